#include "baton/proving/checker.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "baton/model/error.hpp"
#include "baton/model/world.hpp"

namespace baton {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();
constexpr mjtByte kGroundGroup = 5;
// Limits of a capture step:
constexpr double kCatchingTorque = 1.0;        ///< fraction of the stall torque
constexpr double kCatchingAcceleration = 1.5;  ///< relative to the profile's

double cross(const Vec2& a, const Vec2& b) {
  return a.x() * b.y() - a.y() * b.x();
}

/// Distance of `x` inside the points' hull: to the nearest line through two points that has all others on its left. −∞
/// for a hull without area.
double inside_hull(const std::vector<Vec2>& points, const Vec2& x) {
  double margin = kInfinity;
  for (const Vec2& a : points) {
    for (const Vec2& b : points) {
      const Vec2 along = b - a;
      const double length = along.norm();
      if (length < 1e-9) continue;
      const bool edge = std::all_of(points.begin(), points.end(),
                                    [&](const Vec2& c) { return cross(along, c - a) >= -1e-9 * length; });
      if (edge) margin = std::min(margin, cross(along, x - a) / length);
    }
  }
  return std::isfinite(margin) ? margin : -kInfinity;
}

Vec3 vec3(const mjtNum* x) {
  return {x[0], x[1], x[2]};
}

bool finite(const Checker::Tick& tick) {
  return std::isfinite(tick.t) && tick.q.allFinite() && tick.target.allFinite() && tick.frame.p.allFinite() &&
         tick.frame.R.allFinite();
}

bool same_place(const Checker::Tick& a, const Checker::Tick& b) {
  return a.q == b.q && a.contact.left == b.contact.left && a.contact.right == b.contact.right &&
         a.frame.p == b.frame.p && a.frame.R == b.frame.R;
}

}  // namespace

Checker::Checker(const RobotModel& robot, const std::string& model_text, const Tolerances& tolerances)
    : robot_(&robot), tolerance_(tolerances), model_(compile_text(model_text, "model of robot and world")) {
  const mjModel& m = *model_;
  if (m.nq != robot.nq()) throw InputError("model of robot and world: the world has joints");
  prepare_model();
  world_ = DataPtr(mj_makeData(&m));
  forces_ = DataPtr(mj_makeData(&m));
  parts_.of_leg.assign(robot.joints().size(), 0);
  for (const Side side : kSides) {
    for (const int joint : robot.leg(side))
      parts_.of_leg[static_cast<std::size_t>(joint)] = 1;
  }
  const double foot = robot.sole(Side::left).vertices().front().norm();
  const Profile::Ik& ik = robot.profile().ik;
  place_tolerance_ = tolerance_.residuals * (ik.position + ik.rotation * foot);
}

void Checker::prepare_model() {
  mjModel& m = *model_;
  const std::string owner = "model of robot and world";
  for (const Side side : kSides)
    parts_.foot[side] = find_id(m, mjOBJ_BODY, name_of(robot_->mj(), mjOBJ_BODY, robot_->foot_body(side)), owner);
  const int root = m.body_rootid[parts_.foot.left];
  // No contact forces; collision detection within twice the margin.
  m.opt.disableflags |= mjDSBL_SPRING | mjDSBL_DAMPER;
  const double reach = 2.0 * robot_->profile().margin.self_collision;
  for (int g = 0; g < m.ngeom; ++g) {
    const int body = m.geom_bodyid[g];
    parts_.of_robot.push_back(m.body_rootid[body] == root);
    parts_.of_foot.push_back(body == parts_.foot.left || body == parts_.foot.right);
    parts_.ground.push_back(!parts_.of_robot.back() && World::is_ground(name_of(m, mjOBJ_GEOM, g)));
    m.geom_group[g] = parts_.ground.back() ? kGroundGroup : 0;
    m.geom_margin[g] = 0.0;
    m.geom_gap[g] = parts_.of_robot.back() ? 0.0 : reach;
    if (!parts_.of_robot.back()) m.body_margin[body] = reach;
  }
  for (int p = 0; p < m.npair; ++p) {
    m.pair_margin[p] = 0.0;
    m.pair_gap[p] = reach;
  }
}

void Checker::report(Kind kind, double t, double value, double limit, std::string where) {
  found_.push_back({kind, t, value, limit, std::move(where)});
}

