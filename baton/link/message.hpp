/// The messages between a robot and its driver (docs/protocol.md).
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "baton/link/socket.hpp"
#include "baton/robot/robot.hpp"

namespace baton::link {

/// What the other end says is no message of the protocol.
class Malformed : public LinkError {
 public:
  using LinkError::LinkError;
};

inline constexpr int kVersion = 1;
inline constexpr std::size_t kLongest = 1U << 20U;  ///< longest body of a message [bytes]

enum class Type : std::uint8_t {
  hello = 1,
  welcome,
  refusal,
  start,
  truth,
  measurement,
  target,
  rejected,
  damp,
  bye,
};

struct Message {
  Type type = Type::bye;
  std::string body;
};

/// The bytes of a message: length of the body, type, body.
[[nodiscard]] std::string framed(Type type, std::string_view body = {});

/// Takes messages out of a stream of bytes.
class Stream {
 public:
  /// Where the bytes are appended.
  std::string& bytes() { return bytes_; }
  /// The next whole message, if there is one.
  /// @throws Malformed a message of unknown type, or longer than `kLongest`
  [[nodiscard]] std::optional<Message> next();

 private:
  std::string bytes_;
};

/// What a connection begins with.
struct Hello {
  enum class Role { drive, damp };
  int version = kVersion;
  std::string token;  ///< "": none
  Role role = Role::drive;
};

/// The robot, as it introduces itself.
struct Welcome {
  int version = kVersion;
  std::string robot;
  std::vector<std::string> joints;  ///< in the order of all vectors
  double period = 0.0;              ///< of a tick [s]
  bool lock_step = true;            ///< each tick waits for its target
  std::string on = "real";          ///< sim, ideal or real
  std::string world;                ///< in which a simulated robot stands; "": unknown
};

/// The driver takes over, with the servos as it expects them.
struct Start {
  std::string drive;
  VecX kp;  ///< [N·m/rad]
  VecX kd;  ///< [N·m·s/rad]
};

struct Refusal {
  std::string reason;  ///< version, token, busy, damped, servos or protocol
  std::string text;    ///< one line
};

/// A measurement of the robot, and what goes with it.
struct Reading {
  std::uint64_t sequence = 0;
  bool damped = false;  ///< its motors only brake, until somebody at the robot's end arms it again
  double battery = std::numeric_limits<double>::quiet_NaN();  ///< charge, 0 to 1; NaN: unknown
  Measurement measurement;
};

/// What the servos are told. Their torque is kp (q − measured) + kd (dq − measured) + tau.
struct Target {
  std::uint64_t sequence = 0;  ///< of the measurement that it answers
  VecX q;                      ///< for the end of the tick [rad]
  VecX dq;                     ///< [rad/s]
  VecX tau;                    ///< [N·m]
};

/// @throws std::logic_error a vector has the wrong length
[[nodiscard]] std::string encode(const Hello& hello);
[[nodiscard]] std::string encode(const Welcome& welcome);
[[nodiscard]] std::string encode(const Start& start);
[[nodiscard]] std::string encode(const Refusal& refusal);
[[nodiscard]] std::string encode(const Reading& reading);
[[nodiscard]] std::string encode(const Target& target);
[[nodiscard]] std::string encode(const Truth& truth);
/// Why the robot was damped, or a target rejected.
[[nodiscard]] std::string encode_text(const std::string& text);

/// The bodies of messages. All numbers of JSON are finite, all vectors have the stated length.
/// @throws Malformed
[[nodiscard]] Hello decode_hello(const std::string& body);
[[nodiscard]] Welcome decode_welcome(const std::string& body);
[[nodiscard]] Start decode_start(const std::string& body, Eigen::Index joints);
[[nodiscard]] Refusal decode_refusal(const std::string& body);
[[nodiscard]] Reading decode_reading(const std::string& body, Eigen::Index joints);
[[nodiscard]] Target decode_target(const std::string& body, Eigen::Index joints);
[[nodiscard]] Truth decode_truth(const std::string& body, Eigen::Index joints);
[[nodiscard]] std::string decode_text(const std::string& body);

}  // namespace baton::link
