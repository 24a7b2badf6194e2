#include "baton/record/image.hpp"

#include <fmt/format.h>
#include <png.h>

#include <algorithm>

#include "baton/model/error.hpp"
#include "baton/record/output_file.hpp"

namespace baton {

void save_png(const std::filesystem::path& file, const Image& image) {
  png_image png{};
  png.version = PNG_IMAGE_VERSION;
  png.width = static_cast<png_uint_32>(image.width);
  png.height = static_cast<png_uint_32>(image.height);
  png.format = PNG_FORMAT_RGB;
  png_alloc_size_t size = PNG_IMAGE_PNG_SIZE_MAX(png);
  std::string bytes(size, '\0');
  if (png_image_write_to_memory(&png, bytes.data(), &size, 0, image.rgb.data(), 0, nullptr) == 0) {
    throw std::runtime_error(fmt::format("picture {}: cannot be made: {}", file.string(), png.message));
  }
  write_whole(file, "picture", std::string_view(bytes).substr(0, size));
}

Image load_png(const std::filesystem::path& file) {
  png_image png{};
  png.version = PNG_IMAGE_VERSION;
  Image image;
  if (png_image_begin_read_from_file(&png, file.c_str()) != 0) {
    png.format = PNG_FORMAT_RGB;
    image.width = static_cast<int>(png.width);
    image.height = static_cast<int>(png.height);
    image.rgb.resize(PNG_IMAGE_SIZE(png));
    const png_color white{255, 255, 255};
    if (png_image_finish_read(&png, &white, image.rgb.data(), 0, nullptr) != 0) return image;
  }
  const std::string why = png.message;
  png_image_free(&png);
  throw InputError(fmt::format("picture {}: cannot be read: {}", file.string(), why));
}

Image montage(std::span<const Image> images, int columns, int gap) {
  if (images.empty()) return {};
  const int count = static_cast<int>(images.size());
  if (columns <= 0) columns = count;
  columns = std::min(columns, count);
  const int rows = (count + columns - 1) / columns;
  int wide = 0;
  int high = 0;
  for (const Image& image : images) {
    wide = std::max(wide, image.width);
    high = std::max(high, image.height);
  }
  Image all;
  all.width = columns * wide + (columns - 1) * gap;
  all.height = rows * high + (rows - 1) * gap;
  all.rgb.assign(static_cast<std::size_t>(all.width) * static_cast<std::size_t>(all.height) * 3, 255);
  for (int i = 0; i < count; ++i) {
    const Image& image = images[static_cast<std::size_t>(i)];
    const int left = (i % columns) * (wide + gap) + (wide - image.width) / 2;
    const int top = (i / columns) * (high + gap) + (high - image.height) / 2;
    for (int y = 0; y < image.height; ++y) {
      std::copy_n(image.row(y), static_cast<std::size_t>(image.width) * 3, all.row(top + y) + left * 3);
    }
  }
  return all;
}

}  // namespace baton
