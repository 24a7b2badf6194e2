/// Recording and replay, and planning on a thread of its own.
#include <gmock/gmock.h>

#include <algorithm>
#include <cmath>
#include <fstream>
#include <functional>
#include <nlohmann/json.hpp>

#include "app/app.hpp"
#include "app/outputs.hpp"
#include "baton/input/script.hpp"
#include "baton/proving/stick.hpp"
#include "tests/support/recording_edit.hpp"
#include "tests/support/robots.hpp"
#include "tests/support/scratch.hpp"

namespace baton {
namespace {

using test::Outcome;
using test::RecordingParts;
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

  void write(const RecordingParts& parts, bool finished = true) const { std::ofstream(file_) << parts.bytes(finished); }
  /// What replays of a recording with one message changed say.
  [[nodiscard]] Outcome replayed_with(RecordingParts parts, const std::string& topic, std::uint32_t tick,
                                      const std::function<void(nlohmann::json&)>& change) const {
    RecordingParts::Part& part = parts.at(topic, tick);
    nlohmann::json message = part.json();
    change(message);
    part.data = message.dump();
    write(parts);
    return run({"replay", file_, "--verify"});
  }

  Scratch scratch_;
  std::string file_ = scratch_.path("run.mcap");
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

TEST_F(Replay, HasWhatDroveTheArms) {
  const std::string chunks = R"({"t": 0, "joints": ["left_elbow_flexion"], "at": [0.8, 1.6], "q": [[0.7], [1.2]]}
{"t": 1.0, "joints": ["right_elbow_flexion", "right_shoulder_flexion"], "at": [1.1], "q": [[0.9, 0.2]]}
{"t": 2.0, "joints": ["left_elbow_flexion"]}
)";
  record("sim", {"--fast", "--arms", "script:" + scratch_.write("arms.jsonl", chunks)});
  const Outcome again = run({"replay", file_, "--verify"});
  EXPECT_EQ(again.code, app::kDone) << again.out << again.err;
  EXPECT_THAT(again.out, HasSubstr("identical bit for bit"));
  const RecordingParts parts(file_);
  const Outcome other = replayed_with(parts, "/baton/arms", 0, [](nlohmann::json& m) { m["q"][0][0] = 0.6; });
  EXPECT_EQ(other.code, app::kFailed) << other.out << other.err;
  const Outcome none = replayed_with(parts, "/baton/arms", 0, [](nlohmann::json& m) { m["joints"][0] = "left_knee"; });
  EXPECT_EQ(none.code, app::kBadInput) << none.out;
  EXPECT_THAT(none.err, HasSubstr("left_knee"));
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
  const RecordingParts parts(file_);
  long changes = 0;
  std::uint32_t changed = 0;
  for (const RecordingParts::Part& part : parts.messages) {
    if (part.topic != "/baton/events") continue;
    const nlohmann::json event = part.json();
    if (event["event"] != "sensor") continue;
    ++changes;
    EXPECT_THAT(again.out,
                HasSubstr("tick " + std::to_string(part.sequence) + ": sensor " + event["sensor"].get<std::string>() +
                          " is " + event["health"].get<std::string>() + "\n"));
    changed = part.sequence;
  }
  ASSERT_GT(changes, 4);
  EXPECT_EQ(std::count(again.out.begin(), again.out.end(), '\n'), changes + 1);

