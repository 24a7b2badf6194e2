// A robot's end that navigates, in real time over the loopback device: how late it follows the stick, how even its
// ticks are, and what the connection costs; each beside the same without a connection, turn by turn.
#include <algorithm>
#include <atomic>
#include <thread>

#include "baton/ik/stand.hpp"
#include "baton/link/echoed_planning.hpp"
#include "baton/link/engage.hpp"
#include "baton/link/robot_server.hpp"
#include "baton/model/world.hpp"
#include "baton/run/planning_thread.hpp"
#include "bench/bench.hpp"
#include "bench/draw.hpp"
#include "bench/noted_robot.hpp"

namespace baton::bench {
namespace {

using Clock = NotedRobot::Clock;

constexpr int kTurns = 5;
constexpr Range kBetween{0.02, 0.04};  ///< time between two changes of the stick [s]

Clock::duration duration(double seconds) {
  return std::chrono::duration_cast<Clock::duration>(std::chrono::duration<double>(seconds));
}

double ms(Clock::duration time) {
  return std::chrono::duration<double, std::milli>(time).count();
}

/// The trunk is guided anywhere, and anew at random times.
class ChangingStick {
 public:
  ChangingStick(std::uint64_t seed, int changes) {
    Draw draw(seed);
    double t = 0.5;
    for (int k = 0; k < changes; ++k) {
      Command command;
      command.axes.head<2>() << draw.real(-1.0, 1.0), draw.real(-1.0, 1.0);
      changes_.push_back({Clock::now() + duration(t), command});
      t += draw.real(kBetween);
    }
    end_ = Clock::now() + duration(t + 0.1);
  }

  [[nodiscard]] bool over() const { return Clock::now() >= end_; }
  /// Where it is now.
  [[nodiscard]] Command read() {
    while (next_ < changes_.size() && changes_[next_].at <= Clock::now())
      ++next_;
    return next_ == 0 ? Command{} : changes_[next_ - 1].command;
  }
  /// From each change to the first tick that followed it, or a later one.
  /// @param followed by each tick
  void add_delays(const std::vector<Clock::time_point>& ticks, const std::vector<Command>& followed, Row& row) const {
    auto next = changes_.begin();
    for (std::size_t tick = 0; tick < followed.size(); ++tick) {
      const auto is_it = [&](const Change& change) { return change.command == followed[tick]; };
      const auto newest = std::find_if(next, changes_.end(), is_it);
      if (newest == changes_.end()) continue;
      for (; next <= newest; ++next)
        row.values.push_back(ms(ticks[tick] - next->at));
    }
  }

 private:
  struct Change {
    Clock::time_point at;
    Command command;
  };

  std::vector<Change> changes_;
  std::size_t next_ = 0;
  Clock::time_point end_;
};

/// By how much the time from tick to tick is not the period.
void add_jitter(const std::vector<Clock::time_point>& ticks, Clock::duration period, Row& row) {
  for (std::size_t k = 1; k < ticks.size(); ++k)
    row.values.push_back(1e3 * std::abs(ms(ticks[k] - ticks[k - 1] - period)));
}

struct Measured {
  Row inside{"stick to tick, without a connection", {}, "a session that ticks by the clock", "ms"};
  Row wire{"stick to tick, over loopback", {}, "", "ms"};
  Row bare_jitter{"jitter of a loop that only sleeps", {}, "wall time from tick to tick, but for the period"};
  Row inside_jitter{"jitter without a connection", {}, ""};
  Row wire_jitter{"jitter of the robot's end", {}, ""};
  Row robots_end{"link: a tick at a navigating robot's end", {}, ""};
  Row drivers_end{"link: a tick at its driver's end", {}, ""};
};

class Turn {
 public:
  /// @param changes of the stick
  Turn(const RobotModel& model, const World& world, std::uint64_t seed, int changes, Measured& measured)
      : model_(&model),
        world_(&world),
        seed_(seed),
        changes_(changes),
        measured_(&measured),
        period_(duration(model.profile().tick.period)),
        robot_(model, stand(model, world.site("start"), model.profile().stance.com_height)) {}

  void bare() {
    const ChangingStick stick(seed_, changes_);
    std::vector<Clock::time_point> ticks;
    for (auto due = Clock::now(); !stick.over(); due += period_) {
      std::this_thread::sleep_until(due);
      ticks.push_back(Clock::now());
    }
    add_jitter(ticks, period_, measured_->bare_jitter);
  }

