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
      world_(&world),
      period_(period),
      parameters_(parameters),
      start_(start),
      kinematics_(robot),
      actuators_(robot, parameters.plant.actuators, period, parameters.timestep),
      sensors_(parameters.plant.sensors, robot.nv() - 6, period, robot.mass() * kGravity, parameters.plant.seed) {
  const std::string owner = fmt::format("world {} with robot {}", world.name(), robot.profile().name);
  const double steps = period_ / parameters_.timestep;
  if (!(steps > 0.5) || std::abs(steps - std::round(steps)) > 1e-6) {
    throw InputError(fmt::format("{}: tick.period = {} is not a multiple of the physics step {}", owner, period_,
                                 parameters_.timestep));
  }
  const SpecPtr spec = parse_text(model_text(Visuals::drop), owner);
  spec->compiler.discardvisual = 1;
  model_ = compile_model(*spec, owner);
  mjModel& m = *model_;
  m.opt.disableflags |= mjDSBL_SENSOR | mjDSBL_ISLAND;  // sensors are computed below; one robot is one island
  in_world_ = RobotInWorld::find(robot, m, owner);
  data_ = DataPtr(mj_makeData(&m));
  mj_setConst(&m, data_.get());
  if (parameters_.nominal_com_height == 0.0) parameters_.nominal_com_height = robot.profile().stance.com_height;
  SimulatedRobot::reset();
}

std::string SimulatedRobot::model_text(Visuals visuals) const {
  return with_plant(world_->compose(*robot_, parameters_.timestep, visuals), parameters_.plant, *robot_,
                    0.5 * (start_.sole.left.p + start_.sole.right.p));
}

void SimulatedRobot::reset() {
  mj_resetData(model_.get(), data_.get());
  const Plant& plant = parameters_.plant;
  actuators_ = Actuators(*robot_, plant.actuators, period_, parameters_.timestep);
  sensors_ = Sensors(plant.sensors, robot_->nv() - 6, period_, robot_->mass() * kGravity, plant.seed);
  truth_ = {};
  imu_velocity_.setZero();
  measured_at_ = 0.0;
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
  torque_ = VecX::Zero(robot_->nv() - 6);
  torques_ = 0;
  mj_forward(model_.get(), data_.get());
  observe();
  if (parameters_.hangs) gantry_.emplace(*robot_, kinematics_, *model_);
  readings_.clear();
  due_.clear();
  tick_ = 0.0;
  measure();
  // A measurement is scheduled before it is due.
  const long ahead = std::lround(std::ceil((plant.sensors.delay + plant.sensors.jitter) / period_));
  for (long tick = 0; tick < ahead; ++tick)
    schedule();
}

void SimulatedRobot::schedule() {
  tick_ += period_;
  const double latest = due_.empty() ? measured_at_ : due_.back();
  due_.push_back(std::max(tick_ - sensors_.age(), latest));
}

void SimulatedRobot::write(const JointTarget& target) {
  const int steps = static_cast<int>(std::lround(period_ / parameters_.timestep));
  actuators_.send(target, data_->time);
  schedule();
  for (int step = 0; step < steps; ++step) {
    actuators_.advance(data_->time);
    for (std::size_t j = 0; j < in_world_.joints.size(); ++j) {
      const RobotInWorld::Address& joint = in_world_.joints[j];
      const Backlash& beyond = actuators_.backlash(j);
      const Actuators::Torque torque = actuators_.torque(
          j, sensors_.encoder(j, data_->qpos[joint.qpos] + beyond.angle()), data_->qvel[joint.dof] + beyond.speed());
      data_->ctrl[joint.motor] = torque.link;
      torque_[static_cast<Eigen::Index>(j)] += torque.motor;
    }
    ++torques_;
    apply_pushes();
    if (gantry_) gantry_->pull(*model_, *data_);
    mj_step(model_.get(), data_.get());
    while (!due_.empty() && due_.front() < data_->time + 0.5 * parameters_.timestep) {
      if (due_.front() > measured_at_ + 0.5 * parameters_.timestep) {
        observe();
        measure();
      } else {
        readings_.push_back(readings_.back());
      }
      due_.pop_front();
    }
  }
  if (truth_.t != data_->time) observe();
  readings_.pop_front();
  check_fall();
}

