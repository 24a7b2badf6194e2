#include <gmock/gmock.h>

#include "tests/support/scratch.hpp"

namespace baton {
namespace {

using test::run;
using test::Scratch;
using testing::HasSubstr;

class Verify : public testing::Test {
 protected:
  Verify() {
    const std::string script = scratch_.write("walk.jsonl", R"({"t": 0, "guide": "trunk", "axes": [1, 0, 0, 0, 0, 0]}
{"t": 1.5, "guide": "left_hand", "axes": [0, 0, 1, 0, 0, 0]}
{"t": 3.0}
{"t": 4.0, "retrace": true}
{"t": 9.0}
)");
    const test::Outcome planned = run({"plan", script, "--world", "flat", "--out", scratch_.path("motions")});
    plan_ = nlohmann::json::parse(planned.out);
  }

  const Scratch scratch_;
  nlohmann::json plan_;
};

TEST_F(Verify, FindsTheSameMarginsAgain) {
  int checked = 0, backwards = 0;
  for (const auto& segment : plan_["segments"]) {
    if (segment.contains("refused")) continue;
    const test::Outcome outcome = run({"verify", segment["file"].get<std::string>()});
    ASSERT_EQ(outcome.code, app::kDone) << outcome.err;
    const auto again = nlohmann::json::parse(outcome.out);
    EXPECT_TRUE(again["verified"].get<bool>());
    ASSERT_EQ(again["margins"].size(), segment["margins"].size());
    for (std::size_t i = 0; i < again["margins"].size(); ++i) {
      const auto& now = again["margins"][i];
      const auto& then = segment["margins"][i];
      EXPECT_EQ(now["quantity"], then["quantity"]);
      EXPECT_NEAR(now["value"].get<double>(), then["value"].get<double>(), 1e-9) << now["quantity"];
    }
    ++checked;
    if (segment["retraces"].get<bool>()) ++backwards;
  }
  EXPECT_GE(checked, 4);
  EXPECT_GE(backwards, 1);
}

TEST_F(Verify, RefusesAMotionThatWasTamperedWith) {
  auto motion = scratch_.json("motions/segment_000.json");
  motion["samples"][10]["q"][20] = 3.0;
  const test::Outcome outcome = run({"verify", scratch_.write("bent.json", motion.dump())});
  EXPECT_EQ(outcome.code, app::kFailed);
  EXPECT_FALSE(nlohmann::json::parse(outcome.out)["verified"].get<bool>());
}

TEST_F(Verify, AnotherWorldMayRefuseIt) {
  // What walks on the flat floor walks into the stage of the room.
  const test::Outcome outcome = run({"verify", scratch_.path("motions/segment_000.json"), "--world", "room"});
  EXPECT_EQ(outcome.code, app::kFailed) << outcome.out;
}

TEST_F(Verify, AFileThatIsNoMotionIsNamed) {
  const auto good = scratch_.json("motions/segment_000.json");
  const auto says = [&](const std::string& name, const std::string& text) {
    const test::Outcome outcome = run({"verify", scratch_.write(name, text)});
    EXPECT_EQ(outcome.code, app::kBadInput) << name;
    EXPECT_EQ(std::count(outcome.err.begin(), outcome.err.end(), '\n'), 1) << outcome.err;
    EXPECT_THAT(outcome.err, HasSubstr(name));
    return outcome.err;
  };
  says("no.json", "{");
  EXPECT_THAT(says("empty.json", "{}"), HasSubstr("robot is missing"));
  for (const std::string key : {"robot", "world", "anchor", "period", "phases", "dq0", "retraces", "samples"}) {
    auto lacking = good;
    lacking.erase(key);
    EXPECT_THAT(says("lacking_" + key + ".json", lacking.dump()), HasSubstr(key + " is missing"));
  }
  auto odd = good;
  odd["samples"][3]["q"].push_back(0.0);
  EXPECT_THAT(says("long.json", odd.dump()), HasSubstr("samples[3].q"));
  for (const std::string key : {"robot", "world"}) {
    odd = good;
    odd[key] = "nothing";
    EXPECT_THAT(says("odd_" + key + ".json", odd.dump()), HasSubstr(key + " 'nothing'"));
  }
  odd = good;
  odd["samples"][3]["com"][1] = nullptr;
  EXPECT_THAT(says("nan.json", odd.dump()), HasSubstr("samples[3].com[1]"));
  odd = good;
  odd["phases"][0]["ticks"] = 3;
  EXPECT_THAT(says("short.json", odd.dump()), HasSubstr("ticks"));
  odd = good;
  odd["anchor"]["quat"] = {1, 1, 0, 0};
  EXPECT_THAT(says("skew.json", odd.dump()), HasSubstr("anchor.quat"));
  EXPECT_EQ(run({"verify", scratch_.path("none.json")}).code, app::kBadInput);
}

}  // namespace
}  // namespace baton
