/// Sensors → pose and velocity of the root: attitude from the IMU, place from the soles that stand (docs/balance.md).
#pragma once

#include "baton/balance/joint_speeds.hpp"
#include "baton/balance/leg_odometry.hpp"
#include "baton/balance/map_matching.hpp"
#include "baton/balance/root_imu.hpp"
#include "baton/balance/sole_wrenches.hpp"
#include "baton/motion/motion.hpp"

namespace baton {

/// Where the state of the robot comes from.
enum class StateSource {
  sensors,  ///< encoders, IMU, forces under the soles
  torques,  ///< encoders, IMU, torques of the motors
  perfect,  ///< the pose of the root is measured, as only a simulation can
};

[[nodiscard]] constexpr std::string_view to_string(StateSource source) {
  constexpr std::array<std::string_view, 3> names{"sensors", "torques", "perfect"};
  return names[static_cast<std::size_t>(source)];
}

class Odometry {
 public:
  /// Robot and world must outlive the object.
  /// @param world its ground is known: heights are those of the ground where soles stand
  /// @param start posture that the robot stands in, at rest, in the world
  /// @throws InputError source needs an IMU on the root body, and the profile names none there
  Odometry(const RobotModel& robot, const World& world, StateSource source, const Posture& start);

  /// The measurement with the root's pose and velocity, the joints' speeds smoothed, and the soles' wrenches.
  /// @param planned sample of this tick
  [[nodiscard]] const Measurement& update(const Measurement& measurement, const MotionSample& planned);

  /// Vertical force on each sole [N].
  [[nodiscard]] const BySide<double>& load() const { return contact_.load(); }
  /// How far off the place may be, by the way that the feet have gone, from footfall to footfall [m].
  [[nodiscard]] double uncertainty() const;
  /// Whether a sole carries some of the weight.
  [[nodiscard]] const BySide<bool>& touch() const { return contact_.touch(); }

 private:
  /// Vertical force on each sole of a robot whose root is measured [N].
  [[nodiscard]] BySide<double> told_load(const Measurement& measurement, const MotionSample& planned) const;
  /// The same by the wrenches of soles in their frames.
  [[nodiscard]] BySide<double> load_of(const BySide<Wrench>& sole) const;

  const RobotModel* robot_;
  StateSource source_;
  Kinematics kinematics_;
  Measurement completed_;
  VecX q_;   ///< configuration with the root at the origin
  VecX dq_;  ///< its velocity, the root turning only
  RootImu imu_;
  JointSpeeds speeds_;
  SoleWrenches wrenches_;
  SoleContact contact_;
  LegOdometry legs_;
  MapMatching map_;
};

}  // namespace baton
