#include "baton/input/joystick.hpp"

#include <SDL.h>
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <utility>
#include <vector>

#include "baton/model/error.hpp"

namespace baton {
namespace {

constexpr Uint32 kSubsystems = SDL_INIT_JOYSTICK | SDL_INIT_GAMECONTROLLER;
constexpr Uint16 kSaitek = 0x06a3;
constexpr Uint16 kAv8r = 0x0461;

struct Close {
  void operator()(SDL_Joystick* joystick) const { SDL_JoystickClose(joystick); }
  void operator()(SDL_GameController* pad) const { SDL_GameControllerClose(pad); }
};
using StickPtr = std::unique_ptr<SDL_Joystick, Close>;
using PadPtr = std::unique_ptr<SDL_GameController, Close>;

double unit(Sint16 raw) {
  return raw < 0 ? raw / 32768.0 : raw / 32767.0;
}

std::string text(const char* name) {
  return name != nullptr && *name != '\0' ? name : "unnamed device";
}

bool has_av8r_layout(SDL_Joystick* stick) {
  return SDL_JoystickNumAxes(stick) >= Av8rState::kAxes && SDL_JoystickNumHats(stick) >= 1 &&
         SDL_JoystickNumButtons(stick) >= Av8rState::kButtons;
}

Av8rState av8r_state(SDL_Joystick* stick) {
  Av8rState state;
  for (int i = 0; i < Av8rState::kAxes; ++i)
    state.axes[i] = unit(SDL_JoystickGetAxis(stick, i));
  for (int i = 0; i < Av8rState::kButtons; ++i)
    state.buttons[i] = SDL_JoystickGetButton(stick, i) != 0;
  const Uint8 hat = SDL_JoystickGetHat(stick, 0);
  const auto pressed = [hat](Uint8 direction) { return (hat & direction) != 0 ? 1 : 0; };
  state.hat_right = pressed(SDL_HAT_RIGHT) - pressed(SDL_HAT_LEFT);
  state.hat_up = pressed(SDL_HAT_UP) - pressed(SDL_HAT_DOWN);
  return state;
}

PadState pad_state(SDL_GameController* pad) {
  const auto axis = [pad](SDL_GameControllerAxis which) { return unit(SDL_GameControllerGetAxis(pad, which)); };
  const auto held = [pad](SDL_GameControllerButton which) { return SDL_GameControllerGetButton(pad, which) != 0; };
  return {.left_right = axis(SDL_CONTROLLER_AXIS_LEFTX),
          .left_down = axis(SDL_CONTROLLER_AXIS_LEFTY),
          .right_right = axis(SDL_CONTROLLER_AXIS_RIGHTX),
          .right_down = axis(SDL_CONTROLLER_AXIS_RIGHTY),
          .left_trigger = axis(SDL_CONTROLLER_AXIS_TRIGGERLEFT),
          .right_trigger = axis(SDL_CONTROLLER_AXIS_TRIGGERRIGHT),
          .left_shoulder = held(SDL_CONTROLLER_BUTTON_LEFTSHOULDER),
          .right_shoulder = held(SDL_CONTROLLER_BUTTON_RIGHTSHOULDER),
          .a = held(SDL_CONTROLLER_BUTTON_A),
          .b = held(SDL_CONTROLLER_BUTTON_B),
          .x = held(SDL_CONTROLLER_BUTTON_X),
          .y = held(SDL_CONTROLLER_BUTTON_Y),
          .back = held(SDL_CONTROLLER_BUTTON_BACK),
          .start = held(SDL_CONTROLLER_BUTTON_START),
          .stick = held(SDL_CONTROLLER_BUTTON_LEFTSTICK) || held(SDL_CONTROLLER_BUTTON_RIGHTSTICK),
          .up = held(SDL_CONTROLLER_BUTTON_DPAD_UP),
          .down = held(SDL_CONTROLLER_BUTTON_DPAD_DOWN),
          .left = held(SDL_CONTROLLER_BUTTON_DPAD_LEFT),
          .right = held(SDL_CONTROLLER_BUTTON_DPAD_RIGHT)};
}

Command neutral(Part guide) {
  Command command;
  command.guide = guide;
  return command;
}

}  // namespace

/// An open device: exactly one member is set.
struct Joystick::Handle {
  StickPtr stick;
  PadPtr pad;

