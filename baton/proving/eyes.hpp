/// The robot as seen by a person in the room: from outside, with an error.
#pragma once

#include <optional>
#include <random>

#include "baton/run/operator.hpp"

namespace baton {

/// What is seen of the robot, in the world frame.
struct Sight {
  BySide<Pose> sole;
  Vec3 com;
  Vec3 hand;               ///< left
  Vec3 shoulder;           ///< left
  double heading = 0.0;    ///< mean yaw of both feet [rad]
  double trunk_yaw = 0.0;  ///< [rad]
  [[nodiscard]] Vec2 feet() const { return 0.5 * (sole.left.p + sole.right.p).head<2>(); }
};

class Eyes {
 public:
  struct Parameters {
    double error = 0.001;      ///< standard deviation of seen positions [m]
    double yaw_error = 0.005;  ///< of seen headings [rad]
    double foresight = 0.2;    ///< motion is assumed to continue for this long after release [s]
  };

  /// @param robot must outlive this object
  Eyes(const RobotModel& robot, std::uint64_t seed, const Parameters& parameters);

  /// @throws std::logic_error the robot has no truth
  [[nodiscard]] Sight look(const Operator::View& view);

  /// The sight extrapolated to where the robot would come to rest if released now; not extrapolated if the last call
  /// was more than `within` [s] ago.
  [[nodiscard]] Sight foresee(const Operator::View& view, double within);

 private:
  Parameters parameters_;
  std::mt19937_64 random_;
  Kinematics kinematics_;
  std::optional<Sight> last_;
  double looked_ = 0.0;  ///< time of `last_` [s]
};

}  // namespace baton
