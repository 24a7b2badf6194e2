/// What the log of a run says of the robot's condition: sensors that are not believed, falls, that it was lifted.
#pragma once

#include <string>
#include <utility>
#include <vector>

#include "baton/run/sink.hpp"

namespace baton {

/// A rejected reading beside what is believed in its place: of joints and soles, the one that is farthest off.
[[nodiscard]] std::string rejected_reading(const RobotModel& robot, Sensor sensor, const Measurement& read,
                                           const Measurement& believed);

class ConditionLog : public Sink {
 public:
  struct Line {
    double t = 0.0;  ///< [s]
    bool warning = false;
    const char* what = "";  ///< sensor or guard
    std::string text;
  };

  /// For one run. The robot must outlive the object.
  explicit ConditionLog(const RobotModel& robot) : robot_(&robot) { told_.values.fill(-kAgain); }

  void on_tick(const TickRecord& record) override;
  /// What has been noticed since the last call.
  [[nodiscard]] std::vector<Line> take() { return std::exchange(lines_, {}); }

 private:
  static constexpr double kAgain = 5.0;  ///< least time between two warnings of one sensor [s]

  void look_at(Sensor sensor, const TickRecord& record);
  void say(const TickRecord& record, bool warning, const char* what, std::string text) {
    lines_.push_back({record.t, warning, what, std::move(text)});
  }

  const RobotModel* robot_;
  BySensor<double> told_;     ///< time of the last warning of it [s]
  BySensor<bool> told_lost_;  ///< that it is lost was the last line about it
  bool told_frozen_ = false;
  std::vector<Line> lines_;
};

}  // namespace baton
