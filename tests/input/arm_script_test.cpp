/// Scripts of what drives the arms.
#include "baton/input/arm_script.hpp"

#include <gmock/gmock.h>

#include "baton/input/arm_targets_json.hpp"
#include "baton/model/error.hpp"
#include "tests/support/robots.hpp"

namespace baton {
namespace {

using testing::HasSubstr;

ArmScript arms_of(const std::string& text) {
  return ArmScript::parse(text, "a.jsonl", test::robot("mighty"));
}

TEST(ArmScriptTest, GivesEachChunkOnceFromItsTimeOn) {
  ArmScript script = arms_of(R"({"t": 0.5, "joints": ["left_elbow_flexion"], "at": [1, 2], "q": [[-0.3], [-0.4]]}

{"t": 0.5, "joints": ["right_elbow_flexion"]}
{"t": 0.7, "joints": ["left_elbow_flexion"]})");
  EXPECT_EQ(script.next(0.4), nullptr);
  const ArmTargets* first = script.next(0.5);
  ASSERT_NE(first, nullptr);
  EXPECT_EQ(first->t, (std::vector<double>{1.0, 2.0}));
  EXPECT_EQ(first->q(1, 0), -0.4);
  const ArmTargets* second = script.next(0.5);
  ASSERT_NE(second, nullptr);
  EXPECT_TRUE(second->t.empty());
  EXPECT_EQ(script.next(0.5), nullptr);
  EXPECT_NE(script.next(9.0), nullptr);
  EXPECT_EQ(script.next(9.0), nullptr);
}

TEST(ArmScriptTest, ChunksAreReadAsTheyWereWritten) {
  const ArmTargets targets{{"left_elbow_flexion", "right_elbow_flexion"}, {0.1, 1.0 / 3.0}, MatX::Random(2, 2)};
  const nlohmann::json json = nlohmann::json::parse(to_json(targets).dump());
  const ArmTargets again = arm_targets_in(JsonReader(json, "here"));
  EXPECT_EQ(again.joints, targets.joints);
  EXPECT_EQ(again.t, targets.t);
  EXPECT_EQ(again.q, targets.q);
}

TEST(ArmScriptTest, ManyNamesAndTimesWithoutTargetsTakeNoMemory) {
  constexpr std::size_t kMany = 100'000;
  const nlohmann::json json = {{"joints", std::vector<std::string>(kMany, "")},
                               {"at", std::vector<double>(kMany, 0.0)},
                               {"q", std::vector<std::vector<double>>(kMany)}};
  EXPECT_THROW(static_cast<void>(arm_targets_in(JsonReader(json, "here"))), InputError);
}

TEST(ArmScriptTest, WhatIsWrongIsNamedWithItsLine) {
  const std::vector<std::pair<std::string, std::string>> wrong{
      {"", "empty"},
      {R"({"t": 0})", "joints"},
      {R"({"t": -1, "joints": ["left_elbow_flexion"]})", "t = -1"},
      {R"({"t": 0, "joints": ["left_knee_flexion"]})", "left_knee_flexion"},
      {R"({"t": 0, "joints": ["left_elbow_flexion", "left_elbow_flexion"], "at": [1], "q": [[0, 0]]})", "twice"},
      {R"({"t": 0, "joints": ["left_elbow_flexion"], "at": [1]})", "q"},
      {R"({"t": 0, "joints": ["left_elbow_flexion"], "at": [2, 1], "q": [[0], [0]]})", "later"},
      {R"({"t": 0, "joints": ["left_elbow_flexion"], "at": [1], "q": [[0, 1]]})", "q[0]"},
      {R"({"t": 0, "joints": ["left_elbow_flexion"], "at": [1], "q": [["x"]]})", "q[0]"},
      {"{", "not JSON"},
  };
  for (const auto& [text, what] : wrong) {
    try {
      static_cast<void>(arms_of(text));
      ADD_FAILURE() << text;
    } catch (const InputError& error) {
      EXPECT_THAT(error.what(), HasSubstr(what));
      EXPECT_THAT(error.what(), HasSubstr(text.empty() ? "a.jsonl" : "a.jsonl: line 1"));
    }
  }
  EXPECT_THROW(static_cast<void>(arms_of(R"({"t": 2, "joints": ["left_elbow_flexion"]})"
                                         "\n"
                                         R"({"t": 1, "joints": ["left_elbow_flexion"]})")),
               InputError);
}

}  // namespace
}  // namespace baton
