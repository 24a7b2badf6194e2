/// The messages between server and page (docs/page.md): JSON texts on a WebSocket.
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>
#include <string_view>
#include <variant>

#include "baton/cockpit/frame.hpp"
#include "baton/model/robot_model.hpp"

namespace baton {

/// A page asks for the driver's seat, or gives it back.
struct TakeSeat {};
struct LeaveSeat {};
/// A page moves the stick.
struct Steer {
  Command command;  ///< as it came: perhaps out of range, perhaps not a number
  bool deadman = false;
};
/// A message that is none; says why, for the one who wrote the page.
struct Malformed {
  std::string why;
};
using PageMessage = std::variant<TakeSeat, LeaveSeat, Steer, Malformed>;

inline constexpr std::size_t kLargestMessage = 4096;  ///< [bytes] from a page

/// Never throws on whatever text.
[[nodiscard]] PageMessage parse_page_message(std::string_view text);

/// A page's standing towards the driver's seat.
enum class Role { driver, watcher };

/// The `state` message; `device`: the one that this page is told about; `taken`: whether any page drives.
[[nodiscard]] std::string state_message(const Frame& frame, const DeviceStatus& device, const RobotModel& robot,
                                        Role role, bool taken);

/// The `error` message.
[[nodiscard]] std::string error_message(std::string_view text);

}  // namespace baton
