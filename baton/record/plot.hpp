/// Line, scatter and area plots as SVG: panels one below the other, axes in SI units, no dependency.
#pragma once

#include <array>
#include <filesystem>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "baton/math/pose.hpp"
#include "baton/model/profile.hpp"

namespace baton {

/// Okabe and Ito's palette, told apart with any colour vision.
namespace palette {
inline constexpr const char* kBlack = "#222222";
inline constexpr const char* kBlue = "#0072b2";
inline constexpr const char* kOrange = "#e69f00";
inline constexpr const char* kGreen = "#009e73";
inline constexpr const char* kVermilion = "#d55e00";
inline constexpr const char* kPurple = "#cc79a7";
inline constexpr const char* kSky = "#56b4e9";
inline constexpr const char* kGrey = "#999999";
/// The order in which series are coloured that name no colour.
inline constexpr std::array<const char*, 6> kSeries{kBlue, kVermilion, kGreen, kPurple, kOrange, kSky};
}  // namespace palette

enum class Stroke { solid, dashed, dotted, points };

/// A line, or points. A point that is not finite breaks the line.
struct Series {
  std::string name;          ///< in the legend; "": not there
  std::vector<Vec2> points;  ///< data units
  Stroke stroke = Stroke::solid;
  std::string colour;  ///< any SVG colour; "": the next of the palette
  double width = 1.6;  ///< of the line, or radius of the points [px]
};

/// A filled polygon behind the series: a band, a sole, a region.
struct Area {
  std::string name;           ///< in the legend once, however many areas bear it; "": not there
  std::vector<Vec2> outline;  ///< data units
  std::string colour = palette::kGrey;
  double opacity = 0.25;
  bool edge = false;  ///< draw the outline too
};

/// The rectangle between two corners.
[[nodiscard]] Area band(std::string name, const Vec2& low, const Vec2& high, std::string colour, double opacity = 0.25);

struct Panel {
  std::string title;
  std::string x_label;  ///< with its unit: "t [s]"
  std::string y_label;
  std::vector<Area> areas;
  std::vector<Series> series;
  bool equal = false;            ///< one metre is as long upward as sideways (for loci)
  std::optional<Range> x_range;  ///< nothing: from the data
  std::optional<Range> y_range;
  double height = 220.0;  ///< of the axes' box [px]
};

/// The panels as one SVG document of this width [px].
[[nodiscard]] std::string plot_svg(std::span<const Panel> panels, double width = 720.0);

/// @throws InputError the file cannot be written
/// @throws std::runtime_error it could not be written whole
void save_plot(const std::filesystem::path& file, std::span<const Panel> panels, double width = 720.0);

}  // namespace baton
