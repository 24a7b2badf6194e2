#pragma once

#include <gtest/gtest.h>

#include <functional>

#include "baton/robot/robot.hpp"

namespace baton::test {

/// A robot whose readings are spoiled.
class GlitchyRobot : public Robot {
 public:
  explicit GlitchyRobot(Robot& robot) : robot_(&robot) {}
  [[nodiscard]] Measurement read() override {
    Measurement m = robot_->read();
    if (spoil) spoil(m);
    return m;
  }
  void write(const JointTarget& target) override {
    ASSERT_TRUE(target.q.allFinite() && target.dq.allFinite() && target.tau.allFinite());
    robot_->write(target);
  }
  void reset() override { robot_->reset(); }
  [[nodiscard]] const Truth* truth() const override { return hidden ? nullptr : robot_->truth(); }

  std::function<void(Measurement&)> spoil;
  bool hidden = false;  ///< whether it has no truth to tell

 private:
  Robot* robot_;
};

}  // namespace baton::test
