#include "baton/plan/planner.hpp"

#include <cmath>
#include <limits>

#include "baton/ik/stand.hpp"

namespace baton {
namespace {

constexpr int kSurveyed = 12;          ///< postures that a survey looks at
constexpr int kSurveyIterations = 12;  ///< of inverse kinematics for each

/// Whether more time can mend it.
bool is_matter_of_time(Reason reason) {
  switch (reason) {
    case Reason::zmp:
    case Reason::joint_speed:
    case Reason::joint_torque:
    case Reason::friction:
      return true;
    default:
      return false;
  }
}

}  // namespace

Planner::Planner(const RobotModel& robot, const World& world) : robot_(&robot), ik_(robot), verifier_(robot, world) {}

PlanResult Planner::plan(const Posture& from, const Goal& goal, const Pose& anchor) {
  const Profile& profile = robot_->profile();
  if (!goal.com.allFinite() || !goal.trunk.allFinite()) return Refusal{Reason::not_finite, goal.guided, 0, 0, ""};
  const Segment segment(*robot_, from, goal);
  Motion motion;
  motion.period = profile.tick.period;
  motion.goal = goal;
  Refusal refusal;
  for (double T = profile.duration.first; T <= profile.duration.max + 1e-9; T += profile.duration.step) {
    ++motion.durations_tried;
    const int ticks = static_cast<int>(std::lround(T / motion.period));
    motion.com = com_path(segment.com(), ticks, motion.period);
    const ZmpMargin zmp = zmp_margin(segment.com(), motion.com, motion.period);
    if (!(zmp.margin >= segment.com().margin)) {
      refusal = {Reason::zmp, goal.guided, zmp.margin, segment.com().margin, "point mass"};
      continue;
    }
    motion.phases = segment.phases(ticks);
    std::optional<Refusal> failed = survey(segment, from, motion);
    if (!failed) failed = realise(segment, from, motion);
    if (failed) {
      refusal = *failed;
    } else {
      auto verdict = verifier_.verify(motion, anchor);
      if (const auto* certificate = std::get_if<Certificate>(&verdict)) {
        motion.certificate = *certificate;
        motion.rest = resting(*robot_, motion.end);
        return motion;
      }
      refusal = std::get<Refusal>(verdict);
    }
    if (refusal.part == Part::trunk) refusal.part = goal.guided;
    if (!is_matter_of_time(refusal.reason)) break;
  }
  return refusal;
}

std::optional<Refusal> Planner::survey(const Segment& segment, const Posture& from, const Motion& motion) {
  const Profile& profile = robot_->profile();
  const Part part = motion.goal.guided;
  const int ticks = static_cast<int>(std::lround(motion.com.duration() / motion.period));
  const int stride = std::max(1, ticks / kSurveyed);
  VecX before = from.q;
  VecX q = from.q;
  for (int k = stride; k <= ticks; k += stride) {
    before = q;
    const IkResult result = ik_.solve(segment.targets(motion.com, k, ticks), before,
                                      std::numeric_limits<double>::infinity(), q, kSurveyIterations);
    const IkResidual& r = result.residual;
    for (std::size_t j = 0; j < robot_->joints().size(); ++j) {
      const Joint& joint = robot_->joints()[j];
      const auto i = 7 + static_cast<Eigen::Index>(j);
      const double room = std::min(q[i] - joint.position.lo, joint.position.hi - q[i]);
      if (room < profile.margin.joint)
        return Refusal{Reason::joint_limit, part, room, profile.margin.joint, joint.name};
      // The mean speed between two looks: if that is too much, the largest is.
      const double speed = std::abs(q[i] - before[i]) / (stride * motion.period);
      if (speed > joint.speed) return Refusal{Reason::joint_speed, part, speed, joint.speed, joint.name};
    }
    const double position = std::max(r.sole_position, r.com);
    if (position > profile.ik.position && result.iterations == kSurveyIterations) {
      return Refusal{Reason::unreachable, part, position, profile.ik.position, ""};
    }
  }
  return std::nullopt;
}

std::optional<Refusal> Planner::realise(const Segment& segment, const Posture& from, Motion& motion) {
  const Profile::Ik& tolerance = robot_->profile().ik;
  const double dt = motion.period;
  const Part part = motion.goal.guided;
  int ticks = 0;
  for (const ContactPhase& phase : motion.phases)
    ticks += phase.ticks;
  motion.samples.assign(static_cast<std::size_t>(ticks) + 1, {});
  std::size_t phase = 0;
  int phase_end = motion.phases[0].ticks;
  IkTargets targets;
  double hand_residual = 0.0;
  for (int k = 0; k <= ticks; ++k) {
    MotionSample& sample = motion.samples[static_cast<std::size_t>(k)];
    while (phase + 1 < motion.phases.size() && k >= phase_end)
      phase_end += motion.phases[++phase].ticks;
    sample.contact = motion.phases[phase].contact;
    targets = segment.targets(motion.com, k, ticks);
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
      if (room < 1e-6) return Refusal{Reason::joint_limit, part, room, robot_->profile().margin.joint, joint.name};
      return Refusal{Reason::joint_speed, part, joint.speed, joint.speed, joint.name};
    }
    if (lost) return Refusal{Reason::unreachable, part, position, tolerance.position, ""};
  }
  if (hand_residual > tolerance.hand) return Refusal{Reason::unreachable, part, hand_residual, tolerance.hand, "hand"};

  // Speeds and accelerations from the joint paths; before the start the robot moved as it does there, after the
  // end it rests.
  VecX step(robot_->nv());
  std::vector<VecX> steps(static_cast<std::size_t>(ticks) + 2);
  steps.front() = from.dq;
  steps.back() = VecX::Zero(robot_->nv());
  for (int k = 0; k < ticks; ++k) {
    const auto i = static_cast<std::size_t>(k);
    difference(*robot_, step, dt, motion.samples[i].q, motion.samples[i + 1].q);
    steps[i + 1] = step;
  }
  for (int k = 0; k <= ticks; ++k) {
    const auto i = static_cast<std::size_t>(k);
    MotionSample& sample = motion.samples[i];
    sample.dq = 0.5 * (steps[i] + steps[i + 1]);
    sample.ddq = (steps[i + 1] - steps[i]) / dt;
  }
  motion.samples.front().dq = from.dq;
  motion.samples.back().dq.setZero();

  const Kinematics& last = ik_.kinematics();
  Posture& end = motion.end;
  end.q = motion.samples.back().q;
  end.dq = VecX::Zero(robot_->nv());
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
