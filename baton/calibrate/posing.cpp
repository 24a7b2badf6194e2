#include "baton/calibrate/posing.hpp"

#include <utility>

namespace baton {
namespace {

constexpr double kPatience = 1.0;  ///< for a motion to begin; then it counts as refused [s]
constexpr double kHold = 0.2;      ///< time at rest after which the way home has ended [s]
constexpr double kSettle = 0.7;    ///< rest before it is measured [s]
constexpr double kMeasure = 0.5;   ///< [s]

/// A motion by a stick that is held until it begins, and whether the rest after it is measured.
struct Move {
  Command command;
  bool measured = true;
};

std::vector<Move> all_moves() {
  std::vector<Move> all;
  const auto guide = [&all](Part part, const Vec6& axes, double lift = 0.0) {
    Command command;
    command.guide = part;
    command.axes = axes;
    if (is_foot(part)) command.lift[side_of(part)] = lift;
    all.push_back({command});
  };
  const auto trunk = [&](const Vec6& axes) { guide(Part::trunk, axes); };
  const auto home = [&all](bool measured) {
    Command command;
    command.recall = Recall::home;
    all.push_back({command, measured});
  };
  // Ahead and to the left, low and leaning; back; to the right, high, leaning otherwise; to the middle.
  const auto shift_around = [&] {
    trunk({0.6, 0.5, -0.8, 0, 0.5, 0.4});
    trunk({-1, 0, 0.5, 0, 0, -0.7});
    trunk({0, -1, 1, 0.4, -0.9, 0.3});
    trunk({0.5, 0.4, 0.6, -0.4, 0.4, 0});
  };
  trunk(Vec6::Zero());
  shift_around();
  for (const Side side : kSides) {
    const double out = sign_of(side);
    guide(foot(side), Vec6::Zero(), 1.0);
    guide(foot(side), {1, out, 0, 0, 0, 0});
    guide(foot(side), {1, 0.4 * out, 0, 0, 0, out});
    shift_around();
    if (side == Side::left) home(false);
  }
  guide(Part::left_foot, {0, 1, 0, 0, 0, 0});
  trunk({0, -0.5, -0.8, 0, 0, -0.4});
  home(true);
  return all;
}

const std::vector<Move>& list() {
  static const std::vector<Move> all = all_moves();
  return all;
}

}  // namespace

int Posing::moves() {
  return static_cast<int>(list().size());
}

void Posing::begin(Doing doing) {
  doing_ = doing;
  ticks_ = 0;
}

void Posing::next() {
  ++tried_;
  begin(Doing::ask);
}

Command Posing::decide(const View& view) {
  if (done()) return {};
  const Move& move = list()[static_cast<std::size_t>(tried_)];
  const bool resting = view.navigator.motion() == nullptr;
  const long committed = view.navigator.committed();
  Command released = move.command;
  released.axes.setZero();
  released.recall = Recall::none;
  const double lasted = static_cast<double>(ticks_++) * robot_->profile().tick.period;
  switch (doing_) {
    case Doing::ask:
      if (ticks_ == 1) committed_ = committed;
      if (committed > committed_ || move.command.neutral()) {
        begin(Doing::settle);
      } else if (lasted < kPatience) {
        return move.command;
      } else {
        next();
      }
      break;
    case Doing::settle:
      if (!resting) ticks_ = 0;
      if (lasted < kHold && move.command.recall != Recall::none) return move.command;
      if (lasted < kSettle) break;
      if (!move.measured) {
        next();
        break;
      }
      begin(Doing::measure);
      mean_ = {};
      break;
    case Doing::measure:
      if (!resting) begin(Doing::settle);  // it had to balance
      break;
  }
  return released;
}

void Posing::on_tick(const TickRecord& record) {
  const BySide<bool>& contact = record.navigator.sample().contact;
  moved_ = moved_ || !contact.left || !contact.right || find_event<Slipped>(record.navigator.events()) != nullptr;
  if (doing_ != Doing::measure) return;
  mean_.add(record.measurement);
  if (mean_.size() * robot_->profile().tick.period < kMeasure) return;
  if (std::exchange(moved_, false)) ++stance_;
  rests_.push_back(mean_.mean());
  rests_.back().contact = contact;
  rests_.back().stance = stance_;
  next();
}

}  // namespace baton
