/// Where a robot is in a compiled model that holds a world too.
#pragma once

#include <optional>
#include <vector>

#include "baton/model/robot_model.hpp"

namespace baton {

struct RobotInWorld {
  /// Of one joint of the robot.
  struct Address {
    int qpos = 0;
    int dof = 0;
    int motor = 0;  ///< its actuator
  };
  /// Of one geom of the model.
  struct Geom {
    bool robot = false;        ///< belongs to the robot
    std::optional<Side> sole;  ///< the foot that it is on, if it can touch something
  };

  int root_body = 0;
  int root_qpos = 0;
  int root_dof = 0;
  int imu_site = -1;            ///< −1: the robot has no IMU
  std::vector<Address> joints;  ///< in the order of `RobotModel::joints`
  std::vector<Geom> geoms;

  /// @throws InputError a body, joint or motor of the robot is not in the model; the message names `owner`
  [[nodiscard]] static RobotInWorld find(const RobotModel& robot, const mjModel& model, const std::string& owner);

  /// Configuration (nq) and velocity (nv) of the robot, both of its size, in the order of its own model.
  void read(const mjData& data, VecX& q, VecX& dq) const;
  /// Puts the robot into a configuration (nq).
  void write(const VecX& q, mjData& data) const;

  [[nodiscard]] const Geom& geom(int id) const { return geoms[static_cast<std::size_t>(id)]; }
};

}  // namespace baton
