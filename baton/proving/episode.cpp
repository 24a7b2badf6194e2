#include "baton/proving/episode.hpp"

#include <cmath>
#include <utility>

#include "baton/input/script.hpp"
#include "baton/proving/arm_policy.hpp"
#include "baton/proving/judges.hpp"
#include "baton/proving/stick.hpp"
#include "baton/record/report.hpp"

namespace baton {
namespace {

constexpr double kRestTimeout = 20.0;    ///< [s] a robot must come to rest within this after release
constexpr double kBeginTimeout = 120.0;  ///< [s] a robot must begin to retrace, or refuse to: hot, it cools first
constexpr double kRestTime = 0.25;       ///< [s] without a motion: no planning under way either
constexpr std::uint64_t kArms = 7;       ///< random stream of what drives the arms
constexpr long kMostRetraced = 5;        ///< most motions retraced at the end

/// In physics soles sink and the planning frame follows their estimated positions, so penetration is judged within the
/// ground's flatness. In a scenario, or if the sensors err, only falls count, as the ground is not as planned.
std::optional<Checker> checker_of(const Trial& trial, const RobotModel& robot, const Simulation& simulation) {
  if (trial.scenario != nullptr || trial.real) return std::nullopt;
  Checker::Tolerances tolerances;
  if (trial.on == Simulation::On::sim) tolerances.sink = robot.profile().ground.flatness;
  return Checker(robot, simulation.model_text(Visuals::drop), tolerances);
}

std::uint64_t seed_of(const Trial& trial, long index) {
  return trial.seed + static_cast<std::uint64_t>(index);
}

Simulation::Parameters parameters_of(const Trial& trial, const RobotModel& robot, long index, Planning& planning) {
  Simulation::Parameters parameters;
  parameters.physics.plant = plant_of(trial.real, trial.scenario, robot, seed_of(trial, index), trial.times);
  parameters.session = {trial.modes, trial.state, &planning};
  parameters.calibration = trial.calibration;
  return parameters;
}

/// A running episode.
class Run {
 public:
  Run(const RobotModel& robot, const World& world, const Trial& trial, long index)
      : direct_(robot, world, trial.modes),
        planning_(direct_, trial.answers, robot.profile().tick.period, seed_of(trial, index)),
        simulation_(robot, world, trial.on, parameters_of(trial, robot, index, planning_)),
        session_(simulation_.session()),
        report_(robot),
        failures_(session_, index, tally_),
        way_back_(robot, trial.on == Simulation::On::ideal, failures_, tally_.retrace),
        tick_judge_(checker_of(trial, robot, simulation_), trial.on == Simulation::On::ideal, failures_, tally_),
        stuck_judge_(robot, world, trial.modes.duration, session_, failures_) {
    session_.add(report_);
    session_.add(way_back_);
    session_.add(tick_judge_);
    session_.add(stuck_judge_);
    if (!trial.arms) return;
    arms_.emplace(robot, mixed_seed(seed_of(trial, index), kArms));
    session_.add(*arms_);
  }

  void drive(Device& stick, long ticks, bool back, const std::atomic<bool>& stop) {
    for (long k = 0; k < ticks && !stop && !session_.fallen(); ++k) {
      const Command command = stick.read(session_.t());
      const bool deflected = Stick::deflected(command);
      tally_.deflected += deflected ? 1 : 0;
      note_letting_go(deflected);
      drive_arms();
      step(command);
      stuck_judge_.look();
    }
    if (arms_) session_.drive_arms(released_arms(session_.model()));
    if (!come_to_rest(stop)) return;
    if (back && !session_.fallen() && !stop) {
      stuck_judge_.test();
      if (!go_back(stop)) return;
    }
    if (session_.fallen()) {
      step(Command{});  // as `drive` does, so the last row shows it
      failures_.add("fall", session_.t(), 0.0, 0.0, simulation_.truth().fall);
    }
  }

  /// Ends the episode after an exception.
  void fail(const std::string& what) { failures_.add("exception", session_.t(), 0.0, 0.0, what); }

