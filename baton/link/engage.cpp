#include "baton/link/engage.hpp"

#include <fmt/format.h>

#include <cmath>

#include "baton/balance/check_limits.hpp"
#include "baton/ik/stand.hpp"
#include "baton/model/contact.hpp"
#include "baton/model/error.hpp"

namespace baton::link {
namespace {

constexpr double kNear = 0.15;   ///< largest difference of a joint from the stance; zero errors and sag are less [rad]
constexpr double kLevel = 0.06;  ///< inclination of a sole against the other that zero errors may explain [rad]
constexpr double kSame = 0.02;   ///< difference of their heights [COM height]
constexpr double kUnit = 0.15;   ///< how near to 1 a specific force is, at rest, if it is in units of g

}  // namespace

bool in_stance(const RobotModel& robot, const VecX& q) {
  const VecX stance = stand(robot, Pose{}, robot.profile().stance.com_height).q.tail(q.size());
  return ((q - stance).array().abs() <= kNear).all();  // not so if one is not a number
}

std::optional<std::string> lacks(const Measurement& measured, StateSource source) {
  const auto because = [&](const char* lacks, const char* must) {
    return fmt::format("--state {}: measures no {}: must be {}", to_string(source), lacks, must);
  };
  const auto feels = [&](Side side) { return !measured.sole[side].force.array().isNaN().all(); };
  if (source == StateSource::sensors && !feels(Side::left) && !feels(Side::right))
    return because("forces on its soles", "--state torques");
  if (source == StateSource::torques && measured.torque.size() == 0) return because("motor torques", "--state sensors");
  if (source == StateSource::perfect && !measured.root)
    return because("pose of its root", "--state sensors or torques");
  return std::nullopt;
}

std::optional<std::string> in_other_units(const Measurement& at_rest, StateSource source) {
  const double force = at_rest.imu.acceleration.norm();
  if (source != StateSource::perfect && std::abs(force - 1.0) < kUnit)
    return fmt::format("its accelerometer reads {:.2f} at rest: must be in m/s², about 9.8, not in units of g", force);
  return std::nullopt;
}

Posture engage(const RobotModel& robot, const Pose& start, const VecX& q) {
  const double height = robot.profile().stance.com_height;
  if (in_stance(robot, q)) return stand(robot, start, height);
  for (std::size_t j = 0; j < robot.joints().size(); ++j) {
    const Joint& joint = robot.joints()[j];
    const double angle = q[static_cast<Eigen::Index>(j)];
    if (!(angle >= joint.position.lo - check::kBeyondRange && angle <= joint.position.hi + check::kBeyondRange))
      throw InputError(fmt::format("{}: {} is at {:.4g} rad: must be within its range, {:.4g} to {:.4g} rad",
                                   robot.profile().name, joint.name, angle, joint.position.lo, joint.position.hi));
  }
  VecX whole = VecX::Zero(robot.nq());
  whole[3] = 1.0;
  whole.tail(q.size()) = q;
  const BySide<Pose> sole = posture_of(robot, whole).sole;
  const Vec3 up = (sole.left.R.col(2) + sole.right.R.col(2)).normalized();
  const double inclined = tilt_of(sole.left.R.transpose() * sole.right.R);
  if (!(inclined <= kLevel))
    throw InputError(
        fmt::format("{}: with its joints as they are, one sole is inclined by {:.3f} rad against the other: "
                    "must be at most {}; let it stand on both soles",
                    robot.profile().name, inclined, kLevel));
  const double higher = std::abs(up.dot(sole.left.p - sole.right.p));
  if (!(higher <= kSame * height))
    throw InputError(
        fmt::format("{}: with its joints as they are, one sole is {:.4f} m above the other: must be at most "
                    "{:.4f} m; let it stand on both soles",
                    robot.profile().name, higher, kSame * height));
  // The frame in the middle of the soles, its z along their normals, goes to the start.
  const Vec3 ahead = sole.left.R.col(0) + sole.right.R.col(0);
  Pose middle;
  middle.p = 0.5 * (sole.left.p + sole.right.p);
  middle.R.col(2) = up;
  middle.R.col(1) = up.cross(ahead).normalized();
  middle.R.col(0) = middle.R.col(1).cross(up);
  set_root(whole, start * middle.inverse());
  Posture posture = posture_of(robot, whole);
  const ConvexPolygon support =
      support_polygon(robot, posture.sole, posture.contact, posture.com, support_plane(posture.sole, posture.contact));
  if (!(support.margin(posture.com.head<2>()) >= robot.profile().margin.zmp_feedback))
    throw InputError(fmt::format("{}: with its joints as they are, its COM is not above its soles: it would tip over",
                                 robot.profile().name));
  return posture;
}

}  // namespace baton::link
