#include "app/episode.hpp"

#include <cmath>
#include <set>

#include "baton/record/report.hpp"

namespace baton::app {
namespace {

constexpr double kComesToRest = 20.0;  ///< [s] within which a robot that is let go has to rest
constexpr double kRests = 0.25;        ///< [s] without a motion: nothing is being planned either
constexpr int kRefusedInARow = 200;    ///< refusals without a motion between them that make one wonder

/// In physics soles sink, and the planning frame is laid on them.
Checker::Tolerances tolerances(Session::On on) {
  Checker::Tolerances tolerances;
  if (on == Session::On::sim) tolerances.sink = 5e-4;
  return tolerances;
}

/// One episode while it runs.
class Run {
 public:
  Run(const RobotModel& robot, const World& world, Session::On on, Modes modes, long index)
      : robot_(robot),
        on_(on),
        index_(index),
        session_(robot, world, on, std::nullopt, {}, modes),
        checker_(robot, session_.model_text(), tolerances(on)),
        report_(robot),
        stuck_planning_(robot, world, {modes.duration, OnLimit::discard}) {
    session_.on_tick = [this](const TickRecord& record) { judge(record); };
    session_.on_plan = [this](const PlanRecord& record) {
      report_.add(record);
      count_refusals(record);
    };
  }

  void drive(std::uint64_t seed, long ticks, const std::atomic<bool>& stop) {
    const double period = robot_.profile().tick.period;
    Stick stick(seed, period);
    for (long k = 0; k < ticks && !stop && !session_.fallen(); ++k) {
      const Command command = stick.next();
      tally_.deflected += Stick::deflected(command) ? 1 : 0;
      step(command);
      look_whether_stuck();
    }
    const long latest = ticks_ + std::lround(kComesToRest / period);
    for (long rests = 0; rests < std::lround(kRests / period) && !stop && !session_.fallen();) {
      step(Command{});
      rests = session_.resting() ? rests + 1 : 0;
      if (ticks_ > latest) return fail("unrest", session_.t(), kComesToRest, kComesToRest, "");
    }
    if (session_.fallen()) {
      step(Command{});  // as `drive` does: the last row says so
      fail("fall", session_.t(), 0.0, 0.0, session_.truth().fall);
    } else if (!stop) {
      test_whether_stuck();
    }
  }

  void fail(const std::string& kind, double t, double value, double limit, const std::string& where) {
    const long segment = session_.navigator().committed();
    if (segment != segment_) kinds_.clear();
    if (kinds_.empty()) ++tally_.failures;
    segment_ = segment;
    if (!kinds_.insert(kind).second) return;
    ++tally_.bad[kind];
    if (tally_.listed.size() < Tally::kListed) tally_.listed.push_back({kind, index_, t, value, limit, where});
  }

  [[nodiscard]] double t() const { return session_.t(); }

  [[nodiscard]] EpisodeResult result() {
    const nlohmann::json summary = report_.json("", "", 0, 0.0);
    tally_.episodes = 1;
    tally_.ticks = ticks_;
    tally_.segments = session_.navigator().committed();
    summary["segments"]["refused"].get_to(tally_.refused);
    summary["commands"]["given"].get_to(tally_.given);
    summary["commands"]["moved"].get_to(tally_.moved);
    tally_.travel = summary["travel_m"].get<double>();
    return {tally_, ticks_, last_q_};
  }

 private:
  void step(const Command& command) {
    session_.step(command);
    ++ticks_;
  }

  void judge(const TickRecord& record) {
    report_.add(record);
    const Navigator& navigator = record.navigator;
    last_q_ = record.truth.q;
    if (navigator.phase() == Phase::fallen) return;
    if (navigator.committed() != committed_) {
      committed_ = navigator.committed();
      tally_.shrunk += navigator.motion()->limit ? 1 : 0;
    }
    const bool ideal = on_ == Session::On::ideal;
    tick_ = {record.t,
             ideal ? Pose{} : navigator.anchor(),
             ideal ? record.truth.q : navigator.sample().q,
             navigator.sample().contact,
             navigator.phase() == Phase::hold,
             record.target.q};
    for (const Checker::Violation& v : checker_.add(tick_))
      fail(std::string(Checker::kNames[static_cast<std::size_t>(v.kind)]), v.t, v.value, v.limit, v.where);
    if (!record.truth.q.allFinite() || !record.target.tau.allFinite()) fail("not_finite", record.t, 0.0, 0.0, "");
  }

  void count_refusals(const PlanRecord& record) {
    if (std::holds_alternative<Motion>(record.result.outcome)) refused_in_a_row_ = 0;
    if (std::holds_alternative<Refusal>(record.result.outcome)) ++refused_in_a_row_;
  }

  void look_whether_stuck() {
    if (refused_in_a_row_ != kRefusedInARow || !session_.resting()) return;
    ++refused_in_a_row_;  // asked once
    test_whether_stuck();
  }

  void test_whether_stuck() {
    if (stuck(stuck_planning_, session_.navigator().problem({}))) fail("stuck", session_.t(), 0.0, 0.0, "");
  }

  const RobotModel& robot_;
  Session::On on_;
  long index_;
  Session session_;
  Checker checker_;
  Report report_;
  Planning stuck_planning_;
  Checker::Tick tick_;
  Tally tally_;
  long ticks_ = 0;
  long committed_ = 0;
  VecX last_q_;
  int refused_in_a_row_ = 0;
  long segment_ = -1;            ///< the one that failed last
  std::set<std::string> kinds_;  ///< what it failed by
};

}  // namespace

Episodes::Episodes(const RobotModel& robot, const World& world, Session::On on, Modes modes, std::uint64_t seed,
                   double seconds)
    : robot_(&robot),
      world_(&world),
      on_(on),
      modes_(modes),
      seed_(seed),
      ticks_(std::max(1L, std::lround(seconds / robot.profile().tick.period))) {}

EpisodeResult Episodes::run(long index, const std::atomic<bool>& stop) const {
  std::unique_lock<std::mutex> lock(compiling_);
  Run run(*robot_, *world_, on_, modes_, index);
  lock.unlock();
  try {
    run.drive(mixed_seed(seed_, static_cast<std::uint64_t>(index)), ticks_, stop);
  } catch (const std::exception& error) {
    run.fail("exception", run.t(), 0.0, 0.0, error.what());
  }
  return run.result();
}

std::string Episodes::script(long index) const {
  return stick_script(mixed_seed(seed_, static_cast<std::uint64_t>(index)), robot_->profile().tick.period, ticks_);
}

bool stuck(Planning& planning, Problem problem) {
  const auto goes = [&](const Command& command) {
    problem.command = command;
    return std::holds_alternative<Motion>(planning.plan(problem).outcome);
  };
  Command command;
  for (const double size : {0.5, 1.0, 0.1}) {
    for (const Part part : {Part::trunk, Part::left_foot, Part::right_foot, Part::left_hand, Part::right_hand}) {
      command.guide = part;
      for (const double lift : {0.0, 0.5, 1.0}) {
        if (lift > 0.0 && !is_foot(part)) continue;
        command.lift = {lift, lift};
        for (int direction = 0; direction < 27; ++direction) {
          if (direction == 13) continue;  // none
          const Eigen::Vector3i way(direction / 9 - 1, direction / 3 % 3 - 1, direction % 3 - 1);
          command.axes.head<3>() = size * way.cast<double>();
          if (goes(command)) return false;
        }
      }
    }
  }
  command = {};
  command.recall = Recall::retrace;
  return !goes(command);
}

}  // namespace baton::app