  void inside() {
    robot_.reset();
    PlanningThread planning(*model_, *world_, Modes{});
    Session session(*model_, *world_, robot_, posture(robot_), {{}, StateSource::sensors, &planning});
    ChangingStick stick(seed_, changes_);
    std::vector<Command> followed;
    for (auto due = Clock::now(); !stick.over(); due += period_) {
      std::this_thread::sleep_until(due);
      followed.push_back(stick.read());
      session.step(followed.back());
    }
    stick.add_delays(robot_.ticks(), followed, measured_->inside);
    add_jitter(robot_.ticks(), period_, measured_->inside_jitter);
  }

  void wire() {
    link::RobotServer server(*model_, robot_,
                             {.listen = {"127.0.0.1", 0},
                              .on = "ideal",
                              .world = world_->name(),
                              .real_time = true,
                              .navigates_in = world_,
                              .planning = [this](Modes modes) {
                                return std::make_unique<NotedPlanning>(
                                    std::make_unique<PlanningThread>(*model_, *world_, modes), robot_);
                              }});
    const Address address = server.address();
    std::atomic<bool> stop{false};
    std::thread thread([&] {
      while (!stop)
        server.serve(Socket::Time(50));
    });
    ChangingStick stick = drive(address, stop);
    thread.join();
    stick.add_delays(robot_.ticks(), followed_, measured_->wire);
    add_jitter(robot_.ticks(), period_, measured_->wire_jitter);
    measured_->robots_end.values.push_back(robot_.between_us());
  }

 private:
  [[nodiscard]] Posture posture(Robot& robot) const {
    return link::engage(*model_, world_->site("start"), robot.read().q);
  }
  /// As `baton drive` does.
  /// @param stop set before the robot's end notices that it is not driven any more
  [[nodiscard]] ChangingStick drive(const Address& address, std::atomic<bool>& stop) {
    link::RemoteRobot remote(*model_, world_->name(), link::RemoteRobot::Parameters{address, ""});
    link::EchoedPlanning planning(remote, std::make_unique<PlanningThread>(*model_, *world_, Modes{}));
    Session session(*model_, *world_, remote, posture(remote), {{}, StateSource::sensors, &planning});
    ChangingStick stick(seed_, changes_);
    followed_.clear();
    double us = 0.0;
    while (!stick.over()) {
      const double before = cpu_us();
      followed_.push_back(remote.guide([&] { return stick.read(); }));
      us += cpu_us() - before;
      session.step(followed_.back());
    }
    measured_->drivers_end.values.push_back(us / static_cast<double>(followed_.size()));
    stop = true;
    return stick;
  }

  const RobotModel* model_;
  const World* world_;
  std::uint64_t seed_;
  int changes_;
  Measured* measured_;
  Clock::duration period_;
  NotedRobot robot_;
  std::vector<Command> followed_;
};

std::string beside(const Row& row, const Row& without) {
  return fmt::format("{:+.2f} ms in the median, {:+.2f} in the p99", row.quantile(0.5) - without.quantile(0.5),
                     row.quantile(0.99) - without.quantile(0.99));
}

std::string over(const Row& row, const Row& bare) {
  return fmt::format("{:.1f} times the bare loop's median, {:.1f} times its p99",
                     row.quantile(0.5) / bare.quantile(0.5), row.quantile(0.99) / bare.quantile(0.99));
}

}  // namespace

Rows link_in_real_time(const Options& options) {
  const RobotModel model = RobotModel::load(options.robot);
  const World world = World::load("flat");
  Measured measured;
  for (std::uint64_t turn = 0; turn < kTurns; ++turn) {
    Turn now(model, world, turn, options.trials / kTurns, measured);
    now.bare();
    now.inside();
    now.wire();
  }
  measured.wire.remark = beside(measured.wire, measured.inside);
  measured.inside_jitter.remark = over(measured.inside_jitter, measured.bare_jitter);
  measured.wire_jitter.remark = over(measured.wire_jitter, measured.bare_jitter);
  for (Row* row : {&measured.robots_end, &measured.drivers_end})
    row->remark = fmt::format("the link's own CPU time: {:.1f} % of a core at 500 Hz", 0.05 * row->quantile(0.5));
  return {measured.inside,      measured.wire,       measured.bare_jitter, measured.inside_jitter,
          measured.wire_jitter, measured.robots_end, measured.drivers_end};
}

}  // namespace baton::bench
