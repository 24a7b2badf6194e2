#include "baton/balance/footing.hpp"

#include <algorithm>

namespace baton {
namespace {

// How much differs from where; lengths are shares of the COM height, forces of the weight.
constexpr double kCarries = 0.05;      ///< load from which a sole counts as carrying
constexpr double kShould = 0.1;        ///< planned load of a sole that is missed if it does not carry
constexpr double kMissed = 0.0175;     ///< for so long [s]
constexpr double kFull = 0.3;          ///< load from which it is followed at the full rate
constexpr double kInside = 0.03;       ///< room of the pressure to the edge of a sole that lies flat
constexpr double kExact = 4e-4;        ///< a sole no farther off stands where it was planned
constexpr double kLevel = 1e-3;        ///< nor is it inclined [rad]
constexpr double kMostHeight = 0.045;  ///< bounds of the offset
constexpr double kMostPlace = 0.1;
constexpr double kMostTurn = 0.2;  ///< [rad]
constexpr double kAirRate = 10.0;  ///< at which the offset of a sole in the air goes back [1/s]
constexpr double kDamping = 1e-6;

/// v, no longer than `most`.
template <typename Vector>
Vector bounded(const Vector& v, double most) {
  const double size = v.norm();
  return size > most ? Vector(v * (most / size)) : v;
}

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
      rows_(6, robot.nv()) {}

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
      // In the air: back to the plan, inclined as the other one stands.
      Offset& offset = offset_[side];
      offset.p *= 1.0 - share_of(kAirRate);
      const Vec3& stands = offset_[other(side)].turn;
      offset.turn += share_of(kAirRate) * (Vec3(stands.x(), stands.y(), 0.0) - offset.turn);
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
  offset.turn.head<2>() += carries * share_of(rates_.yield_turn) * beyond(excess, band);

  // A sole that tips over its edge says nothing about the ground.
  const Vec3 moment = state.sole[side].R.transpose() * force.moment;
  const Vec2 pressure = Vec2(-moment.y(), moment.x()) / force.force.z();
  if (robot_->sole(side).margin(pressure) > kInside * height_) {
    const Vec2 turned = rotation_error(state.sole[side].R, now.sole[side].R).head<2>();
    offset.turn.head<2>() += carries * share_of(rates_.turn) * (beyond(turned, kLevel) - offset.turn.head<2>());
  }
  offset.p.z() = std::clamp(offset.p.z(), -kMostHeight * height_, kMostHeight * height_);
  offset.p.head<2>() = bounded(Vec2(offset.p.head<2>()), kMostPlace * height_);
  offset.turn = bounded(offset.turn, kMostTurn);
}

void Footing::apply(const Kinematics& kinematics, VecX& q) {
  // No leg is stretched beyond what was planned, it might be straight: the trunk comes down instead.
  const double down = std::max({0.0, -offset_.left.p.z(), -offset_.right.p.z()});
  for (const Side side : kSides) {
    const Offset& offset = offset_[side];
    if (offset.p.isZero(0.0) && offset.turn.isZero(0.0) && down == 0.0) continue;
    kinematics.sole_jacobian(side, rows_);
    Vec6 wanted;
    wanted << offset.p + Vec3(0, 0, down), offset.turn;
    Eigen::Matrix<double, 6, 6> gram = kDamping * Eigen::Matrix<double, 6, 6>::Identity();
    for (const int j : robot_->leg(side)) {
      const Vec6 column = rows_.col(6 + j);
      gram.noalias() += column * column.transpose();
    }
    const Vec6 along = gram.ldlt().solve(wanted);
    for (const int j : robot_->leg(side)) {
      const Joint& joint = robot_->joints()[static_cast<std::size_t>(j)];
      q[j] = std::clamp(q[j] + rows_.col(6 + j).dot(along), joint.position.lo, joint.position.hi);
    }
  }
}

}  // namespace baton
