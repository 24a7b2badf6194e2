#include "baton/plan/strategy.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

namespace baton {
namespace {

constexpr int kShrinkings = 3;            ///< bisections of the share of the target
constexpr std::size_t kAxesTried = 3;     ///< single axes tried when nothing along the direction is feasible
constexpr double kLeastProgress = 0.05;   ///< least displacement of a shrunk motion, fraction of the part's reach
constexpr double kEarliestLanding = 0.5;  ///< fraction of the remaining flight after which a foot may land, to stop
constexpr double kLeastArms = 0.01;       ///< least motion of a joint for which arms move in part [rad]
constexpr double kLongestArms = 10.0;     ///< time after which they have moved that far [s]
constexpr double kStepAside = 0.1;        ///< DCM excess from which a step aside is also tried [COM height]

/// Turns a planner's result into an answer to a request.
std::variant<std::monostate, PlannedMotion, Refusal> outcome_of(PlanResult planned) {
  if (auto* motion = std::get_if<PlannedMotion>(&planned)) return std::move(*motion);
  return std::get<Refusal>(std::move(planned));
}

/// The trail of the motion that replaces or follows the executed one; null if there is none.
std::shared_ptr<const Trail> trail_with(const Start& start, const Motion& motion) {
  if (start.sample < 0) return std::make_shared<const Trail>(trail_of(start.posture, motion));
  if (!start.trail) return nullptr;
  return std::make_shared<const Trail>(continued(*start.trail, start.sample, motion));
}

/// What goals are relative to once a motion that began in `context` has ended.
GuideContext context_at(const Posture& end, const GuideContext& context) {
  GuideContext there{end, context.anchor, context.last_step, context.foothold};
  there.com_offset = context.com_offset;
  there.place_uncertainty = context.place_uncertainty;
  return there;
}

}  // namespace

Strategy::Strategy(const RobotModel& robot, const World& world, Modes modes)
    : robot_(&robot),
      modes_(modes),
      guide_(robot, world),
      planner_(robot, world, modes.duration),
      normal_(Limits::normal(robot.profile())),
      uneven_ground_(Limits::uneven_ground(robot.profile())),
      push_recovery_(Limits::push_recovery(robot.profile())) {}

Answer Strategy::plan(const Request& request) {
  for (Limits* limits : {&normal_, &uneven_ground_, &push_recovery_})
    limits->com_offset = request.start.context.com_offset;
  if (request.intents.empty()) return attempt(request, intent_of(request.command));
  Answer answer;
  std::optional<Refusal> with_arms;
  for (const Intent& intent : request.intents) {
    answer = attempt(request, intent);
    if (answer.motion() != nullptr) break;
    const auto* follows = std::get_if<Follow>(&intent);
    if (follows != nullptr && follows->arms && answer.refusal() != nullptr) with_arms = *answer.refusal();
  }
  if (answer.motion() != nullptr) answer.arms_rest = std::move(with_arms);
  return answer;
}

Answer Strategy::attempt(const Request& request, const Intent& intent) {
  if (const auto* capture = std::get_if<Catch>(&intent)) return attempt_capture(request, *capture);
  Answer answer{request.at, intent, request.command, request.start.context, {}, request.start.trail};
  if (stops(answer.intent)) answer.command.recall = Recall::stop;
  if (const auto* halt = std::get_if<HaltAt>(&intent)) {
    answer.outcome = this->halt(request, halt->rest);
    if (answer.motion() != nullptr) answer.trail = std::make_shared<const Trail>(trail_to(*answer.trail, halt->rest));
  } else if (std::holds_alternative<Retrace>(intent)) {
    answer.outcome = go_back(request, answer.trail);
  } else if (std::holds_alternative<MoveArms>(intent)) {
    answer.outcome = move_arms(request);
    if (answer.motion() != nullptr) answer.trail = trail_with(request.start, *answer.motion());
  } else if (std::holds_alternative<Cool>(intent)) {
    answer.outcome = cool(request);
    if (answer.motion() != nullptr) answer.trail = trail_with(request.start, *answer.motion());
  } else if (const auto* alone = std::get_if<Follow>(&intent); alone != nullptr && !alone->arms) {
    Request without = request;
    auto path = std::make_shared<ArmPath>(*request.arms);
    path->until.setZero();
    without.arms = std::move(path);
    return attempt(without, Follow{});
  } else {
    answer.outcome = follow_or_stop(request, stops(answer.intent));
    if (answer.motion() != nullptr) answer.trail = trail_with(request.start, *answer.motion());
  }
  return answer;
}

Answer Strategy::attempt_capture(Request request, const Catch& capture) {
  request.command = Command{.guide = request.command.guide};
  GuideContext& context = request.start.context;
  context.anchor.p.z() = capture.height;
  if (context.step) context.step->to.p.head<2>() -= capture.moved;
  Answer answer{request.at, capture, request.command, context, catch_step(request, capture), request.start.trail};
  if (answer.motion() != nullptr) answer.trail = trail_with(request.start, *answer.motion());
  return answer;
}

Strategy::Outcome Strategy::follow_or_stop(const Request& request, bool stops) {
  const auto with = [&](const Limits& limits) { return stops ? stop(limits, request) : follow(limits, request); };
  if (request.terrain.uneven) {
    Outcome outcome = with(uneven_ground_);
    if (!std::holds_alternative<Refusal>(outcome)) return outcome;
  }
  Outcome outcome = with(normal_);
  const auto* refusal = std::get_if<Refusal>(&outcome);
  if (refusal == nullptr || stops) return outcome;
  std::optional<PlannedMotion> step = closing_step(request, *refusal);
  if (!step) return outcome;
  step->limit = *refusal;
  return *std::move(step);
}

Strategy::Outcome Strategy::follow(const Limits& limits, const Request& request) {
  const GuideContext& context = request.start.context;
  Outcome whole = resolve(limits, request, guide_.goals(context, request.command));
  const auto* refusal = std::get_if<Refusal>(&whole);
  const std::optional<Target> target = guide_.target(context, request.command);
  if (modes_.on_limit == OnLimit::discard || refusal == nullptr || !target) return whole;
  std::optional<PlannedMotion> part = shrunk(limits, request, *target, *refusal);
  if (!part) return whole;
  part->limit = *refusal;
  return *std::move(part);
}

Strategy::Outcome Strategy::resolve(const Limits& limits, const Request& request, GuideResult guided) {
  if (auto* refusal = std::get_if<Refusal>(&guided)) return std::move(*refusal);
  const auto* goals = std::get_if<std::vector<Goal>>(&guided);
  if (goals == nullptr) return std::monostate{};
  return outcome_of(first_of(limits, *goals, request));
}

Strategy::Outcome Strategy::go_back(const Request& request, std::shared_ptr<const Trail>& remaining) {
  if (!request.start.trail) return Refusal{Reason::no_history, Part::trunk, 0, 0, ""};
  const Trail& trail = *request.start.trail;
  const Heat& heat = request.start.posture.heat;
  PlanResult planned = planner_.retrace(trail, request.start.context.anchor, normal_, heat);
  if (auto* refusal = std::get_if<Refusal>(&planned)) {
    if (modes_.on_limit == OnLimit::discard) return std::move(*refusal);
    std::optional<Planner::PartOfWay> part =
        planner_.retrace_part(trail, request.start.context.anchor, normal_, *refusal, heat);
    if (!part) return std::move(*refusal);
    remaining = std::make_shared<const Trail>(trail_to(trail, part->halt));
    planned = std::move(part->planned);
  }
  auto& back = std::get<PlannedMotion>(planned);
  if (std::optional<Refusal> tips = no_stance(*back.motion, request)) return *std::move(tips);
  return std::move(back);
}

Strategy::Outcome Strategy::stop(Limits limits, const Request& request) {
  const GuideContext& context = request.start.context;
  const bool rests = request.start.sample < 0;  // with a foot in the air, to be put down
  GuideResult ways = rests ? guide_.goals(context, Command{.guide = request.command.guide}) : guide_.stops(context);
  if (auto* refusal = std::get_if<Refusal>(&ways)) return std::move(*refusal);
  Outcome outcome =
      rests ? resolve(limits, request, ways) : quickest(limits, std::get<std::vector<Goal>>(ways), request);
  const bool hot = hottest(request.start.posture.heat).total >= kHot;
  if (!hot || !std::holds_alternative<Refusal>(outcome) || limits.heat >= push_recovery_.heat) return outcome;
  limits.heat = push_recovery_.heat;  // to stay on the way, or on one foot, would be hotter
  return stop(limits, request);
}

Strategy::Outcome Strategy::catch_step(const Request& request, const Catch& capture) {
  const GuideContext& context = request.start.context;
  const bool step_aside = capture.dcm_excess > kStepAside * robot_->profile().stance.com_height;
  const GuideResult guided = guide_.capture_steps(context, capture.by, step_aside);
  const auto* goals = std::get_if<std::vector<Goal>>(&guided);
  if (goals == nullptr) return std::monostate{};
  // The excess grows until touchdown; there the foothold adjustment is subtracted.
  const auto excess_at = [&](double t, double adjustment) {
    return capture.dcm_excess * std::exp(robot_->omega() * t) - adjustment;
  };
  const Vec2 direction = capture.by.normalized();
  const Profile::Tick& tick = robot_->profile().tick;
  double best_excess =
      capture.lands_in ? excess_at(*capture.lands_in, capture.gain) : std::numeric_limits<double>::infinity();
  Outcome best;
  for (const Goal& goal : *goals) {
    Outcome outcome = quickest(push_recovery_, {goal}, request);
    const auto* planned = std::get_if<PlannedMotion>(&outcome);
    if (planned == nullptr) continue;
    const Side side = *goal.swing;
    const Pose& before = context.step ? context.step->to : context.from.sole[other(side)];
    const double adjustment = (goal.sole[side].p - before.p).head<2>().dot(direction);
    const double excess = excess_at((tick.lookahead + planned->motion->last_phase()) * tick.period, adjustment);
    if (excess >= best_excess) continue;
    best_excess = excess;
    best = std::move(outcome);
    if (excess < 0.0) break;
  }
  return best;
}

Strategy::Outcome Strategy::quickest(const Limits& limits, const std::vector<Goal>& goals, const Request& request) {
  std::vector<Posture> starts{request.start.posture};
  if (request.start.posture.flight) {  // the foot may also land earlier than planned
    Flight& flight = *starts.emplace_back(request.start.posture).flight;
    const double remaining = std::max(least_flight(robot_->profile()), kEarliestLanding * flight.remaining);
    flight.to_apex *= remaining / flight.remaining;
    flight.remaining = remaining;
  }
  std::optional<PlannedMotion> best;
  std::optional<Refusal> against;
  for (const Goal& goal : goals) {
    for (const Posture& start : starts) {
      PlanResult planned = planner_.plan(start, goal, request.start.context.anchor, limits, DurationRule::search);
      if (auto* found = std::get_if<PlannedMotion>(&planned)) {
        if (!best || found->motion->ticks() < best->motion->ticks()) best = std::move(*found);
      } else if (!against) {
        against = std::get<Refusal>(std::move(planned));
      }
    }
  }
  if (best) return *std::move(best);
  return *std::move(against);
}

Strategy::Outcome Strategy::cool(const Request& request) {
  std::optional<PlannedMotion> planned = straightened(normal_, request.start.posture, request.start.context);
  if (!planned) {
    Limits limits = normal_;
    limits.heat = push_recovery_.heat;  // to stay would be hotter
    planned = straightened(limits, request.start.posture, request.start.context);
  }
  if (!planned) return std::monostate{};
  return *std::move(planned);
}

Strategy::Outcome Strategy::move_arms(const Request& request) {
  Goal goal = request.goal ? *request.goal : guide_.staying(request.start.context, request.command.guide);
  goal.arm_path = request.arms;
  if (!request.goal && request.arms) goal.duration = request.arms->duration;
  PlanResult whole = first_of(normal_, {goal}, request);
  const auto* against = std::get_if<Refusal>(&whole);
  if (against == nullptr || request.goal || !request.arms) return outcome_of(std::move(whole));
  // Not all of it: both arms for a shorter time, or one of them.
  const auto planned = [&](const BySide<double>& until) -> std::optional<PlannedMotion> {
    auto path = std::make_shared<ArmPath>(*request.arms);
    double most = 0.0;
    path->duration = 0.0;
    for (std::size_t k = 0; k < path->joints.size(); ++k) {
      const auto row = static_cast<Eigen::Index>(k);
      const std::vector<int>& left = robot_->arm(Side::left);
      const Side side = std::ranges::find(left, path->joints[k]) != left.end() ? Side::left : Side::right;
      path->until[row] = std::min(path->until[row], until[side]);
      path->duration = std::max(path->duration, std::min(path->until[row] + path->braking, request.arms->duration));
      most = std::max(most, std::abs(path->at(row, kLongestArms, kLongestArms) - path->q(row, 0)));
    }
    if (most < kLeastArms) return std::nullopt;
    goal.duration = path->duration;
    goal.arm_path = std::move(path);
    PlanResult part = first_of(normal_, {goal}, request);
    auto* motion = std::get_if<PlannedMotion>(&part);
    if (motion == nullptr) return std::nullopt;
    motion->limit = *against;
    return std::move(*motion);
  };
  const double sooner = against->t - request.arms->braking - 2.0 * request.arms->period;
  const double far = std::numeric_limits<double>::infinity();
  for (const BySide<double>& until : {BySide<double>{sooner, sooner}, {far, 0.0}, {0.0, far}}) {
    if (std::max(until.left, until.right) <= 0.0) continue;
    if (std::optional<PlannedMotion> part = planned(until)) return *std::move(part);
  }
  return *against;
}

Strategy::Outcome Strategy::halt(const Request& request, const TrailRest& rest) {
  const Start& start = request.start;
  return outcome_of(planner_.halt(start.posture, *start.trail, rest, start.context.anchor, normal_));
}

std::optional<PlannedMotion> Strategy::shrunk(const Limits& limits, const Request& request, const Target& whole,
                                              const Refusal& against) {
  const GuideContext& context = request.start.context;
  std::optional<PlannedMotion> best;
  const auto accepted = [&](GuideResult goals) {
    Outcome outcome = resolve(limits, request, std::move(goals));
    auto* planned = std::get_if<PlannedMotion>(&outcome);
    const bool better = planned != nullptr && worth(context.from, *planned->motion);
    if (better) best = std::move(*planned);
    return better;
  };
  const auto tried = [&](const Target& target) { return accepted(guide_.goals(context, target)); };
  double done = 0.0;
  double refused = 1.0;
  for (int k = 0; k < kShrinkings; ++k) {
    const double share = 0.5 * (done + refused);
    (tried(guide_.part_of(context, whole, share)) ? done : refused) = share;
  }
  if (best) return best;
  // Nothing along the direction is feasible, so try along the limit: a foot to the border of its region, or any part by
  // its largest axis alone, then the next.
  if (is_foot(whole.part)) {
    const Target within = guide_.within_region(context, whole);
    if (within.move.head<2>().dot(whole.move.head<2>()) > 0.0 && tried(within)) return best;
    const bool edge = against.reason == Reason::ground;
    // A foot that is guided towards the other does not push it away.
    const bool too_near = against.where == "sideways" && against.value < against.limit;
    const bool too_far = against.reason == Reason::foot_region && !too_near;
    if (edge && accepted(guide_.nearest_step(context, whole))) return best;
    if ((edge || too_far) && accepted(guide_.other_foot_first(context, whole))) return best;
  }
  std::vector<Target> singles = guide_.single_axes(whole);
  singles.resize(std::min(singles.size(), kAxesTried));
  for (const Target& single : singles) {
    if (tried(single)) return best;
  }
  return std::nullopt;
}

std::optional<PlannedMotion> Strategy::closing_step(const Request& request, const Refusal& against) {
  const GuideContext& context = request.start.context;
  const std::optional<Target> target = guide_.target(context, request.command);
  const bool from_rest = request.start.sample < 0;
  if (modes_.on_limit == OnLimit::discard || !from_rest || !target || target->part != Part::trunk) return std::nullopt;
  const Vec3 move = target->move.head<3>();
  const bool along = std::abs(move.x()) > std::max(std::abs(move.y()), std::abs(move.z()));
  if (!along || against.reason == Reason::ground) return std::nullopt;
  const std::vector<Goal> steps = guide_.closing_steps(context, move.x() > 0.0);
  if (steps.empty()) return std::nullopt;
  PlanResult planned = first_of(normal_, steps, request);
  auto* found = std::get_if<PlannedMotion>(&planned);
  return found != nullptr ? std::optional(std::move(*found)) : std::nullopt;
}

bool Strategy::worth(const Posture& from, const Motion& motion) const {
  const Part part = motion.goal.guided;
  const Vec6 least = kLeastProgress * reach_of(*robot_, part);
  const auto pose = [&](const Posture& posture) -> Pose {
    if (is_foot(part)) return posture.sole[side_of(part)];
    if (is_hand(part)) return posture.hand[side_of(part)];
    return {posture.com, posture.trunk};
  };
  const Pose a = pose(from);
  const Pose b = pose(motion.end);
  return (b.p - a.p).norm() >= least[0] || rotation_error(b.R, a.R).norm() >= least[3];
}

PlanResult Strategy::first_of(const Limits& limits, const std::vector<Goal>& goals, const Request& request) {
  std::optional<Refusal> against;
  for (Goal goal : goals) {
    if (!goal.arm_path) goal.arm_path = request.arms;
    PlanResult planned = planner_.plan(request.start.posture, goal, request.start.context.anchor, limits);
    if (auto* found = std::get_if<PlannedMotion>(&planned)) {
      std::optional<Refusal> against_it = no_stance(*found->motion, request);
      if (!against_it) against_it = no_landing(*found->motion, request.start.context);
      // A foot that has to come down does so wherever it rests then.
      if (!against_it && goal.kind != SegmentKind::lower)
        against_it = no_cooling(*found->motion, request.start.context);
      if (!against_it) return planned;
      planned = *std::move(against_it);
    }
    if (!against) against = std::get<Refusal>(planned);
  }
  return *against;
}

std::optional<Refusal> Strategy::no_stance(const Motion& motion, const Request& request) {
  if (!request.terrain.inclined) return std::nullopt;
  const Side side = request.terrain.inclined->side;
  const bool alone = std::any_of(motion.samples.begin(), motion.samples.end(), [side](const MotionSample& sample) {
    return sample.contact[side] && !sample.contact[other(side)];
  });
  if (!alone) return std::nullopt;
  return Refusal{Reason::inclined_sole, foot(side), request.terrain.inclined->angle, kFlatSole, ""};
}

std::optional<Refusal> Strategy::no_landing(const Motion& motion, const GuideContext& context) {
  Posture end = motion.end;
  if (end.contact.left && end.contact.right) return std::nullopt;
  end.heat = at_least(std::move(end.heat), kHot);  // at the latest then it lands
  const Side up = end.contact.left ? Side::right : Side::left;
  GuideResult landings = guide_.landings(context_at(end, context), up);
  std::optional<Refusal> against;
  if (const auto* goals = std::get_if<std::vector<Goal>>(&landings)) {
    for (const Goal& goal : *goals) {
      PlanResult planned = planner_.plan(end, goal, context.anchor, normal_);
      std::optional<Refusal> against_it;
      if (const auto* found = std::get_if<PlannedMotion>(&planned)) {
        against_it = no_cooling(*found->motion, context);
        if (!against_it) return std::nullopt;
      } else {
        against_it = std::get<Refusal>(planned);
      }
      if (!against) against = std::move(against_it);
    }
  } else {
    against = std::get<Refusal>(landings);
  }
  return refusal_by(Reason::no_landing, *against);
}

std::optional<Refusal> Strategy::no_cooling(const Motion& motion, const GuideContext& context) {
  if (!motion.end.contact.left || !motion.end.contact.right || motion.held.total <= 1.0) return std::nullopt;
  Posture end = motion.end;
  end.heat = at_least(std::move(end.heat), kHot);  // at the latest then it stands straighter
  if (straightened(normal_, end, context_at(end, context))) return std::nullopt;
  const auto joint = static_cast<std::size_t>(motion.held.joint);
  return Refusal{Reason::motor_heat, Part::trunk, motion.held.total, 1.0, robot_->joints()[joint].name};
}

std::optional<PlannedMotion> Strategy::straightened(const Limits& limits, const Posture& rest,
                                                    const GuideContext& context) {
  for (const Goal& goal : guide_.straighter(context)) {
    PlanResult planned = planner_.plan(rest, goal, context.anchor, limits);
    auto* found = std::get_if<PlannedMotion>(&planned);
    if (found != nullptr && found->motion->held.total <= 1.0) return std::move(*found);
  }
  return std::nullopt;
}

}  // namespace baton
