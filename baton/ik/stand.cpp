#include "baton/ik/stand.hpp"

#include <fmt/format.h>

#include <limits>

#include "baton/model/contact.hpp"
#include "baton/model/error.hpp"

namespace baton {

Posture posture_of(const RobotModel& robot, const VecX& q) {
  Kinematics kinematics(robot);
  kinematics.set(q);
  Posture posture;
  posture.q = q;
  posture.dq = VecX::Zero(robot.nv());
  posture.ddq = VecX::Zero(robot.nv());
  posture.com = kinematics.com();
  posture.trunk = kinematics.trunk().R;
  for (const Side side : kSides) {
    posture.sole[side] = kinematics.sole(side);
    posture.hand[side] = kinematics.hand(side);
    posture.shoulder[side] = kinematics.shoulder(side);
  }
  return posture;
}

Posture stand(const RobotModel& robot, const Pose& start, double com_height) {
  IkTargets targets;
  targets.com = start * Vec3(0, 0, com_height);
  targets.trunk = start.R;
  targets.arms = VecX::Zero(robot.nv() - 6);
  VecX q = VecX::Zero(robot.nq());
  q[3] = 1.0;
  for (std::size_t j = 0; j < robot.joints().size(); ++j) {
    const Joint& joint = robot.joints()[j];
    const auto i = static_cast<Eigen::Index>(j);
    targets.arms[i] = joint.home;
    // Initial guess with bent knees, as straight ones are singular. A knee is a joint that bends one way only.
    const double span = joint.position.hi - joint.position.lo;
    double angle = joint.home;
    if (joint.position.lo > -0.1 * span) angle = std::max(angle, joint.position.lo + 0.3 * span);
    if (joint.position.hi < 0.1 * span) angle = std::min(angle, joint.position.hi - 0.3 * span);
    q[7 + i] = angle;
  }
  for (const Side side : kSides) {
    targets.sole[side] = start * Pose{Vec3(0, sign_of(side) * 0.5 * robot.profile().stance.width, 0), Mat3::Identity()};
    for (const int j : robot.arm(side))
      q[7 + j] = targets.arms[j];
  }
  // With the attitude of the target, and the soles roughly in place.
  Eigen::Quaterniond attitude(start.R);
  q.segment<4>(3) << attitude.w(), attitude.x(), attitude.y(), attitude.z();
  const Posture guess = posture_of(robot, q);
  q.head<3>() += start.p - 0.5 * (guess.sole.left.p + guess.sole.right.p);
  InverseKinematics ik(robot);
  const VecX from = q;
  const IkResult result = ik.solve(targets, from, std::numeric_limits<double>::infinity(), q, 200);
  const IkResidual& r = result.residual;
  const double worst = std::max({r.sole_position, r.sole_rotation, r.com, r.trunk});
  if (!(worst < 1e-4)) {
    throw InputError(
        fmt::format("robot {} cannot stand with its COM at {} m and its soles {} m apart: inverse kinematics leaves "
                    "sole {:.4f} m, {:.4f} rad, COM {:.4f} m, trunk {:.4f} rad",
                    robot.profile().name, com_height, robot.profile().stance.width, r.sole_position, r.sole_rotation,
                    r.com, r.trunk));
  }
  Posture posture = posture_of(robot, q);
  posture.com = targets.com;
  posture.trunk = targets.trunk;
  posture.sole = targets.sole;
  return posture;
}

MotionSample resting(const RobotModel& robot, const Posture& posture) {
  MotionSample sample;
  sample.q = posture.q;
  sample.dq = VecX::Zero(robot.nv());
  sample.ddq = VecX::Zero(robot.nv());
  sample.force = VecX::Zero(robot.nv());
  Kinematics kinematics(robot);
  kinematics.inverse_dynamics(sample.q, sample.dq, sample.ddq, sample.force);
  sample.com = posture.com;
  sample.sole = posture.sole;
  sample.contact = posture.contact;
  sample.zmp_height = support_plane(posture.sole, posture.contact);
  sample.zmp = ground_wrench(kinematics, sample.force).zmp(sample.zmp_height);
  sample.zmp_region = std::make_shared<const ConvexPolygon>(
      support_polygon(robot, sample.sole, sample.contact, sample.com, sample.zmp_height)
          .inset(robot.profile().margin.zmp_feedback));
  return sample;
}

}  // namespace baton
