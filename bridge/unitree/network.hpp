/// The robot's DDS network: what is read from it and written to it.
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>

#include "bridge/unitree/factory_gait.hpp"
#include "bridge/unitree/messages.hpp"

namespace baton::unitree {

/// Its functions may be called by several threads.
class Network {
 public:
  struct Answer {
    std::int64_t id = 0;
    int code = 0;
    std::string data;
  };
  /// What is said on the topics of this bridge and does not belong there: one line each.
  using Complain = std::function<void(const std::string&)>;

  enum class Speaks { yes, never };

  /// @param interface name of the network interface; "": DDS chooses one
  /// @param speaks whether it can send: one that never does publishes no topic
  /// @throws InputError there is no such interface
  /// @throws std::runtime_error DDS does not start
  Network(const std::string& interface, Speaks speaks);
  ~Network();
  Network(const Network&) = delete;
  Network& operator=(const Network&) = delete;

  /// Waits until there is a state or somebody else's command.
  /// @param limit longest wait [s]
  void wait(double limit);
  /// The next state. Those of a second publisher are left out, as long as the first one is there.
  [[nodiscard]] std::optional<LowState> state(const Complain& complain);
  /// Whether somebody else has sent a command since the last call.
  [[nodiscard]] bool foreign_command();
  /// Looks for publishers that use the names of the robot's topics for other types.
  void look_for_strangers(const Complain& complain);

  /// @throws std::runtime_error it cannot be sent
  void send(const LowCommand& command);
  /// @throws std::runtime_error it cannot be sent
  void send(const FactoryGait::Request& request);
  /// The next answer of the motion switcher.
  [[nodiscard]] std::optional<Answer> answer();

 private:
  struct Entities;
  std::unique_ptr<Entities> entities_;
};

}  // namespace baton::unitree
