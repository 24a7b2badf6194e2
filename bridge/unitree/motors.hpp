/// What the motors are told: by whom, since when, and when they only brake. It is what makes the robot's end safe, and
/// depends on nothing but what it is told: no network, no clock.
///
/// | state | the motors | |
/// |---|---|---|
/// | braking | kp 0, kd as in the profile | nobody moves the robot: the state at the start, and after each driver |
/// | posing | go to the stance of the profile, slowly, and stay there | for a robot that hangs |
/// | driven | follow the driver's targets | from its first target on |
/// | damped | kp 0, kd as in the profile | latched: nothing but `arm` ends it |
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "baton/model/robot_model.hpp"
#include "baton/motion/motion.hpp"
#include "bridge/unitree/messages.hpp"

namespace baton::unitree {

class Motors {
 public:
  enum class State { braking, posing, driven, damped };

  struct Parameters {
    double silence = 0.1;         ///< without a new state of the robot, after which it is damped [s]
    double no_target = 0.5;       ///< without a target of the driver, after its first, after which it is damped [s]
    double pose_speed = 0.3;      ///< mean speed of the joint that has the longest way to the stance [rad/s]
    double pose_time = 3.0;       ///< least time that this takes [s]
    double stronger_gains = 2.0;  ///< largest gains that a driver may ask for, of those of the profile
  };

  /// The newest state of the robot that was believed.
  struct Heard {
    LowState state;
    double t = 0.0;  ///< when it arrived [s]
  };

  /// `model` must outlive this object. All times that it is told are of one clock that never goes back [s].
  /// @throws InputError the model's joints are not those of a G1
  explicit Motors(const RobotModel& model) : Motors(model, Parameters()) {}
  Motors(const RobotModel& model, const Parameters& parameters);

  /// A state of the robot has arrived. Its remote may damp, or ask for the stance.
  /// @returns why it is ignored; none: it is not
  std::optional<std::string> hear(const LowState& state, double t);
  /// Time has passed: damps if there was nothing new from the robot, or from its driver, for too long.
  void pass(double t);

  /// A driver takes over, with gains of the servos (n). It moves the robot from its first target on.
  /// @returns why it cannot; none: it has
  std::optional<std::string> engage(const VecX& kp, const VecX& kd, double t);
  /// What the driver wants at time `end`. Nothing happens unless it is engaged.
  void follow(const JointTarget& target, double end, double t);
  /// Nobody drives any more.
  void release();
  /// Goes to the stance, if nobody drives.
  /// @returns why it does not; none: it does
  std::optional<std::string> pose(double t);
  /// The motors only brake from now on.
  /// @param because one line
  void damp(const std::string& because);
  /// Ends that.
  /// @returns why it does not; none: it has
  std::optional<std::string> arm(double t);

  /// What the motors are told now, with its checksum. A state must have been heard.
  [[nodiscard]] LowCommand command(double t) const;

  [[nodiscard]] State state() const { return state_; }
  [[nodiscard]] const std::string& damped_because() const { return damped_because_; }
  [[nodiscard]] const std::optional<Heard>& heard() const { return heard_; }
  /// Motor of each joint.
  [[nodiscard]] const std::vector<std::size_t>& motors() const { return motors_; }

 private:
  [[nodiscard]] bool silent(double t) const { return !heard_ || t - heard_->t > parameters_.silence; }
  [[nodiscard]] VecX measured() const;
  /// How far a way of `pose` is done, from 0 to 1, without speed at both ends.
  [[nodiscard]] double posed(double t) const;

  const RobotModel* model_;
  Parameters parameters_;
  std::vector<std::size_t> motors_;
  VecX stance_;  ///< [rad]
  State state_ = State::braking;
  std::string damped_because_;
  std::optional<Heard> heard_;
  bool engaged_ = false;  ///< a driver is there
  VecX kp_, kd_;          ///< of the driver
  JointTarget target_;
  double target_end_ = 0.0;  ///< time that the target is for [s]
  double told_at_ = 0.0;     ///< when the last target came [s]
  VecX pose_from_;           ///< [rad]
  double pose_since_ = 0.0;  ///< [s]
  double pose_time_ = 0.0;   ///< [s]
};

}  // namespace baton::unitree
