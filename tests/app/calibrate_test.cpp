/// baton calibrate, and driving with what it found.
#include <gmock/gmock.h>

#include <algorithm>
#include <cmath>

#include "tests/support/scratch.hpp"

namespace baton {
namespace {

using test::Outcome;
using test::run;
using test::Scratch;
using testing::AllOf;
using testing::HasSubstr;

const std::string kWalkAndTurn = R"({"t": 0.3, "guide": "trunk", "axes": [1, 0, 0, 0, 0, 0.2]}
{"t": 3.0, "guide": "trunk", "axes": [0, 0, 0, 0, 0, 0]}
)";

TEST(Calibrate, FindsMostOfTheErrorsOfSeveralRobots) {
  const Scratch scratch;
  double before = 0.0, after = 0.0;
  for (const char* seed : {"1", "2", "3", "4"}) {
    const Outcome outcome =
        run({"calibrate", "--out", scratch.path("c.toml"), "--seed", seed, "--report", scratch.path("r.json")});
    ASSERT_EQ(outcome.code, app::kDone) << outcome.out << outcome.err;
    EXPECT_THAT(outcome.out,
                AllOf(HasSubstr("left_hip_flexion"), HasSubstr("poorly observable"), HasSubstr("for evaluation only")));
    const nlohmann::json report = scratch.json("r.json");
    EXPECT_LT(report["duration_s"].get<double>(), 75.0);
    EXPECT_GE(report["rests"].get<int>(), 18);
    EXPECT_LT(report["misfit"].get<double>(), 1.0);
    const auto share = [&](const char* key) {
      const nlohmann::json& rms = report["truth"][key];
      return rms["after"].get<double>() / rms["before"].get<double>();
    };
    // Of 30 others, the worst: 0.84, 0.37, 0.33, 0.16.
    EXPECT_LT(share("leg_zero_deg"), 0.9) << seed;
    EXPECT_LT(share("imu_mount_deg"), 0.45) << seed;
    EXPECT_LT(share("force_gain"), 0.5) << seed;
    EXPECT_LT(share("force_zero_n"), 0.25) << seed;
    before += std::pow(report["truth"]["leg_zero_deg"]["before"].get<double>(), 2);
    after += std::pow(report["truth"]["leg_zero_deg"]["after"].get<double>(), 2);
  }
  EXPECT_LT(std::sqrt(after / before), 0.65) << "of all 30: 0.49";
}

TEST(Calibrate, TheSameRobotGetsTheSameFile) {
  const Scratch scratch;
  for (const char* file : {"a.toml", "b.toml"})
    ASSERT_EQ(run({"calibrate", "--out", scratch.path(file), "--seed", "5"}).code, app::kDone);
  EXPECT_EQ(scratch.read("a.toml"), scratch.read("b.toml"));
  EXPECT_THAT(scratch.read("a.toml"), AllOf(HasSubstr("robot = \"mighty\""), HasSubstr("[encoder_zero_deg]")));
}

TEST(Calibrate, ACalibratedRobotDrivesAndItsRecordingReplays) {
  const Scratch scratch;
  const std::string file = scratch.path("c.toml");
  ASSERT_EQ(run({"calibrate", "--out", file, "--seed", "6"}).code, app::kDone);
  const std::string script = "script:" + scratch.write("walk.jsonl", kWalkAndTurn);
  for (const bool calibrated : {false, true}) {
    std::vector<std::string> args{"drive",     "--world",
                                  "flat",      "--input",
                                  script,      "--fast",
                                  "--seconds", "4",
                                  "--seed",    "6",
                                  "--record",  scratch.path("run.mcap"),
                                  "--trace",   scratch.path(calibrated ? "yes.csv" : "no.csv")};
    if (calibrated) args.insert(args.end(), {"--calibration", file});
    const Outcome outcome = run(args);
    ASSERT_EQ(outcome.code, app::kDone) << outcome.out << outcome.err;
    const Outcome again = run({"replay", scratch.path("run.mcap"), "--verify"});
    EXPECT_EQ(again.code, app::kDone) << again.out << again.err;
    EXPECT_THAT(again.out, HasSubstr("identical bit for bit"));
  }
  EXPECT_NE(scratch.read("yes.csv"), scratch.read("no.csv"));
  const Outcome soak =
      run({"soak", "--scenario", "nominal", "--seeds", "1", "--seed", "6", "--episode", "3", "--calibration", file});
  EXPECT_EQ(soak.code, app::kDone) << soak.out << soak.err;
}

TEST(Calibrate, WritesNothingIfTheReadingsContradictEachOther) {
  const Scratch scratch;  // five times the play that the profile states
  const Outcome outcome =
      run({"calibrate", "--out", scratch.path("c.toml"), "--scenario", "backlash", "--times", "2.5", "--seed", "1"});
  EXPECT_EQ(outcome.code, app::kFailed);
  EXPECT_THAT(outcome.out, AllOf(HasSubstr("contradict"), HasSubstr("no calibration")));
  EXPECT_FALSE(std::filesystem::exists(scratch.path("c.toml")));
}

TEST(Calibrate, SaysWhatIsWrongInOneLine) {
  const Scratch scratch;
  const std::string bad = scratch.write("bad.toml", "robot = \"somebody\"\n");
  const std::string script = "script:" + scratch.write("walk.jsonl", kWalkAndTurn);
  const std::vector<std::string> drive{"drive", "--world", "flat", "--input", script, "--fast", "--seconds", "1"};
  const auto driven = [&drive](std::vector<std::string> more) {
    more.insert(more.begin(), drive.begin(), drive.end());
    return more;
  };
  for (const auto& [args, says] : std::vector<std::pair<std::vector<std::string>, std::string>>{
           {{"calibrate"}, "calibrate: --out is missing"},
           {{"calibrate", "--out", "/nowhere/c.toml"}, "--out /nowhere/c.toml"},
           {{"calibrate", "--out", scratch.path("x"), "--report", scratch.path("x")}, "the same file"},
           {{"calibrate", "--out", scratch.path("x"), "--robot", "nobody"}, "nobody"},
           {driven({"--calibration", bad}), "robot = 'somebody': must be \"mighty\", the robot that is driven"},
           {driven({"--calibration", scratch.path("none.toml")}), "none.toml: no such file"},
           {driven({"--calibration", bad, "--on", "ideal"}), "must be --on sim"},
           {driven({"--calibration", bad, "--report", bad}), "the robot that is driven"},
           {{"soak", "--scenario", "nominal", "--seeds", "1", "--calibration", bad}, "the robot that is driven"}}) {
    const Outcome outcome = run(args);
    EXPECT_EQ(outcome.code, app::kBadInput) << says;
    EXPECT_THAT(outcome.err, HasSubstr(says));
    EXPECT_EQ(std::count(outcome.err.begin(), outcome.err.end(), '\n'), 1) << outcome.err;
  }
  EXPECT_FALSE(std::filesystem::exists(scratch.path("x")));
}

}  // namespace
}  // namespace baton
