/// Pictures of a robot in its world, drawn off screen in software (MuJoCo's renderer on OSMesa; no display,
/// no GPU).
#pragma once

#include <array>
#include <filesystem>
#include <memory>
#include <span>
#include <string>

#include "baton/math/pose.hpp"
#include "baton/model/mujoco.hpp"
#include "baton/record/image.hpp"

namespace baton {

/// A camera that looks at a point.
struct FreeCamera {
  Vec3 lookat = Vec3::Zero();  ///< [m]
  double distance = 1.0;       ///< [m]
  double azimuth = 140.0;      ///< of the line of sight about z, 0 along x [deg]
  double elevation = -16.0;    ///< of the line of sight, negative looks down [deg]
};

using Colour = std::array<float, 4>;  ///< red, green, blue, opacity, 0…1

/// Lives on the thread that made it.
class Picture {
 public:
  /// @param model copied; world and robot composed. Its own off-screen size does not matter
  /// @param width, height [px]
  /// @throws std::invalid_argument a size that is not in 1…8192
  /// @throws std::runtime_error no off-screen OpenGL here
  Picture(const mjModel& model, int width, int height);
  ~Picture();
  Picture(Picture&&) noexcept;
  Picture& operator=(Picture&&) noexcept;

  /// Marks that the next pictures show beside the model, [m] in the world.
  void add_point(const Vec3& at, double radius, const Colour& colour);
  void add_line(const Vec3& from, const Vec3& to, double radius, const Colour& colour);
  /// The line through all points; back to the first if `closed` (the outline of a sole).
  void add_path(std::span<const Vec3> points, double radius, const Colour& colour, bool closed = false);
  void clear_marks();

  /// Draws the state of `data` (positions as of the last mj_forward or mj_step).
  /// @throws InputError the model has no camera of this name
  const Image& render(mjData& data, const std::string& camera);
  const Image& render(mjData& data, const FreeCamera& camera);

  /// The last picture.
  [[nodiscard]] const Image& image() const;
  /// @throws InputError the file cannot be written
  void save(const std::filesystem::path& file) const;

 private:
  struct Canvas;
  const Image& draw(mjData& data, mjvCamera& camera);
  std::unique_ptr<Canvas> canvas_;
};

}  // namespace baton
