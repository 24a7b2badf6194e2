#include "baton/proving/stick.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "baton/input/script.hpp"

namespace baton {
namespace {

constexpr double kVisible = 0.05;

/// Probability of each style in percent; `pinned` has its own rule.
constexpr std::array<int, 11> kShare{22, 12, 12, 8, 8, 6, 0, 11, 7, 8, 6};
constexpr int kPinned = 6;  ///< percent of sticks that start pinned

}  // namespace

Stick::Stick(std::uint64_t seed, double period) : dice_(seed), period_(period) {}

DeviceStatus Stick::status() const {
  return {.name = "stick at random", .connected = true, .armed = true, .hint = ""};
}

bool Stick::deflected(const Command& command) {
  const Command c = sanitised(command);
  return c.axes.cwiseAbs().maxCoeff() > kVisible || (is_foot(c.guide) && c.lift[side_of(c.guide)] > kVisible);
}

Command Stick::next() {
  if (stretch_ == 0) begin_stretch();
  if (hold_ == 0) {
    draw();
    hold_ = std::min(hold_, stretch_);
    // Release only if deflected enough before.
    if (!deflected(command_) && 4 * deflected_ < 3 * (ticks_ + hold_)) command_.axes[dice_.below(6)] = dice_.sign();
  }
  --stretch_;
  --hold_;
  Command command = command_;
  if (until_away_-- == 0) {
    away_ = ticks(25, 100);
    if (style_ == Style::pinned || 4 * deflected_ < 3 * (ticks_ + away_)) away_ = 0;
    until_away_ = away_ + ticks(60, 400);
  }
  if (away_ > 0) {
    --away_;
    command = Command{};
    command.guide = command_.guide;
  }
  ++ticks_;
  deflected_ += deflected(command) ? 1 : 0;
  return command;
}

int Stick::ticks(int milliseconds_lo, int milliseconds_hi) {
  return std::max(1, static_cast<int>(std::lround(1e-3 * dice_.between(milliseconds_lo, milliseconds_hi) / period_)));
}

void Stick::begin_stretch() {
  hold_ = 0;
  int roll = dice_.below(100);
  std::size_t chosen = 0;
  while (roll >= kShare[chosen])
    roll -= kShare[chosen++];
  style_ = static_cast<Style>(chosen);
  if (first_ && dice_.percent(kPinned)) style_ = Style::pinned;
  first_ = false;
  if (dice_.percent(50)) command_.guide = kParts[static_cast<std::size_t>(dice_.below(5))];
  if (dice_.percent(40))
    command_.lift = dice_.percent(45) ? BySide<double>{0.0, 0.0} : BySide<double>{lever(), lever()};
  pace_ = dice_.percent(50) ? dice_.between(1, 20) : dice_.between(20, 200);
  command_.axes = axes();
  command_.recall = Recall::none;
  switch (style_) {
    case Style::recall:
      stretch_ = ticks(300, 6000);
      command_.recall = dice_.percent(60) ? Recall::retrace : dice_.percent(50) ? Recall::home : Recall::stop;
      break;
    case Style::calm:
      stretch_ = ticks(2000, 6000);
      wish();
      break;
    case Style::pinned:
      stretch_ = ticks(60000, 180000);
      if (dice_.percent(50)) wish();
      break;
    case Style::centred:
      stretch_ = ticks(100, 3000);
      break;
    default:
      stretch_ = ticks(1000, 8000);
  }
}

void Stick::draw() {
  const auto any_part = [this] { return kParts[static_cast<std::size_t>(dice_.below(5))]; };
  hold_ = stretch_;
  switch (style_) {
    case Style::calm:
    case Style::pinned:
    case Style::recall:
      return;  // unchanged since the start of the stretch
    case Style::full:
      hold_ = ticks(300, 4000);
      for (double& axis : command_.axes)
        axis = dice_.between(-1, 1);
      return;
    case Style::any:
      hold_ = ticks(300, 2000);
      if (dice_.percent(30)) command_.guide = any_part();
      command_.axes = axes();
      return;
    case Style::hectic:
      hold_ = dice_.between(1, 60);
      if (dice_.percent(30)) command_.guide = any_part();
      if (dice_.percent(20)) command_.lift = {lever(), lever()};
      command_.axes = axes();
      return;
    case Style::reversal:
      hold_ = pace_;
      command_.axes = -command_.axes;
      if (dice_.percent(10)) command_.axes[dice_.below(6)] = dice_.sign();
      return;
    case Style::modes:
      hold_ = 1;
      command_.guide = kParts[(static_cast<std::size_t>(command_.guide) + 1) % kParts.size()];
      return;
    case Style::throttles:
      hold_ = ticks(100, 2500);
      if (dice_.percent(60)) command_.guide = foot(dice_.percent(50) ? Side::left : Side::right);
      command_.lift = {lever(), lever()};
      command_.axes = dice_.percent(50) ? Vec6(Vec6::Zero()) : axes();
      return;
    case Style::broken:
      hold_ = dice_.between(1, 200);
      for (double& axis : command_.axes)
        axis = dice_.percent(50) ? strange() : dice_.axis();
      for (const Side side : kSides)
        command_.lift[side] = dice_.percent(50) ? strange() : lever();
      return;
    case Style::centred:
      command_.axes.setZero();
      return;
  }
}

/// One thing an operator might want.
void Stick::wish() {
  command_.axes.setZero();
  command_.lift = {0.0, 0.0};
  command_.guide = dice_.percent(40) ? Part::trunk : kParts[static_cast<std::size_t>(dice_.below(5))];
  const double size = dice_.between(1, 4) / 4.0;
  if (is_foot(command_.guide) && dice_.percent(25)) {
    command_.lift[side_of(command_.guide)] = size;
    return;
  }
  switch (dice_.below(8)) {
    case 0:  // any of the six
      command_.axes[dice_.below(6)] = dice_.sign() * size;
      break;
    case 1:  // turn
      command_.axes[5] = dice_.sign() * size;
      break;
    case 2:  // up, down
      command_.axes[2] = dice_.sign() * size;
      break;
    default:  // go
      command_.axes.head<2>() << dice_.between(-1, 1) * size, dice_.between(-1, 1) * size;
  }
}

Vec6 Stick::axes() {
  Vec6 axes = Vec6::Zero();
  switch (dice_.below(4)) {
    case 0:  // one
      axes[dice_.below(6)] = dice_.axis();
      break;
    case 1:  // the stick itself
      axes.head<2>() << dice_.axis(), dice_.axis();
      break;
    case 2:  // all
      for (double& axis : axes)
        axis = dice_.axis();
      break;
    default:  // all, at the stops
      for (double& axis : axes)
        axis = dice_.sign();
  }
  return axes;
}

double Stick::lever() {
  switch (dice_.below(5)) {
    case 0:
      return 0.5;
    case 1:
      return 1.0;
    case 2:
      return std::abs(dice_.axis());
    default:
      return 0.0;
  }
}

double Stick::strange() {
  constexpr double kInfinity = std::numeric_limits<double>::infinity();
  constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
  constexpr std::array<double, 14> values{kNan, kNan,   kInfinity, -kInfinity, 1e300, -1e300, 7.0,
                                          -3.0, 5e-324, -5e-324,   2.2e-308,   1e-9,  -0.0,   1.0000001};
  return values[static_cast<std::size_t>(dice_.below(values.size()))];
}

std::string stick_script(Device& stick, double period, long ticks) {
  std::string text;
  std::string last;
  for (long k = 0; k < ticks; ++k) {
    const double t = static_cast<double>(k) * period;
    const Command command = stick.read(t);
    std::string same = script_line(0.0, command);
    if (same == last) continue;
    last = std::move(same);
    text += script_line(t, command) + '\n';
  }
  return text + script_line(static_cast<double>(ticks) * period, Command{}) + '\n';
}

}  // namespace baton
