#include "baton/proving/tryout.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "baton/proving/stick.hpp"
#include "baton/record/report.hpp"

namespace baton {
namespace {

constexpr double kHalfTurn =
    0.94 * M_PI;  ///< what counts as a turn by 180°: the last segment may end short of it [rad]
constexpr double kIdle = 0.5 * M_PI / 180.0;  ///< tolerance of waist and neck [rad]
constexpr double kRandom = 60.0;              ///< [s]

/// A stick that does one thing after the other.
class Stretches {
 public:
  Stretches& hold(Command command, double seconds) {
    entries_.push_back({t_, command});
    t_ += seconds;
    return *this;
  }
  Stretches& axis(Part part, int axis, double value, double seconds) {
    Command command;
    command.guide = part;
    command.axes[axis] = value;
    return hold(command, seconds);
  }
  Stretches& release(Part part, double seconds) {
    Command command;
    command.guide = part;
    return hold(command, seconds);
  }
  [[nodiscard]] Manoeuvre named(const std::string& name) const { return {name, entries_, t_, 0.0, 0.0}; }

 private:
  std::vector<Script::Entry> entries_;
  double t_ = 0.0;
};

SimulatedRobot::Parameters physics_of(const RobotModel& robot, std::uint64_t seed) {
  SimulatedRobot::Parameters physics;
  physics.plant = real_plant(robot, seed);
  return physics;
}

std::string most_frequent(const nlohmann::json& refused) {
  std::string reason;
  long most = 0;
  for (const auto& [name, count] : refused.items()) {
    if (count.get<long>() <= most) continue;
    most = count.get<long>();
    reason = name;
  }
  return reason;
}

}  // namespace

std::vector<Manoeuvre> manoeuvres(const RobotModel& robot) {
  const double unit = robot.profile().duration.max / 3.0;
  std::vector<Manoeuvre> list;
  list.push_back(Stretches().release(Part::trunk, 5.0).named("stand"));
  Stretches shift;
  shift.release(Part::trunk, 0.5);
  for (const double to : {1.0, -1.0})
    shift.axis(Part::trunk, 1, to, 1.5 * unit).release(Part::trunk, 1.5 * unit);
  list.push_back(shift.named("shift"));
  Stretches squat;
  squat.release(Part::trunk, 0.5);
  for (const double to : {-1.0, 1.0})
    squat.axis(Part::trunk, 2, to, 2.0 * unit).release(Part::trunk, unit);
  list.push_back(squat.named("squat"));
  for (const Part foot : {Part::left_foot, Part::right_foot}) {
    Command up;
    up.guide = foot;
    up.lift[side_of(foot)] = 1.0;
    list.push_back(Stretches()
                       .release(foot, 0.5)
                       .hold(up, 4.0 * unit)
                       .release(foot, 4.0 * unit)
                       .named(fmt::format("lift {}", to_string(foot))));
    Stretches step;
    step.release(foot, 0.5);
    const double out = sign_of(side_of(foot));
    for (const auto& [axis, to] : {std::pair(0, 1.0), std::pair(0, -1.0), std::pair(1, out), std::pair(1, -out)})
      step.axis(foot, axis, to, 1.5 * unit).release(foot, 3.0 * unit);
    list.push_back(step.named(fmt::format("step {}", to_string(foot))));
  }
  Manoeuvre turn = Stretches().release(Part::trunk, 0.5).axis(Part::trunk, 5, 1.0, 90.0 * unit).named("turn");
  turn.turn = kHalfTurn;
  list.push_back(turn);
  Manoeuvre walk = Stretches()
                       .release(Part::trunk, 0.5)
                       .axis(Part::trunk, 0, 1.0, 12.0 * unit)
                       .release(Part::trunk, 3.0 * unit)
                       .named("walk");
  walk.way = robot.profile().stance.com_height;
  list.push_back(walk);
  for (const Part hand : {Part::left_hand, Part::right_hand}) {
    Stretches reach;
    reach.release(hand, 0.5);
    for (const auto& [axis, to] : {std::pair(0, 1.0), std::pair(2, 1.0), std::pair(0, -1.0), std::pair(2, -1.0)})
      reach.axis(hand, axis, to, unit).release(hand, unit);
    list.push_back(reach.named(fmt::format("reach {}", to_string(hand))));
  }
  list.push_back({"random", {}, kRandom, 0.0, 0.0});
  return list;
}

nlohmann::json Attempt::json() const {
  return {{"manoeuvre", manoeuvre},
          {"done", done()},
          {"problem", problem},
          {"fall", fall},
          {"t", t},
          {"commands", {{"given", given}, {"moved", moved}}},
          {"travel_m", travel},
          {"turned_rad", turned},
          {"idle_joints_rad", idle},
          {"com_rms_m", com_rms},
          {"refusal", refusal}};
}

Tryout::Tryout(const RobotModel& robot, const World& world, Simulation::On on, std::uint64_t seed)
    : robot_(&robot), simulation_(robot, world, on, {.physics = physics_of(robot, seed)}), seed_(seed) {}

Attempt Tryout::run(const Manoeuvre& manoeuvre) {
  Session& session = simulation_.session();
  session.reset();
  Report report(*robot_);
  session.add(report);
  Attempt attempt;
  attempt.manoeuvre = manoeuvre.name;
  const bool random = manoeuvre.stick.empty();
  Script script(manoeuvre.stick);
  Stick any(seed_, robot_->profile().tick.period);
  Kinematics kinematics(*robot_);
  const auto yaw = [&] {
    kinematics.set(simulation_.truth().q);
    return yaw_of(kinematics.trunk().R);
  };
  double last_yaw = yaw();
  double end = manoeuvre.seconds;
  bool turned = false;
  while (session.t() < end && !session.fallen()) {
    Command command = random ? any.next() : script.read(session.t());
    if (turned) command.axes.setZero();
    session.step(command);
    const double now = yaw();
    attempt.turned += std::remainder(now - last_yaw, 2.0 * M_PI);
    last_yaw = now;
    if (manoeuvre.turn == 0.0 || turned || std::abs(attempt.turned) < manoeuvre.turn) continue;
    turned = true;
    end = session.t() + robot_->profile().duration.max;
  }
  if (session.fallen()) attempt.fall = simulation_.truth().fall;
  attempt.t = session.t();
  attempt.q = simulation_.truth().q;
  for (const int j : robot_->idle()) {
    attempt.idle =
        std::max(attempt.idle, std::abs(attempt.q[7 + j] - robot_->joints()[static_cast<std::size_t>(j)].home));
  }
  const nlohmann::json summary = report.json("", "", 0, 0.0);
  summary["commands"]["given"].get_to(attempt.given);
  summary["commands"]["moved"].get_to(attempt.moved);
  summary["travel_m"].get_to(attempt.travel);
  summary["tracking"]["com_rms_m"].get_to(attempt.com_rms);
  attempt.refusal = most_frequent(summary["segments"]["refused"]);
  const std::string why = attempt.refusal.empty() ? "" : fmt::format(" ({})", attempt.refusal);
  if (!attempt.fall.empty()) {
    attempt.problem = fmt::format("it falls after {:.1f} s: {}", attempt.t, attempt.fall);
  } else if (!random && static_cast<double>(attempt.moved) < kMovedShare * static_cast<double>(attempt.given)) {
    attempt.problem = fmt::format("{} of {} commands moved it{}", attempt.moved, attempt.given, why);
  } else if (attempt.travel < manoeuvre.way) {
    attempt.problem = fmt::format("it went {:.2f} m instead of {:.2f} m{}", attempt.travel, manoeuvre.way, why);
  } else if (std::abs(attempt.turned) < manoeuvre.turn) {
    attempt.problem = fmt::format("it turned by {:.0f}° instead of 180°{}", attempt.turned * 180.0 / M_PI, why);
  } else if (manoeuvre.turn != 0.0 &&
             attempt.idle > kIdle + robot_->profile().sensors.encoder_offset + robot_->profile().actuators.backlash) {
    attempt.problem = fmt::format("waist or neck is {:.1f}° from home after the turn", attempt.idle * 180.0 / M_PI);
  }
  return attempt;
}

}  // namespace baton
