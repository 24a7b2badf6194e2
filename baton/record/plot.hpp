/// Line, scatter and area plots as SVG: stacked panels, axes in SI units, no dependency.
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

/// The Okabe-Ito palette, safe for colour-blind readers.
namespace palette {
inline constexpr const char* kBlack = "#222222";
inline constexpr const char* kBlue = "#0072b2";
inline constexpr const char* kOrange = "#e69f00";
inline constexpr const char* kGreen = "#009e73";
inline constexpr const char* kVermilion = "#d55e00";
inline constexpr const char* kPurple = "#cc79a7";
inline constexpr const char* kSky = "#56b4e9";
inline constexpr const char* kGrey = "#999999";
/// Default colours of series, in order.
inline constexpr std::array<const char*, 6> kSeries{kBlue, kVermilion, kGreen, kPurple, kOrange, kSky};
}  // namespace palette

enum class Stroke { solid, dashed, dotted, points };

/// A line or a set of points. A non-finite point breaks the line.
struct Series {
  std::string name;          ///< in the legend; "": none
  std::vector<Vec2> points;  ///< data units
  Stroke stroke = Stroke::solid;
  std::string colour;  ///< any SVG colour; "": next in the palette
  double width = 1.6;  ///< line width, or point radius [px]
};

/// A filled polygon drawn behind the series: a band, a sole, a region.
struct Area {
  std::string name;           ///< in the legend, once for all areas of this name; "": none
  std::vector<Vec2> outline;  ///< data units
  std::string colour = palette::kGrey;
  double opacity = 0.25;
  bool edge = false;  ///< also draw the outline
};

/// A rectangle given by two corners.
[[nodiscard]] Area band(std::string name, const Vec2& low, const Vec2& high, std::string colour, double opacity = 0.25);

struct Panel {
  std::string title;
  std::string x_label;  ///< with its unit: "t [s]"
  std::string y_label;
  std::vector<Area> areas;
  std::vector<Series> series;
  std::vector<std::string> rows;  ///< names along the y axis, of 0, 1, 2, …, in place of numbers
  bool equal = false;             ///< equal scales on both axes (for loci)
  std::optional<Range> x_range;   ///< default: from the data
  std::optional<Range> y_range;
  double height = 220.0;  ///< height of the axes' box [px]
};

/// Renders the panels as one SVG document; `width` in [px].
[[nodiscard]] std::string plot_svg(std::span<const Panel> panels, double width = 720.0);

/// @throws InputError the file cannot be written
/// @throws std::runtime_error the file was not written completely
void save_plot(const std::filesystem::path& file, std::span<const Panel> panels, double width = 720.0);

}  // namespace baton
