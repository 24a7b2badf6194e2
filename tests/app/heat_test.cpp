/// Hot motors as the program tells of them: report, message for the page, replay.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <regex>

#include "app/view.hpp"
#include "baton/record/report.hpp"
#include "tests/support/robots.hpp"
#include "tests/support/scratch.hpp"

namespace baton {
namespace {

using test::run;

class HotProgramTest : public testing::Test {
 protected:
  /// mighty with motors that get hot forty times as quickly; returns its profile.
  std::string small_motors() const {
    const std::filesystem::path folder = std::filesystem::path(BATON_SOURCE_DIR) / "robots" / "mighty";
    std::ostringstream text;
    text << std::ifstream(folder / "profile.toml").rdbuf();
    std::string profile = text.str();
    profile = std::regex_replace(profile, std::regex("_time = 10,"), "_time = 1,");
    profile = std::regex_replace(profile, std::regex("housing_time = [0-9]+"), "housing_time = 11");
    profile = std::regex_replace(profile, std::regex("mighty\\.xml"), (folder / "mighty.xml").string());
    return scratch_.write("profile.toml", profile);
  }

  test::Scratch scratch_;
};

TEST_F(HotProgramTest, AWalkGoesOnWithPausesAndTheReportSaysSo) {
  const std::string stick = scratch_.write("walk.jsonl", R"({"t": 0.2, "guide": "trunk", "axes": [1, 0, 0, 0, 0, 0]})"
                                                         "\n");
  const std::vector<std::string> drive{"drive",     "--world", "flat",    "--input", "script:" + stick, "--fast",
                                       "--seconds", "40",      "--plant", "model",   "--robot",         small_motors()};
  std::vector<std::string> args = drive;
  args.insert(args.end(), {"--report", scratch_.path("hot.json"), "--record", scratch_.path("hot.mcap")});
  ASSERT_EQ(run(args).code, 0);
  args = drive;
  args.back() = "mighty";
  args.insert(args.end(), {"--report", scratch_.path("cool.json")});
  ASSERT_EQ(run(args).code, 0);

  const nlohmann::json hot = scratch_.json("hot.json");
  const nlohmann::json cool = scratch_.json("cool.json");
  EXPECT_GE(hot["heat"]["hot_times"], 2);
  EXPECT_GT(hot["heat"]["hot_s"], 5.0);
  EXPECT_GE(hot["heat"]["most"], 0.8);
  EXPECT_LE(hot["heat"]["most"], 1.0);
  EXPECT_EQ(cool["heat"]["hot_times"], 0);
  EXPECT_EQ(cool["heat"]["hot_s"], 0.0);
  EXPECT_LT(cool["heat"]["most"], 0.8);
  EXPECT_THAT(cool["heat"]["joint"].get<std::string>(), testing::HasSubstr("knee"));
  EXPECT_EQ(hot["falls"], 0);
  EXPECT_GT(hot["travel_m"], 0.3) << "it goes on";
  EXPECT_LT(hot["travel_m"], cool["travel_m"]);

  const test::Outcome replayed = run({"replay", scratch_.path("hot.mcap"), "--verify"});
  EXPECT_EQ(replayed.code, 0) << replayed.out << replayed.err;
}

TEST_F(HotProgramTest, ARobotWithoutThermalConstantsHasNoHeatToReport) {
  Profile profile = test::robot("mighty").profile();
  profile.heat.clear();
  const RobotModel robot(profile);
  const World world = World::load("flat");
  Simulation simulation(robot, world, Simulation::On::ideal);
  Report report(robot);
  simulation.session().add(report);
  for (int k = 0; k < 10; ++k)
    simulation.session().step({});
  EXPECT_TRUE(report.json("", "", 0, 0.0)["heat"].is_null());
  EXPECT_EQ(app::heat_message(simulation.session()), "");
}

TEST_F(HotProgramTest, ThePageIsToldWhichMotorIsHot) {
  const RobotModel robot = RobotModel::load(small_motors());
  const World world = World::load("flat");
  Simulation simulation(robot, world, Simulation::On::ideal);
  Session& session = simulation.session();
  Command walk;
  walk.axes[0] = 1.0;
  for (int k = 0; k < 6000 && !session.navigator().thermometer().hot(); ++k) {
    EXPECT_EQ(app::heat_message(session), "");
    session.step(walk);
  }
  EXPECT_THAT(app::heat_message(session), testing::MatchesRegex("A motor is hot \\([a-z ]+, 8[0-9] % .*"));
}

}  // namespace
}  // namespace baton
