/// Tracking error relative to the stance soles, and localisation error.
#pragma once

#include <nlohmann/json.hpp>
#include <optional>

#include "baton/run/sink.hpp"

namespace baton {

class TrackingError {
 public:
  /// `robot` must outlive this object.
  explicit TrackingError(const RobotModel& robot) : robot_(&robot), planned_(robot) {}

  /// One tick. Requires a robot with truth that has not fallen.
  /// @param truth the robot's true kinematics at this tick
  void add(const TickRecord& record, const Kinematics& truth);

  [[nodiscard]] nlohmann::json json() const;

 private:
  /// Sums of squared errors over the ticks [m²]; for soles and hands the mean of both sides.
  struct Squares {
    double com = 0.0;
    double com_estimated = 0.0;
    double sole = 0.0;
    double hand = 0.0;
    double zmp = 0.0;
    long ticks = 0;
  };

  const RobotModel* robot_;
  Kinematics planned_;
  Squares squares_;
  bool forces_ = false;           ///< whether the truth has had any
  double estimate_ = 0.0;         ///< largest error of the trunk's estimated position [m]
  double share_ = 0.0;            ///< largest ratio of that error to the distance travelled, beyond an initial distance
  double way_ = 0.0;              ///< distance travelled by the trunk [m]
  std::optional<Vec3> way_from_;  ///< end of the last counted piece of path [m]
};

}  // namespace baton
