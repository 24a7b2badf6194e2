/// The robot's end of a connection: one driver at a time, a brake that needs no driver, and one who only looks on.
#pragma once

#include <chrono>
#include <functional>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "baton/link/onboard.hpp"
#include "baton/link/remote_robot.hpp"
#include "baton/link/target_check.hpp"
#include "baton/run/condition_log.hpp"

namespace baton::link {

/// States: `waiting` for a driver → `driven` → `waiting`; from each to `damped`, and by `arm` back to `waiting`.
class RobotServer {
 public:
  enum class State { waiting, driven, damped };
  using Clock = std::chrono::steady_clock;

  struct Parameters {
    Address listen;
    std::string token{};  ///< that drivers must know; "": none, which is accepted on a loopback address alone
    std::string on = "sim";
    std::string world{};
    std::map<std::string, std::string> settings{};  ///< of a simulator, for its driver's recording
    bool real_time = false;  ///< goes on by the clock, whether or not a target has come; else waits for each
    /// World in which it navigates by itself, and follows commands; null: it follows targets for the joints.
    const World* navigates_in = nullptr;
    /// Where it plans then; none, or null: synchronously.
    std::function<std::unique_ptr<Planning>(Modes)> planning{};
    /// Connection to the robot itself, if that follows targets somewhere else and is balanced from here. In real time
    /// only, by the clock of that robot; null: `robot` is moved from here.
    RemoteRobot* remote = nullptr;
    /// What that robot is told until the first driver has taken over; none: nothing.
    std::optional<JointTarget> hold{};
    /// In real time: a target is written as soon as it has come, and once. For a robot that moves by itself, not in
    /// `write`, and stays where the last target was.
    bool immediate = false;
    /// Somebody else controls the robot: there are observers, and no driver.
    bool only_observed = false;
    /// Sets the servos as a driver counts on them; says why if it cannot. Without it they are those of the profile, and
    /// no others.
    std::function<std::optional<std::string>(const Start&)> set_servos{};
    /// A navigator at this end has been started by a driver; `ended`: nobody drives it, and it rests or is damped.
    std::function<void(Onboard&, const NavigationOptions&)> began = [](Onboard&, const NavigationOptions&) {};
    std::function<void()> ended = [] {};
    std::function<Clock::time_point()> now = Clock::now;
    std::function<void(const std::string&)> log = [](const std::string&) {};
  };

  /// `model`, `robot` and the world must outlive this object. The robot must have a `reset`, unless it is `remote`.
  /// @throws InputError the address cannot be listened on, or needs a token
  RobotServer(const RobotModel& model, Robot& robot, Parameters parameters);

  /// Where it listens: with the port that was chosen, if 0 was asked for.
  [[nodiscard]] Address address() const;
  [[nodiscard]] State state() const { return state_; }
  /// Whether a target has been followed that answers the newest measurement.
  [[nodiscard]] bool answered() const { return next_ > reading_.sequence; }
  /// The navigator at this end, once a driver has started it.
  [[nodiscard]] const Onboard* onboard() const { return onboard_.get(); }

  /// Waits for messages, and does what they ask for; in real time, also moves the robot when a tick is over.
  /// @param limit longest wait
  /// @throws LinkError the robot that is `remote` is gone
  void serve(Socket::Time limit);

  /// Drops the driver, and takes no other: for the time until the robot rests.
  void retire();
  /// Whether it may be left: at rest on both feet, soft after a fall, damped, or not moved from here.
  [[nodiscard]] bool resting() const;

  /// The motors only brake from now on, whatever a driver says.
  /// @param because one line, for the log and the driver
  void damp(const std::string& because);
  /// Says what is wrong with the robot. Until nothing is, the stick counts as centred, so the robot comes to rest; who
  /// drives is told.
  /// @param fault one line; "": nothing
  void set_fault(const std::string& fault);
  /// Ends that. Who drove has to begin anew. A robot that is `remote` has to be armed at its own end before.
  void arm();

 private:
  struct Peer {
    Socket socket;
    Stream stream;
    std::string unsent;       ///< what its connection has not taken yet
    Clock::time_point since;  ///< of its connection
    bool welcomed = false;
    bool observes = false;
    bool started = false;
  };

