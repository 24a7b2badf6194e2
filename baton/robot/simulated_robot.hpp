/// A robot in MuJoCo physics: motors with servos and torque-speed limits, honest contact, sensors.
#pragma once

#include <deque>
#include <random>

#include "baton/model/world.hpp"
#include "baton/robot/plant.hpp"
#include "baton/robot/robot.hpp"

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
  void perturb();
  /// Torque that the servo of a joint asks of its motor, `to_end` before the targets are due.
  [[nodiscard]] double servo(std::size_t joint, const JointTarget& target, double to_end);
  [[nodiscard]] double noise() { return normal_(random_); }
  void observe();
  void sense();
  void check_fall();

  const RobotModel* robot_;
  double period_;
  Parameters parameters_;
  Posture start_;
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
  std::mt19937_64 random_;
  std::normal_distribution<double> normal_;
  /// A target on its way to the servos.
  struct Sent {
    double arrives = 0.0;  ///< [s]
    JointTarget target;
  };
  std::deque<Sent> sent_;
  VecX encoder_error_;                ///< of the last reading
  VecX torque_;                       ///< of the motors, mean over the last tick
  Vec3 imu_velocity_ = Vec3::Zero();  ///< a tick ago [m/s]
  Measurement reading_;               ///< of the sensors, now
};

}  // namespace baton
