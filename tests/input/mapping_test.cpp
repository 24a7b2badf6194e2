/// Properties of both mappings over random states of the devices, and of arming over random histories.
#include <gtest/gtest.h>

#include <random>
#include <utility>

#include "baton/input/arming.hpp"
#include "baton/input/av8r.hpp"
#include "baton/input/pad.hpp"

namespace baton {
namespace {

constexpr int kTrials = 5000;

class MappingTest : public testing::Test {
 protected:
  /// Ends, centre and everything between, all of them often.
  double position() {
    switch (random_() % 4) {
      case 0:
        return static_cast<double>(random_() % 3) - 1.0;
      default:
        return std::uniform_real_distribution<double>(-1.0, 1.0)(random_);
    }
  }
  bool held() { return random_() % 3 == 0; }
  int three_way() { return static_cast<int>(random_() % 3) - 1; }
  Side side() { return held() ? Side::left : Side::right; }
  Part part() { return kParts[random_() % kParts.size()]; }

  Av8rState av8r() {
    Av8rState state;
    for (double& axis : state.axes)
      axis = position();
    for (bool& button : state.buttons)
      button = held();
    state.hat_right = three_way();
    state.hat_up = three_way();
    return state;
  }
  PadState pad() {
    PadState s;
    for (double* axis : {&s.left_right, &s.left_down, &s.right_right, &s.right_down})
      *axis = position();
    for (double* trigger : {&s.left_trigger, &s.right_trigger})
      *trigger = std::abs(position());
    for (bool* button : {&s.left_shoulder, &s.right_shoulder, &s.a, &s.b, &s.x, &s.y, &s.back, &s.start, &s.stick,
                         &s.up, &s.down, &s.left, &s.right}) {
      *button = held();
    }
    return s;
  }

  static void expect_valid(const Command& command) { EXPECT_EQ(command, sanitised(command)); }

