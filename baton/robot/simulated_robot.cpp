#include "baton/robot/simulated_robot.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "baton/model/error.hpp"

namespace baton {
namespace {

constexpr double kFallenTilt = 45.0 * M_PI / 180.0;
constexpr double kFallenHeight = 0.5;  ///< share of the nominal COM height
constexpr double kTouch = 0.5;         ///< [N] force from which a sole counts as touching

}  // namespace

SimulatedRobot::SimulatedRobot(const RobotModel& robot, const World& world, const Posture& start, double period)
    : SimulatedRobot(robot, world, start, period, Parameters{}) {}

SimulatedRobot::SimulatedRobot(const RobotModel& robot, const World& world, const Posture& start, double period,
                               Parameters parameters)
    : robot_(&robot),
      period_(period),
      parameters_(parameters),
      start_(start),
      text_(with_ground(world.compose(robot, parameters.timestep), parameters.plant, name_of(robot.mj(), mjOBJ_BODY, 1),
                        0.5 * (start.sole.left.p + start.sole.right.p))),
      kinematics_(robot) {
  const std::string owner = fmt::format("world {} with robot {}", world.name(), robot.profile().name);
  const double steps = period_ / parameters_.timestep;
  if (!(steps > 0.5) || std::abs(steps - std::round(steps)) > 1e-6) {
    throw InputError(fmt::format("{}: tick.period = {} is not a multiple of the physics step {}", owner, period_,
                                 parameters_.timestep));
  }
  const SpecPtr spec = parse_text(text_, owner);
  spec->compiler.discardvisual = 1;
  model_ = compile_model(*spec, owner);
  mjModel& m = *model_;
  m.opt.disableflags |= mjDSBL_SENSOR | mjDSBL_ISLAND;  // what is sensed is reckoned below; one robot is one island

  const int root = find_id(m, mjOBJ_BODY, name_of(robot.mj(), mjOBJ_BODY, 1), owner);
  root_body_ = root;
  root_qpos_ = m.jnt_qposadr[m.body_jntadr[root]];
  root_dof_ = m.jnt_dofadr[m.body_jntadr[root]];
  for (const Joint& joint : robot.joints()) {
    const int id = find_id(m, mjOBJ_JOINT, joint.name, owner);
    qpos_.push_back(m.jnt_qposadr[id]);
    dof_.push_back(m.jnt_dofadr[id]);
    int motor = -1;
    for (int a = 0; a < m.nu; ++a) {
      if (m.actuator_trntype[a] == mjTRN_JOINT && m.actuator_trnid[2 * a] == id) motor = a;
    }
    if (motor < 0 || m.actuator_biastype[motor] != mjBIAS_NONE) {
      throw InputError(fmt::format("{}: joint '{}' has no torque motor", owner, joint.name));
    }
    motor_.push_back(motor);
  }
  robot_geom_.assign(static_cast<std::size_t>(m.ngeom), 0);
  sole_of_geom_.assign(static_cast<std::size_t>(m.ngeom), -1);
  for (int g = 0; g < m.ngeom; ++g) {
    const auto i = static_cast<std::size_t>(g);
    robot_geom_[i] = m.body_rootid[m.geom_bodyid[g]] == root;
    if (!robot_geom_[i] || (m.geom_contype[g] == 0 && m.geom_conaffinity[g] == 0)) continue;
    const std::string body = name_of(m, mjOBJ_BODY, m.geom_bodyid[g]);
    for (const Side side : kSides) {
      if (body == name_of(robot.mj(), mjOBJ_BODY, robot.foot_body(side))) sole_of_geom_[i] = static_cast<int>(side);
    }
  }
  imu_site_ = robot.profile().imu.empty() ? -1 : find_id(m, mjOBJ_SITE, robot.profile().imu, owner);

  perturb();
  data_ = DataPtr(mj_makeData(&m));
  mj_setConst(&m, data_.get());
  if (parameters_.nominal_com_height == 0.0) parameters_.nominal_com_height = robot.profile().stance.com_height;
  SimulatedRobot::reset();
}

void SimulatedRobot::reset() {
  mj_resetData(model_.get(), data_.get());
  random_.seed(parameters_.plant.seed);
  normal_.reset();
  sent_.clear();
  truth_ = {};
  imu_velocity_.setZero();
  // On tilted ground it is put down tilted.
  const Vec3 at = 0.5 * (start_.sole.left.p + start_.sole.right.p);
  const Mat3 tilt = rotation_exp(parameters_.plant.tilt);
  truth_.q = start_.q;
  truth_.q.head<3>() = at + tilt * (start_.q.head<3>() - at);
  const Eigen::Quaterniond attitude =
      Eigen::Quaterniond(tilt) * Eigen::Quaterniond(start_.q[3], start_.q[4], start_.q[5], start_.q[6]);
  truth_.q.segment<4>(3) << attitude.w(), attitude.x(), attitude.y(), attitude.z();
  truth_.dq = VecX::Zero(robot_->nv());
  for (int i = 0; i < 7; ++i)
    data_->qpos[root_qpos_ + i] = truth_.q[i];
  for (std::size_t j = 0; j < qpos_.size(); ++j)
    data_->qpos[qpos_[j]] = start_.q[7 + static_cast<Eigen::Index>(j)];
  encoder_error_ = torque_ = VecX::Zero(robot_->nv() - 6);
  mj_forward(model_.get(), data_.get());
  observe();
}

void SimulatedRobot::perturb() {
  const Plant& plant = parameters_.plant;
  mjModel& m = *model_;
  for (int g = 0; g < m.ngeom; ++g) {
    if (sole_of_geom_[static_cast<std::size_t>(g)] < 0) continue;
    if (plant.friction) m.geom_friction[3 * g] = *plant.friction;
    if (plant.solref) m.geom_solref[2 * g] = *plant.solref;
  }
  for (int b = 0; b < m.nbody; ++b) {
    m.body_mass[b] *= plant.mass;
    for (int axis = 0; axis < 3; ++axis)
      m.body_inertia[3 * b + axis] *= plant.mass;
  }
  for (int axis = 0; axis < 3; ++axis)
    m.body_ipos[3 * root_body_ + axis] += plant.com_offset[axis];
}

double SimulatedRobot::servo(std::size_t j, const JointTarget& target, double to_end) {
  const auto i = static_cast<Eigen::Index>(j);
  const Joint& joint = robot_->joints()[j];
  const Plant& plant = parameters_.plant;
  const double kp = plant.kp * joint.gains.kp;
  const double q = data_->qpos[qpos_[j]] + (plant.encoder_noise > 0.0 ? plant.encoder_noise * noise() : 0.0);
  const double angle = target.q[i] + (i < target.shift.size() ? target.shift[i] : 0.0) - to_end * target.dq[i];
  const double brake = joint.gains.kd * (target.dq[i] - data_->qvel[dof_[j]]);
  switch (robot_->profile().drive) {
    case Drive::torque:
      return target.tau[i] + kp * (angle - q) + brake;
    case Drive::pd:  // the feed-forward torque is folded into the angle, by the stiffness that the program believes in
      return kp * (angle + target.tau[i] / joint.gains.kp - q) + brake;
    case Drive::stiff:
      return kp * (angle - q) + brake;
  }
  return 0.0;
}

void SimulatedRobot::write(const JointTarget& target) {
  const int steps = static_cast<int>(std::lround(period_ / parameters_.timestep));
  const Plant& plant = parameters_.plant;
  sent_.push_back({data_->time + plant.delay, target});
  torque_.setZero();
  for (int step = 0; step < steps; ++step) {
    const double now = data_->time + 1e-9;
    while (sent_.size() > 1 && sent_[1].arrives <= now)
      sent_.pop_front();
    const double to_end = sent_.front().arrives + period_ - data_->time;
    for (std::size_t j = 0; j < qpos_.size(); ++j) {
      const double most = plant.strength * robot_->joints()[j].motor.stall;
      const double torque = std::clamp(plant.gain * servo(j, sent_.front().target, to_end), -most, most);
      data_->ctrl[motor_[j]] = torque;
      torque_[static_cast<Eigen::Index>(j)] += torque / steps;
    }
    Eigen::Map<Vec3>(data_->xfrc_applied + 6 * root_body_) = plant.force(data_->time);
    mj_step(model_.get(), data_.get());
  }
  observe();
  check_fall();
}

void SimulatedRobot::observe() {
  const mjModel& m = *model_;
  truth_.t = data_->time;
  for (int i = 0; i < 7; ++i)
    truth_.q[i] = data_->qpos[root_qpos_ + i];
  for (int i = 0; i < 6; ++i)
    truth_.dq[i] = data_->qvel[root_dof_ + i];
  for (std::size_t j = 0; j < qpos_.size(); ++j) {
    truth_.q[7 + static_cast<Eigen::Index>(j)] = data_->qpos[qpos_[j]];
    truth_.dq[6 + static_cast<Eigen::Index>(j)] = data_->qvel[dof_[j]];
  }
  for (const Side side : kSides)
    truth_.sole[side] = {};
  for (int c = 0; c < data_->ncon; ++c) {
    const mjContact& contact = data_->contact[c];
    for (const int which : {0, 1}) {
      const int geom = contact.geom[which];
      if (geom < 0 || sole_of_geom_[static_cast<std::size_t>(geom)] < 0) continue;
      if (contact.geom[1 - which] >= 0 && robot_geom_[static_cast<std::size_t>(contact.geom[1 - which])]) continue;
      std::array<mjtNum, 6> local{};
      mj_contactForce(&m, data_.get(), c, local.data());
      const Eigen::Map<const Eigen::Matrix<double, 3, 3, Eigen::RowMajor>> axes(contact.frame);
      const double sign = which == 1 ? 1.0 : -1.0;  // the force acts from geom 0 on geom 1
      const Vec3 force = sign * (axes.transpose() * Vec3(local[0], local[1], local[2]));
      const Vec3 torque = sign * (axes.transpose() * Vec3(local[3], local[4], local[5]));
      const Vec3 at(contact.pos[0], contact.pos[1], contact.pos[2]);
      Wrench& sole = truth_.sole[static_cast<Side>(sole_of_geom_[static_cast<std::size_t>(geom)])];
      sole.force += force;
      sole.moment += at.cross(force) + torque;
    }
  }
  for (const Side side : kSides)
    truth_.touch[side] = truth_.sole[side].force.z() > kTouch;
  sense();
}

void SimulatedRobot::check_fall() {
  if (truth_.fallen) return;
  const mjModel& m = *model_;
  const auto fall = [this](std::string why) {
    truth_.fallen = true;
    truth_.fall = std::move(why);
  };
  for (int i = 0; i < mjNWARNING; ++i) {
    if (data_->warning[i].number > 0) {
      return fall(
          fmt::format("simulator warning: {}", mju_warningText(i, static_cast<size_t>(data_->warning[i].lastinfo))));
    }
  }
  for (int c = 0; c < data_->ncon; ++c) {
    const mjContact& contact = data_->contact[c];
    for (const int which : {0, 1}) {
      const int mine = contact.geom[which];
      const int theirs = contact.geom[1 - which];
      if (mine < 0 || theirs < 0 || contact.efc_address < 0) continue;
      if (!robot_geom_[static_cast<std::size_t>(mine)] || robot_geom_[static_cast<std::size_t>(theirs)]) continue;
      if (sole_of_geom_[static_cast<std::size_t>(mine)] < 0) {
        return fall(fmt::format("{} touches {}", name_of(m, mjOBJ_GEOM, mine), name_of(m, mjOBJ_GEOM, theirs)));
      }
    }
  }
  const double tilt = tilt_of(kinematics_.trunk().R);  // `sense` has set them to the truth
  if (!(tilt <= kFallenTilt)) return fall(fmt::format("the trunk tilts by {:.0f} degrees", tilt * 180.0 / M_PI));
  const double ground = std::min(kinematics_.sole(Side::left).p.z(), kinematics_.sole(Side::right).p.z());
  const double height = kinematics_.com().z() - ground;
  if (!(height >= kFallenHeight * parameters_.nominal_com_height)) {
    fall(fmt::format("the COM is {:.3f} m above the lower sole", height));
  }
}

void SimulatedRobot::push(const Vec3& impulse) {
  const double mass = model_->body_subtreemass[root_body_];
  for (int axis = 0; axis < 3; ++axis)
    data_->qvel[root_dof_ + axis] += impulse[axis] / mass;
}

void SimulatedRobot::sense() {
  const Plant& plant = parameters_.plant;
  reading_.t = truth_.t;
  reading_.q = truth_.q.tail(robot_->nv() - 6);
  reading_.dq = truth_.dq.tail(robot_->nv() - 6);
  reading_.torque = torque_;
  if (plant.encoder_noise > 0.0) {
    for (Eigen::Index j = 0; j < reading_.q.size(); ++j) {
      const double error = plant.encoder_noise * noise();
      reading_.q[j] += error;
      reading_.dq[j] += (error - encoder_error_[j]) / period_;  // speeds are differences of angles
      encoder_error_[j] = error;
    }
  }
  kinematics_.set(truth_.q);
  reading_.root = RootMeasurement{kinematics_.body(1), truth_.dq.head<3>(), truth_.dq.segment<3>(3)};
  if (imu_site_ >= 0) {
    const Eigen::Map<const Eigen::Matrix<double, 3, 3, Eigen::RowMajor>> attitude(data_->site_xmat + 9 * imu_site_);
    reading_.imu.attitude = rotation_exp(plant.imu_bias) * attitude;
    std::array<mjtNum, 6> velocity{};
    mj_objectVelocity(model_.get(), data_.get(), mjOBJ_SITE, imu_site_, velocity.data(), 1);
    reading_.imu.rate = {velocity[0], velocity[1], velocity[2]};
    // The sensor integrates: what it tells is the mean over the tick.
    const Vec3 moves = attitude * Vec3(velocity[3], velocity[4], velocity[5]);
    const Vec3 acceleration = Vec3(0, 0, kGravity) + (moves - imu_velocity_) / period_;
    reading_.imu.acceleration = attitude.transpose() * acceleration;
    imu_velocity_ = moves;
  }
  for (const Side side : kSides) {
    const Pose to_sole = kinematics_.sole(side).inverse();
    Wrench& sole = reading_.sole[side];
    sole = {to_sole.R * truth_.sole[side].force, to_sole.R * truth_.sole[side].moment_about(kinematics_.sole(side).p)};
    if (plant.force_noise == 0.0) continue;
    for (int axis = 0; axis < 3; ++axis) {
      sole.force[axis] *= 1.0 + plant.force_noise * noise();
      sole.moment[axis] *= 1.0 + plant.force_noise * noise();
    }
  }
}

}  // namespace baton
