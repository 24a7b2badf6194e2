/// The command line as a function, so that tests can call it.
#pragma once

#include <string>
#include <vector>

namespace baton::app {

/// "0.1.0"
std::string version();

/// Exit codes.
inline constexpr int kDone = 0;
inline constexpr int kFailed = 1;
inline constexpr int kBadInput = 2;
inline constexpr int kFallen = 3;

/// Runs the program with these arguments (program name excluded). Never throws.
int run(const std::vector<std::string>& args);

}  // namespace baton::app
