#include "baton/proving/checker.hpp"

#include <gmock/gmock.h>

#include <fstream>
#include <functional>
#include <set>

#include "baton/input/script.hpp"
#include "baton/run/simulation.hpp"
#include "tests/support/robots.hpp"

namespace baton {
namespace {

using Kind = Checker::Kind;
using Ticks = std::vector<Checker::Tick>;

/// Walks, reaches, lifts a foot and stands on the other at the end.
constexpr std::string_view kScript = R"({"t": 0.2, "guide": "trunk", "axes": [1, 0, 0, 0, 0, 0]}
{"t": 1.5, "guide": "left_hand", "axes": [0.5, 0, 0.5, 0, 0, 0]}
{"t": 2.5, "guide": "left_foot", "axes": [0, 0, 0, 0, 0, 0], "lift": [1, 0]})";

struct Recorded {
  std::string model_text;
  Ticks ticks;
};

/// What was executed on the ideal robot; once a process.
const Recorded& recorded(const std::string& name) {
  static std::map<std::string, Recorded> known;
  Recorded& made = known[name];
  if (!made.ticks.empty()) return made;
  const World world = World::load("flat");
  Simulation simulation(test::robot(name), world, Simulation::On::ideal);
  Session& session = simulation.session();
  made.model_text = simulation.model_text();
  Hooks hooks;
  session.add(hooks);
  hooks.tick = [&made](const TickRecord& r) {
    made.ticks.push_back(
        {r.t, Pose{}, r.truth->q, r.navigator.sample().contact, r.navigator.phase() == Phase::hold, false, r.target.q});
  };
  Script script = Script::parse(kScript, "walk");
  while (session.t() < 5.0)
    session.step(script);
  return made;
}

std::set<std::string_view> judge(const RobotModel& robot, const std::string& model_text, const Ticks& ticks) {
  Checker checker(robot, model_text);
  std::set<std::string_view> kinds;
  for (const Checker::Tick& tick : ticks) {
    for (const Checker::Violation& v : checker.add(tick))
      kinds.insert(Checker::kNames[static_cast<std::size_t>(v.kind)]);
  }
  return kinds;
}

class CheckerTest : public testing::TestWithParam<std::string> {
 protected:
  /// First of at least three ticks of which this is true.
  template <typename Fits>
  [[nodiscard]] std::size_t find(const Fits& fits) const {
    for (std::size_t k = 2; k + 2 < ticks_.size(); ++k) {
      if (fits(ticks_[k - 1]) && fits(ticks_[k]) && fits(ticks_[k + 1])) return k;
    }
    ADD_FAILURE() << "the recording has no such tick";
    return 2;
  }
  [[nodiscard]] Eigen::Index joint(Side side, std::size_t which) const { return robot_.arm(side)[which]; }
  [[nodiscard]] const Joint& joint_of(Eigen::Index j) const { return robot_.joints()[static_cast<std::size_t>(j)]; }
  /// Adds to a joint from tick `k` on, in what is planned and what is executed.
  void bend(std::size_t k, Eigen::Index j, const std::function<double(double)>& angle_at) {
    const double dt = robot_.profile().tick.period;
    for (std::size_t i = k; i < ticks_.size(); ++i) {
      ticks_[i].q[7 + j] += angle_at(static_cast<double>(i - k) * dt);
      ticks_[i].target[j] += angle_at(static_cast<double>(i - k + 1) * dt);
    }
    if (k > 0) ticks_[k - 1].target[j] += angle_at(0.0);
  }
  [[nodiscard]] std::set<std::string_view> judged() const { return judge(robot_, text_, ticks_); }

