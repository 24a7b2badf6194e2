/// The operator's command: the latest position of the stick.
#pragma once

#include <array>
#include <cstdint>
#include <string_view>

#include "baton/model/robot_model.hpp"
#include "baton/motion/posture.hpp"

namespace baton {

/// What a held button asks for, instead of the stick.
enum class Recall : std::uint8_t {
  none,
  retrace,  ///< go back the way it came
  home,     ///< step to the initial stance
  stop,     ///< come to rest by the quickest verified motion
};

/// Their names, in this order.
inline constexpr std::array<std::string_view, 4> kRecalls{"none", "retrace", "home", "stop"};

/// The recall of the buttons held: stop before retrace before home.
[[nodiscard]] constexpr Recall recall_of(bool stop, bool retrace, bool home) {
  return stop ? Recall::stop : retrace ? Recall::retrace : home ? Recall::home : Recall::none;
}

/// `axes` are in −1…1, in the heading frame: x forward, y left, z up, roll, pitch, yaw (right-handed). `lift` is the
/// throttle of each foot, in 0…1. Devices have applied dead zone and response curve already.
struct Command {
  Part guide = Part::trunk;
  Vec6 axes = Vec6::Zero();
  BySide<double> lift{0.0, 0.0};
  Recall recall = Recall::none;

  /// Whether nothing is requested: no recall, centred axes, and zero lift of a guided foot.
  [[nodiscard]] bool neutral() const {
    return recall == Recall::none && axes.isZero(0.0) && (!is_foot(guide) || lift[side_of(guide)] == 0.0);
  }
  [[nodiscard]] bool operator==(const Command& other) const {
    return guide == other.guide && axes == other.axes && lift.left == other.lift.left &&
           lift.right == other.lift.right && recall == other.recall;
  }
};

/// Lifts below this count as zero.
inline constexpr double kLeastLift = 0.05;

/// Displacement of a part at full stick, along each axis: position [m], rotation vector [rad].
[[nodiscard]] Vec6 reach_of(const RobotModel& robot, Part part);

/// Displacement of the guided part that the axes request, in the heading frame: position [m], rotation vector [rad].
/// Zero along axes that the part cannot use: a foot's z, roll and pitch, and the rotation of a hand whose arm has fewer
/// than six joints.
[[nodiscard]] Vec6 requested_move(const RobotModel& robot, const Command& command);

/// Whether `a` guides a foot, and `b` another part or that foot with a different lift, beyond device jitter.
[[nodiscard]] bool lever_moved(const Command& a, const Command& b);

/// Whether two commands differ in guided part, axes or the lift of `a`'s foot, beyond device jitter. Ignores recalls.
[[nodiscard]] bool differs(const Command& a, const Command& b);

/// The command with axes clamped to −1…1 and lifts to 0…1. NaN, as from a broken device, becomes 0.
[[nodiscard]] Command sanitised(const Command& command);

}  // namespace baton
