#include "baton/record/plot.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <set>

#include "baton/record/output_file.hpp"

namespace baton {
namespace {

constexpr double kLeft = 70.0, kRight = 18.0, kTitle = 26.0, kLegend = 20.0, kBelow = 46.0, kRowGap = 24.0;  ///< [px]

std::string escaped(const std::string& text) {
  static const std::map<char, const char*> entities{
      {'&', "&amp;"}, {'<', "&lt;"}, {'>', "&gt;"}, {'"', "&quot;"}, {'\'', "&apos;"}};
  std::string out;
  for (const char c : text) {
    const auto entity = entities.find(c);
    if (entity != entities.end()) {
      out += entity->second;
    } else if (static_cast<unsigned char>(c) >= 0x20) {  // XML allows few other control characters
      out += c;
    }
  }
  return out;
}

/// Approximate width of a UTF-8 text [px].
double width_of(const std::string& text) {
  double width = 0.0;
  for (const char c : text) {
    if ((c & 0xc0) != 0x80) width += c >= 'A' && c <= 'Z' ? 9.2 : 6.6;
  }
  return width;
}

/// One axis: maps data units to pixels, with round ticks.
struct Axis {
  double lo = 0.0, hi = 1.0;      ///< data units
  double begin = 0.0, end = 1.0;  ///< pixels of lo and hi

  [[nodiscard]] double at(double value) const { return begin + (value - lo) / (hi - lo) * (end - begin); }

  [[nodiscard]] double tick_step(double apart) const {
    const double wanted = (hi - lo) * apart / std::abs(end - begin);
    const double decade = std::pow(10.0, std::floor(std::log10(wanted)));
    for (const double factor : {1.0, 2.0, 5.0}) {
      if (factor * decade >= wanted * (1.0 - 1e-9)) return factor * decade;
    }
    return 10.0 * decade;
  }
};

Axis axis_over(const std::vector<double>& values, const std::optional<Range>& given) {
  Axis axis;
  axis.lo = std::numeric_limits<double>::infinity();
  axis.hi = -axis.lo;
  for (const double value : values) {
    if (!std::isfinite(value)) continue;
    axis.lo = std::min(axis.lo, value);
    axis.hi = std::max(axis.hi, value);
  }
  if (!(axis.lo <= axis.hi)) axis.lo = axis.hi = 0.0;
  const double room = axis.hi > axis.lo ? 0.04 * (axis.hi - axis.lo) : std::max(0.5, 0.1 * std::abs(axis.hi));
  axis.lo -= room;
  axis.hi += room;
  if (given && given->lo < given->hi) {
    axis.lo = given->lo;
    axis.hi = given->hi;
  }
  return axis;
}

std::string number(double value, double step) {
  if (std::abs(value) < 0.5 * step) return "0";
  const double size = std::abs(value);
  const int decimals = std::max(0, static_cast<int>(-std::floor(std::log10(step) + 1e-9)));
  const bool plain = decimals <= 4 && size < 1e6;
  return (value < 0 ? "\u2212" : "") + (plain ? fmt::format("{:.{}f}", size, decimals) : fmt::format("{:.4g}", size));
}

/// The lines and the points of one panel.
class Drawing {
 public:
  Drawing(const Panel& panel, int index, double top, double width) : panel_(panel), index_(index) {
    std::vector<double> xs, ys;
    const auto take = [&](const std::vector<Vec2>& points) {
      for (const Vec2& point : points) {
        if (!point.allFinite()) continue;
        xs.push_back(point.x());
        ys.push_back(point.y());
      }
    };
    for (const Area& area : panel.areas)
      take(area.outline);
    for (const Series& series : panel.series)
      take(series.points);
    x_ = axis_over(xs, panel.x_range);
    y_ = axis_over(ys, panel.y_range);
    x_.begin = kLeft;
    for (const std::string& row : panel.rows)
      x_.begin = std::max(x_.begin, width_of(row) + kRowGap);
    x_.end = width - kRight;
    width_ = width;
    top_ = top;
    legend();
    y_.end = legend_y_ + kLegend;
    y_.begin = y_.end + panel.height;
    if (panel.equal) {
      const double unit = std::min((x_.end - x_.begin) / (x_.hi - x_.lo), panel.height / (y_.hi - y_.lo));
      widen(x_, (x_.end - x_.begin) / unit);
      widen(y_, panel.height / unit);
    }
  }

