#include "baton/input/typed_lines.hpp"

#include <poll.h>
#include <unistd.h>

#include <array>

namespace baton {
namespace {

constexpr std::size_t kMostTyped = 4096;

}  // namespace

std::optional<std::string> TypedLines::next() {
  pollfd input{STDIN_FILENO, POLLIN, 0};
  if (open_ && typed_.size() < kMostTyped && poll(&input, 1, 0) > 0) {
    std::array<char, 256> some{};
    const ssize_t got = ::read(STDIN_FILENO, some.data(), some.size());
    open_ = got != 0;  // an error is none of a terminal that is somebody else's for now
    if (got > 0) typed_.append(some.data(), static_cast<std::size_t>(got));
  }
  const auto end = typed_.find('\n');
  if (end == std::string::npos) {
    if (typed_.size() >= kMostTyped) typed_.clear();
    return std::nullopt;
  }
  std::string line = typed_.substr(0, end);
  typed_.erase(0, end + 1);
  return line;
}

}  // namespace baton
