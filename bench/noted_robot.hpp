/// An ideal robot that notes when its ticks begin, and what they cost.
#pragma once

#include <chrono>
#include <memory>
#include <optional>
#include <utility>
#include <vector>

#include "baton/robot/ideal_robot.hpp"
#include "baton/run/cpu_time.hpp"
#include "baton/run/planning.hpp"

namespace baton::bench {

class NotedRobot : public Robot {
 public:
  using Clock = std::chrono::steady_clock;

  NotedRobot(const RobotModel& model, const Posture& start) : ideal_(model, start, model.profile().tick.period) {}

  [[nodiscard]] Measurement read() override {
    began_ = Clock::now();
    const double before = cpu_us();
    if (ended_us_) between_us_ += before - *ended_us_;
    Measurement measurement = ideal_.read();
    own_us_ += cpu_us() - before;
    return measurement;
  }
  void write(const JointTarget& target) override {
    const double before = cpu_us();
    ideal_.write(target);
    own_us_ += cpu_us() - before;
    ticks_.push_back(began_);
  }
  void reset() override {
    ideal_.reset();
    ticks_.clear();
    ended_us_.reset();
    between_us_ = own_us_ = 0.0;
  }
  [[nodiscard]] const Truth* truth() const override { return ideal_.truth(); }

  /// The session's tick may be over: the last such note before the next tick counts.
  void note_end() { ended_us_ = cpu_us(); }

  /// When each tick since the last reset has begun.
  [[nodiscard]] const std::vector<Clock::time_point>& ticks() const { return ticks_; }
  /// CPU time of the thread that moves it, a tick: what the robot itself takes, and what is between two ticks of its
  /// session [µs].
  [[nodiscard]] double own_us() const { return own_us_ / static_cast<double>(ticks_.size()); }
  [[nodiscard]] double between_us() const { return between_us_ / static_cast<double>(ticks_.size()); }

 private:
  IdealRobot ideal_;
  std::vector<Clock::time_point> ticks_;
  Clock::time_point began_;
  std::optional<double> ended_us_;
  double between_us_ = 0.0, own_us_ = 0.0;
};

/// Planning of a session that moves such a robot: what each of its ticks ends with.
class NotedPlanning : public Planning {
 public:
  NotedPlanning(std::unique_ptr<Planning> planning, NotedRobot& robot)
      : planning_(std::move(planning)), robot_(&robot) {}

  [[nodiscard]] bool idle() const override {
    const bool idle = planning_->idle();
    robot_->note_end();
    return idle;
  }
  void post(Request request) override { planning_->post(std::move(request)); }
  [[nodiscard]] std::optional<Reply> poll(long tick) override {
    std::optional<Reply> reply = planning_->poll(tick);
    robot_->note_end();
    return reply;
  }
  void reset() override { planning_->reset(); }

 private:
  std::unique_ptr<Planning> planning_;
  NotedRobot* robot_;
};

}  // namespace baton::bench
