/// Pictures in memory and as PNG files.
#pragma once

#include <cstdint>
#include <filesystem>
#include <span>
#include <vector>

namespace baton {

/// Rows from the top, three bytes (red, green, blue) a pixel.
struct Image {
  int width = 0;   ///< [px]
  int height = 0;  ///< [px]
  std::vector<std::uint8_t> rgb;

  [[nodiscard]] std::uint8_t* row(int y) { return rgb.data() + static_cast<std::size_t>(y) * width * 3; }
  [[nodiscard]] const std::uint8_t* row(int y) const { return rgb.data() + static_cast<std::size_t>(y) * width * 3; }
};

/// @throws InputError the file cannot be written
/// @throws std::runtime_error it could not be written whole
void save_png(const std::filesystem::path& file, const Image& image);

/// @throws InputError no such file, or not a PNG
[[nodiscard]] Image load_png(const std::filesystem::path& file);

/// The images in rows of `columns`, `gap` white pixels between them; a smaller image sits in the middle of
/// its cell. `columns` 0: all side by side.
[[nodiscard]] Image montage(std::span<const Image> images, int columns = 0, int gap = 6);

}  // namespace baton