  [[nodiscard]] double bottom() const { return y_.begin + kBelow; }

  [[nodiscard]] std::string svg() {
    const double w = x_.end - x_.begin;
    std::string out = fmt::format(
        "<g>\n<clipPath id=\"box{}\"><rect x=\"{:.2f}\" y=\"{:.2f}\" width=\"{:.2f}\" "
        "height=\"{:.2f}\"/></clipPath>\n",
        index_, x_.begin, y_.end, w, panel_.height);
    out += fmt::format("<text class=\"title\" x=\"{:.2f}\" y=\"{:.2f}\">{}</text>\n", x_.begin, top_ + 17,
                       escaped(panel_.title));
    out += legend_;
    std::string labels;
    const double sx = x_.tick_step(80);
    for (double tick = std::ceil(x_.lo / sx - 1e-9) * sx; tick <= x_.hi + 1e-9 * sx; tick += sx) {
      out += fmt::format("<path class=\"grid\" d=\"M{0:.2f} {1:.2f}V{2:.2f}\"/>", x_.at(tick), y_.end, y_.begin);
      labels += fmt::format("<text x=\"{:.2f}\" y=\"{:.2f}\" text-anchor=\"middle\">{}</text>\n", x_.at(tick),
                            y_.begin + 16, number(tick, sx));
    }
    const auto mark_y = [&](double tick, const std::string& label) {
      out += fmt::format("<path class=\"grid\" d=\"M{0:.2f} {1:.2f}H{2:.2f}\"/>", x_.begin, y_.at(tick), x_.end);
      labels += fmt::format("<text x=\"{:.2f}\" y=\"{:.2f}\" text-anchor=\"end\">{}</text>\n", x_.begin - 7,
                            y_.at(tick) + 4, label);
    };
    const double sy = y_.tick_step(34);
    for (std::size_t i = 0; i < panel_.rows.size(); ++i)
      mark_y(static_cast<double>(i), escaped(panel_.rows[i]));
    if (panel_.rows.empty()) {
      for (double tick = std::ceil(y_.lo / sy - 1e-9) * sy; tick <= y_.hi + 1e-9 * sy; tick += sy)
        mark_y(tick, number(tick, sy));
    }
    out += fmt::format("\n<g clip-path=\"url(#box{})\">\n", index_);
    for (const Area& area : panel_.areas) {
      out +=
          fmt::format("<path fill=\"{0}\" fill-opacity=\"{1:.3f}\" stroke=\"{2}\" d=\"{3}Z\"/>\n", escaped(area.colour),
                      area.opacity, area.edge ? escaped(area.colour) : "none", path(area.outline));
    }
    for (std::size_t i = 0; i < panel_.series.size(); ++i) {
      const Series& series = panel_.series[i];
      if (series.stroke != Stroke::points) {
        out += fmt::format("<path class=\"line\" d=\"{}\" {}/>\n", path(series.points), stroke(series, i));
        continue;
      }
      for (const Vec2& point : series.points) {
        if (point.allFinite()) out += dot({x_.at(point.x()), y_.at(point.y())}, series, i);
      }
    }
    out += fmt::format("</g>\n<rect class=\"frame\" x=\"{:.2f}\" y=\"{:.2f}\" width=\"{:.2f}\" height=\"{:.2f}\"/>\n",
                       x_.begin, y_.end, w, panel_.height);
    out += labels;
    out += fmt::format("<text x=\"{:.2f}\" y=\"{:.2f}\" text-anchor=\"middle\">{}</text>\n", 0.5 * (x_.begin + x_.end),
                       y_.begin + 35, escaped(panel_.x_label));
    out += fmt::format("<text transform=\"translate(18 {:.2f}) rotate(-90)\" text-anchor=\"middle\">{}</text>\n</g>\n",
                       0.5 * (y_.begin + y_.end), escaped(panel_.y_label));
    return out;
  }

 private:
  static void widen(Axis& axis, double span) {
    const double middle = 0.5 * (axis.lo + axis.hi);
    axis.lo = middle - 0.5 * span;
    axis.hi = middle + 0.5 * span;
  }

  static std::string colour(const Series& series, std::size_t i) {
    return series.colour.empty() ? palette::kSeries[i % palette::kSeries.size()] : escaped(series.colour);
  }

