#include "baton/robot/simulated_robot.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "baton/model/error.hpp"

namespace baton {
namespace {

constexpr double kFallenTilt = 45.0 * M_PI / 180.0;  ///< trunk tilt that counts as a fall [rad]
constexpr double kFallenHeight = 0.5;                ///< COM height below which it is a fall [nominal COM height]
constexpr double kTouch = 0.01;                      ///< least contact force of a touching sole [weight]

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
      kinematics_(robot),
      actuators_(robot, parameters.plant.actuators, period),
      sensors_(parameters.plant.sensors, robot.nv() - 6, period, parameters.plant.seed) {
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
  m.opt.disableflags |= mjDSBL_SENSOR | mjDSBL_ISLAND;  // sensors are computed below; one robot is one island
  in_world_ = RobotInWorld::find(robot, m, owner);
  perturb();
  data_ = DataPtr(mj_makeData(&m));
  mj_setConst(&m, data_.get());
  if (parameters_.nominal_com_height == 0.0) parameters_.nominal_com_height = robot.profile().stance.com_height;
  SimulatedRobot::reset();
}

void SimulatedRobot::reset() {
  mj_resetData(model_.get(), data_.get());
  const Plant& plant = parameters_.plant;
  actuators_ = Actuators(*robot_, plant.actuators, period_);
  sensors_ = Sensors(plant.sensors, robot_->nv() - 6, period_, plant.seed);
  truth_ = {};
  imu_velocity_.setZero();
  // On tilted ground the robot starts tilted.
  const Vec3 at = 0.5 * (start_.sole.left.p + start_.sole.right.p);
  const Mat3 tilt = rotation_exp(plant.tilt);
  truth_.q = start_.q;
  truth_.q.head<3>() = at + tilt * (start_.q.head<3>() - at);
  const Eigen::Quaterniond attitude =
      Eigen::Quaterniond(tilt) * Eigen::Quaterniond(start_.q[3], start_.q[4], start_.q[5], start_.q[6]);
  truth_.q.segment<4>(3) << attitude.w(), attitude.x(), attitude.y(), attitude.z();
  truth_.dq = VecX::Zero(robot_->nv());
  in_world_.write(truth_.q, *data_);
  reading_.torque = VecX::Zero(robot_->nv() - 6);
  mj_forward(model_.get(), data_.get());
  observe();
}

void SimulatedRobot::perturb() {
  const Plant& plant = parameters_.plant;
  mjModel& m = *model_;
  for (int g = 0; g < m.ngeom; ++g) {
    if (!in_world_.geom(g).sole) continue;
    if (plant.friction) m.geom_friction[3 * g] = *plant.friction;
    if (plant.solref) m.geom_solref[2 * g] = *plant.solref;
  }
  for (int b = 0; b < m.nbody; ++b) {
    m.body_mass[b] *= plant.mass;
    for (int axis = 0; axis < 3; ++axis)
      m.body_inertia[3 * b + axis] *= plant.mass;
  }
  for (int axis = 0; axis < 3; ++axis)
    m.body_ipos[3 * in_world_.root_body + axis] += plant.com_offset[axis];
}

void SimulatedRobot::write(const JointTarget& target) {
  const int steps = static_cast<int>(std::lround(period_ / parameters_.timestep));
  actuators_.send(target, data_->time);
  reading_.torque.setZero();
  for (int step = 0; step < steps; ++step) {
    actuators_.advance(data_->time);
    for (std::size_t j = 0; j < in_world_.joints.size(); ++j) {
      const RobotInWorld::Address& joint = in_world_.joints[j];
      const double torque = actuators_.torque(j, sensors_.encoder(data_->qpos[joint.qpos]), data_->qvel[joint.dof]);
      data_->ctrl[joint.motor] = torque;
      reading_.torque[static_cast<Eigen::Index>(j)] += torque / steps;
    }
    Eigen::Map<Vec3>(data_->xfrc_applied + 6 * in_world_.root_body) = parameters_.plant.force(data_->time);
    mj_step(model_.get(), data_.get());
  }
  observe();
  check_fall();
}

void SimulatedRobot::observe() {
  const mjModel& m = *model_;
  truth_.t = data_->time;
  in_world_.read(*data_, truth_.q, truth_.dq);
  for (const Side side : kSides)
    truth_.sole[side] = {};
  for (int c = 0; c < data_->ncon; ++c) {
    const mjContact& contact = data_->contact[c];
    for (const int which : {0, 1}) {
      const int geom = contact.geom[which];
      if (geom < 0 || !in_world_.geom(geom).sole) continue;
      if (contact.geom[1 - which] >= 0 && in_world_.geom(contact.geom[1 - which]).robot) continue;
      std::array<mjtNum, 6> local{};
      mj_contactForce(&m, data_.get(), c, local.data());
      const Eigen::Map<const Eigen::Matrix<double, 3, 3, Eigen::RowMajor>> axes(contact.frame);
      const double sign = which == 1 ? 1.0 : -1.0;  // MuJoCo's force acts from geom 0 on geom 1
      const Vec3 force = sign * (axes.transpose() * Vec3(local[0], local[1], local[2]));
      const Vec3 torque = sign * (axes.transpose() * Vec3(local[3], local[4], local[5]));
      const Vec3 at(contact.pos[0], contact.pos[1], contact.pos[2]);
      Wrench& sole = truth_.sole[*in_world_.geom(geom).sole];
      sole.force += force;
      sole.moment += at.cross(force) + torque;
    }
  }
  for (const Side side : kSides)
    truth_.touch[side] = truth_.sole[side].force.z() > kTouch * robot_->mass() * kGravity;
  measure();
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
      if (!in_world_.geom(mine).robot || in_world_.geom(theirs).robot) continue;
      if (!in_world_.geom(mine).sole) {
        return fall(fmt::format("{} touches {}", name_of(m, mjOBJ_GEOM, mine), name_of(m, mjOBJ_GEOM, theirs)));
      }
    }
  }
  const double tilt = tilt_of(kinematics_.trunk().R);  // set by `measure`
  if (!(tilt <= kFallenTilt)) return fall(fmt::format("the trunk tilts by {:.0f} degrees", tilt * 180.0 / M_PI));
  const double ground = std::min(kinematics_.sole(Side::left).p.z(), kinematics_.sole(Side::right).p.z());
  const double height = kinematics_.com().z() - ground;
  if (!(height >= kFallenHeight * parameters_.nominal_com_height)) {
    fall(fmt::format("the COM is {:.3f} m above the lower sole", height));
  }
}

