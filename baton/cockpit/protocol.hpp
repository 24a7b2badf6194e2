/// Messages between server and page (docs/page.md): JSON over WebSocket.
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>
#include <string_view>
#include <variant>

#include "baton/cockpit/frame.hpp"
#include "baton/model/robot_model.hpp"

namespace baton {

/// A page requests or releases the driver's seat.
struct TakeSeat {};
struct LeaveSeat {};
/// A page lets the motors only brake.
struct AskDamp {};
/// A page moves the stick.
struct Steer {
  Command command;  ///< unchecked: may be out of range or NaN
  bool deadman = false;
};
/// An invalid message, and why, for the author of the page.
struct Malformed {
  std::string why;
};
using PageMessage = std::variant<TakeSeat, LeaveSeat, AskDamp, Steer, Malformed>;

inline constexpr std::size_t kLargestMessage = 4096;  ///< longest message from a page [bytes]

/// Accepts any text; never throws.
[[nodiscard]] PageMessage parse_page_message(std::string_view text);

/// Whether a page holds the driver's seat.
enum class Role { driver, watcher };

/// The `state` message. `device`: the device shown on this page; `taken`: whether any page drives.
[[nodiscard]] std::string state_message(const Frame& frame, const DeviceStatus& device, const RobotModel& robot,
                                        Role role, bool taken);

/// The `error` message.
[[nodiscard]] std::string error_message(std::string_view text);

}  // namespace baton
