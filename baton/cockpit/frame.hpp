/// One frame of a run, as shown on the page.
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
#include "baton/navigate/navigator.hpp"

namespace baton {

/// What the robot is doing.
enum class Activity : std::uint8_t {
  rest,
  moving,
  stopping,   ///< to rest as quickly as possible
  retracing,  ///< retracing, or going home
  fallen,
};

[[nodiscard]] constexpr std::string_view to_string(Activity activity) {
  constexpr std::array<std::string_view, 5> names{"rest", "moving", "stopping", "retracing", "fallen"};
  return names[static_cast<std::size_t>(activity)];
}

/// @param fallen as its truth says
[[nodiscard]] Activity activity(const Navigator& navigator, bool fallen);

/// A part that was refused repeatedly at the same rest, and the ways out.
struct Stuck {
  Part part = Part::trunk;
  int times = 0;         ///< in a row
  bool retrace = false;  ///< there is a motion to retrace, and it was not refused
  bool home = false;     ///< going home was not refused
};

/// Positions are in the scene's frame unless stated otherwise.
struct Frame {
  double t = 0.0;  ///< since the start of the run [s]
  Activity activity = Activity::rest;
  std::vector<Pose> bodies;  ///< all bodies of the scene in order, world included

  Command command;      ///< the active command
  DeviceStatus device;  ///< source of that command

  /// The committed motion; empty at rest.
  struct Segment {
    std::optional<Goal> goal;
    double time = 0.0;             ///< since its start [s]
    double duration = 0.0;         ///< total [s]
    std::optional<Refusal> limit;  ///< why the motion does only part of the request, if so
  } segment;
  std::size_t history = 0;  ///< number of motions that can be retraced

  /// Contact and balance.
  struct Balance {
    BySide<bool> contact{true, true};  ///< stance soles
    ConvexPolygon support;             ///< support polygon
    double support_height = 0.0;       ///< height of the support plane [m]
    Vec3 com = Vec3::Zero();           ///< [m]
    Vec2 zmp = Vec2::Zero();           ///< on the support plane [m]
    Vec2 dcm = Vec2::Zero();           ///< horizontal [m]
  } balance;

  std::optional<Refusal> refusal;  ///< the newest
  int refusals = 0;                ///< number of refusals since the start; tells new from old
  std::optional<Stuck> stuck;
  bool damps = false;   ///< whether the robot can be damped: its motors only brake then
  std::string message;  ///< one sentence for the operator; may be empty
};

/// Poses of all bodies, for `Frame::bodies`.
[[nodiscard]] std::vector<Pose> body_poses(const mjModel& scene, const mjData& data);

}  // namespace baton
