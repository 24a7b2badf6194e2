/// Recording and replay, and planning on a thread of its own.
#include <gmock/gmock.h>

#include <cmath>
#include <fstream>
#include <functional>
#include <nlohmann/json.hpp>

#include "app/app.hpp"
#include "app/outputs.hpp"
#include "baton/input/script.hpp"
#include "baton/proving/stick.hpp"
#include "tests/support/robots.hpp"
#include "tests/support/scratch.hpp"

namespace baton {
namespace {

using test::Outcome;
using test::run;
using test::Scratch;
using testing::HasSubstr;

const std::string kScript = R"({"t": 0.1, "guide": "trunk", "axes": [1, 0.3, 0, 0, 0, 0.2]}
{"t": 1.3, "guide": "left_hand", "axes": [0.5, 0, 1, null, 0, 0]}
{"t": 1.8, "guide": "right_foot", "axes": [0, -1, 0, 0, 0, 0], "lift": [0, 0.5]}
{"t": 2.5, "retrace": true}
)";

class Replay : public testing::Test {
 protected:
  void record(const std::string& on, std::vector<std::string> more) {
    std::vector<std::string> args{"drive",
                                  "--on",
                                  on,
                                  "--world",
                                  "flat",
                                  "--input",
                                  "script:" + scratch_.write("s.jsonl", kScript),
                                  "--seconds",
                                  "3",
                                  "--record",
                                  file_,
                                  "--headless"};
    args.insert(args.end(), more.begin(), more.end());
    const Outcome outcome = run(args);
    ASSERT_EQ(outcome.code, app::kDone) << outcome.err;
  }

  [[nodiscard]] std::vector<std::string> lines() const {
    std::ifstream in(file_);
    std::vector<std::string> lines;
    for (std::string line; std::getline(in, line);)
      lines.push_back(line);
    return lines;
  }