void SimulatedRobot::push(const Vec3& impulse) {
  const double mass = model_->body_subtreemass[in_world_.root_body];
  for (int axis = 0; axis < 3; ++axis)
    data_->qvel[in_world_.root_dof + axis] += impulse[axis] / mass;
}

void SimulatedRobot::measure() {
  const int n = robot_->nv() - 6;
  reading_.t = truth_.t;
  reading_.q = truth_.q.tail(n);
  reading_.dq = truth_.dq.tail(n);
  kinematics_.set(truth_.q);
  reading_.root = RootMeasurement{kinematics_.body(1), truth_.dq.head<3>(), truth_.dq.segment<3>(3)};
  reading_.imu = {};
  if (in_world_.imu_site >= 0) {
    const Eigen::Map<const Eigen::Matrix<double, 3, 3, Eigen::RowMajor>> attitude(data_->site_xmat +
                                                                                  9 * in_world_.imu_site);
    std::array<mjtNum, 6> velocity{};
    mj_objectVelocity(model_.get(), data_.get(), mjOBJ_SITE, in_world_.imu_site, velocity.data(), 1);
    // The accelerometer integrates: its reading is the mean over the tick.
    const Vec3 moves = attitude * Vec3(velocity[3], velocity[4], velocity[5]);
    const Vec3 acceleration = Vec3(0, 0, kGravity) + (moves - imu_velocity_) / period_;
    reading_.imu = {attitude, {velocity[0], velocity[1], velocity[2]}, attitude.transpose() * acceleration};
    imu_velocity_ = moves;
  }
  for (const Side side : kSides) {
    const Pose to_sole = kinematics_.sole(side).inverse();
    const Wrench& sole = truth_.sole[side];
    reading_.sole[side] = {to_sole.R * sole.force, to_sole.R * sole.moment_about(kinematics_.sole(side).p)};
  }
  sensors_.disturb(reading_);
}

}  // namespace baton
