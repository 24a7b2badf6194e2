/// A robot in MuJoCo physics: motors with servos and torque-speed limits, honest contact, sensors.
#pragma once

#include "baton/model/world.hpp"
#include "baton/robot/plant.hpp"
#include "baton/robot/robot.hpp"
#include "baton/robot/robot_in_world.hpp"

namespace baton {

class SimulatedRobot : public Robot {
 public:
  struct Parameters {
    double timestep = 0.001;          ///< of physics and servo [s], a divisor of the tick's period
    double nominal_com_height = 0.0;  ///< filled in from the profile when 0 [m]
    Plant plant;
  };

  /// @param start posture that it stands in, in the world
  /// @throws InputError world and robot do not go together
  SimulatedRobot(const RobotModel& robot, const World& world, const Posture& start, double period);
  SimulatedRobot(const RobotModel& robot, const World& world, const Posture& start, double period,
                 Parameters parameters);

  [[nodiscard]] Measurement read() override { return reading_; }
  void write(const JointTarget& target) override;
  void reset() override;
  [[nodiscard]] const Truth* truth() const override { return &truth_; }

  /// The very model that is stepped, as MJCF text.
  [[nodiscard]] const std::string& model_text() const { return text_; }
  [[nodiscard]] const mjModel& model() const { return *model_; }
  [[nodiscard]] const mjData& data() const { return *data_; }
  /// For tests: gives the trunk a push [N·s].
  void push(const Vec3& impulse);

 private:
  /// Physics as the plant has it: friction, softness, masses.
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
  Vec3 imu_velocity_ = Vec3::Zero();  ///< a tick ago [m/s]
  Measurement reading_;               ///< of the sensors, now; torques are means over the last tick
};

}  // namespace baton
