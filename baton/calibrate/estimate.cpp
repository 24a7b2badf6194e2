#include "baton/calibrate/estimate.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "baton/model/error.hpp"
#include "baton/model/kinematics.hpp"
#include "baton/robot/plant.hpp"

namespace baton {
namespace {

// Standard deviations of what a rest tells.
constexpr double kEncoder = 5e-4;  ///< joint angle, by steps of the encoder and noise [rad]
constexpr double kTilt = 1e-3;     ///< sole that stands, against the horizontal [rad]
constexpr double kTurn = 1e-3;     ///< one sole that stands against the other, since the last step [rad]
constexpr double kPlace = 6e-4;    ///< the same, along the ground [COM height]
constexpr double kHeight = 4e-4;   ///< the same, upward [COM height]
constexpr double kLoad = 5e-3;     ///< sum of the vertical forces [weight]
constexpr double kZmp = 4e-3;      ///< measured ZMP [COM height]
constexpr double kEmpty = 3e-3;    ///< force on a sole in the air [weight]
constexpr double kLoaded = 0.02;   ///< torque from which a motor is at an end of its play [stall torque]
// Standard deviations of what is unknown before, beside what the profile says.
constexpr double kComOffset = 0.01;   ///< COM against the model's [COM height]
constexpr double kStancePlace = 0.2;  ///< one sole to the other, against the encoders [COM height]
constexpr double kStanceTurn = 0.2;   ///< the same [rad]
constexpr double kLeastBound = 1e-6;  ///< what the profile says to be exact is nearly so
constexpr int kMostIterations = 20;
constexpr double kDone = 1e-6;  ///< last step [standard deviations]
constexpr double kStep = 1e-3;  ///< for derivatives [standard deviations]

/// Standard deviation of what is spread evenly within ± bound.
double even(double bound) {
  return std::max(bound, kLeastBound) / std::sqrt(3.0);
}

/// What is estimated: what the caller asks for, and what has to be known for that.
struct Unknowns {
  Calibration errors;
  double play = 0.0;
  double yield = 0.0;
  Vec2 com_offset = Vec2::Zero();  ///< in the axes of the root [COM height]
  /// Where the right sole stands in the left one's frame, against what the encoders say, for each stance: x, y [COM
  /// height], yaw [rad].
  std::vector<Vec3> stance;
};

class Problem {
 public:
  Problem(const RobotModel& robot, std::span<const Rest> rests)
      : robot_(&robot),
        rests_(rests),
        kinematics_(robot),
        q_(VecX::Zero(robot.nq())),
        height_(robot.profile().stance.com_height),
        weight_(robot.mass() * kGravity),
        joints_(leg_joints(robot)),
        hips_{abduction(robot, Side::left), abduction(robot, Side::right)} {
    q_[3] = 1.0;
    int stances = 0;
    for (const Rest& rest : rests)
      stances = std::max(stances, rest.stance + 1);
    none_.errors = Calibration::none(robot.nv() - 6);
    none_.stance.assign(static_cast<std::size_t>(stances), Vec3::Zero());
    seen_ = none_.stance;
    for (const Rest& rest : rests) {
      set(rest, none_);
      if (on_both(rest)) seen_[static_cast<std::size_t>(rest.stance)] = right_in_left();
    }
    for (const Rest& rest : rests)
      whitening_.push_back(whitening(rest));
  }

  /// Calls `visit(value, sigma)` with each unknown and its standard deviation before the rests.
  template <typename Visit>
  void each(Unknowns& x, const Visit& visit) const {
    const SensorErrors& sensors = robot_->profile().sensors;
    const ActuatorErrors& actuators = robot_->profile().actuators;
    for (const int j : joints_)
      visit(x.errors.encoder_zero[j], even(sensors.encoder_offset));
    for (double& tilt : x.errors.imu_mount)
      visit(tilt, std::max(sensors.imu_mount, kLeastBound) * M_SQRT1_2);  // in a random direction
    for (const Side side : kSides) {
      visit(x.errors.force_gain[side], even(sensors.force_gain));
      for (double& zero : x.errors.force_zero[side])
        visit(zero, even(sensors.force_zero) * weight_);
    }
    visit(x.play, std::max(actuators.backlash, kLeastBound));
    visit(x.yield, std::max(actuators.hip_compliance, kLeastBound));
    for (double& offset : x.com_offset)
      visit(offset, kComOffset);
    for (Vec3& stance : x.stance) {
      visit(stance.x(), kStancePlace);
      visit(stance.y(), kStancePlace);
      visit(stance.z(), kStanceTurn);
    }
  }

