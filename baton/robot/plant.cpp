#include "baton/robot/plant.hpp"

#include <fmt/format.h>

#include <array>
#include <random>

#include "baton/model/error.hpp"
#include "baton/model/world.hpp"

namespace baton {
namespace {

constexpr int kTiles = 40;  ///< rows, and tiles per row
constexpr int kLevel = 2;   ///< tiles kept level around the start, in each direction

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

}  // namespace

Vec3 Plant::force(double t) const {
  Vec3 sum = Vec3::Zero();
  for (const Push& push : pushes) {
    if (t >= push.t && t < push.t + push.duration) sum += push.impulse / push.duration;
  }
  return sum;
}

std::string with_ground(const std::string& text, const Plant& plant, const std::string& root, const Vec3& at) {
  if (plant.tiles == 0.0 && plant.tilt.isZero(0.0)) return text;
  const auto lock = lock_compiler();
  const SpecPtr spec = parse_text(text, "world");
  mjsBody* world = mjs_findBody(spec.get(), "world");
  if (plant.tiles > 0.0) add_tiles(*world, plant, at);
  const Mat3 R = rotation_exp(plant.tilt);
  const Pose by{at - R * at, R};
  for (mjsElement* e = mjs_firstChild(world, mjOBJ_GEOM, 0); e != nullptr; e = mjs_nextChild(world, e, 0))
    move(*mjs_asGeom(e), by);
  for (mjsElement* e = mjs_firstChild(world, mjOBJ_BODY, 0); e != nullptr; e = mjs_nextChild(world, e, 0)) {
    if (root != mjs_getString(mjs_getName(e))) move(*mjs_asBody(e), by);
  }
  static_cast<void>(compile_model(*spec, "world"));
  return text_of(*spec, "world");
}

}  // namespace baton
