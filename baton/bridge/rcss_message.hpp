/// The messages of rcssservermj, the RoboCup 3D simulator on MuJoCo (PyPI package rcsssmj, version 0.2.1): a length of
/// 4 bytes, most significant first, then symbolic expressions. Angles are in degrees.
#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "baton/bridge/sexpr.hpp"
#include "baton/math/pose.hpp"

namespace baton::bridge {

inline constexpr double kRcssCycle = 0.02;                    ///< [s]
inline constexpr std::size_t kLongestPerception = 1U << 20U;  ///< of a message [bytes]

/// A joint, as the simulator calls it.
struct RcssJoint {
  std::string perceptor;  ///< of its angle and speed: "q_llj1"
  std::string effector;   ///< of its servo: "lle1"
};

/// What a robot perceives after a cycle, in SI units and radians.
struct Perception {
  long cycle = 0;  ///< number of the cycles that the simulation has made
  std::string play_mode;
  VecX q;             ///< joint angles, in the order asked for [rad]
  VecX dq;            ///< [rad/s]
  Vec3 rate;          ///< angular velocity of the torso, in its axes [rad/s]
  Vec3 acceleration;  ///< specific force there [m/s²]
  Pose torso;         ///< in the field: truth, for judges alone
};

/// The simulator cuts numbers off after some digits, towards zero. Half of the last digit away from zero is nearer to
/// what was there: at most half of it off, for numbers that are not cut to zero.
[[nodiscard]] double uncut(double value, double digit);

/// @param joints their perceptors; the simulator may have no others
/// @throws SExprError malformed, something is missing, or the joints are others
[[nodiscard]] Perception perception_in(std::string_view text, const std::vector<RcssJoint>& joints);

/// What a servo is told for a cycle. Its torque is kp (q − measured) + kd (dq − measured) + tau, up to the stall
/// torque.
struct RcssServo {
  double q = 0.0;    ///< [rad]
  double dq = 0.0;   ///< [rad/s]
  double kp = 0.0;   ///< [N·m/rad]
  double kd = 0.0;   ///< [N·m·s/rad]
  double tau = 0.0;  ///< [N·m]
};

/// The text that joins the simulation.
/// @param robot the simulator's name of its model
[[nodiscard]] std::string init_text(std::string_view robot, std::string_view team, int player);
/// The text that puts the robot there, upright with all joints at zero.
/// @param place x, y in the field [m], yaw [rad]
[[nodiscard]] std::string beam_text(const Vec3& place);
[[nodiscard]] std::string servo_text(const RcssJoint& joint, const RcssServo& servo);

/// The bytes of a message.
[[nodiscard]] std::string rcss_framed(std::string_view text);
/// Takes the first whole message out of the bytes, if there is one.
/// @throws SExprError it is empty, or longer than `kLongestPerception`
[[nodiscard]] std::optional<std::string> take_rcss_message(std::string& bytes);

}  // namespace baton::bridge
