#include "baton/navigate/watch.hpp"

#include <algorithm>
#include <cmath>

#include "baton/navigate/drift.hpp"

namespace baton {
namespace {

constexpr double kDisturbed = 0.02;     ///< error of the DCM from which nothing new is begun [COM height]
constexpr double kNarrow = 0.35;        ///< the same, if that is less [half-width of a sole]
constexpr double kRecovered = 0.01;     ///< error below which the robot is no longer disturbed [COM height]
constexpr double kSteady = 12.0;        ///< low-pass of the DCM error's steady part [1/ω]
constexpr double kMostSteady = 0.06;    ///< bound of the steady part [COM height]
constexpr double kSinks = 4e-3;         ///< difference of heights that is how soles sink [COM height]
constexpr double kFallenTilt = 0.7;     ///< inclination of the trunk from which it falls [rad]
constexpr double kFallenHeight = 0.58;  ///< height of the COM below which it falls [nominal]
constexpr double kFalling = 0.09;       ///< time for which that has to last, for a fall to be certain [1/ω]
constexpr double kLifted = 0.1;         ///< load of the soles below which the robot is held by someone [weight]
constexpr double kStands = 0.5;         ///< load from which it stands again [weight]
constexpr double kLifting = 0.9;        ///< time for which that has to last [1/ω]
constexpr double kStill = 6.0;          ///< time for which a robot that was stood up has to be still [1/ω]
constexpr double kStillSpeed = 0.016;   ///< and its COM slower than this [COM height × ω]
constexpr double kCarries = 0.2;        ///< load of a sole that carries [weight]
constexpr double kUneven = 0.015;       ///< inclination from which the ground is not what the map says [rad]
constexpr double kForgets = 60.0;       ///< time constant with which that is forgotten [1/ω]

}  // namespace

Watch::Watch(const RobotModel& robot, const World& world, StateSource source, const Posture& start)
    : robot_(&robot),
      sensors_(robot, source),
      odometry_(robot, world, source, start),
      estimator_(robot),
      thermometer_(robot) {}

void Watch::estimate(const Measurement& measurement, const MotionSample& planned, const Pose& anchor) {
  measured_ = &odometry_.update(sensors_.check(measurement, planned), planned);
  state_ = &estimator_.update(*measured_, anchor, odometry_.kinematics());
}

void Watch::change_frame(const MotionSample& planned, const Pose& anchor) {
  state_ = &estimator_.update(*measured_, anchor, odometry_.kinematics());
  update_slip(planned, anchor);
}

void Watch::judge(const MotionSample& planned, const Pose& anchor, bool centred) {
  update_guard(centred);
  if (soft()) return;
  update_disturbed(planned, anchor);
  update_slip(planned, anchor);
  update_inclination(planned);
}

void Watch::update_guard(bool centred) {
  const double height = robot_->profile().stance.com_height;
  const double carried = this->carried();
  const double lower = std::min(state_->sole.left.p.z(), state_->sole.right.p.z());
  // Negated, so that an estimate that is not a number counts as a fall.
  const bool falls = !(tilt_of(state_->trunk) <= kFallenTilt && state_->com.z() - lower >= kFallenHeight * height);
  const auto lasting = [this](int& ticks, bool condition, double time) {
    ticks = condition ? ticks + 1 : 0;
    return ticks * robot_->profile().tick.period * robot_->omega() >= time;
  };
  const auto lasts = [&](bool condition, double time) { return lasting(guard_ticks_, condition, time); };
  switch (guard_) {
    case Guard::armed:
      if (lasting(falling_ticks_, falls, kFalling)) return fall();
      if (lasts(carried < kLifted, kLifting)) guard_ = Guard::lifted;
      break;
    case Guard::lifted:
      if (lasts(carried > kStands && feels() && centred, kLifting)) guard_ = Guard::armed;
      break;
    case Guard::fallen:
      if (lasts(stands_upright(), kStill)) guard_ = Guard::stood_up;
      break;
    case Guard::stood_up:
      if (!stands_upright()) guard_ = Guard::fallen;
      break;
  }
}

double Watch::carried() const {
  const BySide<double>& load = odometry_.load();
  return (load.left + load.right) / (robot_->mass() * kGravity);
}

double Watch::stands() const {
  if (guard_ != Guard::lifted) return 1.0;
  return feels() ? std::clamp(carried() / kStands, 0.0, 1.0) : 0.0;
}

bool Watch::feels() const {
  return sensors_.health(Sensor::forces) == Health::good && sensors_.health(Sensor::torques) == Health::good;
}

void Watch::fall() {
  guard_ = Guard::fallen;
  guard_ticks_ = falling_ticks_ = 0;
  disturbed_ = slip_.now = slip_.found = false;
  dcm_error_.setZero();
  steady_dcm_error_.setZero();
}

void Watch::arm() {
  guard_ = Guard::armed;
  inclination_ = 0.0;
}

void Watch::update_disturbed(const MotionSample& planned, const Pose& anchor) {
  const double omega = robot_->omega();
  const Vec3 error = state_->dcm(omega) - slid(planned) * Vec3(planned.com + planned.dcom / omega);
  const Eigen::Rotation2Dd heading(mean_yaw(planned.sole));
  const Vec2 off = heading.inverse() * error.head<2>();
  const double height = robot_->profile().stance.com_height;
  const double follows = omega * robot_->profile().tick.period / kSteady;
  steady_dcm_error_ = bounded(Vec2(steady_dcm_error_ + follows * (off - steady_dcm_error_)), kMostSteady * height);
  const Vec2 rest = heading * Vec2(off - steady_dcm_error_);
  dcm_error_ = (anchor.R * Vec3(rest.x(), rest.y(), 0)).head<2>();
  const double most = std::min(kDisturbed * height, kNarrow * robot_->sole_half_width());
  disturbed_ = dcm_error_.norm() > (disturbed_ ? std::min(most, kRecovered * height) : most);
}

void Watch::update_slip(const MotionSample& planned, const Pose& anchor) {
  slip_.found = false;
  for (const Side side : kSides) {
    if (planned.contact[side] && !odometry_.touch()[side]) return;  // only what stands can slide
  }
  const double distance = distance_at(anchor * slid(planned), anchor, planned.com);
  const bool slipped = distance > kSlip * robot_->profile().reach.foot;
  if (slipped && !slip_.now) ++slip_.count;
  slip_.now = slip_.found = slipped;
  if (slipped) slip_.distance = distance;
}

void Watch::update_inclination(const MotionSample& planned) {
  inclination_ *= 1.0 - robot_->omega() * robot_->profile().tick.period / kForgets;
  const double carries = kCarries * robot_->mass() * kGravity;
  for (const Side side : kSides) {
    if (!planned.contact[side] || odometry_.load()[side] < carries) continue;
    inclination_ = std::max(inclination_, tilt_of(planned.sole[side].R.transpose() * state_->sole[side].R));
  }
}

bool Watch::uneven() const {
  return inclination_ > kUneven;
}

Pose Watch::slid(const MotionSample& planned, const BySide<bool>& stands) const {
  Pose slid = anchor_correction(planned.sole, state_->sole, stands);
  // A frame that followed how soles sink would bring every next step down by that: ways back would end in the air.
  const double most = kSinks * robot_->profile().stance.com_height;
  slid.p.z() -= std::clamp(slid.p.z(), -most, most);
  return slid;
}

std::optional<Terrain::Inclined> Watch::inclined_sole(const MotionSample& planned) const {
  if (!planned.contact.left || !planned.contact.right) return std::nullopt;
  BySide<double> angle;
  for (const Side side : kSides) {
    const Mat3 turned = planned.sole[side].R.transpose() * state_->sole[side].R;
    angle[side] = odometry_.touch()[side] ? tilt_of(turned) : 0.0;
  }
  const Side side = angle.left > angle.right ? Side::left : Side::right;
  if (angle[side] <= kFlatSole) return std::nullopt;
  return Terrain::Inclined{side, angle[side]};
}

bool Watch::stands_upright() const {
  const Profile& profile = robot_->profile();
  const double weight = robot_->mass() * kGravity;
  bool stands = tilt_of(state_->trunk) < profile.region.trunk_inclination &&
                state_->dcom.norm() < kStillSpeed * robot_->omega() * profile.stance.com_height;
  for (const Side side : kSides)
    stands = stands && odometry_.load()[side] > kCarries * weight && tilt_of(state_->sole[side].R) < kFlatSole;
  return stands;
}

bool Watch::supported() const {
  const BySide<bool> both{true, true};
  const ConvexPolygon support =
      support_polygon(*robot_, state_->sole, both, state_->com, support_plane(state_->sole, both));
  return support.margin(state_->com.head<2>()) > robot_->profile().margin.stand_on;
}

}  // namespace baton
