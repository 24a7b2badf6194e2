#include "baton/proving/episode.hpp"

#include <cmath>
#include <deque>
#include <set>
#include <utility>

#include "baton/ik/stand.hpp"
#include "baton/input/script.hpp"
#include "baton/record/report.hpp"

namespace baton {
namespace {

constexpr double kComesToRest = 20.0;  ///< [s] within which a robot that is let go has to rest
constexpr double kRests = 0.25;        ///< [s] without a motion: nothing is being planned either
constexpr int kRefusedInARow = 200;    ///< refusals without a motion between them that make one wonder
constexpr long kRetraced = 5;          ///< motions back at the end, at most
constexpr double kSamePlace = 0.005;   ///< [m] from the rest that it leads back to
constexpr double kSameTurn = 0.02;     ///< [rad]

/// In physics soles sink, and the planning frame is laid on where they are believed to be: as near to the known ground
/// as its unevenness lets be told.
Checker::Tolerances tolerances(const RobotModel& robot, const Trial& trial) {
  Checker::Tolerances tolerances;
  if (trial.on == Session::On::sim) tolerances.sink = robot.profile().ground.flatness;
  return tolerances;
}

SimulatedRobot::Parameters parameters(const RobotModel& robot, const Trial& trial, long index) {
  SimulatedRobot::Parameters parameters;
  const std::uint64_t seed = trial.seed + static_cast<std::uint64_t>(index);
  if (trial.scenario != nullptr) parameters.plant = plant_of(*trial.scenario, robot, seed, trial.times);
  return parameters;
}

/// One episode while it runs.
class Run {
 public:
  Run(const RobotModel& robot, const World& world, const Trial& trial, long index)
      : robot_(robot),
        on_(trial.on),
        index_(index),
        session_(robot, world, trial.on, std::nullopt, parameters(robot, trial, index), trial.modes, trial.state),
        report_(robot),
        stuck_planning_(robot, world, {trial.modes.duration, OnLimit::discard}) {
    AnswerFaults faults = trial.answers;
    faults.seed = trial.seed + static_cast<std::uint64_t>(index);
    session_.spoil_answers(faults);
    // In a scenario it is falls that count: the ground is not as planned.
    if (trial.scenario == nullptr) checker_.emplace(robot, session_.model_text(), tolerances(robot, trial));
    session_.on_tick = [this](const TickRecord& record) { judge(record); };
    session_.on_plan = [this](const PlanRecord& record) {
      report_.add(record);
      count_refusals(record);
      if (going_back_) look_whether_refused(record);
    };
  }

