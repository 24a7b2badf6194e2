/// What a recording may hold. tests/app/replay_test.cpp has what a run makes of it.
#include "baton/record/recording.hpp"

#include <gmock/gmock.h>

#include "baton/model/error.hpp"
#include "tests/support/robots.hpp"
#include "tests/support/scratch.hpp"

namespace baton {
namespace {

using nlohmann::json;
using test::Scratch;
using testing::AllOf;
using testing::HasSubstr;
using testing::Not;

class Recording : public testing::Test {
 protected:
  Recording() {
    const std::string script = scratch_.write("s.jsonl", R"({"t": 0, "axes": [1, 0, 0, 0, 0, 0]})");
    const test::Outcome outcome = test::run({"drive", "--on", "sim", "--world", "flat", "--fast", "--seconds", "0.02",
                                             "--input", "script:" + script, "--record", scratch_.path("good.jsonl")});
    EXPECT_EQ(outcome.code, app::kDone) << outcome.err;
    std::istringstream text(scratch_.read("good.jsonl"));
    for (std::string line; std::getline(text, line);)
      lines_.push_back(json::parse(line));
    EXPECT_EQ(lines_.size(), 5U);
  }

  /// What is said of the recording with that line in the place of its own; empty: nothing.
  [[nodiscard]] std::string complaint(std::size_t index, const json& line) const {
    std::string text;
    for (std::size_t i = 0; i < lines_.size(); ++i)
      text += (i == index ? line : lines_[i]).dump() + '\n';
    return complaint(text);
  }
  [[nodiscard]] std::string complaint(const std::string& text) const {
    try {
      RecordingReader reader(scratch_.write("run.jsonl", text));
      while (reader.next(joints_)) {
      }
    } catch (const InputError& error) {
      EXPECT_THAT(error.what(), AllOf(HasSubstr("run.jsonl"), Not(HasSubstr("\n")), Not(HasSubstr("exception"))));
      return error.what();
    }
    return "";
  }