  Scratch scratch_;
  std::string file_ = scratch_.path("run.jsonl");
};

TEST_F(Replay, GivesTheSameJointTargetsBitByBit) {
  for (const char* on : {"ideal", "sim"}) {
    for (const char* gait : {"flow", "stop"}) {
      record(on, {"--fast", "--gait", gait});
      const Outcome again = run({"replay", file_, "--verify"});
      EXPECT_EQ(again.code, app::kDone) << again.out << again.err;
      EXPECT_THAT(again.out, HasSubstr("600 ticks"));
      EXPECT_THAT(again.out, HasSubstr("identical bit for bit"));
    }
  }
}

TEST_F(Replay, AlsoOfARunThatWaitedForNothing) {
  record("ideal", {});  // by the clock, planned on a thread of its own
  const Outcome again = run({"replay", file_, "--verify"});
  EXPECT_EQ(again.code, app::kDone) << again.out << again.err;
}

TEST_F(Replay, AlsoOfARunThatIsPushedAndWhoseAnswersComeLateOrNever) {
  long dropped = 0;
  for (const char* scenario : {"push", "mix"}) {
    for (const char* seed : {"1", "2", "3"}) {
      for (const bool spoilt : {false, true}) {
        SCOPED_TRACE(testing::Message() << scenario << ' ' << seed << ' ' << spoilt);
        std::string script;
        Stick stick(std::stoul(seed), 0.005);
        for (int k = 0; k < 1600; ++k)
          script += script_line(0.005 * k, stick.next()) + '\n';
        const std::string report = scratch_.path("r.json");
        std::vector<std::string> args{
            "drive",  "--world",   "flat",     "--input",    "script:" + scratch_.write("wild.jsonl", script),
            "--fast", "--seconds", "8",        "--scenario", scenario,
            "--seed", seed,        "--record", file_,        "--report",
            report};
        if (spoilt) args.insert(args.end(), {"--answer-delay", "60", "--answer-loss", "0.1"});
        ASSERT_EQ(run(args).code, app::kDone);
        const Outcome again = run({"replay", file_, "--verify"});
        EXPECT_EQ(again.code, app::kDone) << again.out << again.err;
        const long late = std::stol(again.out.substr(again.out.find("segments, ") + 10));
        EXPECT_TRUE(spoilt || late == 0) << late;
        dropped += late;
      }
    }
  }
  EXPECT_GT(dropped, 10);
}

TEST_F(Replay, TellsWhichSensorsWereNotBelievedAndNoticesADifference) {
  record("sim", {"--fast", "--scenario", "glitches", "--times", "20", "--seed", "4"});
  const Outcome again = run({"replay", file_, "--verify"});
  EXPECT_EQ(again.code, app::kDone) << again.out << again.err;
  std::vector<std::string> text = lines();
  long changes = 0;
  std::size_t changed = 0;
  for (std::size_t k = 1; k < text.size(); ++k) {
    const nlohmann::json line = nlohmann::json::parse(text[k]);
    if (!line.contains("sensors")) continue;
    for (const auto& [sensor, health] : line["sensors"].items()) {
      ++changes;
      EXPECT_THAT(again.out, HasSubstr("tick " + std::to_string(k - 1) + ": sensor " + sensor + " is " +
                                       health.get<std::string>() + "\n"));
    }
    changed = k;
  }
  ASSERT_GT(changes, 4);
  EXPECT_EQ(std::count(again.out.begin(), again.out.end(), '\n'), changes + 1);

  const auto with = [&](const std::function<void(nlohmann::json&)>& change) {
    nlohmann::json line = nlohmann::json::parse(text[changed]);
    change(line);
    std::ofstream out(file_);
    for (std::size_t k = 0; k < text.size(); ++k)
      out << (k == changed ? line.dump() : text[k]) << '\n';
    out.close();
    return run({"replay", file_, "--verify"});
  };
  const Outcome other = with([](nlohmann::json& line) { line.erase("sensors"); });
  EXPECT_EQ(other.code, app::kFailed);
  EXPECT_THAT(other.out, HasSubstr("the sensors' health differs from the recorded one"));
  const Outcome bad = with([](nlohmann::json& line) { line["sensors"].begin().value() = "ill"; });
  EXPECT_EQ(bad.code, app::kBadInput);
  EXPECT_THAT(bad.err, HasSubstr("must be good, bridged or lost"));
  const Outcome unknown = with([](nlohmann::json& line) { line["sensors"]["nose"] = "lost"; });
  EXPECT_EQ(unknown.code, app::kBadInput);
  EXPECT_THAT(unknown.err, HasSubstr("must be an object whose keys are sensors"));
}

TEST_F(Replay, NoticesAnythingElse) {
  record("ideal", {"--fast"});
  std::vector<std::string> text = lines();
  ASSERT_EQ(text.size(), 601u);
  const auto write = [&] {
    std::ofstream out(file_);
    for (const std::string& line : text)
      out << line << '\n';
  };
  // Another command, early: other targets later.
  const std::string original = text[21];
  ASSERT_THAT(original, HasSubstr("\"axes\":[1.0,0.3"));
  text[21].replace(text[21].find("[1.0,0.3"), 8, "[0.9,0.3");
  write();
  const Outcome other = run({"replay", file_, "--verify"});
  EXPECT_EQ(other.code, app::kFailed);
  EXPECT_THAT(other.out, HasSubstr("the joint targets differ"));
  text[21] = original;

  // A recording that ends in the middle of a line was cut off by the end of the process.
  text.back().resize(text.back().size() / 2);
  write();
  std::filesystem::resize_file(file_, std::filesystem::file_size(file_) - 1);
  const Outcome cut = run({"replay", file_, "--verify"});
  EXPECT_EQ(cut.code, app::kDone) << cut.err;
  EXPECT_THAT(cut.out, HasSubstr("599 ticks"));

  text[300] = "{}";
  write();
  const Outcome broken = run({"replay", file_, "--verify"});
  EXPECT_EQ(broken.code, app::kBadInput);
  EXPECT_THAT(broken.err, HasSubstr("line 301"));
  EXPECT_EQ(run({"replay", scratch_.path("none.jsonl")}).code, app::kBadInput);
  EXPECT_EQ(run({"replay", scratch_.write("other.json", "{\"a\": 1}\n")}).code, app::kBadInput);
}

TEST_F(Replay, HoldsTheTargetsThemselvesToTheRecordedOnes) {
  record("ideal", {"--fast"});
  const std::vector<std::string> text = lines();
  struct Change {
    std::size_t line;
    std::size_t joint;
    double by;  ///< 0: the next number
  };
  for (const Change& change : {Change{300, 5, 0.1}, Change{1, 0, 0.0}, Change{600, 19, 0.0}}) {
    nlohmann::json line = nlohmann::json::parse(text[change.line]);
    const double was = line["target"][change.joint];
    line["target"][change.joint] = change.by != 0.0 ? was + change.by : std::nextafter(was, 10.0);
    std::ofstream out(file_);
    for (std::size_t i = 0; i < text.size(); ++i)
      out << (i == change.line ? line.dump() : text[i]) << '\n';
    out.close();
    const Outcome other = run({"replay", file_, "--verify"});
    EXPECT_EQ(other.code, app::kFailed) << change.line;
    EXPECT_THAT(other.out, HasSubstr("tick " + std::to_string(change.line - 1) + ": the joint targets differ"));
    EXPECT_EQ(run({"replay", file_}).code, app::kDone) << "without --verify it is only summed up";
  }
}

TEST_F(Replay, WhatItReadsWrongIsOneLineAndExitCodeTwo) {
  record("ideal", {"--fast"});
  const std::vector<std::string> text = lines();
  const auto refused = [&](const std::string& all, const std::string& says) {
    for (const std::vector<std::string>& more : {std::vector<std::string>{}, {"--verify"}}) {
      std::vector<std::string> args{"replay", scratch_.write("bad.jsonl", all)};
      args.insert(args.end(), more.begin(), more.end());
      const Outcome outcome = run(args);
      EXPECT_EQ(outcome.code, app::kBadInput) << outcome.out;
      EXPECT_THAT(outcome.err, testing::AllOf(HasSubstr("bad.jsonl"), HasSubstr(says)));
      EXPECT_EQ(std::count(outcome.err.begin(), outcome.err.end(), '\n'), 1) << outcome.err;
    }
  };
  const auto changed = [&](std::size_t i, const std::string& pointer, const nlohmann::json& value) {
    nlohmann::json line = nlohmann::json::parse(text[i]);
    line[nlohmann::json::json_pointer(pointer)] = value;
    std::string all;
    for (std::size_t k = 0; k < 4; ++k)
      all += (k == i ? line.dump() : text[k]) + '\n';
    return all;
  };
  refused(changed(2, "/m/dq", nlohmann::json::array()), "line 3: m.dq has 0 members: must be a list of 20 numbers");
  refused(changed(2, "/m/dq", {1.0, 2.0, 3.0}), "line 3: m.dq has 3 members");
  refused(changed(1, "/c/recall", 9), "line 2: c.recall = 9");
  refused(changed(0, "/gait", "gallop"), "line 1: gait = \"gallop\": must be stop or flow");
  refused(changed(0, "/world", "nowhere"), "line 1: world 'nowhere'");
  refused(changed(0, "/robot", "nobody"), "line 1: robot 'nobody'");
  refused(changed(0, "/world", 5), "line 1: world = 5");
  refused(text[0] + '\n', "holds no ticks");
}

}  // namespace
}  // namespace baton
