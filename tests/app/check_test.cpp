#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <fstream>
#include <nlohmann/json.hpp>

#include "app/app.hpp"
#include "baton/model/input_file.hpp"
#include "baton/proving/tryout.hpp"
#include "tests/support/robots.hpp"
#include "tests/support/scratch.hpp"

namespace baton {
namespace {

using nlohmann::json;
using test::Outcome;
using test::Scratch;
using testing::AllOf;
using testing::HasSubstr;

std::string mighty_model() {
  return (share_dir() / "robots" / "mighty" / "mighty.xml").string();
}

TEST(Check, AModelAloneDrivesAndItsWrittenProfileSaysTheSame) {
  const Scratch scratch;
  const Outcome outcome = test::run({"check", mighty_model(), "--write-profile", scratch.path("mine.toml"), "--report",
                                     scratch.path("report.json"), "--pictures", scratch.path("pictures")});
  EXPECT_EQ(outcome.code, app::kDone) << outcome.out << outcome.err;
  EXPECT_THAT(outcome.out, AllOf(HasSubstr("region.foot_x"), HasSubstr("the soles' distance at q = 0"),
                                 HasSubstr("in physics  turn")));
  const json report = json::parse(scratch.read("report.json"));
  EXPECT_EQ(report["verdict"], "drives");
  EXPECT_TRUE(report["problems"].empty());
  EXPECT_EQ(report["values"]["parts.trunk"]["value"], "body");
  EXPECT_EQ(report["trials"].size(), 2 * manoeuvres(test::robot("mighty")).size());
  for (const json& trial : report["trials"]) {
    EXPECT_TRUE(trial["done"]) << trial;
    EXPECT_EQ(trial["fall"], "");
  }
  for (const char* picture : {"front.png", "side.png", "walk.png"})
    EXPECT_GT(std::filesystem::file_size(scratch.path(std::string("pictures/") + picture)), 2000U) << picture;
  // The profile is short, and gives the robot that was checked.
  EXPECT_LT(scratch.read("mine.toml").size(), 2000U);
  const Profile written = Profile::load(scratch.path("mine.toml"));
  const Profile model = Profile::load(mighty_model());
  EXPECT_EQ(written.model, model.model);
  EXPECT_EQ(written.home, model.home);
  EXPECT_EQ(written.stance.com_height, model.stance.com_height);
  EXPECT_EQ(written.parts.hand, model.parts.hand);
  EXPECT_EQ(written.region.foot_lateral.hi, model.region.foot_lateral.hi);
  EXPECT_EQ(written.gains.at("left_knee_flexion").kd, model.gains.at("left_knee_flexion").kd);
}

TEST(Check, SaysWhyAModelCannotBeDriven) {
  const Scratch scratch;
  std::string footless = read_input(mighty_model(), "model");
  for (const char* side : {"left", "right"}) {
    const std::string sole = std::string("name=\"") + side + "_sole_col\" class=\"sole\"";
    const std::size_t at = footless.find(sole);
    ASSERT_NE(at, std::string::npos);
    footless.insert(at + sole.size(), " contype=\"0\" conaffinity=\"0\"");
  }
  struct Case {
    std::string model;
    std::string says;
  };
  const std::vector<Case> cases{
      {(share_dir() / "worlds" / "flat.xml").string(), "hinges"},
      {scratch.write("footless.xml", footless), "right_ankle_abduction"},
      {scratch.write("pole.xml", "<mujoco><worldbody><body><geom size='1'/><joint/></body></worldbody></mujoco>"),
       "'robot', is held"},
  };
  for (const Case& c : cases) {
    const Outcome outcome = test::run({"check", c.model, "--report", scratch.path("report.json")});
    EXPECT_EQ(outcome.code, app::kFailed) << c.model;
    EXPECT_THAT(outcome.out, AllOf(HasSubstr("cannot: "), HasSubstr(c.says), HasSubstr(c.model)));
    const json report = json::parse(scratch.read("report.json"));
    EXPECT_EQ(report["verdict"], "cannot");
    EXPECT_EQ(report["problems"].size(), 1U);
  }
}

TEST(Check, BadInputIsOneClearLineAndExitCodeTwo) {
  const Scratch scratch;
  const std::string good = mighty_model();
  struct Case {
    std::vector<std::string> args;
    std::string says;
  };
  const std::vector<Case> cases{
      {{}, "MODEL"},
      {{scratch.path("none.xml")}, "none.xml"},
      {{scratch.path("none.urdf")}, "none.urdf"},
      {{scratch.write("text.xml", "hello")}, "text.xml"},
      {{"nobody"}, "nobody"},
      {{good, "--profile", scratch.path("none.toml")}, "none.toml"},
      {{good, "--report", good}, "--report"},
      {{good, "--write-profile", "/nowhere/p.toml"}, "/nowhere/p.toml"},
      {{good, "--seed", "x"}, "--seed"},
  };
  for (const Case& c : cases) {
    std::vector<std::string> args{"check"};
    args.insert(args.end(), c.args.begin(), c.args.end());
    const Outcome outcome = test::run(args);
    EXPECT_EQ(outcome.code, app::kBadInput) << c.says << outcome.out;
    EXPECT_THAT(outcome.err, HasSubstr(c.says));
    EXPECT_EQ(std::ranges::count(outcome.err, '\n'), 1) << outcome.err;
  }
}

TEST(Tryout, OfARobotThatCannotLiftSaysSo) {
  Profile profile = test::robot("mighty").profile();
  profile.region.foot_lateral = {0.0830, 0.0845};
  profile.region.foot_x = {-0.001, 0.001};
  profile.region.stride = 0.001;
  const RobotModel robot(profile);
  const World world = World::load("flat");
  Tryout tryout(robot, world, Simulation::On::ideal, 0);
  for (const Manoeuvre& manoeuvre : manoeuvres(robot)) {
    const Attempt attempt = tryout.run(manoeuvre);
    EXPECT_EQ(attempt.fall, "");
    if (manoeuvre.name == "stand" || manoeuvre.name == "squat") {
      EXPECT_TRUE(attempt.done()) << attempt.problem;
    }
    if (manoeuvre.name == "walk" || manoeuvre.name == "step left_foot") {
      EXPECT_FALSE(attempt.done()) << manoeuvre.name;
      EXPECT_NE(attempt.refusal, "");
    }
  }
}

}  // namespace
}  // namespace baton
