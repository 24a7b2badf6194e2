/// The messages between a robot and its driver (docs/protocol.md).
#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "baton/balance/state_source.hpp"
#include "baton/guide/command.hpp"
#include "baton/link/socket.hpp"
#include "baton/plan/modes.hpp"
#include "baton/robot/robot.hpp"
#include "baton/run/sink.hpp"

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
  command,
  tick,
  arms,
  fault,
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

/// What a connection is for.
enum class Role { drive, damp, observe };

/// What a connection begins with.
struct Hello {
  int version = kVersion;
  std::string token;  ///< "": none
  Role role = Role::drive;
};

/// Limits of a robot's joints.
struct JointLimits {
  VecX lower, upper;  ///< (n) [rad]
  VecX speed;         ///< without load (n) [rad/s]
  VecX torque;        ///< at standstill (n) [N·m]
};

/// The robot, as it introduces itself.
struct Welcome {
  int version = kVersion;
  std::string robot;
  std::vector<std::string> joints;      ///< in the order of all vectors
  double period = 0.0;                  ///< of a tick [s]
  bool lock_step = true;                ///< each tick waits for its target
  std::string on = "real";              ///< sim, ideal or real
  std::string world;                    ///< in which a simulated robot stands; "": unknown
  bool navigates = false;               ///< follows commands, by a navigator of its own; else targets for the joints
  Role role = Role::drive;              ///< what the robot has understood: `drive` or `observe`
  std::optional<JointLimits> limits{};  ///< none: unknown
  std::map<std::string, std::string> settings{};  ///< of a simulator, for recordings
};

/// How a robot that navigates by itself is to do so.
struct NavigationOptions {
  Modes modes{};
  StateSource source = StateSource::sensors;
  bool hangs = false;  ///< in a gantry, in its stance
};

/// The driver takes over, with the servos as it expects them.
struct Start {
  std::string drive;
  VecX kp;                                        ///< [N·m/rad]
  VecX kd;                                        ///< [N·m·s/rad]
  std::optional<NavigationOptions> navigation{};  ///< none: for a robot that follows targets
};

struct Refusal {
  std::string reason;  ///< version, token, damped, busy, servos, sensors, posture, robot or protocol
  std::string text;    ///< one line
};

/// A measurement of the robot, and what goes with it.
struct Reading {
  std::uint64_t sequence = 0;
  bool damped = false;  ///< its motors only brake, until somebody at the robot's end arms it again
  double battery = std::numeric_limits<double>::quiet_NaN();  ///< charge, 0 to 1; NaN: unknown
  Measurement measurement;
};

/// The joint angles that a target asks for, with what balance adds (n) [rad].
[[nodiscard]] VecX commanded(const JointTarget& target);

/// What the servos are told. Their torque is kp (q − measured) + kd (dq − measured) + tau.
struct Target {
  std::uint64_t sequence = 0;  ///< of the measurement that it answers
  VecX q;                      ///< for the end of the tick [rad]
  VecX dq;                     ///< [rad/s]
  VecX tau;                    ///< [N·m]
};

/// What the stick asks for.
struct StickPosition {
  std::uint64_t seen = 0;  ///< number of the ticks that the driver knew of when it asked
  Command command;
};

/// What a robot that navigates by itself has done in a tick: all that its navigator's output depends on.
struct Tick {
  Reading reading;     ///< its sequence is the tick's number, from 0
  Command command;     ///< that was followed
  bool stale = false;  ///< the driver's was not followed: too old, or something is wrong with the robot
  std::vector<PlanningEvent> planning;  ///< after the tick, in order; at most `kMostPlanning`
  VecX target;                          ///< joint angles that the navigator gave out: `commanded` [rad]

  static constexpr std::size_t kMostPlanning = 3;
};

/// @throws std::logic_error a vector has the wrong length
[[nodiscard]] std::string encode(const Hello& hello);
[[nodiscard]] std::string encode(const Welcome& welcome);
[[nodiscard]] std::string encode(const Start& start);
[[nodiscard]] std::string encode(const Refusal& refusal);
[[nodiscard]] std::string encode(const Reading& reading);
[[nodiscard]] std::string encode(const Target& target);
[[nodiscard]] std::string encode(const Truth& truth);
[[nodiscard]] std::string encode(const StickPosition& stick);
[[nodiscard]] std::string encode(const Tick& tick);
/// What drives the arms of a robot that navigates by itself.
[[nodiscard]] std::string encode(const ArmTargets& targets);
/// Why the robot was damped, or a target rejected; what is wrong with the robot.
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
[[nodiscard]] StickPosition decode_stick(const std::string& body);
[[nodiscard]] Tick decode_tick(const std::string& body, Eigen::Index joints);
[[nodiscard]] ArmTargets decode_arms(const std::string& body);
[[nodiscard]] std::string decode_text(const std::string& body);

}  // namespace baton::link
