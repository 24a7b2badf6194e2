/// A robot in MuJoCo physics: motors with servos and torque-speed limits, honest contact, sensors.
#pragma once

#include "baton/model/world.hpp"
#include "baton/robot/robot.hpp"

namespace baton {

/// Perturbations of the plant, so that it is not the model.
struct Plant {
  double friction = 1.0;           ///< factor on the soles' and ground's sliding friction
  double mass = 1.0;               ///< factor on all masses and inertias
  Vec3 com_offset = Vec3::Zero();  ///< of the trunk's COM [m]
  double gains = 1.0;              ///< factor on kp and kd
};

class SimulatedRobot : public TransparentRobot {
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

  [[nodiscard]] Measurement read() override;
  void write(const JointTarget& target) override;
  [[nodiscard]] const Truth& truth() const override { return truth_; }

  /// The very model that is stepped, as MJCF text.
  [[nodiscard]] const std::string& model_text() const { return text_; }
  [[nodiscard]] const mjModel& model() const { return *model_; }
  [[nodiscard]] const mjData& data() const { return *data_; }
  /// For tests: gives the trunk a push [N·s].
  void push(const Vec3& impulse);

 private:
  void observe();
  void check_fall();

  const RobotModel* robot_;
  double period_;
  Parameters parameters_;
  std::string text_;
  ModelPtr model_;
  DataPtr data_;
  std::vector<int> qpos_;  ///< address of each joint's angle in the stepped model
  std::vector<int> dof_;
  std::vector<int> motor_;  ///< actuator of each joint
  int root_qpos_ = 0;
  int root_dof_ = 0;
  int root_body_ = 0;
  int imu_site_ = -1;
  std::vector<int> sole_of_geom_;  ///< −1, or the side, by geom of the stepped model
  std::vector<char> robot_geom_;   ///< belongs to the robot, by geom
  Kinematics kinematics_;
  Truth truth_;
  Vec3 acceleration_ = Vec3::Zero();
};

}  // namespace baton
