/// What the page shows of one moment of a run.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "baton/guide/command.hpp"
#include "baton/input/device.hpp"
#include "baton/math/polygon.hpp"
#include "baton/model/mujoco.hpp"
#include "baton/motion/goal.hpp"
#include "baton/motion/refusal.hpp"

namespace baton {

/// What the robot does, in a word.
enum class Activity : std::uint8_t {
  rest,
  moving,
  stopping,   ///< to rest, as quickly as can be
  retracing,  ///< on a way back: what was done last, backwards, or home
  fallen,
};

[[nodiscard]] constexpr std::string_view to_string(Activity activity) {
  constexpr std::array<std::string_view, 5> names{"rest", "moving", "stopping", "retracing", "fallen"};
  return names[static_cast<std::size_t>(activity)];
}

/// A part that was refused again and again at one rest, and what leads away from there.
struct Stuck {
  Part part = Part::trunk;
  int times = 0;         ///< in a row
  bool retrace = false;  ///< there is something to retrace, and that was not refused
  bool home = false;     ///< going home was not refused
};

/// Places are in the frame of the scene, unless said otherwise.
struct Frame {
  double t = 0.0;  ///< since the start of the run [s]
  Activity activity = Activity::rest;
  std::vector<Pose> bodies;  ///< of every body of the scene, in its order, the world included

  Command command;      ///< the one that is obeyed
  DeviceStatus device;  ///< of the device that it comes from

  /// The committed motion; empty at rest.
  struct Segment {
    std::optional<Goal> goal;
    double time = 0.0;             ///< since its start [s]
    double duration = 0.0;         ///< of the whole motion [s]
    std::optional<Refusal> limit;  ///< what spoke against the whole way, if it is only a part of that
  } segment;
  std::size_t history = 0;  ///< motions that can be retraced

  /// What the robot stands on, and how.
  struct Balance {
    BySide<bool> contact{true, true};  ///< which soles stand
    ConvexPolygon support;             ///< support polygon
    double support_height = 0.0;       ///< of its plane [m]
    Vec3 com = Vec3::Zero();           ///< [m]
    Vec2 zmp = Vec2::Zero();           ///< on the support polygon's plane [m]
    Vec2 dcm = Vec2::Zero();           ///< seen from above [m]
  } balance;

  std::optional<Refusal> refusal;  ///< the newest
  int refusals = 0;                ///< their number since the start: tells a new one from an old one
  std::optional<Stuck> stuck;
  std::string message;  ///< one sentence for the operator; may be empty
};

/// Poses of all bodies, for `Frame::bodies`.
[[nodiscard]] std::vector<Pose> body_poses(const mjModel& scene, const mjData& data);

}  // namespace baton
