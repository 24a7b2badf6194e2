// `baton soak`: its report, its table of scenarios, and what went wrong as a script.
#include <fmt/format.h>
#include <gmock/gmock.h>

#include "baton/model/input_file.hpp"
#include "baton/proving/episode.hpp"
#include "tests/proving/trial.hpp"
#include "tests/support/robots.hpp"
#include "tests/support/scratch.hpp"

namespace baton::app {
namespace {

using test::trial;

using test::Outcome;
using test::run;
using test::Scratch;
using testing::HasSubstr;

constexpr double kPeriod = 0.005;

/// A report without what depends on the clock on the wall.
nlohmann::json timeless(nlohmann::json report) {
  EXPECT_TRUE(report.contains("wall"));
  report.erase("wall");
  return report;
}

/// A trace that ended at the episode's last tick, in the same configuration.
void expect_same_end(const std::vector<std::vector<std::string>>& rows, const EpisodeResult& episode) {
  ASSERT_EQ(static_cast<long>(rows.size()) - 1, episode.ticks);
  const auto first = std::find(rows.front().begin(), rows.front().end(), "qpos_0") - rows.front().begin();
  for (Eigen::Index i = 0; i < episode.q.size(); ++i)
    EXPECT_NEAR(std::stod(rows.back()[static_cast<std::size_t>(first + i)]), episode.q[i], 1e-9) << i;
}

TEST(Soak, ConnectionsWithFaultsAreReportedAndDoNotDependOnJobs) {
  const Scratch scratch;
  const auto soak = [&](const char* jobs, const char* file) {
    return run({"soak", "--link", "--seeds", "3", "--episode", "2", "--jobs", jobs, "--report", scratch.path(file)});
  };
  const Outcome one = soak("1", "one.json");
  EXPECT_EQ(one.code, kDone);
  EXPECT_THAT(one.out, HasSubstr("3 connections with faults: 0 fell, 0 did not come to rest"));
  EXPECT_EQ(soak("2", "two.json").out, one.out);
  const nlohmann::json report = scratch.json("one.json");
  EXPECT_EQ(report, scratch.json("two.json"));
  EXPECT_EQ(report["tried"], 3);
  EXPECT_EQ(report["failures"].size(), 0U);
  EXPECT_THAT(run({"soak", "--link"}).err, HasSubstr("needs --seeds"));
  EXPECT_THAT(run({"soak", "--link", "--seeds", "1", "--scenario", "push"}).err, HasSubstr("leave out --scenario"));
}

TEST(Soak, TheResultDoesNotDependOnJobsOrPauses) {
  const Scratch scratch;
  const auto soak = [&](const std::string& file, const std::string& segments, std::vector<std::string> more = {}) {
    std::vector<std::string> args{"soak", "--on",      "ideal", "--segments", segments,          "--seed",
                                  "5",    "--episode", "6",     "--report",   scratch.path(file)};
    args.insert(args.end(), more.begin(), more.end());
    return run(args);
  };
  const Outcome one = soak("one.json", "60");
  ASSERT_EQ(one.code, kDone) << one.out << one.err;
  EXPECT_THAT(one.out, HasSubstr("0 violations in "));
  ASSERT_EQ(soak("two.json", "60", {"--jobs", "2"}).code, kDone);
  const nlohmann::json all = timeless(scratch.json("one.json"));
  EXPECT_EQ(all, timeless(scratch.json("two.json")));
  EXPECT_GE(all["segments"].get<int>(), 60);
  EXPECT_GE(all["deflected_share"].get<double>(), 0.7);
  EXPECT_EQ(all["failures"], 0);
  const nlohmann::json& back = all["retrace"];
  EXPECT_GE(back["tried"].get<int>(), 5);
  EXPECT_EQ(back["arrived"], back["tried"]);
  EXPECT_EQ(back["refused"], 0);
  EXPECT_LT(back["worst_m"].get<double>(), 1e-6);
  EXPECT_LT(back["worst_rad"].get<double>(), 1e-6);
  EXPECT_THAT(one.out, HasSubstr(fmt::format("{0} of {0} motions retraced", back["tried"].get<int>())));
  EXPECT_NEAR(all["failure_rate_95"].get<double>(), failure_rate_95(0, all["segments"].get<long>()), 1e-15);

  ASSERT_EQ(soak("parts.json", "5").code, kDone);
  EXPECT_LT(scratch.json("parts.json")["episodes"], all["episodes"]);
  ASSERT_EQ(soak("parts.json", "60", {"--resume"}).code, kDone);
  EXPECT_EQ(all, timeless(scratch.json("parts.json")));

  const Outcome other = soak("parts.json", "60", {"--resume", "--world", "room"});
  EXPECT_EQ(other.code, kBadInput);
  EXPECT_THAT(other.err, HasSubstr("world is \"flat\" in the file and \"room\" here"));
}

TEST(Soak, AFallIsReportedWithAScriptThatReplaysIt) {
  // A gale that the planner does not know of.
  const Scratch scratch;
  std::ifstream in(share_dir() / "worlds" / "flat.xml");
  std::string world{std::istreambuf_iterator<char>(in), {}};
  const auto at = world.find("<option ");
  ASSERT_NE(at, std::string::npos);
  world.insert(at + 8, "density=\"100\" wind=\"8 0 0\" ");
  const std::string file = scratch.write("gale.xml", world);
  const Outcome outcome = run({"soak", "--on", "sim", "--plant", "model", "--world", file, "--segments", "1", "--seed",
                               "5", "--episode", "30", "--report", scratch.path("r.json")});
  EXPECT_EQ(outcome.code, kFailed);
  const nlohmann::json report = scratch.json("r.json");
  ASSERT_EQ(report["first_failures"].size(), 1U);
  EXPECT_EQ(report["violations"]["fall"], 1);
  const std::string script = scratch.path("r.json.5-0.jsonl");
  const double t = report["simulated_s"];
  EXPECT_THAT(
      outcome.out,
      HasSubstr(
          "baton drive --robot mighty --world " + file +
          " --on sim --state sensors --plant model --duration paper --gait flow --on-limit shrink --input script:" +
          script));
  EXPECT_THAT(outcome.out, HasSubstr(fmt::format("--seconds {:.3f}", t)));

  EXPECT_EQ(run({"drive", "--world", file, "--on", "sim", "--plant", "model", "--input", "script:" + script, "--fast",
                 "--seconds", fmt::format("{:.3f}", t), "--trace", scratch.path("t.csv")})
                .code,
            kFallen);
  const World gale(file);
  const std::atomic<bool> stop{false};
  const EpisodeResult again = Episodes(test::robot("mighty"), gale, trial(Simulation::On::sim, 5, 30.0)).run(0, stop);
  expect_same_end(scratch.table("t.csv"), again);
}

TEST(Soak, ReplaysToTheSameTickOnIdeal) {
  const Scratch scratch;
  const World world = World::load("flat");
  const std::atomic<bool> stop{false};
  const Episodes episodes(test::robot("mighty"), world, trial(Simulation::On::ideal, 11, 20.0));
  const EpisodeResult result = episodes.run(4, stop);
  EXPECT_GE(result.tally.segments, 3);
  EXPECT_GE(result.tally.retrace.tried, 1);
  EXPECT_LT(result.tally.ticks, result.ticks) << "the way back is not driven by the stick";
  ASSERT_EQ(run({"drive", "--world", "flat", "--on", "ideal", "--input",
                 "script:" + scratch.write("s.jsonl", episodes.script(4, result)), "--fast", "--seconds",
                 fmt::format("{:.3f}", static_cast<double>(result.ticks) * kPeriod), "--trace", scratch.path("t.csv")})
                .code,
            kDone);
  expect_same_end(scratch.table("t.csv"), result);
}

TEST(Soak, AWayBackThatIsRefusedIsAFailure) {
  // The ground ends under the heels: the robot goes forward from there, and no foot may be put down there again.
  const Scratch scratch;
  const std::string file = scratch.write("edge.xml", R"(<mujoco model="edge"><worldbody><site name="start"/>
<geom name="ground" type="box" pos="4.98 0 -1" size="5 5 1"/></worldbody></mujoco>)");
  const Outcome outcome = run({"soak", "--world", file, "--segments", "8", "--seed", "1", "--episode", "3", "--report",
                               scratch.path("r.json")});
  EXPECT_EQ(outcome.code, kFailed);
  const nlohmann::json report = scratch.json("r.json");
  EXPECT_GE(report["retrace"]["refused"].get<int>(), 1);
  EXPECT_EQ(report["violations"]["retrace"], report["retrace"]["refused"]);
  for (const auto& failure : report["first_failures"]) {
    if (failure["kind"] == "retrace") {
      EXPECT_EQ(failure["where"], "ground");
    }
  }
}

TEST(Soak, BadInputIsOneClearLine) {
  const Scratch scratch;
  const std::string report = scratch.path("r.json");
  struct Case {
    std::vector<std::string> args;
    std::string says;
  };
  const std::vector<Case> cases{
      {{"--report", report}, "--segments or --hours"},
      {{"--report", report, "--segments", "5", "--hours", "1"}, "--segments or --hours"},
      {{"--report", report, "--segments", "-5"}, "--segments"},
      {{"--report", report, "--segments", "5", "--jobs", "0"}, "--jobs"},
      {{"--segments", "5"}, "--report"},
      {{"--segments", "5", "--report", "/nowhere/r.json"}, "/nowhere/r.json"},
      {{"--segments", "5", "--report", report, "--world", "nowhere"}, "nowhere"},
      {{"--segments", "5", "--resume", "--report", scratch.write("not.json", "{]")}, "not the report of a soak"},
  };
  for (const Case& c : cases) {
    std::vector<std::string> args{"soak"};
    args.insert(args.end(), c.args.begin(), c.args.end());
    const Outcome outcome = run(args);
    EXPECT_EQ(outcome.code, kBadInput) << c.says;
    EXPECT_THAT(outcome.err, HasSubstr(c.says));
    EXPECT_EQ(std::count(outcome.err.begin(), outcome.err.end(), '\n'), 1) << outcome.err;
  }
}

TEST(Soak, PrintsATableOfAScenarioAndAFallThatCanBeSeenAgain) {
  const Scratch scratch;
  // A push that fells everyone.
  const Outcome outcome = run({"soak", "--scenario", "push_stand", "--times", "8", "--seeds", "3", "--seed", "5",
                               "--report", scratch.path("r.json")});
  EXPECT_EQ(outcome.code, kFallen);
  EXPECT_THAT(outcome.out, HasSubstr("push_stand"));
  EXPECT_THAT(outcome.out, HasSubstr("0/3"));
  const nlohmann::json row = scratch.json("r.json")["scenarios"]["push_stand"];
  EXPECT_EQ(row["tried"], 3);
  EXPECT_EQ(row["survived"], 0);
  EXPECT_EQ(row["fell_with_seeds"], nlohmann::json({5, 6, 7}));
  EXPECT_NEAR(row["fall_rate_95"].get<double>(), 1.0, 1e-12);
  // The line printed for the second of them, as it is.
  const std::string script = scratch.path("r.json.push_stand-5-1.jsonl");
  const std::string line = "--scenario push_stand --times 8 --seed 6";
  EXPECT_THAT(outcome.out, HasSubstr(line));
  EXPECT_EQ(run({"drive", "--world", "flat", "--on", "sim", "--scenario", "push_stand", "--times", "8", "--seed", "6",
                 "--input", "script:" + script, "--fast", "--seconds", "6"})
                .code,
            kFallen);
  EXPECT_EQ(
      run({"drive", "--world", "flat", "--on", "sim", "--input", "script:" + script, "--fast", "--seconds", "6"}).code,
      kDone);
}

TEST(Soak, AScenarioIsRefusedWithWhatWouldBeRight) {
  const Outcome unknown = run({"soak", "--scenario", "earthquake", "--seeds", "2"});
  EXPECT_EQ(unknown.code, kBadInput);
  EXPECT_THAT(unknown.err, HasSubstr("nominal, friction"));
  EXPECT_EQ(run({"soak", "--scenario", "mass"}).code, kBadInput);
  EXPECT_EQ(run({"soak", "--scenario", "mass", "--seeds", "2", "--hours", "1"}).code, kBadInput);
  EXPECT_EQ(run({"soak", "--segments", "5"}).code, kBadInput) << "without a report";
  const Outcome tiles = run({"drive", "--scenario", "tiles", "--world", "room", "--fast", "--seconds", "1"});
  EXPECT_EQ(tiles.code, kBadInput);
  EXPECT_THAT(tiles.err, HasSubstr("one plane"));
  const Outcome ideal = run({"drive", "--on", "ideal", "--scenario", "mass", "--fast", "--seconds", "1"});
  EXPECT_EQ(ideal.code, kBadInput);
  EXPECT_THAT(ideal.err, HasSubstr("--on sim"));
  EXPECT_EQ(run({"drive", "--times", "2", "--fast", "--seconds", "1"}).code, kBadInput) << "of what?";
  EXPECT_EQ(run({"drive", "--state", "guess", "--fast", "--seconds", "1"}).code, kBadInput);
}

TEST(Soak, FindsHowLargeADisturbanceMayBe) {
  const Scratch scratch;
  const Outcome outcome = run({"soak", "--scenario", "push_stand", "--break", "--seeds", "2", "--episode", "4",
                               "--report", scratch.path("r.json"), "--plot", scratch.path("b.svg")});
  EXPECT_EQ(outcome.code, kDone) << outcome.err;
  const nlohmann::json row = scratch.json("r.json")["scenarios"]["push_stand"];
  EXPECT_EQ(row["survived"], 2);
  const double holds = row["breaking"]["holds"].get<double>();
  const double breaks = row["breaking"]["breaks"].get<double>();
  EXPECT_GT(holds, 1.5);  // 0.9 N s
  EXPECT_LT(breaks, 8.0);
  EXPECT_LT(holds, breaks);
  EXPECT_LT(breaks, 1.09 * holds);
  EXPECT_THAT(outcome.out, HasSubstr(fmt::format("x {:.3g}", holds)));
  // As it says: there none falls, and there one does.
  const auto fell = [&](double times) {
    const Outcome again = run({"soak", "--scenario", "push_stand", "--times", fmt::format("{:.17g}", times), "--seeds",
                               "2", "--episode", "4"});
    return again.code == kFallen;
  };
  EXPECT_FALSE(fell(holds));
  EXPECT_TRUE(fell(breaks));
  EXPECT_THAT(read_input(scratch.path("b.svg"), "--plot"), HasSubstr("push_stand"));
  // What the report has already is not done again.
  nlohmann::json report = scratch.json("r.json");
  report["scenarios"]["push_stand"]["breaking"]["holds"] = 1.25;
  scratch.write("r.json", report.dump());
  const std::vector<std::string> resumed{"soak",     "--scenario", "push_stand",          "--break",
                                         "--seeds",  "2",          "--episode",           "4",
                                         "--resume", "--report",   scratch.path("r.json")};
  EXPECT_THAT(run(resumed).out, HasSubstr("x 1.25"));
  EXPECT_EQ(scratch.json("r.json"), report);
  std::vector<std::string> other = resumed;
  other[7] = "5";
  EXPECT_THAT(run(other).err, HasSubstr("episode_s is 4.0 in the file and 5.0 here"));
  report["scenarios"]["push_stand"].erase("breaking");
  scratch.write("r.json", report.dump());
  EXPECT_THAT(run(resumed).err, HasSubstr("scenario push_stand: breaking is missing"));
}

TEST(Soak, TheRealPlantIsDrawnBySeedAndComesUnderAnyScenario) {
  const Scratch scratch;
  const auto run_of = [&](const std::vector<std::string>& physics, const std::string& report) {
    std::vector<std::string> args{"soak", "--seeds", "1", "--episode", "2", "--report", scratch.path(report)};
    args.insert(args.end(), physics.begin(), physics.end());
    EXPECT_EQ(run(args).code, kDone);
    const nlohmann::json json = scratch.json(report);
    return json["scenarios"].begin().value()["tracking"]["com_rms_m"].get<double>();
  };
  const double exact = run_of({"--scenario", "nominal", "--plant", "model"}, "a.json");
  const double real = run_of({"--scenario", "nominal", "--plant", "real"}, "b.json");
  EXPECT_GT(real, 2.0 * exact);
  EXPECT_NE(run_of({"--scenario", "nominal", "--plant", "real", "--seed", "1"}, "c.json"), real);
  EXPECT_EQ(run_of({"--scenario", "nominal"}, "d.json"), real) << "the default";
  EXPECT_NE(run_of({"--scenario", "friction", "--plant", "real"}, "e.json"), real);
  EXPECT_EQ(scratch.json("b.json")["plant"], "real");
  run_of({"--scenario", "mount", "--plant", "model"}, "f.json");
  const nlohmann::json mount = scratch.json("f.json")["scenarios"]["mount"]["tracking"];
  EXPECT_LT(mount["com_estimated_rms_m"], 0.5 * mount["com_rms_m"].get<double>())
      << "an IMU askew, which it cannot know";
  EXPECT_GT(mount["com_estimated_rms_m"], 0.0);
  EXPECT_EQ(scratch.json("a.json")["plant"], "model");
}

TEST(Soak, WhatCannotBeScaledOrHasNoPhysicsIsRefused) {
  const std::vector<std::pair<std::vector<std::string>, std::string>> cases{
      {{"soak", "--scenario", "nominal", "--times", "2", "--seeds", "1"}, "nominal has no size"},
      {{"drive", "--scenario", "stiff", "--times", "2", "--fast", "--seconds", "1"}, "stiff has no size"},
      {{"soak", "--scenario", "nominal", "--break"}, "nominal has no size"},
      {{"soak", "--scenario", "mass", "--break", "--times", "2"}, "--break looks for --times itself"},
      {{"soak", "--scenario", "mass", "--seeds", "1", "--plot", "b.svg"}, "--plot goes with --break"},
      {{"soak", "--segments", "5", "--report", "r.json", "--break"}, "go with --scenario"},
      {{"soak", "--scenario", "mass", "--seeds", "1", "--resume"}, "--resume of scenarios goes with --break"},
      {{"soak", "--segments", "5", "--report", "r.json", "--plant", "real"}, "--plant real with --on ideal"},
      {{"drive", "--on", "ideal", "--plant", "real", "--fast", "--seconds", "1"}, "--plant real with --on ideal"},
      {{"drive", "--plant", "imaginary", "--fast", "--seconds", "1"}, "--plant"},
  };
  for (const auto& [args, says] : cases) {
    const Outcome outcome = run(args);
    EXPECT_EQ(outcome.code, kBadInput) << says;
    EXPECT_THAT(outcome.err, HasSubstr(says));
  }
}

}  // namespace
}  // namespace baton::app
