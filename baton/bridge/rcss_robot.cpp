#include "baton/bridge/rcss_robot.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "baton/link/engage.hpp"
#include "baton/model/error.hpp"

namespace baton::bridge {
namespace {

constexpr int kLongestDelay = 10;           ///< within which the robot appears where it was put [cycles]
constexpr double kPlaced = 0.1;             ///< distance from there [m]
constexpr int kRising = 50;                 ///< from straight legs to the stance [cycles]
constexpr int kSettling = 30;               ///< at the stance [cycles]
constexpr int kAveraged = 10;               ///< the last ones of these, which tell where up is [cycles]
constexpr double kUpright = 0.2;            ///< largest tilt then [rad]
constexpr double kTiltOfFall = M_PI / 4.0;  ///< of the trunk [rad]
constexpr double kHeightOfFall = 0.5;       ///< of the COM [nominal height]

}  // namespace

RcssRobot::RcssRobot(const RobotModel& model, const Posture& start, Parameters parameters)
    : model_(&model),
      start_(start),
      parameters_(std::move(parameters)),
      names_(rcss_names(model)),
      attitude_(kRcssCycle),
      kinematics_(model) {
  const double period = model.profile().tick.period;
  if (std::abs(period - kRcssCycle) > 1e-9)
    throw InputError(fmt::format("{}: tick.period = {}: must be {} s, the simulator's cycle", model.profile().name,
                                 period, kRcssCycle));
}

void RcssRobot::join() {
  connection_.emplace(parameters_.server, names_.robot, names_.joints);
  reset();
}

void RcssRobot::reset() {
  if (!moved_) return;
  sent_.clear();
  place();
  stand_up();
  moved_ = false;
}

void RcssRobot::wait(bool brakes) {
  Command command = sent_.back();
  for (std::size_t i = 0; i < command.size(); ++i) {
    command[i].dq = 0.0;
    if (!brakes) continue;
    command[i].q = measured_.q[static_cast<Eigen::Index>(i)];
    command[i].tau = 0.0;
  }
  cycle(std::move(command), "");
  attitude_.update(connection_->perception().rate, connection_->perception().acceleration);
  measure();
}

void RcssRobot::cycle(Command command, const std::string& before) {
  std::string text = before;
  for (std::size_t i = 0; i < names_.joints.size(); ++i)
    text += servo_text(names_.joints[i], command[i]);
  const long last = connection_->perception().cycle;
  connection_->cycle(text);
  ++cycles_;
  sent_.push_back(std::move(command));
  while (static_cast<int>(sent_.size()) > delay_ + 1)
    sent_.pop_front();
  if (connection_->perception().cycle == last + 1 || std::exchange(lost_cycles_, true)) return;
  parameters_.log("cycles were lost: the simulator does not wait for the driver; start it with --sync --no-realtime");
}

void RcssRobot::follow(const JointTarget& target, const std::string& before) {
  const double to_end = (0.5 - delay_) * kRcssCycle;
  Command command;
  for (std::size_t i = 0; i < names_.joints.size(); ++i) {
    const ServoCommand servo = servo_command(*model_, i, target, to_end);
    const Profile::Gains& gains = model_->joints()[i].gains;
    command.push_back({servo.q, servo.dq, gains.kp, gains.kd, servo.tau});
  }
  cycle(std::move(command), before);
}

JointTarget RcssRobot::standing(double rise, double speed) {
  const VecX stance = start_.q.tail(static_cast<Eigen::Index>(names_.joints.size()));
  VecX q = start_.q;
  q.tail(stance.size()) = rise * stance;
  const VecX still = VecX::Zero(model_->nv());
  VecX force(model_->nv());
  kinematics_.inverse_dynamics(q, still, still, force);
  const BySide<bool> both{true, true};
  const BySide<Pose> sole{kinematics_.sole(Side::left), kinematics_.sole(Side::right)};
  JointTarget target{q.tail(stance.size()), speed * stance, {}, VecX(stance.size()), both, {}};
  joint_torques(kinematics_, force, share_wrench(*model_, sole, both, ground_wrench(kinematics_, force)), target.tau);
  return target;
}

void RcssRobot::place() {
  const auto away = [this] { return (connection_->perception().torso.p - parameters_.place).head<2>().norm(); };
  const bool tells = away() > 2.0 * kPlaced;  // one that is there already does not show when it has been put there
  follow(standing(0.0, 0.0), beam_text(parameters_.place));
  for (int delay = 0; delay <= kLongestDelay; ++delay) {
    if (tells ? away() < kPlaced : delay == delay_) {
      delay_ = delay;
      return;
    }
    follow(standing(0.0, 0.0));
  }
  delay_ = 1;
  parameters_.log(
      fmt::format("play mode {}: the robot could not be placed and stands where the simulator put it; its "
                  "delay is taken to be one cycle",
                  connection_->perception().play_mode));
}

void RcssRobot::stand_up() {
  Vec3 force = Vec3::Zero();
  for (int i = 1; i <= kRising + kSettling; ++i) {
    const double phase = std::min(1.0, static_cast<double>(i) / kRising) * M_PI;
    follow(standing(0.5 * (1.0 - std::cos(phase)), 0.5 * M_PI * std::sin(phase) / (kRising * kRcssCycle)));
    if (i > kRising + kSettling - kAveraged) force += connection_->perception().acceleration / kAveraged;
  }
  attitude_.start(force.norm() > 0.0 ? force : Vec3::UnitZ());
  const double tilt = tilt_of(attitude_.attitude());
  if (!(tilt < kUpright) || !link::in_stance(*model_, connection_->perception().q))
    throw SimulatorError(
        fmt::format("the robot does not stand up in the simulator: its torso is tilted by {:.2f} rad, "
                    "its joints are {:.2f} rad from the stance",
                    tilt, (connection_->perception().q - standing(1.0, 0.0).q).cwiseAbs().maxCoeff()));
  first_ = connection_->perception().cycle;
  truth_ = {};
  to_world_ = {};
  measure();
  align();
  judge();
}

void RcssRobot::align() {
  const Vec3 middle = 0.5 * (kinematics_.sole(Side::left).p + kinematics_.sole(Side::right).p);
  const Vec3 begins = 0.5 * (start_.sole.left.p + start_.sole.right.p);
  const double yaw = mean_yaw({kinematics_.sole(Side::left), kinematics_.sole(Side::right)});
  to_world_.R = rotation_z(mean_yaw(start_.sole) - yaw);
  to_world_.p = begins - to_world_.R * middle;
  to_world_.p.z() = begins.z();  // the field is level, its height zero
  truth_ = {};
}

void RcssRobot::write(const JointTarget& target) {
  moved_ = true;
  follow(target);
  attitude_.update(connection_->perception().rate, connection_->perception().acceleration);
  measure();
}

void RcssRobot::measure() {
  const Perception& p = connection_->perception();
  measured_.t = static_cast<double>(p.cycle - first_) * kRcssCycle;
  measured_.age = delay_ * kRcssCycle;
  measured_.q = p.q;
  measured_.dq = p.dq;
  measured_.torque.resize(p.q.size());
  for (Eigen::Index i = 0; i < p.q.size(); ++i) {
    const auto joint = static_cast<std::size_t>(i);
    const RcssServo& servo = sent_.front()[joint];
    const ServoCommand command{servo.q, servo.dq, servo.tau};
    measured_.torque[i] = motor_torque(model_->joints()[joint].motor,
                                       servo_torque(model_->joints()[joint].gains, command, p.q[i], p.dq[i]));
  }
  measured_.imu = {attitude_.attitude(), p.rate, p.acceleration};
  const Vec3 unknown = Vec3::Constant(std::numeric_limits<double>::quiet_NaN());
  measured_.sole = {{unknown, unknown}, {unknown, unknown}};
  judge();
}

void RcssRobot::judge() {
  const Perception& p = connection_->perception();
  const Pose torso = to_world_ * p.torso;
  const bool first = truth_.q.size() == 0;
  const Vec3 before = first ? torso.p : Vec3(truth_.q.head<3>());
  truth_.t = measured_.t;
  truth_.q.resize(model_->nq());
  set_root(truth_.q, torso);
  truth_.q.tail(p.q.size()) = p.q;
  truth_.dq.resize(model_->nv());
  truth_.dq << (torso.p - before) / kRcssCycle, p.rate, p.dq;
  truth_.sole = measured_.sole;  // unknown
  kinematics_.set(truth_.q);
  const double tilt = tilt_of(kinematics_.trunk().R);
  const double height = kinematics_.com().z();
  const double lowest = kHeightOfFall * model_->profile().stance.com_height;
  if (!truth_.fallen && (tilt > kTiltOfFall || height < lowest)) {
    truth_.fallen = true;
    truth_.fall = tilt > kTiltOfFall ? fmt::format("the trunk tilts by {:.0f} degrees", tilt * 180.0 / M_PI)
                                     : fmt::format("the COM is {:.2f} m above the ground", height);
  }
}

}  // namespace baton::bridge
