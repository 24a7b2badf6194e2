/// A robot in MuJoCo physics: servos, motors with torque-speed limits, contact, sensors.
#pragma once

#include <deque>
#include <optional>

#include "baton/model/world.hpp"
#include "baton/robot/actuators.hpp"
#include "baton/robot/gantry.hpp"
#include "baton/robot/plant.hpp"
#include "baton/robot/robot.hpp"
#include "baton/robot/robot_in_world.hpp"
#include "baton/robot/sensors.hpp"

namespace baton {

class SimulatedRobot : public Robot {
 public:
  struct Parameters {
    double timestep = 0.001;          ///< of physics and servos; must divide the tick period [s]
    double nominal_com_height = 0.0;  ///< 0: from the profile [m]
    Plant plant;
    bool hangs = false;  ///< from a gantry, where it starts, whether its soles touch the ground or not
  };

  /// `robot` and `world` must outlive this object.
  /// @param start initial posture, in the world frame
  /// @throws InputError world and robot cannot be combined
  SimulatedRobot(const RobotModel& robot, const World& world, const Posture& start, double period);
  SimulatedRobot(const RobotModel& robot, const World& world, const Posture& start, double period,
                 Parameters parameters);

  [[nodiscard]] Measurement read() override;
  void write(const JointTarget& target) override;
  void reset() override;
  [[nodiscard]] const Truth* truth() const override { return &truth_; }

  /// The simulated model as MJCF text; what only pictures show is not simulated.
  [[nodiscard]] std::string model_text(Visuals visuals = Visuals::keep) const;
  [[nodiscard]] const mjModel& model() const { return *model_; }
  [[nodiscard]] const mjData& data() const { return *data_; }
  /// Raises or lowers the gantry (`Gantry::move`), if it hangs from one.
  void move_gantry(double height);
  /// For tests: applies an impulse to the trunk [N·s].
  void push(const Vec3& impulse);

 private:
  /// Sets the truth, and the kinematics to it.
  void observe();
  /// Takes a measurement that will be read later, or now.
  void measure();
  /// Draws when the measurement is taken that is read at the end of the next tick.
  void schedule();
  /// Sets the forces of the plant's pushes, for the next step.
  void apply_pushes();
  void check_fall();

  const RobotModel* robot_;
  const World* world_;
  double period_;
  Parameters parameters_;
  Posture start_;
  ModelPtr model_;
  DataPtr data_;
  RobotInWorld in_world_;
  Kinematics kinematics_;
  Truth truth_;
  std::optional<Gantry> gantry_;
  Actuators actuators_;
  Sensors sensors_;
  Vec3 imu_velocity_ = Vec3::Zero();  ///< at the last measurement [m/s]
  VecX torque_;                       ///< sum of the motor torques since the last measurement [N·m]
  int torques_ = 0;                   ///< number of them
  double measured_at_ = 0.0;          ///< time of the last measurement [s]
  double tick_ = 0.0;                 ///< end of the last tick scheduled [s]
  std::deque<double> due_;            ///< times of measurements to be taken, ascending [s]
  std::deque<Measurement> readings_;  ///< the front one is read
};

}  // namespace baton
