#include <gmock/gmock.h>

#include <algorithm>
#include <cmath>
#include <csignal>
#include <map>

#include "app/app.hpp"
#include "baton/model/world.hpp"
#include "baton/record/image.hpp"
#include "tests/input/virtual_joystick.hpp"
#include "tests/support/robots.hpp"
#include "tests/support/scratch.hpp"

namespace baton {
namespace {

using test::Outcome;
using test::run;
using test::Scratch;
using testing::HasSubstr;

const std::string kWalkAhead = R"({"t": 0.2, "guide": "trunk", "axes": [1, 0, 0, 0, 0, 0], "lift": [0, 0]}
{"t": 3.0, "guide": "left_hand", "axes": [0.5, 0, 0.5, 0, 0, 0]}
{"t": 4.5, "guide": "left_foot", "axes": [0, -1, 0, 0, 0, 0]}
{"t": 5.0, "guide": "trunk", "axes": [0, 0, 0, 0, 0, 0]}
)";

/// Columns of a trace by name.
class Table {
 public:
  explicit Table(std::vector<std::vector<std::string>> rows) : rows_(std::move(rows)) {
    for (std::size_t i = 0; i < rows_.front().size(); ++i)
      columns_[rows_.front()[i]] = i;
  }
  [[nodiscard]] std::size_t rows() const { return rows_.size() - 1; }
  [[nodiscard]] bool has(const std::string& column) const { return columns_.contains(column); }
  [[nodiscard]] const std::string& text(std::size_t row, const std::string& column) const {
    return rows_[row + 1].at(columns_.at(column));
  }
  [[nodiscard]] double number(std::size_t row, const std::string& column) const { return std::stod(text(row, column)); }

