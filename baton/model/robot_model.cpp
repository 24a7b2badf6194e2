#include "baton/model/robot_model.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>

#include "baton/model/anatomy.hpp"
#include "baton/model/error.hpp"
#include "baton/model/robot_file.hpp"

namespace baton {
namespace {

constexpr double kHomeMargin = 2.0;  ///< of a joint's home to its limits [margin.joint]

std::filesystem::path& installed_share() {
  static std::filesystem::path folder = BATON_SHARE_DIR;
  return folder;
}

}  // namespace

std::filesystem::path share_dir() {
  const char* given = std::getenv("BATON_SHARE");
  return given != nullptr ? given : installed_share();
}

void use_share_dir(std::filesystem::path folder) {
  installed_share() = std::move(folder);
}

std::filesystem::path profile_file(const std::string& name_or_file) {
  const std::filesystem::path file = name_or_file;
  const bool given = file.extension() == ".toml" || file.extension() == ".xml" || file.extension() == ".urdf";
  return given ? file : share_dir() / "robots" / name_or_file / "profile.toml";
}

RobotModel RobotModel::load(const std::string& name_or_file) {
  const std::filesystem::path file = profile_file(name_or_file);
  std::error_code ignored;
  if (!std::filesystem::exists(file, ignored)) {
    throw InputError(
        fmt::format("robot '{}': no file {}: give a folder of robots/, a profile (.toml) or a model (.xml, .urdf)",
                    name_or_file, file.string()));
  }
  return RobotModel(Profile::load(file));
}

SpecPtr RobotModel::spec(Visuals visuals) const {
  return read_robot(profile_.model, profile_.changes(), visuals);
}

RobotModel::RobotModel(Profile profile) : profile_(std::move(profile)) {
  const std::string owner = fmt::format("model {}", profile_.model.string());
  const SpecPtr text = spec(Visuals::drop);
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
  sole_half_width_ = std::min(half_width(sole_.left), half_width(sole_.right));
  for (const Side side : kSides) {
    const auto i = static_cast<std::size_t>(side);
    leg_[side] = joints_of_one(foot_[side].body, foot_[other(side)].body);
    arm_[side] = joints_of_one(hand_[side].body, hand_[other(side)].body);
    if (leg_[side].size() < 6) {
      throw InputError(fmt::format("{}: the leg to '{}' has {} joints: at least 6 are needed", owner,
                                   profile_.parts.foot[i], leg_[side].size()));
    }
  }
  mass_ = m.body_subtreemass[0];
  for (const Side side : kSides)
    limit_support(side);
  for (int j = 0; j < static_cast<int>(joints_.size()); ++j) {
    const auto has = [j](const std::vector<int>& chain) { return std::ranges::find(chain, j) != chain.end(); };
    if (has(leg_.left) || has(leg_.right) || has(arm_.left) || has(arm_.right)) continue;
    idle_.push_back(j);
  }
  if (!profile_.imu.empty()) {
    const Frame sensor = site_frame(profile_.imu, owner);
    if (sensor.body == 1) imu_ = sensor.frame;
  }
  omega_ = std::sqrt(kGravity / profile_.stance.com_height);
}

std::vector<int> RobotModel::joints_of_one(int body, int opposite) const {
  const std::vector<int>& others = dofs_to(opposite);
  std::vector<int> joints;
  for (const int dof : dofs_to(body)) {
    if (std::ranges::find(others, dof) == others.end()) joints.push_back(dof - 6);
  }
  return joints;
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
    const auto stated = profile_.motors.find(joint.name);
    const double speed = stated == profile_.motors.end() ? 0.0 : stated->second.speed;
    if (!(joint.motor.damping > 0.0) && !(speed > 0.0)) {
      throw InputError(
          fmt::format("{}: joint '{}' has no damping, which would set its no-load speed: give its motor "
                      "one, or drive.gains.speed",
                      owner, joint.name));
    }
    joint.motor.no_load = speed > 0.0 ? speed : stall / joint.motor.damping;
    joint.speed = profile_.margin.speed * joint.motor.no_load;
    const auto gains = profile_.gains.find(joint.name);
    if (gains == profile_.gains.end()) {
      throw InputError(
          fmt::format("profile of {}: drive.gains names no gains for joint '{}'", profile_.name, joint.name));
    }
    joint.gains = gains->second;
    const auto home = profile_.home.find(joint.name);
    joint.home = home == profile_.home.end() ? 0.0 : home->second;
    if (home != profile_.home.end() && (joint.home < joint.position.lo || joint.home > joint.position.hi)) {
      throw InputError(
          fmt::format("profile of {}: home_deg.{} lies outside the joint's range", profile_.name, joint.name));
    }
    if (joint.position.hi - joint.position.lo > 2.0 * kHomeMargin * profile_.margin.joint) {
      joint.home = Range{joint.position.lo + kHomeMargin * profile_.margin.joint,
                         joint.position.hi - kHomeMargin * profile_.margin.joint}
                       .clamped(joint.home);
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
  Frame& foot = foot_[side];
  const SoleShape shape = sole_shape(*model_, foot.body, foot.frame);
  if (shape.outline.empty()) {
    throw InputError(fmt::format("model {}: body '{}' of the foot has no colliding geom to stand on",
                                 profile_.model.string(), name_of(*model_, mjOBJ_BODY, foot.body)));
  }
  sole_[side] = shape.outline;
  sole_geoms_[side] = shape.geoms;
  foot.frame = foot.frame * Pose{Vec3(shape.centre.x(), shape.centre.y(), shape.height), Mat3::Identity()};
}

void RobotModel::limit_support(Side side) {
  constexpr double kShare = 0.85;  // of the permitted torque: accelerations need some of it, too
  constexpr double kFar = 10.0;    // [m]
  const mjModel& m = *model_;
  const DataPtr data(mj_makeData(&m));
  mj_kinematics(&m, data.get());
  const int body = foot_[side].body;
  const Pose foot{Eigen::Map<const Vec3>(data->xpos + 3 * body),
                  Eigen::Map<const Eigen::Matrix<double, 3, 3, Eigen::RowMajor>>(data->xmat + 9 * body)};
  const Pose to_sole = (foot * foot_[side].frame).inverse();
  support_[side] = sole_[side];
  for (auto j = leg_[side].end() - 2; j != leg_[side].end(); ++j) {
    const Vec3 axis = to_sole.R * Eigen::Map<const Vec3>(data->xaxis + 3 * (1 + *j));
    const Vec3 anchor = to_sole * Eigen::Map<const Vec3>(data->xanchor + 3 * (1 + *j));
    const Vec2 across(-axis.y(), axis.x());  // lever arm of the weight about the axis: across · (p − a)
    if (across.norm() < 0.1) continue;       // about the vertical
    const double torque = kShare * profile_.margin.torque * joints_[static_cast<std::size_t>(*j)].motor.stall;
    const double most = torque / (mass_ * kGravity * across.norm());
    const Vec2 n = across.normalized();
    const Vec2 along(-n.y(), n.x());
    const auto& vertices = support_[side].vertices();
    if (std::ranges::all_of(vertices, [&](const Vec2& p) { return std::abs(n.dot(p - anchor.head<2>())) <= most; })) {
      continue;
    }
    std::vector<Vec2> strip;
    for (const double a : {-most, most}) {
      for (const double b : {-kFar, kFar})
        strip.push_back(anchor.head<2>() + a * n + b * along);
    }
    support_[side] = support_[side].clipped(ConvexPolygon::hull(strip));
  }
  if (support_[side].empty()) {
    throw InputError(
        fmt::format("model {}: the ankle of the {} leg is too weak to carry the robot's weight anywhere on "
                    "its sole",
                    profile_.model.string(), to_string(side)));
  }
}

}  // namespace baton
