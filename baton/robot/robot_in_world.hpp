/// Indices of a robot's joints and geoms in a compiled model of robot and world.
#pragma once

#include <optional>
#include <vector>

#include "baton/model/robot_model.hpp"

namespace baton {

/// Name of the spring by which a joint of the robot yields under load, if a model has it: a joint in line with it.
[[nodiscard]] std::string flexible(const std::string& joint);

struct RobotInWorld {
  /// Indices of one robot joint.
  struct Address {
    int qpos = 0;
    int dof = 0;
    int motor = 0;           ///< actuator index
    int flexible_qpos = -1;  ///< of the spring in line with it (`flexible`); −1: none
    int flexible_dof = -1;
  };
  /// What one geom of the model belongs to.
  struct Geom {
    bool robot = false;        ///< belongs to the robot
    std::optional<Side> sole;  ///< foot that the geom is part of, if it can collide
  };

  int root_body = 0;
  int root_qpos = 0;
  int root_dof = 0;
  BySide<int> hand_site{0, 0};  ///< where pulls at a hand act
  int imu_site = -1;            ///< −1 without IMU
  std::vector<Address> joints;  ///< ordered as `RobotModel::joints`
  std::vector<Geom> geoms;

  /// @throws InputError a body, joint or motor of the robot is not in the model; the message names `owner`
  [[nodiscard]] static RobotInWorld find(const RobotModel& robot, const mjModel& model, const std::string& owner);

  /// Reads configuration q (nq) and velocity dq (nv), ordered as in the robot's own model; both must have their size.
  /// A joint's angle includes that of its spring.
  void read(const mjData& data, VecX& q, VecX& dq) const;
  /// Sets the robot's configuration (nq).
  void write(const VecX& q, mjData& data) const;

  [[nodiscard]] const Geom& geom(int id) const { return geoms[static_cast<std::size_t>(id)]; }
};

}  // namespace baton
