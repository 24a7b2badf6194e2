#include "baton/plan/planner.hpp"

#include <cmath>
#include <utility>

#include "baton/ik/moving.hpp"
#include "baton/ik/stand.hpp"
#include "baton/math/quintic.hpp"
#include "baton/plan/retrace.hpp"
#include "baton/plan/shortest.hpp"

namespace baton {
namespace {

constexpr int kCorrections = 2;          ///< iterations of the correction for the limbs' contribution to the ZMP
constexpr double kRestTolerance = 1e-5;  ///< joint error of inverse kinematics allowed at a rest while retracing [rad]
constexpr int kMostRests = 8;            ///< planned rests tried on a retrace path that fails as a whole
constexpr int kMostParts = 3;            ///< verified parts of a retrace path; each may cost as much as the whole
constexpr int kMostVain = 2;             ///< failures in a row after which a load counts as independent of the duration
constexpr double kJump = 2.0;  ///< acceleration from which that is certain of a joint [limit]; less varies by chance
// Search for the shortest duration.
constexpr double kOfOutward = 0.25;   ///< way from outer edges that a way back has to keep [`Limits::zmp_outward`]
constexpr double kGrowth = 1.2;       ///< least factor from a failed duration to the next
constexpr double kSlower = 1.5;       ///< the same after a failure that does not depend on time
constexpr int kHalvings = 3;          ///< bisections back towards the failed duration
constexpr double kResolution = 0.04;  ///< relative resolution of the bisection
constexpr int kDivisions = 3;         ///< steps from the default division to that of the shortest timing
constexpr int kMostFinishes = 6;      ///< durations realised at every tick

/// Factor on the duration that may help: speeds scale with 1/T, accelerations with 1/T².
double stretch_for(const Refusal& refusal) {
  const double excess = refusal.value / refusal.limit;
  switch (refusal.reason) {
    case Reason::joint_speed:
      return std::clamp(excess, 1.03, 2.0);
    case Reason::joint_acceleration:
    case Reason::joint_torque:
    case Reason::friction:
      return std::clamp(std::sqrt(excess), 1.05, 1.5);
    default:
      return mends_with_time(refusal.reason) ? 1.08 : 0.0;
  }
}

/// The part of a value that no duration changes, from those of two durations, if the rest scales with 1/T².
double constant_part(double T1, double first, double T2, double second) {
  return (T2 * T2 * second - T1 * T1 * first) / (T2 * T2 - T1 * T1);
}

/// From the refusals of two durations: whether a joint's torque or acceleration is too large at any duration. A jump of
/// the inverse kinematics is constant.
bool in_vain(double T1, const Refusal& first, double T2, const Refusal& second) {
  if (second.reason != first.reason || second.where != first.where) return false;
  const bool torque = first.reason == Reason::joint_torque;
  if (!torque && first.reason != Reason::joint_acceleration) return false;
  return constant_part(T1, first.value, T2, second.value) > (torque ? kTorqueTolerance : kJump) * second.limit;
}

/// Whether they let one doubt that any duration up to the longest helps: it is too short even for an acceleration that
/// falls with 1/T², an acceleration does not fall, or a torque stays too large.
bool doubtful(double T1, const Refusal& first, double T2, const Refusal& second, double longest) {
  const bool accelerates = second.reason == Reason::joint_acceleration;
  if (accelerates && T2 * std::sqrt(second.value / second.limit) > longest) return true;
  if (second.reason != first.reason || second.where != first.where) return false;
  if (accelerates) return second.value >= first.value;
  return second.reason == Reason::joint_torque && constant_part(T1, first.value, T2, second.value) > second.limit;
}

/// The first `ticks` of a reversed motion, continued by `end`.
Motion joined(const Motion& backwards, int ticks, Motion end) {
  Motion motion = std::move(end);
  motion.retraces = true;
  motion.leaves = ticks;
  motion.dq0 = backwards.dq0;
  motion.contact_before = backwards.contact_before;
  motion.heat = backwards.heat;
  motion.samples.insert(motion.samples.begin(), backwards.samples.begin(), backwards.samples.begin() + ticks);
  const std::vector<ContactPhase> phases = first_phases(backwards.phases, ticks);
  motion.phases.insert(motion.phases.begin(), phases.begin(), phases.end());
  return motion;
}

/// Whether the ZMP of a way back comes too near to an outer edge of a sole. A way that was planned as a capture step,
/// or for a robot that seemed to weigh elsewhere, leaves no room there. The verifier does not check this margin: plans
/// keep it by construction.
std::optional<Refusal> leans_out(const RobotModel& robot, const Motion& motion, const Limits& limits) {
  const double least = kOfOutward * limits.zmp_outward;
  for (std::size_t k = 0; k < motion.samples.size(); ++k) {
    const MotionSample& sample = motion.samples[k];
    const Vec2 zmp = sample.zmp + limits.com_offset;
    for (const Side side : kSides) {
      if (!sample.contact[side]) continue;
      const Pose& sole = sample.sole[side];
      const Vec3 from_sole = sole.R.transpose() * (Vec3(zmp.x(), zmp.y(), sole.p.z()) - sole.p);
      const double inside = outer_edge(robot, side) - sign_of(side) * from_sole.y();
      if (inside < least) {
        return Refusal{Reason::zmp,
                       motion.goal.guided,
                       inside,
                       least,
                       std::string(to_string(foot(side))),
                       static_cast<double>(k) * motion.period};
      }
    }
  }
  return std::nullopt;
}

}  // namespace

Planner::Planner(const RobotModel& robot, const World& world, DurationRule rule)
    : robot_(&robot), rule_(rule), survey_(robot), ik_(robot), kinematics_(robot), verifier_(robot, world) {}

PlanResult Planner::plan(const Posture& from, const Goal& goal, const Pose& anchor, const Limits& limits,
                         DurationRule rule) {
  if (!goal.com.allFinite() || !goal.trunk.allFinite()) return Refusal{Reason::not_finite, goal.guided, 0, 0, ""};
  const Segment segment(*robot_, from, goal, limits, part_rates(kinematics_, from));
  Task task{segment, anchor};
  return rule == DurationRule::paper ? by_paper(task) : by_search(task);
}

PlanResult Planner::by_paper(Task& task) {
  const Profile::Duration& duration = robot_->profile().duration;
  const double period = robot_->profile().tick.period;
  std::optional<Failure> failure;
  double certain = 0.0;                              // shorter durations certainly fail
  std::optional<std::pair<double, Refusal>> before;  // last duration that failed, and why
  int vain = 0;                                      // consecutive failures that indicate that no duration works
  int doubts = 0;                                    // the same, less certain: the longest decides, once
  bool looked = false;
  const auto attempt = [&](Task& at, double T) -> std::variant<PlannedMotion, Failure> {
    const int ticks = static_cast<int>(std::lround(T / period));
    Candidate candidate{timing_by_shares(at.segment.com().phases, ticks, period)};
    if (std::optional<Failure> fails = evaluate(at, candidate)) return *std::move(fails);
    return finish(at, candidate);
  };
  const double first = task.segment.first_duration();
  const double longest = first + std::floor((duration.max + 1e-9 - first) / duration.step) * duration.step;
  for (double T = first; T <= duration.max + 1e-9; T += duration.step) {
    if (T < certain) continue;
    std::variant<PlannedMotion, Failure> attempted = attempt(task, T);
    if (auto* planned = std::get_if<PlannedMotion>(&attempted)) return std::move(*planned);
    failure = std::get<Failure>(std::move(attempted));
    if (failure->stretch == 0.0) break;
    if (before) {
      const auto& [T1, against] = *before;
      vain = in_vain(T1, against, T, failure->refusal) ? vain + 1 : 0;
      doubts = doubtful(T1, against, T, failure->refusal, longest) ? doubts + 1 : 0;
    }
    if (vain == kMostVain) break;
    if (doubts == kMostVain && T + duration.step < longest && !std::exchange(looked, true)) {
      Task aside{task.segment, task.anchor};  // if the longest is feasible, the search goes on as if it was not tried
      std::variant<PlannedMotion, Failure> last = attempt(aside, longest);
      const auto* fails = std::get_if<Failure>(&last);
      if (fails != nullptr && fails->stretch > 0.0) return fails->refusal;
    }
    before = {T, failure->refusal};
    task.not_shorter = failure->refusal;
    if (failure->refusal.reason == Reason::joint_speed) certain = std::min(failure->stretch * T, duration.max);
  }
  return failure->refusal;
}

std::optional<Timing> Planner::timing(const Segment& segment, const Timing& shortest, int ticks) {
  const ComProblem& com = segment.com();
  const std::optional<std::size_t> swing = segment.swing_phase();
  const Timing by_shares = timing_by_shares(com.phases, ticks, shortest.period);
  Timing timing = by_shares;
  for (int k = 0; k <= kDivisions; ++k) {
    for (std::size_t i = 1; i + 1 < timing.border.size(); ++i) {
      const double stretched = 1.0 * shortest.border[i] * ticks / shortest.ticks();
      timing.border[i] =
          static_cast<int>(std::lround(by_shares.border[i] + (stretched - by_shares.border[i]) * k / kDivisions));
    }
    const auto swings = [&](const Timing& t) { return t.border[*swing + 1] - t.border[*swing]; };
    const bool long_enough = !swing || swings(timing) >= swings(shortest);
    if (long_enough && com_.path(com, timing)) return timing;
    if (!swing) break;
  }
  return std::nullopt;
}

PlanResult Planner::by_search(Task& task) {
  const Profile& profile = robot_->profile();
  const double period = profile.tick.period;
  const Part part = task.segment.goal().guided;
  const auto in_ticks = [&](double t) { return static_cast<int>(std::lround(t / period)); };
  const int longest = in_ticks(profile.duration.max);
  const std::optional<Flight>& flight = task.segment.from().flight;
  const double swing_time = flight ? flight->remaining : task.segment.limits().swing_time;
  const int least_swing = static_cast<int>(std::ceil(swing_time / period - 1e-9));
  const ComProblem& com = task.segment.com();
  // Shortest duration for the point mass, but at least that of a swing.
  const std::optional<Shortest> shortest =
      shortest_timing(com_, com, task.segment.swing_phase(), least_swing, longest, period);
  if (!shortest) {
    const Timing by_shares = timing_by_shares(com.phases, longest, period);
    const ZmpMargin zmp = zmp_margin(com, com_path(com, by_shares), by_shares);
    return Refusal{Reason::zmp, part, zmp.margin, com.margin, "point mass"};
  }
  int ticks = shortest->timing.ticks();
  if (ticks > least_swing + static_cast<int>(com.phases.size()) - 1)
    task.not_shorter = Refusal{Reason::zmp, part, 0, com.margin, "point mass"};
  ticks = std::max(ticks, least_swing);
  int failed = ticks - 1;
  // Lengthen until the survey passes, then bisect towards the last failure.
  Candidate candidate;
  const auto is_feasible = [&](int duration) {
    std::optional<Failure> failure = Failure{{Reason::zmp, part, 0, com.margin, ""}, kGrowth};
    if (std::optional<Timing> divided = timing(task.segment, shortest->timing, duration)) {
      candidate.timing = *std::move(divided);
      failure = evaluate(task, candidate);
    }
    if (failure) task.not_shorter = failure->refusal;
    return failure;
  };
  const auto longer = [&](double stretch) { return std::min(longest, static_cast<int>(std::ceil(ticks * stretch))); };
  // A quick motion leans farther out than a slow one, so more time may help against this too; one retry is enough.
  double chance = kSlower;
  const auto stretch_after = [&](const Failure& failure) {
    return failure.stretch > 0.0 ? failure.stretch : std::exchange(chance, 0.0);
  };
  while (const std::optional<Failure> failure = is_feasible(ticks)) {
    const double stretch = stretch_after(*failure);
    if (stretch == 0.0 || ticks == longest) return failure->refusal;
    failed = ticks;
    ticks = longer(std::max(stretch, kGrowth));
  }
  for (int k = 0; k < kHalvings && ticks - failed > kResolution * ticks; ++k) {
    const int middle = (ticks + failed) / 2;
    (is_feasible(middle) ? failed : ticks) = middle;
  }
  std::optional<Failure> failure;
  double least_stretch = 1.0 + kResolution;
  for (int k = 0; k < kMostFinishes; ++k, least_stretch *= least_stretch) {
    failure = is_feasible(ticks);
    if (!failure) {
      std::variant<PlannedMotion, Failure> finished = finish(task, candidate);
      if (auto* planned = std::get_if<PlannedMotion>(&finished)) return std::move(*planned);
      failure = std::get<Failure>(std::move(finished));
    }
    task.not_shorter = failure->refusal;
    const double stretch = stretch_after(*failure);
    if (stretch == 0.0 || ticks == longest) break;
    ticks = longer(std::max(stretch, least_stretch));
  }
  return failure->refusal;
}

PlanResult Planner::retrace(const Trail& trail, const Pose& anchor, const Limits& limits, const Heat& heat) {
  Motion back = reversed(*robot_, trail);
  back.heat = heat;
  std::variant<VerifiedMotion, Refusal> verdict = verifier_.verify(std::move(back), anchor, limits);
  if (auto* refusal = std::get_if<Refusal>(&verdict)) return std::move(*refusal);
  VerifiedMotion verified = std::get<VerifiedMotion>(std::move(verdict));
  if (std::optional<Refusal> tips = leans_out(*robot_, *verified, limits)) return *std::move(tips);
  return PlannedMotion{std::move(verified)};
}

PlanResult Planner::halt(const Posture& from, const Trail& trail, const TrailRest& halt, const Pose& anchor,
                         const Limits& limits) {
  const Trail::Piece& piece = trail.pieces[halt.piece];
  const Trail::Point& there = piece.points->back();
  Goal goal;
  goal.guided = piece.goal.guided;
  goal.sole = there.sole;
  goal.com = there.com;
  goal.trunk = posture_of(*robot_, there.q).trunk;
  goal.arms = there.q.tail(robot_->nv() - 6);
  PlanResult planned = plan(from, goal, anchor, limits, DurationRule::search);
  auto* found = std::get_if<PlannedMotion>(&planned);
  if (found == nullptr) return planned;
  Motion motion = *found->motion;
  VecX off(robot_->nv());
  difference(*robot_, off, 1.0, motion.end.q, there.q);
  const double most = off.cwiseAbs().maxCoeff();
  if (most > kRestTolerance)
    return Refusal{Reason::unreachable, goal.guided, most, kRestTolerance, "rest on the way back"};
  // The residual of inverse kinematics is spread along the path.
  for (int k = 1; k <= motion.ticks(); ++k)
    integrate(*robot_, motion.samples[static_cast<std::size_t>(k)].q, off, smooth_step(k, motion.ticks()).x);
  motion.samples.back().q = motion.end.q = there.q;
  motion.rest = resting(*robot_, motion.end);
  differentiate(*robot_, motion);
  std::variant<VerifiedMotion, Refusal> verdict = verifier_.verify(std::move(motion), anchor, limits);
  if (auto* refusal = std::get_if<Refusal>(&verdict)) return std::move(*refusal);
  found->motion = std::get<VerifiedMotion>(std::move(verdict));
  return planned;
}

std::optional<Planner::PartOfWay> Planner::retrace_part(const Trail& trail, const Pose& anchor, const Limits& limits,
                                                        Refusal against, const Heat& heat) {
  Motion whole = reversed(*robot_, trail);
  whole.heat = heat;
  const auto both_stand = [&](int k) {
    const MotionSample& sample = whole.samples[static_cast<std::size_t>(k)];
    return sample.contact.left && sample.contact.right;
  };
  const std::vector<TrailRest> rests = rests_on(trail);
  int tries = kMostRests;
  int verified = 0;
  double until = against.t;
  for (auto rest = rests.rbegin(); rest != rests.rend() && tries > 0; ++rest) {
    if (rest->passed * whole.period > until) continue;
    --tries;
    // From the last touchdown on both feet stand, and the robot may come to rest.
    int landed = rest->passed;
    while (landed > 0 && both_stand(landed - 1))
      --landed;
    for (const int leaves : {landed, (landed + rest->passed) / 2, rest->passed}) {
      MotionSample& sample = whole.samples[static_cast<std::size_t>(leaves)];
      sample.force.resize(robot_->nv());
      kinematics_.inverse_dynamics(sample.q, sample.dq, sample.ddq, sample.force);
      Posture from = passing(*robot_, sample);
      if (leaves > 0) from.contact_before = whole.samples[static_cast<std::size_t>(leaves) - 1].contact;
      PlanResult planned = halt(from, trail, *rest, anchor, limits);
      auto* end = std::get_if<PlannedMotion>(&planned);
      if (end == nullptr) continue;
      if (verified++ == kMostParts) return std::nullopt;
      Motion part = joined(whole, leaves, *end->motion);
      differentiate(*robot_, part);
      std::variant<VerifiedMotion, Refusal> verdict = verifier_.verify(std::move(part), anchor, limits);
      if (const auto* refusal = std::get_if<Refusal>(&verdict)) {
        if (refusal->t < leaves * whole.period) until = std::min(until, refusal->t);
        continue;
      }
      end->motion = std::get<VerifiedMotion>(std::move(verdict));
      if (leans_out(*robot_, *end->motion, limits)) continue;
      end->limit = std::move(against);
      return PartOfWay{std::move(*end), *rest};
    }
  }
  return std::nullopt;
}

Planner::Failure Planner::judged(Refusal refusal, const Segment& segment) {
  if (refusal.part == Part::trunk) refusal.part = segment.goal().guided;
  const double stretch = stretch_for(refusal);
  return {std::move(refusal), stretch};
}

std::optional<Planner::Failure> Planner::evaluate(Task& task, Candidate& candidate) {
  ++task.tried;
  ++tried_;
  const Timing& timing = candidate.timing;
  const ComProblem& problem = task.segment.com();
  VrpOffset offset;
  for (int k = 0;; ++k) {
    std::optional<ComPath> path = com_.path(problem, timing, offset);
    if (!path) {
      const double margin = zmp_margin(problem, com_path(problem, timing), timing).margin;
      return judged({Reason::zmp, task.segment.goal().guided, margin, problem.margin, k == 0 ? "point mass" : ""},
                    task.segment);
    }
    candidate.com = std::move(*path);
    if (k == kCorrections) break;
    std::variant<VrpOffset, Refusal> found = survey_.evaluate(task.segment, candidate.com, timing, task.warm_start);
    if (auto* refusal = std::get_if<Refusal>(&found)) return judged(std::move(*refusal), task.segment);
    offset = std::move(std::get<VrpOffset>(found));
  }
  return std::nullopt;
}

std::variant<PlannedMotion, Planner::Failure> Planner::finish(const Task& task, const Candidate& candidate) {
  std::variant<Motion, Refusal> motion = realise(task.segment, candidate);
  if (auto* refusal = std::get_if<Refusal>(&motion)) return judged(std::move(*refusal), task.segment);
  std::variant<VerifiedMotion, Refusal> verdict =
      verifier_.verify(std::get<Motion>(std::move(motion)), task.anchor, task.segment.limits());
  if (auto* refusal = std::get_if<Refusal>(&verdict)) return judged(std::move(*refusal), task.segment);
  return PlannedMotion{std::get<VerifiedMotion>(std::move(verdict)), task.tried, task.not_shorter};
}

std::variant<Motion, Refusal> Planner::realise(const Segment& segment, const Candidate& candidate) {
  const Profile::Ik& tolerance = robot_->profile().ik;
  const double dt = robot_->profile().tick.period;
  const Posture& from = segment.from();
  const Goal& goal = segment.goal();
  const Part part = goal.guided;
  const Timing& timing = candidate.timing;
  const int ticks = timing.ticks();
  Motion motion;
  motion.period = dt;
  motion.goal = goal;
  motion.contact_before = from.contact_before;
  motion.heat = from.heat;
  motion.phases = segment.phases(timing);
  motion.com = candidate.com;
  const Vec2 apex = segment.apex(timing);
  motion.swing = {goal.swing ? (from.flight ? from.flight->from : from.sole[*goal.swing]) : Pose{}, apex.x(), apex.y()};
  motion.samples.assign(static_cast<std::size_t>(ticks) + 1, {});
  set_contacts(motion);
  const bool moving = !from.dq.isZero(0.0);
  IkTargets targets;
  double hand_residual = 0.0;
  for (int k = 0; k <= ticks; ++k) {
    MotionSample& sample = motion.samples[static_cast<std::size_t>(k)];
    targets = segment.targets(motion.com, timing, k * dt);
    sample.com = targets.com;
    sample.dcom = motion.com.at(k * dt).dp;
    sample.sole = targets.sole;
    if (k == 0) {
      sample.q = from.q;
      continue;
    }
    const VecX& previous = motion.samples[static_cast<std::size_t>(k) - 1].q;
    sample.q = previous;
    if (k == 1 && moving) integrate(*robot_, sample.q, from.dq, dt);
    if (k > 1) {  // linearise at the extrapolated joint angles
      const VecX& earlier = motion.samples[static_cast<std::size_t>(k) - 2].q;
      sample.q.tail(robot_->nv() - 6) += (previous - earlier).tail(robot_->nv() - 6);
      sample.q.head<3>() += (previous - earlier).head<3>();
    }
    const IkResult result = ik_.solve(targets, previous, dt, sample.q, 3);
    const IkResidual& r = result.residual;
    hand_residual = r.hand;
    const double position = std::max(r.sole_position, r.com);
    if (!result.finite_targets) return Refusal{Reason::not_finite, part, 0, 0, ""};
    const bool lost = !(position <= tolerance.position) || !(r.sole_rotation <= tolerance.rotation);
    if (lost && result.bound_joint >= 0) {
      const Joint& joint = robot_->joints()[static_cast<std::size_t>(result.bound_joint)];
      const double q = sample.q[7 + result.bound_joint];
      const double room = std::min(q - joint.position.lo, joint.position.hi - q);
      if (room < 1e-6) return Refusal{Reason::joint_limit, part, room, segment.limits().joint, joint.name};
      return Refusal{Reason::joint_speed, part, joint.speed, joint.speed, joint.name};
    }
    if (lost) return Refusal{Reason::unreachable, part, position, tolerance.position, ""};
  }
  if (hand_residual > tolerance.hand) return Refusal{Reason::unreachable, part, hand_residual, tolerance.hand, "hand"};

  motion.dq0 = from.dq - 0.5 * dt * from.ddq;
  differentiate(*robot_, motion);

  const Kinematics& last = ik_.kinematics();
  Posture& end = motion.end;
  end.q = motion.samples.back().q;
  end.dq = VecX::Zero(robot_->nv());
  end.ddq = VecX::Zero(robot_->nv());
  end.com = goal.com;
  end.dcom.setZero();
  end.trunk = last.trunk().R;
  end.sole = targets.sole;
  end.contact = goal.contact;
  for (const Side side : kSides) {
    end.hand[side] = last.hand(side);
    end.shoulder[side] = last.shoulder(side);
  }
  motion.rest = resting(*robot_, end);
  return motion;
}

}  // namespace baton