  void drive(const std::function<Command()>& stick, long ticks, bool back, const std::atomic<bool>& stop) {
    for (long k = 0; k < ticks && !stop && !session_.fallen(); ++k) {
      const Command command = stick();
      const bool deflected = Stick::deflected(command);
      tally_.deflected += deflected ? 1 : 0;
      note_letting_go(deflected);
      step(command);
      look_whether_stuck();
    }
    if (!come_to_rest(stop)) return;
    if (back && !session_.fallen() && !stop) {
      test_whether_stuck();
      if (!go_back(stop)) return;
    }
    if (session_.fallen()) {
      step(Command{});  // as `drive` does: the last row says so
      fail("fall", session_.t(), 0.0, 0.0, session_.truth().fall);
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
    tally_.segments = session_.navigator().committed();
    summary["segments"]["refused"].get_to(tally_.refused);
    summary["commands"]["given"].get_to(tally_.given);
    summary["commands"]["moved"].get_to(tally_.moved);
    tally_.travel = summary["travel_m"].get<double>();
    return {tally_, summary, ticks_, last_q_, back_};
  }

 private:
  void step(const Command& command) {
    if (going_back_ && !(command == last_command_)) back_ += script_line(session_.t(), command) + '\n';
    last_command_ = command;
    session_.step(command);
    ++ticks_;
    tally_.ticks += going_back_ ? 0 : 1;
  }

  /// Lets go of the stick; false if that does not bring the robot to rest.
  bool come_to_rest(const std::atomic<bool>& stop) {
    const double period = robot_.profile().tick.period;
    const long latest = ticks_ + std::lround(kComesToRest / period);
    for (long rests = 0; rests < std::lround(kRests / period) && !stop && !session_.fallen();) {
      step(Command{});
      rests = session_.resting() ? rests + 1 : 0;
      if (ticks_ > latest) {
        fail("unrest", session_.t(), kComesToRest, kComesToRest, "");
        return false;
      }
    }
    return true;
  }

  /// The last few motions back, with retrace held: let go of, a long way back would end early.
  bool go_back(const std::atomic<bool>& stop) {
    going_back_ = true;
    Command press;
    press.recall = Recall::retrace;
    const Navigator& navigator = session_.navigator();
    const Tally::Retrace& sum = tally_.retrace;
    while (sum.tried < kRetraced && sum.refused == 0 && (back_to_ || navigator.history() > 0) && !stop &&
           !session_.fallen())
      step(press);
    return come_to_rest(stop);
  }

  /// Counts the motions during which the stick was let go of.
  void note_letting_go(bool deflected) {
    const long segment = session_.navigator().segment();
    if (std::exchange(was_deflected_, deflected) && !deflected && segment >= 0 && segment != let_go_in_) {
      ++tally_.let_go;
      let_go_in_ = segment;
    }
  }

  void judge(const TickRecord& record) {
    report_.add(record);
    const Navigator& navigator = record.navigator;
    last_q_ = record.truth.q;
    if (navigator.phase() == Phase::fallen) return;
    follow_rests(navigator, record.truth.q);
    if (navigator.committed() != committed_) {
      committed_ = navigator.committed();
      tally_.shrunk += navigator.motion()->limit ? 1 : 0;
    }
    if (!checker_) return;
    const bool ideal = on_ == Session::On::ideal;
    tick_ = {record.t,
             ideal ? Pose{} : navigator.anchor(),
             ideal ? record.truth.q : navigator.sample().q,
             navigator.sample().contact,
             navigator.phase() == Phase::hold,
             navigator.catching(),
             record.target.q};
    for (const Checker::Violation& v : checker_->add(tick_))
      fail(std::string(Checker::kNames[static_cast<std::size_t>(v.kind)]), v.t, v.value, v.limit, v.where);
    if (!record.truth.q.allFinite() || !record.target.tau.allFinite()) fail("not_finite", record.t, 0.0, 0.0, "");
  }

  /// Notes where the motions that can be retraced began, and looks where those back end.
  void follow_rests(const Navigator& navigator, const VecX& q) {
    const Motion* motion = navigator.motion();
    const bool begins = navigator.committed() != committed_;
    const bool from_rest = motion == nullptr || navigator.now() >= motion_ends_;
    if (begins) motion_ends_ = navigator.now() + motion->ticks();
    if (back_to_ && (begins || motion == nullptr)) {
      if (from_rest && going_back_ && !part_) look_whether_back(q);
      if (!from_rest || part_) rests_.push_back(*back_to_);  // it ended on the way to there
      back_to_.reset();
    }
    if (begins && motion->retraces) {
      part_ = motion->limit.has_value();
      back_to_ = rests_.back();
      rests_.pop_back();
    } else if (begins && from_rest) {
      rests_.push_back(q);
    }
    while (rests_.size() > navigator.history())  // forgotten: too long ago, or after a slip
      rests_.pop_front();
  }

  void look_whether_back(const VecX& q) {
    const Posture there = posture_of(robot_, *back_to_);
    const Posture here = posture_of(robot_, q);
    const double turned = rotation_error(there.trunk, here.trunk).norm();
    double off = (there.com - here.com).norm();
    for (const Side side : kSides)
      off = std::max(off, (there.sole[side].p - here.sole[side].p).norm());
    Tally::Retrace& sum = tally_.retrace;
    ++sum.tried;
    sum.worst_m = std::max(sum.worst_m, off);
    sum.worst_rad = std::max(sum.worst_rad, turned);
    const bool turned_too_far = turned > kSameTurn;
    if (off <= kSamePlace && !turned_too_far) {
      ++sum.arrived;
    } else if (on_ == Session::On::ideal) {
      fail("retrace", session_.t(), turned_too_far ? turned : off, turned_too_far ? kSameTurn : kSamePlace,
           turned_too_far ? "trunk" : "");
    }
  }

  void look_whether_refused(const PlanRecord& record) {
    const auto* refusal = std::get_if<Refusal>(&record.result.outcome);
    if (refusal == nullptr || record.request.command.recall != Recall::retrace || !record.request.trail) return;
    ++tally_.retrace.tried;
    ++tally_.retrace.refused;
    if (on_ == Session::On::ideal)
      fail("retrace", session_.t(), refusal->value, refusal->limit, std::string(to_string(refusal->reason)));
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
    if (stuck(stuck_planning_, session_.navigator().request_for({}))) fail("stuck", session_.t(), 0.0, 0.0, "");
  }

  const RobotModel& robot_;
  Session::On on_;
  long index_;
  Session session_;
  std::optional<Checker> checker_;
  Report report_;
  Strategy stuck_planning_;
  Checker::Tick tick_;
  Tally tally_;
  long ticks_ = 0;
  long committed_ = 0;
  bool was_deflected_ = false;
  long let_go_in_ = -1;     ///< the segment in which the stick was let go of last
  std::deque<VecX> rests_;  ///< where the motions that can be retraced began
  bool going_back_ = false;
  long motion_ends_ = 0;         ///< the one under way, if nothing replaces it [tick]
  std::optional<VecX> back_to_;  ///< where the motion back that is under way shall end
  bool part_ = false;            ///< it goes only a part of the way there
  Command last_command_;
  std::string back_;
  VecX last_q_;
  int refused_in_a_row_ = 0;
  long segment_ = -1;            ///< the one that failed last
  std::set<std::string> kinds_;  ///< what it failed by
};

}  // namespace

long Episodes::ticks() const {
  return std::max(1L, std::lround(trial_.seconds / robot_->profile().tick.period));
}

std::function<Command()> Episodes::stick(long index) const {
  static const Scenario random{};
  return stick_of(trial_.scenario == nullptr ? random : *trial_.scenario, *robot_,
                  mixed_seed(trial_.seed, static_cast<std::uint64_t>(index)));
}

EpisodeResult Episodes::run(long index, const std::atomic<bool>& stop) const {
  Run run(*robot_, *world_, trial_, index);
  try {
    run.drive(stick(index), ticks(), trial_.scenario == nullptr, stop);
  } catch (const std::exception& error) {
    run.fail("exception", run.t(), 0.0, 0.0, error.what());
  }
  return run.result();
}

std::string Episodes::script(long index, const EpisodeResult& result) const {
  return stick_script(stick(index), robot_->profile().tick.period, ticks()) + result.back;
}

bool stuck(Strategy& planning, Request request) {
  const auto goes = [&](const Command& command) {
    request.command = command;
    return std::holds_alternative<Motion>(planning.plan(request).outcome);
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

}  // namespace baton
