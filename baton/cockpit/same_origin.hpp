/// Who may talk to the page's server: programs and pages of this machine that address it as such.
#pragma once

#include <optional>
#include <string_view>

namespace baton {

/// Whether a request's Host is this machine: 127.0.0.1, localhost or [::1], with any port or none (a tunnel
/// changes the port). A foreign name that resolves to this machine (DNS rebinding) is not.
[[nodiscard]] bool is_loopback_host(std::string_view host);

/// Whether a request may be answered: its Host is this machine, and its Origin, where a browser names one, is
/// the page that this Host serves.
[[nodiscard]] bool is_same_origin(std::string_view host, std::optional<std::string_view> origin);

}  // namespace baton
