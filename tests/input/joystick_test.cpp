#include "baton/input/joystick.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <memory>
#include <random>

#include "baton/model/error.hpp"
#include "tests/input/virtual_joystick.hpp"

namespace baton {
namespace {

using test::VirtualAv8r;
using test::VirtualJoystick;
using test::VirtualPad;
using testing::HasSubstr;

class JoystickTest : public testing::Test {
 protected:
  Command read() { return joystick_->read(t_ += 0.01); }
  void with(const Joystick::Parameters& parameters) { joystick_ = std::make_unique<Joystick>(parameters); }

  test::SdlJoysticks sdl_;
  std::unique_ptr<Joystick> joystick_ = std::make_unique<Joystick>();
  double t_ = 0.0;
};

Command recall(Recall which) {
  Command c;
  c.recall = which;
  return c;
}

Command command(Part guide, std::initializer_list<double> axes, BySide<double> lift = {}) {
  Command c{guide, Vec6::Zero(), lift, Recall::none};
  std::copy(axes.begin(), axes.end(), c.axes.begin());
  return c;
}

TEST_F(JoystickTest, WithoutADeviceIsNeutralAndSaysSo) {
  EXPECT_EQ(read(), Command{});
  const DeviceStatus status = joystick_->status();
  EXPECT_FALSE(status.connected);
  EXPECT_FALSE(status.armed);
  EXPECT_EQ(status.name, "");
  EXPECT_THAT(status.hint, HasSubstr("Plug in"));
  EXPECT_TRUE(std::isinf(joystick_->age()));
}

TEST_F(JoystickTest, Av8rDrivesEveryPartOfACommand) {
  VirtualAv8r stick;
  EXPECT_EQ(read(), Command{});
  EXPECT_TRUE(joystick_->status().armed);
  EXPECT_EQ(joystick_->status().name, "Saitek Aviator (virtual)");
  EXPECT_EQ(joystick_->status().hint, "");

  stick.hat(SDL_HAT_LEFTUP);
  EXPECT_EQ(read(), command(Part::trunk, {1, 1, 0, 0, 0, 0}));
  stick.hat(SDL_HAT_RIGHTDOWN);
  stick.button(5, true);
  EXPECT_EQ(read(), command(Part::trunk, {-1, -1, -1, 0, 0, 0}));
  stick.hat(SDL_HAT_CENTERED);
  stick.button(5, false);
  stick.button(4, true);
  EXPECT_EQ(read(), command(Part::trunk, {0, 0, 1, 0, 0, 0}));
  stick.button(4, false);
  stick.axis(0, 1);
  stick.axis(1, -1);
  stick.axis(3, 1);
  EXPECT_EQ(read(), command(Part::trunk, {0, 0, 0, 1, 1, -1}));
  for (const int axis : {0, 1, 3})
    stick.axis(axis, 0.05);
  EXPECT_EQ(read(), Command{});

  stick.button(12, true);
  stick.axis(2, -1);
  EXPECT_EQ(read(), command(Part::left_foot, {}, {1, 0}));
  stick.button(2, true);
  stick.axis(4, -1);
  EXPECT_EQ(read(), command(Part::right_foot, {}, {1, 1}));
  stick.button(2, false);
  stick.button(12, false);
  stick.button(13, true);
  EXPECT_EQ(read().guide, Part::right_hand);
  stick.button(1, true);
  EXPECT_EQ(read().guide, Part::left_hand);
}

TEST_F(JoystickTest, AStickIsNeutralBeforeItIsArmed) {
  VirtualAv8r stick;
  stick.axis(1, -1.0);
  for (int i = 0; i < 10; ++i)
    EXPECT_EQ(read(), Command{});
  EXPECT_TRUE(joystick_->status().connected);
  EXPECT_FALSE(joystick_->status().armed);
  EXPECT_THAT(joystick_->status().hint, HasSubstr("Release"));
  stick.axis(1, 0.0);
  EXPECT_EQ(read(), Command{});
  EXPECT_TRUE(joystick_->status().armed);
  stick.axis(1, -1.0);
  EXPECT_EQ(read().axes[4], 1.0);
}

TEST_F(JoystickTest, Av8rGoesBackWhileT3OrT4AndStopsWhileTheTriggerIsHeld) {
  VirtualAv8r stick;
  stick.button(6, true);
  EXPECT_EQ(read(), Command{});
  EXPECT_FALSE(joystick_->status().armed) << "a switch that springs back has to be let go first";
  stick.button(6, false);
  read();
  EXPECT_TRUE(joystick_->status().armed);
  stick.button(6, true);
  EXPECT_EQ(read(), recall(Recall::retrace));
  stick.button(7, true);
  EXPECT_EQ(read(), recall(Recall::retrace)) << "of both, retrace wins";
  stick.button(6, false);
  EXPECT_EQ(read(), recall(Recall::home));
  stick.button(0, true);
  EXPECT_EQ(read(), recall(Recall::stop)) << "the trigger wins over both";
  stick.button(0, false);
  stick.button(7, false);
  EXPECT_EQ(read(), Command{});
}

TEST_F(JoystickTest, PadGoesBackOrStopsWhileItsButtonAndTheDeadManButtonAreHeld) {
  VirtualPad pad;
  pad.button(SDL_CONTROLLER_BUTTON_BACK, true);
  EXPECT_EQ(read(), Command{});
  EXPECT_FALSE(joystick_->status().armed);
  pad.button(SDL_CONTROLLER_BUTTON_BACK, false);
  read();
  ASSERT_TRUE(joystick_->status().armed);
  pad.button(SDL_CONTROLLER_BUTTON_BACK, true);
  EXPECT_EQ(read(), Command{}) << "not without the dead-man button";
  pad.button(SDL_CONTROLLER_BUTTON_LEFTSHOULDER, true);
  EXPECT_EQ(read(), recall(Recall::retrace));
  pad.button(SDL_CONTROLLER_BUTTON_START, true);
  EXPECT_EQ(read(), recall(Recall::retrace)) << "of both, retrace wins";
  pad.button(SDL_CONTROLLER_BUTTON_BACK, false);
  EXPECT_EQ(read(), recall(Recall::home));
  for (const auto pressed_in : {SDL_CONTROLLER_BUTTON_LEFTSTICK, SDL_CONTROLLER_BUTTON_RIGHTSTICK}) {
    pad.button(pressed_in, true);
    EXPECT_EQ(read(), recall(Recall::stop)) << "it wins over both";
    pad.button(pressed_in, false);
  }
  pad.button(SDL_CONTROLLER_BUTTON_LEFTSHOULDER, false);
  EXPECT_EQ(read(), Command{});
}

TEST_F(JoystickTest, ALeverCountsFromWhenItWasPulledBack) {
  VirtualAv8r stick;
  stick.axis(4, 0.0);  // half way, as it was left
  EXPECT_EQ(read(), Command{});
  EXPECT_TRUE(joystick_->status().armed);
  stick.axis(4, -1.0);
  EXPECT_EQ(read().lift.right, 0.0);
  stick.axis(4, 1.0);
  EXPECT_EQ(read().lift.right, 0.0);
  stick.axis(4, -1.0);
  EXPECT_EQ(read().lift.right, 1.0);
}

TEST_F(JoystickTest, PulledOutItIsNeutralAndBackInItMustBeNeutralFirst) {
  VirtualAv8r stick;
  stick.button(13, true);
  read();
  stick.axis(0, 1.0);
  EXPECT_EQ(read(), command(Part::left_hand, {0, 0, 0, 1, 0, 0}));
  stick.unplug();
  for (int i = 0; i < 3; ++i)
    EXPECT_EQ(read(), command(Part::left_hand, {}));  // the part guided last
  EXPECT_FALSE(joystick_->status().connected);

  VirtualAv8r again;
  again.axis(0, 1.0);
  for (int i = 0; i < 3; ++i)
    EXPECT_EQ(read(), command(Part::left_hand, {}));
  EXPECT_TRUE(joystick_->status().connected);
  EXPECT_FALSE(joystick_->status().armed);
  again.axis(0, 0.0);
  EXPECT_EQ(read(), command(Part::trunk, {}));
  again.axis(0, -1.0);
  EXPECT_EQ(read(), command(Part::trunk, {0, 0, 0, -1, 0, 0}));
}

TEST_F(JoystickTest, PulledOutAndInBetweenTwoReadsItIsNotArmed) {
  auto stick = std::make_unique<VirtualAv8r>();
  read();
  ASSERT_TRUE(joystick_->status().armed);
  stick = nullptr;
  VirtualAv8r again;
  again.axis(0, 1.0);
  EXPECT_EQ(read(), Command{});
  EXPECT_FALSE(joystick_->status().armed);
}

TEST_F(JoystickTest, OfTwoDevicesTheFirstIsKeptUntilItGoes) {
  VirtualAv8r first;
  read();
  VirtualPad second;
  second.axis(SDL_CONTROLLER_AXIS_LEFTX, 1.0);
  second.button(SDL_CONTROLLER_BUTTON_LEFTSHOULDER, true);
  EXPECT_EQ(read(), Command{});
  first.axis(0, 1.0);
  EXPECT_EQ(read().axes[3], 1.0);
  first.unplug();
  EXPECT_EQ(read(), Command{});
  EXPECT_EQ(joystick_->status().name, "Pad (virtual)");
  EXPECT_FALSE(joystick_->status().armed);
  second.axis(SDL_CONTROLLER_AXIS_LEFTX, 0.0);
  read();
  second.axis(SDL_CONTROLLER_AXIS_LEFTX, 1.0);
  EXPECT_EQ(read(), command(Part::trunk, {0, -1, 0, 0, 0, 0}));
}

TEST_F(JoystickTest, PadMovesOnlyWhileTheDeadManButtonIsHeld) {
  VirtualPad pad;
  pad.axis(SDL_CONTROLLER_AXIS_LEFTY, -1.0);
  EXPECT_EQ(read(), Command{});
  EXPECT_FALSE(joystick_->status().armed);  // the released button is no neutral stick
  pad.axis(SDL_CONTROLLER_AXIS_LEFTY, 0.0);
  EXPECT_EQ(read(), Command{});
  EXPECT_TRUE(joystick_->status().armed);
  EXPECT_THAT(joystick_->status().hint, HasSubstr("left shoulder"));
  pad.axis(SDL_CONTROLLER_AXIS_LEFTY, -1.0);
  pad.button(SDL_CONTROLLER_BUTTON_X, true);
  EXPECT_EQ(read(), command(Part::left_foot, {}));  // the choice of part moves nothing
  pad.button(SDL_CONTROLLER_BUTTON_X, false);
  pad.button(SDL_CONTROLLER_BUTTON_LEFTSHOULDER, true);
  pad.axis(SDL_CONTROLLER_AXIS_TRIGGERLEFT, 1.0);
  EXPECT_EQ(read(), command(Part::left_foot, {1, 0, 0, 0, 0, 0}, {1, 0}));
  EXPECT_EQ(joystick_->status().hint, "");
  pad.button(SDL_CONTROLLER_BUTTON_LEFTSHOULDER, false);
  EXPECT_EQ(read(), command(Part::left_foot, {}));
  pad.button(SDL_CONTROLLER_BUTTON_LEFTSHOULDER, true);
  EXPECT_EQ(read().axes[0], 1.0);
}

TEST_F(JoystickTest, PadDrivesEveryPartOfACommand) {
  with({.dead_man = false});
  VirtualPad pad;
  EXPECT_EQ(read(), Command{});
  pad.axis(SDL_CONTROLLER_AXIS_LEFTX, -1.0);
  pad.axis(SDL_CONTROLLER_AXIS_RIGHTX, -1.0);
  pad.axis(SDL_CONTROLLER_AXIS_RIGHTY, -1.0);
  pad.axis(SDL_CONTROLLER_AXIS_TRIGGERRIGHT, 1.0);
  pad.button(SDL_CONTROLLER_BUTTON_DPAD_RIGHT, true);
  pad.button(SDL_CONTROLLER_BUTTON_DPAD_UP, true);
  pad.button(SDL_CONTROLLER_BUTTON_RIGHTSHOULDER, true);
  EXPECT_EQ(read(), command(Part::right_hand, {0, 1, 1, 1, 1, 1}, {0, 1}));
}

TEST_F(JoystickTest, AStickOfTheSameLayoutIsTakenAndAnyOtherIsNot) {
  SDL_VirtualJoystickDesc d{};
  d.type = SDL_JOYSTICK_TYPE_FLIGHT_STICK;
  d.naxes = 4;
  d.nbuttons = 12;
  d.nhats = 1;
  d.name = "Wheel";
  const VirtualJoystick wheel(d);
  for (int i = 0; i < 2; ++i) {
    EXPECT_EQ(read(), Command{});
    EXPECT_FALSE(joystick_->status().connected);
    EXPECT_THAT(joystick_->status().hint, HasSubstr("Wheel"));
  }
  d.naxes = 6;
  d.nbuttons = 16;
  d.name = "Other stick";
  VirtualJoystick stick(d);
  stick.axis(2, 1.0);
  stick.axis(4, 1.0);
  read();
  EXPECT_TRUE(joystick_->status().armed);
  EXPECT_EQ(joystick_->status().name, "Other stick");
}

TEST_F(JoystickTest, AStickThatIsHeldStaysInForce) {
  VirtualAv8r stick;
  read();
  stick.hat(SDL_HAT_UP);
  read();
  EXPECT_EQ(joystick_->age(), 0.0);
  EXPECT_EQ(joystick_->read(t_ + 1000.0).axes[0], 1.0);
  EXPECT_DOUBLE_EQ(joystick_->age(), 1000.0);
}

TEST_F(JoystickTest, SilentForTooLongItCountsAsLost) {
  with({.max_age = 2.0});
  VirtualAv8r stick;
  EXPECT_EQ(joystick_->read(0.0), Command{});
  EXPECT_TRUE(joystick_->status().armed);
  EXPECT_EQ(joystick_->read(100.0), Command{});
  EXPECT_TRUE(joystick_->status().armed);  // at rest there is nothing to lose
  stick.hat(SDL_HAT_UP);
  EXPECT_EQ(joystick_->read(101.0).axes[0], 1.0);
  EXPECT_EQ(joystick_->read(103.0).axes[0], 1.0);
  EXPECT_EQ(joystick_->read(103.01), Command{});
  EXPECT_FALSE(joystick_->status().connected);
  EXPECT_THAT(joystick_->status().hint, HasSubstr("Silent"));
  stick.hat(SDL_HAT_LEFT);
  EXPECT_EQ(joystick_->read(104.0), Command{});  // alive, but not neutral
  stick.hat(SDL_HAT_CENTERED);
  EXPECT_EQ(joystick_->read(105.0), Command{});
  stick.hat(SDL_HAT_LEFT);
  EXPECT_EQ(joystick_->read(106.0).axes[1], 1.0);
}

TEST_F(JoystickTest, WhateverIsMovedCommandsAreInRangeAndNeutralUntilArmed) {
  std::mt19937_64 random(5);
  std::unique_ptr<VirtualAv8r> stick;
  for (int i = 0; i < 5000; ++i) {
    if (random() % 100 == 0) stick = stick ? nullptr : std::make_unique<VirtualAv8r>();
    if (stick) {
      const bool let_go = random() % 10 == 0;
      for (int axis = 0; axis < 5; ++axis) {
        const bool lever = axis == 2 || axis == 4;
        const double raw = std::uniform_real_distribution<double>(-1.0, 1.0)(random);
        stick->axis(axis, let_go ? (lever ? 1.0 : 0.0) : raw);
      }
      for (int button = 0; button < 14; ++button)
        stick->button(button, !let_go && random() % 2 == 0);
      stick->hat(let_go ? SDL_HAT_CENTERED : static_cast<Uint8>(random() % 16));
    }
    const Command c = read();
    ASSERT_EQ(c, sanitised(c));
    const DeviceStatus status = joystick_->status();
    ASSERT_EQ(status.connected, stick != nullptr);
    if (!status.armed) {
      ASSERT_TRUE(c.neutral());
      ASSERT_FALSE(status.hint.empty());
    }
  }
}

TEST(Joystick, RefusesParametersOutOfRange) {
  EXPECT_THROW(Joystick({.max_age = 0.0}), InputError);
  EXPECT_THROW(Joystick({.max_age = std::nan("")}), InputError);
  Joystick::Parameters half;
  half.av8r.lever_forward = 0.5;
  EXPECT_THROW(Joystick{half}, InputError);
}

TEST(Joystick, StartsAndEndsManyTimes) {
  for (int i = 0; i < 3; ++i) {
    Joystick joystick;
    EXPECT_EQ(joystick.read(0.0), Command{});
  }
}

}  // namespace
}  // namespace baton