  std::mt19937_64 random_{11};
};

/// Roll, yaw and y change sign in the mirror.
Vec6 mirrored(const Vec6& axes) {
  Vec6 result = axes;
  for (const int i : {1, 3, 5})
    result[i] = 0.0 - result[i];
  return result;
}

TEST_F(MappingTest, Av8rCommandsAreInRange) {
  for (int trial = 0; trial < kTrials; ++trial)
    expect_valid(av8r_command(av8r(), side()));
}

TEST_F(MappingTest, Av8rKeepsLeftAndRightApart) {
  for (int trial = 0; trial < kTrials; ++trial) {
    const Av8rState state = av8r();
    Av8rState mirror = state;
    for (const std::size_t i : {0U, 3U})
      mirror.axes[i] = -mirror.axes[i];
    mirror.hat_right = -mirror.hat_right;
    std::swap(mirror.axes[2], mirror.axes[4]);
    std::swap(mirror.buttons[1], mirror.buttons[2]);
    const Side before = side();
    const Side now = av8r_side(state, before);
    ASSERT_EQ(av8r_side(mirror, other(before)), other(now));
    const Command a = av8r_command(state, now);
    const Command b = av8r_command(mirror, other(now));
    EXPECT_EQ(b.axes, mirrored(a.axes));
    EXPECT_EQ(a.lift.left, b.lift.right);
    EXPECT_EQ(a.lift.right, b.lift.left);
    EXPECT_EQ(a.recall, b.recall);
    EXPECT_EQ(is_foot(a.guide), is_foot(b.guide));
    EXPECT_EQ(is_hand(a.guide), is_hand(b.guide));
    if (a.guide != Part::trunk) {
      EXPECT_EQ(side_of(a.guide), other(side_of(b.guide)));
    }
  }
}

TEST_F(MappingTest, Av8rSignsAreThoseOfTheTable) {
  for (int trial = 0; trial < kTrials; ++trial) {
    const Av8rState s = av8r();
    const Command c = av8r_command(s, Side::left);
    EXPECT_EQ(c.axes[0], s.hat_up);
    EXPECT_EQ(c.axes[1], -s.hat_right);
    EXPECT_EQ(c.axes[2], s.buttons[4] - s.buttons[5]);
    EXPECT_GE(c.axes[3] * s.axes[0], 0.0);
    EXPECT_LE(c.axes[4] * s.axes[1], 0.0);
    EXPECT_LE(c.axes[5] * s.axes[3], 0.0);
    const bool a = s.buttons[12];
    const bool b = s.buttons[13];
    EXPECT_EQ(c.guide, a == b ? Part::trunk : a ? Part::left_foot : Part::left_hand);
    EXPECT_EQ(c.recall, recall_of(s.buttons[0], s.buttons[6], s.buttons[7]));
  }
}

TEST_F(MappingTest, Av8rLeversLiftAsTheyGoForward) {
  for (const double forward : {-1.0, 1.0}) {
    Av8rMapping mapping;
    mapping.lever_forward = forward;
    Av8rState state;
    for (int trial = 0; trial < kTrials; ++trial) {
      const double a = position();
      const double b = position();
      state.axes[2] = forward * std::min(a, b);
      state.axes[4] = forward * std::max(a, b);
      const Command c = av8r_command(state, Side::left, mapping);
      EXPECT_LE(c.lift.left, c.lift.right);
    }
    state.axes[2] = -forward;
    state.axes[4] = forward;
    const Command c = av8r_command(state, Side::left, mapping);
    EXPECT_EQ(c.lift.left, 0.0);
    EXPECT_EQ(c.lift.right, 1.0);
  }
}

TEST_F(MappingTest, Av8rSideIsTheOneHeldLast) {
  Av8rState state;
  Side side = Side::left;
  const auto press = [&](bool launcher, bool main) {
    state.buttons[1] = launcher;
    state.buttons[2] = main;
    return side = av8r_side(state, side);
  };
  EXPECT_EQ(press(false, false), Side::left);
  EXPECT_EQ(press(false, true), Side::right);
  EXPECT_EQ(press(true, true), Side::right);
  EXPECT_EQ(press(false, false), Side::right);
  EXPECT_EQ(press(true, false), Side::left);
}

TEST_F(MappingTest, PadCommandsAreInRange) {
  for (int trial = 0; trial < kTrials; ++trial) {
    const PadState state = pad();
    const Part guide = part();
    const Command command = pad_command(state, guide);
    expect_valid(command);
    EXPECT_EQ(command.guide, guide);
  }
}

TEST_F(MappingTest, PadKeepsLeftAndRightApart) {
  for (int trial = 0; trial < kTrials; ++trial) {
    const PadState state = pad();
    PadState mirror = state;
    mirror.left_right = -mirror.left_right;
    mirror.right_right = -mirror.right_right;
    std::swap(mirror.left, mirror.right);
    std::swap(mirror.left_trigger, mirror.right_trigger);
    const Command a = pad_command(state, Part::trunk);
    const Command b = pad_command(mirror, Part::trunk);
    EXPECT_EQ(b.axes, mirrored(a.axes));
    EXPECT_EQ(a.lift.left, b.lift.right);
  }
}

TEST_F(MappingTest, PadSignsAreThoseOfTheTable) {
  for (int trial = 0; trial < kTrials; ++trial) {
    const PadState s = pad();
    const Command c = pad_command(s, Part::trunk);
    EXPECT_LE(c.axes[0] * s.left_down, 0.0);
    EXPECT_LE(c.axes[1] * s.left_right, 0.0);
    EXPECT_LE(c.axes[2] * s.right_down, 0.0);
    EXPECT_EQ(c.axes[3], s.right - s.left);
    EXPECT_EQ(c.axes[4], s.up - s.down);
    EXPECT_EQ(c.recall, recall_of(s.stick, s.back, s.start));
    EXPECT_LE(c.axes[5] * s.right_right, 0.0);
  }
}

TEST_F(MappingTest, PadGuidesThePartOfTheOneButtonPressed) {
  for (int trial = 0; trial < kTrials; ++trial) {
    const PadState s = pad();
    const Part before = part();
    const Part guide = pad_guide(s, before);
    if (s.a + s.b + s.x + s.y + s.right_shoulder != 1) {
      EXPECT_EQ(guide, before);
      continue;
    }
    EXPECT_EQ(guide, s.a   ? Part::trunk
                     : s.x ? Part::left_foot
                     : s.b ? Part::right_foot
                     : s.y ? Part::left_hand
                           : Part::right_hand);
  }
}

TEST_F(MappingTest, ArmedMeansAtRestOnceSinceItAppeared) {
  Arming arming;
  bool rested = false;  // since it appeared
  for (int trial = 0; trial < kTrials; ++trial) {
    const bool present = random_() % 8 != 0;
    const bool at_rest = held();
    rested = present && (rested || at_rest);
    const Arming::State state = arming.update(present, at_rest);
    EXPECT_EQ(state, !present ? Arming::State::absent : rested ? Arming::State::armed : Arming::State::waiting);
    EXPECT_EQ(arming.armed(), rested);
  }
}

}  // namespace
}  // namespace baton
