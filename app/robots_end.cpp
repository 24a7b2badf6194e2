#include "app/robots_end.hpp"

#include <spdlog/spdlog.h>

#include <csignal>
#include <string>
#include <utility>

#include "app/commands.hpp"
#include "baton/input/typed_lines.hpp"

namespace baton::app {
namespace {

void obey(const std::string& line, link::RobotServer& server, const std::function<bool(const std::string&)>& key) {
  if (line == "d" || line == "damp") {
    server.damp("by the robot's own key");
  } else if (line == "a" || line == "arm") {
    server.arm();
  } else if (line == "f" || line.starts_with("f ")) {
    server.set_fault(line.size() > 2 ? line.substr(2) : "");
  } else if (!line.empty() && !key(line)) {
    spdlog::warn(
        "type d (damp: the motors only brake), a (arm again), f TEXT (report a fault) or f (it is over), each "
        "with Enter");
  }
}

}  // namespace

void serve_drivers(link::RobotServer& server, const std::function<void()>& between,
                   const std::function<bool(const std::string&)>& key) {
  // Neither a job in the background that is typed to, nor a log that nobody reads any more, stops a robot's end.
  std::signal(SIGTTIN, SIG_IGN);
  std::signal(SIGPIPE, SIG_IGN);
  TypedLines keyboard;
  bool ending = false;
  while (!interrupted || !server.resting()) {
    if (interrupted && !std::exchange(ending, true)) {
      spdlog::info("coming to rest; again: end at once");
      std::signal(SIGINT, SIG_DFL);
      std::signal(SIGTERM, SIG_DFL);
      server.retire();
    }
    server.serve(Socket::Time(50));
    between();
    if (const std::optional<std::string> line = keyboard.next()) obey(*line, server, key);
  }
}

}  // namespace baton::app
