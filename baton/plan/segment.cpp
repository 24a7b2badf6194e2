#include "baton/plan/segment.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "baton/math/quintic.hpp"
#include "baton/model/contact.hpp"

namespace baton {
namespace {

constexpr double kLevel = 2e-3;  ///< [m] footholds nearer in height need no shaped swing

constexpr double kGapReserve = 1e-3;   ///< [m]
constexpr double kMostOutward = 0.02;  ///< [m]
constexpr double kOutwardStep = 4e-3;  ///< [m]

BySide<bool> only(Side side) {
  return {side == Side::left, side == Side::right};
}

}  // namespace

Segment::Segment(const RobotModel& robot, const Posture& from, const Goal& goal)
    : robot_(&robot), from_(from), goal_(goal) {
  const Profile::Phases& profile = robot.profile().phases;
  const BySide<bool> both{true, true};
  std::vector<double> shares{1.0};
  contact_ = {both};
  std::vector<VrpKnot> knots;
  const auto wish = [&](double t, const Vec3& place, double weight) {
    const Vec3 level = from.com + t * (goal.com - from.com);
    knots.push_back({t, Vec3(place.x(), place.y(), level.z()), weight});
  };
  // Beside the paper's knots at the borders of the phases there is one in the middle of each double support that
  // shifts the weight: with it the ZMP need not wander farther out the longer the motion takes.
  const std::array<double, 4>& w = profile.weights;
  const Vec3 stance = goal.swing ? from.sole[other(*goal.swing)].p : from.com;
  switch (goal.kind) {
    case SegmentKind::step:
      shares.assign(profile.step.begin(), profile.step.end());
      contact_ = {both, only(other(*goal.swing)), both};
      wish(0.0, from.com, w[0]);
      wish(0.5 * shares[0], from.com, w[0]);
      wish(shares[0], stance, w[1]);
      wish(shares[0] + shares[1], stance, w[2]);
      wish(1.0 - 0.5 * shares[2], goal.com, w[3]);
      wish(1.0, goal.com, w[3]);
      break;
    case SegmentKind::lift:
      shares.assign(profile.lift.begin(), profile.lift.end());
      contact_ = {both, only(other(*goal.swing))};
      wish(0.0, from.com, w[0]);
      wish(0.5 * shares[0], from.com, w[0]);
      wish(shares[0], stance, w[1]);
      wish(1.0, goal.com, w[2]);
      break;
    case SegmentKind::lower:
      shares.assign(profile.lower.begin(), profile.lower.end());
      contact_ = {only(other(*goal.swing)), both};
      wish(0.0, from.com, w[1]);
      wish(shares[0], stance, w[2]);
      wish(1.0 - 0.5 * shares[1], goal.com, w[3]);
      wish(1.0, goal.com, w[3]);
      break;
    case SegmentKind::air:
      contact_ = {only(other(*goal.swing))};
      [[fallthrough]];
    case SegmentKind::shift:
    case SegmentKind::reach:
      wish(0.0, from.com, 1.0);
      wish(1.0 / 3.0, from.com, 1.0);
      wish(2.0 / 3.0, goal.com, 1.0);
      wish(1.0, goal.com, 1.0);
      break;
  }
  const double plane = std::min(support_plane(from.sole, from.contact), support_plane(goal.sole, goal.contact));
  com_ = {robot.omega(), from.com, from.dcom, goal.com, plane, robot.profile().margin.zmp_plan, {}, std::move(knots)};
  for (std::size_t i = 0; i < shares.size(); ++i) {
    // Soles move only while they are up: before the swing all are where they were, after it where they go.
    const BySide<Pose>& sole = i == 0 ? from.sole : goal.sole;
    const Vec3 com = from.com + (goal.com - from.com) * (static_cast<double>(i) / static_cast<double>(shares.size()));
    com_.phases.push_back({shares[i], support_polygon(robot, sole, contact_[i], com, plane)});
  }
  if (goal.swing) {
    // Turned soles may pass each other too closely on the straight way.
    const double wanted = robot.profile().region.sole_gap + kGapReserve;
    while (outward_ < kMostOutward && least_gap() < wanted)
      outward_ += kOutwardStep;
  }
}

double Segment::least_gap() const {
  const Side side = *goal_.swing;
  const ConvexPolygon stance = sole_outline(*robot_, other(side), from_.sole[other(side)]);
  double least = std::numeric_limits<double>::infinity();
  constexpr int kSamples = 20;
  for (int k = 1; k < kSamples; ++k) {
    const Pose sole = swing(static_cast<double>(k) / kSamples, 1.0);
    least = std::min(least, separation(sole_outline(*robot_, side, sole), stance));
  }
  return least;
}

std::vector<ContactPhase> Segment::phases(int ticks) const {
  const std::vector<int> borders = phase_borders(com_.phases, ticks);
  std::vector<ContactPhase> phases;
  for (std::size_t i = 0; i < contact_.size(); ++i)
    phases.push_back({borders[i + 1] - borders[i], contact_[i]});
  return phases;
}

Pose Segment::swing(double t, double duration) const {
  const Side side = *goal_.swing;
  const Pose& a = from_.sole[side];
  const Pose& b = goal_.sole[side];
  const double rise = b.p.z() - a.p.z();
  // Edges are cleared by moving forward late on the way up and early on the way down.
  double begin = 0.0;
  double end = 1.0;
  const bool lands = goal_.contact[side];
  if (goal_.kind == SegmentKind::step && rise > kLevel) begin = 0.3;
  if (goal_.kind == SegmentKind::step && rise < -kLevel) end = 0.7;
  if (goal_.kind == SegmentKind::lift) begin = 0.2;
  if (goal_.kind == SegmentKind::lower) end = 0.8;
  const double s = smooth_step(t - begin * duration, (end - begin) * duration).x;
  Pose pose;
  pose.p = a.p + s * (b.p - a.p);
  const double bow = 16.0 * s * s * (1.0 - s) * (1.0 - s);
  pose.p += from_.sole[other(side)].R * Vec3(0, sign_of(side) * outward_ * bow, 0);
  pose.R = interpolate(a.R, b.R, s);
  if (goal_.kind == SegmentKind::step && lands) {
    // Up to the apex and down again: two quintics, smooth to the second derivative.
    const double apex = std::max(a.p.z(), b.p.z()) + robot_->profile().swing.clearance;
    const double up = rise < -kLevel ? 0.4 * duration : (rise > kLevel ? 0.6 * duration : 0.5 * duration);
    pose.p.z() = t < up ? a.p.z() + (apex - a.p.z()) * smooth_step(t, up).x
                        : apex + (b.p.z() - apex) * smooth_step(t - up, duration - up).x;
  } else {
    pose.p.z() = a.p.z() + rise * smooth_step(t, duration).x;
  }
  return pose;
}

IkTargets Segment::targets(const ComPath& path, int tick, int ticks) const {
  const double period = path.duration() / ticks;
  const double T = path.duration();
  const double t = tick * period;
  IkTargets targets;
  targets.com = path.at(t).p;
  targets.sole = from_.sole;
  if (goal_.swing) {
    const std::vector<int> borders = phase_borders(com_.phases, ticks);
    const Side side = *goal_.swing;
    for (std::size_t i = 0; i < contact_.size(); ++i) {
      if (contact_[i][side]) continue;
      const int begin = borders[i];
      const int end = borders[i + 1];
      if (tick >= end) {
        targets.sole[side] = goal_.sole[side];
      } else if (tick > begin) {
        targets.sole[side] = swing((tick - begin) * period, (end - begin) * period);
      }
    }
  }
  const double s = smooth_step(t, T).x;
  targets.trunk = interpolate(from_.trunk, goal_.trunk, s);
  for (const Side side : kSides) {
    if (!goal_.hand[side]) continue;
    const Pose& a = from_.hand[side];
    const Pose& b = *goal_.hand[side];
    targets.hand[side] = Pose{a.p + s * (b.p - a.p), interpolate(a.R, b.R, s)};
  }
  const auto start = from_.q.tail(goal_.arms.size());
  targets.arms = start + s * (goal_.arms - start);
  return targets;
}

}  // namespace baton
