/// Virtual joysticks of SDL, which live in the process of the test.
#pragma once

#include <SDL.h>
#include <gtest/gtest.h>

#include <cstdlib>

namespace baton::test {

/// Keeps SDL's joysticks alive without a display.
class SdlJoysticks {
 public:
  SdlJoysticks() {
    setenv("SDL_VIDEODRIVER", "dummy", 1);
    SDL_SetHint(SDL_HINT_NO_SIGNAL_HANDLERS, "1");
    EXPECT_EQ(SDL_InitSubSystem(SDL_INIT_JOYSTICK | SDL_INIT_GAMECONTROLLER), 0) << SDL_GetError();
  }
  ~SdlJoysticks() { SDL_QuitSubSystem(SDL_INIT_JOYSTICK | SDL_INIT_GAMECONTROLLER); }
  SdlJoysticks(const SdlJoysticks&) = delete;
  SdlJoysticks& operator=(const SdlJoysticks&) = delete;
};

/// Plugged in from construction until `unplug` or destruction. What is set is seen after the next update of
/// SDL.
class VirtualJoystick {
 public:
  explicit VirtualJoystick(SDL_VirtualJoystickDesc description) {
    description.version = SDL_VIRTUAL_JOYSTICK_DESC_VERSION;
    const int index = SDL_JoystickAttachVirtualEx(&description);
    EXPECT_GE(index, 0) << SDL_GetError();
    stick_ = SDL_JoystickOpen(index);
    EXPECT_NE(stick_, nullptr) << SDL_GetError();
  }
  ~VirtualJoystick() { unplug(); }
  VirtualJoystick(const VirtualJoystick&) = delete;
  VirtualJoystick& operator=(const VirtualJoystick&) = delete;

  void unplug() {
    if (stick_ == nullptr) return;
    const SDL_JoystickID id = SDL_JoystickInstanceID(stick_);
    SDL_JoystickClose(stick_);
    stick_ = nullptr;
    for (int i = 0; i < SDL_NumJoysticks(); ++i) {
      if (SDL_JoystickGetDeviceInstanceID(i) == id) {
        SDL_JoystickDetachVirtual(i);
        return;
      }
    }
  }

  /// `value` in −1…1.
  void axis(int which, double value) {
    SDL_JoystickSetVirtualAxis(stick_, which, static_cast<Sint16>(value * (value < 0.0 ? 32768.0 : 32767.0)));
  }
  void button(int which, bool held) {
    SDL_JoystickSetVirtualButton(stick_, which, static_cast<Uint8>(held ? SDL_PRESSED : SDL_RELEASED));
  }
  void hat(Uint8 direction) { SDL_JoystickSetVirtualHat(stick_, 0, direction); }

 private:
  SDL_Joystick* stick_ = nullptr;
};

/// An AV8R at rest: both levers pulled back.
class VirtualAv8r : public VirtualJoystick {
 public:
  VirtualAv8r() : VirtualJoystick(description()) {
    axis(2, 1.0);
    axis(4, 1.0);
  }

 private:
  static SDL_VirtualJoystickDesc description() {
    SDL_VirtualJoystickDesc d{};
    d.type = SDL_JOYSTICK_TYPE_FLIGHT_STICK;
    d.naxes = 5;
    d.nbuttons = 14;
    d.nhats = 1;
    d.vendor_id = 0x06a3;
    d.product_id = 0x0461;
    d.name = "Saitek Aviator (virtual)";
    return d;
  }
};

/// A pad at rest; its axes and buttons are SDL_GameControllerAxis and SDL_GameControllerButton.
class VirtualPad : public VirtualJoystick {
 public:
  VirtualPad() : VirtualJoystick(description()) {
    axis(SDL_CONTROLLER_AXIS_TRIGGERLEFT, -1.0);
    axis(SDL_CONTROLLER_AXIS_TRIGGERRIGHT, -1.0);
  }

 private:
  static SDL_VirtualJoystickDesc description() {
    SDL_VirtualJoystickDesc d{};
    d.type = SDL_JOYSTICK_TYPE_GAMECONTROLLER;
    d.naxes = SDL_CONTROLLER_AXIS_MAX;
    d.nbuttons = SDL_CONTROLLER_BUTTON_MAX;
    d.name = "Pad (virtual)";
    return d;
  }
};

}  // namespace baton::test
