#include "baton/record/plot.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cctype>
#include <cmath>
#include <limits>
#include <regex>

#include "baton/model/error.hpp"

namespace baton {
namespace {

using testing::HasSubstr;
using testing::Not;

/// Whether every tag is closed in order, every attribute quoted and no bare & or < left (all that XML asks of
/// a document without a DTD). Says what is wrong; "" if nothing is.
std::string fault(const std::string& xml) {
  static const std::regex entity("&(amp|lt|gt|quot|apos);");
  static const std::regex tag(R"(^<(/?)([A-Za-z][\w:]*)((\s+[\w:-]+="[^"<]*")*)\s*(/?)>)");
  if (std::regex_replace(xml, entity, "").find('&') != std::string::npos) return "bare &";
  std::vector<std::string> open;
  std::size_t at = xml.find("?>") + 2;
  int roots = 0;
  while ((at = xml.find('<', at)) != std::string::npos) {
    const std::size_t end = xml.find('>', at);
    if (end == std::string::npos) return "tag without end";
    const std::string text = xml.substr(at, end - at + 1);
    std::smatch match;
    if (!std::regex_match(text, match, tag)) return "no tag: " + text;
    if (match[1].length() > 0) {
      if (open.empty() || open.back() != match[2].str()) return "closes what is not open: " + text;
      open.pop_back();
    } else {
      if (open.empty()) ++roots;
      if (match[5].length() == 0) open.push_back(match[2].str());
    }
    at = end;
  }
  if (!open.empty()) return "not closed: " + open.back();
  return roots == 1 ? "" : "not one root";
}

std::size_t count(const std::string& text, const std::string& part) {
  std::size_t n = 0;
  for (std::size_t at = text.find(part); at != std::string::npos; at = text.find(part, at + 1))
    ++n;
  return n;
}

Panel full_panel() {
  Panel panel;
  panel.title = R"(a < b & "c" > 'd')";
  panel.x_label = "t [s] <x>";
  panel.y_label = "y & z [m]";
  panel.areas = {band("sole & \"edge\"", {0, -1}, {1, 1}, palette::kSky),
                 band("sole & \"edge\"", {1, -1}, {2, 1}, palette::kSky)};
  panel.series = {{"<line>", {{0, 0}, {1, 1}, {2, -1}}, Stroke::dashed, "", 1.6},
                  {"dots", {{0.5, 0.5}, {1.5, 0.2}}, Stroke::points, "\"/><script>", 3.0}};
  return panel;
}

TEST(Plot, IsWellFormedWhateverTheTextSays) {
  const std::vector<Panel> panels{full_panel(), Panel{}, full_panel()};
  const std::string svg = plot_svg(panels);
  EXPECT_EQ(fault(svg), "");
  EXPECT_THAT(svg, Not(HasSubstr("<script")));
  EXPECT_THAT(svg, HasSubstr("a &lt; b &amp; &quot;c&quot; &gt; &apos;d&apos;"));
  EXPECT_THAT(svg, HasSubstr("y &amp; z [m]"));
  EXPECT_EQ(fault("<a><b></a></b>"), "closes what is not open: </a>");  // the checker itself
}

TEST(Plot, NamesEverySeriesAndAreaOnce) {
  const std::vector<Panel> panels{full_panel()};
  const std::string svg = plot_svg(panels);
  EXPECT_EQ(count(svg, "&lt;line&gt;"), 1u);
  EXPECT_EQ(count(svg, "sole &amp; &quot;edge&quot;"), 1u);
  EXPECT_EQ(count(svg, "<circle"), 3u);  // two points and the legend's
}

TEST(Plot, SurvivesWhatIsNotFinite) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  const double inf = std::numeric_limits<double>::infinity();
  Panel panel;
  panel.series = {{"a", {{0, 0}, {1, nan}, {2, 2}, {3, 3}, {inf, 1}}, Stroke::solid, "", 1.0},
                  {"b", {}, Stroke::points, "", 1.0}};
  panel.x_range = Range{1.0, 1.0};  // no range at all
  const std::string svg = plot_svg({&panel, 1});
  EXPECT_EQ(fault(svg), "");
  EXPECT_THAT(svg, Not(HasSubstr("nan")));
  EXPECT_THAT(svg, Not(HasSubstr("inf")));
  const std::regex broken(R"(d="M[\d.]+ [\d.]+M[\d.]+ [\d.]+L[\d.]+ [\d.]+")");
  EXPECT_TRUE(std::regex_search(svg, broken));
}

TEST(Plot, EqualAspectKeepsASquareSquare) {
  Panel panel;
  panel.equal = true;
  panel.areas = {band("", {-0.1, 2.0}, {0.1, 2.2}, palette::kGrey)};
  const std::string svg = plot_svg({&panel, 1});
  const std::regex corners(R"re(d="M([\d.]+) ([\d.]+)L([\d.]+) ([\d.]+)L([\d.]+) ([\d.]+)L)re");
  std::smatch m;
  ASSERT_TRUE(std::regex_search(svg, m, corners));
  EXPECT_NEAR(std::stod(m[3]) - std::stod(m[1]), std::stod(m[4]) - std::stod(m[6]), 0.05);
}

TEST(Plot, SaysWhichFileCannotBeWritten) {
  const std::vector<Panel> panels{full_panel()};
  try {
    save_plot("/nowhere/at/all.svg", panels);
    FAIL();
  } catch (const InputError& error) {
    EXPECT_THAT(error.what(), HasSubstr("/nowhere/at/all.svg"));
  }
}

}  // namespace
}  // namespace baton
