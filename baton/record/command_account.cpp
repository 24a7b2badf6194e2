#include "baton/record/command_account.hpp"

#include <algorithm>

#include "baton/guide/command.hpp"

namespace baton {
namespace {

constexpr double kMovedShare = 0.25;  ///< fraction of the request that counts as moved
constexpr double kMoved = 0.0192;     ///< displacement that always counts [COM height]: 5 mm for mighty

/// Component of `made` along `asked`; 0 if `asked` is zero.
double along(const Vec3& asked, const Vec3& made) {
  return asked.isZero(0.0) ? 0.0 : asked.dot(made) / asked.norm();
}

}  // namespace

Pose guided_pose(const Kinematics& kinematics, Part part) {
  if (is_foot(part)) return kinematics.sole(side_of(part));
  if (is_hand(part)) return kinematics.hand(side_of(part));
  return {kinematics.com(), kinematics.trunk().R};
}

bool CommandAccount::Interval::moved(double always) const {
  const double wanted = asked.norm();
  const double wanted_rotation = asked_rotation.norm();
  return (wanted > 0.0 && (most >= kMovedShare * wanted || most >= always)) ||
         (wanted_rotation > 0.0 && most_rotation >= kMovedShare * wanted_rotation);
}

std::optional<CommandAccount::Interval> CommandAccount::asked(const Command& command, bool lifts,
                                                              const Mat3& heading) const {
  const Profile& profile = robot_->profile();
  if (command.recall != Recall::none || command.neutral() || (command.axes.isZero(0.0) && !lifts)) return std::nullopt;
  const Vec6 requested = requested_move(*robot_, command);
  Vec3 move = requested.head<3>();
  const Vec3 turn = requested.tail<3>();
  if (is_foot(command.guide)) {
    const double lift = command.lift[side_of(command.guide)];
    move.z() = lift < kLeastLift ? 0.0 : lift * profile.swing.lift;
  }
  if (move.isZero(0.0) && turn.isZero(0.0)) return std::nullopt;
  Interval interval;
  interval.command = command;
  interval.asked = heading * move;
  interval.asked_rotation = heading * turn;
  return interval;
}

void CommandAccount::account(const Credit& credit, const Kinematics& truth, bool over) {
  Interval& interval = intervals_[credit.command];
  const Pose now = guided_pose(truth, interval.command.guide);
  const double made = interval.made + along(interval.asked, now.p - credit.start.p);
  const double rotation =
      interval.made_rotation + along(interval.asked_rotation, rotation_error(now.R, credit.start.R));
  interval.most = std::max(interval.most, made);
  interval.most_rotation = std::max(interval.most_rotation, rotation);
  if (!over) return;
  interval.made = made;
  interval.made_rotation = rotation;
}

void CommandAccount::add(const TickRecord& record, const Kinematics& truth) {
  const Navigator& nav = record.navigator;
  const bool begins = find_event<Committed>(nav.events()) != nullptr;
  const Command& command = nav.command();
  if (!(command == last_command_)) {
    // A throttle held up asks for nothing new.
    const bool lifts =
        is_foot(command.guide) && command.lift[side_of(command.guide)] != last_command_.lift[side_of(command.guide)];
    const Mat3 heading = nav.anchor().R * rotation_z(mean_yaw(nav.sample().sole));
    const std::optional<Interval> interval = asked(command, lifts, heading);
    if (interval) intervals_.push_back(*interval);
    command_ = interval ? static_cast<long>(intervals_.size()) - 1 : -1;
    last_command_ = command;
  }
  std::erase_if(open_, [&](const Credit& credit) {
    const bool again = begins && static_cast<long>(credit.command) == planned_by_;
    const bool over = again || record.t >= credit.until - 0.5 * robot_->profile().tick.period;
    account(credit, truth, over);
    return over;
  });
  if (!begins || planned_by_ < 0) return;
  const auto by = static_cast<std::size_t>(planned_by_);
  open_.push_back({by, guided_pose(truth, intervals_[by].command.guide), record.t + nav.motion()->duration()});
}

void CommandAccount::answered(const Request& request) {
  const Intent& asked = request.intents.front();
  planned_by_ = std::holds_alternative<Follow>(asked) || std::holds_alternative<Catch>(asked) ? command_ : -1;
}

nlohmann::json CommandAccount::json() const {
  const auto moved = std::count_if(
      intervals_.begin(), intervals_.end(),
      [always = kMoved * robot_->profile().stance.com_height](const Interval& i) { return i.moved(always); });
  return {{"given", intervals_.size()}, {"moved", moved}};
}

}  // namespace baton
