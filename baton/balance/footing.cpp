#include "baton/balance/footing.hpp"

#include <algorithm>
#include <cmath>

namespace baton {
namespace {

// Lengths are shares of the COM height, forces of the weight. Rates and times are the same for any size of robot.
constexpr double kCarries = 0.05;      ///< load from which a sole counts as carrying
constexpr double kShould = 0.1;        ///< planned load of a sole that is missed if it does not carry
constexpr double kMissed = 0.0175;     ///< for so long a sole does not carry before it is missed [s]
constexpr double kFull = 0.3;          ///< load from which it is followed at the full rate
constexpr double kInside = 0.03;       ///< room of the pressure to the edge of a sole that lies flat
constexpr double kExact = 4e-4;        ///< a sole no farther off stands where it was planned
constexpr double kLevel = 1e-3;        ///< nor is it inclined [rad]
constexpr double kMostHeight = 0.045;  ///< bounds of the offset
constexpr double kMostPlace = 0.1;     ///< in place
constexpr double kMostTurn = 0.2;      ///< in inclination and yaw [rad]
constexpr double kInsists = 0.03;      ///< a moment that is too much for longer, in one sense, is yielded to faster [s]
constexpr double kMostInsists = 4.0;   ///< times as fast, at most
constexpr double kAirRate = 10.0;      ///< at which the offset of a sole in the air goes back [1/s]
constexpr double kFloorRate = 0.3;     ///< at which the floor is taken to be inclined as a sole that lies flat is [1/s]
constexpr double kDamping =
    1e-6;  ///< of the legs' kinematics, beside half of the error squared; for any size of robot [m², rad²]
constexpr int kSteps = 4;          ///< of the legs' kinematics, at most
constexpr double kFarthest = 0.3;  ///< that a joint goes in one: a straight leg's would be anything [rad]
constexpr double kThere = 1e-6;    ///< error that needs no further step, for any size of robot [m, rad]

/// What of v is beyond a dead band.
template <typename Vector>
Vector beyond(const Vector& v, double band) {
  const double size = v.norm();
  return size > band ? Vector(v * (1.0 - band / size)) : Vector(Vector::Zero());
}
double beyond(double v, double band) {
  return v > band ? v - band : v < -band ? v + band : 0.0;
}

}  // namespace

Footing::Rates Footing::rates_for(Drive drive) {
  Rates rates;
  if (drive != Drive::stiff) return rates;
  // Here the soles' forces are all there is to balance with.
  rates.relax = 0.0;
  rates.untwist = 0.0;
  rates.height = 3.0;
  rates.turn = 3.0;
  rates.yield_turn = 3.0;
  rates.yield_height = 0.1;
  rates.yield_early = 1.0;
  rates.early_trust = 1.0;
  rates.band_turn = 0.0;
  rates.band_height = 0.0;
  return rates;
}

Footing::Footing(const RobotModel& robot)
    : robot_(&robot),
      rates_(rates_for(robot.profile().drive)),
      period_(robot.profile().tick.period),
      height_(robot.profile().stance.com_height),
      weight_(robot.mass() * kGravity),
      rows_(6, robot.nv()),
      shift_(VecX::Zero(robot.nv() - 6)),
      shifted_(VecX::Zero(robot.nv() + 1)) {}

void Footing::follow(const MotionSample& now, const MotionSample& next, const State& state,
                     const BySide<Wrench>& wanted) {
  BySide<double> carries;
  for (const Side side : kSides) {
    const double load = state.force[side].force.z() / weight_;
    carries[side] = load < kCarries ? 0.0 : std::clamp(load / kFull, 0.0, 1.0);
  }
  if (now.contact.left && now.contact.right && carries.left > 0.0 && carries.right > 0.0) relax(state, wanted);
  for (const Side side : kSides) {
    const bool misses = now.contact[side] && wanted[side].force.z() > kShould * weight_ && carries[side] == 0.0 &&
                        carries[other(side)] > 0.0;
    missed_[side] = misses ? missed_[side] + period_ : 0.0;
    // A foot on its way down follows ground that comes early; one on its way up must not cling to what it leaves.
    const bool lands = next.sole[side].p.z() < now.sole[side].p.z();
    if ((now.contact[side] || lands) && carries[side] > 0.0) {
      follow_ground(side, carries[side], now, state, wanted[side]);
    } else if (missed_[side] > kMissed) {
      // The ground is farther down than planned.
      double& z = offset_[side].p.z();
      z = std::max(z - share_of(rates_.late) * height_, -kMostHeight * height_);
    } else if (!now.contact[side]) {
      // In the air: back to the plan, inclined as the floor is.
      Offset& offset = offset_[side];
      offset.p *= 1.0 - share_of(kAirRate);
      offset.turn += share_of(kAirRate) * (Vec3(floor_.x(), floor_.y(), 0.0) - offset.turn);
    }
  }
}

void Footing::relax(const State& state, const BySide<Wrench>& wanted) {
  // Half of the difference: what both have too much of is not between them.
  const Wrench& left = wanted.left;
  const Wrench& right = wanted.right;
  const Vec3 force = (state.force.left.force - left.force) - (state.force.right.force - right.force);
  const double twist = (state.force.left.moment - left.moment).z() - (state.force.right.moment - right.moment).z();
  const Vec2 apart = 0.5 * force.head<2>() / weight_;
  const double against = 0.5 * twist / (weight_ * height_);
  for (const Side side : kSides) {
    offset_[side].p.head<2>() += sign_of(side) * share_of(rates_.relax) * height_ * apart;
    offset_[side].turn.z() += sign_of(side) * share_of(rates_.untwist) * against;
  }
}

void Footing::follow_ground(Side side, double carries, const MotionSample& now, const State& state,
                            const Wrench& wanted) {
  Offset& offset = offset_[side];
  const Wrench& force = state.force[side];
  const bool early = !now.contact[side];
  if (early) carries = std::max(carries, rates_.early_trust);
  const Vec3 off = beyond(Vec3(state.sole[side].p - now.sole[side].p), kExact * height_);
  offset.p.z() += carries * share_of(early ? rates_.early : rates_.height) * (off.z() - offset.p.z());
  offset.p.head<2>() += carries * share_of(rates_.place) * (off.head<2>() - offset.p.head<2>());

  // It yields to what presses more than it should.
  const double heavier = (force.force.z() - wanted.force.z()) / weight_;
  const double yields = share_of(early ? rates_.yield_early : rates_.yield_height) * height_;
  offset.p.z() += carries * yields * beyond(heavier, rates_.band_height);
  const Vec2 excess = (force.moment - wanted.moment).head<2>() / (weight_ * height_);
  const double band = rates_.band_turn * force.force.z() / weight_;
  const Vec2 tips = beyond(excess, band);
  Tipping& tipping = tipping_[side];
  tipping.lasts = tips.dot(tipping.last) > 0.0 ? tipping.lasts + period_ : 0.0;
  tipping.last = tips;
  // Ground under the whole sole would have taken it up by then: the sole tips on an edge. What it tipped by as it was
  // lifted is remembered until it lands.
  const double faster = std::clamp(tipping.lasts / kInsists, 1.0, kMostInsists);
  offset.turn.head<2>() += carries * share_of(rates_.yield_turn) * faster * tips;

  // A sole that tips over its edge says nothing about the ground.
  const Vec3 moment = state.sole[side].R.transpose() * force.moment;
  const Vec2 pressure = Vec2(-moment.y(), moment.x()) / force.force.z();
  if (robot_->sole(side).margin(pressure) > kInside * height_) {
    const Vec2 turned = rotation_error(state.sole[side].R, now.sole[side].R).head<2>();
    const Vec2 inclined = beyond(turned, kLevel);
    offset.turn.head<2>() += carries * share_of(rates_.turn) * (inclined - offset.turn.head<2>());
    floor_ = bounded(Vec2(floor_ + carries * share_of(kFloorRate) * (inclined - floor_)), kMostTurn);
  }
  offset.p.z() = std::clamp(offset.p.z(), -kMostHeight * height_, kMostHeight * height_);
  offset.p.head<2>() = bounded(Vec2(offset.p.head<2>()), kMostPlace * height_);
  offset.turn = bounded(offset.turn, kMostTurn);
}

void Footing::apply(Kinematics& kinematics, const VecX& q, VecX& joints) {
  const auto n = shift_.size();
  joints = q.tail(n);
  const double down = std::max(stretched(Side::left, kinematics), stretched(Side::right, kinematics));
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
  // From the last shift on: a single step would be far off where a leg is nearly straight.
  shifted_ = q;
  for (int j = 0; j < static_cast<int>(n); ++j)
    shifted_[7 + j] = within_range(j, q[7 + j], q[7 + j] + shift_[j]);
  bool there = false;
  for (int step = 0; step < kSteps && !there; ++step) {
    kinematics.set(shifted_);
    there = true;
    for (const Side side : kSides)
      there = reach(side, goal[side], kinematics, q) && there;
  }
  shift_ = shifted_.tail(n) - joints;
  joints += shift_;
}

bool Footing::reach(Side side, const Pose& goal, const Kinematics& kinematics, const VecX& q) {
  const Pose sole = kinematics.sole(side);
  Vec6 error;
  error << goal.p - sole.p, rotation_error(goal.R, sole.R);
  if (error.norm() < kThere) return true;
  kinematics.sole_jacobian(side, rows_);
  Eigen::Matrix<double, 6, 6> gram = (kDamping + 0.5 * error.squaredNorm()) * Eigen::Matrix<double, 6, 6>::Identity();
  for (const int j : robot_->leg(side)) {
    const Vec6 column = rows_.col(6 + j);
    gram.noalias() += column * column.transpose();
  }
  const Vec6 along = gram.ldlt().solve(error);
  double farthest = 0.0;
  for (const int j : robot_->leg(side))
    farthest = std::max(farthest, std::abs(rows_.col(6 + j).dot(along)));
  const double share = std::min(1.0, kFarthest / farthest);
  for (const int j : robot_->leg(side)) {
    const double angle = shifted_[7 + j] + share * rows_.col(6 + j).dot(along);
    shifted_[7 + j] = within_range(j, q[7 + j], angle);
  }
  return false;
}

double Footing::within_range(int j, double planned, double angle) const {
  const Range& range = robot_->joints()[static_cast<std::size_t>(j)].position;
  const double margin = robot_->profile().margin.joint;
  return std::clamp(angle, std::min(planned, range.lo + margin), std::max(planned, range.hi - margin));
}

double Footing::stretched(Side side, const Kinematics& kinematics) const {
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
