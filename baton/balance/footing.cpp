#include "baton/balance/footing.hpp"

#include <algorithm>
#include <cmath>

namespace baton {
namespace {

// Lengths are in COM heights or, where it says "sole", in half-widths of a sole; forces in weights, rates in ω, times
// in 1/ω.
constexpr double kFollowHeight = 2.4;       ///< height of a loaded sole is followed
constexpr double kFollowHeightEarly = 4.9;  ///< the same after early touchdown
constexpr double kFollowPlace = 1.3;        ///< horizontal position of a loaded sole is followed
constexpr double kFollowTilt = 1.3;         ///< tilt of a loaded sole is followed
constexpr double kSearch = 0.1;             ///< downward search while an expected contact is missing [COM height × ω]
constexpr double kWithdraw = 0.25;  ///< speed of a leg back from below the ground that it found [COM height × ω]
constexpr double kRelax = 0.16;     ///< compliance with internal force between the legs [COM height × ω per weight]
constexpr double kUntwist = 0.33;   ///< the same with internal yaw moment [ω per weight × COM height]
constexpr double kYieldTilt = 1.3;  ///< compliance with excess moment [ω per weight × COM height]
constexpr double kYieldHeight = 0.033;   ///< compliance with excess vertical force [COM height × ω per weight]
constexpr double kMomentBand = 0.29;     ///< dead band of excess moment, as error of the centre of pressure [sole]
constexpr double kForceBand = 0.1;       ///< dead band of excess force
constexpr double kContactLoad = 0.05;    ///< least load of a sole in contact
constexpr double kExpectedLoad = 0.1;    ///< least planned load from which a contact is expected
constexpr double kMissedTime = 0.107;    ///< time without an expected contact after which a sole searches downward
constexpr double kFullLoad = 0.3;        ///< load from which a sole is followed at the full rate
constexpr double kFlatMargin = 0.22;     ///< least margin of the centre of pressure inside a sole that is flat [sole]
constexpr double kPlaceBand = 4e-4;      ///< dead band of the position error
constexpr double kTiltBand = 1e-3;       ///< dead band of the tilt error [rad]
constexpr double kMaxHeight = 0.045;     ///< bound of the vertical offset
constexpr double kMaxPlace = 0.1;        ///< bound of the horizontal offset
constexpr double kMaxTurn = 0.2;         ///< bound of the offset in tilt and yaw [rad]
constexpr double kTippingTime = 0.18;    ///< time after which an excess moment in one direction means tipping
constexpr double kMaxTippingGain = 4.0;  ///< largest factor on compliance with excess moment while tipping
constexpr double kMaxSoftGain = 4.0;     ///< largest factor on soft ground
constexpr double kAirRate = 4.0;         ///< a sole in the air makes up for the trunk's errors
constexpr double kFloorRate = 0.05;      ///< low-pass of the terrain's tilt
constexpr double kOld = 0.066;           ///< age of measurements that halves all compliance
constexpr double kAgeRate = 0.3;         ///< low-pass of the measurements' age
constexpr double kSwayRate = 3.0;        ///< high-pass of the difference between the soles' excess loads
constexpr double kRockRate = 0.3;        ///< low-pass of the square of the load that rocks from sole to sole
constexpr double kRocking = 0.18;        ///< rms of the load that rocks, at which compliance is half
constexpr double kAtRest = 1e-3;         ///< planned speed at rest: norm over the root and all joints [m/s, rad/s]
constexpr double kStiffServo = 12.0;     ///< ankle kp above which compliance falls [weight × COM height/rad]
// The legs' kinematics, a numerical iteration:
constexpr double kDamping = 1e-6;      ///< added to half of the squared error [m², rad²]
constexpr int kMaxSteps = 4;           ///< iterations
constexpr double kMaxJointStep = 0.3;  ///< in one iteration; near a straight leg it would be arbitrary [rad]
constexpr double kConverged = 1e-6;    ///< error at which it ends [m, rad]
constexpr double kLastStep = 1e-4;     ///< error from which one iteration leads there: its square is less than that

/// Stiffness of the stiffer ankle's servo [N·m/rad].
double ankle_stiffness(const RobotModel& robot) {
  double stiffness = 0.0;
  for (const Side side : kSides)
    stiffness = std::max(stiffness, robot.joints()[static_cast<std::size_t>(robot.leg(side).back())].gains.kp);
  return stiffness;
}

Pose root_of(const VecX& q) {
  return {q.head<3>(), Eigen::Quaterniond(q[3], q[4], q[5], q[6]).toRotationMatrix()};
}

/// The links of the legs, each after its parent.
std::vector<int> leg_links(const RobotModel& robot) {
  const mjModel& m = robot.mj();
  std::vector<bool> in_leg(static_cast<std::size_t>(m.nbody));
  for (const Side side : kSides) {
    for (int body = robot.foot_body(side); body > 1; body = m.body_parentid[body])
      in_leg[static_cast<std::size_t>(body)] = true;
  }
  std::vector<int> links;
  for (int body = 2; body < m.nbody; ++body) {
    const auto i = static_cast<std::size_t>(body);
    in_leg[i] = in_leg[i] || in_leg[static_cast<std::size_t>(m.body_parentid[body])];  // carried by one
    if (in_leg[i]) links.push_back(body);
  }
  return links;
}

}  // namespace

Footing::Footing(const RobotModel& robot)
    : robot_(&robot),
      period_(robot.omega() * robot.profile().tick.period),
      height_(robot.profile().stance.com_height),
      half_width_(robot.sole_half_width()),
      weight_(robot.mass() * kGravity),
      ankle_kp_(ankle_stiffness(robot) / (weight_ * height_)),
      softness_(std::min(1.0, kStiffServo / ankle_kp_)),
      ground_(period_),
      legs_(leg_links(robot)),
      columns_(6, static_cast<Eigen::Index>(std::max(robot.leg(Side::left).size(), robot.leg(Side::right).size()))),
      shift_(VecX::Zero(robot.nv() - 6)),
      shifted_(VecX::Zero(robot.nv() + 1)) {}

void Footing::follow(const MotionSample& now, const MotionSample& next, const State& state,
                     const BySide<Wrench>& wanted) {
  // Admittance is an integrator around the servos' stiffness: what is stable is inversely proportional to that, and to
  // the delay.
  age_ += share_of(kAgeRate) * (state.age * robot_->omega() - age_);
  compliance_ = softness_ / (1.0 + age_ / kOld);
  if (now.contact.left && now.contact.right && now.dq.norm() < kAtRest) {
    feel_rocking(state, wanted);
    // Not on soft ground: soles have to yield there.
    compliance_ /= 1.0 + std::pow(std::sqrt(rocking_) / (kRocking * ground_gain()), 4);
  } else {
    uneven_.reset();
    rocking_ -= share_of(kRockRate) * rocking_;
  }
  BySide<double> carries;
  for (const Side side : kSides) {
    const double load = state.force[side].force.z() / weight_;
    carries[side] = load < kContactLoad ? 0.0 : std::clamp(load / kFullLoad, 0.0, 1.0);
  }
  if (now.contact.left && now.contact.right && carries.left > 0.0 && carries.right > 0.0) relax(state, wanted);
  for (const Side side : kSides) {
    const bool misses = now.contact[side] && wanted[side].force.z() > kExpectedLoad * weight_ && carries[side] == 0.0 &&
                        carries[other(side)] > 0.0;
    missing_time_[side] = misses ? missing_time_[side] + period_ : 0.0;
    // A descending foot follows the terrain from early touchdown on; an ascending one must not stick to it.
    const bool lands = next.sole[side].p.z() < now.sole[side].p.z();
    overreaches_[side] = overreaches_[side] && now.contact[side];
    if ((now.contact[side] || lands) && carries[side] > 0.0) {
      if (overreaches_[side]) withdraw(side, now, state, wanted[side]);
      follow_ground(side, carries[side], now, state, wanted[side]);
    } else if (missing_time_[side] > kMissedTime) {
      // The terrain is lower than planned.
      overreaches_[side] = true;
      double& z = offset_[side].p.z();
      z = std::max(z - share_of(kSearch) * height_, -kMaxHeight * height_);
    } else if (!now.contact[side]) {
      Offset& offset = offset_[side];
      const Offset wish = levelled(side, now, state);
      offset.p += share_of(kAirRate) * (wish.p - offset.p);
      offset.turn += share_of(kAirRate) * (wish.turn - offset.turn);
    }
  }
}

void Footing::withdraw(Side side, const MotionSample& now, const State& state, const Wrench& wanted) {
  double& z = offset_[side].p.z();
  const double ground = (state.sole[side].p - now.sole[side].p).z();
  // What presses no more than it should, as where it catches a robot that was pushed, stays.
  if (state.force[side].force.z() > wanted.force.z())
    z = std::max(z, std::min(ground, z + share_of(kWithdraw) * height_));
  overreaches_[side] = z < ground - kPlaceBand * height_;
}

Footing::Offset Footing::levelled(Side side, const MotionSample& now, const State& state) const {
  const Pose planned = root_of(now.q);
  const Pose measured = root_of(state.q);
  const Mat3 turned = measured.R * planned.R.transpose();
  const double raised = (measured.p + turned * (now.sole[side].p - planned.p) - now.sole[side].p).z();
  const Vec2 inclined = rotation_error(turned, Mat3::Identity()).head<2>();
  Offset offset;
  offset.p.z() = -std::clamp(beyond(raised, kPlaceBand * height_), -kMaxHeight * height_, kMaxHeight * height_);
  offset.turn.head<2>() = floor_tilt_ - bounded(beyond(inclined, kTiltBand), kMaxTurn);  // as flat as the ground
  return offset;
}

double Footing::ground_gain() const {
  return std::min(1.0 + ankle_kp_ * ground_.estimate(), kMaxSoftGain);
}

void Footing::feel_rocking(const State& state, const BySide<Wrench>& wanted) {
  const double left = (state.force.left.force - wanted.left.force).z() / weight_;
  const double right = (state.force.right.force - wanted.right.force).z() / weight_;
  const double apart = left - right;
  if (!uneven_) uneven_ = apart;
  *uneven_ += share_of(kSwayRate) * (apart - *uneven_);
  rocking_ += share_of(kRockRate) * (std::pow(apart - *uneven_, 2) - rocking_);
}

void Footing::relax(const State& state, const BySide<Wrench>& wanted) {
  // Half of the difference: an excess that both soles have in common is no internal force.
  const Wrench& left = wanted.left;
  const Wrench& right = wanted.right;
  const Vec3 force = (state.force.left.force - left.force) - (state.force.right.force - right.force);
  const double twist = (state.force.left.moment - left.moment).z() - (state.force.right.moment - right.moment).z();
  const Vec2 apart = 0.5 * force.head<2>() / weight_;
  const double against = 0.5 * twist / (weight_ * height_);
  for (const Side side : kSides) {
    offset_[side].p.head<2>() += sign_of(side) * share_of(compliance_ * kRelax) * height_ * apart;
    offset_[side].turn.z() += sign_of(side) * share_of(compliance_ * kUntwist) * against;
  }
}

void Footing::follow_ground(Side side, double carries, const MotionSample& now, const State& state,
                            const Wrench& wanted) {
  Offset& offset = offset_[side];
  const Wrench& force = state.force[side];
  const bool early = !now.contact[side];
  const Vec3 off = beyond(Vec3(state.sole[side].p - now.sole[side].p), kPlaceBand * height_);
  offset.p.z() += carries * share_of(early ? kFollowHeightEarly : kFollowHeight) * (off.z() - offset.p.z());
  offset.p.head<2>() += carries * share_of(kFollowPlace) * (off.head<2>() - offset.p.head<2>());

  // Admittance: comply with excess force and moment.
  const double heavier = (force.force.z() - wanted.force.z()) / weight_;
  const double yields = share_of(compliance_ * kYieldHeight) * height_;
  offset.p.z() += carries * yields * beyond(heavier, kForceBand);
  const Vec2 turned = rotation_error(state.sole[side].R, now.sole[side].R).head<2>();
  ground_.update(side, turned, force.moment.head<2>() / (weight_ * height_), now.contact[side] && carries >= 1.0);
  const double farther = ground_gain();
  const Vec2 excess = (force.moment - wanted.moment).head<2>() / (weight_ * height_);
  const double band = kMomentBand * half_width_ / height_ / farther * force.force.z() / weight_;
  const Vec2 tips = beyond(excess, band);
  Tipping& tipping = tipping_[side];
  tipping.duration = tips.dot(tipping.moment) > 0.0 ? tipping.duration + period_ : 0.0;
  tipping.moment = tips;
  // Terrain under the whole sole would have balanced a moment that lasts so long: the sole tips on an edge. The state
  // is kept in the air until the sole lands.
  const double faster = std::clamp(tipping.duration / kTippingTime, 1.0, kMaxTippingGain);
  offset.turn.head<2>() += carries * share_of(compliance_ * kYieldTilt) * std::max(faster, farther) * tips;

  // A sole that tips over its edge tells nothing about the terrain.
  const Vec3 moment = state.sole[side].R.transpose() * force.moment;
  const Vec2 pressure = Vec2(-moment.y(), moment.x()) / force.force.z();
  if (robot_->sole(side).margin(pressure) > kFlatMargin * half_width_) {
    const Vec2 inclined = beyond(turned, kTiltBand);
    offset.turn.head<2>() += carries * share_of(kFollowTilt) * (inclined - offset.turn.head<2>());
    floor_tilt_ = bounded(Vec2(floor_tilt_ + carries * share_of(kFloorRate) * (inclined - floor_tilt_)), kMaxTurn);
  }
  offset.p.z() = std::clamp(offset.p.z(), -kMaxHeight * height_, kMaxHeight * height_);
  offset.p.head<2>() = bounded(Vec2(offset.p.head<2>()), kMaxPlace * height_);
  offset.turn = bounded(offset.turn, kMaxTurn);
}

void Footing::apply(Kinematics& kinematics, const VecX& q, VecX& joints) {
  const auto n = shift_.size();
  joints = q.tail(n);
  const double down = std::max(trunk_drop(Side::left, kinematics), trunk_drop(Side::right, kinematics));
  BySide<Pose> goal;
  bool planned = down == 0.0;
  for (const Side side : kSides) {
    const Offset& offset = offset_[side];
    const Pose sole = kinematics.sole(side);
    goal[side] = {sole.p + offset.p + Vec3(0, 0, down), rotation_exp(offset.turn) * sole.R};
    planned = planned && offset.p.isZero(0.0) && offset.turn.isZero(0.0);
  }
  if (planned) {
    shift_.setZero();
    return;
  }
  // Starting from the previous change: near a straight leg a single step would be far off.
  shifted_ = q;
  for (int j = 0; j < static_cast<int>(n); ++j)
    shifted_[7 + j] = within_range(j, q[7 + j], q[7 + j] + shift_[j]);
  bool there = false;
  for (int step = 0; step < kMaxSteps && !there; ++step) {
    kinematics.set_links(shifted_, legs_);
    there = true;
    for (const Side side : kSides)
      there = step_towards(side, goal[side], kinematics, q) && there;
  }
  shift_ = shifted_.tail(n) - joints;
  joints += shift_;
}

bool Footing::step_towards(Side side, const Pose& goal, const Kinematics& kinematics, const VecX& q) {
  const Pose sole = kinematics.sole(side);
  Vec6 error;
  error << goal.p - sole.p, rotation_error(goal.R, sole.R);
  if (error.norm() < kConverged) return true;
  const std::vector<int>& leg = robot_->leg(side);
  const auto n = static_cast<Eigen::Index>(leg.size());
  Eigen::Matrix<double, 6, 6> gram = (kDamping + 0.5 * error.squaredNorm()) * Eigen::Matrix<double, 6, 6>::Identity();
  for (Eigen::Index i = 0; i < n; ++i) {
    const Kinematics::Axis& axis = kinematics.dof_axis(6 + leg[static_cast<std::size_t>(i)]);
    Vec6 column;
    column << axis.direction.cross(sole.p - axis.point), axis.direction;
    gram.noalias() += column * column.transpose();
    columns_.col(i) = column;
  }
  const Vec6 along = gram.ldlt().solve(error);
  double farthest = 0.0;
  for (Eigen::Index i = 0; i < n; ++i)
    farthest = std::max(farthest, std::abs(columns_.col(i).dot(along)));
  const double share = std::min(1.0, kMaxJointStep / farthest);
  for (Eigen::Index i = 0; i < n; ++i) {
    const int j = leg[static_cast<std::size_t>(i)];
    const double angle = shifted_[7 + j] + share * columns_.col(i).dot(along);
    shifted_[7 + j] = within_range(j, q[7 + j], angle);
  }
  return error.norm() < kLastStep;
}

double Footing::within_range(int j, double planned, double angle) const {
  const Range& range = robot_->joints()[static_cast<std::size_t>(j)].position;
  const double margin = robot_->profile().margin.joint;
  return std::clamp(angle, std::min(planned, range.lo + margin), std::max(planned, range.hi - margin));
}

double Footing::trunk_drop(Side side, const Kinematics& kinematics) const {
  const Offset& offset = offset_[side];
  const std::vector<int>& leg = robot_->leg(side);
  const Vec3 ankle = kinematics.dof_axis(6 + leg.back()).point;
  const Vec3 planned = ankle - kinematics.dof_axis(6 + leg.front()).point;
  const Vec3 above = ankle - kinematics.sole(side).p;
  const Vec3 v = planned + offset.p + rotation_exp(offset.turn) * above - above;
  // |v + z ez| = |planned|
  const double rest = planned.squaredNorm() - v.head<2>().squaredNorm();
  return rest > 0.0 ? std::max(0.0, -v.z() - std::sqrt(rest)) : 0.0;
}

}  // namespace baton
