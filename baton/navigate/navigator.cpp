#include "baton/navigate/navigator.hpp"

#include <algorithm>
#include <cmath>

#include "baton/ik/stand.hpp"

namespace baton {
namespace {

constexpr double kPatience = 0.05;     ///< from a refusal at rest to the next request [s]
constexpr int kShrinkings = 3;         ///< shares of a goal that are tried
constexpr std::size_t kAxesTried = 3;  ///< one by one, when nothing along the direction can be had
constexpr double kWorth = 0.05;        ///< least part of the guided part's reach that a shrunk motion makes
constexpr double kSlip = 0.2;          ///< jump of the planning frame that is a slip, of the reach of a foot
constexpr std::size_t kHistory = 200;  ///< motions that are kept to be retraced

}  // namespace

Planning::Planning(const RobotModel& robot, const World& world, Modes modes)
    : robot_(&robot), modes_(modes), guide_(robot, world), planner_(robot, world, modes.duration) {}

PlanningResult Planning::plan(const Problem& problem) {
  PlanningResult result{problem.take_over, problem.command, problem.context.anchor, std::monostate{}};
  if (problem.command.recall == Recall::retrace) {
    result.outcome = go_back(problem);
    return result;
  }
  result.outcome = resolve(problem.context, problem.command);
  if (const auto* refusal = std::get_if<Refusal>(&result.outcome)) {
    std::optional<Motion> part = modes_.on_limit == OnLimit::shrink ? shrunk(problem) : std::nullopt;
    if (part) {
      part->limit = *refusal;
      result.outcome = *std::move(part);
    }
  }
  return result;
}

Planning::Outcome Planning::resolve(const GuideContext& context, const Command& command) {
  GuideResult guided = guide_.goals(context, command);
  if (auto* refusal = std::get_if<Refusal>(&guided)) return std::move(*refusal);
  const auto* goals = std::get_if<std::vector<Goal>>(&guided);
  if (goals == nullptr) return std::monostate{};
  PlanResult planned = first_of(*goals, context);
  if (auto* motion = std::get_if<Motion>(&planned)) return std::move(*motion);
  return std::get<Refusal>(std::move(planned));
}

Planning::Outcome Planning::go_back(const Problem& problem) {
  if (!problem.trail) return Refusal{Reason::no_history, Part::trunk, 0, 0, ""};
  PlanResult planned = planner_.retrace(*problem.trail, problem.context.anchor);
  if (auto* motion = std::get_if<Motion>(&planned)) return std::move(*motion);
  return std::get<Refusal>(std::move(planned));
}

std::optional<Motion> Planning::shrunk(const Problem& problem) {
  const Posture& from = problem.context.from;
  const Command& command = problem.command;
  const bool both_stand = from.contact.left && from.contact.right;
  if (command.recall != Recall::none ||
      (!both_stand && (!is_foot(command.guide) || from.contact[side_of(command.guide)])))
    return std::nullopt;
  std::optional<Motion> best;
  const auto tried = [&](const Command& candidate) {
    Outcome outcome = resolve(problem.context, candidate);
    auto* motion = std::get_if<Motion>(&outcome);
    const bool better = motion != nullptr && worth(from, *motion);
    if (better) best = std::move(*motion);
    return better;
  };
  double done = 0.0;
  double refused = 1.0;
  for (int k = 0; k < kShrinkings; ++k) {
    const double share = 0.5 * (done + refused);
    (tried(guide_.shortened(problem.context, command, share)) ? done : refused) = share;
  }
  if (best) return best;
  // Nowhere along the direction: along the limit then, by the axis that asks for most, or the next.
  std::vector<int> axes = guide_.axes_of(command.guide);
  std::stable_sort(axes.begin(), axes.end(),
                   [&](int a, int b) { return std::abs(command.axes[a]) > std::abs(command.axes[b]); });
  axes.resize(std::min(axes.size(), kAxesTried));
  for (const int axis : axes) {
    Command one = command;
    one.axes.setZero();
    one.axes[axis] = command.axes[axis];
    if (one.axes[axis] != 0.0 && tried(one)) return best;
  }
  return std::nullopt;
}

bool Planning::worth(const Posture& from, const Motion& motion) const {
  const Profile::Reach& reach = robot_->profile().reach;
  const Part part = motion.goal.guided;
  const auto pose = [&](const Posture& posture) -> Pose {
    if (is_foot(part)) return posture.sole[side_of(part)];
    if (is_hand(part)) return posture.hand[side_of(part)];
    return {posture.com, posture.trunk};
  };
  const double size = is_foot(part) ? reach.foot : is_hand(part) ? reach.hand : reach.trunk;
  const Pose a = pose(from);
  const Pose b = pose(motion.end);
  return (b.p - a.p).norm() >= kWorth * size || rotation_error(b.R, a.R).norm() >= kWorth * reach.rotation;
}

PlanResult Planning::first_of(const std::vector<Goal>& goals, const GuideContext& context) {
  std::optional<Refusal> against;
  for (const Goal& goal : goals) {
    PlanResult planned = planner_.plan(context.from, goal, context.anchor);
    if (auto* motion = std::get_if<Motion>(&planned)) {
      if (can_land(*motion, context)) return planned;
      planned = Refusal{Reason::no_landing, goal.guided, 0, 0, ""};
    }
    if (!against) against = std::get<Refusal>(planned);
  }
  return *against;
}

bool Planning::can_land(const Motion& motion, const GuideContext& context) {
  const Posture& end = motion.end;
  if (end.contact.left && end.contact.right) return true;
  const Side up = end.contact.left ? Side::right : Side::left;
  const GuideResult landings = guide_.landings({end, context.anchor, context.last_step, context.foothold}, up);
  const auto* goals = std::get_if<std::vector<Goal>>(&landings);
  return goals != nullptr && std::any_of(goals->begin(), goals->end(), [&](const Goal& goal) {
           return std::holds_alternative<Motion>(planner_.plan(end, goal, context.anchor));
         });
}

Navigator::Navigator(const RobotModel& robot, const Posture& start)
    : robot_(&robot),
      estimator_(robot),
      stabiliser_(robot),
      posture_(start),
      held_(resting(robot, start)),
      sample_(&held_),
      foothold_(start.sole) {
  const VecX zero = VecX::Zero(robot.nv() - 6);
  soft_ = {zero, zero, zero, zero, {false, false}};
}

const JointTarget& Navigator::tick(const Measurement& measurement, const Command& command) {
  ++tick_;
  command_ = sanitised(command);
  if (refusal_ && !(command_ == refused_)) refusal_.reset();

  if (motion_ && ++index_ == motion_->ticks()) end_of_motion();
  take_over();

  sample_ = motion_ ? &motion_->samples[static_cast<std::size_t>(index_)] : &held_;
  const MotionSample& next = motion_ ? motion_->samples[static_cast<std::size_t>(index_) + 1] : held_;
  state_ = &estimator_.update(measurement, anchor_);
  if (fallen_) {
    soft_.q = measurement.q;
    return soft_;
  }
  return stabiliser_.target(*sample_, next, *state_);
}

std::optional<Problem> Navigator::request() {
  const int lookahead = robot_->profile().tick.lookahead;
  if (fallen_ || tick_ < 0 || asked_) return std::nullopt;
  if (motion_ && motion_->ticks() - index_ > lookahead) return std::nullopt;
  const BySide<bool>& stands = rest().contact;
  const bool a_foot_is_up = !stands.left || !stands.right;
  if (command_.neutral() && !a_foot_is_up) return std::nullopt;

  Problem due = problem(command_);
  if ((due.context.anchor.p - anchor_.p).norm() > kSlip * robot_->profile().reach.foot) {
    history_.clear();  // it slipped: what led here does not lead back
    due.trail.reset();
  }
  // What was refused would be refused again, from the same place.
  const bool same_place = (due.context.anchor.p - refused_at_.p).norm() < 1e-3;
  if (!motion_ && ((refusal_ && same_place) || tick_ < not_before_)) return std::nullopt;
  asked_ = due;
  return asked_;
}

Problem Navigator::problem(const Command& command) const {
  const Pose anchor = anchor_ * anchor_correction(sample_->sole, state_->sole, sample_->contact);
  return {tick_ + robot_->profile().tick.lookahead,
          command,
          {rest(), anchor, last_step_, foothold_},
          history_.empty() ? nullptr : history_.back()};
}

void Navigator::offer(PlanningResult result) {
  if (!asked_ || result.take_over != asked_->take_over || result.take_over <= tick_) return;
  offered_ = std::move(result);
}

void Navigator::end_of_motion() {
  posture_ = motion_->end;
  held_ = motion_->rest;
  motion_.reset();
}

void Navigator::take_over() {
  if (!asked_ || asked_->take_over > tick_) return;
  std::optional<PlanningResult> result = std::move(offered_);
  offered_.reset();
  asked_.reset();
  if (!result || motion_ || fallen_) return;
  if (auto* motion = std::get_if<Motion>(&result->outcome)) {
    commit(std::move(*motion), result->anchor);
  } else if (const auto* refusal = std::get_if<Refusal>(&result->outcome)) {
    if (!refusal_ || !(refused_ == result->command)) ++refused_in_a_row_;
    refusal_ = *refusal;
    refused_ = result->command;
    refused_at_ = result->anchor;
    not_before_ = tick_ + std::lround(kPatience / robot_->profile().tick.period);
  }
}

void Navigator::commit(Motion motion, const Pose& anchor) {
  if (motion.retraces) {
    history_.pop_back();
  } else {
    if (history_.size() == kHistory) history_.erase(history_.begin());
    history_.push_back(std::make_shared<const Trail>(trail_of(posture_, motion)));
  }
  refused_in_a_row_ = 0;
  motion_ = std::move(motion);
  index_ = 0;
  anchor_ = anchor;
  ++committed_;
  refusal_.reset();
  const Goal& goal = motion_->goal;
  for (const Side side : kSides) {
    if (goal.contact[side]) foothold_[side] = goal.sole[side];
  }
  if (goal.swing) last_step_ = *goal.swing;
}

void Navigator::fall() {
  fallen_ = true;
  motion_.reset();
  offered_.reset();
  asked_.reset();
  sample_ = &held_;
}

Phase Navigator::phase() const {
  if (fallen_) return Phase::fallen;
  if (!motion_) return Phase::hold;
  if (sample_->contact.left && sample_->contact.right) return Phase::double_support;
  return sample_->contact.left ? Phase::single_left : Phase::single_right;
}

}  // namespace baton
