#include "baton/plan/segment.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "baton/math/quintic.hpp"
#include "baton/model/contact.hpp"

namespace baton {
namespace {

constexpr int kShiftKnots = 5;    ///< VRP intervals of a single-phase segment
constexpr double kLevel = 0.008;  ///< height difference below which footholds are level [COM height]

/// For a foot that hangs in the air and lands elsewhere: fractions of the descent at which it starts to sink, and at
/// which it is above the foothold. There may be an edge in between.
constexpr std::pair<double, double> kBesideDescent{0.4, 0.7};

// A swing that passes the stance foot [COM height]:
constexpr double kGapReserve = 0.004;   ///< added to the least gap of the soles
constexpr double kMostOutward = 0.08;   ///< largest detour
constexpr double kOutwardStep = 0.016;  ///< step by which it is found

BySide<bool> only(Side side) {
  return {side == Side::left, side == Side::right};
}

}  // namespace

double outer_edge(const RobotModel& robot, Side side) {
  double edge = 0.0;
  for (const Vec2& corner : robot.sole(side).vertices())
    edge = std::max(edge, sign_of(side) * corner.y());
  return edge;
}

Segment::Segment(const RobotModel& robot, const Posture& from, const Goal& goal, const Limits& limits,
                 const PartRates& rates)
    : robot_(&robot),
      from_(from),
      goal_(goal),
      limits_(limits),
      rates_(rates),
      first_duration_(robot.profile().duration.first) {
  const Profile::Phases& profile = robot.profile().phases;
  enum class Swing { none, step, lift, lower, air };
  const auto kind = [&] {
    if (!goal.swing) return Swing::none;
    if (from.contact[*goal.swing]) return goal.contact[*goal.swing] ? Swing::step : Swing::lift;
    return goal.contact[*goal.swing] ? Swing::lower : Swing::air;
  }();
  const BySide<bool> both{true, true};
  const bool moving = !from.dq.isZero(0.0);
  const std::array<double, 3>& step = moving ? profile.flow : profile.step;
  std::vector<double> shares{1.0};
  contact_ = {both};
  std::vector<VrpKnot> knots;
  // The pendulum is the robot's COM, not the model's. It continues with its current acceleration.
  const Vec3 start = from.com + com_offset();
  const Vec3 end = goal.com + com_offset();
  const Vec3 drive = start - from.ddcom / (robot.omega() * robot.omega());
  const auto wish = [&](double t, const Vec3& place, double weight) {
    const Vec3 level = start + t / static_cast<double>(contact_.size()) * (end - start);
    knots.push_back({t, Vec3(place.x(), place.y(), level.z()), weight});
  };
  // Besides the paper's knots at the phase boundaries there are some within each phase: otherwise the ZMP strays
  // farther out with longer durations, and the shortest motion is longer than necessary. Those of a step were found by
  // search: near its boundaries, for a quick transfer, and two in single support; durations then stay within 1.25 of
  // the lower bound.
  const std::array<double, 4>& w = profile.weights;
  const Vec3 stance = goal.swing ? from.sole[other(*goal.swing)].p : start;
  switch (kind) {
    case Swing::step:
      shares.assign(step.begin(), step.end());
      if (from.lift_off && from.lift_off->side == *goal.swing) {  // the weight shift is under way
        const double swing = step[1] * first_duration_;
        const double after = step[2] * first_duration_;
        first_duration_ = from.lift_off->remaining + swing + after;
        shares = {from.lift_off->remaining / first_duration_, swing / first_duration_, after / first_duration_};
      }
      contact_ = {both, only(other(*goal.swing)), both};
      wish(0.0, start, w[0]);
      wish(0.7, start, w[0]);
      wish(1.0, stance, w[1]);
      wish(1.33, stance, 0.5 * (w[1] + w[2]));
      wish(1.67, stance, 0.5 * (w[1] + w[2]));
      wish(2.0, stance, w[2]);
      wish(2.3, end, w[3]);
      wish(3.0, end, w[3]);
      break;
    case Swing::lift:
      shares.assign(profile.lift.begin(), profile.lift.end());
      contact_ = {both, only(other(*goal.swing))};
      wish(0.0, start, w[0]);
      wish(0.5, start, w[0]);
      wish(1.0, stance, w[1]);
      wish(1.5, stance, w[1]);
      wish(2.0, end, w[2]);
      break;
    case Swing::lower:
      shares.assign(profile.lower.begin(), profile.lower.end());
      if (from.flight) {  // remaining swing, then as long as after a step
        first_duration_ = from.flight->remaining + step[2] * first_duration_;
        shares = {from.flight->remaining / first_duration_, 1.0 - from.flight->remaining / first_duration_};
      }
      contact_ = {only(other(*goal.swing)), both};
      wish(0.0, start, w[1]);
      wish(0.5, stance, w[2]);
      wish(1.0, stance, w[2]);
      wish(1.5, end, w[3]);
      wish(2.0, end, w[3]);
      break;
    case Swing::air:
      contact_ = {only(other(*goal.swing))};
      [[fallthrough]];
    case Swing::none:
      if (goal.duration) {
        const Profile::Duration& duration = robot.profile().duration;
        first_duration_ = std::clamp(*goal.duration, duration.step, duration.max);
      }
      for (int k = 0; k <= kShiftKnots; ++k)
        wish(static_cast<double>(k) / kShiftKnots, 2 * k < kShiftKnots ? start : end, 1.0);
      break;
  }
  knots.front().wish = drive;
  const double plane = std::min(support_plane(from.sole, from.contact), support_plane(goal.sole, goal.contact));
  com_ = {robot.omega(), start, from.dcom, end, plane, limits.zmp_plan, {}, {}, std::move(knots)};
  if (!(from.contact_before.left && from.contact_before.right))
    com_.at_start = support_polygon(robot, from.sole, from.contact_before, start, plane);
  for (std::size_t i = 0; i < shares.size(); ++i) {
    // Soles move only in swing: before it they are at the start, after it at the goal.
    const BySide<Pose>& sole = i == 0 ? from.sole : goal.sole;
    const Vec3 com = start + (end - start) * (static_cast<double>(i) / static_cast<double>(shares.size()));
    const ConvexPolygon support = support_polygon(robot, sole, contact_[i], com, plane);
    const ConvexPolygon inner = within_outer_edges(support, sole, contact_[i]);
    // A motion may begin elsewhere, after a capture step.
    const bool begins = i > 0 || inner.margin(drive.head<2>()) >= limits.zmp_plan;
    com_.phases.push_back({shares[i], begins && !inner.empty() ? inner : support});
  }
  if (goal.swing) {
    const double size = robot.profile().stance.com_height;
    // On a straight path, yawed soles may pass too close to each other.
    const double wanted = robot.profile().region.sole_gap + kGapReserve * size;
    while (outward_ < kMostOutward * size && least_gap() < wanted)
      outward_ += kOutwardStep * size;
  }
}

ConvexPolygon Segment::within_outer_edges(ConvexPolygon support, const BySide<Pose>& sole,
                                          const BySide<bool>& contact) const {
  const double more = limits_.zmp_outward - limits_.zmp_plan;
  if (more <= 0.0) return support;
  for (const Side side : kSides) {
    if (!contact[side]) continue;
    const double edge = outer_edge(*robot_, side);
    const double far = 10.0 * robot_->profile().stance.com_height;
    std::array<Vec2, 4> corners;
    std::size_t k = 0;
    for (const double x : {-far, far}) {
      for (const double y : {edge - more, -far})
        corners[k++] = (sole[side] * Vec3(x, sign_of(side) * y, 0.0)).head<2>();
    }
    support = support.clipped(ConvexPolygon::hull(corners));
  }
  return support;
}

double Segment::least_gap() const {
  const Side side = *goal_.swing;
  const ConvexPolygon stance = sole_outline(*robot_, other(side), from_.sole[other(side)]);
  double least = std::numeric_limits<double>::infinity();
  constexpr int kSamples = 20;
  const double duration = from_.flight ? from_.flight->remaining : 1.0;
  for (int k = 1; k < kSamples; ++k) {
    const Pose sole = swing(duration * k / kSamples, duration);
    least = std::min(least, separation(sole_outline(*robot_, side, sole), stance));
  }
  return least;
}

std::optional<std::size_t> Segment::swing_phase() const {
  if (!goal_.swing) return std::nullopt;
  const auto up = std::find_if(contact_.begin(), contact_.end(), [&](const auto& c) { return !c[*goal_.swing]; });
  return static_cast<std::size_t>(up - contact_.begin());
}

BySide<bool> Segment::contact(const Timing& timing, double t) const {
  std::size_t phase = 0;
  while (phase + 1 < contact_.size() && t > timing.border[phase + 1] * timing.period - 1e-9)
    ++phase;
  return contact_[phase];
}

std::vector<ContactPhase> Segment::phases(const Timing& timing) const {
  std::vector<ContactPhase> phases;
  for (std::size_t i = 0; i < contact_.size(); ++i)
    phases.push_back({timing.border[i + 1] - timing.border[i], contact_[i]});
  return phases;
}

double Segment::level() const {
  return kLevel * robot_->profile().stance.com_height;
}

bool Segment::beside() const {
  const Side side = *goal_.swing;
  return (goal_.sole[side].p - from_.sole[side].p).head<2>().norm() > level();
}

Vec2 Segment::apex(double duration) const {
  const Side side = *goal_.swing;
  const double from = from_.sole[side].p.z();
  const double to = goal_.sole[side].p.z();
  if (!goal_.contact[side]) return {0.0, from};
  const double clearance = limits_.swing_clearance;
  if (from_.contact[side]) {
    const double share = to - from < -level() ? 0.4 : (to - from > level() ? 0.6 : 0.5);
    return {share * duration, std::max(from, to) + clearance};
  }
  if (!from_.flight && beside()) return {kBesideDescent.first * duration, std::max(from, to)};
  if (!from_.flight || from_.flight->to_apex <= 0.0) return {0.0, from};
  return {from_.flight->to_apex / from_.flight->remaining * duration, std::max(from_.flight->apex, to + clearance)};
}

Vec2 Segment::apex(const Timing& timing) const {
  const std::optional<std::size_t> phase = swing_phase();
  if (!phase) return Vec2::Zero();
  const double begin = timing.border[*phase] * timing.period;
  const Vec2 in_swing = apex(timing.border[*phase + 1] * timing.period - begin);
  return {begin + in_swing.x(), in_swing.y()};
}

Pose Segment::swing(double t, double duration) const {
  const Side side = *goal_.swing;
  const Pose& a = from_.sole[side];
  const Pose& b = goal_.sole[side];
  const double rise = b.p.z() - a.p.z();
  // To clear edges, move horizontally late when going up and early when going down.
  double begin = 0.0;
  double end = 1.0;
  const bool stood = from_.contact[side];
  const bool lands = goal_.contact[side];
  if (stood && lands && rise > level()) begin = 0.3;
  if (stood && lands && rise < -level()) end = 0.7;
  if (stood && !lands) begin = 0.2;
  if (!stood && lands && !from_.flight) end = beside() ? kBesideDescent.second : 0.8;
  if (from_.flight && lands && b.p.z() < from_.sole[other(side)].p.z() - level()) end = 0.6;
  const double s = smooth_step(t - begin * duration, (end - begin) * duration).x;
  const PoseRate& rate = rates_.sole[side];
  const Carry on = carry(t, end * duration);
  Pose pose;
  pose.p = a.p + s * (b.p - a.p) + on.velocity * rate.v + on.acceleration * rate.a;
  // Move outward at once: feet far apart fore and aft overlap sideways as soon as one begins to pass.
  const double bow = 1.0 - std::pow(2.0 * s - 1.0, 4);
  pose.p += from_.sole[other(side)].R * Vec3(0, sign_of(side) * outward_ * bow, 0);
  pose.R = rotation_exp(on.velocity * rate.rate + on.acceleration * rate.rate_change) * interpolate(a.R, b.R, s);
  // Up to the apex and down: two quintics, continuous to the second derivative.
  const Vec2 top = apex(duration);
  const double up = top.x();
  if (t < up) {
    const Carry rising = carry(t, up);
    pose.p.z() = a.p.z() + (top.y() - a.p.z()) * smooth_step(t, up).x + rising.velocity * rate.v.z() +
                 rising.acceleration * rate.a.z();
  } else if (up > 0.0) {
    pose.p.z() = top.y() + (b.p.z() - top.y()) * smooth_step(t - up, duration - up).x;
  } else {
    const Carry going = carry(t, duration);
    pose.p.z() =
        a.p.z() + rise * smooth_step(t, duration).x + going.velocity * rate.v.z() + going.acceleration * rate.a.z();
  }
  return pose;
}

IkTargets Segment::targets(const ComPath& path, const Timing& timing, double t) const {
  const double T = timing.duration();
  IkTargets targets;
  targets.com = path.at(t).p - com_offset();
  targets.sole = from_.sole;
  if (const std::optional<std::size_t> phase = swing_phase()) {
    const double begin = timing.border[*phase] * timing.period;
    const double end = timing.border[*phase + 1] * timing.period;
    constexpr double kSame = 1e-9;  // [s]
    if (t > end - kSame) {
      targets.sole[*goal_.swing] = goal_.sole[*goal_.swing];
    } else if (t > begin + kSame) {
      targets.sole[*goal_.swing] = swing(t - begin, end - begin);
    }
  }
  const double s = smooth_step(t, T).x;
  const Carry on = carry(t, T);
  targets.trunk = rotation_exp(on.velocity * rates_.trunk.rate + on.acceleration * rates_.trunk.rate_change) *
                  interpolate(from_.trunk, goal_.trunk, s);
  for (const Side side : kSides) {
    if (!goal_.hand[side]) continue;
    const Pose& a = from_.hand[side];
    const Pose& b = *goal_.hand[side];
    const PoseRate& rate = rates_.hand[side];
    targets.hand[side] =
        Pose{a.p + s * (b.p - a.p) + on.velocity * rate.v + on.acceleration * rate.a,
             rotation_exp(on.velocity * rate.rate + on.acceleration * rate.rate_change) * interpolate(a.R, b.R, s)};
  }
  const auto start = from_.q.tail(goal_.arms.size());
  targets.arms = start + s * (goal_.arms - start) + on.velocity * from_.dq.tail(start.size()) +
                 on.acceleration * from_.ddq.tail(start.size());
  if (const ArmPath* driven = goal_.arm_path.get()) {
    for (std::size_t k = 0; k < driven->joints.size(); ++k)
      targets.arms[driven->joints[k]] = driven->at(static_cast<Eigen::Index>(k), t, T);
  }
  return targets;
}

}  // namespace baton