  [[nodiscard]] Eigen::Index size() const {
    Eigen::Index n = 0;
    Unknowns any = none_;
    each(any, [&n](double&, double) { ++n; });
    return n;
  }

  /// Unknowns that are so many standard deviations from none.
  [[nodiscard]] Unknowns at(const VecX& deviations) const {
    Unknowns x = none_;
    Eigen::Index i = 0;
    each(x, [&](double& value, double sigma) { value += sigma * deviations[i++]; });
    return x;
  }

  /// Standard deviations, given relative to those before the rests.
  [[nodiscard]] Unknowns sigmas(const VecX& relative) const {
    Unknowns x = none_;
    x.errors.encoder_zero.setConstant(even(robot_->profile().sensors.encoder_offset));  // of joints that are left out
    Eigen::Index i = 0;
    each(x, [&](double& value, double sigma) { value = sigma * relative[i++]; });
    return x;
  }

  /// By how much all rests contradict these unknowns, in standard deviations.
  [[nodiscard]] VecX residuals(const Unknowns& x) {
    std::vector<double> all;
    for (std::size_t i = 0; i < rests_.size(); ++i)
      judge(rests_[i], whitening_[i], x, all);
    return Eigen::Map<const VecX>(all.data(), static_cast<Eigen::Index>(all.size()));
  }

 private:
  static bool on_both(const Rest& rest) { return rest.contact.left && rest.contact.right; }

  /// Where each motor is in its play, from −1 to 1 (n): at the end towards which it pushes.
  [[nodiscard]] VecX side_in_play(const Rest& rest) const {
    VecX side(rest.torque.size());
    for (Eigen::Index j = 0; j < side.size(); ++j) {
      const double stall = robot_->joints()[static_cast<std::size_t>(j)].motor.stall;
      side[j] = std::clamp(rest.torque[j] / (kLoaded * stall), -1.0, 1.0);
    }
    return side;
  }

  /// Sets the kinematics, with the root at the origin, to where the links are.
  void set(const Rest& rest, const Unknowns& x) {
    const Eigen::Index n = rest.q.size();
    q_.tail(n) = rest.q - x.errors.encoder_zero - x.play * side_in_play(rest);
    for (const int hip : hips_)
      q_[7 + hip] -= x.yield * rest.torque[hip] / (weight_ * height_);
    kinematics_.set(q_);
  }

  /// x, y [COM height], yaw [rad].
  [[nodiscard]] Vec3 right_in_left() const {
    const Pose right = kinematics_.sole(Side::left).inverse() * kinematics_.sole(Side::right);
    return {right.p.x() / height_, right.p.y() / height_, yaw_of(right.R)};
  }

  /// The vertical in the root frame.
  [[nodiscard]] Vec3 up(const Rest& rest, const Unknowns& x) const {
    Measurement measurement;
    measurement.q = rest.q;
    measurement.imu.acceleration = rest.acceleration;
    return (robot_->imu_in_root()->R * without_errors(measurement, x.errors).imu.acceleration).normalized();
  }

  /// Soles that stand are level; two of them are equally high, and stay where they are to each other. Requires `set`.
  [[nodiscard]] VecX geometry(const Rest& rest, const Unknowns& x, const Vec3& vertical) const {
    VecX all(on_both(rest) ? 8 : 2);
    Eigen::Index i = 0;
    for (const Side side : kSides) {
      if (!rest.contact[side]) continue;
      all.segment<2>(i) = (kinematics_.sole(side).R.transpose() * vertical).head<2>();
      i += 2;
    }
    if (!on_both(rest)) return all;
    const auto stance = static_cast<std::size_t>(rest.stance);
    all.segment<3>(4) = right_in_left() - seen_[stance] - x.stance[stance];
    all[6] = wrap_angle(all[6]);
    all[7] = (kinematics_.sole(Side::right).p - kinematics_.sole(Side::left).p).dot(vertical) / height_;
    return all;
  }

  /// The factor that makes the covariance of a rest's `geometry` the identity. Where a motor pushes so little that it
  /// may be anywhere in its play, the joint's angle is uncertain by the play.
  [[nodiscard]] MatX whitening(const Rest& rest) {
    constexpr double angle = 1e-4;
    const Vec3 vertical = up(rest, none_);
    const VecX sigma{{kTilt, kTilt, kTilt, kTilt, kPlace, kPlace, kTurn, kHeight}};
    MatX covariance = sigma.head(on_both(rest) ? 8 : 2).cwiseAbs2().asDiagonal();
    const auto moved = [&](int joint, double by) {
      Rest other = rest;
      other.q[joint] += by;
      set(other, none_);
      return geometry(other, none_, vertical);
    };
    const VecX in_play = side_in_play(rest);
    const double play = robot_->profile().actuators.backlash;
    for (const int j : joints_) {
      const VecX by = (moved(j, angle) - moved(j, -angle)) / (2.0 * angle);
      const double unsure = play * play * (1.0 - in_play[j] * in_play[j]);
      covariance += (kEncoder * kEncoder + unsure) * by * by.transpose();
    }
    return covariance.llt().matrixL().solve(MatX::Identity(covariance.rows(), covariance.rows()));
  }