std::string Checker::geoms(int a, int b) const {
  return fmt::format("{} and {}", name_of(*model_, mjOBJ_GEOM, a), name_of(*model_, mjOBJ_GEOM, b));
}

void Checker::place(const Tick& tick, mjData& data, bool in_world) const {
  mju_copy(data.qpos, tick.q.data(), model_->nq);
  if (in_world) {
    const Vec3 p = tick.frame * Vec3(tick.q.head<3>());
    const Eigen::Quaterniond turn(tick.frame.R);
    const Eigen::Quaterniond attitude = turn * Eigen::Quaterniond(tick.q[3], tick.q[4], tick.q[5], tick.q[6]);
    mju_copy(data.qpos, p.data(), 3);
    data.qpos[3] = attitude.w();
    mju_copy(data.qpos + 4, attitude.vec().data(), 3);
  }
  mj_kinematics(model_.get(), &data);
  mj_comPos(model_.get(), &data);
}

Pose Checker::sole(Side side, const mjData& data) const {
  const int body = parts_.foot[side];
  const Eigen::Map<const Eigen::Matrix<double, 3, 3, Eigen::RowMajor>> R(data.xmat + 9 * body);
  return Pose{vec3(data.xpos + 3 * body), R} * robot_->sole_in_foot(side);
}

const std::vector<Checker::Violation>& Checker::add(const Tick& tick) {
  found_.clear();
  if (!finite(tick)) {
    report(Kind::not_finite, tick.t, 0.0, 0.0);
    before_.reset();
    earlier_.reset();
    still_ = false;
    return found_;
  }
  // Judge a state at rest once.
  const bool unmoved = before_ && same_place(*before_, tick);
  judge_joints(tick);
  if (before_) judge_step(*before_, tick);
  if (!unmoved) {
    place(tick, *world_, true);
    judge_contacts(tick);
    judge_soles(tick);
  }
  if (earlier_ && !(unmoved && still_)) judge_forces(*earlier_, *before_, tick);
  still_ = unmoved && earlier_ && same_place(*earlier_, *before_);
  earlier_ = std::move(before_);
  before_ = tick;
  return found_;
}

void Checker::judge_joints(const Tick& tick) {
  const double margin = robot_->profile().margin.joint;
  for (std::size_t j = 0; j < robot_->joints().size(); ++j) {
    const Joint& joint = robot_->joints()[j];
    const auto i = static_cast<Eigen::Index>(j);
    const double q = tick.q[7 + i];
    for (const double angle : {q, tick.target[i]}) {
      const double room = std::min(angle - joint.position.lo, joint.position.hi - angle);
      if (!(room >= margin - tolerance_.exact)) report(Kind::joint_range, tick.t, room, margin, joint.name);
    }
    if (!before_) continue;
    const double missed = std::abs(q - before_->target[i]);
    if (!(missed <= tolerance_.exact)) report(Kind::target, tick.t, missed, tolerance_.exact, joint.name);
  }
}

void Checker::judge_step(const Tick& before, const Tick& tick) {
  const double period = robot_->profile().tick.period;
  const double passed = tick.t - before.t;
  if (!(std::abs(passed - period) <= tolerance_.exact)) report(Kind::clock, tick.t, passed, period);
  for (std::size_t j = 0; j < robot_->joints().size(); ++j) {
    const Joint& joint = robot_->joints()[j];
    const auto i = 7 + static_cast<Eigen::Index>(j);
    const double speed = std::abs(tick.q[i] - before.q[i]) / period;
    const double limit = joint.speed + 2.0 * tolerance_.exact / period;
    if (!(speed <= limit)) report(Kind::joint_speed, tick.t, speed, joint.speed, joint.name);
  }
  if (tick.hold && before.hold) {
    const double moved = (tick.q - before.q).cwiseAbs().maxCoeff();
    if (!(moved <= tolerance_.still)) report(Kind::rest, tick.t, moved, tolerance_.still);
  }
}

