#include "baton/model/world.hpp"

#include <fmt/format.h>

#include <array>
#include <cmath>
#include <limits>

#include "baton/model/error.hpp"

namespace baton {
namespace {

constexpr double kFarAway = 1e3;  ///< half size of an infinite plane [m]
constexpr double kWithin = 5e-7;  ///< from the outline of a face, where a higher one may begin, into it [m]

/// Points on and inside the outline, at most `spacing` [m] apart.
std::vector<Vec2> cover(const ConvexPolygon& outline, double spacing) {
  std::vector<Vec2> points;
  const Vec2 centre = outline.centre();
  const auto& vertices = outline.vertices();
  for (std::size_t i = 0; i < vertices.size(); ++i) {
    const Vec2& a = vertices[i];
    const Vec2 edge = vertices[(i + 1) % vertices.size()] - a;
    const int along = std::max(1, static_cast<int>(std::ceil(edge.norm() / spacing)));
    for (int k = 0; k < along; ++k) {
      const Vec2 rim = a + edge * (static_cast<double>(k) / along);
      const int inward = std::max(1, static_cast<int>(std::ceil((centre - rim).norm() / spacing)));
      for (int j = 0; j < inward; ++j)
        points.push_back(rim + (centre - rim) * (static_cast<double>(j) / inward));
    }
  }
  points.push_back(centre);
  return points;
}

}  // namespace

World World::load(const std::string& name_or_file) {
  std::filesystem::path file = name_or_file;
  if (file.extension() != ".xml") file = share_dir() / "worlds" / (name_or_file + ".xml");
  std::error_code ignored;
  if (!std::filesystem::exists(file, ignored)) {
    throw InputError(fmt::format("world '{}': no file {}: give the name of a file in worlds/ or a .xml file",
                                 name_or_file, file.string()));
  }
  return World(file);
}

World::World(const std::filesystem::path& file) : file_(file), name_(file.stem().string()) {
  const std::string owner = fmt::format("world {}", file.string());
  const SpecPtr spec = parse_model(file);
  model_ = compile_model(*spec, owner);
  const mjModel& m = *model_;
  const DataPtr data(mj_makeData(&m));
  mj_kinematics(&m, data.get());
  for (int g = 0; g < m.ngeom; ++g) {
    const std::string name = name_of(m, mjOBJ_GEOM, g);
    if (!is_ground(name)) continue;
    const Pose pose{Eigen::Map<const Vec3>(data->geom_xpos + 3 * g),
                    Eigen::Map<const Eigen::Matrix<double, 3, 3, Eigen::RowMajor>>(data->geom_xmat + 9 * g)};
    Vec3 half = Eigen::Map<const Vec3>(m.geom_size + 3 * g);
    if (m.geom_type[g] == mjGEOM_PLANE) {
      for (const int axis : {0, 1})
        half[axis] = half[axis] > 0.0 ? half[axis] : kFarAway;
      half.z() = 0.0;
    } else if (m.geom_type[g] != mjGEOM_BOX) {
      throw InputError(fmt::format("{}: geom '{}' may be stood on but is neither a plane nor a box", owner, name));
    }
    // The side of the box that faces up.
    int up = 2;
    for (int axis = 0; axis < 3; ++axis) {
      if (m.geom_type[g] == mjGEOM_BOX && std::abs(pose.R(2, axis)) > std::abs(pose.R(2, up)) + 1e-9) up = axis;
    }
    const int u = (up + 1) % 3;
    const int w = (up + 2) % 3;
    GroundFace face;
    const bool turned = m.geom_type[g] == mjGEOM_BOX && pose.R(2, up) < 0.0;
    face.normal = pose.R.col(up) * (turned ? -1.0 : 1.0);
    face.point = pose.p + face.normal * half[up];
    std::vector<Vec2> corners;
    for (const double a : {-1.0, 1.0}) {
      for (const double b : {-1.0, 1.0}) {
        corners.push_back((face.point + a * half[u] * pose.R.col(u) + b * half[w] * pose.R.col(w)).head<2>());
      }
    }
    face.outline = ConvexPolygon::hull(corners);
    if (face.normal.z() < 0.1 || face.outline.empty()) {
      throw InputError(fmt::format("{}: geom '{}' may be stood on but has no upper side", owner, name));
    }
    faces_.push_back(std::move(face));
  }
  if (faces_.empty()) throw InputError(fmt::format("{}: no geom whose name begins with 'ground'", owner));
  static_cast<void>(site("start"));
}

Pose World::site(const std::string& name) const {
  const int id = find_id(*model_, mjOBJ_SITE, name, fmt::format("world {}", file_.string()));
  const mjtNum* q = model_->site_quat + 4 * id;
  return {Eigen::Map<const Vec3>(model_->site_pos + 3 * id),
          Eigen::Quaterniond(q[0], q[1], q[2], q[3]).toRotationMatrix()};
}

std::optional<GroundPoint> World::ground(const Vec2& at) const {
  std::optional<GroundPoint> highest;
  for (const GroundFace& face : faces_) {
    const double edge = face.outline.margin(at);
    if (edge < 0.0) continue;
    const double height = face.height(at);
    if (!highest || height > highest->height) highest = GroundPoint{height, face.normal, edge};
  }
  if (!highest) return highest;
  // The foot of a higher face is an edge, too.
  for (const GroundFace& face : faces_) {
    if (face.normal.z() == 1.0 && face.point.z() <= highest->height) continue;  // level, and no higher
    const double outside = face.outline.margin(at);
    if (outside >= 0.0) continue;
    const Vec2 nearest = face.outline.nearest(at);
    if (face.height(nearest) > highest->height + 1e-6) {
      highest->edge = std::min(highest->edge, (nearest - at).norm());
    }
  }
  return highest;
}

std::optional<Vec2> World::nearest_of_height(const Vec2& at, double height, double tolerance) const {
  std::optional<Vec2> nearest;
  for (const GroundFace& face : faces_) {
    const Vec2 place = face.outline.nearest(at);
    const double there = face.height(place);
    if (std::abs(there - height) > tolerance) continue;
    const std::optional<GroundPoint> highest = ground(face.outline.inset(kWithin).nearest(place));
    if (highest && highest->height > there + tolerance) continue;  // hidden below a higher face
    if (!nearest || (place - at).squaredNorm() < (*nearest - at).squaredNorm()) nearest = place;
  }
  return nearest;
}

double World::highest_under(const ConvexPolygon& outline) const {
  double highest = -std::numeric_limits<double>::infinity();
  for (const GroundFace& face : faces_) {
    if (separation(outline, face.outline) > 0.0) continue;
    const ConvexPolygon shared = outline.clipped(face.outline);
    for (const Vec2& vertex : shared.vertices())
      highest = std::max(highest, face.height(vertex));
  }
  return highest;
}

Foothold World::foothold(const ConvexPolygon& outline, const Profile::Ground& flat, double edge) const {
  const ConvexPolygon wide = outline.inset(-edge);
  const std::optional<GroundPoint> centre = ground(wide.centre());
  Foothold foothold;
  if (!centre) return foothold;
  foothold.height = centre->height;
  foothold.normal = centre->normal;
  GroundFace plane;
  plane.point << wide.centre(), centre->height;
  plane.normal = centre->normal;
  for (const Vec2& point : cover(wide, 0.02)) {
    const std::optional<GroundPoint> here = ground(point);
    if (!here) {
      foothold.deviation = std::numeric_limits<double>::infinity();
      return foothold;
    }
    foothold.deviation = std::max(foothold.deviation, std::abs(here->height - plane.height(point)));
  }
  for (const GroundFace& face : faces_) {  // vertices that the sampling missed
    if (separation(wide, face.outline) > 0.0) continue;
    const ConvexPolygon shared = wide.clipped(face.outline);
    for (const Vec2& vertex : shared.vertices()) {
      foothold.deviation = std::max(foothold.deviation, face.height(vertex) - plane.height(vertex));
    }
  }
  foothold.flat = foothold.deviation <= flat.flatness && std::acos(std::min(1.0, centre->normal.z())) <= flat.tilt;
  return foothold;
}

std::string World::compose(const RobotModel& robot, double timestep, Visuals visuals) const {
  const auto lock = lock_compiler();
  const SpecPtr world = parse_model(file_);
  const SpecPtr body = robot.spec(visuals);
  // The robot's global defaults become a class, which needs a name.
  mjs_setName(mjs_getSpecDefault(body.get())->element, "robot");
  body->option = world->option;  // differing options would be a conflict; those that count are set below
  mjsElement* frame = mjs_addFrame(mjs_findBody(world.get(), "world"), nullptr)->element;
  mjsBody* root = mjs_findBody(body.get(), name_of(robot.mj(), mjOBJ_BODY, 1).c_str());
  if (mjs_attach(frame, root->element, "", "") == nullptr) {
    throw InputError(
        fmt::format("world {} and robot {}: {}", file_.string(), robot.profile().name, mjs_getError(world.get())));
  }
  mjOption& option = world->option;
  option.timestep = timestep;
  option.integrator = mjINT_IMPLICITFAST;
  option.cone = mjCONE_ELLIPTIC;
  option.impratio = 10.0;
  option.disableflags |= mjDSBL_AUTORESET;
  for (int axis = 0; axis < 3; ++axis)
    option.gravity[axis] = axis == 2 ? -kGravity : 0.0;
  const std::string what = fmt::format("world {} with robot {}", name_, robot.profile().name);
  static_cast<void>(compile_model(*world, what));
  return text_of(*world, what);
}

}  // namespace baton
