/// Images in memory and as PNG files.
#pragma once

#include <cstdint>
#include <filesystem>
#include <span>
#include <vector>

namespace baton {

/// RGB image: rows from the top, three bytes a pixel.
struct Image {
  int width = 0;   ///< [px]
  int height = 0;  ///< [px]
  std::vector<std::uint8_t> rgb;

  [[nodiscard]] std::uint8_t* row(int y) { return rgb.data() + static_cast<std::size_t>(y) * width * 3; }
  [[nodiscard]] const std::uint8_t* row(int y) const { return rgb.data() + static_cast<std::size_t>(y) * width * 3; }
};

/// @throws InputError the file cannot be written
/// @throws std::runtime_error the file was not written completely
void save_png(const std::filesystem::path& file, const Image& image);

/// @throws InputError the file is missing or not a PNG
[[nodiscard]] Image load_png(const std::filesystem::path& file);

/// Arranges images in rows of `columns` with `gap` white pixels between; smaller images are centred in their cells.
/// `columns` 0: a single row.
[[nodiscard]] Image montage(std::span<const Image> images, int columns = 0, int gap = 6);

}  // namespace baton