  [[nodiscard]] EpisodeResult result() {
    const nlohmann::json summary = report_.json("", "", 0, 0.0);
    tally_.episodes = 1;
    tally_.segments = session_.navigator().committed();
    summary["segments"]["refused"].get_to(tally_.refused);
    summary["commands"]["given"].get_to(tally_.given);
    summary["commands"]["moved"].get_to(tally_.moved);
    if (arms_) tally_.arms = {arms_->ticks(), arms_->on_target()};
    tally_.travel = summary["travel_m"].get<double>();
    return {tally_, summary, ticks_, tick_judge_.last(), back_};
  }

 private:
  void drive_arms() {
    if (!arms_) return;
    while (const ArmTargets* targets = arms_->next(session_.t()))
      session_.drive_arms(*targets);
  }

  void step(const Command& command) {
    const bool back = way_back_.begun();
    if (back && !(command == last_command_)) back_ += script_line(session_.t(), command) + '\n';
    last_command_ = command;
    session_.step(command);
    ++ticks_;
    tally_.ticks += back ? 0 : 1;
  }

  /// Releases the stick; false if the robot does not come to rest.
  bool come_to_rest(const std::atomic<bool>& stop) {
    const double period = session_.model().profile().tick.period;
    const long latest = ticks_ + std::lround(kRestTimeout / period);
    for (long rests = 0; rests < std::lround(kRestTime / period) && !stop && !session_.fallen();) {
      step(Command{});
      rests = session_.resting() ? rests + 1 : 0;
      if (ticks_ > latest) {
        failures_.add("unrest", session_.t(), kRestTimeout, kRestTimeout, "");
        return false;
      }
    }
    return true;
  }

  /// Retraces the last few motions; false if the robot does not begin one or does not come to rest. Retrace stays
  /// held, since releasing it would end a long retrace early.
  bool go_back(const std::atomic<bool>& stop) {
    way_back_.begin();
    Command press;
    press.recall = Recall::retrace;
    const Navigator& navigator = session_.navigator();
    const Tally::Retrace& sum = tally_.retrace;
    const long most = std::lround(kBeginTimeout / session_.model().profile().tick.period);
    long waited = 0;
    while (sum.tried < kMostRetraced && sum.refused == 0 && (way_back_.under_way() || navigator.history() > 0) &&
           !stop && !session_.fallen()) {
      step(press);
      waited = way_back_.under_way() ? 0 : waited + 1;
      if (waited > most) {
        failures_.add("frozen", session_.t(), kBeginTimeout, kBeginTimeout, "");
        return false;
      }
    }
    return come_to_rest(stop);
  }

  /// Counts motions during which the stick was released.
  void note_letting_go(bool deflected) {
    const long segment = session_.navigator().segment();
    if (std::exchange(was_deflected_, deflected) && !deflected && segment >= 0 && segment != let_go_in_) {
      ++tally_.let_go;
      let_go_in_ = segment;
    }
  }

  DirectPlanning direct_;
  FaultyPlanning planning_;
  Simulation simulation_;
  Session& session_;
  Tally tally_;
  Report report_;
  Failures failures_;
  WayBack way_back_;
  TickJudge tick_judge_;
  StuckJudge stuck_judge_;
  std::optional<ArmPolicy> arms_;
  long ticks_ = 0;
  Command last_command_;
  bool was_deflected_ = false;
  long let_go_in_ = -1;  ///< segment in which the stick was last released
  std::string back_;     ///< stick while retracing
};

}  // namespace

long Episodes::ticks() const {
  return std::max(1L, std::lround(trial_.seconds / robot_->profile().tick.period));
}

std::unique_ptr<Device> Episodes::stick(long index) const {
  static const Scenario random{};
  return stick_of(trial_.scenario == nullptr ? random : *trial_.scenario, *robot_,
                  mixed_seed(trial_.seed, static_cast<std::uint64_t>(index)));
}

EpisodeResult Episodes::run(long index, const std::atomic<bool>& stop) const {
  Run run(*robot_, *world_, trial_, index);
  try {
    run.drive(*stick(index), ticks(), trial_.scenario == nullptr, stop);
  } catch (const std::exception& error) {
    run.fail(error.what());
  }
  return run.result();
}

std::string Episodes::script(long index, const EpisodeResult& result) const {
  return stick_script(*stick(index), robot_->profile().tick.period, ticks()) + result.back;
}

}  // namespace baton