void Checker::judge_contacts(const Tick& tick) {
  const mjModel& m = *model_;
  mj_collision(&m, world_.get());
  const double margin = robot_->profile().margin.self_collision;
  for (int c = 0; c < world_->ncon; ++c) {
    const mjContact& contact = world_->contact[c];
    const int a = contact.geom[0];
    const int b = contact.geom[1];
    const auto is = [a, b](const std::vector<char>& set, bool first) {
      return set[static_cast<std::size_t>(first ? a : b)] != 0;
    };
    const bool both = is(parts_.of_robot, true) && is(parts_.of_robot, false);
    const bool sole = !both && ((is(parts_.of_foot, true) && is(parts_.ground, false)) ||
                                (is(parts_.of_foot, false) && is(parts_.ground, true)));
    if (sole) {
      const int foot = m.geom_bodyid[is(parts_.of_foot, true) ? a : b];
      const Side side = foot == parts_.foot.left ? Side::left : Side::right;
      const double limit = -tolerance_.sink - place_tolerance_;
      // A stance sole was judged at touchdown and must not slip; its estimated position changes every tick.
      const bool judged = tick.contact[side] && stood_[side];
      if (!judged && contact.dist < limit) {
        report(tick.contact[side] ? Kind::sole_ground : Kind::swing_ground, tick.t, contact.dist, limit, geoms(a, b));
      }
      continue;
    }
    // Box colliders test few directions and may report false proximity: MuJoCo's distance decides.
    const double limit = margin - (both ? tolerance_.exact : place_tolerance_);
    if (contact.dist >= limit) continue;
    const double distance = mj_geomDistance(&m, world_.get(), a, b, 2.0 * margin, nullptr);
    if (distance < limit) report(both ? Kind::self_collision : Kind::obstacle, tick.t, distance, margin, geoms(a, b));
  }
}

void Checker::judge_soles(const Tick& tick) {
  for (const Side side : kSides) {
    if (!tick.contact[side]) {
      stood_[side].reset();
      continue;
    }
    const Pose now = tick.frame.inverse() * sole(side, *world_);
    if (!stood_[side]) {
      stood_[side] = now;
      judge_ground(tick, side);
      continue;
    }
    double moved = 0.0;
    for (const Vec2& v : robot_->sole(side).vertices()) {
      const Vec3 corner(v.x(), v.y(), 0.0);
      moved = std::max(moved, (now * corner - *stood_[side] * corner).norm());
    }
    if (!(moved <= place_tolerance_)) report(Kind::slip, tick.t, moved, place_tolerance_, std::string(to_string(side)));
  }
}

/// Casts rays from just above the sole to the ground, all over the sole.
void Checker::judge_ground(const Tick& tick, Side side) {
  const Pose pose = sole(side, *world_);
  const std::vector<Vec2>& rim = robot_->sole(side).vertices();
  const double above = 0.2 * robot_->profile().stance.com_height;
  const double allowed = robot_->profile().ground.flatness + tolerance_.sink + place_tolerance_;
  constexpr std::array<mjtByte, mjNGROUP> only_ground{0, 0, 0, 0, 0, 1};
  constexpr int kSteps = 6;
  double worst = 0.0;
  for (std::size_t i = 0; i < rim.size(); ++i) {
    for (int along = 0; along < kSteps; ++along) {
      const Vec2 edge = rim[i] + (rim[(i + 1) % rim.size()] - rim[i]) * (along / static_cast<double>(kSteps));
      for (int inward = 0; inward <= kSteps; ++inward) {
        const Vec2 spot = edge * (inward / static_cast<double>(kSteps));
        const Vec3 start = pose * Vec3(spot.x(), spot.y(), 0.0) + Vec3(0, 0, above);
        const Vec3 down(0, 0, -1);
        int geom = -1;
        const double depth =
            mj_ray(model_.get(), world_.get(), start.data(), down.data(), only_ground.data(), 1, -1, &geom, nullptr);
        const double off = geom < 0 ? kInfinity : std::abs(depth - above);
        // The sole's centre lies on the ground; elsewhere the ground may deviate within the flatness limit.
        const double limit = inward == 0 ? allowed - robot_->profile().ground.flatness : allowed;
        if (off > limit) worst = std::max(worst, off);
      }
    }
  }
  if (worst > 0.0) report(Kind::sole_ground, tick.t, worst, allowed, std::string(to_string(side)));
}