  const Outcome other = replayed_with(parts, "/baton/events", changed, [](auto& event) { event["health"] = "ill"; });
  EXPECT_EQ(other.code, app::kFailed);
  EXPECT_THAT(other.out, HasSubstr("tick " + std::to_string(changed) + ": "));
  EXPECT_THAT(other.out, HasSubstr("in the recording"));
  EXPECT_THAT(other.out, HasSubstr("\"health\":\"ill\""));
}

TEST_F(Replay, NoticesAnythingElse) {
  record("ideal", {"--fast"});
  const RecordingParts parts(file_);
  ASSERT_EQ(parts.count("/baton/tick"), 600);
  // Another command, early: other targets later.
  const Outcome other = replayed_with(parts, "/baton/command", 20, [](auto& c) { c["axes"][0] = 0.9; });
  EXPECT_EQ(other.code, app::kFailed);
  EXPECT_THAT(other.out, HasSubstr("the joint targets differ from the recorded ones by up to "));

  // A file that was not finished is replayed to its end.
  RecordingParts cut = parts;
  std::erase_if(cut.messages, [](const auto& part) { return part.sequence >= 590; });
  write(cut, false);
  const Outcome unfinished = run({"replay", file_, "--verify"});
  EXPECT_EQ(unfinished.code, app::kDone) << unfinished.err;
  EXPECT_THAT(unfinished.out, HasSubstr("590 ticks"));
  EXPECT_THAT(unfinished.out, HasSubstr("the recording was not finished"));

  // A gap, as after a disk that was too slow.
  cut = parts;
  std::erase_if(cut.messages, [](const auto& part) { return part.sequence >= 300 && part.sequence < 340; });
  write(cut);
  const Outcome gap = run({"replay", file_, "--verify"});
  EXPECT_EQ(gap.code, app::kFailed);
  EXPECT_THAT(gap.out, HasSubstr("300 ticks"));
  EXPECT_THAT(gap.out, HasSubstr("tick 299: 40 ticks are missing"));

  const Outcome broken = replayed_with(parts, "/baton/tick", 300, [](auto& tick) { tick = nlohmann::json::array(); });
  EXPECT_EQ(broken.code, app::kBadInput);
  EXPECT_THAT(broken.err, HasSubstr("tick 300: /baton/tick"));
  EXPECT_EQ(run({"replay", scratch_.path("none.mcap")}).code, app::kBadInput);
  const Outcome old = run({"replay", scratch_.write("other.json", "{\"baton_recording\": 2}\n")});
  EXPECT_EQ(old.code, app::kBadInput);
  EXPECT_THAT(old.err, HasSubstr("is not an MCAP file"));
}

TEST_F(Replay, HoldsTheTargetsThemselvesToTheRecordedOnes) {
  record("ideal", {"--fast"});
  const RecordingParts parts(file_);
  struct Change {
    std::uint32_t tick;
    Eigen::Index joint;
    double by;  ///< 0: the next number
  };
  for (const Change& change : {Change{299, 5, 0.1}, Change{0, 0, 0.0}, Change{599, 19, 0.0}}) {
    RecordingParts changed = parts;
    std::string& data = changed.at("/joint_targets", change.tick).data;
    ros::JointState message;
    decode(data, message);
    double& was = message.position[change.joint];
    was = change.by != 0.0 ? was + change.by : std::nextafter(was, 10.0);
    encode(data, message);
    write(changed);
    const Outcome other = run({"replay", file_, "--verify"});
    EXPECT_EQ(other.code, app::kFailed) << change.tick;
    EXPECT_THAT(other.out, HasSubstr("tick " + std::to_string(change.tick) + ": the joint targets differ"));
    EXPECT_THAT(other.out, HasSubstr(message.name[static_cast<std::size_t>(change.joint)]));
    EXPECT_THAT(other.out, HasSubstr(change.by != 0.0 ? "by up to 0.1 rad" : "rad, at "));
    EXPECT_EQ(run({"replay", file_}).code, app::kDone) << "without --verify it is only summed up";
  }
  const Outcome sum = replayed_with(parts, "/baton/tick", 7, [](auto& tick) { tick["sum"] = "0123456789abcdef"; });
  EXPECT_EQ(sum.code, app::kFailed);
  EXPECT_THAT(sum.out, HasSubstr("tick 7: the joint targets differ"));
}

TEST_F(Replay, InfoTakesEventsWithoutAName) {
  record("ideal", {"--fast"});
  const RecordingParts parts(file_);
  const auto first = std::ranges::find(parts.messages, "/baton/events", &RecordingParts::Part::topic);
  ASSERT_NE(first, parts.messages.end());
  for (const char* data : {R"({"event": 7})", "{}", "[1]", "7", "null"}) {
    RecordingParts changed = parts;
    changed.messages[static_cast<std::size_t>(first - parts.messages.begin())].data = data;
    write(changed);
    const Outcome outcome = run({"info", file_});
    EXPECT_EQ(outcome.code, app::kDone) << data << outcome.err;
    EXPECT_THAT(outcome.out, HasSubstr("1 event")) << data;
  }
}

TEST_F(Replay, WhatItReadsWrongIsOneLineAndExitCodeTwo) {
  record("ideal", {"--fast"});
  const RecordingParts parts(file_);
  const auto refused = [&](const std::string& key, const std::string& value, const std::string& says) {
    RecordingParts changed = parts;
    changed.metadata[key] = value;
    write(changed);
    for (const std::vector<std::string>& more : {std::vector<std::string>{}, {"--verify"}}) {
      std::vector<std::string> args{"replay", file_};
      args.insert(args.end(), more.begin(), more.end());
      const Outcome outcome = run(args);
      EXPECT_EQ(outcome.code, app::kBadInput) << outcome.out;
      EXPECT_THAT(outcome.err, testing::AllOf(HasSubstr("run.mcap"), HasSubstr(says)));
      EXPECT_EQ(std::count(outcome.err.begin(), outcome.err.end(), '\n'), 1) << outcome.err;
    }
  };
  refused("gait", "gallop", "gait = \"gallop\": must be stop or flow");
  refused("world", "nowhere", "world 'nowhere'");
  refused("robot", "nobody", "robot 'nobody'");
  refused("start", "[1, 2]", "start has 2 members: must be a list of 27 numbers");
  refused("recording", "4", "recording = 4: must be 3");
}

TEST_F(Replay, SaysWhatARunWasMadeOf) {
  record("ideal", {"--fast"});
  const mcap::Reader reader(file_, "recording");
  const mcap::Metadata& head = reader.metadata().at("baton");
  EXPECT_EQ(head.at("baton"), app::version());
  EXPECT_EQ(head.at("mujoco"), "3.17.0");
  const mcap::Attachment& profile = reader.attachments().at("profile.toml");
  EXPECT_EQ(head.at("profile_sum"), checksum(profile.data));
  EXPECT_THAT(profile.data, HasSubstr("[stance]"));
  EXPECT_THAT(profile.data, HasSubstr("com_height"));
}

}  // namespace
}  // namespace baton
