#include "baton/model/robot_model.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>

#include "baton/model/error.hpp"

namespace baton {
namespace {

/// Points spanning a geom's surface, in its own frame: enough to find the lowest ones of a sole.
std::vector<Vec3> surface_points(const mjModel& m, int geom) {
  const double* size = m.geom_size + 3 * geom;
  std::vector<Vec3> points;
  switch (m.geom_type[geom]) {
    case mjGEOM_BOX:
      for (const double x : {-1.0, 1.0}) {
        for (const double y : {-1.0, 1.0}) {
          for (const double z : {-1.0, 1.0})
            points.emplace_back(x * size[0], y * size[1], z * size[2]);
        }
      }
      break;
    case mjGEOM_SPHERE:
      points = {{0, 0, -size[0]}, {0, 0, size[0]}, {size[0], 0, 0},
                {-size[0], 0, 0}, {0, size[0], 0}, {0, -size[0], 0}};
      break;
    case mjGEOM_CAPSULE:
      for (const double end : {-size[1], size[1]}) {
        for (int k = 0; k < 16; ++k) {
          const double a = k * M_PI / 8.0;
          points.emplace_back(size[0] * std::cos(a), size[0] * std::sin(a), end);
        }
        points.emplace_back(0, 0, end + std::copysign(size[0], end));
      }
      break;
    case mjGEOM_MESH: {
      const int mesh = m.geom_dataid[geom];
      for (int k = 0; k < m.mesh_vertnum[mesh]; ++k) {
        const float* vertex = m.mesh_vert + 3 * (m.mesh_vertadr[mesh] + k);
        points.emplace_back(vertex[0], vertex[1], vertex[2]);
      }
      break;
    }
    default:
      break;
  }
  return points;
}

Pose local_pose(const mjtNum* pos, const mjtNum* quat) {
  return {Vec3(pos[0], pos[1], pos[2]), Eigen::Quaterniond(quat[0], quat[1], quat[2], quat[3]).toRotationMatrix()};
}

}  // namespace

std::filesystem::path share_dir() {
  const char* given = std::getenv("BATON_SHARE");
  return given != nullptr ? given : BATON_SHARE_DIR;
}

std::filesystem::path profile_file(const std::string& name_or_file) {
  const std::filesystem::path file = name_or_file;
  return file.extension() == ".toml" ? file : share_dir() / "robots" / name_or_file / "profile.toml";
}

RobotModel RobotModel::load(const std::string& name_or_file) {
  const std::filesystem::path file = profile_file(name_or_file);
  std::error_code ignored;
  if (!std::filesystem::exists(file, ignored)) {
    throw InputError(fmt::format("robot '{}': no file {}: give a folder of robots/ or a profile's .toml file",
                                 name_or_file, file.string()));
  }
  return RobotModel(Profile::load(file));
}

SpecPtr RobotModel::spec() const {
  return parse_model(profile_.model);
}

RobotModel::RobotModel(Profile profile) : profile_(std::move(profile)) {
  const std::string owner = fmt::format("model {}", profile_.model.string());
  const SpecPtr text = spec();
  text->compiler.discardvisual = 1;  // nothing is drawn here, and MuJoCo's kinematics places every geom
  model_ = compile_model(*text, owner);
  const mjModel& m = *model_;
  for (int i = 0; i < m.nbody; ++i)
    dofs_to_.push_back(chain(i));
  trunk_body_ = find_id(m, mjOBJ_BODY, profile_.parts.trunk, owner);
  read_joints(owner);
  for (const Side side : kSides) {
    const auto i = static_cast<std::size_t>(side);
    foot_[side] = site_frame(profile_.parts.foot[i], owner);
    hand_[side] = site_frame(profile_.parts.hand[i], owner);
    shoulder_body_[side] = find_id(m, mjOBJ_BODY, profile_.parts.shoulder[i], owner);
    read_sole(side);
  }
  for (const Side side : kSides) {
    const auto i = static_cast<std::size_t>(side);
    for (const int dof : dofs_to_[static_cast<std::size_t>(foot_[side].body)]) {
      if (dof >= 6) leg_[side].push_back(dof - 6);
    }
    const std::vector<int>& opposite = dofs_to_[static_cast<std::size_t>(hand_[other(side)].body)];
    for (const int dof : dofs_to_[static_cast<std::size_t>(hand_[side].body)]) {
      if (std::find(opposite.begin(), opposite.end(), dof) == opposite.end()) arm_[side].push_back(dof - 6);
    }
    if (leg_[side].size() < 6) {
      throw InputError(fmt::format("{}: the leg to '{}' has {} joints: at least 6 are needed", owner,
                                   profile_.parts.foot[i], leg_[side].size()));
    }
  }
  if (!profile_.imu.empty()) {
    const Frame sensor = site_frame(profile_.imu, owner);
    if (sensor.body == 1) imu_ = sensor.frame;
  }
  mass_ = m.body_subtreemass[0];
  omega_ = std::sqrt(kGravity / profile_.stance.com_height);
}

RobotModel::Frame RobotModel::site_frame(const std::string& site, const std::string& owner) const {
  const int id = find_id(*model_, mjOBJ_SITE, site, owner);
  return {model_->site_bodyid[id], local_pose(model_->site_pos + 3 * id, model_->site_quat + 4 * id)};
}

std::vector<int> RobotModel::chain(int body) const {
  std::vector<int> dofs;
  for (int b = body; b > 0; b = model_->body_parentid[b]) {
    for (int k = model_->body_dofnum[b] - 1; k >= 0; --k)
      dofs.push_back(model_->body_dofadr[b] + k);
  }
  std::reverse(dofs.begin(), dofs.end());
  return dofs;
}

void RobotModel::read_joints(const std::string& owner) {
  const mjModel& m = *model_;
  if (m.njnt < 1 || m.jnt_type[0] != mjJNT_FREE || m.jnt_bodyid[0] != 1) {
    throw InputError(fmt::format("{}: the first body needs a free joint", owner));
  }
  const auto narrow = [](double& limit, const mjtNum* range, double gear) {
    limit = std::min(limit, std::min(std::abs(range[0]), std::abs(range[1])) * std::abs(gear));
  };
  for (int j = 1; j < m.njnt; ++j) {
    Joint joint;
    joint.name = name_of(m, mjOBJ_JOINT, j);
    if (m.jnt_type[j] != mjJNT_HINGE) {
      throw InputError(fmt::format("{}: joint '{}' is not a hinge: only hinges can be driven", owner, joint.name));
    }
    if (!m.jnt_limited[j]) throw InputError(fmt::format("{}: joint '{}' has no range", owner, joint.name));
    joint.position = {m.jnt_range[2 * j], m.jnt_range[2 * j + 1]};
    double stall = std::numeric_limits<double>::infinity();
    if (m.jnt_actfrclimited[j]) narrow(stall, m.jnt_actfrcrange + 2 * j, 1.0);
    for (int a = 0; a < m.nu; ++a) {
      if (m.actuator_trntype[a] != mjTRN_JOINT || m.actuator_trnid[2 * a] != j) continue;
      if (m.actuator_ctrllimited[a] && m.actuator_biastype[a] == mjBIAS_NONE) {
        narrow(stall, m.actuator_ctrlrange + 2 * a, m.actuator_gear[6 * a]);
      }
      if (m.actuator_forcelimited[a]) narrow(stall, m.actuator_forcerange + 2 * a, m.actuator_gear[6 * a]);
    }
    if (!std::isfinite(stall) || stall <= 0.0) {
      throw InputError(fmt::format("{}: joint '{}' has no torque limit: give its motor a ctrlrange or forcerange",
                                   owner, joint.name));
    }
    const auto heat = profile_.heat.find(joint.name);
    joint.motor = {stall, m.dof_damping[m.jnt_dofadr[j]], 0.0, heat == profile_.heat.end() ? Thermal{} : heat->second};
    if (!(joint.motor.damping > 0.0)) {
      throw InputError(
          fmt::format("{}: joint '{}' has no damping: the motor's back-EMF sets its no-load speed", owner, joint.name));
    }
    joint.motor.no_load = stall / joint.motor.damping;
    joint.speed = profile_.margin.speed * joint.motor.no_load;
    const auto gains = profile_.gains.find(joint.name);
    if (gains == profile_.gains.end()) {
      throw InputError(
          fmt::format("profile of {}: drive.gains names no gains for joint '{}'", profile_.name, joint.name));
    }
    joint.gains = gains->second;
    if (const auto home = profile_.home.find(joint.name); home != profile_.home.end()) {
      joint.home = home->second;
      if (joint.home < joint.position.lo || joint.home > joint.position.hi) {
        throw InputError(
            fmt::format("profile of {}: home_deg.{} lies outside the joint's range", profile_.name, joint.name));
      }
    }
    joints_.push_back(std::move(joint));
  }
  const auto known = [this](const std::string& name) {
    return std::any_of(joints_.begin(), joints_.end(), [&](const Joint& joint) { return joint.name == name; });
  };
  for (const auto& [name, value] : profile_.home) {
    if (!known(name))
      throw InputError(fmt::format("profile of {}: home_deg.{}: the model has no such joint", profile_.name, name));
  }
  for (const auto& [name, value] : profile_.gains) {
    if (!known(name))
      throw InputError(fmt::format("profile of {}: drive.gains: the model has no joint '{}'", profile_.name, name));
  }
}

void RobotModel::read_sole(Side side) {
  const mjModel& m = *model_;
  Frame& foot = foot_[side];
  const Pose site_inverse = foot.frame.inverse();
  std::vector<Vec3> points;
  double lowest = std::numeric_limits<double>::infinity();
  for (int g = 0; g < m.ngeom; ++g) {
    if (m.geom_bodyid[g] != foot.body || (m.geom_contype[g] == 0 && m.geom_conaffinity[g] == 0)) continue;
    sole_geoms_[side].push_back(g);
    const Pose geom = site_inverse * local_pose(m.geom_pos + 3 * g, m.geom_quat + 4 * g);
    for (const Vec3& point : surface_points(m, g)) {
      points.push_back(geom * point);
      lowest = std::min(lowest, points.back().z());
    }
  }
  std::vector<Vec2> outline;
  for (const Vec3& point : points) {
    if (point.z() < lowest + 0.004) outline.push_back(point.head<2>());
  }
  const ConvexPolygon polygon = ConvexPolygon::hull(outline);
  if (polygon.empty()) {
    throw InputError(fmt::format("model {}: body '{}' of the foot has no colliding geom to stand on",
                                 profile_.model.string(), name_of(m, mjOBJ_BODY, foot.body)));
  }
  Vec2 lo = polygon.vertices().front();
  Vec2 hi = lo;
  for (const Vec2& vertex : polygon.vertices()) {
    lo = lo.cwiseMin(vertex);
    hi = hi.cwiseMax(vertex);
  }
  const Vec2 centre = 0.5 * (lo + hi);
  std::vector<Vec2> centred;
  for (const Vec2& vertex : polygon.vertices())
    centred.push_back(vertex - centre);
  sole_[side] = ConvexPolygon::hull(centred);
  foot.frame = foot.frame * Pose{Vec3(centre.x(), centre.y(), lowest), Mat3::Identity()};
}

}  // namespace baton
