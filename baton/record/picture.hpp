/// Off-screen software rendering of a robot in its world (MuJoCo's renderer on OSMesa; no display, no GPU).
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

/// A camera aimed at a point.
struct FreeCamera {
  Vec3 lookat = Vec3::Zero();  ///< [m]
  double distance = 1.0;       ///< [m]
  double azimuth = 140.0;      ///< of the line of sight about z, 0 along x [deg]
  double elevation = -16.0;    ///< of the line of sight, negative looks down [deg]
};

using Colour = std::array<float, 4>;  ///< red, green, blue, opacity, 0…1

/// Must be used on the thread that created it.
class Picture {
 public:
  /// @param model robot and world composed; copied. Its off-screen size is ignored
  /// @param width, height [px]
  /// @throws std::invalid_argument a size is outside 1…8192
  /// @throws std::runtime_error off-screen OpenGL is not available
  Picture(const mjModel& model, int width, int height);
  ~Picture();
  Picture(Picture&&) noexcept;
  Picture& operator=(Picture&&) noexcept;

  /// Adds markers to the following pictures, [m] in the world frame.
  void add_point(const Vec3& at, double radius, const Colour& colour);
  void add_line(const Vec3& from, const Vec3& to, double radius, const Colour& colour);
  /// A polyline; closed back to the first point if `closed` (the outline of a sole).
  void add_path(std::span<const Vec3> points, double radius, const Colour& colour, bool closed = false);
  void clear_marks();

  /// Renders the state of `data` (positions of the last mj_forward or mj_step).
  /// @throws InputError the model has no such camera
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
