#include "baton/proving/link_trial.hpp"

#include <algorithm>
#include <deque>
#include <optional>
#include <utility>

#include "baton/ik/stand.hpp"
#include "baton/link/remote_robot.hpp"
#include "baton/link/robot_server.hpp"
#include "baton/proving/answer_faults.hpp"
#include "baton/proving/scenario.hpp"
#include "baton/proving/stick.hpp"
#include "baton/robot/simulated_robot.hpp"

namespace baton {
namespace {

constexpr double kPlanning = 0.03;   ///< longest delay of a planner's answer [s]
constexpr double kGoneFor = 6.0;     ///< time without a driver, at the end [s]
constexpr double kCools = 3.0;       ///< longest time of a motion to a straighter posture [s]
constexpr double kFaultEvery = 1.5;  ///< on average [s]

/// Says what a driver says, with a random stick.
class RandomDriver {
 public:
  RandomDriver(const RobotModel& robot, const link::NavigationOptions& navigation, std::uint64_t seed)
      : start_(link::start_of(robot)), stick_(seed, robot.profile().tick.period) {
    start_.navigation = navigation;
  }

  /// What a connection begins with.
  [[nodiscard]] std::string hello() {
    stream_ = {};
    return link::framed(link::Type::hello, link::encode(link::Hello{}));
  }
  /// Messages by which it answers bytes from the robot.
  /// @returns none: it hangs up
  [[nodiscard]] std::optional<std::vector<std::string>> answer(const std::string& bytes) {
    std::vector<std::string> answers;
    try {
      stream_.bytes() += bytes;
      while (const std::optional<link::Message> message = stream_.next()) {
        switch (message->type) {
          case link::Type::welcome:
            answers.push_back(link::framed(link::Type::start, link::encode(start_)));
            break;
          case link::Type::measurement:
            answers.push_back(position(0));
            break;
          case link::Type::tick:
            answers.push_back(position(link::decode_tick(message->body, start_.kp.size()).reading.sequence + 1));
            break;
          case link::Type::truth:
            break;
          default:
            return std::nullopt;
        }
      }
    } catch (const LinkError&) {
      return std::nullopt;
    }
    return answers;
  }

  bool stick_is_there = true;

 private:
  std::string position(std::uint64_t seen) {
    const Command command = stick_.next();
    return link::framed(link::Type::command,
                        link::encode(link::StickPosition{seen, stick_is_there ? command : Command{}}));
  }

  link::Start start_;
  Stick stick_;
  link::Stream stream_;
};

/// A planner on the spot whose answers are late, as those of a thread are.
class LatePlanning : public Planning {
 public:
  LatePlanning(const RobotModel& robot, const World& world, Modes modes, std::uint64_t seed)
      : direct_(robot, world, modes), late_(direct_, {.delay = kPlanning}, robot.profile().tick.period, seed) {}
  [[nodiscard]] bool idle() const override { return late_.idle(); }
  void post(Request request) override { late_.post(std::move(request)); }
  [[nodiscard]] std::optional<Reply> poll(long tick) override { return late_.poll(tick); }
  void reset() override { late_.reset(); }

 private:
  DirectPlanning direct_;
  FaultyPlanning late_;
};

/// Messages on their way in one direction.
class Way {
 public:
  void send(double at, std::string bytes) { messages_.emplace_back(at, std::move(bytes)); }
  /// Takes those that have arrived.
  [[nodiscard]] std::string arrived(double now) {
    std::string bytes;
    while (!messages_.empty() && messages_.front().first <= now) {  // one that is late delays the others
      bytes += messages_.front().second;
      messages_.pop_front();
    }
    return bytes;
  }
  void clear() { messages_.clear(); }
  void hold_until(double time) {
    for (auto& [at, bytes] : messages_)
      at = std::max(at, time);
  }
  /// @returns whether there was anything to spoil
  bool spoil(LinkFault fault, Dice& dice) {
    if (messages_.empty()) return false;
    const auto size = static_cast<int>(messages_.size());
    auto& bytes = messages_[static_cast<std::size_t>(dice.below(size))].second;
    if (bytes.empty()) return false;
    const auto at = static_cast<std::size_t>(dice.below(static_cast<int>(bytes.size())));
    switch (fault) {
      case LinkFault::corrupt:
        bytes[at] = static_cast<char>(bytes[at] ^ static_cast<char>(1 << dice.below(8)));
        return true;
      case LinkFault::lose:
        bytes.erase(at, static_cast<std::size_t>(dice.between(1, 9)));
        return true;
      case LinkFault::repeat:
        bytes += std::string(bytes);
        return true;
      case LinkFault::swap:
        if (size < 2) return false;
        std::swap(messages_[0].second, messages_[1].second);
        return true;
      default:
        return false;
    }
  }