  void hear_all();
  /// Takes what a peer has sent.
  /// @param why receives why it is gone, unless it has said so
  /// @returns whether it stays connected
  [[nodiscard]] bool listen_to(Peer& peer, std::string& why);
  void accept();
  /// @returns whether the peer stays connected
  [[nodiscard]] bool hear(Peer& peer, const Message& message);
  [[nodiscard]] bool greet(Peer& peer, const Message& message);
  [[nodiscard]] bool greet_observer(Peer& peer);
  /// Says who the robot is.
  void welcome(Peer& peer, Role role);
  [[nodiscard]] bool begin(Peer& peer, const Message& message);
  /// @returns why not, with these servos
  [[nodiscard]] std::optional<std::string> wrong_servos(const Start& start) const;
  /// What the robot is to follow.
  /// @returns whether the peer stays connected
  [[nodiscard]] bool take(Peer& peer, const Message& message);
  void follow(Peer& peer, const Message& message);
  /// @returns whether the peer stays connected
  [[nodiscard]] bool guide(Peer& peer, const Message& message);
  void drive_arms(Peer& peer, const Message& message);
  /// @returns why the target is not followed
  [[nodiscard]] std::optional<std::string> judge(const Target& target);
  /// Moves the robot by a tick and measures.
  void move();
  /// Tells the driver.
  /// @throws LinkError it is gone
  void report();
  /// Measures, without moving.
  void look();
  /// Tells the observer what was measured.
  void show();
  void brake();
  void look_at_faults();
  void tell_fault(Peer& peer);
  /// Logs what the navigator at this end has done in a tick, as far as somebody beside the robot wants to know it.
  void log_changes();
  [[nodiscard]] Clock::duration period() const;
  /// In real time, by the clock or as the robot says.
  void advance_if_due();
  /// Moves, and drops a driver that is gone.
  void advance();
  void advance_remote();
  void send_reading(Peer& peer);
  /// Truth, if there is any, and a message.
  void send(Peer& peer, const std::string& message);
  /// Sends as much as the peer takes at once, and the rest later.
  /// @throws LinkError it is gone, or takes nothing
  static void tell(Peer& peer, const std::string& bytes);
  /// @returns false: it does not stay connected
  [[nodiscard]] bool refuse(Peer& peer, const std::string& reason, const std::string& text);
  /// The same by another last message. What comes to a connection that is closed makes it lose what it has not
  /// delivered: so it is open until the peer closes it, for some seconds, and what comes is dropped.
  bool dismiss(Peer& peer, const std::string& last);
  void see_off();
  /// @param why for the log; "": it is there already
  void drop_driver(const std::string& why);
  void drop_observer(const std::string& why);

  const RobotModel* model_;
  Robot* robot_;
  Parameters parameters_;
  Socket listener_;
  State state_ = State::waiting;
  std::vector<Peer> guests_;               ///< connected, and nothing agreed on yet
  std::optional<Peer> driver_;             ///< at most one
  std::optional<Peer> observer_;           ///< the same
  std::vector<Peer> dismissed_;            ///< told their last message
  std::uint64_t shown_ = 0;                ///< measurements since it came
  std::optional<ConditionLog> condition_;  ///< of its run
  std::unique_ptr<Onboard> onboard_;       ///< null before the first start, and if it follows targets
  TargetCheck check_;
  JointTarget target_;  ///< the last one that was followed
  Reading reading_;     ///< the last one that was sent
  std::string damped_because_;
  std::string fault_;         ///< that the driver is told: the first of the next two that there is
  std::string own_fault_;     ///< `set_fault`
  std::string remote_fault_;  ///< that the robot that is `remote` reports
  bool stale_ = false;        ///< that the stick was has been logged
  bool rest_logged_ = false;  ///< that it rests without a driver has been logged
  bool retired_ = false;
  long rejections_ = 0;
  long refusals_ = 0;             ///< not logged yet
  Clock::time_point refused_at_;  ///< of the last one that was logged
  bool more_ = false;             ///< a peer has sent more than what was heard
  bool runs_ = false;             ///< a driver has started it
  Clock::time_point due_;         ///< end of the tick, in real time
  std::uint64_t next_ = 0;        ///< least sequence of the next target that may be followed
};

}  // namespace baton::link
