/// The world: a model file whose geoms named `ground…` are terrain to stand on, whose other colliding geoms are
/// obstacles, and whose sites mark places. Answers terrain queries, and is combined with a robot for simulation.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "baton/math/polygon.hpp"
#include "baton/model/robot_model.hpp"

namespace baton {

/// A flat face to stand on: a plane, or the upper side of a box.
struct GroundFace {
  ConvexPolygon outline;        ///< projected onto the horizontal plane [m]
  Vec3 point = Vec3::Zero();    ///< a point of the face [m]
  Vec3 normal = Vec3::UnitZ();  ///< upward unit normal

  /// Height of the face's plane at a place [m].
  [[nodiscard]] double height(const Vec2& at) const {
    return point.z() - (normal.x() * (at.x() - point.x()) + normal.y() * (at.y() - point.y())) / normal.z();
  }
};

/// The terrain at a place.
struct GroundPoint {
  double height = 0.0;  ///< [m]
  Vec3 normal = Vec3::UnitZ();
  double edge = 0.0;  ///< distance to the nearest terrain edge [m]
};

/// The terrain under a sole.
struct Foothold {
  bool flat = false;    ///< entirely on known terrain, flat enough, away from edges
  double height = 0.0;  ///< at the centre of the sole [m]
  Vec3 normal = Vec3::UnitZ();
  double deviation = 0.0;  ///< largest height difference from the plane at the centre [m]
};

class World {
 public:
  /// @throws InputError no such file, not a model, no ground, no site `start`, or a ground geom that is neither plane
  /// nor box or has no upper side
  explicit World(const std::filesystem::path& file);

  /// Loads a world by its file, or by its name in `worlds/`.
  [[nodiscard]] static World load(const std::string& name_or_file);

  /// Whether a geom of this name is terrain to stand on.
  [[nodiscard]] static bool is_ground(const std::string& geom) { return geom.starts_with("ground"); }

  [[nodiscard]] const std::string& name() const { return name_; }
  [[nodiscard]] const std::filesystem::path& file() const { return file_; }
  [[nodiscard]] const mjModel& mj() const { return *model_; }
  [[nodiscard]] const std::vector<GroundFace>& faces() const { return faces_; }

  /// Pose of a site.
  /// @throws InputError no such site
  [[nodiscard]] Pose site(const std::string& name) const;

  /// The highest terrain at a place; empty if there is none.
  [[nodiscard]] std::optional<GroundPoint> ground(const Vec2& at) const;

  /// The nearest place whose terrain has this height within `tolerance` [m]. One candidate for each face: the point
  /// nearest to `at`. Empty if none fits.
  [[nodiscard]] std::optional<Vec2> nearest_of_height(const Vec2& at, double height, double tolerance) const;

  /// Highest terrain anywhere under an outline [m]; −∞ if there is none.
  [[nodiscard]] double highest_under(const ConvexPolygon& outline) const;

  /// The terrain under a sole with this outline, widened by `edge` [m].
  [[nodiscard]] Foothold foothold(const ConvexPolygon& outline, const Profile::Ground& flat, double edge) const;

  /// World and robot as one model (MJCF text), for simulation, collision checks and `--save-model`. Sets the physics
  /// options: time step [s], integrator, friction cone, no automatic reset.
  [[nodiscard]] std::string compose(const RobotModel& robot, double timestep, Visuals visuals = Visuals::keep) const;

 private:
  std::filesystem::path file_;
  std::string name_;
  ModelPtr model_;
  std::vector<GroundFace> faces_;
};

}  // namespace baton
