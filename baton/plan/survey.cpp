#include "baton/plan/survey.hpp"

#include <cmath>
#include <limits>
#include <string>

#include "baton/model/contact.hpp"

namespace baton {
namespace {

constexpr int kPostures = 24;       ///< approximate number of postures
constexpr double kSpacing = 0.02;   ///< least spacing of postures [s]
constexpr int kSwingPostures = 20;  ///< number of postures in swing
constexpr int kIterations = 12;     ///< iterations of inverse kinematics per posture
constexpr InverseKinematics::Parameters kCoarse{.tolerance = 1e-5};

Refusal fails(Reason reason, double value, double limit, const std::string& where) {
  return {reason, Part::trunk, value, limit, where};
}

std::vector<double> times(const Segment& segment, const Timing& timing) {
  std::vector<double> t{0.0};
  const double spacing = std::max(kSpacing, timing.duration() / kPostures);
  for (std::size_t i = 0; i + 1 < timing.border.size(); ++i) {
    const double begin = timing.border[i] * timing.period;
    const double end = timing.border[i + 1] * timing.period;
    const bool swings = segment.swing_phase() == i;  // where accelerations change fastest
    const int parts = swings ? kSwingPostures : std::max(2, static_cast<int>(std::lround((end - begin) / spacing)));
    for (int k = 1; k <= parts; ++k)
      t.push_back(begin + (end - begin) * k / parts);
  }
  return t;
}

}  // namespace

Survey::Survey(const RobotModel& robot) : robot_(&robot), ik_(robot, kCoarse), kinematics_(robot) {}

std::variant<VrpOffset, Refusal> Survey::evaluate(const Segment& segment, const ComPath& path, const Timing& timing,
                                                  std::vector<VecX>& warm_start) {
  Rollout rollout{times(segment, timing), {}, {}};
  if (std::optional<Refusal> refusal = follow(segment, path, timing, warm_start, rollout)) return *std::move(refusal);
  std::variant<VrpOffset, Refusal> found = check_dynamics(segment, path, timing, rollout);
  warm_start = std::move(rollout.q);
  return found;
}

std::optional<Refusal> Survey::follow(const Segment& segment, const ComPath& path, const Timing& timing,
                                      const std::vector<VecX>& warm_start, Rollout& rollout) {
  const Limits& limits = segment.limits();
  const double tolerance = robot_->profile().ik.position;
  const Posture& from = segment.from();
  auto& [t, q, step] = rollout;
  q.assign(t.size(), from.q);
  step.assign(t.size() + 1, VecX::Zero(robot_->nv()));
  const bool again = warm_start.size() == t.size();
  const bool moving = !from.dq.isZero(0.0);
  std::optional<Refusal> hasty;  // the refusal that needs the most additional time
  double worst = 1.0;
  for (std::size_t i = 1; i < t.size(); ++i) {
    const double h = t[i] - t[i - 1];
    q[i] = again ? warm_start[i] : q[i - 1];
    if (!again && (moving || i > 1)) integrate(*robot_, q[i], i > 1 ? step[i - 1] : from.dq, h);
    const IkResult result = ik_.solve(segment.targets(path, timing, t[i]), q[i - 1],
                                      std::numeric_limits<double>::infinity(), q[i], kIterations);
    difference(*robot_, step[i], h, q[i - 1], q[i]);
    for (std::size_t j = 0; j < robot_->joints().size(); ++j) {
      const Joint& joint = robot_->joints()[j];
      const auto n = static_cast<Eigen::Index>(j);
      const double room = std::min(q[i][7 + n] - joint.position.lo, joint.position.hi - q[i][7 + n]);
      if (room < limits.joint) return fails(Reason::joint_limit, room, limits.joint, joint.name);
      // Mean speed between two postures: a lower bound on the peak.
      const double speed = std::abs(step[i][6 + n]);
      if (speed > worst * joint.speed) {
        worst = speed / joint.speed;
        hasty = fails(Reason::joint_speed, speed, joint.speed, joint.name);
      }
    }
    const double position = std::max(result.residual.sole_position, result.residual.com);
    if (position > tolerance && result.iterations == kIterations)
      return fails(Reason::unreachable, position, tolerance, "");
  }
  return hasty;
}

std::variant<VrpOffset, Refusal> Survey::check_dynamics(const Segment& segment, const ComPath& path,
                                                        const Timing& timing, const Rollout& rollout) {
  const double most = segment.limits().torque;
  const ComProblem& problem = segment.com();
  const auto& [t, q, step] = rollout;
  const std::size_t last = t.size() - 1;
  std::optional<Refusal> hasty;
  double worst = 0.0;
  VrpOffset offset;
  VecX dq, ddq, tau, force(robot_->nv());
  for (std::size_t i = 0; i <= last; ++i) {
    if (i == 0) {
      dq = segment.from().dq;
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
    const Wrench needed = with_com_offset(total, segment.limits().com_offset);
    const BySide<Pose> sole{kinematics_.sole(Side::left), kinematics_.sole(Side::right)};
    joint_torques(kinematics_, force, share_wrench(*robot_, sole, segment.contact(timing, t[i]), needed), tau);
    for (std::size_t j = 0; j < robot_->joints().size(); ++j) {
      const Joint& joint = robot_->joints()[j];
      const auto n = static_cast<Eigen::Index>(j);
      const double load = joint.motor.load(tau[n], dq[6 + n]);
      if (load > std::max(kTorqueTolerance * most, worst)) {
        worst = load;
        hasty = fails(Reason::joint_torque, load, most, joint.name);
      }
    }
    const ComState com = path.at(t[i]);
    const Vec3 moment = total.moment_about(kinematics_.com());
    const double lever = com.p.z() - com.v.z() + kGravity / (problem.omega * problem.omega);
    const double f = lever / (com.p.z() - problem.plane) / total.force.z();
    offset.times.push_back(t[i]);
    offset.values.emplace_back(-moment.y() * f, moment.x() * f, 0.0);
  }
  if (hasty) return *hasty;
  return offset;
}

}  // namespace baton
