/// Access control of the page's server: only programs and pages of this machine.
#pragma once

#include <optional>
#include <string_view>

namespace baton {

/// Whether a Host header names this machine: 127.0.0.1, localhost or [::1], with or without a port (a tunnel changes
/// the port). Rejects foreign names that resolve to this machine (DNS rebinding).
[[nodiscard]] bool is_loopback_host(std::string_view host);

/// Whether a request is allowed: its Host is this machine, and its Origin, if present, is the page served there.
[[nodiscard]] bool is_same_origin(std::string_view host, std::optional<std::string_view> origin);

}  // namespace baton
