/// Files that were damaged in any way are read or refused: whatever reads one says, in one line that names the file,
/// what is wrong, and throws nothing else.
#include <gmock/gmock.h>

#include <functional>
#include <random>

#include "baton/input/json_reader.hpp"
#include "baton/input/script.hpp"
#include "baton/model/error.hpp"
#include "baton/model/input_file.hpp"
#include "baton/model/profile.hpp"
#include "baton/proving/tally.hpp"
#include "baton/record/motion_file.hpp"
#include "baton/record/recording.hpp"
#include "tests/support/robots.hpp"
#include "tests/support/scratch.hpp"

namespace baton {
namespace {

using test::Scratch;

constexpr int kTrials = 2000;

using Random = std::mt19937_64;

std::string mutated(std::string text, Random& random) {
  static const std::vector<std::string> pieces{"0",
                                               "-1",
                                               "1e308",
                                               "1e999",
                                               "-",
                                               "null",
                                               "true",
                                               "\"\"",
                                               "[]",
                                               "{}",
                                               "[",
                                               "]",
                                               "{",
                                               "}",
                                               ",",
                                               ":",
                                               "=",
                                               "\"",
                                               "\\u0000",
                                               "\xff",
                                               "\n",
                                               "nan",
                                               "inf",
                                               "1.5",
                                               "18446744073709551615",
                                               "\"x\"",
                                               "0.0000001",
                                               std::string(1, '\0'),
                                               std::string(200, '['),
                                               std::string(400, '9')};
  const auto below = [&random](std::size_t n) { return static_cast<std::size_t>(random() % (n + 1)); };
  for (std::size_t change = below(3) + 1; change > 0; --change) {
    const std::size_t at = below(text.size());
    switch (random() % 7) {
      case 0:
        if (at < text.size()) text[at] = static_cast<char>(random() % 256);
        break;
      case 1:
        text.erase(at, below(5));
        break;
      case 2:
        text.insert(at, pieces[random() % pieces.size()]);
        break;
      case 3:
        text.insert(at, text.substr(below(text.size()), below(40)));
        break;
      case 4: {  // a value gives way to another
        const std::size_t from = text.find_first_of("0123456789tf\"", at);
        if (from == std::string::npos) break;
        const std::size_t to = std::min(text.find_first_of(",]}\n", from), text.size());
        text.replace(from, to - from, pieces[random() % pieces.size()]);
        break;
      }
      case 5: {  // a member of a list or an object goes
        const std::size_t from = text.find(',', at);
        if (from == std::string::npos) break;
        text.erase(from, std::min(text.find_first_of(",]}\n", from + 1), text.size()) - from);
        break;
      }
      default:
        if (random() % 8 == 0) text.resize(at);
        break;
    }
  }
  return text;
}

class Mutated : public testing::Test {
 protected:
  /// @param read of the file with that name
  void expect_read_or_refused(const std::string& good, const std::string& name,
                              const std::function<void(const std::filesystem::path&)>& read) {
    ASSERT_NO_THROW(read(scratch_.write(name, good)));
    Random random(5);
    int refused = 0;
    for (int trial = 0; trial < kTrials; ++trial) {
      const std::string text = mutated(good, random);
      try {
        read(scratch_.write(name, text));
      } catch (const InputError& error) {
        ++refused;
        const std::string message = error.what();
        ASSERT_THAT(message, testing::AllOf(testing::HasSubstr(name), testing::Not(testing::HasSubstr("\n")),
                                            testing::Not(testing::HasSubstr("exception"))))
            << trial;
        ASSERT_LT(message.size(), 600U) << trial;
      } catch (const std::exception& error) {
        FAIL() << trial << ": " << error.what() << '\n' << text.substr(0, 3000);
      }
    }
    EXPECT_GT(refused, kTrials / 4);
    EXPECT_LT(refused, kTrials);
  }

  /// What the program writes for a moment's drive or plan.
  void ran(const std::vector<std::string>& args) {
    const test::Outcome outcome = test::run(args);
    ASSERT_EQ(outcome.code, app::kDone) << outcome.err;
  }

  Scratch scratch_;
  const std::string script_ = R"({"t": 0, "guide": "trunk", "axes": [1, 0, -0.5, 0, null, 0], "lift": [0.5, 0]}
{"t": 1.25, "guide": "left_foot", "lift": [1e-3, null]}
{"t": 2, "retrace": true}
)";
};

TEST_F(Mutated, Script) {
  expect_read_or_refused(script_, "walk.jsonl", [](const auto& file) { static_cast<void>(Script::load(file)); });
}

TEST_F(Mutated, Profile) {
  const test::Outcome whole = test::run({"profile", "mighty"});
  ASSERT_EQ(whole.code, app::kDone) << whole.err;
  expect_read_or_refused(whole.out, "profile.toml", [](const auto& file) { static_cast<void>(Profile::load(file)); });
}

TEST_F(Mutated, Recording) {
  ran({"drive", "--on", "sim", "--world", "flat", "--fast", "--seconds", "0.02", "--input",
       "script:" + scratch_.write("s.jsonl", script_), "--record", scratch_.path("good.mcap")});
  std::vector<std::string> joints;
  for (const Joint& joint : test::robot("mighty").joints())
    joints.push_back(joint.name);
  expect_read_or_refused(scratch_.read("good.mcap"), "run.mcap", [&](const auto& file) {
    RecordingReader reader(file);
    while (const auto tick = reader.next(joints)) {
      for (const VecX* v : {&tick->measurement.q, &tick->measurement.dq, &tick->target})
        ASSERT_EQ(v->size(), std::ssize(joints));
      ASSERT_LE(static_cast<int>(tick->command.recall), static_cast<int>(Recall::stop));
    }
  });
}

TEST_F(Mutated, Motion) {
  ran({"plan", scratch_.write("s.jsonl", script_), "--seconds", "0", "--out", scratch_.path("plan")});
  nlohmann::json good = scratch_.json("plan/segment_000.json");
  good["samples"].erase(good["samples"].begin() + 5, good["samples"].end());
  good["phases"] = nlohmann::json::array({good["phases"][0]});
  good["phases"][0]["ticks"] = 4;
  const RobotModel& robot = test::robot("mighty");
  expect_read_or_refused(good.dump(), "motion.json", [&](const auto& file) {
    static_cast<void>(read_motion_place(file));
    static_cast<void>(read_motion(file, robot));
  });
}

TEST_F(Mutated, ReportOfASoak) {
  ran({"soak", "--segments", "1", "--episode", "2", "--report", scratch_.path("good.json")});
  nlohmann::json good = scratch_.json("good.json");
  good["first_failures"].push_back(
      {{"kind", "zmp"}, {"episode", 0}, {"t", 0.5}, {"value", nullptr}, {"limit", 0.003}, {"where", "x"}});
  expect_read_or_refused(good.dump(2), "report.json", [](const auto& file) {
    const nlohmann::json json = parse_json(read_input(file, "report"), "report " + file.string());
    const Tally tally = Tally::from_json(JsonReader(json, "report " + file.string()));
    ASSERT_GE(tally.segments, 0);
  });
}

}  // namespace
}  // namespace baton
