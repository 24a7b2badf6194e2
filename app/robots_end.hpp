/// What all commands have in common that are the robot's end of a connection.
#pragma once

#include <functional>
#include <string>

#include "baton/link/robot_server.hpp"

namespace baton::app {

/// Serves drivers until the program is interrupted, and obeys d (damp), a (arm), f TEXT (there is a fault) and f
/// (there is none) typed at the terminal.
/// @param between called between two messages
/// @param key called with any other line that is typed; returns whether it means something
void serve_drivers(
    link::RobotServer& server, const std::function<void()>& between = [] {},
    const std::function<bool(const std::string&)>& key = [](const std::string&) { return false; });

}  // namespace baton::app
