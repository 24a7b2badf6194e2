#include "baton/input/script.hpp"
#include "tests/support/temp.hpp"

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <fstream>
#include <limits>
#include <random>

#include "baton/model/error.hpp"

namespace baton {
namespace {

using testing::AllOf;
using testing::HasSubstr;
using testing::Not;

constexpr double kNan = std::numeric_limits<double>::quiet_NaN();

/// What the script's author is told; empty if the text is taken.
std::string complaint(const std::string& text) {
  try {
    static_cast<void>(Script::parse(text, "walk.jsonl"));
  } catch (const InputError& error) {
    return error.what();
  }
  return "";
}

TEST(Script, HoldsEachCommandUntilTheNextLine) {
  Script script = Script::parse(
      "{\"t\": 0.5, \"guide\": \"left_hand\", \"axes\": [1, -0.5, 0.25, 0, 0.1, -1], \"lift\": [0.5, 1]}\n"
      "\n"
      "{\"t\": 1.25, \"guide\": \"right_foot\"}\r\n"
      "  \t\n"
      "{\"t\": 2, \"lift\": [0, 0]}",
      "walk.jsonl");
  EXPECT_EQ(script.entries().size(), 3u);
  EXPECT_EQ(script.duration(), 2.0);
  EXPECT_EQ(script.read(0.0), Command{});
  EXPECT_EQ(script.read(0.499), Command{});
  Command hand{Part::left_hand, {}, {0.5, 1.0}};
  hand.axes << 1, -0.5, 0.25, 0, 0.1, -1;
  EXPECT_EQ(script.read(0.5), hand);
  EXPECT_EQ(script.read(0.5 - 1e-12), hand);
  EXPECT_EQ(script.read(1.249), hand);
  const Command foot{Part::right_foot, Vec6::Zero(), {0.5, 1.0}};  // the levers stay, the stick is let go
  EXPECT_EQ(script.read(1.25), foot);
  EXPECT_EQ(script.read(2.0), (Command{Part::right_foot, Vec6::Zero(), {0.0, 0.0}}));
  EXPECT_EQ(script.read(1e9), script.read(2.0));
  EXPECT_EQ(script.read(1.25), foot);  // any order
  EXPECT_EQ(script.read(kNan), Command{});
  EXPECT_TRUE(script.status().armed);
  EXPECT_TRUE(script.status().connected);
  EXPECT_EQ(script.status().name, "walk.jsonl");
}

TEST(Script, TheWaysBackAreLetGoOnTheNextLine) {
  Script script = Script::parse(
      "{\"t\": 1, \"guide\": \"left_foot\", \"retrace\": true}\n"
      "{\"t\": 2}\n"
      "{\"t\": 3, \"home\": true, \"retrace\": false}\n"
      "{\"t\": 4, \"home\": false}\n",
      "walk.jsonl");
  EXPECT_EQ(script.read(0.0).recall, Recall::none);
  EXPECT_EQ(script.read(1.0), (Command{Part::left_foot, Vec6::Zero(), {}, Recall::retrace}));
  EXPECT_EQ(script.read(2.0), (Command{Part::left_foot, Vec6::Zero(), {}, Recall::none}));
  EXPECT_EQ(script.read(3.0).recall, Recall::home);
  EXPECT_EQ(script.read(4.0).recall, Recall::none);
}

TEST(Script, ReadsTheTickThatFallsOnALine) {
  Script script = Script::parse("{\"t\": 0}\n{\"t\": 0.3, \"axes\": [1, 0, 0, 0, 0, 0]}", "s");
  double t = 0.0;
  for (int tick = 0; tick < 60; ++tick)
    t += 0.005;  // 0.3 less some rounding
  EXPECT_EQ(script.read(t).axes[0], 1.0);
}

TEST(Script, OfEqualTimesTheLastCounts) {
  Script script = Script::parse("{\"t\": 1, \"guide\": \"left_foot\"}\n{\"t\": 1, \"guide\": \"left_hand\"}", "s");
  EXPECT_EQ(script.read(1.0).guide, Part::left_hand);
}

TEST(Script, ClampsAndKeepsWhatIsNotANumber) {
  Script script = Script::parse("{\"t\": 0, \"axes\": [7, -1e300, null, 0, 0, 0], \"lift\": [-3, null]}", "s");
  const Command command = script.read(0.0);
  EXPECT_EQ(command.axes[0], 1.0);
  EXPECT_EQ(command.axes[1], -1.0);
  EXPECT_TRUE(std::isnan(command.axes[2]));
  EXPECT_EQ(command.lift.left, 0.0);
  EXPECT_TRUE(std::isnan(command.lift.right));
  EXPECT_EQ(sanitised(command).axes[2], 0.0);
}

TEST(Script, KnowsEveryPart) {
  for (const Part part : kParts) {
    EXPECT_EQ(Script::parse(fmt::format("{{\"t\": 0, \"guide\": \"{}\"}}", to_string(part)), "s").read(0).guide, part);
  }
}

struct Bad {
  std::string line;
  std::vector<std::string> named;  ///< what the message has to name
};

class BadLine : public testing::TestWithParam<Bad> {};

TEST_P(BadLine, IsNamedInOneClearLine) {
  const std::string message = complaint("{\"t\": 1}\n\n" + GetParam().line + "\n{\"t\": 9}\n");
  EXPECT_THAT(message,
              AllOf(HasSubstr("script walk.jsonl: line 3: "), Not(HasSubstr("\n")), Not(HasSubstr("json.exception"))));
  for (const std::string& name : GetParam().named)
    EXPECT_THAT(message, HasSubstr(name));
  EXPECT_LT(message.size(), 300u);
}

INSTANTIATE_TEST_SUITE_P(
    Script, BadLine,
    testing::Values(
        Bad{"forward", {"not JSON"}}, Bad{"{\"t\": 1", {"not JSON"}}, Bad{"{\"t\": 1} {\"t\": 2}", {"not JSON"}},
        Bad{"{\"t\": 1,}", {"not JSON"}}, Bad{"{\"t\": NaN}", {"not JSON"}}, Bad{"{\"t\": 1e999}", {"1e999"}},
        Bad{"\xff\xfe", {"not JSON"}}, Bad{std::string("{\"t\": 1\0}", 9), {"not JSON"}},
        Bad{"{\"t\": \"" + std::string(5000, 'a') + "\x01", {"not JSON"}}, Bad{"[1, 2]", {"[1,2]", "object"}},
        Bad{"3", {"3", "object"}}, Bad{"null", {"null", "object"}}, Bad{"{}", {"t is missing"}},
        Bad{"{\"axes\": [0,0,0,0,0,0]}", {"t is missing"}}, Bad{"{\"t\": null}", {"t = null", "seconds"}},
        Bad{"{\"t\": \"2\"}", {"t = \"2\"", "seconds"}}, Bad{"{\"t\": -1}", {"t = -1", "seconds"}},
        Bad{"{\"t\": true}", {"t = true"}}, Bad{"{\"t\": 1e300}", {"t = 1e+300", "at most 86400"}},
        Bad{"{\"t\": 86400.5}", {"t = 86400.5", "a day"}}, Bad{"{\"t\": 0.5}", {"t = 0.5", "at least 1"}},
        Bad{"{\"t\": 1, \"t\": 2}", {"\"t\"", "twice"}},
        Bad{"{\"t\": 1, \"axis\": [0]}", {"unknown key \"axis\"", "axes", "retrace", "home", "stop"}},
        Bad{"{\"t\": 1, \"retrace\": 1}", {"retrace = 1", "true or false"}},
        Bad{"{\"t\": 1, \"retrace\": null}", {"retrace = null", "true or false"}},
        Bad{"{\"t\": 1, \"home\": \"true\"}", {"home = \"true\"", "true or false"}},
        Bad{"{\"t\": 1, \"home\": [true]}", {"home = [true]", "true or false"}},
        Bad{"{\"t\": 1, \"retrace\": true, \"home\": true}", {"retrace and home are both true"}},
        Bad{"{\"t\": 1, \"stop\": true, \"home\": true}", {"home and stop are both true"}},
        Bad{"{\"t\": 1, \"stop\": 1}", {"stop = 1", "true or false"}},
        Bad{"{\"t\": 1, \"home\": true, \"home\": true}", {"\"home\"", "twice"}},
        Bad{"{\"t\": 1, \"T\": 2}", {"unknown key \"T\""}}, Bad{"{\"t\": 1, \"a\\nb\": 2}", {"unknown key \"a\\nb\""}},
        Bad{"{\"t\": 1, \"guide\": \"left hand\"}", {"guide = \"left hand\"", "left_hand"}},
        Bad{"{\"t\": 1, \"guide\": null}", {"guide = null"}}, Bad{"{\"t\": 1, \"guide\": 2}", {"guide = 2"}},
        Bad{"{\"t\": 1, \"guide\": [\"trunk\"]}", {"guide = [\"trunk\"]"}},
        Bad{"{\"t\": 1, \"axes\": [0, 0, 0, 0, 0]}", {"axes = [0,0,0,0,0]", "6 numbers"}},
        Bad{"{\"t\": 1, \"axes\": [0, 0, 0, 0, 0, 0, 0]}", {"axes", "6 numbers"}},
        Bad{"{\"t\": 1, \"axes\": [0, 0, \"1\", 0, 0, 0]}", {"axes", "6 numbers"}},
        Bad{"{\"t\": 1, \"axes\": [0, 0, [1], 0, 0, 0]}", {"axes", "6 numbers"}},
        Bad{"{\"t\": 1, \"axes\": null}", {"axes = null", "6 numbers"}}, Bad{"{\"t\": 1, \"axes\": 1}", {"axes = 1"}},
        Bad{"{\"t\": 1, \"axes\": {\"x\": 1}}", {"axes = {\"x\":1}"}},
        Bad{"{\"t\": 1, \"lift\": [0]}", {"lift = [0]", "2 numbers"}},
        Bad{"{\"t\": 1, \"lift\": [0, false]}", {"lift = [0,false]", "2 numbers"}},
        Bad{"{\"t\": 1, \"lift\": 0.5}", {"lift = 0.5", "2 numbers"}},
        Bad{"{\"t\": 1, \"axes\": " + std::string(200000, '['), {"nested"}}));

TEST(Script, NamesTheFileThatCannotBeRead) {
  EXPECT_THAT([] { static_cast<void>(Script::load("/nonexistent/walk.jsonl")); },
              testing::ThrowsMessage<InputError>("script /nonexistent/walk.jsonl: no such file"));
  const std::string folder = test::temp_folder();
  EXPECT_THAT([&] { static_cast<void>(Script::load(folder)); },
              testing::ThrowsMessage<InputError>(HasSubstr("is a folder, not a file that can be read whole")));
}

TEST(Script, LoadsAFile) {
  const std::string file = test::temp_folder() + "baton_script_test.jsonl";
  std::ofstream(file) << "{\"t\": 0, \"guide\": \"left_foot\"}\n{\"t\": 1.5}\n";
  EXPECT_EQ(Script::load(file).duration(), 1.5);
  std::ofstream(file) << "{\"t\": 0}\n{\"t\": \"x\"}\n";
  EXPECT_THAT([&] { static_cast<void>(Script::load(file)); },
              testing::ThrowsMessage<InputError>(HasSubstr(file + ": line 2: t = \"x\"")));
}

TEST(Script, RefusesAFileWithoutCommands) {
  for (const char* text : {"", "\n", " \n\t\r\n"})
    EXPECT_THAT(complaint(text), HasSubstr("walk.jsonl: empty"));
}

TEST(Script, RefusesEntriesOutOfOrder) {
  for (const auto& [a, b] : {std::pair{1.0, 0.5}, {-1.0, 0.0}, {0.0, kNan}, {0.0, HUGE_VAL}}) {
    EXPECT_THROW(Script(std::vector<Script::Entry>{{a, {}}, {b, {}}}), InputError) << a << " " << b;
  }
  EXPECT_EQ(Script(std::vector<Script::Entry>{}).read(1.0), Command{});
}

TEST(Script, AnyTextIsTakenOrRefusedInOneLine) {
  const std::string good =
      "{\"t\": 0, \"guide\": \"trunk\", \"axes\": [1, 0, -0.5, 0, null, 0], \"lift\": [0.5, 0]}\n"
      "{\"t\": 1.25, \"guide\": \"left_foot\", \"lift\": [1e-3, null]}\n";
  const std::vector<std::string> pieces{
      "0", "5",    "-",     " ",    "\n", "{",      "}",     "[",       "]",       "\"",   ",",
      ":", "null", "1e400", "true", "t",  "\"t\":", "guide", "\\u0000", "\\ud800", "\xc3", std::string(1, '\0')};
  std::mt19937_64 random(3);
  int taken = 0;
  constexpr int kLines = 20000;
  for (int trial = 0; trial < kLines; ++trial) {
    std::string text = good;
    for (std::uint64_t change = random() % 2 + 1; change > 0; --change) {
      const std::size_t at = random() % text.size();
      switch (random() % 4) {
        case 0:
          text[at] = static_cast<char>(random() % 256);
          break;
        case 1:
          text.erase(at, random() % 4 + 1);
          break;
        case 2:
          text.insert(at, pieces[random() % pieces.size()]);
          break;
        default:
          text.insert(at, text.substr(random() % text.size(), random() % 20));
          break;
      }
      if (text.empty()) text = "{";
    }
    const std::string message = complaint(text);
    if (!message.empty()) {
      ASSERT_EQ(message.rfind("script walk.jsonl: ", 0), 0u) << message;
      ASSERT_EQ(message.find('\n'), std::string::npos) << message;
      continue;
    }
    ++taken;
    Script script = Script::parse(text, "s");
    for (const auto& [t, command] : script.entries()) {
      ASSERT_TRUE(std::isfinite(t));
      ASSERT_LE(sanitised(command).axes.cwiseAbs().maxCoeff(), 1.0);
    }
  }
  EXPECT_GT(taken, kLines / 100);
  EXPECT_LT(taken, kLines);
}

}  // namespace
}  // namespace baton
