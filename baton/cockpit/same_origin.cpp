#include "baton/cockpit/same_origin.hpp"

#include <algorithm>
#include <array>
#include <cctype>

namespace baton {
namespace {

char lower(char c) {
  return static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
}
bool is_digit(char c) {
  return c >= '0' && c <= '9';
}

bool equal_ignoring_case(std::string_view a, std::string_view b) {
  return std::equal(a.begin(), a.end(), b.begin(), b.end(), [](char x, char y) { return lower(x) == lower(y); });
}

}  // namespace

bool is_loopback_host(std::string_view host) {
  constexpr std::array<std::string_view, 3> names{"127.0.0.1", "localhost", "[::1]"};
  return std::any_of(names.begin(), names.end(), [host](std::string_view name) {
    if (!equal_ignoring_case(host.substr(0, name.size()), name)) return false;
    const std::string_view port = host.substr(name.size());
    if (port.empty()) return true;
    return port.size() >= 2 && port.size() <= 6 && port.front() == ':' &&
           std::all_of(port.begin() + 1, port.end(), is_digit);
  });
}

bool is_same_origin(std::string_view host, std::optional<std::string_view> origin) {
  constexpr std::string_view scheme = "http://";
  if (!is_loopback_host(host)) return false;
  if (!origin) return true;
  return equal_ignoring_case(origin->substr(0, scheme.size()), scheme) &&
         equal_ignoring_case(origin->substr(std::min(scheme.size(), origin->size())), host);
}

}  // namespace baton
