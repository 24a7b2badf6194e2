#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>

#include "baton/record/plan_json.hpp"
#include "baton/shadow/shadow.hpp"

namespace baton::shadow {
namespace {

constexpr double kDegrees = 180.0 / M_PI;
constexpr double kPeriodOff = 0.01;   ///< error of the period that is worth a word
constexpr double kLateShare = 0.001;  ///< share of late or repeated measurements that is none
constexpr double kHotMotors = 0.8;    ///< [permitted rise]
constexpr double kUnnoticed = 0.5;    ///< time within which a fall has to be noticed [s]

/// A number with its unit, for people: angles in degrees.
std::string shown(double value, const std::string& unit, const char* sign = "") {
  const auto number = [&](const char* digits, double scaled, std::string_view name) {
    return fmt::format(fmt::runtime(fmt::format("{{:{}{}}}{{}}", sign, digits)), scaled, name);
  };
  if (unit == "rad") return number(".2f", value * kDegrees, "°");
  if (unit == "m") return number(".1f", 1e3 * value, " mm");
  return number(unit == "N" ? ".1f" : ".3f", value, " " + unit);
}

nlohmann::json statistic_json(const Statistic& s) {
  return {{"n", s.n}, {"mean", s.mean()}, {"rms", s.rms()}, {"worst", s.worst}, {"worst_t", s.when}};
}

std::string_view sensor_cause(Sensor sensor) {
  switch (sensor) {
    case Sensor::encoders:
      return "an angle or speed that jumped, stood still or contradicted the other";
    case Sensor::torques:
      return "torques that no motor gives";
    case Sensor::attitude:
      return "an attitude that is no rotation, or turned otherwise than the gyro";
    case Sensor::gyro:
      return "a gyro out of range, or that turned otherwise than the attitude";
    case Sensor::accelerometer:
      return "an acceleration out of range, or far from gravity";
    case Sensor::forces:
      break;
  }
  return "forces out of range, with their pressure beyond the sole, or that the motor torques contradict";
}

}  // namespace

std::vector<Finding> Shadow::findings() const {
  std::vector<Finding> all;
  const auto find = [&](std::string what, double value, double limit, std::string unit, std::string verdict) {
    all.push_back({std::move(what), value, limit, std::move(unit), std::move(verdict)});
  };
  const double period = robot_->profile().tick.period;
  for (const Comparison& one : standing_.enough() ? standing_.disagreements() : std::vector<Comparison>{}) {
    const double mean = one.value.mean();
    find(one.what, mean, one.limit, one.unit,
         fmt::format("{}: {} off the model (limit {}): {}?", one.what, shown(mean, one.unit, "+"),
                     shown(one.limit, one.unit), one.cause));
  }
  if (const double drift = standing_.yaw_drift(); std::abs(drift) > standing_.yaw_drift_limit()) {
    find(
        "yaw drift", drift, standing_.yaw_drift_limit(), "rad/s",
        fmt::format("yaw drift: the IMU turns by {:+.1f}° a minute against soles that stand (limit {:.1f}°): its gyro?",
                    60.0 * kDegrees * drift, 60.0 * kDegrees * standing_.yaw_drift_limit()));
  }
  for (const Beyond& one : beyond_) {
    find(one.what + " of " + one.joint, one.value, one.limit, one.unit,
         fmt::format("{} of {}: {} at {:.2f} s, {} measurements beyond {}: a wrong zero, sign, unit or profile?",
                     one.what, one.joint, shown(one.value, one.unit, "+"), one.t, one.n, shown(one.limit, one.unit)));
  }
  for (const Sensor sensor : kSensors) {
    const Rejected& rejected = rejected_[sensor];
    if (rejected.ticks == 0) continue;
    const std::string name(baton::to_string(sensor));
    find(name, static_cast<double>(rejected.ticks), 0.0, "measurements",
         fmt::format("{}: {} of {} measurements rejected, {} times, {} of them not finite, first at {:.2f} s{}: {}?",
                     name, rejected.ticks, timing_.measurements, rejected.times, rejected.not_finite, rejected.first,
                     rejected.lost > 0 ? fmt::format(", {} times given up", rejected.lost) : "", sensor_cause(sensor)));
  }
  const auto counted = [&](const char* what, long n, const char* cause) {
    const double most = kLateShare * static_cast<double>(timing_.measurements);
    if (static_cast<double>(n) <= most) return;
    find(what, static_cast<double>(n), most, "measurements",
         fmt::format("{} of {} measurements {}: {}?", n, timing_.measurements, what, cause));
  };
  counted("lost", timing_.lost, "a slow connection or program at the robot's end");
  counted("repeated", timing_.repeated, "sensors slower than the tick, or a robot that stands still in time");
  counted("out of order", timing_.out_of_order, "a connection that reorders, or a wrong number");
  counted("late", timing_.late, "a robot's end that waits before it sends");
  const double mean = timing_.interval.mean();
  if (timing_.interval.n > 0 && std::abs(mean - period) > kPeriodOff * period) {
    find("period", mean, period, "s",
         fmt::format("period: {:.3f} ms in the mean, {:.3f} ms by the profile: another rate or clock?", 1e3 * mean,
                     1e3 * period));
  }
  if (unusable_ > 0.0) {
    find("unusable", unusable_, 0.0, "s",
         fmt::format("for {:.2f} s there was nothing to begin with: joint angles that are not finite, or an attitude "
                     "that is no rotation?",
                     unusable_));
  }
  for (const Guard guard : {Guard::fallen, Guard::lifted}) {
    const auto is = [&](const Judged& one) { return one.to == guard; };
    const auto first = std::find_if(judged_.begin(), judged_.end(), is);
    if (first == judged_.end()) continue;
    const auto n = std::count_if(judged_.begin(), judged_.end(), is);
    const auto wrong =
        std::count_if(judged_.begin(), judged_.end(), [&](const Judged& one) { return is(one) && one.truly == false; });
    const std::string name(baton::to_string(guard));
    find("guard: " + name, static_cast<double>(n), 0.0, "times",
         fmt::format("the guard would have said {} {} times, first at {:.2f} s{}: was it?", name, n, first->t,
                     wrong > 0 ? fmt::format(", {} times wrongly, by the simulator", wrong) : ""));
  }
  if (fallen_unnoticed_ > kUnnoticed) {
    find("guard: not fallen", fallen_unnoticed_, kUnnoticed, "s",
         fmt::format("the robot had fallen, by the simulator, for {:.2f} s that the guard did not notice",
                     fallen_unnoticed_));
  }
  if (hottest_ > kHotMotors) {
    find("heat", hottest_, kHotMotors, "permitted rise",
         fmt::format("a motor would have been at {:.2f} of its permitted rise of temperature (limit {})", hottest_,
                     kHotMotors));
  }
  return all;
}

std::string Shadow::summary() const {
  std::string text = fmt::format("{:.1f} s, of which it stood still for {:.1f} s; {} measurements, {:.3f} ms apart\n",
                                 seconds(), standing_.seconds(), timing_.measurements, 1e3 * timing_.interval.mean());
  // Of the joints' torques those three that are nearest to their limit, or beyond.
  std::vector<const Comparison*> torques, rows;
  for (const Comparison& one : standing_.all()) {
    if (one.value.n > 0) (one.unit == "N·m" ? torques : rows).push_back(&one);
  }
  std::sort(torques.begin(), torques.end(), [](const Comparison* a, const Comparison* b) {
    return std::abs(a->value.mean() / a->limit) > std::abs(b->value.mean() / b->limit);
  });
  torques.resize(std::min<std::size_t>(torques.size(), 3));
  rows.insert(rows.begin(), torques.begin(), torques.end());
  if (!rows.empty())
    text += fmt::format("{:<46}{:>13}{:>13}{:>13}{:>10}{:>12}\n", "still: measured less what the model says", "mean",
                        "rms", "worst", "at", "limit");
  for (const Comparison* one : rows) {
    text += fmt::format("  {:<44}{:>13}{:>13}{:>13}{:>8.2f} s{:>12}\n", one->what,
                        shown(one->value.mean(), one->unit, "+"), shown(one->value.rms(), one->unit),
                        shown(one->value.worst, one->unit, "+"), one->value.when, shown(one->limit, one->unit));
  }
  std::map<std::string, long> outcomes;
  for (const Tried& one : tried_) {
    std::string outcome(to_string(one.outcome));
    std::replace(outcome.begin(), outcome.end(), '_', ' ');
    if (one.outcome == Tried::Outcome::refused)
      outcome += fmt::format(" ({})", one.refusal ? baton::to_string(one.refusal->reason) : "posture");
    ++outcomes[outcome];
  }
  for (const auto& [outcome, n] : outcomes)
    text += fmt::format("commands {}: {}\n", outcome, n);
  const std::vector<Finding> found = findings();
  if (!standing_.enough()) text += "it did not stand still for long enough to compare it with its model\n";
  text += found.empty() ? "nothing disagrees by more than the robot's profile explains\n" : "to look at:\n";
  for (const Finding& one : found)
    text += "  " + one.verdict + '\n';
  return text;
}

nlohmann::json Shadow::json() const {
  nlohmann::json standing = nlohmann::json::array();
  for (const Comparison& one : standing_.all()) {
    if (one.value.n == 0) continue;
    nlohmann::json entry = statistic_json(one.value);
    entry.update({{"what", one.what}, {"unit", one.unit}, {"limit", one.limit}});
    standing.push_back(std::move(entry));
  }
  nlohmann::json beyond = nlohmann::json::array();
  for (const Beyond& one : beyond_) {
    beyond.push_back({{"joint", one.joint},
                      {"what", one.what},
                      {"unit", one.unit},
                      {"limit", one.limit},
                      {"n", one.n},
                      {"worst", one.value},
                      {"worst_t", one.t}});
  }
  nlohmann::json sensors = nlohmann::json::object();
  for (const Sensor sensor : kSensors) {
    const Rejected& rejected = rejected_[sensor];
    if (rejected.ticks == 0) continue;
    sensors[std::string(baton::to_string(sensor))] = {{"rejected_ticks", rejected.ticks},
                                                      {"times", rejected.times},
                                                      {"not_finite", rejected.not_finite},
                                                      {"lost", rejected.lost},
                                                      {"first_t", rejected.first}};
  }
  nlohmann::json guard = nlohmann::json::array();
  for (const Judged& one : judged_) {
    guard.push_back({{"t", one.t},
                     {"from", baton::to_string(one.from)},
                     {"to", baton::to_string(one.to)},
                     {"truly", one.truly ? nlohmann::json(*one.truly) : nlohmann::json(nullptr)}});
  }
  nlohmann::json commands = nlohmann::json::array();
  std::map<std::string, long> outcomes, reasons;
  for (const Tried& one : tried_) {
    ++outcomes[std::string(to_string(one.outcome))];
    const std::string reason = one.refusal ? std::string(baton::to_string(one.refusal->reason)) : "posture";
    if (one.outcome == Tried::Outcome::refused) ++reasons[reason];
    commands.push_back({{"t", one.t},
                        {"guide", baton::to_string(one.command.guide)},
                        {"outcome", to_string(one.outcome)},
                        {"duration", one.duration},
                        {"refusal", to_json(one.refusal)},
                        {"posture", one.why}});
  }
  nlohmann::json findings = nlohmann::json::array();
  for (const Finding& one : this->findings()) {
    findings.push_back(
        {{"what", one.what}, {"value", one.value}, {"limit", one.limit}, {"unit", one.unit}, {"verdict", one.verdict}});
  }
  return {{"seconds", seconds()},
          {"still_s", standing_.seconds()},
          {"damped_s", damped_time_},
          {"unusable_s", unusable_},
          {"timing",
           {{"measurements", timing_.measurements},
            {"begun", timing_.begun},
            {"lost", timing_.lost},
            {"repeated", timing_.repeated},
            {"out_of_order", timing_.out_of_order},
            {"late", timing_.late},
            {"interval_s", statistic_json(timing_.interval)},
            {"age_s", statistic_json(timing_.age)}}},
          {"standing", std::move(standing)},
          {"yaw_drift", {{"rad_per_s", standing_.yaw_drift()}, {"limit", standing_.yaw_drift_limit()}}},
          {"beyond", std::move(beyond)},
          {"sensors", std::move(sensors)},
          {"guard", {{"changes", std::move(guard)}, {"fallen_unnoticed_s", fallen_unnoticed_}}},
          {"heat", hottest_},
          {"plans", {{"outcomes", outcomes}, {"refused", reasons}, {"commands", std::move(commands)}}},
          {"findings", std::move(findings)}};
}

}  // namespace baton::shadow
