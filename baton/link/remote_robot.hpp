/// A robot at the other end of a connection. In lock-step it waits for each target or command; in real time it goes on
/// by its clock.
///
/// One that follows targets is a robot like any other: `write` sends the target, and returns when it has measured
/// again, at once if that was some time ago. One that navigates by itself follows commands: `guide` sends one and
/// returns the one that was followed in its next tick. A session at this end runs the same ticks, with
/// `EchoedPlanning`, and `write` compares what it comes to: so all that can be known of a run is known here, too.
#pragma once

#include <chrono>
#include <deque>
#include <functional>
#include <limits>
#include <string>
#include <utility>
#include <vector>

#include "baton/link/follow_check.hpp"
#include "baton/link/message.hpp"
#include "baton/model/robot_model.hpp"

namespace baton::link {

/// Limits of the joints of a model.
[[nodiscard]] JointLimits limits_of(const RobotModel& robot);

/// The servos that the driver of a robot counts on: those of its profile.
[[nodiscard]] Start start_of(const RobotModel& robot);

/// @param from where it is
/// @throws LinkError it speaks another version
/// @throws InputError it is another robot than `model`, with other joints or narrower limits, or in another world
void check_robot(const RobotModel& model, const std::string& world, const Welcome& welcome, const Address& from);

class RemoteRobot : public Robot {
 public:
  struct Parameters {
    Address address;
    std::string token;               ///< "": none
    NavigationOptions navigation{};  ///< for a robot that navigates by itself
    /// Called before the robot is taken over; throws if it shall not be.
    std::function<void(const Welcome&)> accept = [](const Welcome&) {};
    /// For `late`.
    std::function<std::chrono::steady_clock::time_point()> now = &std::chrono::steady_clock::now;
    Socket::Time connecting{3000};   ///< longest time for an answer to come while connecting
    Socket::Time answering{10'000};  ///< the same for a measurement: the robot may be simulated by a slow computer
  };

  /// Connects, and takes the robot over.
  /// @throws LinkError nobody there, or refused; the message says why
  /// @throws InputError it is another robot than `model`, with other joints, or in another world
  RemoteRobot(const RobotModel& model, const std::string& world, const Parameters& parameters);
  /// Hands the robot back.
  ~RemoteRobot() override;
  RemoteRobot(const RemoteRobot&) = delete;
  RemoteRobot& operator=(const RemoteRobot&) = delete;

  /// The newest measurement.
  [[nodiscard]] Measurement read() override { return reading_.measurement; }
  /// Sends the target and waits for the next measurement. To a robot that navigates by itself nothing is sent.
  /// @throws LinkError the robot is gone, silent, or breaks the protocol; its own navigator came to another target
  void write(const JointTarget& target) override;
  /// Sends a command, and waits for the next tick of a robot that navigates by itself.
  /// @returns the command that it followed: in real time an earlier one, or none if that was too old
  /// @throws LinkError the robot is gone, silent, damped, or breaks the protocol
  [[nodiscard]] Command guide(const Command& command);
  /// The same for a stick. In real time it is looked at until that tick has come, and each change is sent at once.
  /// @param stick where it is now
  [[nodiscard]] Command guide(const std::function<Command()>& stick);
  /// Sends targets for the arms to a robot that navigates by itself, which accepts or rejects them.
  /// @throws LinkError it is gone
  void drive_arms(const ArmTargets& targets);
  /// What the robot drives the arms by from the newest tick on, in order, once: also that it has let go of them.
  [[nodiscard]] std::vector<ArmTargets> accepted_arms() { return std::exchange(arms_, {}); }
  /// Null if the robot does not send it.
  [[nodiscard]] const Truth* truth() const override { return truth_ ? &*truth_ : nullptr; }

  /// The newest tick of a robot that navigates by itself.
  [[nodiscard]] const Tick& tick() const { return tick_; }
  /// Ticks in which it had no command that was fresh.
  [[nodiscard]] long stale() const { return stale_; }

