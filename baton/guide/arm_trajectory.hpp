/// Targets for the joints of the arms that come from outside: of a policy, a motion capture rig or a script. They come
/// in chunks, each with the times at which the joints are to be where. A governor turns what is known of them into a
/// path that a motion can contain.
#pragma once

#include <memory>
#include <span>
#include <string>
#include <vector>

#include "baton/model/robot_model.hpp"
#include "baton/motion/arm_path.hpp"
#include "baton/motion/posture.hpp"

namespace baton {

/// Targets for some joints of the arms.
struct ArmTargets {
  std::vector<std::string> joints;
  std::vector<double> t;  ///< times from the start of the run, increasing [s]; none: the joints are let go of
  MatX q;                 ///< times × joints [rad]
};

/// Lets go of all joints of both arms.
[[nodiscard]] ArmTargets released_arms(const RobotModel& robot);

class ArmTrajectory {
 public:
  /// Most targets that may be known of the joints that are driven, all together.
  static constexpr std::size_t kMostNumbers = 20'000;

  /// No joint has a target. The robot must outlive the object.
  explicit ArmTrajectory(const RobotModel& robot);

  /// This trajectory up to the first time of the targets, and the targets from there on. From target to target, also
  /// from the last one that is kept to the first new one, joints move evenly; after the last one they stay. Targets out
  /// of a joint's range are moved to its margin.
  /// @param now from when on it counts; all before is dropped [s]
  /// @param q where the joints are planned to be now (n) [rad]
  /// @throws InputError a joint is none of an arm, or named twice; times do not increase; they are too many; a number
  /// is not finite; the matrix has another shape
  [[nodiscard]] ArmTrajectory continued(const ArmTargets& targets, double now, const VecX& q) const;

  /// Number of chunks so far.
  [[nodiscard]] long version() const { return version_; }
  /// Whether a joint has a target.
  [[nodiscard]] bool drives(int joint) const { return !points_[static_cast<std::size_t>(joint)].empty(); }
  [[nodiscard]] bool empty() const;
  /// Where a joint is to be, between its targets by linear interpolation [rad]. Requires `drives`.
  [[nodiscard]] double at(int joint, double t) const;

  /// The path for a motion that begins at `start`: from where the joints are planned to be then, and how they move,
  /// towards their targets, within half of the speed limits and a share of that of acceleration. Null if no joint has a
  /// target.
  /// @param from the planned posture at `start`
  [[nodiscard]] std::shared_ptr<const ArmPath> governed(const Posture& from, double start) const;

 private:
  struct Point {
    double t = 0.0;
    double q = 0.0;
  };

  const RobotModel* robot_;
  std::vector<std::vector<Point>> points_;  ///< by joint, in time
  long version_ = 0;
};

}  // namespace baton
