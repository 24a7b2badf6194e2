/// Nobody asks for more: however the signal of a device ends, the robot comes to rest on its feet and stays there.
#include <gtest/gtest.h>

#include <functional>
#include <limits>
#include <optional>

#include "baton/cockpit/page_device.hpp"
#include "baton/input/joystick.hpp"
#include "baton/model/world.hpp"
#include "baton/run/simulation.hpp"
#include "tests/input/virtual_joystick.hpp"
#include "tests/support/robots.hpp"

namespace baton {
namespace {

class NoSignal : public testing::Test {
 protected:
  /// A tick with what the device says.
  void step(Device& device) { session_.step(device); }
  void steps(Device& device, double seconds) {
    for (const double end = session_.t() + seconds; session_.t() < end;)
      step(device);
  }
  [[nodiscard]] BySide<bool> contact() const { return session_.navigator().sample().contact; }

  /// In the middle of a motion.
  void expect_moving(Device& device) {
    for (int k = 0; k < 400 && session_.resting(); ++k)
      step(device);
    steps(device, 0.1);
    EXPECT_FALSE(session_.resting());
  }
  void expect_foot_up(Device& device) {
    steps(device, 3.0);
    EXPECT_TRUE(session_.resting());
    EXPECT_FALSE(contact().left);
  }
  void expect_rest_on_both_feet(Device& device) {
    steps(device, 5.0);
    EXPECT_TRUE(session_.resting());
    EXPECT_TRUE(contact().left && contact().right);
    EXPECT_TRUE(session_.navigator().command().neutral());
    const long committed = session_.navigator().committed();
    steps(device, 1.0);
    EXPECT_EQ(session_.navigator().committed(), committed);
  }

  World world_ = World::load("flat");
  Simulation simulation_{test::robot("mighty"), world_, Simulation::On::ideal};
  Session& session_ = simulation_.session();
};

TEST_F(NoSignal, AJoystickPulledOut) {
  const test::SdlJoysticks sdl;
  Joystick joystick;
  std::optional<test::VirtualAv8r> stick(std::in_place);
  step(joystick);
  stick->hat(SDL_HAT_UP);
  expect_moving(joystick);
  stick->unplug();
  expect_rest_on_both_feet(joystick);

  stick.emplace();
  stick->button(12, true);  // guides a foot
  step(joystick);
  stick->axis(2, -1.0);
  expect_foot_up(joystick);
  stick->unplug();
  expect_rest_on_both_feet(joystick);
}

TEST_F(NoSignal, APadWhoseDeadManButtonIsReleased) {
  const test::SdlJoysticks sdl;
  Joystick joystick;
  test::VirtualPad pad;
  step(joystick);
  pad.button(SDL_CONTROLLER_BUTTON_LEFTSHOULDER, true);
  pad.axis(SDL_CONTROLLER_AXIS_LEFTY, -1.0);
  expect_moving(joystick);
  pad.button(SDL_CONTROLLER_BUTTON_LEFTSHOULDER, false);
  expect_rest_on_both_feet(joystick);

  pad.axis(SDL_CONTROLLER_AXIS_LEFTY, 0.0);
  pad.button(SDL_CONTROLLER_BUTTON_X, true);
  pad.button(SDL_CONTROLLER_BUTTON_LEFTSHOULDER, true);
  pad.axis(SDL_CONTROLLER_AXIS_TRIGGERLEFT, 1.0);
  expect_foot_up(joystick);
  pad.button(SDL_CONTROLLER_BUTTON_LEFTSHOULDER, false);
  expect_rest_on_both_feet(joystick);
}

TEST_F(NoSignal, APageThatIsSilentOrClosedOrBroken) {
  constexpr PageDevice::Page kPage = 1;
  double now = 0.0;
  PageDevice page([&now] { return now; });
  const Command forward{.axes = (Vec6() << 1, 0, 0, 0, 0, 0).finished()};
  const Command lifted{.guide = Part::left_foot, .lift = {1.0, 0.0}};
  Command broken = lifted;
  broken.axes.setConstant(std::numeric_limits<double>::quiet_NaN());
  broken.lift = {std::numeric_limits<double>::quiet_NaN(), std::numeric_limits<double>::quiet_NaN()};
  const std::function<void()> silent = [&] { now += 0.3; };
  const std::function<void()> closed = [&] { page.release(kPage); };
  const std::function<void()> sends_no_numbers = [&] { page.give(kPage, broken, true); };
  for (const auto& end : {silent, closed, sends_no_numbers}) {
    for (const Command& command : {forward, lifted}) {
      page.take(kPage);
      page.give(kPage, {}, true);
      step(page);
      page.give(kPage, command, true);
      if (command == forward)
        expect_moving(page);
      else
        expect_foot_up(page);
      end();
      expect_rest_on_both_feet(page);
    }
  }
}

}  // namespace
}  // namespace baton