  const RobotModel& robot_ = test::robot(GetParam());
  std::string text_ = recorded(GetParam()).model_text;
  Ticks ticks_ = recorded(GetParam()).ticks;
};

INSTANTIATE_TEST_SUITE_P(Robots, CheckerTest, testing::ValuesIn(test::robot_names()), test::name_of_param);

bool both(const Checker::Tick& tick) {
  return tick.contact.left && tick.contact.right;
}
bool one(const Checker::Tick& tick) {
  return tick.contact.left != tick.contact.right;
}

TEST_P(CheckerTest, FindsNothingInAGoodTrajectory) {
  EXPECT_THAT(judged(), testing::IsEmpty());
  EXPECT_TRUE(std::any_of(ticks_.begin(), ticks_.end(), [](const auto& tick) { return tick.hold && one(tick); }));
}

TEST_P(CheckerTest, FindsANumberThatIsNone) {
  ticks_[300].q[10] = std::nan("");
  EXPECT_TRUE(judged().contains("not_finite"));
}

TEST_P(CheckerTest, FindsTimeThatStandsStillOrSkips) {
  const std::size_t k = find(both);
  ticks_[k].t = ticks_[k - 1].t;
  EXPECT_THAT(judged(), testing::ElementsAre("clock"));
}

TEST_P(CheckerTest, FindsATargetThatWasNotReached) {
  ticks_[300].target[3] += 1e-6;
  EXPECT_THAT(judged(), testing::ElementsAre("target"));
}

TEST_P(CheckerTest, FindsAJointTooNearToItsLimit) {
  const Eigen::Index j = joint(Side::left, 2);
  double highest = -10.0;
  for (const auto& tick : ticks_)
    highest = std::max(highest, tick.q[7 + j]);
  const double room = joint_of(j).position.hi - highest;
  const double margin = robot_.profile().margin.joint;
  const Ticks good = ticks_;
  bend(0, j, [&](double) { return room - 0.9 * margin; });
  EXPECT_TRUE(judged().contains("joint_range"));
  ticks_ = good;
  bend(0, j, [&](double) { return room - 1.1 * margin; });
  EXPECT_FALSE(judged().contains("joint_range"));
}

TEST_P(CheckerTest, FindsAJointThatIsTooFast) {
  // Fast from the first tick on, so that there is no jump.
  const Eigen::Index j = joint(Side::left, 3);
  ticks_.resize(4);
  bend(0, j, [&](double t) { return -1.01 * joint_of(j).speed * t; });
  EXPECT_TRUE(judged().contains("joint_speed"));
  EXPECT_FALSE(judged().contains("joint_acceleration"));
}

TEST_P(CheckerTest, FindsATorqueThatTheMotorDoesNotHave) {
  // On one leg: the stance hip flexion accelerates what is above it; the first joint of the leg.
  const std::size_t k = find(one);
  const Eigen::Index j = robot_.leg(ticks_[k].contact.left ? Side::left : Side::right).front();
  bend(k, j, [](double t) { return 15.0 * t * t; });
  EXPECT_TRUE(judged().contains("joint_torque"));
}

TEST_P(CheckerTest, FindsATorqueOfAnArmOnBothFeetToo) {
  const std::size_t k = find(both);
  ticks_.resize(k + 6);
  const Eigen::Index j = joint(Side::right, 0);
  const double stall = joint_of(j).motor.stall / robot_.mj().dof_armature[6 + j];
  bend(k, j, [&](double t) { return 0.4 * stall * t * t; });
  EXPECT_TRUE(judged().contains("joint_torque"));
}

TEST_P(CheckerTest, FindsASpeedThatJumps) {
  const std::size_t k = find(both);
  const Eigen::Index j = joint(Side::right, 2);
  bend(k, j, [&](double t) { return 0.3 * joint_of(j).speed * t; });
  EXPECT_TRUE(judged().contains("joint_acceleration"));
}

TEST_P(CheckerTest, AStepThatCatchesTheRobotMayAskForMore) {
  const std::size_t k = find(both);
  ticks_.resize(k + 6);
  const Eigen::Index j = joint(Side::right, 0);
  const Ticks good = ticks_;
  const double most = robot_.profile().margin.acceleration;
  for (const double share : {0.9, 1.2, 1.4, 1.6}) {  // of the acceleration, which an arm does not need already
    for (const bool catching : {false, true}) {
      ticks_ = good;
      for (auto& tick : ticks_)
        tick.catching = catching;
      bend(k, j, [&](double t) { return 0.5 * share * most * t * t; });
      EXPECT_EQ(judged().contains("joint_acceleration"), share > (catching ? 1.5 : 1.0)) << share << catching;
    }
  }
}

TEST_P(CheckerTest, FindsWhatMovesInHold) {
  const std::size_t k = find([](const auto& tick) { return tick.hold; });
  bend(k, joint(Side::left, 0), [](double) { return 1e-6; });
  EXPECT_THAT(judged(), testing::ElementsAre("rest"));
}

TEST_P(CheckerTest, FindsAZmpOutsideTheSoles) {
  // One of two standing soles is said to be in the air: the weight lies between them.
  const std::size_t k = find([](const auto& tick) { return tick.hold && both(tick); });
  ticks_[k].contact.right = false;
  EXPECT_THAT(judged(), testing::Contains("zmp"));
  ticks_[k].contact.left = false;
  EXPECT_THAT(judged(), testing::Contains("zmp")) << "nothing stands";
}

TEST_P(CheckerTest, FindsAFootholdThatWouldSlip) {
  const std::size_t k = find(both);
  for (std::size_t i = k; i < ticks_.size(); ++i) {
    const double t = static_cast<double>(i - k) * robot_.profile().tick.period;
    ticks_[i].q[0] += 0.5 * 6.0 * t * t;
  }
  EXPECT_THAT(judged(), testing::Contains("friction"));
}

TEST_P(CheckerTest, FindsAGroundThatWouldHaveToPull) {
  const std::size_t k = find(both);
  for (std::size_t i = k; i < ticks_.size(); ++i) {
    const double t = static_cast<double>(i - k) * robot_.profile().tick.period;
    ticks_[i].q[2] -= 0.5 * 11.0 * t * t;
  }
  EXPECT_THAT(judged(), testing::Contains("friction"));
}

TEST_P(CheckerTest, FindsLinksThatAreTooNear) {
  // An arm comes down until its nearest pair is nearer than the margin; nothing is found before.
  const Eigen::Index j = joint(Side::left, 1);
  ticks_.resize(3);
  Kinematics kinematics(robot_);
  const double margin = robot_.profile().margin.self_collision;
  for (int i = 0; i < 100; ++i) {
    bend(0, j, [](double) { return -0.02; });
    kinematics.set(ticks_[0].q);
    const double distance = kinematics.self_distance(1.0);
    ASSERT_EQ(judged().contains("self_collision"), distance < margin) << distance;
    if (distance < margin) return;
  }
  FAIL() << "the arm never came near";
}

TEST_P(CheckerTest, FindsALinkThatIsTooNearToTheWorld) {
  // Towards the wall of the room, in small steps.
  const World world = World::load("room");
  text_ = world.compose(robot_, 0.001);
  ticks_.resize(3);
  const double margin = robot_.profile().margin.self_collision;
  const ModelPtr model = compile_text(text_, "room");
  const DataPtr data(mj_makeData(model.get()));
  for (int i = 0; i < 1200; ++i) {
    const double x = 0.3 + 0.001 * i;
    double distance = 1.0;
    for (auto& tick : ticks_)
      tick.frame.p.x() = x;
    mju_copy(data->qpos, ticks_[0].q.data(), model->nq);
    data->qpos[0] += x;
    mj_kinematics(model.get(), data.get());
    for (int a = 0; a < model->ngeom; ++a) {
      for (int b = 0; b < model->ngeom; ++b) {
        const bool collide = model->geom_contype[a] == 2 && model->geom_contype[b] == 1;
        if (!collide || World::is_ground(baton::name_of(*model, mjOBJ_GEOM, b))) continue;
        distance = std::min(distance, mj_geomDistance(model.get(), data.get(), a, b, distance, nullptr));
      }
    }
    if (distance > 1.2 * margin && distance < 2.0 * margin) {
      ASSERT_FALSE(judged().contains("obstacle")) << distance;
    }
    if (distance < 0.8 * margin) {
      EXPECT_TRUE(judged().contains("obstacle")) << distance;
      return;
    }
  }
  FAIL() << "the robot never came near";
}

TEST_P(CheckerTest, FindsASoleThatSlides) {
  const std::size_t k = find(both);
  for (std::size_t i = k; i < ticks_.size(); ++i) {
    const double s = std::min(1.0, static_cast<double>(i - k) / 100.0);
    ticks_[i].q[1] += 2e-3 * s * s * (3.0 - 2.0 * s);
  }
  EXPECT_THAT(judged(), testing::Contains("slip"));
}

TEST_P(CheckerTest, FindsASwingSoleInTheGround) {
  // The whole robot lower than it is: the standing sole is in the ground, and so is the other before it lands.
  for (auto& tick : ticks_)
    tick.frame.p.z() = -0.04 * robot_.profile().stance.com_height / 0.26;
  EXPECT_THAT(judged(), testing::UnorderedElementsAre("swing_ground", "sole_ground"));
}

TEST_P(CheckerTest, FindsASoleThatStandsOnNothing) {
  for (auto& tick : ticks_)
    tick.frame.p.z() = 0.001;
  EXPECT_THAT(judged(), testing::ElementsAre("sole_ground"));
  ticks_ = recorded(GetParam()).ticks;
  text_ = World::load("room").compose(robot_, 0.001);
  for (auto& tick : ticks_)
    tick.frame.p = {0.12 - robot_.sole(Side::left).vertices().front().cwiseAbs().x(), 0.0, 0.03};
  EXPECT_TRUE(judged().contains("sole_ground")) << "beyond the stage's edge";
}

TEST_P(CheckerTest, WhatIsBelievedLaterOfWhereASoleWasPutDownIsNotItsFault) {
  // In physics the frame is where the robot believes that it stands.
  const auto judged_lower_from = [&](std::size_t k) {
    Ticks ticks = ticks_;
    for (std::size_t i = k; i < k + 3; ++i)
      ticks[i].frame.p.z() = -0.01 * robot_.profile().stance.com_height / 0.26;
    return judge(robot_, text_, ticks);
  };
  EXPECT_THAT(judged_lower_from(find(both)), testing::IsEmpty());
  EXPECT_THAT(judged_lower_from(0), testing::Contains("sole_ground")) << "put down there";
}

TEST(Checker, SharesNoCodeWithWhatItJudges) {
  for (const char* file : {"/baton/proving/checker.hpp", "/baton/proving/checker.cpp"}) {
    std::ifstream in(std::string(BATON_SOURCE_DIR) + file);
    ASSERT_TRUE(in);
    for (std::string line; std::getline(in, line);) {
      if (!line.starts_with("#include \"")) continue;
      EXPECT_TRUE(line.find("baton/model/") != std::string::npos || line.find("proving/checker") != std::string::npos)
          << line;
      EXPECT_EQ(line.find("contact"), std::string::npos) << line;
      EXPECT_EQ(line.find("kinematics"), std::string::npos) << line;
    }
  }
}

}  // namespace
}  // namespace baton