 private:
  std::vector<std::vector<std::string>> rows_;
  std::map<std::string, std::size_t> columns_;
};

TEST(Drive, AHeldStickLeadsStraightAheadThoughSolesSlide) {
  const std::string held = R"({"t": 3, "guide": "trunk", "axes": [1, 0, 0, 0, 0, 0]})";
  for (const std::string scenario : {"nominal", "friction"}) {
    const Scratch scratch;
    const Outcome outcome = run({"drive", "--world", "flat", "--on", "sim", "--plant", "model", "--scenario", scenario,
                                 "--input", "script:" + scratch.write("held.jsonl", held), "--fast", "--seconds", "28",
                                 "--report", scratch.path("r.json")});
    ASSERT_EQ(outcome.code, app::kDone) << outcome.err;
    const nlohmann::json trunk = scratch.json("r.json")["final"]["trunk"];
    EXPECT_GT(trunk["p"][0].get<double>(), 1.8);
    // Without making up for it, 0.02 m and 0.01 rad, and as much again with every 20 s.
    EXPECT_LT(std::abs(trunk["p"][1].get<double>()), 0.02) << scenario;  // it sways by half of that
    EXPECT_LT(std::abs(trunk["rpy"][2].get<double>()), 3e-3) << scenario;
  }
}

TEST(Drive, AScriptInPhysicsWritesTraceReportAndModel) {
  const Scratch scratch;
  const Outcome outcome =
      run({"drive", "--world", "flat", "--input", "script:" + scratch.write("walk.jsonl", kWalkAhead), "--plant",
           "model", "--fast", "--seconds", "6", "--seed", "7", "--trace", scratch.path("t.csv"), "--report",
           scratch.path("r.json"), "--save-model", scratch.path("m.xml")});
  ASSERT_EQ(outcome.code, app::kDone) << outcome.err;
  const nlohmann::json report = scratch.json("r.json");
  EXPECT_EQ(report["robot"], "mighty");
  EXPECT_EQ(report["world"], "flat");
  EXPECT_EQ(report["on"], "sim");
  EXPECT_EQ(report["seed"], 7);
  EXPECT_NEAR(report["duration_s"].get<double>(), 6.0, 1e-9);
  EXPECT_EQ(report["falls"], 0);
  EXPECT_GE(report["segments"]["committed"].get<int>(), 4);
  EXPECT_EQ(report["segments"]["refused"]["foot_region"], 1) << "a refusal counts once for a command";
  EXPECT_EQ(report["commands"]["given"], 3);
  EXPECT_EQ(report["commands"]["moved"], 2);
  EXPECT_GT(report["travel_m"].get<double>(), 0.05);
  for (const char* key : {"plan_us", "tick_us"}) {
    EXPECT_GT(report[key]["n"].get<int>(), 0);
    EXPECT_LE(report[key]["p50"].get<double>(), report[key]["p99"].get<double>());
    EXPECT_LE(report[key]["p99"].get<double>(), report[key]["max"].get<double>());
  }
  EXPECT_GT(report["zmp_margin_m"]["planned_min"].get<double>(), 0.0029);
  EXPECT_GT(report["zmp_margin_m"]["measured_min"].get<double>(), 0.0);
  EXPECT_LT(report["tilt_deg_max"].get<double>(), 10.0);
  EXPECT_GT(report["real_time_factor"].get<double>(), 1.0);
  for (const char* part : {"left_foot", "right_foot", "left_hand", "right_hand", "trunk"}) {
    EXPECT_EQ(report["final"][part]["p"].size(), 3u);
    EXPECT_EQ(report["final"][part]["rpy"].size(), 3u);
  }
  EXPECT_GT(report["final"]["com"][0].get<double>(), 0.05);

  const Table trace(scratch.table("t.csv"));
  ASSERT_EQ(trace.rows(), 1200u) << "a row a tick";
  for (const char* column :
       {"t", "guide", "segment", "phase", "qpos_0", "qpos_26", "qvel_25", "target_left_hip_flexion", "com_z",
        "com_plan_z", "zmp_x", "zmp_plan_y", "contact_left", "touch_right", "force_left"}) {
    EXPECT_TRUE(trace.has(column)) << column;
  }
  std::map<std::string, int> phases;
  double apart = 0.0;
  for (std::size_t k = 0; k < trace.rows(); ++k) {
    ++phases[trace.text(k, "phase")];
    EXPECT_NEAR(trace.number(k, "t"), 0.005 * static_cast<double>(k), 1e-9);
    EXPECT_EQ(trace.text(k, "phase") == "hold", trace.number(k, "segment") < 0);
    apart = std::max(apart, std::abs(trace.number(k, "zmp_x") - trace.number(k, "zmp_plan_x")));
    EXPECT_LT(std::abs(trace.number(k, "com_x") - trace.number(k, "com_plan_x")), 0.005);
  }
  EXPECT_GT(apart, 1e-5) << "measured columns are measured";
  for (const char* phase : {"hold", "double", "single_left", "single_right"})
    EXPECT_GT(phases[phase], 0) << phase;

  const ModelPtr model = compile_text(scratch.read("m.xml"), "saved model");
  EXPECT_EQ(model->nq, 27);
  EXPECT_EQ(model->neq, 0);
  EXPECT_EQ(model->nmocap, 0);
  EXPECT_TRUE(model->opt.disableflags & mjDSBL_AUTORESET);
  for (int b = 0; b < model->nbody; ++b)
    EXPECT_EQ(model->body_gravcomp[b], 0.0);
}

TEST(Drive, ByTheClockTheReportTellsPeriodSlackAndLateness) {
  const Scratch scratch;
  const std::string script = scratch.write("walk.jsonl", R"({"t": 0, "axes": [1, 0, 0, 0, 0, 0]})");
  ASSERT_EQ(run({"drive", "--on", "ideal", "--world", "flat", "--headless", "--seconds", "0.5", "--input",
                 "script:" + script, "--report", scratch.path("r.json")})
                .code,
            app::kDone);
  const nlohmann::json loop = scratch.json("r.json")["loop"];
  EXPECT_EQ(loop["period_us"], 5000.0);
  EXPECT_EQ(loop["interval_us"]["n"], 99);
  EXPECT_GT(loop["interval_us"]["p99"].get<double>(), 0.0);
  EXPECT_LE(loop["slack_us"]["p1"].get<double>(), loop["slack_us"]["p50"].get<double>());
  EXPECT_LT(loop["slack_us"]["p50"].get<double>(), 5000.0);
  EXPECT_EQ(loop["slack_us"]["min"].get<double>() < 0.0, loop["late"].get<int>() > 0);
  EXPECT_GE(loop["dropped"].get<int>(), 0);
}

TEST(Drive, TheSameScriptGivesTheSameTrace) {
  const Scratch scratch;
  const std::string script = "script:" + scratch.write("walk.jsonl", kWalkAhead);
  for (const char* on : {"ideal", "sim"}) {
    for (const char* file : {"a.csv", "b.csv"}) {
      ASSERT_EQ(run({"--world", "room", "--on", on, "--input", script, "--fast", "--seconds", "4", "--trace",
                     scratch.path(file)})
                    .code,
                app::kDone);
    }
    EXPECT_EQ(scratch.read("a.csv"), scratch.read("b.csv"));
    EXPECT_GT(scratch.read("a.csv").size(), 100000u);
  }
}

TEST(Drive, APrintedProfileHasAllThatIsDerivedAndDrivesTheSame) {
  const Scratch scratch;
  const std::string script = "script:" + scratch.write("walk.jsonl", kWalkAhead);
  const Outcome printed = run({"profile"});
  ASSERT_EQ(printed.code, app::kDone) << printed.err;
  EXPECT_THAT(printed.out, HasSubstr("zmp_outward"));
  const std::string whole = scratch.write("whole.toml", printed.out);
  for (const std::string& robot : {std::string("mighty"), whole}) {
    const std::string file = robot == whole ? "whole.csv" : "short.csv";
    ASSERT_EQ(run({"--robot", robot, "--world", "room", "--input", script, "--fast", "--seconds", "4", "--trace",
                   scratch.path(file)})
                  .code,
              app::kDone);
  }
  EXPECT_EQ(scratch.read("whole.csv"), scratch.read("short.csv"));
  EXPECT_GT(scratch.read("short.csv").size(), 100000u);
  EXPECT_EQ(run({"profile", whole}).out, printed.out);
  const Outcome nobody = run({"profile", "nobody"});
  EXPECT_EQ(nobody.code, app::kBadInput);
  EXPECT_THAT(nobody.err, HasSubstr("nobody"));
}

TEST(Drive, BadInputIsOneClearLineAndExitCodeTwo) {
  const Scratch scratch;
  const std::string script = "script:" + scratch.write("ok.jsonl", kWalkAhead);
  const std::string bad = "script:" + scratch.write("bad.jsonl", R"({"t": 0, "guide": "tail", "axes": [0,0,0,0,0,0]})");
  scratch.write("broken.xml", "<mujoco><worldbody><geom name='ground'");
  scratch.write("nan.toml", "name = \"x\"\nmodel = \"mighty.xml\"\n[stance]\nwidth = nan\n");
  struct Case {
    std::vector<std::string> args;
    std::string says;
  };
  const std::vector<std::string> fast{"--fast", "--seconds", "1"};
  const std::vector<Case> cases{
      {{"--robot", "nobody"}, "nobody"},
      {{"--robot", scratch.path("none.toml")}, "none.toml"},
      {{"--robot", scratch.path("nan.toml")}, "nan.toml"},
      {{"--world", "nowhere"}, "nowhere"},
      {{"--world", scratch.path("broken.xml")}, "broken.xml"},
      {{"--input", "wheel"}, "wheel"},
      {{"--input", "script:" + scratch.path("none.jsonl")}, "none.jsonl"},
      {{"--input", bad}, "tail"},
      {{"--input", script, "--trace", "/nowhere/t.csv"}, "/nowhere/t.csv"},
      {{"--input", script, "--report", "/nowhere/r.json"}, "/nowhere/r.json"},
      {{"--input", script, "--save-model", "/nowhere/m.xml"}, "/nowhere/m.xml"},
      {{"--duration", "forever"}, "forever"},
      {{"--gait", "gallop"}, "gait"},
      {{"--on-limit", "hope"}, "hope"},
      {{"--on", "mars"}, "mars"},
      {{"--seconds", "-1"}, "--seconds"},
      {{"--speed", "9"}, "--speed"},
      {{"--input", "page"}, "--input page"},
  };
  for (const Case& c : cases) {
    std::vector<std::string> args{"drive"};
    if (c.says != "--seconds") args.insert(args.end(), fast.begin(), fast.end());
    args.insert(args.end(), c.args.begin(), c.args.end());
    const Outcome outcome = run(args);
    EXPECT_EQ(outcome.code, app::kBadInput) << c.says;
    EXPECT_THAT(outcome.err, HasSubstr(c.says));
    EXPECT_EQ(std::count(outcome.err.begin(), outcome.err.end(), '\n'), 1) << outcome.err;
  }
  EXPECT_THAT(run({"drive", "--fast"}).err, HasSubstr("--seconds"));
  EXPECT_EQ(run({"dance"}).code, app::kBadInput);
}

TEST(Drive, AFallEndsTheRunAndIsReported) {
  // A gale that the planner does not know of.
  const Scratch scratch;
  std::ifstream in(share_dir() / "worlds" / "flat.xml");
  std::ostringstream text;
  text << in.rdbuf();
  std::string world = text.str();
  const auto at = world.find("<option ");
  ASSERT_NE(at, std::string::npos);
  world.insert(at + 8, "density=\"100\" wind=\"8 0 0\" ");
  scratch.write("gale.xml", world);
  const std::string walk = R"({"t": 0, "guide": "trunk", "axes": [1, 1, 0, 0, 0, 1]})";
  const Outcome outcome =
      run({"drive", "--world", scratch.path("gale.xml"), "--input", "script:" + scratch.write("w.jsonl", walk),
           "--fast", "--seconds", "60", "--trace", scratch.path("t.csv"), "--report", scratch.path("r.json")});
  ASSERT_EQ(outcome.code, app::kFallen) << outcome.out;
  EXPECT_THAT(outcome.out, HasSubstr("fallen"));
  const nlohmann::json report = scratch.json("r.json");
  EXPECT_EQ(report["falls"], 1);
  EXPECT_LT(report["duration_s"].get<double>(), 60.0);
  const Table trace(scratch.table("t.csv"));
  EXPECT_EQ(trace.text(trace.rows() - 1, "phase"), "fallen");
}

TEST(Drive, AnAv8rDrivesTheWholeProgram) {
  const test::SdlJoysticks sdl;
  test::HeldAv8r stick([](test::HeldAv8r& hands, int look) {
    hands.hat(look > 50 && look < 550 ? SDL_HAT_UP : SDL_HAT_CENTERED);
    hands.button(12, look > 650 && look < 1200);  // mode A: foot
    hands.button(2, look > 640 && look < 660);    // the right one
    hands.axis(4, look > 700 && look < 1000 ? -1.0 : 1.0);
  });
  const Scratch scratch;
  const Outcome outcome = run({"drive", "--world", "flat", "--input", "joystick", "--fast", "--seconds", "8", "--trace",
                               scratch.path("t.csv"), "--report", scratch.path("r.json")});
  ASSERT_EQ(outcome.code, app::kDone) << outcome.err;
  const nlohmann::json report = scratch.json("r.json");
  EXPECT_EQ(report["falls"], 0);
  EXPECT_GT(report["final"]["com"][0].get<double>(), 0.05) << "the mini stick walks the robot forward";
  const Table trace(scratch.table("t.csv"));
  double lifted = 0.0;
  for (std::size_t k = 0; k < trace.rows(); ++k) {
    if (trace.text(k, "guide") == "right_foot" && trace.text(k, "phase") == "single_left") lifted += 0.005;
  }
  EXPECT_GT(lifted, 0.2) << "the throttle lifts the foot";
  EXPECT_NEAR(report["final"]["right_foot"]["p"][2].get<double>(), 0.0, 1e-3) << "and puts it down";
}

class DriveEndedBy : public testing::TestWithParam<int> {};

// Ctrl-C, kill, and a terminal that goes.
INSTANTIATE_TEST_SUITE_P(Signals, DriveEndedBy, testing::Values(SIGINT, SIGTERM, SIGHUP));

TEST_P(DriveEndedBy, ASignalComesToRestAndWritesWhatWasAskedFor) {
  const test::SdlJoysticks sdl;
  test::HeldAv8r stick([](test::HeldAv8r& hands, int look) {
    hands.hat(look > 20 ? SDL_HAT_UP : SDL_HAT_CENTERED);
    if (look == 100) std::raise(GetParam());  // in the middle of a step
  });
  const Scratch scratch;
  const Outcome outcome = run({"drive", "--world", "flat", "--input", "joystick", "--fast", "--seconds", "60",
                               "--trace", scratch.path("t.csv"), "--report", scratch.path("r.json")});
  EXPECT_EQ(outcome.code, app::kDone);
  const nlohmann::json report = scratch.json("r.json");
  EXPECT_LT(report["duration_s"].get<double>(), 3.0);
  EXPECT_EQ(report["segments"]["committed"], 1);
  const Table trace(scratch.table("t.csv"));
  EXPECT_NE(trace.text(100, "phase"), "hold") << "it was moving";
  EXPECT_NEAR(trace.number(trace.rows() - 1, "com_z"), 0.26, 0.005);
}

TEST(Drive, GoesOnWithoutATerminalWhereNohupAsksForThat) {
  const test::SdlJoysticks sdl;
  test::HeldAv8r stick([](test::HeldAv8r& /*hands*/, int look) {
    if (look == 20) std::raise(SIGHUP);
  });
  const Scratch scratch;
  const auto before = std::signal(SIGHUP, SIG_IGN);
  const Outcome outcome = run({"drive", "--world", "flat", "--on", "ideal", "--input", "joystick", "--fast",
                               "--seconds", "1", "--report", scratch.path("r.json")});
  EXPECT_EQ(std::signal(SIGHUP, before), SIG_IGN) << "and leaves it so";
  EXPECT_EQ(outcome.code, app::kDone);
  EXPECT_NEAR(scratch.json("r.json")["duration_s"].get<double>(), 1.0, 1e-9);
}

TEST(Drive, AJoystickThatIsNotThereIsWaitedForByTheClockOnly) {
  const test::SdlJoysticks sdl;
  const Outcome fast = run({"drive", "--world", "flat", "--input", "joystick", "--fast", "--seconds", "1"});
  EXPECT_EQ(fast.code, app::kBadInput);
  EXPECT_THAT(fast.err, testing::AllOf(HasSubstr("--input joystick"), HasSubstr("--fast"), HasSubstr("Plug in")));
  const Outcome waits =
      run({"drive", "--world", "flat", "--on", "ideal", "--input", "joystick", "--headless", "--seconds", "0.05"});
  EXPECT_EQ(waits.code, app::kDone);
  EXPECT_THAT(waits.err, HasSubstr("Plug in"));
  EXPECT_EQ(std::count(waits.err.begin(), waits.err.end(), '\n'), 1) << waits.err;
}

TEST(Plan, ShowsSegmentsAndRefusals) {
  const Scratch scratch;
  const Outcome outcome = run({"plan", scratch.write("walk.jsonl", kWalkAhead)});
  ASSERT_EQ(outcome.code, app::kDone) << outcome.err;
  const nlohmann::json plan = nlohmann::json::parse(outcome.out);
  int refused = 0;
  int steps = 0;
  for (const auto& segment : plan["segments"]) {
    if (segment.contains("refused")) {
      ++refused;
      EXPECT_EQ(segment["refused"]["reason"], "foot_region");
      continue;
    }
    steps += segment["kind"] == "step" ? 1 : 0;
    double sum = 0.0;
    for (const auto& phase : segment["phases"])
      sum += phase["duration"].get<double>();
    EXPECT_NEAR(sum, segment["T"].get<double>(), 1e-9);
    EXPECT_GE(segment["knots"].size(), 3u);
    EXPECT_GE(segment["margins"].size(), 6u);
    for (const char* part : {"left_foot", "right_foot", "left_hand", "right_hand", "trunk", "com"}) {
      EXPECT_TRUE(segment["goal"].contains(part)) << part;
    }
  }
  EXPECT_GE(refused, 1);
  EXPECT_GE(steps, 1);
}

TEST(Plan, SaysWhatForbidsAnythingShorter) {
  const Scratch scratch;
  const std::string script = scratch.write("walk.jsonl", kWalkAhead);
  const double first = test::robot("mighty").profile().duration.first;
  for (const char* rule : {"paper", "search"}) {
    const Outcome outcome = run({"plan", script, "--duration", rule});
    ASSERT_EQ(outcome.code, app::kDone) << outcome.err;
    const nlohmann::json plan = nlohmann::json::parse(outcome.out);
    int forbidden = 0;
    for (const auto& segment : plan["segments"]) {
      if (segment.contains("refused")) continue;
      const nlohmann::json& why = segment["not_shorter"];
      const bool the_first = segment["T"].get<double>() <= first + 1e-9;
      if (rule == std::string("paper")) {
        EXPECT_EQ(why.is_null(), the_first);
      }
      if (why.is_null()) {
        EXPECT_TRUE(the_first) << rule;
        continue;
      }
      ++forbidden;
      for (const char* key : {"reason", "part", "value", "limit", "where"})
        EXPECT_TRUE(why.contains(key)) << key;
      EXPECT_FALSE(why["reason"].get<std::string>().empty());
    }
    EXPECT_GE(forbidden, 1) << rule;
  }
}

TEST(Reproduce, TheRoomIsReachedAndDriveGivesTheSameTrace) {
  const Scratch scratch;
  const Outcome outcome = run({"reproduce", "room", "--out", scratch.path("room")});
  ASSERT_EQ(outcome.code, app::kDone) << outcome.out << outcome.err;
  const nlohmann::json room = scratch.json("room/room.json");
  EXPECT_EQ(room["falls"], 0);
  EXPECT_EQ(room["reached"], true);
  EXPECT_LT(room["hand_error_m"].get<double>(), 0.015) << "two seconds after the stick was let go of";
  EXPECT_LE(room["duration_s"].get<double>(), 110.0);
  for (const char* file : {"room/fig10.svg", "room/fig11.svg", "room/fig12.png"}) {
    EXPECT_GT(std::filesystem::file_size(scratch.path(file)), 10000u) << file;
  }
  // The robot's back and the door are blue.
  const Image snapshots = load_png(scratch.path("room/fig12.png"));
  int blue = 0;
  for (std::size_t i = 0; i + 2 < snapshots.rgb.size(); i += 3)
    blue += snapshots.rgb[i + 2] > snapshots.rgb[i] + 80 ? 1 : 0;
  EXPECT_GT(blue, 1000);
  const nlohmann::json report = scratch.json("room/room_report.json");
  ASSERT_EQ(run({"drive", "--world", "room", "--input", "script:" + scratch.path("room/room.jsonl"), "--fast",
                 "--seconds", std::to_string(report["duration_s"].get<double>()), "--trace", scratch.path("again.csv")})
                .code,
            app::kDone);
  EXPECT_EQ(scratch.read("again.csv"), scratch.read("room/room.csv"));
}

TEST(DriveToTheWall, StopsBeforeItThoughItsPlaceIsUnsure) {
  const Scratch scratch;
  const std::string ahead = scratch.write("s.jsonl", R"({"t": 0.1, "guide": "trunk", "axes": [1, 0, 0, 0, 0, 0]})"
                                                     "\n");
  int near_it = 0;
  for (int seed = 0; seed < 12; ++seed) {  // 1 and 8 once ran into the door post
    const Outcome outcome =
        run({"drive", "--world", "room", "--plant", "real", "--seed", std::to_string(seed), "--fast", "--seconds", "14",
             "--input", "script:" + ahead, "--report", scratch.path("r.json")});
    EXPECT_EQ(outcome.code, app::kDone) << seed << outcome.out;  // a trunk that touches the wall counts as a fall
    const double x = scratch.json("r.json")["final"]["com"][0].get<double>();
    near_it += x > 0.79 ? 1 : 0;  // who steps on an edge stays there
  }
  EXPECT_GE(near_it, 9) << "the wall is at 0.945";
}

TEST(Reproduce, WalksOfAMinuteEndWhereTheyWereToEnd) {
  const Scratch scratch;
  const Outcome outcome = run({"reproduce", "walks", "--plant", "model", "--out", scratch.path("walks")});
  ASSERT_EQ(outcome.code, app::kDone) << outcome.out << outcome.err;
  const nlohmann::json walks = scratch.json("walks/walks.json");
  ASSERT_EQ(walks.size(), 13u);
  for (const nlohmann::json& walk : walks) {
    const std::string name = walk["walk"];
    EXPECT_EQ(walk["falls"], 0) << name;
    EXPECT_EQ(walk["slips"], 0) << name;
    EXPECT_LT(walk["tilt_deg_max"].get<double>(), 10.0) << name;
    EXPECT_LT(walk["off_m"].get<double>(), 0.03) << name;
    EXPECT_GT(walk["segments"].get<int>(), 80) << name;
    EXPECT_GT(walk["way_m"].get<double>(), name.starts_with("turn") ? 1.5 : 2.0) << name;  // turns: sway
  }
  EXPECT_GT(std::filesystem::file_size(scratch.path("walks/walks.svg")), 10000u);
  // The scripts give the same walk.
  ASSERT_EQ(run({"drive", "--world", "flat", "--input", "script:" + scratch.path("walks/forward.jsonl"), "--plant",
                 "model", "--fast", "--seconds", "60", "--report", scratch.path("r.json")})
                .code,
            app::kDone);
  EXPECT_EQ(scratch.json("r.json")["tracking"]["way_m"], walks[0]["way_m"]);
}

TEST(Operate, TheOperatorReachesTheDoorFromRandomStarts) {
  // 13: feet so far apart ahead that one passes the other at once; 14: turned against each other.
  for (const char* seed : {"0", "1", "2", "13"}) {
    const Outcome outcome = run({"operate", "--task", "room", "--seed", seed});
    EXPECT_EQ(outcome.code, app::kDone) << outcome.out << outcome.err;
  }
  const Outcome outcome = run({"operate", "--task", "room", "--seed", "14", "--plant", "model"});
  EXPECT_EQ(outcome.code, app::kDone) << outcome.out << outcome.err;
}

TEST(Operate, FootByFootToo) {  // a foot that stood at the very edge, and hung over it
  const Outcome outcome = run({"--verbose", "operate", "--task", "room", "--seed", "12", "--gait", "stop",
                               "--foot-by-foot", "--plant", "model"});
  EXPECT_EQ(outcome.code, app::kDone) << outcome.out << outcome.err;
}

}  // namespace
}  // namespace baton
