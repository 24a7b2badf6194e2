#include "baton/robot/plant.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <random>
#include <stdexcept>

#include "baton/model/error.hpp"
#include "baton/model/kinematics.hpp"
#include "baton/model/world.hpp"
#include "baton/robot/robot_in_world.hpp"

namespace baton {
namespace {

constexpr int kTiles = 40;              ///< rows, and tiles per row
constexpr int kLevel = 2;               ///< tiles kept level around the start, in each direction
constexpr double kPayloadRadius = 0.1;  ///< [COM height]
constexpr double kSpringTime = 0.003;   ///< damping of a hip's spring, relative to its stiffness [s]

Pose pose_of(const double* pos, const double* quat) {
  return {Eigen::Map<const Vec3>(pos),
          Eigen::Quaterniond(quat[0], quat[1], quat[2], quat[3]).normalized().toRotationMatrix()};
}

/// Transforms an element through its `pos` and `quat`.
template <typename Element>
void move(Element& element, const Pose& by) {
  const Pose moved = by * pose_of(element.pos, element.quat);
  const Eigen::Quaterniond q(moved.R);
  Eigen::Map<Vec3>(element.pos) = moved.p;
  const std::array<double, 4> quat{q.w(), q.x(), q.y(), q.z()};
  std::copy(quat.begin(), quat.end(), element.quat);
}

void add_tiles(mjsBody& world, const Plant& plant, const Vec3& at) {
  mjsElement* only = mjs_firstChild(&world, mjOBJ_GEOM, 0);
  mjsGeom* plane = only == nullptr ? nullptr : mjs_asGeom(only);
  if (plane == nullptr || plane->type != mjGEOM_PLANE || mjs_nextChild(&world, only, 0) != nullptr) {
    throw InputError("tiles need a world whose ground is one plane and nothing else");
  }
  const double ground = plane->pos[2];
  const double half = 0.5 * plant.tile_side;
  plane->pos[2] -= 2.0 * plant.tiles;
  std::mt19937_64 random(plant.seed);
  std::uniform_real_distribution<double> height(-plant.tiles, plant.tiles);
  for (int i = -kTiles / 2; i < kTiles / 2; ++i) {
    for (int k = -kTiles / 2; k < kTiles / 2; ++k) {
      const double x = (2 * i + 1) * half;
      const double y = (2 * k + 1) * half;
      const double top = std::max(std::abs(x), std::abs(y)) < 2 * kLevel * half ? 0.0 : height(random);
      mjsGeom* tile = mjs_addGeom(&world, nullptr);
      mjs_setName(tile->element, fmt::format("ground_tile_{}_{}", i, k).c_str());
      tile->type = mjGEOM_BOX;
      Eigen::Map<Vec3>(tile->size) = Vec3(half, half, half);
      Eigen::Map<Vec3>(tile->pos) = Vec3(at.x() + x, at.y() + y, ground + top - half);
    }
  }
}

/// Tiles, then the tilt.
void change_ground(mjsBody& world, const Plant& plant, const std::string& root, const Vec3& at) {
  if (plant.tiles > 0.0) add_tiles(world, plant, at);
  const Mat3 R = rotation_exp(plant.tilt);
  const Pose by{at - R * at, R};
  for (mjsElement* e = mjs_firstChild(&world, mjOBJ_GEOM, 0); e != nullptr; e = mjs_nextChild(&world, e, 0))
    move(*mjs_asGeom(e), by);
  for (mjsElement* e = mjs_firstChild(&world, mjOBJ_BODY, 0); e != nullptr; e = mjs_nextChild(&world, e, 0)) {
    if (root != mjs_getString(mjs_getName(e))) move(*mjs_asBody(e), by);
  }
}

/// Adds payloads and springs.
void add_parts(mjSpec& spec, const Plant& plant, const RobotModel& robot) {
  for (const Side side : kSides) {
    if (plant.payload[side] > 0.0) {
      mjsBody* hand = mjs_findBody(&spec, name_of(robot.mj(), mjOBJ_BODY, robot.hand_body(side)).c_str());
      mjsBody* payload = mjs_addBody(hand, nullptr);  // the hand's own inertia may be stated, not that of its geoms
      mjs_setName(payload->element, fmt::format("{}_payload", to_string(side)).c_str());
      Eigen::Map<Vec3>(payload->pos) = robot.hand_in_body(side).p;
      mjsGeom* ball = mjs_addGeom(payload, nullptr);
      ball->type = mjGEOM_SPHERE;
      ball->mass = plant.payload[side];
      ball->size[0] = kPayloadRadius * robot.profile().stance.com_height;
      ball->contype = ball->conaffinity = 0;
    }
    if (plant.actuators.hip_compliance > 0.0) {
      const int hip = abduction(robot, side);
      const std::string name = robot.joints()[static_cast<std::size_t>(hip)].name;
      const mjsJoint& motor = *mjs_asJoint(mjs_findElement(&spec, mjOBJ_JOINT, name.c_str()));
      mjsBody* link = mjs_findBody(&spec, name_of(robot.mj(), mjOBJ_BODY, robot.mj().jnt_bodyid[1 + hip]).c_str());
      mjsJoint* spring = mjs_addJoint(link, nullptr);
      mjs_setName(spring->element, flexible(name).c_str());
      spring->type = mjJNT_HINGE;
      std::copy_n(&motor.axis[0], 3, &spring->axis[0]);
      std::copy_n(&motor.pos[0], 3, &spring->pos[0]);
      const double stiffness =
          robot.mass() * kGravity * robot.profile().stance.com_height / plant.actuators.hip_compliance;
      spring->stiffness[0] = stiffness;
      spring->damping[0] = kSpringTime * stiffness;
      spring->limited = mjLIMITED_FALSE;
    }
  }
}

/// Makes the contact of a sole's geom that of a critically damped mat, into which both soles together, each on four
/// points, sink by `depth` [m]. With the impedance d, MuJoCo's static force at a point of penetration r and effective
/// mass 1/A is k r/((1 − d) A).
void soften(mjModel& m, int geom, double weight, double depth) {
  constexpr double impedance = 0.5;
  constexpr double points = 8.0;
  const double inverse_mass = m.body_invweight0[2 * m.geom_bodyid[geom]];
  const double stiffness = weight / points / depth * inverse_mass * (1.0 - impedance);
  std::fill_n(m.geom_solimp + 5 * geom, 2, impedance);
  m.geom_solref[2 * geom] = -stiffness;
  m.geom_solref[2 * geom + 1] = -2.0 * std::sqrt(stiffness);
}

/// Changes contact, masses and dry friction.
void perturb(mjModel& m, const Plant& plant, const RobotModel& robot) {
  const RobotInWorld in_world = RobotInWorld::find(robot, m, "world");
  for (int g = 0; g < m.ngeom; ++g) {
    if (!in_world.geom(g).sole) continue;
    if (plant.friction) m.geom_friction[3 * g] = *plant.friction;
    if (plant.solref) m.geom_solref[2 * g] = *plant.solref;
    if (plant.mat > 0.0) soften(m, g, robot.mass() * kGravity, plant.mat);
  }
  for (int b = 0; b < m.nbody; ++b) {
    m.body_mass[b] *= plant.mass;
    for (int axis = 0; axis < 3; ++axis)
      m.body_inertia[3 * b + axis] *= plant.mass;
  }
  for (int axis = 0; axis < 3; ++axis)
    m.body_ipos[3 * in_world.root_body + axis] += plant.com_offset[axis];
  for (std::size_t j = 0; j < in_world.joints.size(); ++j)
    m.dof_frictionloss[in_world.joints[j].dof] += plant.actuators.friction * robot.joints()[j].motor.stall;
}

}  // namespace

int abduction(const RobotModel& robot, Side side) {
  Kinematics kinematics(robot);
  kinematics.set(Eigen::Map<const VecX>(robot.mj().qpos0, robot.nq()));
  for (const int j : robot.leg(side)) {
    if (std::abs(kinematics.dof_axis(6 + j).direction.x()) > M_SQRT1_2) return j;
  }
  throw InputError(
      fmt::format("robot {}: the {} leg has no joint for abduction", robot.profile().name, to_string(side)));
}

Vec3 Plant::force(double t, std::optional<Side> hand) const {
  Vec3 sum = Vec3::Zero();
  for (const Push& push : pushes) {
    if (push.hand == hand && t >= push.t && t < push.t + push.duration) sum += push.impulse / push.duration;
  }
  return sum;
}

Plant real_plant(const RobotModel& robot, std::uint64_t seed) {
  Plant plant;
  plant.sensors = robot.profile().sensors;
  plant.actuators = robot.profile().actuators;
  plant.seed = seed;
  return plant;
}

std::string with_plant(const std::string& text, const Plant& plant, const RobotModel& robot, const Vec3& at) {
  const bool ground = plant.tiles > 0.0 || !plant.tilt.isZero(0.0);
  const bool parts = plant.payload != BySide<double>{} || plant.actuators.hip_compliance > 0.0;
  const bool perturbed = plant.friction || plant.solref || plant.mat > 0.0 || plant.mass != 1.0 ||
                         !plant.com_offset.isZero(0.0) || plant.actuators.friction > 0.0;
  if (!ground && !parts && !perturbed) return text;
  const auto lock = lock_compiler();
  const SpecPtr spec = parse_text(text, "world");
  if (ground) change_ground(*mjs_findBody(spec.get(), "world"), plant, name_of(robot.mj(), mjOBJ_BODY, 1), at);
  if (parts) add_parts(*spec, plant, robot);
  const ModelPtr model = compile_model(*spec, "world");
  if (perturbed) {
    perturb(*model, plant, robot);
    if (mj_copyBack(spec.get(), model.get()) == 0) throw std::logic_error("the compiled model is not that of the text");
  }
  return text_of(*spec, "world");
}

}  // namespace baton