  [[nodiscard]] SDL_Joystick* joystick() const { return pad ? SDL_GameControllerGetJoystick(pad.get()) : stick.get(); }
};

Joystick::Joystick(const Parameters& parameters) : parameters_(parameters) {
  if (!(parameters.max_age > 0.0)) {
    throw InputError(fmt::format("joystick: max_age = {}: must be more than 0 s", parameters.max_age));
  }
  if (std::abs(parameters.av8r.lever_forward) != 1.0) {
    throw InputError(fmt::format("joystick: lever_forward = {}: must be -1 or 1", parameters.av8r.lever_forward));
  }
  SDL_SetHint(SDL_HINT_NO_SIGNAL_HANDLERS, "1");
  SDL_SetHint(SDL_HINT_JOYSTICK_ALLOW_BACKGROUND_EVENTS, "1");
  if (SDL_InitSubSystem(kSubsystems) != 0) {
    throw std::runtime_error(fmt::format("joystick: SDL cannot start: {}", SDL_GetError()));
  }
}

Joystick::~Joystick() {
  handle_.reset();
  SDL_QuitSubSystem(kSubsystems);
}

Command Joystick::read(double t) {
  now_ = t;
  SDL_JoystickUpdate();
  // Positions are polled; flush the event queue, which nobody else reads.
  SDL_FlushEvents(SDL_JOYAXISMOTION, SDL_CONTROLLERSENSORUPDATE);
  if (handle_ && SDL_JoystickGetAttached(handle_->joystick()) == SDL_FALSE) {
    handle_.reset();
    controls_ = {};
    lever_known_ = {};
    arming_.update(false, false);
  }
  if (!handle_) find();

  const Controls newest = controls();
  if (newest != controls_) {
    controls_ = newest;
    changed_ = t;
  }
  Command command = command_of(controls_);
  if (std::holds_alternative<Av8rState>(controls_)) {
    // A lever does not spring back: it counts once it has been pulled back.
    for (const Side side : kSides) {
      lever_known_[side] = lever_known_[side] || command.lift[side] == 0.0;
      if (!lever_known_[side]) command.lift[side] = 0.0;
    }
  }
  const bool rests = controls_released(command);
  arming_.update(handle_ && (rests || age() <= parameters_.max_age), rests);
  if (!arming_.armed()) return neutral(guide_);
  guide_ = command.guide;
  return dead_man_released() ? neutral(guide_) : command;
}

DeviceStatus Joystick::status() const {
  DeviceStatus status;
  status.connected = arming_.state() != Arming::State::absent;
  status.armed = arming_.armed();
  if (handle_) status.name = text(SDL_JoystickName(handle_->joystick()));
  switch (arming_.state()) {
    case Arming::State::absent:
      if (handle_) {
        status.hint = fmt::format("Silent for more than {} s: release all controls.", parameters_.max_age);
      } else if (!refused_name_.empty()) {
        status.hint = fmt::format("{} is neither an AV8R nor a pad known to SDL: plug in one.", refused_name_);
      } else {
        status.hint = "Plug in a joystick or a pad.";
      }
      break;
    case Arming::State::waiting:
      status.hint = std::holds_alternative<PadState>(controls_) ? "Release all controls, triggers included."
                                                                : "Release stick and switches.";
      break;
    case Arming::State::armed:
      if (dead_man_released()) status.hint = "Hold the left shoulder button to move.";
      break;
  }
  return status;
}

double Joystick::age() const {
  return handle_ ? now_ - changed_ : std::numeric_limits<double>::infinity();
}

void Joystick::find() {
  refused_name_.clear();
  const int count = SDL_NumJoysticks();
  for (int i = 0; i < count && !handle_; ++i) {
    const SDL_JoystickID id = SDL_JoystickGetDeviceInstanceID(i);
    if (std::find(refused_.begin(), refused_.end(), id) != refused_.end()) {
      refused_name_ = text(SDL_JoystickNameForIndex(i));
      continue;
    }
    const bool named = SDL_JoystickGetDeviceVendor(i) == kSaitek && SDL_JoystickGetDeviceProduct(i) == kAv8r;
    Handle found;
    if (!named && SDL_IsGameController(i) == SDL_TRUE) {
      found.pad.reset(SDL_GameControllerOpen(i));
    } else {
      found.stick.reset(SDL_JoystickOpen(i));
    }
    if (!found.joystick()) continue;
    if (found.pad || has_av8r_layout(found.stick.get())) {
      handle_ = std::make_unique<Handle>(std::move(found));
    } else {
      refused_.push_back(id);
      refused_name_ = text(SDL_JoystickNameForIndex(i));
    }
  }
}

Joystick::Controls Joystick::controls() const {
  if (!handle_) return {};
  if (handle_->pad) return pad_state(handle_->pad.get());
  return av8r_state(handle_->stick.get());
}

Command Joystick::command_of(const Controls& controls) {
  if (const auto* av8r = std::get_if<Av8rState>(&controls)) {
    side_ = av8r_side(*av8r, side_);
    return av8r_command(*av8r, side_, parameters_.av8r);
  }
  if (const auto* pad = std::get_if<PadState>(&controls)) {
    return pad_command(*pad, pad_guide(*pad, guide_), parameters_.pad);
  }
  return neutral(guide_);
}

bool Joystick::dead_man_released() const {
  const auto* pad = std::get_if<PadState>(&controls_);
  return parameters_.dead_man && pad != nullptr && !pad->left_shoulder;
}

}  // namespace baton
