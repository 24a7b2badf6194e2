#include "baton/link/target_check.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

namespace baton::link {
namespace {

constexpr double kBeyondRange = 0.1;  ///< of a joint that has been pushed there [rad]
constexpr double kFaster = 1.5;       ///< speed, of the no-load speed
constexpr double kStronger = 1.5;     ///< torque, of the stall torque
constexpr double kStep = 2.0;         ///< step of a target, of what the no-load speed does in a tick
constexpr double kSmallStep = 0.03;   ///< step that any joint may make [rad]

}  // namespace

std::optional<std::string> TargetCheck::reject(const Target& target, const VecX& q) {
  const double period = robot_->profile().tick.period;
  for (Eigen::Index i = 0; i < target.q.size(); ++i) {
    const Joint& joint = robot_->joints()[static_cast<std::size_t>(i)];
    const auto because = [&](const char* what, double value, const std::string& must) {
      return fmt::format("{}: {} {:.4g}: must be {}", joint.name, what, value, must);
    };
    const std::array<std::pair<const char*, double>, 3> all{
        {{"angle", target.q[i]}, {"speed", target.dq[i]}, {"torque", target.tau[i]}}};
    for (const auto& [what, value] : all) {
      if (!std::isfinite(value)) return because(what, value, "a finite number");
    }
    const double lowest = joint.position.lo - kBeyondRange;
    const double highest = joint.position.hi + kBeyondRange;
    if (target.q[i] < lowest || target.q[i] > highest)
      return because("angle", target.q[i], fmt::format("from {:.4g} to {:.4g} rad", lowest, highest));
    const double fastest = kFaster * joint.motor.no_load;
    if (std::abs(target.dq[i]) > fastest)
      return because("speed", target.dq[i], fmt::format("at most {:.4g} rad/s", fastest));
    const double strongest = kStronger * joint.motor.stall;
    if (std::abs(target.tau[i]) > strongest)
      return because("torque", target.tau[i], fmt::format("at most {:.4g} N·m", strongest));
    const double step = kSmallStep + kStep * joint.motor.no_load * period;
    const double jump = std::min(std::abs(target.q[i] - last_[i]), std::abs(target.q[i] - q[i]));
    if (!(jump <= step))
      return because("a jump to", target.q[i],
                     fmt::format("within {:.4g} rad of the target before, {:.4g}, or of where it is, {:.4g}", step,
                                 last_[i], q[i]));
  }
  last_ = target.q;
  return std::nullopt;
}

}  // namespace baton::link