void Checker::judge_forces(const Tick& before, const Tick& tick, const Tick& after) {
  mjModel& m = *model_;
  mjData& d = *forces_;
  const double dt = robot_->profile().tick.period;
  const bool catching = before.catching || tick.catching || after.catching;
  VecX to(m.nv);
  VecX from(m.nv);
  mj_differentiatePos(&m, from.data(), dt, before.q.data(), tick.q.data());
  mj_differentiatePos(&m, to.data(), dt, tick.q.data(), after.q.data());
  for (std::size_t j = 0; j < robot_->joints().size(); ++j) {
    const Joint& joint = robot_->joints()[j];
    const auto i = 6 + static_cast<Eigen::Index>(j);
    const double rate = std::abs(to[i] - from[i]) / dt;
    const double limit = robot_->profile().margin.acceleration * (catching ? kCatchingAcceleration : 1.0);
    if (!(rate <= limit * (1.0 + 1e-6))) report(Kind::joint_acceleration, tick.t, rate, limit, joint.name);
  }

  // External forces required for this motion, without contact.
  const VecX speed = 0.5 * (from + to);
  const VecX rate = (to - from) / dt;
  mju_copy(d.qvel, speed.data(), m.nv);
  mju_copy(d.qacc, rate.data(), m.nv);
  mju_copy(d.qpos, tick.q.data(), m.nq);
  const int flags = m.opt.disableflags;
  m.opt.disableflags |= mjDSBL_CONSTRAINT;
  mj_inverse(&m, &d);
  m.opt.disableflags = flags;
  const VecX force = Eigen::Map<const VecX>(d.qfrc_inverse, m.nv);

  const Vec3 push = force.head<3>();
  const double slope = push.z() > 0.0 ? push.head<2>().norm() / push.z() : kInfinity;
  const double friction = robot_->profile().margin.friction;
  if (!(slope <= friction + tolerance_.friction)) report(Kind::friction, tick.t, slope, friction);

  // Project the planned soles from the COM onto the plane of the lower one, and intersect the line of force with it.
  double height = kInfinity;
  for (const Side side : kSides) {
    if (tick.contact[side]) height = std::min(height, sole(side, d).p.z());
  }
  const int root = m.body_rootid[parts_.foot.left];
  const Vec3 com = vec3(d.subtree_com + 3 * root);
  std::vector<Vec2> points;
  for (const Side side : kSides) {
    if (!tick.contact[side]) continue;
    const Pose pose = sole(side, d);
    for (const Vec2& v : robot_->sole(side).vertices()) {
      const Vec3 c = pose * Vec3(v.x(), v.y(), 0.0);
      points.push_back((com + (c - com) * ((com.z() - height) / (com.z() - c.z()))).head<2>());
    }
  }
  const Vec3 origin = vec3(d.xpos + 3 * root);
  const Eigen::Map<const Eigen::Matrix<double, 3, 3, Eigen::RowMajor>> attitude(d.xmat + 9 * root);
  const Vec3 moment = attitude * Vec3(force.segment<3>(3)) + (origin - Vec3(0, 0, height)).cross(push);
  const Vec2 zmp = Vec2(-moment.y(), moment.x()) / push.z();
  const double margin = points.empty() ? -kInfinity : inside_hull(points, zmp);
  const double limit = robot_->profile().margin.zmp_verify;
  if (!(margin >= limit - tolerance_.zmp)) report(Kind::zmp, tick.t, margin, limit);

  judge_torques(tick, force, speed, catching ? kCatchingTorque : robot_->profile().margin.torque);
}

/// In single support the stance sole carries everything, so every torque is determined; arms carry only themselves.
void Checker::judge_torques(const Tick& tick, const VecX& force, const VecX& speed, double share) {
  const mjModel& m = *model_;
  mjData& d = *forces_;
  const bool single = tick.contact.left != tick.contact.right;
  VecX torque = force;
  if (single) {
    const int root = m.body_rootid[parts_.foot.left];
    VecX ground = VecX::Zero(m.nv);
    const Vec3 push = force.head<3>();
    const Eigen::Map<const Eigen::Matrix<double, 3, 3, Eigen::RowMajor>> attitude(d.xmat + 9 * root);
    const Vec3 moment = attitude * Vec3(force.segment<3>(3));
    mj_applyFT(&m, &d, push.data(), moment.data(), d.xpos + 3 * root,
               parts_.foot[tick.contact.left ? Side::left : Side::right], ground.data());
    torque -= ground;
  }
  for (std::size_t j = 0; j < robot_->joints().size(); ++j) {
    if (parts_.of_leg[j] && !single) continue;
    const Joint& joint = robot_->joints()[j];
    const auto i = 6 + static_cast<Eigen::Index>(j);
    const double load = (std::abs(torque[i]) + joint.motor.damping * std::abs(speed[i])) / joint.motor.stall;
    if (!(load <= share + tolerance_.load)) report(Kind::joint_torque, tick.t, load, share, joint.name);
  }
}

}  // namespace baton
