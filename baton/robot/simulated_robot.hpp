/// A robot in MuJoCo physics: servos, motors with torque-speed limits, contact, sensors.
#pragma once

#include "baton/model/world.hpp"
#include "baton/robot/plant.hpp"
#include "baton/robot/robot.hpp"
#include "baton/robot/robot_in_world.hpp"

namespace baton {

class SimulatedRobot : public Robot {
 public:
  struct Parameters {
    double timestep = 0.001;          ///< of physics and servos; must divide the tick period [s]
    double nominal_com_height = 0.0;  ///< 0: from the profile [m]
    Plant plant;
  };

  /// @param start initial standing posture, in the world frame
  /// @throws InputError world and robot cannot be combined
  SimulatedRobot(const RobotModel& robot, const World& world, const Posture& start, double period);
  SimulatedRobot(const RobotModel& robot, const World& world, const Posture& start, double period,
                 Parameters parameters);

  [[nodiscard]] Measurement read() override { return reading_; }
  void write(const JointTarget& target) override;
  void reset() override;
  [[nodiscard]] const Truth* truth() const override { return &truth_; }

  /// The simulated model as MJCF text.
  [[nodiscard]] const std::string& model_text() const { return text_; }
  [[nodiscard]] const mjModel& model() const { return *model_; }
  [[nodiscard]] const mjData& data() const { return *data_; }
  /// For tests: applies an impulse to the trunk [N·s].
  void push(const Vec3& impulse);

 private:
  /// Applies the plant's friction, contact time constant and masses to the model.
  void perturb();
  void observe();
  void measure();
  void check_fall();

  const RobotModel* robot_;
  double period_;
  Parameters parameters_;
  Posture start_;
  std::string text_;
  ModelPtr model_;
  DataPtr data_;
  RobotInWorld in_world_;
  Kinematics kinematics_;
  Truth truth_;
  Actuators actuators_;
  Sensors sensors_;
  Vec3 imu_velocity_ = Vec3::Zero();  ///< one tick ago [m/s]
  Measurement reading_;               ///< current; torques are means over the last tick
};

}  // namespace baton