 private:
  std::deque<std::pair<double, std::string>> messages_;
};

/// A trial under way.
class LinkRun {
 public:
  LinkRun(const RobotModel& robot, const World& world, const LinkTrial& trial)
      : period_(robot.profile().tick.period),
        dice_(mixed_seed(trial.seed, 1)),
        simulated_(robot, world, stand(robot, world.site("start"), robot.profile().stance.com_height), period_,
                   physics(robot, trial.seed)),
        server_(robot, simulated_,
                {.listen = {"127.0.0.1", 0},
                 .world = world.name(),
                 .real_time = true,
                 .navigates_in = &world,
                 .planning = [&robot, &world, seed = mixed_seed(trial.seed, 3)](
                                 Modes modes) { return std::make_unique<LatePlanning>(robot, world, modes, seed); },
                 .now = [this] { return link::RobotServer::Clock::time_point(clock(now_)); },
                 .log = [this](const std::string& line) { log(line); }}),
        driver_(robot, trial.navigation, mixed_seed(trial.seed, 2)) {
    result_.delay = dice_.percent(50) ? 0.05 * dice_.share() : 0.5 * dice_.share();
    result_.jitter = dice_.percent(50) ? 0.0 : 0.2 * dice_.share();
  }

  LinkTrialResult run(double seconds) {
    connect();
    for (; now_ < seconds && result_.fall.empty(); pass()) {
      if (dice_.share() < period_ / kFaultEvery) happen(static_cast<LinkFault>(dice_.below(kLinkFaults.size())));
      if (!connection_ && now_ >= back_at_) connect();
      driver_.stick_is_there = now_ >= stick_back_at_;
    }
    hang_up();
    const double end = now_ + kGoneFor;
    // A robot whose motors are hot stands straighter by itself, whenever that is.
    for (; (now_ < end || (!rests() && now_ < end + kCools)) && result_.fall.empty(); pass()) {
    }
    result_.rests = rests();
    return std::move(result_);
  }

 private:
  [[nodiscard]] bool rests() const {
    const link::Onboard* onboard = server_.onboard();  // null: no driver has taken over, and it stands as it began
    return result_.fall.empty() && (onboard == nullptr || onboard->rests());
  }
  static SimulatedRobot::Parameters physics(const RobotModel& robot, std::uint64_t seed) {
    SimulatedRobot::Parameters parameters;
    parameters.plant = plant_of(true, nullptr, robot, static_cast<long>(seed), 1.0);
    return parameters;
  }
  static link::RobotServer::Clock::duration clock(double t) {
    return std::chrono::duration_cast<link::RobotServer::Clock::duration>(std::chrono::duration<double>(t));
  }

  void log(const std::string& line) {
    if (line == "a driver has taken over") ++result_.drivers;
    result_.log.push_back(line);
  }
  void connect() {
    connection_.emplace(Socket::connect(server_.address(), Socket::Time(5000)));
    to_robot_.send(arrival(), driver_.hello());
  }
  void hang_up() {
    connection_.reset();
    to_robot_.clear();
    to_driver_.clear();
    back_at_ = now_ + 3.0 * dice_.share();
  }
  /// When a message that is sent now arrives.
  double arrival() { return std::max(now_ + result_.delay + result_.jitter * dice_.share(), stalled_until_); }

  void happen(LinkFault fault) {
    switch (fault) {
      case LinkFault::stall:
        stalled_until_ = now_ + 3.0 * dice_.share();
        to_robot_.hold_until(stalled_until_);
        to_driver_.hold_until(stalled_until_);
        break;
      case LinkFault::cut:
        if (!connection_) return;
        hang_up();
        break;
      case LinkFault::clock:
        now_ += 1.0 * dice_.share();
        break;
      case LinkFault::stick:
        stick_back_at_ = now_ + 2.0 * dice_.share();
        break;
      default:
        if (!(dice_.percent(50) ? to_robot_ : to_driver_).spoil(fault, dice_)) return;
    }
    ++result_.faults[static_cast<std::size_t>(fault)];
  }

  /// A tick.
  void pass() {
    now_ += period_;
    exchange();
    const long before = motions();
    server_.serve(Socket::Time(0));
    const long after = motions();
    result_.motions += after >= before ? after - before : after;  // a driver has begun anew
    if (const link::Onboard* onboard = server_.onboard(); onboard != nullptr && onboard->stale()) ++result_.stale;
    if (simulated_.truth()->fallen) result_.fall = simulated_.truth()->fall;
  }
  [[nodiscard]] long motions() const {
    return server_.onboard() != nullptr ? server_.onboard()->session().navigator().committed() : 0;
  }

  void exchange() {
    if (!connection_) return;
    try {
      std::string bytes;
      while (connection_->receive(bytes, Socket::Time(0))) {
      }
      if (!bytes.empty()) to_driver_.send(arrival(), std::move(bytes));
      if (const std::string heard = to_robot_.arrived(now_); !heard.empty())
        connection_->send(heard, Socket::Time(5000));
    } catch (const LinkError&) {  // the robot's end has hung up
      hang_up();
      return;
    }
    const std::optional<std::vector<std::string>> answers = driver_.answer(to_driver_.arrived(now_));
    if (!answers) return hang_up();
    for (const std::string& answer : *answers)
      to_robot_.send(arrival(), answer);
  }

  double period_;
  double now_ = 0.0;
  Dice dice_;
  LinkTrialResult result_;
  SimulatedRobot simulated_;
  link::RobotServer server_;
  RandomDriver driver_;
  std::optional<Socket> connection_;  ///< the driver's
  Way to_robot_, to_driver_;
  double stalled_until_ = 0.0, back_at_ = 0.0, stick_back_at_ = 0.0;
};

}  // namespace

LinkTrialResult run_link_trial(const RobotModel& robot, const World& world, const LinkTrial& trial) {
  return LinkRun(robot, world, trial).run(trial.seconds);
}

}  // namespace baton
