/// Leads a robot through the postures of a calibration by the stick alone, and keeps what it reads at each rest.
#pragma once

#include <vector>

#include "baton/calibrate/rest.hpp"
#include "baton/run/operator.hpp"
#include "baton/run/sink.hpp"

namespace baton {

/// Operator and sink of the same session, which begins with the robot at rest. Postures that are refused are left out.
class Posing : public Operator, public Sink {
 public:
  /// The robot must outlive the object.
  explicit Posing(const RobotModel& robot) : robot_(&robot) {}

  [[nodiscard]] Command decide(const View& view) override;
  void on_tick(const TickRecord& record) override;

  [[nodiscard]] bool done() const { return tried() == moves(); }
  /// Motions tried so far, and all there are.
  [[nodiscard]] int tried() const { return tried_; }
  [[nodiscard]] static int moves();
  [[nodiscard]] const std::vector<Rest>& rests() const { return rests_; }

 private:
  enum class Doing { ask, settle, measure };

  void begin(Doing doing);
  void next();

  const RobotModel* robot_;
  int tried_ = 0;
  Doing doing_ = Doing::ask;
  long ticks_ = 0;      ///< in which it has been doing that
  long committed_ = 0;  ///< motions before this one
  bool moved_ = false;  ///< a foot has left its place since the last rest
  int stance_ = 0;
  RestMean mean_;
  std::vector<Rest> rests_;
};

}  // namespace baton
