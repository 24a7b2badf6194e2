#include "baton/verify/obstacles.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <set>

#include "baton/model/error.hpp"

namespace baton {

Obstacles::Obstacles(const RobotModel& robot, const World& world) {
  const std::string owner = fmt::format("world {} with robot {}", world.name(), robot.profile().name);
  model_ = compile_text(world.compose(robot, robot.profile().tick.period, Visuals::drop), owner);
  const mjModel& m = *model_;
  if (m.nq != robot.nq()) throw InputError(fmt::format("{}: something in the world has joints of its own", owner));
  data_ = DataPtr(mj_makeData(&m));
  mj_kinematics(&m, data_.get());
  const int root = find_id(m, mjOBJ_BODY, name_of(robot.mj(), mjOBJ_BODY, 1), owner);
  const BySide<std::string> feet{name_of(robot.mj(), mjOBJ_BODY, robot.foot_body(Side::left)),
                                 name_of(robot.mj(), mjOBJ_BODY, robot.foot_body(Side::right))};
  std::set<std::string> arm;
  for (const Side side : kSides) {
    for (int body = robot.hand_body(side); body > 1; body = robot.mj().body_parentid[body]) {
      arm.insert(name_of(robot.mj(), mjOBJ_BODY, body));
      if (body == robot.shoulder_body(side)) break;
    }
  }
  const auto collides = [&m](int g) { return m.geom_contype[g] != 0 || m.geom_conaffinity[g] != 0; };
  for (int link = 0; link < m.ngeom; ++link) {
    if (!collides(link) || m.body_rootid[m.geom_bodyid[link]] != root) continue;
    const std::string body = name_of(m, mjOBJ_BODY, m.geom_bodyid[link]);
    const bool foot = body == feet.left || body == feet.right;
    const bool of_arm = arm.count(body) > 0;
    for (int obstacle = 0; obstacle < m.ngeom; ++obstacle) {
      if (!collides(obstacle) || m.body_rootid[m.geom_bodyid[obstacle]] == root) continue;
      const bool ground = World::is_ground(name(obstacle));
      if (!foot || !ground) (of_arm || ground ? pairs_ : by_map_).push_back({link, obstacle});
    }
  }
}

double Obstacles::least_distance(int geom, const Vec3& point) const {
  const Vec3 centre = Eigen::Map<const Vec3>(data_->geom_xpos + 3 * geom);
  const Eigen::Map<const Eigen::Matrix<double, 3, 3, Eigen::RowMajor>> axes(data_->geom_xmat + 9 * geom);
  const Vec3 local = axes.transpose() * (point - centre);
  const Vec3 size = Eigen::Map<const Vec3>(model_->geom_size + 3 * geom);
  switch (model_->geom_type[geom]) {
    case mjGEOM_PLANE:
      return local.z();
    case mjGEOM_BOX:
      return (local.cwiseAbs() - size).cwiseMax(0.0).norm();
    default:
      return local.norm() - model_->geom_rbound[geom];
  }
}

void Obstacles::set(const VecX& q) {
  mju_copy(data_->qpos, q.data(), model_->nq);
  mj_kinematics(model_.get(), data_.get());
}

double Obstacles::distance(bool by_map, double limit, std::array<int, 2>& geoms) const {
  double least = limit;
  for (const auto& [link, obstacle] : by_map ? by_map_ : pairs_) {
    const Vec3 centre = Eigen::Map<const Vec3>(data_->geom_xpos + 3 * link);
    if (least_distance(obstacle, centre) - model_->geom_rbound[link] >= least) continue;
    const double distance = mj_geomDistance(model_.get(), data_.get(), link, obstacle, least, nullptr);
    if (distance < least) {
      least = distance;
      geoms = {link, obstacle};
    }
  }
  return least;
}

}  // namespace baton
