#include "baton/robot/gantry.hpp"

#include <algorithm>
#include <array>
#include <cmath>

namespace baton {
namespace {

constexpr double kStretch = 0.02;   ///< of a rope that carries half of the robot [COM height]
constexpr double kSpeed = 0.03;     ///< of its upper end [√(g × COM height)]
constexpr double kUpright = 0.5;    ///< moment against the trunk's inclination [weight × COM height per rad]
constexpr double kTurning = 0.3;    ///< moment against its turning [weight × COM height × 1/ω]
constexpr double kSteadied = 0.25;  ///< damping of each shoulder's motion [mass × ω]

}  // namespace

Gantry::Gantry(const RobotModel& robot, const Kinematics& kinematics, const mjModel& model)
    : weight_(robot.mass() * kGravity), length_(robot.profile().stance.com_height) {
  speed_ = kSpeed * std::sqrt(kGravity * length_);
  damping_ = kSteadied * robot.mass() * robot.omega();
  turning_ = kTurning * weight_ * length_ / robot.omega();
  upright_ = kinematics.trunk().R;
  trunk_ = mj_name2id(&model, mjOBJ_BODY, name_of(robot.mj(), mjOBJ_BODY, robot.trunk_body()).c_str());
  for (const Side side : kSides) {
    const Vec3 shoulder = kinematics.shoulder(side);
    rope_[side] = {kinematics.trunk().inverse() * shoulder, shoulder + Vec3(0, 0, (1.0 + kStretch) * length_)};
  }
}

void Gantry::pull(const mjModel& model, mjData& data) {
  const double step = speed_ * model.opt.timestep;
  height_ += std::clamp(goal_ - height_, -step, step);
  const double stiffness = 0.5 * weight_ / (kStretch * length_);
  const Eigen::Map<const Vec3> origin(data.xpos + 3 * trunk_);
  const Eigen::Map<const Eigen::Matrix<double, 3, 3, Eigen::RowMajor>> axes(data.xmat + 9 * trunk_);
  std::array<mjtNum, 6> moves{};  // angular, then linear velocity
  mj_objectVelocity(&model, &data, mjOBJ_XBODY, trunk_, moves.data(), 0);
  const Vec3 turns(moves[0], moves[1], moves[2]);
  mju_zero(data.qfrc_applied, model.nv);
  double pulled = 0.0;  // of the weight
  const Vec3 none = Vec3::Zero();
  for (const Side side : kSides) {
    const Vec3 arm = axes * rope_[side].on_trunk;
    const Vec3 at = origin + arm;
    const Vec3 rope = rope_[side].above + Vec3(0, 0, height_) - at;
    const double stretch = rope.norm() - length_;
    if (stretch <= 0.0) continue;
    const Vec3 velocity = Vec3(moves[3], moves[4], moves[5]) + turns.cross(arm);
    Vec3 force = stiffness * stretch * rope.normalized() - damping_ * velocity;
    force.z() = std::max(force.z(), 0.0);
    pulled = std::min(pulled + force.z() / weight_, 1.0);
    mj_applyFT(&model, &data, force.data(), none.data(), at.data(), trunk_, data.qfrc_applied);
  }
  const Vec3 moment = pulled * (kUpright * weight_ * length_ * rotation_error(upright_, axes) - turning_ * turns);
  mj_applyFT(&model, &data, none.data(), moment.data(), origin.data(), trunk_, data.qfrc_applied);
}

}  // namespace baton
