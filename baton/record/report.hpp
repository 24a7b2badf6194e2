/// A run in numbers (docs/report.md says what each means).
#pragma once

#include <map>
#include <nlohmann/json.hpp>
#include <optional>
#include <vector>

#include "baton/run/sink.hpp"

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

class Report : public Sink {
 public:
  explicit Report(const RobotModel& robot);

  void on_tick(const TickRecord& record) override;
  void on_plan(const PlanRecord& record) override;

  /// @param wall duration of the run by the clock on the wall [s]
  [[nodiscard]] nlohmann::json json(const std::string& world, const std::string& on, long seed, double wall);

 private:
  /// A maximal interval of constant input that asks for something.
  struct Interval {
    Command command;
    Vec3 asked = Vec3::Zero();           ///< displacement of the guided part in a segment, planning frame [m]
    Vec3 asked_rotation = Vec3::Zero();  ///< [rad]
    double made = 0.0;                   ///< along `asked`, by motions that are over [m]
    double made_rotation = 0.0;          ///< along `asked_rotation` [rad]
    double most = 0.0;                   ///< the largest so far [m]
    double most_rotation = 0.0;          ///< [rad]
    [[nodiscard]] bool moved() const;
  };

  /// What a motion does for the command that it was planned for, until it was to end, whatever replaces it.
  struct Credit {
    std::size_t command = 0;
    Pose start;          ///< of the guided part
    double until = 0.0;  ///< [s]
  };

  /// What a command asks for, if anything that its part can do.
  [[nodiscard]] std::optional<Interval> asked(const Command& command, bool lifts, const Mat3& heading) const;
  [[nodiscard]] Pose guided_pose(Part part);
  /// Where a command stands now; `over`: it makes no more by this motion.
  void account(const Credit& credit, bool over);

  const RobotModel* robot_;
  Kinematics kinematics_;
  double duration_ = 0.0;
  bool has_truth_ = true;  ///< the robot does; without, what only a simulator knows is null
  bool fallen_ = false;
  std::vector<Interval> commands_;
  Command last_command_;
  long command_ = -1;     ///< that stands now, if it asks for something
  long planned_by_ = -1;  ///< command that the last answer was for
  std::vector<Credit> open_;
  long segment_ = -1;
  Vec3 com_start_ = Vec3::Zero();
  long committed_ = 0;
  long caught_ = 0;
  long slips_ = 0;
  std::map<std::string, long> shrunk_;  ///< reason → motions that are a part of the way
  std::map<std::string, long> refused_;
  std::string last_refused_;
  double travel_ = 0.0;
  Durations plan_;
  Durations tick_;
  double planned_margin_ = std::numeric_limits<double>::infinity();
  double measured_margin_ = std::numeric_limits<double>::infinity();
  double tilt_ = 0.0;
  /// Height of the COM above the soles at the end of the first and of the last rest on both feet [m].
  double first_height_ = 0.0;
  double height_ = 0.0;
  bool rests_ = false;

  /// How well the plan is followed, seen from the soles that stand.
  struct Tracking {
    double com = 0.0;  ///< sums of squares [m²]
    double sole = 0.0;
    double hand = 0.0;
    double zmp = 0.0;
    long ticks = 0;
    double estimate = 0.0;  ///< the largest error of where the trunk is believed to be [m]

    double share = 0.0;  ///< the largest of estimate over way, once it has come some way
  };
  void track(const TickRecord& record);
  void note_height(const Navigator& navigator);

  Kinematics planned_;
  Tracking tracking_;
  bool tracks_ = false;
  double way_ = 0.0;
  Vec3 way_from_ = Vec3::Zero();
};

}  // namespace baton