  Scratch scratch_;
  std::vector<json> lines_;
  const Eigen::Index joints_ = test::robot("mighty").nv() - 6;
};

/// "/m/imu/0" as messages have it: "m.imu[0]".
std::string field(const std::string& pointer) {
  std::string name;
  for (std::size_t i = 1; i < pointer.size(); ++i) {
    const bool index = i + 1 < pointer.size() && pointer[i] == '/' && std::isdigit(pointer[i + 1]) != 0;
    if (index) {
      name += std::string("[") + pointer[++i] + "]";
    } else {
      name += pointer[i] == '/' ? '.' : pointer[i];
    }
  }
  return name;
}

TEST_F(Recording, EveryVectorHasTheLengthThatTheRobotHas) {
  ASSERT_EQ(complaint(1, lines_[1]), "");
  for (const std::string at :
       {"/m/q", "/m/dq", "/m/torque", "/m/imu/0", "/m/imu/1", "/m/imu/2", "/m/sole/0/0", "/m/sole/0/1", "/m/sole/1/0",
        "/m/sole/1/1", "/m/root/0", "/m/root/1", "/m/root/2", "/m/root/3", "/target", "/c/axes", "/c/lift"}) {
    const json::json_pointer pointer(at);
    const json good = lines_[1].at(pointer);
    const auto says = [&](const json& value) {
      json line = lines_[1];
      line.at(pointer) = value;
      const std::string message = complaint(1, line);
      EXPECT_THAT(message, AllOf(HasSubstr("line 2"), HasSubstr(field(at)))) << at << " " << value;
      return message;
    };
    json longer = good;
    longer.push_back(0.0);
    json shorter = good;
    shorter.erase(0);
    for (const json& wrong : {longer, shorter, json::array({1.0})}) {
      EXPECT_THAT(says(wrong), AllOf(HasSubstr(std::to_string(wrong.size()) + " members"),
                                     HasSubstr("must be a list of " + std::to_string(good.size()))));
    }
    if (at != "/m/torque") static_cast<void>(says(json::array()));  // not measured
    for (const json& other : {json(nullptr), json("x"), json(1.0), json::object(), json(true)}) {
      static_cast<void>(says(other));
      json member = good;
      member[good.size() - 1] = other;
      // A reading that is not a finite number is null.
      if (!other.is_number() && !(other.is_null() && at.starts_with("/m/"))) static_cast<void>(says(member));
    }
  }
  for (const std::string at : {"/m/imu", "/m/sole", "/m/sole/0", "/m/root"}) {
    for (const json& wrong : {json::array(), json::array({0}), json(nullptr), json("x"), json(5)}) {
      json line = lines_[1];
      line.at(json::json_pointer(at)) = wrong;
      EXPECT_THAT(complaint(1, line), AllOf(HasSubstr("line 2"), HasSubstr(field(at)))) << at << " " << wrong;
    }
  }
}

TEST_F(Recording, AValueThatIsNotAmongTheAllowedOnesIsNamedWithThem) {
  struct Case {
    std::size_t line;
    std::string at;
    std::string allowed;
  };
  for (const Case& c :
       {Case{0, "/baton_recording", "must be 2"}, Case{0, "/on", "sim, ideal or real"},
        Case{0, "/duration", "paper or search"}, Case{0, "/gait", "stop or flow"},
        Case{0, "/on_limit", "discard or shrink"}, Case{0, "/state", "sensors, torques or perfect"},
        Case{0, "/drive", "torque, pd or stiff"}, Case{0, "/robot", "a text"}, Case{0, "/world", "a text"},
        Case{1, "/c/guide", "left_hand, right_hand or trunk"}, Case{1, "/c/recall", "a whole number from 0 to 3"},
        Case{1, "/sum", "a text"}, Case{1, "/m/t", "a number"}}) {
    const json::json_pointer pointer(c.at);
    for (const json& wrong : {json(nullptr), json(-1), json(4), json(1.5), json("gallop"), json(true), json::array(),
                              json::object(), json(18446744073709551615U)}) {
      if (wrong.is_string() && c.allowed == "a text") continue;
      if (wrong.is_number() && c.allowed == "a number") continue;
      json line = lines_[c.line];
      line.at(pointer) = wrong;
      EXPECT_THAT(complaint(c.line, line),
                  AllOf(HasSubstr("line " + std::to_string(c.line + 1)), HasSubstr(field(c.at)),
                        HasSubstr(wrong.dump()), HasSubstr(c.allowed)));
    }
    json line = lines_[c.line];
    line.at(pointer.parent_pointer()).erase(pointer.back());
    EXPECT_THAT(complaint(c.line, line), HasSubstr(field(c.at) + " is missing"));
  }
  for (const auto& [key, value] : {std::pair<std::string, json>{"fallen", 1},
                                   {"events", "ask"},
                                   {"events", {"answer"}},
                                   {"events", json::array()},
                                   {"events", {1}}}) {
    json line = lines_[1];
    line[key] = value;
    EXPECT_THAT(complaint(1, line), AllOf(HasSubstr("line 2"), HasSubstr(key)));
  }
  for (const char* key : {"m", "target", "sum"}) {
    json line = lines_[3];
    line.erase(key);
    EXPECT_THAT(complaint(3, line), AllOf(HasSubstr("line 4"), HasSubstr(std::string(key) + " is missing")));
  }
  json line = lines_[1];
  line.erase("c");
  EXPECT_THAT(complaint(1, line), HasSubstr("c is missing")) << "the first command is not told by a line before";
}

TEST_F(Recording, WhatIsNoRecordingIsRefused) {
  const std::string head = lines_[0].dump() + '\n';
  const std::string tick = lines_[1].dump() + '\n';
  EXPECT_EQ(complaint(head + tick), "");
  for (const std::string& text :
       {std::string(), std::string("\n"), std::string("{}\n"), std::string("[1]\n"), std::string("\xff\xfe\x00\x01", 4),
        std::string(300000, '[') + '\n', std::string(3 << 20, ' ') + '\n', head + "\n" + tick, head + "[]\n" + tick,
        head + "1e999\n", head + std::string(100000, '[') + '\n', head + std::string(2 << 20, '7') + '\n',
        head + head}) {
    EXPECT_NE(complaint(text), "") << text.substr(0, 80);
  }
  for (const std::string& rest : {std::string(), tick.substr(0, tick.size() / 2)})
    EXPECT_THAT(complaint(head + rest), HasSubstr("holds no ticks"));
  EXPECT_THROW(RecordingReader{scratch_.path("none.jsonl")}, InputError);
  EXPECT_THROW(RecordingReader{"/dev/zero"}, InputError);
  EXPECT_THROW(RecordingReader{"/"}, InputError);
}

TEST_F(Recording, AReadingMayBeNoneButNoTime) {
  json line = lines_[4];
  line["m"]["dq"][3] = nullptr;
  line["m"]["imu"][0][2] = nullptr;
  line["m"]["sole"][1][0][0] = nullptr;
  EXPECT_EQ(complaint(4, line), "");
  line["m"]["t"] = nullptr;
  EXPECT_THAT(complaint(4, line), HasSubstr("m.t = null"));
}

}  // namespace
}  // namespace baton