void SimulatedRobot::apply_pushes() {
  const auto wrench_on = [this](int body) { return Eigen::Map<Vec6>(data_->xfrc_applied + 6 * body); };
  const BySide<int>& site = in_world_.hand_site;
  for (const Side side : kSides)
    wrench_on(model_->site_bodyid[site[side]]).setZero();
  wrench_on(in_world_.root_body) << parameters_.plant.force(data_->time), Vec3::Zero();
  for (const Side side : kSides) {
    const int body = model_->site_bodyid[site[side]];
    const Eigen::Map<const Vec3> hand(data_->site_xpos + 3 * site[side]);
    const Eigen::Map<const Vec3> centre(data_->xipos + 3 * body);
    const Vec3 force = parameters_.plant.force(data_->time, side);
    wrench_on(body).head<3>() += force;
    wrench_on(body).tail<3>() += (hand - centre).cross(force);
  }
}

Measurement SimulatedRobot::read() {
  Measurement measurement = readings_.front();
  measurement.age = data_->time - measurement.t;
  return measurement;
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
  kinematics_.set(truth_.q);
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
  const double tilt = tilt_of(kinematics_.trunk().R);  // set by `observe`
  if (!(tilt <= kFallenTilt)) return fall(fmt::format("the trunk tilts by {:.0f} degrees", tilt * 180.0 / M_PI));
  const double ground = std::min(kinematics_.sole(Side::left).p.z(), kinematics_.sole(Side::right).p.z());
  const double height = kinematics_.com().z() - ground;
  if (!(height >= kFallenHeight * parameters_.nominal_com_height)) {
    fall(fmt::format("the COM is {:.3f} m above the lower sole", height));
  }
}

void SimulatedRobot::move_gantry(double height) {
  if (gantry_) gantry_->move(height);
}

void SimulatedRobot::push(const Vec3& impulse) {
  const double mass = model_->body_subtreemass[in_world_.root_body];
  for (int axis = 0; axis < 3; ++axis)
    data_->qvel[in_world_.root_dof + axis] += impulse[axis] / mass;
}

void SimulatedRobot::measure() {
  const int n = robot_->nv() - 6;
  Measurement m;
  m.t = truth_.t;
  m.q.resize(n);
  m.dq.resize(n);
  for (int j = 0; j < n; ++j) {
    const RobotInWorld::Address& joint = in_world_.joints[static_cast<std::size_t>(j)];
    const Backlash& beyond = actuators_.backlash(static_cast<std::size_t>(j));
    m.q[j] = data_->qpos[joint.qpos] + beyond.angle();
    m.dq[j] = data_->qvel[joint.dof] + beyond.speed();
  }
  m.torque = torques_ > 0 ? VecX(torque_ / torques_) : torque_;
  m.root = RootMeasurement{kinematics_.body(1), truth_.dq.head<3>(), truth_.dq.segment<3>(3)};
  if (in_world_.imu_site >= 0) {
    const Eigen::Map<const Eigen::Matrix<double, 3, 3, Eigen::RowMajor>> attitude(data_->site_xmat +
                                                                                  9 * in_world_.imu_site);
    std::array<mjtNum, 6> velocity{};
    mj_objectVelocity(model_.get(), data_.get(), mjOBJ_SITE, in_world_.imu_site, velocity.data(), 1);
    // The accelerometer integrates: its reading is the mean since the last measurement.
    const Vec3 moves = attitude * Vec3(velocity[3], velocity[4], velocity[5]);
    const double elapsed = truth_.t - measured_at_;
    Vec3 acceleration(0, 0, kGravity);
    if (elapsed > 0.0) acceleration += (moves - imu_velocity_) / elapsed;
    m.imu = {attitude, {velocity[0], velocity[1], velocity[2]}, attitude.transpose() * acceleration};
    imu_velocity_ = moves;
  }
  for (const Side side : kSides) {
    const Pose to_sole = kinematics_.sole(side).inverse();
    const Wrench& sole = truth_.sole[side];
    m.sole[side] = {to_sole.R * sole.force, to_sole.R * sole.moment_about(kinematics_.sole(side).p)};
  }
  measured_at_ = truth_.t;
  torque_.setZero();
  torques_ = 0;
  sensors_.disturb(m);
  readings_.push_back(std::move(m));
}

}  // namespace baton
