/// State estimation of the root: attitude from the IMU, position from the soles in contact (docs/balance.md).
#pragma once

#include "baton/balance/attitude_filter.hpp"
#include "baton/balance/force_zeros.hpp"
#include "baton/balance/joint_play.hpp"
#include "baton/balance/joint_speeds.hpp"
#include "baton/balance/leg_odometry.hpp"
#include "baton/balance/map_matching.hpp"
#include "baton/balance/root_imu.hpp"
#include "baton/balance/sole_wrenches.hpp"
#include "baton/balance/state_source.hpp"
#include "baton/balance/yaw_drift.hpp"
#include "baton/motion/motion.hpp"

namespace baton {

class Odometry {
 public:
  /// Robot and world must outlive the object.
  /// @param world known terrain, for map matching
  /// @param start initial posture, at rest on both feet, in the world
  /// @throws InputError `source` needs an IMU on the root, and the profile names none there
  Odometry(const RobotModel& robot, const World& world, StateSource source, const Posture& start);

  /// The measurement completed by root pose, root velocity and sole wrenches, with filtered joint speeds.
  /// @param planned planned sample of this tick
  [[nodiscard]] const Measurement& update(const Measurement& measurement, const MotionSample& planned);

  /// Vertical force on each sole [N].
  [[nodiscard]] const BySide<double>& load() const { return contact_.load(); }
  /// Error bound of the position, proportional to the distance walked [m].
  [[nodiscard]] double uncertainty() const;
  /// Play of the joints, to each side, that was taken out of the measured angles [rad].
  [[nodiscard]] double play() const { return completed_.torque.size() == completed_.q.size() ? play_.estimate() : 0.0; }
  /// The joints and the root's attitude as they were estimated, the root at the origin; null with `perfect`.
  [[nodiscard]] const Kinematics* kinematics() const {
    return source_ == StateSource::perfect ? nullptr : &kinematics_;
  }
  /// Whether a sole is in contact.
  [[nodiscard]] const BySide<bool>& touch() const { return contact_.touch(); }

 private:
  /// Vertical force on each sole, for `StateSource::perfect` [N].
  [[nodiscard]] BySide<double> measured_or_planned_load(const Measurement& measurement,
                                                        const MotionSample& planned) const;
  /// Vertical force on each sole, by wrenches in the sole frames [N].
  [[nodiscard]] BySide<double> load_of(const BySide<Wrench>& sole) const;

  const RobotModel* robot_;
  StateSource source_;
  Kinematics kinematics_;
  Measurement completed_;
  VecX q_;   ///< configuration with the root at the origin
  VecX dq_;  ///< velocity, without linear velocity of the root
  AttitudeFilter attitude_;
  YawDrift yaw_drift_;
  ForceZeros zeros_;
  RootImu imu_;
  JointPlay play_;
  JointSpeeds speeds_;
  SoleWrenches wrenches_;
  SoleContact contact_;
  LegOdometry legs_;
  MapMatching map_;
};

}  // namespace baton
