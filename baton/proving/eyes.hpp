/// The robot as a person in the room sees it: from outside, with an error.
#pragma once

#include <optional>
#include <random>

#include "baton/run/operator.hpp"

namespace baton {

/// What can be seen of the robot, in the world.
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
    double foresight = 0.2;    ///< what moves is taken to go on for that long after the stick is let go of [s]
  };

  /// @param robot must outlive the object
  Eyes(const RobotModel& robot, std::uint64_t seed, const Parameters& parameters);

  /// @throws std::logic_error the robot has no truth to be seen
  [[nodiscard]] Sight look(const Operator::View& view);

  /// What is seen, extrapolated to where the robot will come to rest if let go of now; as it is, if the last such look
  /// was longer ago than `within` [s].
  [[nodiscard]] Sight foresee(const Operator::View& view, double within);

 private:
  Parameters parameters_;
  std::mt19937_64 random_;
  Kinematics kinematics_;
  std::optional<Sight> last_;
  double looked_ = 0.0;  ///< then [s]
};

}  // namespace baton