  static std::string stroke(const Series& series, std::size_t i) {
    const char* dashes =
        series.stroke == Stroke::dashed ? "7 4" : (series.stroke == Stroke::dotted ? "1.5 3.5" : "none");
    return fmt::format("stroke=\"{}\" stroke-width=\"{:.2f}\" stroke-dasharray=\"{}\"", colour(series, i), series.width,
                       dashes);
  }

  static std::string dot(const Vec2& at, const Series& series, std::size_t i) {
    return fmt::format("<circle cx=\"{:.2f}\" cy=\"{:.2f}\" r=\"{:.2f}\" fill=\"{}\"/>\n", at.x(), at.y(), series.width,
                       colour(series, i));
  }

  [[nodiscard]] std::string path(const std::vector<Vec2>& points) const {
    std::string d;
    bool begins = true;
    for (const Vec2& point : points) {
      if (point.allFinite())
        d += fmt::format("{}{:.2f} {:.2f}", begins ? 'M' : 'L', x_.at(point.x()), y_.at(point.y()));
      begins = !point.allFinite();
    }
    return d.empty() ? "M0 0" : d;
  }

  /// The legend above the box, wrapped into more rows if needed.
  void legend() {
    double x = x_.begin;
    legend_y_ = top_ + kTitle;
    const auto entry = [&](const std::string& name, const auto& sample) {
      const double wide = 34.0 + width_of(name) + 16.0;
      if (x > x_.begin && x + wide > width_ - kRight) {
        x = x_.begin;
        legend_y_ += kLegend;
      }
      legend_ += sample(x, legend_y_ + 6);
      legend_ += fmt::format("<text x=\"{:.2f}\" y=\"{:.2f}\">{}</text>\n", x + 34, legend_y_ + 10, escaped(name));
      x += wide;
    };
    for (std::size_t i = 0; i < panel_.series.size(); ++i) {
      const Series& series = panel_.series[i];
      if (series.name.empty()) continue;
      entry(series.name, [&](double sx, double sy) {
        if (series.stroke == Stroke::points) return dot({sx + 14, sy}, series, i);
        return fmt::format("<path class=\"line\" d=\"M{:.2f} {:.2f}h28\" {}/>\n", sx, sy, stroke(series, i));
      });
    }
    std::set<std::string> named;
    for (const Area& area : panel_.areas) {
      if (area.name.empty() || !named.insert(area.name).second) continue;
      entry(area.name, [&](double sx, double sy) {
        return fmt::format(
            "<rect x=\"{:.2f}\" y=\"{:.2f}\" width=\"28\" height=\"11\" fill=\"{}\" "
            "fill-opacity=\"{:.3f}\"/>\n",
            sx, sy - 6, escaped(area.colour), area.opacity);
      });
    }
  }

  const Panel& panel_;
  int index_;
  double top_ = 0.0;
  double width_ = 0.0;
  double legend_y_ = 0.0;  ///< y of the legend's last row
  std::string legend_;
  Axis x_, y_;
};

}  // namespace

Area band(std::string name, const Vec2& low, const Vec2& high, std::string colour, double opacity) {
  return {std::move(name), {low, {high.x(), low.y()}, high, {low.x(), high.y()}}, std::move(colour), opacity, false};
}

std::string plot_svg(std::span<const Panel> panels, double width) {
  std::string body;
  double y = 6.0;
  for (std::size_t i = 0; i < panels.size(); ++i) {
    Drawing drawing(panels[i], static_cast<int>(i), y, width);
    body += drawing.svg();
    y = drawing.bottom() + 6.0;
  }
  return fmt::format(
      "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n"
      "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"{0:.0f}\" height=\"{1:.0f}\" viewBox=\"0 0 {0:.0f} "
      "{1:.0f}\">\n"
      "<style>text{{font:12px Helvetica,Arial,'DejaVu Sans',sans-serif;fill:#222}} "
      ".title{{font-weight:bold;font-size:13px}}\n"
      ".grid{{stroke:#e4e4e4;stroke-width:1}} .frame{{fill:none;stroke:#444;stroke-width:1}}\n"
      ".line{{fill:none;stroke-linejoin:round;stroke-linecap:butt}}</style>\n"
      "<rect width=\"100%\" height=\"100%\" fill=\"#ffffff\"/>\n{2}</svg>\n",
      width, y, body);
}

void save_plot(const std::filesystem::path& file, std::span<const Panel> panels, double width) {
  write_whole(file, "plot", plot_svg(panels, width));
}

}  // namespace baton
