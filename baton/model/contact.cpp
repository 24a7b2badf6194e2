#include "baton/model/contact.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace baton {

Vec2 Wrench::zmp(double height) const {
  if (!(force.z() > 0.0)) return Vec2::Constant(std::numeric_limits<double>::quiet_NaN());
  const Vec3 m = moment_about({0, 0, height});
  return {-m.y() / force.z(), m.x() / force.z()};
}

Wrench ground_wrench(const Kinematics& kinematics, const VecX& force) {
  const Pose root = kinematics.body(1);
  Wrench wrench;
  wrench.force = force.head<3>();
  wrench.moment = root.R * force.segment<3>(3) + root.p.cross(wrench.force);
  return wrench;
}

Wrench with_com_offset(Wrench wrench, const Vec2& offset) {
  wrench.moment += Vec3(offset.x(), offset.y(), 0.0).cross(Vec3(0.0, 0.0, wrench.force.z()));
  return wrench;
}

ConvexPolygon sole_outline(const RobotModel& robot, Side side, const Pose& sole) {
  std::vector<Vec2> points;
  for (const Vec2& vertex : robot.sole(side).vertices()) {
    points.push_back((sole * Vec3(vertex.x(), vertex.y(), 0)).head<2>());
  }
  return ConvexPolygon::hull(points);
}

ConvexPolygon support_polygon(const RobotModel& robot, const BySide<Pose>& sole, const BySide<bool>& contact,
                              const Vec3& com, double height) {
  std::vector<Vec2> points;
  for (const Side side : kSides) {
    if (!contact[side]) continue;
    for (const Vec2& vertex : robot.support(side).vertices()) {
      const Vec3 c = sole[side] * Vec3(vertex.x(), vertex.y(), 0);
      points.push_back((com + (c - com) * ((com.z() - height) / (com.z() - c.z()))).head<2>());
    }
  }
  return ConvexPolygon::hull(points);
}

bool on_one_plane(const BySide<Pose>& sole, const BySide<bool>& contact, double height) {
  constexpr double kSame = 1e-9;    // [m]
  constexpr double kLevel = 1e-12;  // 1 − cos(tilt)
  return std::all_of(kSides.begin(), kSides.end(), [&](Side side) {
    const Pose& pose = sole[side];
    return !contact[side] || (std::abs(pose.p.z() - height) < kSame && 1.0 - pose.R(2, 2) < kLevel);
  });
}

double support_plane(const BySide<Pose>& sole, const BySide<bool>& contact) {
  if (contact.left && contact.right) return std::min(sole.left.p.z(), sole.right.p.z());
  return contact.left ? sole.left.p.z() : sole.right.p.z();
}

BySide<Wrench> share_wrench(const RobotModel& robot, const BySide<Pose>& sole, const BySide<bool>& contact,
                            const Wrench& total) {
  BySide<double> load{contact.left ? 1.0 : 0.0, contact.right ? 1.0 : 0.0};
  if (contact.left && contact.right) {
    // In a frame scaled by the sole's half sizes, the right sole's share is the projection of the ZMP on the line
    // between the soles. This minimises the offset of the centre of pressure, which both soles have in common.
    const double height = support_plane(sole, contact);
    Vec2 half = Vec2::Zero();
    for (const Vec2& vertex : robot.sole(Side::left).vertices())
      half = half.cwiseMax(vertex.cwiseAbs());
    const Mat3 to_feet = rotation_z(-mean_yaw(sole));
    const auto scaled = [&](const Vec3& x) -> Vec2 { return (to_feet * x).head<2>().cwiseQuotient(half); };
    const Vec2 zmp = total.zmp(height);
    const Vec2 line = scaled(sole.right.p - sole.left.p);
    const Vec2 offset = scaled(Vec3(zmp.x(), zmp.y(), 0) - sole.left.p);
    const double right = std::clamp(line.dot(offset) / line.squaredNorm(), 0.0, 1.0);
    load = {1.0 - right, std::isfinite(right) ? right : 0.5};
  }
  Vec3 rest = total.moment;  // moment not produced by the forces at the sole centres
  for (const Side side : kSides)
    rest -= sole[side].p.cross(load[side] * total.force);
  BySide<Wrench> shared;
  for (const Side side : kSides) {
    shared[side].force = load[side] * total.force;
    shared[side].moment = sole[side].p.cross(shared[side].force) + load[side] * rest;
  }
  return shared;
}

void joint_torques(const Kinematics& kinematics, const VecX& force, const BySide<Wrench>& contact, VecX& tau) {
  tau = force.tail(kinematics.robot().nv() - 6);
  subtract_contact(kinematics, contact, tau);
}

void scale_ankle_moments(const Kinematics& kinematics, double factor, BySide<Wrench>& contact) {
  for (const Side side : kSides) {
    const Vec3 ankle = kinematics.body(kinematics.robot().foot_body(side)).p;
    Wrench& wrench = contact[side];
    wrench.moment = ankle.cross(wrench.force) + factor * wrench.moment_about(ankle);
  }
}

void subtract_contact(const Kinematics& kinematics, const BySide<Wrench>& contact, VecX& tau) {
  const RobotModel& robot = kinematics.robot();
  for (const Side side : kSides) {
    if (contact[side].force.isZero(0.0)) continue;
    for (const int dof : robot.dofs_to(robot.foot_body(side))) {
      if (dof < 6) continue;
      const auto axis = kinematics.dof_axis(dof);
      tau[dof - 6] -= axis.direction.dot(contact[side].moment_about(axis.point));
    }
  }
}

}  // namespace baton
