#include "app/robots_end.hpp"

#include <poll.h>
#include <spdlog/spdlog.h>
#include <unistd.h>

#include <array>
#include <csignal>
#include <string>

#include "app/commands.hpp"

namespace baton::app {
namespace {

constexpr std::size_t kMostTyped = 4096;

/// Lines that are typed at the robot's end.
class Keyboard {
 public:
  /// The next whole line, if there is one.
  std::optional<std::string> line() {
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

 private:
  bool open_ = true;
  std::string typed_;
};

void obey(const std::string& line, link::RobotServer& server) {
  if (line == "d" || line == "damp") {
    server.damp("by the robot's own key");
  } else if (line == "a" || line == "arm") {
    server.arm();
  } else if (!line.empty()) {
    spdlog::warn("type d (damp: the motors only brake) or a (arm again), each with Enter");
  }
}

}  // namespace

void serve_drivers(link::RobotServer& server, const std::function<void()>& between) {
  // Neither a job in the background that is typed to, nor a log that nobody reads any more, stops a robot's end.
  std::signal(SIGTTIN, SIG_IGN);
  std::signal(SIGPIPE, SIG_IGN);
  Keyboard keyboard;
  while (!interrupted) {
    server.serve(Socket::Time(50));
    between();
    if (const std::optional<std::string> line = keyboard.line()) obey(*line, server);
  }
}

}  // namespace baton::app
