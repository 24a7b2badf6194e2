#include "baton/ik/moving.hpp"

#include "baton/ik/stand.hpp"

namespace baton {
namespace {

constexpr double kStep = 1e-3;  ///< step of the finite differences along (q, q̇, q̈), for robots of any size [s]

PoseRate rate_of(const Pose& before, const Pose& now, const Pose& after) {
  const Vec3 back = rotation_error(before.R, now.R);
  const Vec3 on = rotation_error(after.R, now.R);
  return {(after.p - before.p) / (2.0 * kStep), (after.p - 2.0 * now.p + before.p) / (kStep * kStep),
          (on - back) / (2.0 * kStep), (on + back) / (kStep * kStep)};
}

}  // namespace

Posture passing(const RobotModel& robot, const MotionSample& sample) {
  Posture posture = posture_of(robot, sample.q);
  posture.dq = sample.dq;
  posture.ddq = sample.ddq;
  posture.com = sample.com;
  posture.dcom = sample.dcom;
  posture.ddcom = sample.force.head<3>() / robot.mass() - Vec3(0, 0, kGravity);
  posture.sole = sample.sole;
  posture.contact = sample.contact;
  return posture;
}

PartRates part_rates(Kinematics& kinematics, const Posture& posture) {
  PartRates rates;
  if (posture.dq.isZero(0.0) && posture.ddq.isZero(0.0)) return rates;
  struct Poses {
    Pose trunk;
    BySide<Pose> sole, hand;
  };
  std::array<Poses, 3> at;
  for (const int k : {-1, 0, 1}) {
    VecX q = posture.q;
    const double t = k * kStep;
    integrate(kinematics.robot(), q, posture.dq + 0.5 * t * posture.ddq, t);
    kinematics.set(q);
    at[static_cast<std::size_t>(k + 1)] = {kinematics.trunk(),
                                           {kinematics.sole(Side::left), kinematics.sole(Side::right)},
                                           {kinematics.hand(Side::left), kinematics.hand(Side::right)}};
  }
  rates.trunk = rate_of(at[0].trunk, at[1].trunk, at[2].trunk);
  for (const Side side : kSides) {
    rates.sole[side] = rate_of(at[0].sole[side], at[1].sole[side], at[2].sole[side]);
    rates.hand[side] = rate_of(at[0].hand[side], at[1].hand[side], at[2].hand[side]);
  }
  return rates;
}

}  // namespace baton