  /// How much later the newest measurement of a robot that follows targets in real time has come than the quickest one
  /// of the last seconds: the robot, the network or this end is behind [s].
  [[nodiscard]] double late() const { return late_; }
  /// @param passing called about every 10 ms while the robot is waited for
  void meanwhile(std::function<void()> passing) { meanwhile_ = std::move(passing); }

  /// In real time, goes on to the newest measurement that has come, if there is one: call it before a run begins.
  /// @throws LinkError as `write`
  void catch_up();

  /// Lets its motors only brake, until somebody at its end arms it again.
  /// @throws LinkError it is gone
  void damp(const std::string& because);

  [[nodiscard]] const Address& address() const { return parameters_.address; }
  [[nodiscard]] const Welcome& welcome() const { return welcome_; }
  /// Charge of its battery, 0 to 1; NaN: unknown.
  [[nodiscard]] double battery() const { return reading_.battery; }
  /// Whether the robot's motors only brake, and follow nothing.
  [[nodiscard]] bool damped() const { return reading_.damped; }
  /// Why, as far as the robot has said so.
  [[nodiscard]] const std::string& damped_because() const { return damped_because_; }
  /// What is wrong with the robot, as it says; "": nothing.
  [[nodiscard]] const std::string& fault() const { return fault_; }
  /// Targets that the robot has rejected, and why the last one was.
  [[nodiscard]] long rejected() const { return rejected_; }
  [[nodiscard]] const std::string& rejection() const { return rejection_; }
  /// Why it follows no longer: it was damped, has rejected all targets of some time, or its legs do not go where they
  /// are told to go; "": it follows.
  [[nodiscard]] std::string follows_no_longer() const;

 private:
  /// For how long all targets have been rejected [s].
  [[nodiscard]] double not_followed_for() const;
  /// @throws LinkError none in time
  [[nodiscard]] Message receive(Socket::Time limit);
  void greet(const std::string& token, const std::string& world);
  /// @returns whether it is a measurement
  [[nodiscard]] bool take(const Message& message);
  void take_rejected(const Message& message);
  void take_arms(const Message& message);
  void take_tick(const Message& message);
  /// Takes messages up to the next measurement or tick.
  /// @returns whether it has come in that time
  [[nodiscard]] bool take_reading(Socket::Time limit);
  /// @throws LinkError it has not come in that time
  void await_reading(Socket::Time limit);
  void tell(const Command& command);
  /// @throws LinkError the robot is gone; if it has said why, that
  void send(Type type, const std::string& body);
  /// Takes all that has come.
  /// @throws LinkError it says why the robot is gone
  void hear_last_words();
  void check_sequence(const Reading& reading);
  void note_delay();

  const RobotModel* model_;
  Parameters parameters_;
  Socket socket_;
  Stream stream_;
  Welcome welcome_;
  Reading reading_;
  std::uint64_t expected_ = 0;  ///< sequence of the next measurement or tick
  Tick tick_;
  std::deque<std::string> arms_sent_;  ///< that the robot has not answered yet
  std::vector<ArmTargets> arms_;       ///< accepted by the robot, not taken yet
  long stale_ = 0;
  std::optional<Truth> after_;  ///< truth after the newest tick
  bool begun_ = false;          ///< the first measurement has come
  bool perfect_ = false;        ///< measurements have the root
  std::optional<Truth> truth_;
  long rejected_ = 0;
  long in_a_row_ = 0;          ///< of these, the latest, with none in between that was followed
  bool rejected_now_ = false;  ///< since the last measurement
  std::chrono::steady_clock::time_point rejecting_since_;
  std::string rejection_, damped_because_, fault_;
  FollowCheck follow_;
  /// This end's clock less the measurement's, for the quickest measurement of the last seconds [s].
  double quickest_ = std::numeric_limits<double>::infinity();
  double late_ = 0.0;
  std::function<void()> meanwhile_;
};

/// Damps the robot at that address, whoever drives it.
/// @throws LinkError it could not be told, or refused
void damp(const Address& address, const std::string& token);

}  // namespace baton::link
