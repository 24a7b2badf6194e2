/// A Booster robot in rcssservermj (docs/rcss.md).
#pragma once

#include <deque>
#include <functional>
#include <optional>

#include "baton/bridge/imu_attitude.hpp"
#include "baton/bridge/rcss_connection.hpp"
#include "baton/bridge/rcss_names.hpp"
#include "baton/model/kinematics.hpp"
#include "baton/robot/robot.hpp"
#include "baton/robot/servo.hpp"

namespace baton::bridge {

/// Joint angles, speeds, gyro and accelerometer are the simulator's. It gives no torques: they are what its servos,
/// whose law and command are known, give at the measured angles and speeds. It gives no attitude that a robot could
/// measure: that is integrated from gyro and accelerometer. The torso's true pose goes to the truth alone, whose forces
/// are unknown.
///
/// A target holds for a whole cycle, and in the simulator's parallel mode only for the one after the next. So servos
/// are told where the joint is in the middle of the cycle in which the command acts, by the target's speed.
class RcssRobot : public Robot {
 public:
  struct Parameters {
    Address server;
    Vec3 place{-2.0, 1.0, 0.0};  ///< x, y in the field [m], yaw [rad]
    std::function<void(const std::string&)> log = [](const std::string&) {};
  };

  /// @param model must outlive the object
  /// @param start where the truth begins: the standing posture in the driver's world
  /// @throws InputError the model is none of the simulator's, or the period is not its cycle
  RcssRobot(const RobotModel& model, const Posture& start, Parameters parameters);

  /// Joins the simulation and stands up. It stays there until it is destroyed, as rejoining takes the simulator
  /// seconds. Call it before all that follows.
  /// @throws SimulatorError
  void join();
  /// Is placed on the field anew, if the game allows that, and stands up; unless nobody has moved it since.
  /// @throws SimulatorError
  void reset() override;
  /// Does the same for one more cycle: the simulator removes a robot that lets it wait for 5 s.
  /// @param brakes lets the motors only brake
  /// @throws SimulatorError
  void wait(bool brakes);
  /// Cycles since it has joined.
  [[nodiscard]] long cycles() const { return cycles_; }

  /// After `reset`.
  [[nodiscard]] Measurement read() override { return measured_; }
  /// @throws SimulatorError
  void write(const JointTarget& target) override;
  [[nodiscard]] const Truth* truth() const override { return &truth_; }

  /// The simulator's name of its model.
  [[nodiscard]] const std::string& name() const { return names_.robot; }
  /// Cycles that pass between a perception and the one in which its answer acts.
  [[nodiscard]] int delay() const { return delay_; }

 private:
  using Command = std::vector<RcssServo>;

  void cycle(Command command, const std::string& before);
  /// @param before other actions of the same cycle
  void follow(const JointTarget& target, const std::string& before = "");
  /// Where it stands between straight legs (0) and its stance (1), on both soles.
  /// @param speed of `rise` [1/s]
  [[nodiscard]] JointTarget standing(double rise, double speed);
  void place();
  void stand_up();
  void measure();
  /// The truth begins where the driver takes it to be: with the soles at the same place and heading.
  void align();
  void judge();

  const RobotModel* model_;
  Posture start_;
  Parameters parameters_;
  RcssNames names_;
  std::optional<RcssConnection> connection_;
  std::deque<Command> sent_;  ///< the front one acted in the last cycle
  int delay_ = 1;             ///< [cycles]
  bool moved_ = true;         ///< since it stood up
  long cycles_ = 0;
  long first_ = 0;            ///< cycle of the first measurement
  bool lost_cycles_ = false;  ///< and said so
  ImuAttitude attitude_;
  Measurement measured_;
  Kinematics kinematics_;
  Pose to_world_;  ///< from the field to the driver's world
  Truth truth_;
};

}  // namespace baton::bridge
