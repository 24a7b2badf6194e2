/// Virtual joysticks of SDL, which live in the process of the test.
#pragma once

#include <SDL.h>
#include <gtest/gtest.h>

#include <cstdlib>
#include <functional>
#include <memory>
#include <utility>

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
  VirtualAv8r() : VirtualAv8r(description()) {}

 protected:
  explicit VirtualAv8r(const SDL_VirtualJoystickDesc& d) : VirtualJoystick(d) {
    axis(2, 1.0);
    axis(4, 1.0);
  }

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

/// An AV8R with hands on it: SDL calls them at each look of the program, so that what they do depends on nothing but
/// the number of looks.
class HeldAv8r : public VirtualAv8r {
 public:
  using Hands = std::function<void(HeldAv8r&, int look)>;
  explicit HeldAv8r(Hands hands) : HeldAv8r(std::make_unique<Grip>(Grip{std::move(hands), nullptr, 0})) {}
  ~HeldAv8r() { unplug(); }

 private:
  /// What SDL hands back to us: made before the stick, which SDL may look at while it is made.
  struct Grip {
    Hands hands;
    HeldAv8r* stick;
    int looks;
  };
  explicit HeldAv8r(std::unique_ptr<Grip> grip) : VirtualAv8r(held(grip.get())), grip_(std::move(grip)) {
    grip_->stick = this;
  }
  static SDL_VirtualJoystickDesc held(Grip* grip) {
    SDL_VirtualJoystickDesc d = description();
    d.userdata = grip;
    d.Update = [](void* data) {
      auto& held = *static_cast<Grip*>(data);
      if (held.stick != nullptr) held.hands(*held.stick, held.looks++);
    };
    return d;
  }

  std::unique_ptr<Grip> grip_;
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
