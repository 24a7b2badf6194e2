/// The world: a model file in which geoms named `ground…` may be stood on, all other colliding geoms are
/// obstacles, and sites mark places; ground queries; and its composition with a robot for simulation.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "baton/math/polygon.hpp"
#include "baton/model/robot_model.hpp"

namespace baton {

/// A flat face that may be stood on: the upper side of a plane or of a box.
struct GroundFace {
  ConvexPolygon outline;        ///< seen from above [m]
  Vec3 point = Vec3::Zero();    ///< on the face
  Vec3 normal = Vec3::UnitZ();  ///< unit, upward

  [[nodiscard]] double height(const Vec2& at) const {
    return point.z() - (normal.x() * (at.x() - point.x()) + normal.y() * (at.y() - point.y())) / normal.z();
  }
};

/// The ground at one place.
struct GroundPoint {
  double height = 0.0;  ///< [m]
  Vec3 normal = Vec3::UnitZ();
  double edge = 0.0;  ///< distance to the nearest edge of the face [m]
};

/// The ground under a sole.
struct Foothold {
  bool flat = false;    ///< wholly on known ground, flat enough, away from edges
  double height = 0.0;  ///< at the sole's centre [m]
  Vec3 normal = Vec3::UnitZ();
  double deviation = 0.0;  ///< largest distance of a point under the sole from the plane at its centre [m]
};

class World {
 public:
  /// @throws InputError no such file, not a model, no site `start`, or a ground geom that is neither plane nor box
  explicit World(const std::filesystem::path& file);

  /// Loads a world by file, or by its name in `worlds/`.
  [[nodiscard]] static World load(const std::string& name_or_file);

  /// Whether a geom of this name may be stood on.
  [[nodiscard]] static bool is_ground(const std::string& geom) { return geom.starts_with("ground"); }

  [[nodiscard]] const std::string& name() const { return name_; }
  [[nodiscard]] const std::filesystem::path& file() const { return file_; }
  [[nodiscard]] const mjModel& mj() const { return *model_; }
  [[nodiscard]] const std::vector<GroundFace>& faces() const { return faces_; }

  /// Pose of a site.
  /// @throws InputError no such site
  [[nodiscard]] Pose site(const std::string& name) const;

  /// The highest ground at a place; nothing where there is none.
  [[nodiscard]] std::optional<GroundPoint> ground(const Vec2& at) const;

  /// Of each face's nearest place, where that is the ground and so high, within `tolerance` [m], the nearest; nothing
  /// where none is.
  [[nodiscard]] std::optional<Vec2> nearest_of_height(const Vec2& at, double height, double tolerance) const;

  /// Highest ground anywhere under an outline [m]; −∞ where there is none.
  [[nodiscard]] double highest_under(const ConvexPolygon& outline) const;

  /// Whether a sole with this outline, widened by `edge` [m], rests on ground flat enough.
  [[nodiscard]] Foothold foothold(const ConvexPolygon& outline, const Profile::Ground& flat, double edge) const;

  /// World and robot in one model, as MJCF text: what simulation steps, collision checks use and
  /// `--save-model` writes. Physics options (time step, integrator, cone, no automatic reset) are set here.
  [[nodiscard]] std::string compose(const RobotModel& robot, double timestep) const;

 private:
  std::filesystem::path file_;
  std::string name_;
  ModelPtr model_;
  std::vector<GroundFace> faces_;
};

}  // namespace baton
