#include "baton/robot/robot_in_world.hpp"

#include <fmt/format.h>

#include "baton/model/error.hpp"

namespace baton {

std::string flexible(const std::string& joint) {
  return joint + "_flexible";
}

RobotInWorld RobotInWorld::find(const RobotModel& robot, const mjModel& m, const std::string& owner) {
  RobotInWorld found;
  const int root = find_id(m, mjOBJ_BODY, name_of(robot.mj(), mjOBJ_BODY, 1), owner);
  found.root_body = root;
  found.root_qpos = m.jnt_qposadr[m.body_jntadr[root]];
  found.root_dof = m.jnt_dofadr[m.body_jntadr[root]];
  for (const Side side : kSides)
    found.hand_site[side] = find_id(m, mjOBJ_SITE, robot.profile().parts.hand[side == Side::left ? 0 : 1], owner);
  for (const Joint& joint : robot.joints()) {
    const int id = find_id(m, mjOBJ_JOINT, joint.name, owner);
    int motor = -1;
    for (int a = 0; a < m.nu; ++a) {
      if (m.actuator_trntype[a] == mjTRN_JOINT && m.actuator_trnid[2 * a] == id) motor = a;
    }
    if (motor < 0 || m.actuator_biastype[motor] != mjBIAS_NONE) {
      throw InputError(fmt::format("{}: joint '{}' has no torque motor", owner, joint.name));
    }
    found.joints.push_back({m.jnt_qposadr[id], m.jnt_dofadr[id], motor});
    const int spring = mj_name2id(&m, mjOBJ_JOINT, flexible(joint.name).c_str());
    if (spring < 0) continue;
    found.joints.back().flexible_qpos = m.jnt_qposadr[spring];
    found.joints.back().flexible_dof = m.jnt_dofadr[spring];
  }
  found.geoms.resize(static_cast<std::size_t>(m.ngeom));
  for (int g = 0; g < m.ngeom; ++g) {
    Geom& geom = found.geoms[static_cast<std::size_t>(g)];
    geom.robot = m.body_rootid[m.geom_bodyid[g]] == root;
    if (!geom.robot || (m.geom_contype[g] == 0 && m.geom_conaffinity[g] == 0)) continue;
    const std::string body = name_of(m, mjOBJ_BODY, m.geom_bodyid[g]);
    for (const Side side : kSides) {
      if (body == name_of(robot.mj(), mjOBJ_BODY, robot.foot_body(side))) geom.sole = side;
    }
  }
  if (!robot.profile().imu.empty()) found.imu_site = find_id(m, mjOBJ_SITE, robot.profile().imu, owner);
  return found;
}

void RobotInWorld::read(const mjData& data, VecX& q, VecX& dq) const {
  for (int i = 0; i < 7; ++i)
    q[i] = data.qpos[root_qpos + i];
  for (int i = 0; i < 6; ++i)
    dq[i] = data.qvel[root_dof + i];
  for (std::size_t j = 0; j < joints.size(); ++j) {
    const auto i = static_cast<Eigen::Index>(j);
    q[7 + i] = data.qpos[joints[j].qpos];
    dq[6 + i] = data.qvel[joints[j].dof];
    if (joints[j].flexible_qpos < 0) continue;
    q[7 + i] += data.qpos[joints[j].flexible_qpos];
    dq[6 + i] += data.qvel[joints[j].flexible_dof];
  }
}

void RobotInWorld::write(const VecX& q, mjData& data) const {
  for (int i = 0; i < 7; ++i)
    data.qpos[root_qpos + i] = q[i];
  for (std::size_t j = 0; j < joints.size(); ++j)
    data.qpos[joints[j].qpos] = q[7 + static_cast<Eigen::Index>(j)];
}

}  // namespace baton
