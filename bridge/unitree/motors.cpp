#include "bridge/unitree/motors.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "baton/ik/stand.hpp"
#include "bridge/unitree/joints.hpp"
#include "bridge/unitree/reading.hpp"
#include "bridge/unitree/remote.hpp"

namespace baton::unitree {

Motors::Motors(const RobotModel& model, const Parameters& parameters)
    : model_(&model),
      parameters_(parameters),
      motors_(motors_of(model)),
      stance_(stand(model, Pose{}, model.profile().stance.com_height).q.tail(model.nv() - 6)) {}

std::optional<std::string> Motors::hear(const LowState& state, double t) {
  if (std::optional<std::string> why = doubt(state)) return why;
  if (heard_ && state.mode_machine != heard_->state.mode_machine) return "another mode_machine than before";
  if (heard_ && state.tick == heard_->state.tick) return std::nullopt;  // said again: nothing new
  const Remote before = heard_ ? remote_of(heard_->state.wireless_remote) : Remote{};
  heard_ = Heard{state, t};
  const Remote remote = remote_of(state.wireless_remote);
  if (remote.damp) damp("by the remote");
  if (remote.stance && !before.stance) static_cast<void>(pose(t));
  if (state.mode_pr != 0 && (state_ == State::driven || state_ == State::posing))
    damp(fmt::format("the ankles are in mode {}, not in that of pitch and roll", state.mode_pr));
  return std::nullopt;
}

void Motors::pass(double t) {
  if (heard_ && silent(t))
    damp(fmt::format("nothing new from the robot for {:.0f} ms", 1e3 * parameters_.silence));
  else if (state_ == State::driven && t - told_at_ > parameters_.no_target)
    damp(fmt::format("no target from the driver for {:.0f} ms", 1e3 * parameters_.no_target));
}

std::optional<std::string> Motors::engage(const VecX& kp, const VecX& kd, double t) {
  if (state_ == State::damped) return "damped: " + damped_because_;
  if (silent(t)) return "nothing is heard from the robot";
  if (heard_->state.mode_pr != 0)
    return fmt::format("the ankles are in mode {}, not in that of pitch and roll", heard_->state.mode_pr);
  for (std::size_t i = 0; i < motors_.size(); ++i) {
    const Joint& joint = model_->joints()[i];
    const auto at = static_cast<Eigen::Index>(i);
    const double most_kp = parameters_.stronger_gains * joint.gains.kp;
    const double most_kd = parameters_.stronger_gains * joint.gains.kd;
    if (!(kp[at] >= 0.0 && kp[at] <= most_kp && kd[at] >= 0.0 && kd[at] <= most_kd))
      return fmt::format("{}: kp {:.6g}, kd {:.6g}: must be at most {:.6g}, {:.6g}", joint.name, kp[at], kd[at],
                         most_kp, most_kd);
  }
  if (state_ == State::driven) state_ = State::braking;
  engaged_ = true;
  kp_ = kp;
  kd_ = kd;
  return std::nullopt;
}

void Motors::follow(const JointTarget& target, double end, double t) {
  if (!engaged_ || state_ == State::damped) return;
  state_ = State::driven;
  target_ = target;
  target_end_ = end;
  told_at_ = t;
}

void Motors::release() {
  engaged_ = false;
  if (state_ == State::driven) state_ = State::braking;
}

std::optional<std::string> Motors::pose(double t) {
  if (state_ == State::damped) return "damped: " + damped_because_;
  if (engaged_) return "somebody drives the robot";
  if (state_ == State::posing) return "it does already";
  if (silent(t)) return "nothing is heard from the robot";
  state_ = State::posing;
  pose_from_ = measured();
  pose_since_ = t;
  pose_time_ = std::max(parameters_.pose_time, (stance_ - pose_from_).cwiseAbs().maxCoeff() / parameters_.pose_speed);
  return std::nullopt;
}

void Motors::damp(const std::string& because) {
  if (state_ == State::damped) return;
  state_ = State::damped;
  engaged_ = false;
  damped_because_ = because;
}

std::optional<std::string> Motors::arm(double t) {
  if (state_ != State::damped) return "it is not damped";
  if (silent(t)) return "nothing is heard from the robot";
  if (remote_of(heard_->state.wireless_remote).damp) return "the remote still damps";
  state_ = State::braking;
  return std::nullopt;
}

VecX Motors::measured() const {
  return measurement_of(heard_->state, motors_, heard_->t).q;
}

double Motors::posed(double t) const {
  const double x = std::clamp((t - pose_since_) / pose_time_, 0.0, 1.0);
  return x * x * (3.0 - 2.0 * x);
}

LowCommand Motors::command(double t) const {
  LowCommand command;
  command.mode_machine = heard_->state.mode_machine;
  const VecX q = measured();
  const double share = state_ == State::posing ? posed(t) : 0.0;
  for (std::size_t i = 0; i < motors_.size(); ++i) {
    const auto at = static_cast<Eigen::Index>(i);
    const Profile::Gains& gains = model_->joints()[i].gains;
    MotorCommand& motor = command.motors[motors_[i]];
    motor.mode = 1;
    motor.q = static_cast<float>(q[at]);
    motor.kd = static_cast<float>(gains.kd);
    if (state_ == State::posing) {
      motor.q = static_cast<float>((1.0 - share) * pose_from_[at] + share * stance_[at]);
      motor.kp = static_cast<float>(gains.kp);
    } else if (state_ == State::driven) {
      // Between ticks the angle goes on with the target's speed, to the target's time; without a new one it stays.
      const double left = target_end_ - t;
      const double dq = left > -model_->profile().tick.period ? target_.dq[at] : 0.0;
      motor.q = static_cast<float>(target_.q[at] - std::max(left, 0.0) * dq);
      motor.dq = static_cast<float>(dq);
      motor.tau = static_cast<float>(target_.tau[at]);
      motor.kp = static_cast<float>(kp_[at]);
      motor.kd = static_cast<float>(kd_[at]);
    }
  }
  command.crc = checksum(command);
  return command;
}

}  // namespace baton::unitree
