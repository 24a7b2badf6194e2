#include "baton/record/picture.hpp"

#include <GL/osmesa.h>
#include <fmt/format.h>

#include <algorithm>
#include <stdexcept>
#include <vector>

namespace baton {
namespace {

constexpr int kLargest = 8192;     ///< [px]
constexpr int kModelGeoms = 4000;  ///< scene capacity for the model's geoms

mjvGeom plain_geom(mjtGeom type, const std::array<double, 3>& size, const Vec3& at, const Colour& colour) {
  mjvGeom geom{};
  const std::array<mjtNum, 9> upright{1, 0, 0, 0, 1, 0, 0, 0, 1};
  mjv_initGeom(&geom, type, size.data(), at.data(), upright.data(), colour.data());
  geom.category = mjCAT_DECOR;  // casts no shadow
  geom.emission = 0.5F;
  geom.specular = 0.1F;
  return geom;
}

}  // namespace

/// OpenGL and MuJoCo resources of one picture.
struct Picture::Canvas {
  Canvas(const mjModel& original, int width, int height) {
    if (width < 1 || height < 1 || width > kLargest || height > kLargest) {
      throw std::invalid_argument(
          fmt::format("picture of {} x {} pixels: each must be 1 to {}", width, height, kLargest));
    }
    install_mujoco_handlers();
    model.reset(mj_copyModel(nullptr, &original));
    model->vis.global.offwidth = width;
    model->vis.global.offheight = height;
    image.width = width;
    image.height = height;
    image.rgb.resize(static_cast<std::size_t>(width) * static_cast<std::size_t>(height) * 3);
    mjv_defaultScene(&scene);
    mjr_defaultContext(&context);
    mjv_defaultOption(&option);
    gl = OSMesaCreateContextExt(OSMESA_RGBA, 24, 8, 0, nullptr);
    if (gl == nullptr) throw std::runtime_error("picture: OSMesa gives no off-screen OpenGL context");
    try {
      make_current();
      mjv_makeScene(model.get(), &scene, kModelGeoms);
      mjr_makeContext(model.get(), &context, mjFONTSCALE_100);
      mjr_setBuffer(mjFB_OFFSCREEN, &context);
      if (context.currentBuffer != mjFB_OFFSCREEN) throw std::runtime_error("picture: OSMesa has no off-screen buffer");
    } catch (...) {
      free();
      throw;
    }
  }
  ~Canvas() { free(); }
  Canvas(const Canvas&) = delete;
  Canvas& operator=(const Canvas&) = delete;

  void make_current() {
    // MuJoCo renders into its own buffer, but the context needs one too.
    if (OSMesaMakeCurrent(gl, window.data(), GL_UNSIGNED_BYTE, kWindow, kWindow) == GL_FALSE) {
      throw std::runtime_error("picture: OSMesa's off-screen OpenGL context cannot be used on this thread");
    }
  }

  void free() {
    if (OSMesaMakeCurrent(gl, window.data(), GL_UNSIGNED_BYTE, kWindow, kWindow) == GL_TRUE) mjr_freeContext(&context);
    mjv_freeScene(&scene);
    OSMesaDestroyContext(gl);
  }

  static constexpr int kWindow = 16;
  std::array<unsigned char, kWindow * kWindow * 4> window{};
  OSMesaContext gl = nullptr;
  ModelPtr model;
  mjvScene scene{};
  mjvOption option{};
  mjrContext context{};
  std::vector<mjvGeom> marks;
  Image image;
};

Picture::Picture(const mjModel& model, int width, int height)
    : canvas_(std::make_unique<Canvas>(model, width, height)) {}
Picture::~Picture() = default;
Picture::Picture(Picture&&) noexcept = default;
Picture& Picture::operator=(Picture&&) noexcept = default;

void Picture::add_point(const Vec3& at, double radius, const Colour& colour) {
  canvas_->marks.push_back(plain_geom(mjGEOM_SPHERE, {radius, radius, radius}, at, colour));
}

void Picture::add_line(const Vec3& from, const Vec3& to, double radius, const Colour& colour) {
  mjvGeom geom = plain_geom(mjGEOM_CAPSULE, {radius, radius, radius}, from, colour);
  mjv_connector(&geom, mjGEOM_CAPSULE, radius, from.data(), to.data());
  canvas_->marks.push_back(geom);
}

void Picture::add_path(std::span<const Vec3> points, double radius, const Colour& colour, bool closed) {
  for (std::size_t i = 0; i + 1 < points.size(); ++i)
    add_line(points[i], points[i + 1], radius, colour);
  if (closed && points.size() > 2) add_line(points.back(), points.front(), radius, colour);
}

void Picture::clear_marks() {
  canvas_->marks.clear();
}

const Image& Picture::render(mjData& data, const std::string& camera) {
  mjvCamera view;
  mjv_defaultCamera(&view);
  view.type = mjCAMERA_FIXED;
  view.fixedcamid = find_id(*canvas_->model, mjOBJ_CAMERA, camera, "picture");
  return draw(data, view);
}

const Image& Picture::render(mjData& data, const FreeCamera& camera) {
  mjvCamera view;
  mjv_defaultCamera(&view);
  view.type = mjCAMERA_FREE;
  std::copy_n(camera.lookat.data(), 3, view.lookat);
  view.distance = camera.distance;
  view.azimuth = camera.azimuth;
  view.elevation = camera.elevation;
  return draw(data, view);
}

const Image& Picture::draw(mjData& data, mjvCamera& camera) {
  Canvas& c = *canvas_;
  c.make_current();
  const int marks = static_cast<int>(c.marks.size());
  if (c.scene.maxgeom < kModelGeoms + marks) mjv_makeScene(c.model.get(), &c.scene, kModelGeoms + marks);
  mjv_updateScene(c.model.get(), &data, &c.option, nullptr, &camera, mjCAT_ALL, &c.scene);
  for (mjvGeom* geom = c.scene.geoms; geom != c.scene.geoms + c.scene.ngeom; ++geom) {
    // A floor casting shadows would show speckles far away, where depth precision is low.
    if (geom->type == mjGEOM_PLANE) geom->category = mjCAT_DECOR;
  }
  for (const mjvGeom& mark : c.marks) {
    if (c.scene.ngeom < c.scene.maxgeom) c.scene.geoms[c.scene.ngeom++] = mark;
  }
  const mjrRect whole{0, 0, c.image.width, c.image.height};
  mjr_setBuffer(mjFB_OFFSCREEN, &c.context);
  mjr_render(whole, &c.scene, &c.context);
  mjr_readPixels(c.image.rgb.data(), nullptr, whole, &c.context);
  const std::ptrdiff_t row = static_cast<std::ptrdiff_t>(c.image.width) * 3;
  for (int y = 0; y < c.image.height / 2; ++y) {  // OpenGL's first row is the bottom one
    std::swap_ranges(c.image.row(y), c.image.row(y) + row, c.image.row(c.image.height - 1 - y));
  }
  return c.image;
}

const Image& Picture::image() const {
  return canvas_->image;
}

void Picture::save(const std::filesystem::path& file) const {
  save_png(file, canvas_->image);
}

}  // namespace baton
