/// A player in rcssservermj.
#pragma once

#include <stdexcept>
#include <string>
#include <vector>

#include "baton/bridge/rcss_message.hpp"
#include "baton/link/socket.hpp"

namespace baton::bridge {

/// The simulator is not there, gone or silent, says what is not understood, or the robot does not stand in it. The
/// message is one line.
class SimulatorError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

/// Plays from its construction to its destruction. The simulator (`--sync`) waits for it in each cycle, and removes it
/// if it waits for 5 s.
class RcssConnection {
 public:
  /// Joins as a player of its own team.
  /// @param robot the simulator's name of its model
  /// @throws SimulatorError
  RcssConnection(const Address& server, const std::string& robot, const std::vector<RcssJoint>& joints);

  /// What was perceived last.
  [[nodiscard]] const Perception& perception() const { return perception_; }

  /// Sends what is to be done in the next cycle, and waits for the perception after it.
  /// @throws SimulatorError
  void cycle(const std::string& actions);

 private:
  /// Waits for a perception; if several have come, takes the newest.
  void perceive(Socket::Time limit, const char* hint);

  Address server_;
  std::vector<RcssJoint> joints_;
  Socket socket_;
  std::string bytes_;  ///< received, and not taken yet
  Perception perception_;
};

}  // namespace baton::bridge
