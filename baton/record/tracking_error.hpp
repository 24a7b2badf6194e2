/// How well a run follows its plan, seen from the soles that stand, and how well it knows where it is.
#pragma once

#include <nlohmann/json.hpp>
#include <optional>

#include "baton/run/sink.hpp"

namespace baton {

class TrackingError {
 public:
  /// The robot must outlive the object.
  explicit TrackingError(const RobotModel& robot) : robot_(&robot), planned_(robot) {}

  /// One tick of a robot that has truth and has not fallen.
  /// @param truth the robot's configuration at this tick
  void add(const TickRecord& record, const Kinematics& truth);

  [[nodiscard]] nlohmann::json json() const;

 private:
  /// Sums of squares over the ticks [m²]; of soles and hands the mean of both sides.
  struct Squares {
    double com = 0.0;
    double sole = 0.0;
    double hand = 0.0;
    double zmp = 0.0;
    long ticks = 0;
  };

  const RobotModel* robot_;
  Kinematics planned_;
  Squares squares_;
  double estimate_ = 0.0;         ///< the largest error of where the trunk is believed to be [m]
  double share_ = 0.0;            ///< the largest of that error over the way, once it has come some way
  double way_ = 0.0;              ///< of the trunk [m]
  std::optional<Vec3> way_from_;  ///< where the way was counted last [m]
};

}  // namespace baton