  /// Appends the residuals of one rest.
  void judge(const Rest& rest, const MatX& whitening, const Unknowns& x, std::vector<double>& all) {
    set(rest, x);
    const Vec3 vertical = up(rest, x);
    const VecX off = whitening * geometry(rest, x, vertical);
    all.insert(all.end(), off.begin(), off.end());
    const BySide<Pose> sole{kinematics_.sole(Side::left), kinematics_.sole(Side::right)};
    Wrench total;
    for (const Side side : kSides) {
      const Vec3 force = (rest.sole[side].force - x.errors.force_zero[side]) / x.errors.force_gain[side];
      if (rest.contact[side]) {
        total.force += sole[side].R * force;
        total.moment += sole[side].R * rest.sole[side].moment / x.errors.force_gain[side] +
                        sole[side].p.cross(sole[side].R * force);
      } else {
        for (const double empty : force)
          all.push_back(empty / (kEmpty * weight_));
      }
    }
    all.push_back((total.force.dot(vertical) / weight_ - 1.0) / kLoad);
    // In axes with z up.
    const Mat3 level = Eigen::Quaterniond::FromTwoVectors(vertical, Vec3::UnitZ()).toRotationMatrix();
    const double ground = (level * sole[rest.contact.left ? Side::left : Side::right].p).z();
    const Vec2 zmp = Wrench{level * total.force, level * total.moment}.zmp(ground);
    const Vec2 apart = (zmp - (level * kinematics_.com()).head<2>()) / height_ - x.com_offset;
    all.insert(all.end(), {apart.x() / kZmp, apart.y() / kZmp});
  }

  const RobotModel* robot_;
  std::span<const Rest> rests_;
  Kinematics kinematics_;
  VecX q_;
  double height_;            ///< [m]
  double weight_;            ///< [N]
  std::vector<int> joints_;  ///< of the legs
  std::array<int, 2> hips_;
  Unknowns none_;
  std::vector<Vec3> seen_;       ///< where the right sole stands by the encoders, for each stance
  std::vector<MatX> whitening_;  ///< for each rest
};

}  // namespace

std::vector<int> leg_joints(const RobotModel& robot) {
  std::vector<int> joints = robot.leg(Side::left);
  for (const int j : robot.leg(Side::right)) {
    if (std::find(joints.begin(), joints.end(), j) == joints.end()) joints.push_back(j);  // a waist moves both
  }
  return joints;
}

Estimate estimate(const RobotModel& robot, std::span<const Rest> rests) {
  const std::string& name = robot.profile().name;
  if (!robot.imu_in_root()) throw InputError(fmt::format("robot {}: calibration needs an IMU on its root", name));
  Problem problem(robot, rests);
  const Eigen::Index n = problem.size();
  VecX x = VecX::Zero(n);  // [standard deviations before the rests]
  VecX off = problem.residuals(problem.at(x));
  MatX jacobian(off.size(), n);
  Eigen::LDLT<MatX> information;
  for (int k = 0; k < kMostIterations; ++k) {
    for (Eigen::Index i = 0; i < n; ++i) {
      const VecX by = kStep * VecX::Unit(n, i);
      jacobian.col(i) = (problem.residuals(problem.at(x + by)) - problem.residuals(problem.at(x - by))) / (2.0 * kStep);
    }
    information.compute(jacobian.transpose() * jacobian + MatX::Identity(n, n));
    const VecX step = information.solve(jacobian.transpose() * off + x);
    x -= step;
    off = problem.residuals(problem.at(x));
    if (!(step.norm() > kDone)) break;
  }
  if (!x.allFinite() || !off.allFinite())
    throw InputError(fmt::format("robot {}: no errors of its sensors explain what they read at rest", name));
  const Unknowns best = problem.at(x);
  const Unknowns sigma = problem.sigmas(information.solve(MatX::Identity(n, n)).diagonal().cwiseSqrt());
  const double misfit = std::sqrt(off.squaredNorm() / static_cast<double>(std::max<Eigen::Index>(1, off.size())));
  return {best.errors, sigma.errors, problem.sigmas(VecX::Ones(n)).errors, best.play, sigma.play, best.yield,
          sigma.yield, misfit};
}

}  // namespace baton
