#include "baton/link/hanging.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "baton/ik/stand.hpp"
#include "baton/model/contact.hpp"
#include "baton/model/error.hpp"

namespace baton::link {
namespace {

constexpr double kOutside = 0.1;      ///< of its range, by which a joint may begin [rad]
constexpr double kCheckEvery = 0.02;  ///< of the way, between two checks of distances [rad]
constexpr double kSlides = 0.01;      ///< by which links that are too close may come closer [COM height]
constexpr double kCarries = 0.1;      ///< load of the soles from which the robot does not hang [weight]
constexpr double kOff = 0.15;         ///< largest difference of a joint from where it should be at the end [rad]
constexpr double kCarrying = 0.1;     ///< time for which that has to last [s]
constexpr double kSettles = 0.5;      ///< time at the stance before that is looked at [s]
constexpr double kPeak = 1.875;       ///< largest speed of a minimum-jerk way, of its mean

struct Progress {
  double share, rate;
};

/// Of a minimum-jerk way, at x from 0 to 1.
Progress progress(double x) {
  return {x * x * x * (10.0 - 15.0 * x + 6.0 * x * x), 30.0 * x * x * (1.0 - x) * (1.0 - x)};
}

}  // namespace

WayToStance::WayToStance(const RobotModel& robot, const VecX& q) : robot_(&robot) {
  for (std::size_t j = 0; j < robot.joints().size(); ++j) {
    const Joint& joint = robot.joints()[j];
    const double angle = q[static_cast<Eigen::Index>(j)];
    if (!(angle >= joint.position.lo - kOutside && angle <= joint.position.hi + kOutside))
      throw InputError(fmt::format("{}: {} is at {:.3f} rad: must be within {:.3f} to {:.3f}", robot.profile().name,
                                   joint.name, angle, joint.position.lo, joint.position.hi));
  }
  from_ = q;
  const MotionSample stance = resting(robot, stand(robot, Pose{}, robot.profile().stance.com_height));
  way_ = stance.q.tail(q.size()) - q;
  Kinematics kinematics(robot);
  kinematics.set(stance.q);
  BySide<Wrench> halves = share_wrench(robot, stance.sole, stance.contact, ground_wrench(kinematics, stance.force));
  scale_ankle_moments(kinematics, 0.0, halves);
  joint_torques(kinematics, stance.force, halves, torque_);
  duration_ = std::max(kQuickest, kPeak * way_.cwiseAbs().maxCoeff() / kFastest);
  check(q);
}

void WayToStance::check(const VecX& q) {
  Kinematics kinematics(*robot_);
  VecX whole = VecX::Zero(robot_->nq());
  whole[3] = 1.0;
  const double margin = robot_->profile().margin.self_collision;
  const int steps = 1 + static_cast<int>(way_.cwiseAbs().maxCoeff() / kCheckEvery);
  double least = 0.0;
  for (int step = 0; step <= steps; ++step) {
    whole.tail(q.size()) = q + way_ * step / steps;
    kinematics.set(whole);
    std::array<int, 2> pair{-1, -1};
    const double distance = kinematics.self_distance(margin, &pair);
    // Limp arms lie against the body: what touches already may slide along it, until it has parted.
    if (step == 0) least = distance - kSlides * robot_->profile().stance.com_height;
    if (distance >= margin) least = margin;
    if (distance < least)
      throw InputError(fmt::format("{}: on the way to its stance {} would come within {:.1f} mm of {}: move them apart",
                                   robot_->profile().name, name_of(robot_->mj(), mjOBJ_GEOM, pair[0]),
                                   1e3 * std::max(distance, 0.0), name_of(robot_->mj(), mjOBJ_GEOM, pair[1])));
  }
}

VecX WayToStance::off(const VecX& q) const {
  VecX off = from_ + way_ - q;
  for (Eigen::Index j = 0; j < off.size(); ++j)
    off[j] += torque_[j] / robot_->joints()[static_cast<std::size_t>(j)].gains.kp;
  return off;
}

JointTarget WayToStance::next() {
  t_ = std::min(t_ + robot_->profile().tick.period, duration_);
  const Progress at = progress(t_ / duration_);
  const VecX zero = VecX::Zero(way_.size());
  JointTarget target{from_ + at.share * way_, at.rate / duration_ * way_, zero, zero, {true, true}, {}};
  target.tau = at.share * torque_;
  return target;
}

JointTarget take_stance(const RobotModel& model, RemoteRobot& robot, const Calibration& errors,
                        const std::function<bool()>& go_on) {
  const double period = model.profile().tick.period;
  robot.catch_up();  // what was measured while all was prepared
  WayToStance way(model, without_errors(robot.read(), errors).q);
  const auto given_up = [&](const std::string& why) { return LinkError(robot.address().text() + ": " + why); };
  JointTarget target;
  double carries = 0.0;
  for (double held = 0.0; held < kSettles; held += way.done() ? period : 0.0) {
    if (!go_on()) throw given_up("interrupted on the way to the stance: the robot is handed back as it is");
    robot.catch_up();
    target = way.next();
    target.q += errors.encoder_zero;
    robot.write(target);
    if (const std::string why = robot.follows_no_longer(); !why.empty()) throw LinkError(why);
    double load = 0.0;
    for (const Side side : kSides)
      load += std::fmax(robot.read().sole[side].force.z(), 0.0);  // 0 without such a sensor
    carries = load > kCarries * model.mass() * kGravity ? carries + period : 0.0;
    if (carries > kCarrying)
      throw InputError(
          fmt::format("--gantry: the soles carry {:.0f} N: the robot must hang, with its feet in the air", load));
  }
  const VecX off = way.off(without_errors(robot.read(), errors).q);
  Eigen::Index joint = 0;
  if (off.cwiseAbs().maxCoeff(&joint) <= kOff) return target;
  throw given_up(fmt::format("{} is {:.3f} rad from the stance: must be within {}; is something in its way?",
                             model.joints()[static_cast<std::size_t>(joint)].name, off[joint], kOff));
}

}  // namespace baton::link
