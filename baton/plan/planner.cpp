#include "baton/plan/planner.hpp"

#include <cmath>
#include <limits>
#include <utility>

#include "baton/ik/moving.hpp"
#include "baton/ik/stand.hpp"
#include "baton/math/quintic.hpp"
#include "baton/plan/retrace.hpp"
#include "baton/plan/shortest.hpp"

namespace baton {
namespace {

constexpr int kSurveyed = 24;            ///< postures that a survey looks at, about
constexpr double kSurveySpacing = 0.02;  ///< but none nearer to each other than this [s]
constexpr int kSwingSurveyed = 20;       ///< the same while a foot swings
constexpr int kSurveyIterations = 12;    ///< of inverse kinematics for each
constexpr InverseKinematics::Parameters kCoarse{.tolerance = 1e-5};
constexpr double kRoughly = 1.05;   ///< a survey's torques are not exact
constexpr int kCorrections = 2;     ///< by the limbs' part in the ZMP
constexpr double kSameRest = 1e-5;  ///< of a joint: what inverse kinematics may leave at a rest on the way back [rad]
constexpr int kRestsTried = 8;      ///< rests tried on a way back that cannot be taken whole
constexpr int kPartsVerified = 3;   ///< verifications of a part of a way back; each may take as long as the whole
constexpr int kVain = 2;            ///< surveys in a row, after which a torque is taken for one that stays
// The search for the shortest duration.
constexpr double kGrowth = 1.2;       ///< least factor from one that failed to the next
constexpr double kSlower = 1.5;       ///< the same from one that failed for what is not a matter of time
constexpr int kHalvings = 3;          ///< of the way back to the one that failed
constexpr double kResolution = 0.04;  ///< relative, at which that is given up
constexpr int kDivisions = 3;         ///< steps from the division by shares to that of the shortest
constexpr int kMostFinishes = 6;      ///< durations that are worked out whole

/// The factor on the duration that may mend it: speeds go with 1/T, accelerations with 1/T².
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

/// Two durations and what a survey found against each: whether a joint would be loaded too much however long the motion
/// took. A load has one part that goes with 1/T², and one that stays.
bool in_vain(double T1, const Refusal& first, double T2, const Refusal& second) {
  if (first.reason != Reason::joint_torque || second.reason != first.reason || second.where != first.where)
    return false;
  const double stays = (T2 * T2 * second.value - T1 * T1 * first.value) / (T2 * T2 - T1 * T1);
  return stays > kRoughly * second.limit;
}

/// The first `ticks` of a motion backwards, then `end`, which begins there.
Motion joined(const Motion& backwards, int ticks, Motion end) {
  Motion motion = std::move(end);
  motion.retraces = true;
  motion.leaves = ticks;
  motion.dq0 = backwards.dq0;
  motion.contact_before = backwards.contact_before;
  motion.samples.insert(motion.samples.begin(), backwards.samples.begin(), backwards.samples.begin() + ticks);
  const std::vector<ContactPhase> phases = first_phases(backwards.phases, ticks);
  motion.phases.insert(motion.phases.begin(), phases.begin(), phases.end());
  return motion;
}

}  // namespace

Planner::Planner(const RobotModel& robot, const World& world, DurationRule rule)
    : robot_(&robot), rule_(rule), ik_(robot), coarse_(robot, kCoarse), kinematics_(robot), verifier_(robot, world) {}

PlanResult Planner::plan(const Posture& from, const Goal& goal, const Pose& anchor, const Limits& limits,
                         DurationRule rule) {
  if (!goal.com.allFinite() || !goal.trunk.allFinite()) return Refusal{Reason::not_finite, goal.guided, 0, 0, ""};
  const Segment segment(*robot_, from, goal, limits, part_rates(kinematics_, from));
  Motion motion;
  motion.period = robot_->profile().tick.period;
  motion.goal = goal;
  motion.contact_before = from.contact_before;
  if (goal.swing) motion.lift_off = from.flight ? from.flight->from : from.sole[*goal.swing];
  Task task{segment, anchor};
  return rule == DurationRule::paper ? by_paper(task, std::move(motion)) : by_search(task, std::move(motion));
}

PlanResult Planner::by_paper(Task& task, Motion motion) {
  const Profile::Duration& duration = robot_->profile().duration;
  std::optional<Failure> failure;
  double certain = 0.0;                              // no duration below is worth a try
  std::optional<std::pair<double, Refusal>> before;  // the last look that found something, and what
  int vain = 0;                                      // looks in a row that say that no duration will do
  for (double T = task.segment.first_duration(); T <= duration.max + 1e-9; T += duration.step) {
    if (T < certain) continue;
    const int ticks = static_cast<int>(std::lround(T / motion.period));
    const Timing timing = timing_by_shares(task.segment.com().phases, ticks, motion.period);
    failure = look(task, timing, motion);
    vain = failure && before && in_vain(before->first, before->second, T, failure->refusal) ? vain + 1 : 0;
    if (vain == kVain) break;
    if (failure) before = {T, failure->refusal};
    if (!failure) failure = finish(task, timing, motion);
    if (!failure) return motion;
    if (failure->stretch == 0.0) break;
    motion.not_shorter = failure->refusal;
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

PlanResult Planner::by_search(Task& task, Motion motion) {
  const Profile& profile = robot_->profile();
  const auto in_ticks = [&](double t) { return static_cast<int>(std::lround(t / motion.period)); };
  const int longest = in_ticks(profile.duration.max);
  const std::optional<Flight>& flight = task.segment.from().flight;
  const double swing_time = flight ? flight->left : task.segment.limits().swing_time;
  const int least_swing = static_cast<int>(std::ceil(swing_time / motion.period - 1e-9));
  const ComProblem& com = task.segment.com();
  // The shortest that the point mass can do, but nothing that is over sooner than a swing.
  const std::optional<Shortest> shortest =
      shortest_timing(com_, com, task.segment.swing_phase(), least_swing, longest, motion.period);
  if (!shortest) {
    const Timing by_shares = timing_by_shares(com.phases, longest, motion.period);
    const ZmpMargin zmp = zmp_margin(com, com_path(com, by_shares), by_shares);
    return Refusal{Reason::zmp, motion.goal.guided, zmp.margin, com.margin, "point mass"};
  }
  int ticks = shortest->timing.ticks();
  if (ticks > least_swing + static_cast<int>(com.phases.size()) - 1)
    motion.not_shorter = Refusal{Reason::zmp, motion.goal.guided, 0, com.margin, "point mass"};
  ticks = std::max(ticks, least_swing);
  int failed = ticks - 1;
  // Longer until a look along it finds nothing against it, and back halfway to what failed.
  std::optional<Timing> found;
  const auto looks_good = [&](int duration) {
    std::optional<Failure> failure = Failure{{Reason::zmp, motion.goal.guided, 0, com.margin, ""}, kGrowth};
    found = timing(task.segment, shortest->timing, duration);
    if (found) failure = look(task, *found, motion);
    if (failure) motion.not_shorter = failure->refusal;
    return failure;
  };
  const auto longer = [&](double stretch) { return std::min(longest, static_cast<int>(std::ceil(ticks * stretch))); };
  // A quick motion leans farther out than a slow one: against that, too, more time may help, but once is enough.
  double chance = kSlower;
  const auto stretch_after = [&](const Failure& failure) {
    return failure.stretch > 0.0 ? failure.stretch : std::exchange(chance, 0.0);
  };
  while (const std::optional<Failure> failure = looks_good(ticks)) {
    const double stretch = stretch_after(*failure);
    if (stretch == 0.0 || ticks == longest) return failure->refusal;
    failed = ticks;
    ticks = longer(std::max(stretch, kGrowth));
  }
  for (int k = 0; k < kHalvings && ticks - failed > kResolution * ticks; ++k) {
    const int middle = (ticks + failed) / 2;
    (looks_good(middle) ? failed : ticks) = middle;
  }
  std::optional<Failure> failure;
  double least_stretch = 1.0 + kResolution;
  for (int k = 0; k < kMostFinishes; ++k, least_stretch *= least_stretch) {
    failure = looks_good(ticks);
    if (!failure) failure = finish(task, *found, motion);
    if (!failure) return motion;
    motion.not_shorter = failure->refusal;
    const double stretch = stretch_after(*failure);
    if (stretch == 0.0 || ticks == longest) break;
    ticks = longer(std::max(stretch, least_stretch));
  }
  return failure->refusal;
}

PlanResult Planner::retrace(const Trail& trail, const Pose& anchor, const Limits& limits) {
  Motion motion = reversed(*robot_, trail);
  if (std::optional<Refusal> refusal = certify(motion, anchor, limits)) return *std::move(refusal);
  return motion;
}

PlanResult Planner::halt(const Posture& from, const Trail& trail, const Halt& halt, const Pose& anchor,
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
  auto* motion = std::get_if<Motion>(&planned);
  if (motion == nullptr) return planned;
  VecX off(robot_->nv());
  difference(*robot_, off, 1.0, motion->end.q, there.q);
  const double most = off.cwiseAbs().maxCoeff();
  if (most > kSameRest) return Refusal{Reason::unreachable, goal.guided, most, kSameRest, "rest on the way back"};
  // What inverse kinematics leaves is made up for on the way.
  for (int k = 1; k <= motion->ticks(); ++k)
    integrate(*robot_, motion->samples[static_cast<std::size_t>(k)].q, off, smooth_step(k, motion->ticks()).x);
  motion->samples.back().q = motion->end.q = there.q;
  differentiate(*robot_, *motion);
  if (std::optional<Refusal> refusal = certify(*motion, anchor, limits)) return *std::move(refusal);
  return planned;
}

std::optional<Planner::PartOfWay> Planner::retrace_part(const Trail& trail, const Pose& anchor, const Limits& limits,
                                                        Refusal against) {
  Motion whole = reversed(*robot_, trail);
  const auto both_stand = [&](int k) {
    const MotionSample& sample = whole.samples[static_cast<std::size_t>(k)];
    return sample.contact.left && sample.contact.right;
  };
  const std::vector<Halt> rests = halts(trail);
  int tries = kRestsTried;
  int verified = 0;
  double until = against.t;
  for (auto rest = rests.rbegin(); rest != rests.rend() && tries > 0; ++rest) {
    if (rest->passed * whole.period > until) continue;
    --tries;
    // Both feet stand from where the last of them has landed: from there on the robot may come to rest.
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
      auto* end = std::get_if<Motion>(&planned);
      if (end == nullptr) continue;
      if (verified++ == kPartsVerified) return std::nullopt;
      Motion part = joined(whole, leaves, *std::move(end));
      differentiate(*robot_, part);
      if (const std::optional<Refusal> refusal = certify(part, anchor, limits)) {
        if (refusal->t < leaves * whole.period) until = std::min(until, refusal->t);
        continue;
      }
      part.limit = std::move(against);
      return PartOfWay{std::move(part), *rest};
    }
  }
  return std::nullopt;
}

std::optional<Refusal> Planner::certify(Motion& motion, const Pose& anchor, const Limits& limits) {
  auto verdict = verifier_.verify(motion, anchor, limits);
  if (auto* refusal = std::get_if<Refusal>(&verdict)) return std::move(*refusal);
  motion.certificate = std::get<Certificate>(std::move(verdict));
  motion.rest = resting(*robot_, motion.end);
  return std::nullopt;
}

Planner::Failure Planner::judged(Refusal refusal, const Motion& motion) {
  if (refusal.part == Part::trunk) refusal.part = motion.goal.guided;
  const double stretch = stretch_for(refusal);
  return {std::move(refusal), stretch};
}

std::optional<Planner::Failure> Planner::look(Task& task, const Timing& timing, Motion& motion) {
  ++motion.durations_tried;
  const ComProblem& problem = task.segment.com();
  VrpOffset offset;
  for (int k = 0;; ++k) {
    std::optional<ComPath> path = com_.path(problem, timing, offset);
    if (!path) {
      const double margin = zmp_margin(problem, com_path(problem, timing), timing).margin;
      return judged({Reason::zmp, motion.goal.guided, margin, problem.margin, k == 0 ? "point mass" : ""}, motion);
    }
    motion.com = std::move(*path);
    if (k == kCorrections) break;
    std::variant<VrpOffset, Refusal> looked = survey(task, motion.com, timing);
    if (auto* refusal = std::get_if<Refusal>(&looked)) return judged(std::move(*refusal), motion);
    offset = std::move(std::get<VrpOffset>(looked));
  }
  return std::nullopt;
}

std::optional<Planner::Failure> Planner::finish(Task& task, const Timing& timing, Motion& motion) {
  motion.phases = task.segment.phases(timing);
  const Vec2 apex = task.segment.apex(timing);
  motion.apex_t = apex.x();
  motion.apex = apex.y();
  std::optional<Refusal> refusal = realise(task, timing, motion);
  if (!refusal) refusal = certify(motion, task.anchor, task.segment.limits());
  if (refusal) return judged(*std::move(refusal), motion);
  return std::nullopt;
}

std::variant<VrpOffset, Refusal> Planner::survey(Task& task, const ComPath& path, const Timing& timing) {
  const Profile& profile = robot_->profile();
  const Limits& limits = task.segment.limits();
  const Posture& from = task.segment.from();
  const ComProblem& problem = task.segment.com();
  const auto fails = [](Reason reason, double value, double limit, const std::string& where) {
    return Refusal{reason, Part::trunk, value, limit, where};
  };
  std::vector<double> t{0.0};
  const double spacing = std::max(kSurveySpacing, timing.duration() / kSurveyed);
  for (std::size_t i = 0; i + 1 < timing.border.size(); ++i) {
    const double begin = timing.border[i] * timing.period;
    const double end = timing.border[i + 1] * timing.period;
    const bool swings = task.segment.swing_phase() == i;  // there accelerations change most quickly
    const int parts = swings ? kSwingSurveyed : std::max(2, static_cast<int>(std::lround((end - begin) / spacing)));
    for (int k = 1; k <= parts; ++k)
      t.push_back(begin + (end - begin) * k / parts);
  }
  const std::size_t last = t.size() - 1;
  const bool again = task.looked.size() == t.size();
  const bool moving = !from.dq.isZero(0.0);
  std::vector<VecX> q(t.size(), from.q);
  std::vector<VecX> step(t.size() + 1, VecX::Zero(robot_->nv()));  // velocity between postures i − 1 and i
  std::optional<Refusal> hasty;                                    // what asks for more time, most of all
  double worst = 1.0;
  for (std::size_t i = 1; i <= last; ++i) {
    const double h = t[i] - t[i - 1];
    q[i] = again ? task.looked[i] : q[i - 1];
    if (!again && (moving || i > 1)) integrate(*robot_, q[i], i > 1 ? step[i - 1] : from.dq, h);
    const IkResult result = coarse_.solve(task.segment.targets(path, timing, t[i]), q[i - 1],
                                          std::numeric_limits<double>::infinity(), q[i], kSurveyIterations);
    difference(*robot_, step[i], h, q[i - 1], q[i]);
    for (std::size_t j = 0; j < robot_->joints().size(); ++j) {
      const Joint& joint = robot_->joints()[j];
      const auto n = static_cast<Eigen::Index>(j);
      const double room = std::min(q[i][7 + n] - joint.position.lo, joint.position.hi - q[i][7 + n]);
      if (room < limits.joint) return fails(Reason::joint_limit, room, limits.joint, joint.name);
      // The mean speed between two looks: if that is too much, the largest is.
      const double speed = std::abs(step[i][6 + n]);
      if (speed > worst * joint.speed) {
        worst = speed / joint.speed;
        hasty = fails(Reason::joint_speed, speed, joint.speed, joint.name);
      }
    }
    const double position = std::max(result.residual.sole_position, result.residual.com);
    if (position > profile.ik.position && result.iterations == kSurveyIterations) {
      return fails(Reason::unreachable, position, profile.ik.position, "");
    }
  }
  if (hasty) return *hasty;
  worst = 0.0;
  VrpOffset offset;
  VecX dq, ddq, tau, force(robot_->nv());
  for (std::size_t i = 0; i <= last; ++i) {
    if (i == 0) {
      dq = from.dq;
      ddq = 2.0 / t[1] * (step[1] - dq);
    } else if (i == last) {
      dq.setZero();
      ddq = -2.0 / (t[i] - t[i - 1]) * step[i];
    } else {
      const double before = t[i] - t[i - 1];
      const double after = t[i + 1] - t[i];
      dq = (after * step[i] + before * step[i + 1]) / (before + after);
      ddq = 2.0 / (before + after) * (step[i + 1] - step[i]);
    }
    kinematics_.inverse_dynamics(q[i], dq, ddq, force);
    const Wrench total = ground_wrench(kinematics_, force);
    const BySide<Pose> sole{kinematics_.sole(Side::left), kinematics_.sole(Side::right)};
    joint_torques(kinematics_, force, share_wrench(*robot_, sole, task.segment.contact(timing, t[i]), total), tau);
    for (std::size_t j = 0; j < robot_->joints().size(); ++j) {
      const Joint& joint = robot_->joints()[j];
      const auto n = static_cast<Eigen::Index>(j);
      const double load = joint.motor.load(tau[n], dq[6 + n]);
      if (load > std::max(kRoughly * limits.torque, worst)) {
        worst = load;
        hasty = fails(Reason::joint_torque, load, limits.torque, joint.name);
      }
    }
    const ComState com = path.at(t[i]);
    const Vec3 moment = total.moment_about(kinematics_.com());
    const double lever = com.p.z() - com.v.z() + kGravity / (problem.omega * problem.omega);
    const double f = lever / (com.p.z() - problem.plane) / total.force.z();
    offset.times.push_back(t[i]);
    offset.values.emplace_back(-moment.y() * f, moment.x() * f, 0.0);
  }
  task.looked = std::move(q);
  if (hasty) return *hasty;
  return offset;
}

std::optional<Refusal> Planner::realise(const Task& task, const Timing& timing, Motion& motion) {
  const Profile::Ik& tolerance = robot_->profile().ik;
  const double dt = motion.period;
  const Part part = motion.goal.guided;
  const int ticks = timing.ticks();
  motion.samples.assign(static_cast<std::size_t>(ticks) + 1, {});
  set_contacts(motion);
  const Posture& from = task.segment.from();
  const bool moving = !from.dq.isZero(0.0);
  IkTargets targets;
  double hand_residual = 0.0;
  for (int k = 0; k <= ticks; ++k) {
    MotionSample& sample = motion.samples[static_cast<std::size_t>(k)];
    targets = task.segment.targets(motion.com, timing, k * dt);
    const ComState com = motion.com.at(k * dt);
    sample.com = com.p;
    sample.dcom = com.dp;
    sample.sole = targets.sole;
    if (k == 0) {
      sample.q = from.q;
      continue;
    }
    const VecX& previous = motion.samples[static_cast<std::size_t>(k) - 1].q;
    sample.q = previous;
    if (k == 1 && moving) integrate(*robot_, sample.q, from.dq, dt);
    if (k > 1) {  // linearise where the joints would go by themselves
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
      if (room < 1e-6) return Refusal{Reason::joint_limit, part, room, task.segment.limits().joint, joint.name};
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
  end.com = motion.goal.com;
  end.dcom.setZero();
  end.trunk = last.trunk().R;
  end.sole = targets.sole;
  end.contact = motion.goal.contact;
  for (const Side side : kSides) {
    end.hand[side] = last.hand(side);
    end.shoulder[side] = last.shoulder(side);
  }
  return std::nullopt;
}

}  // namespace baton
