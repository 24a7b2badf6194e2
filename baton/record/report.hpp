/// A run in numbers (docs/report.md says what each means).
#pragma once

#include <map>
#include <nlohmann/json.hpp>
#include <vector>

#include "baton/record/tick_record.hpp"

namespace baton {

/// Durations, to be summed up by their quantiles.
class Durations {
 public:
  void add(double us) { us_.push_back(us); }
  /// {"p50", "p99", "max", "n"}, in µs.
  [[nodiscard]] nlohmann::json summary() const;

 private:
  std::vector<double> us_;
};

class Report {
 public:
  explicit Report(const RobotModel& robot);

  void add(const TickRecord& record);
  void add(const PlanRecord& record);

  /// @param wall duration of the run by the clock on the wall [s]
  [[nodiscard]] nlohmann::json json(const std::string& world, const std::string& on, long seed, double wall);

 private:
  /// A maximal interval of constant input that asks for something.
  struct Interval {
    Command command;
    Vec3 asked = Vec3::Zero();           ///< displacement of the guided part in a segment, planning frame [m]
    Vec3 asked_rotation = Vec3::Zero();  ///< [rad]
    double made = 0.0;                   ///< along `asked` [m]
    double made_rotation = 0.0;          ///< along `asked_rotation` [rad]
    [[nodiscard]] bool moved() const;
  };

  [[nodiscard]] Pose guided_pose(Part part);
  void close_segment();

  const RobotModel* robot_;
  Kinematics kinematics_;
  double duration_ = 0.0;
  bool fallen_ = false;
  std::vector<Interval> commands_;
  Command last_command_;
  long planned_by_ = -1;  ///< command that the request under way answers
  long owner_ = -1;       ///< command of the segment under way
  long segment_ = -1;
  Part segment_part_ = Part::trunk;
  Pose segment_start_;
  Vec3 com_start_ = Vec3::Zero();
  long committed_ = 0;
  std::map<std::string, long> shrunk_;  ///< reason → motions that are a part of the way
  std::map<std::string, long> refused_;
  std::string last_refused_;
  double travel_ = 0.0;
  Durations plan_;
  Durations tick_;
  double planned_margin_ = std::numeric_limits<double>::infinity();
  double measured_margin_ = std::numeric_limits<double>::infinity();
  double tilt_ = 0.0;
};

}  // namespace baton
