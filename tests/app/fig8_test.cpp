#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>

#include "app/app.hpp"
#include "tests/support/temp.hpp"

namespace baton {
namespace {

void expect_knots(const nlohmann::json& knots, const std::vector<double>& y) {
  ASSERT_EQ(knots.size(), y.size());
  for (std::size_t k = 0; k < y.size(); ++k)
    EXPECT_NEAR(knots[k].get<double>(), y[k], 1e-3) << "knot " << k;
}

TEST(ReproduceFig8, ShowsDurationCorrection) {
  const auto out = std::filesystem::path(test::temp_folder()) / "baton_fig8" / "new";
  std::filesystem::remove_all(out);
  ASSERT_EQ(app::run({"reproduce", "fig8", "--out", out.string()}), app::kDone);
  const auto figure = nlohmann::json::parse(std::ifstream(out / "fig8.json"));
  const auto& segments = figure.at("segments");
  ASSERT_EQ(segments.size(), 2u);
  EXPECT_NEAR(segments[0].at("T").get<double>(), 0.5, 1e-9);
  EXPECT_NEAR(segments[1].at("T").get<double>(), 1.0, 1e-9);
  expect_knots(segments[0].at("knots_y"), {-0.0160, 0.0122, 0.0078, -0.0418});
  expect_knots(segments[1].at("knots_y"), {-0.0468, 0.0068, 0.0215, -0.0563});
  for (const auto& segment : segments)
    EXPECT_TRUE(segment.at("verified").get<bool>());
  const auto& uncorrected = figure.at("uncorrected");
  EXPECT_NEAR(uncorrected.at("T").get<double>(), 0.5, 1e-9);
  expect_knots(uncorrected.at("knots_y"), {-0.0384, -0.0007, -0.0018, -0.0617});
  EXPECT_NEAR(uncorrected.at("zmp_outside_m").get<double>(), 0.0078, 1e-3);
  EXPECT_GT(std::filesystem::file_size(out / "fig8.svg"), 3000u);
}

TEST(ReproduceFig8, AFolderThatCannotBeMadeIsBadInput) {
  const auto file = std::filesystem::path(test::temp_folder()) / "baton_fig8_file";
  std::ofstream(file) << "not a folder";
  testing::internal::CaptureStderr();
  EXPECT_EQ(app::run({"reproduce", "fig8", "--out", (file / "below").string()}), app::kBadInput);
  EXPECT_NE(testing::internal::GetCapturedStderr().find((file / "below").string()), std::string::npos);
  testing::internal::CaptureStderr();
  EXPECT_EQ(app::run({"reproduce", "fig8", "--out", file.string()}), app::kBadInput);
  EXPECT_NE(testing::internal::GetCapturedStderr().find(file.string()), std::string::npos);
  testing::internal::CaptureStderr();
  EXPECT_EQ(app::run({"reproduce", "fig9", "--out", "x"}), app::kBadInput);
  (void)testing::internal::GetCapturedStderr();
}

}  // namespace
}  // namespace baton
