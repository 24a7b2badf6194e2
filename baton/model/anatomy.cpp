#include "baton/model/anatomy.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

namespace baton {
namespace {

constexpr double kFlat = 0.01;      ///< thickness of what counts as touching the plane [length of the foot]
constexpr double kOnSide = 0.2;     ///< a cylinder whose axis rises by less than this lies on its side [-]
constexpr int kArmJoints = 7;       ///< most joints of an arm: what comes after them are fingers
constexpr int kLegJoints = 6;       ///< least joints of a leg
constexpr double kMidline = 0.005;  ///< a limb on one side is beyond this [height of the robot]

/// Points of a geom, in its frame, among which are those that touch a plane with this normal.
std::vector<Vec3> touching_points(const mjModel& m, int geom, const Vec3& normal) {
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
      points = {-size[0] * normal};
      break;
    case mjGEOM_ELLIPSOID: {
      const Vec3 radii(size[0], size[1], size[2]);
      points = {-radii.cwiseProduct(radii).cwiseProduct(normal) / radii.cwiseProduct(normal).norm()};
      break;
    }
    case mjGEOM_CAPSULE:
      for (const double end : {-size[1], size[1]})
        points.push_back(Vec3(0, 0, end) - size[0] * normal);
      break;
    case mjGEOM_CYLINDER: {
      // On its side it touches along a line, on its end with a disk.
      const bool on_side = std::abs(normal.z()) < kOnSide;
      const Vec2 below = on_side ? Vec2(-size[0] * normal.head<2>().normalized()) : Vec2::Zero();
      for (const double end : {-size[1], size[1]}) {
        if (on_side) points.emplace_back(below.x(), below.y(), end);
        for (int k = 0; k < 16 && !on_side; ++k) {
          const double a = k * M_PI / 8.0;
          points.emplace_back(size[0] * std::cos(a), size[0] * std::sin(a), end);
        }
      }
      break;
    }
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

int hinges(const mjModel& m, int body) {
  int count = 0;
  for (int j = m.body_jntadr[body]; j >= 0 && j < m.body_jntadr[body] + m.body_jntnum[body]; ++j) {
    if (m.jnt_type[j] == mjJNT_HINGE) ++count;
  }
  return count;
}

/// What is asked about the tree of bodies.
struct Tree {
  explicit Tree(const mjModel& model) : m(model) {
    for (int b = 1; b < m.nbody; ++b) {
      int above = 0;
      for (int a = b; a > 0; a = m.body_parentid[a])
        above += hinges(m, a);
      depth.push_back(above);
    }
  }
  [[nodiscard]] int hinges_to(int body) const { return depth[static_cast<std::size_t>(body - 1)]; }
  [[nodiscard]] bool below(int body, int ancestor) const {
    while (body > ancestor)
      body = m.body_parentid[body];
    return body == ancestor;
  }
  /// Whether anything below this body moves against it.
  [[nodiscard]] bool is_end(int body) const {
    for (int b = body + 1; b < m.nbody; ++b) {
      if (hinges(m, b) > 0 && below(b, body)) return false;
    }
    return true;
  }

  const mjModel& m;
  std::vector<int> depth;
};

/// Where the bodies are at q = 0, in the root's frame [m].
std::vector<Vec3> origins(const mjModel& m) {
  std::vector<Pose> poses(static_cast<std::size_t>(m.nbody));
  std::vector<Vec3> points(poses.size(), Vec3::Zero());
  for (int b = 2; b < m.nbody; ++b) {
    const auto i = static_cast<std::size_t>(b);
    poses[i] =
        poses[static_cast<std::size_t>(m.body_parentid[b])] * local_pose(m.body_pos + 3 * b, m.body_quat + 4 * b);
    points[i] = poses[i].p;
  }
  return points;
}

void find_feet(const Tree& tree, const std::vector<Vec3>& at, Anatomy& found) {
  for (const Side side : kSides) {
    double lowest = std::numeric_limits<double>::infinity();
    for (int b = 2; b < tree.m.nbody; ++b) {
      const Vec3& p = at[static_cast<std::size_t>(b)];
      if (hinges(tree.m, b) == 0 || !tree.is_end(b) || tree.hinges_to(b) < kLegJoints) continue;
      if (p.y() * sign_of(side) <= 0.0 || p.z() >= lowest) continue;
      lowest = p.z();
      found.foot[side] = b;
    }
  }
  if (found.foot.left < 0 || found.foot.right < 0) {
    found.no_legs = "no two legs of at least 6 hinges, one on each side (y > 0 is left) at q = 0";
  }
}

void find_arms(const Tree& tree, const std::vector<Vec3>& at, Anatomy& found) {
  const mjModel& m = tree.m;
  double height = 0.0;
  for (const Vec3& p : at)
    height = std::max(height, p.z() - at[static_cast<std::size_t>(std::max(0, found.foot.left))].z());
  for (const Side side : kSides) {
    const auto on_side = [&](int body) {
      for (int b = body; b < m.nbody; ++b) {
        if (tree.below(b, body) && at[static_cast<std::size_t>(b)].y() * sign_of(side) < kMidline * height)
          return false;
      }
      return true;
    };
    double heaviest = 0.0;
    for (int b = 2; b < m.nbody; ++b) {
      if (hinges(m, b) == 0 || !on_side(b)) continue;
      if (tree.below(found.foot.left, b) || tree.below(found.foot.right, b)) continue;
      bool leg = false;
      for (const Side foot : kSides)
        leg = leg || (found.foot[foot] > 0 && tree.below(b, found.foot[foot]));
      int joints = 0;
      for (int below = b; below < m.nbody; ++below) {
        if (tree.below(below, b)) joints += hinges(m, below);
      }
      if (leg || joints < 2 || m.body_subtreemass[b] <= heaviest) continue;
      heaviest = m.body_subtreemass[b];
      found.shoulder[side] = b;
    }
    if (found.shoulder[side] < 0) continue;
    // Down to the hand.
    int hand = found.shoulder[side];
    for (int joints = hinges(m, hand); joints < kArmJoints;) {
      std::vector<int> next;
      for (int b = hand + 1; b < m.nbody; ++b) {
        if (hinges(m, b) == 0 || !tree.below(b, hand)) continue;
        bool first = true;  // moving body on its way
        for (int a = m.body_parentid[b]; a > hand; a = m.body_parentid[a])
          first = first && hinges(m, a) == 0;
        if (first) next.push_back(b);
      }
      if (next.size() != 1) break;
      hand = next.front();
      joints += hinges(m, hand);
    }
    found.hand[side] = hand;
    for (int j = 0; j < m.njnt; ++j) {
      if (m.jnt_bodyid[j] > hand && tree.below(m.jnt_bodyid[j], hand))
        found.fingers.push_back(name_of(m, mjOBJ_JOINT, j));
    }
  }
  if (found.shoulder.left < 0 || found.shoulder.right < 0) {
    found.no_arms = "no two arms of at least 2 hinges, one wholly on each side at q = 0";
    return;
  }
  found.trunk = common_ancestor(m, found.shoulder.left, found.shoulder.right);
}

void find_imu(const mjModel& m, Anatomy& found) {
  for (int s = 0; s < m.nsensor && found.imu.empty(); ++s) {
    if (m.sensor_type[s] != mjSENS_GYRO || m.site_bodyid[m.sensor_objid[s]] != 1) continue;
    found.imu = name_of(m, mjOBJ_SITE, m.sensor_objid[s]);
  }
  for (int s = 0; s < m.nsite && found.imu.empty(); ++s) {
    std::string name = name_of(m, mjOBJ_SITE, s);
    std::string lower = name;
    std::ranges::transform(lower, lower.begin(), [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
    if (m.site_bodyid[s] == 1 && lower.find("imu") != std::string::npos) found.imu = name;
  }
}

}  // namespace

Pose local_pose(const mjtNum* pos, const mjtNum* quat) {
  return {Vec3(pos[0], pos[1], pos[2]), Eigen::Quaterniond(quat[0], quat[1], quat[2], quat[3]).toRotationMatrix()};
}

int common_ancestor(const mjModel& m, int a, int b) {
  while (a != b)
    (a > b ? a : b) = m.body_parentid[a > b ? a : b];
  return a;
}

SoleShape sole_shape(const mjModel& m, int body, const Pose& frame) {
  SoleShape sole;
  const Pose inverse = frame.inverse();
  std::vector<Vec3> points;
  for (int g = 0; g < m.ngeom; ++g) {
    if (m.geom_bodyid[g] != body || (m.geom_contype[g] == 0 && m.geom_conaffinity[g] == 0)) continue;
    sole.geoms.push_back(g);
    const Pose geom = inverse * local_pose(m.geom_pos + 3 * g, m.geom_quat + 4 * g);
    for (const Vec3& point : touching_points(m, g, geom.R.transpose().col(2)))
      points.push_back(geom * point);
  }
  if (points.empty()) return sole;
  Vec3 lo = points.front();
  Vec3 hi = lo;
  for (const Vec3& point : points) {
    lo = lo.cwiseMin(point);
    hi = hi.cwiseMax(point);
  }
  sole.height = lo.z();
  const double thickness = kFlat * (hi - lo).head<2>().norm();
  std::vector<Vec2> outline;
  for (const Vec3& point : points) {
    if (point.z() <= lo.z() + thickness) outline.push_back(point.head<2>());
  }
  const ConvexPolygon polygon = ConvexPolygon::hull(outline);
  if (polygon.empty()) return sole;
  Vec2 low = polygon.vertices().front();
  Vec2 high = low;
  for (const Vec2& vertex : polygon.vertices()) {
    low = low.cwiseMin(vertex);
    high = high.cwiseMax(vertex);
  }
  sole.centre = 0.5 * (low + high);
  std::vector<Vec2> centred;
  for (const Vec2& vertex : polygon.vertices())
    centred.push_back(vertex - sole.centre);
  sole.outline = ConvexPolygon::hull(centred);
  return sole;
}

double half_width(const ConvexPolygon& outline) {
  const auto across = [](const Vec2& p) { return p.y(); };
  const auto [lo, hi] = std::ranges::minmax_element(outline.vertices(), {}, across);
  return 0.5 * (hi->y() - lo->y());
}

Anatomy find_parts(const mjModel& model) {
  const Tree tree(model);
  const std::vector<Vec3> at = origins(model);
  Anatomy found;
  find_feet(tree, at, found);
  find_arms(tree, at, found);
  find_imu(model, found);
  return found;
}

}  // namespace baton
