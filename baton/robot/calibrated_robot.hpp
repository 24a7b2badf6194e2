/// A robot whose sensors' constant errors are known: whoever drives it sees it without them.
#pragma once

#include <memory>
#include <utility>

#include "baton/robot/calibration.hpp"
#include "baton/robot/robot.hpp"

namespace baton {

/// What is read lacks the errors; joint targets are written as the robot's own encoders have to read.
class CalibratedRobot : public Robot {
 public:
  /// @param calibration with a zero for each joint of the robot
  CalibratedRobot(std::unique_ptr<Robot> robot, Calibration calibration)
      : robot_(std::move(robot)), calibration_(std::move(calibration)) {}

  [[nodiscard]] Measurement read() override { return without_errors(robot_->read(), calibration_); }
  void write(const JointTarget& target) override {
    target_ = target;
    target_.q += calibration_.encoder_zero;
    robot_->write(target_);
  }
  void reset() override { robot_->reset(); }
  [[nodiscard]] const Truth* truth() const override { return robot_->truth(); }

 private:
  std::unique_ptr<Robot> robot_;
  Calibration calibration_;
  JointTarget target_;
};

}  // namespace baton
