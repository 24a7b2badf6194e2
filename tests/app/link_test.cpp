#include <gmock/gmock.h>

#include "baton/proving/scenario.hpp"
#include "tests/support/robots.hpp"
#include "tests/support/scratch.hpp"
#include "tests/support/served.hpp"

namespace baton {
namespace {

using test::Outcome;
using test::run;
using test::Scratch;
using testing::HasSubstr;

const std::string kStick = R"({"t": 0.2, "guide": "trunk", "axes": [1, 0, 0, 0, 0, 0]}
{"t": 2.0, "guide": "left_hand", "axes": [0.5, 0, 0.5, 0, 0, 0]}
{"t": 3.0, "guide": "trunk"}
)";

/// What `baton robot --sim --world flat --seed 4` serves, in a thread.
class RobotsEnd : public test::Served {
 public:
  explicit RobotsEnd(const std::string& token = "", bool navigates = true)
      : Served(test::robot("mighty"), plant_of(true, nullptr, test::robot("mighty"), 4, 1.0), token, Pace::lock_step,
               navigates),
        address(Served::address().text()) {}

  const std::string address;
};

class DriveOverALinkTo : public testing::TestWithParam<bool> {};

std::string level(const testing::TestParamInfo<bool>& navigates) {
  return navigates.param ? "ANavigator" : "ABareRobot";
}
INSTANTIATE_TEST_SUITE_P(Robots, DriveOverALinkTo, testing::Bool(), level);

TEST_P(DriveOverALinkTo, TraceRecordingAndReportAreThoseOfARunWithTheSimulatorInside) {
  const Scratch scratch;
  const RobotsEnd end("", GetParam());
  const std::string script = scratch.write("stick.jsonl", kStick);
  const auto drive = [&](const std::string& on, const std::string& name) {
    return run({"drive", "--on", on, "--world", "flat", "--seed", "4", "--input", "script:" + script, "--fast",
                "--seconds", "5", "--trace", scratch.path(name + ".csv"), "--report", scratch.path(name + ".json"),
                "--record", scratch.path(name + ".mcap")});
  };
  ASSERT_EQ(drive("sim", "inside").code, app::kDone);
  const Outcome there = drive(end.address, "there");
  ASSERT_EQ(there.code, app::kDone) << there.err;
  EXPECT_GT(scratch.read("inside.csv").size(), 100'000U);
  EXPECT_TRUE(scratch.read("inside.csv") == scratch.read("there.csv"));
  EXPECT_TRUE(scratch.read("inside.mcap") == scratch.read("there.mcap"));
  nlohmann::json inside_report = scratch.json("inside.json");
  nlohmann::json there_report = scratch.json("there.json");
  EXPECT_EQ(there_report["link"]["address"], end.address);
  EXPECT_EQ(there_report["link"]["navigates"], GetParam());
  EXPECT_EQ(there_report["link"]["rejected"], 0);
  EXPECT_EQ(there_report["link"]["stale"], 0);
  EXPECT_EQ(there_report["link"]["broken"], "");
  there_report.erase("link");
  for (nlohmann::json* report : {&inside_report, &there_report}) {  // what the computer took
    for (const char* time : {"tick_us", "plan_us", "real_time_factor"})
      report->erase(time);
  }
  EXPECT_EQ(inside_report, there_report);
  EXPECT_EQ(run({"replay", scratch.path("there.mcap"), "--verify"}).code, app::kDone);
}

TEST(DriveOverALink, ATokenComesFromAFile) {
  const Scratch scratch;
  const RobotsEnd end("open sesame");
  const auto drive = [&](const std::vector<std::string>& more) {
    std::vector<std::string> args{"drive", "--on",   end.address, "--world", "flat",      "--input",
                                  "page",  "--fast", "--seconds", "0.5",     "--headless"};
    args[6] = "script:" + scratch.write("stick.jsonl", kStick);
    args.insert(args.end(), more.begin(), more.end());
    return run(args);
  };
  const Outcome without = drive({});
  EXPECT_EQ(without.code, app::kFailed);
  EXPECT_THAT(without.err, HasSubstr("refused (token): a token is needed"));
  EXPECT_THAT(drive({"--token", scratch.write("wrong", "open\n")}).err, HasSubstr("the token is wrong"));
  EXPECT_THAT(drive({"--token", scratch.write("empty", " \n")}).err, HasSubstr("is empty"));
  EXPECT_THAT(drive({"--token", scratch.write("binary", "\xff\x01")}).err, HasSubstr("ASCII"));
  const Outcome right = drive({"--token", scratch.write("right", "open sesame\n")});
  EXPECT_EQ(right.code, app::kDone) << right.err;
  EXPECT_EQ(run({"damp", end.address}).code, app::kFailed);
  EXPECT_EQ(run({"damp", end.address, "--token", scratch.path("right")}).code, app::kDone);
  EXPECT_THAT(drive({"--token", scratch.path("right")}).err, HasSubstr("refused (damped)"));
}

TEST(DriveOverALink, WhatOnlyTheOtherEndKnowsIsNotTakenHere) {
  const RobotsEnd end;
  const std::vector<std::pair<std::vector<std::string>, std::string>> cases{
      {{"--plant", "model"}, "--plant model with --on tcp://"},
      {{"--scenario", "push"}, "--scenario push with --on tcp://"},
      {{"--answer-delay", "5"}, "--answer-delay with --on tcp://"},
      {{"--answer-loss", "0.5"}, "--answer-loss with --on tcp://"},
      {{"--world", "room"}, "stands in 'flat'"},
  };
  for (const auto& [more, named] : cases) {
    std::vector<std::string> args{"drive", "--on", end.address, "--headless", "--seconds", "1", "--world", "flat"};
    if (more[0] == "--world") args.resize(6);
    args.insert(args.end(), more.begin(), more.end());
    const Outcome outcome = run(args);
    EXPECT_EQ(outcome.code, app::kBadInput) << outcome.err;
    EXPECT_THAT(outcome.err, HasSubstr(named));
  }
  EXPECT_THAT(run({"drive", "--on", end.address, "--world", "flat", "--times", "2", "--headless"}).err,
              HasSubstr("--times 2 with --on tcp://"));
  EXPECT_THAT(run({"drive", "--token", "t", "--headless"}).err, HasSubstr("goes with --on tcp://"));
  EXPECT_THAT(run({"drive", "--on", "udp://x:1"}).err, HasSubstr("is not sim, ideal or tcp://HOST:PORT"));
  EXPECT_THAT(run({"drive", "--on", "tcp://x"}).err, HasSubstr("is no address"));
  EXPECT_THAT(run({"robot"}).err, HasSubstr("either --sim, or --on"));
}

}  // namespace
}  // namespace baton
