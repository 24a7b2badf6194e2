/// Sensors → pose and velocity of the root: attitude from the IMU, place from the soles that stand (docs/balance.md).
#pragma once

#include "baton/balance/measurement.hpp"
#include "baton/model/world.hpp"
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
  [[nodiscard]] const BySide<double>& load() const { return load_; }
  /// How far off the place may be, by the way that the feet have gone, from footfall to footfall [m].
  [[nodiscard]] double uncertainty() const;
  /// Whether a sole carries some of the weight.
  [[nodiscard]] const BySide<bool>& touch() const { return touch_; }

 private:
  void measure_soles(const Measurement& measurement, const MotionSample& planned, const Vec3& ddroot,
                     const Vec3& drate);
  void smooth_speeds(const Measurement& measurement, const MotionSample& planned);
  void note_touch();
  void follow_map(const MotionSample& planned);
  /// Of a sole that stands tilted on an edge of the ground: the way to where that is by the map [m], zero if it is
  /// there. Nothing of a sole that stands otherwise.
  [[nodiscard]] std::optional<Vec2> felt_edge(Side side, const GroundPoint& below) const;

  const RobotModel* robot_;
  const World* world_;
  StateSource source_;
  double period_;
  Kinematics kinematics_;
  JacobianRows jacobian_;
  BySide<std::vector<Vec2>> corners_;  ///< of the soles, a little inside [m]
  Measurement completed_;
  VecX q_;            ///< configuration with the root at the origin
  VecX dq_;           ///< its velocity, the root turning only
  VecX ddq_, force_;  ///< for the soles' wrenches by inverse dynamics
  VecX speed_error_;  ///< of the joints: measured − planned, smoothed [rad/s]
  bool first_ = true;
  Mat3 yaw_ = Mat3::Identity();  ///< of the world in the IMU's world
  Vec3 place_;                   ///< of the root [m]
  Vec3 velocity_ = Vec3::Zero();
  Vec3 rate_before_ = Vec3::Zero();
  BySide<Vec3> foothold_;  ///< where the soles stand [m]
  BySide<Vec3> footfall_;  ///< where they stood last [m]
  double gone_ = 0.0;      ///< way of both feet, from footfall to footfall [m]
  BySide<bool> touch_{true, true};
  double untouched_ = 0.0;  ///< for which no sole has touched [s]
  bool lost_ = false;       ///< the height is not known, since the robot was in the air
  BySide<double> load_;
};

}  // namespace baton
