#include "baton/bridge/rcss_connection.hpp"

#include <fmt/format.h>

#include <chrono>

namespace baton::bridge {
namespace {

constexpr Socket::Time kJoiningRcss{20'000};     ///< it compiles its model anew
constexpr Socket::Time kPatienceWithRcss{8000};  ///< it waits for 5 s for each other robot
constexpr const char* kTeam = "baton";
constexpr int kPlayer = 1;

}  // namespace

RcssConnection::RcssConnection(const Address& server, const std::string& robot, const std::vector<RcssJoint>& joints)
    : server_(server), joints_(joints) {
  try {
    socket_ = Socket::connect(server_, kPatienceWithRcss);
    socket_.send(rcss_framed(init_text(robot, kTeam, kPlayer)), kPatienceWithRcss);
  } catch (const LinkError& error) {
    const std::string why = error.what();
    throw SimulatorError(
        fmt::format("no simulator: {}", why.starts_with(server_.text()) ? why : server_.text() + ": " + why));
  }
  perceive(kJoiningRcss,
           "it has no robot of that name, no rcssservermj runs there, or somebody plays as player 1 of team baton");
}

void RcssConnection::cycle(const std::string& actions) {
  try {
    socket_.send(rcss_framed(actions), kPatienceWithRcss);
  } catch (const LinkError& error) {
    throw SimulatorError(fmt::format("simulator {}: {}", server_.text(), error.what()));
  }
  perceive(kPatienceWithRcss, "it was ended, or has removed a robot that did not answer for 5 s");
}

void RcssConnection::perceive(Socket::Time limit, const char* hint) {
  const auto until = std::chrono::steady_clock::now() + limit;
  std::string newest;
  try {
    while (newest.empty()) {
      const auto left = std::chrono::ceil<Socket::Time>(until - std::chrono::steady_clock::now());
      if (left.count() <= 0 || !socket_.receive(bytes_, left))
        throw SimulatorError(fmt::format("simulator {}: nothing for {} ms", server_.text(), limit.count()));
      while (std::optional<std::string> text = take_rcss_message(bytes_))
        newest = *std::move(text);
    }
    perception_ = perception_in(newest, joints_);
  } catch (const LinkError& error) {
    throw SimulatorError(fmt::format("simulator {}: {} ({})", server_.text(), error.what(), hint));
  } catch (const SExprError& error) {
    throw SimulatorError(fmt::format("simulator {}: not understood: {}", server_.text(), error.what()));
  }
}

}  // namespace baton::bridge
