/// The tables of states in docs/protocol.md, tried cell by cell.
#include <fmt/format.h>
#include <gmock/gmock.h>

#include <algorithm>
#include <atomic>
#include <fstream>
#include <functional>
#include <map>
#include <set>
#include <sstream>
#include <thread>

#include "tests/support/robots.hpp"
#include "tests/support/served.hpp"

namespace baton::link {
namespace {

using test::complaint;
using test::hello;
using test::kLinkPatience;
using test::Served;

/// Event → state → cell.
using Table = std::map<std::string, std::map<std::string, std::string>>;

std::vector<std::string> cells_of(const std::string& line) {
  std::vector<std::string> cells;
  std::istringstream rest(line.substr(1));
  for (std::string cell; std::getline(rest, cell, '|');) {
    const auto begin = cell.find_first_not_of(' ');
    cells.push_back(begin == std::string::npos ? "" : cell.substr(begin, cell.find_last_not_of(' ') - begin + 1));
  }
  return cells;
}

/// The table whose header has this state.
Table table_with(const std::string& state) {
  std::ifstream file(BATON_SOURCE_DIR "/docs/protocol.md");
  Table table;
  std::vector<std::string> states;
  for (std::string line; std::getline(file, line);) {
    if (!line.starts_with("|")) {
      if (!table.empty()) return table;
      states.clear();
      continue;
    }
    const std::vector<std::string> cells = cells_of(line);
    if (states.empty()) {
      const bool is_it = cells.front() == "event" && std::find(cells.begin(), cells.end(), state) != cells.end();
      if (is_it) states = cells;
    } else if (!line.starts_with("|--")) {
      for (std::size_t k = 1; k < cells.size(); ++k)
        table[cells.front()][states.at(k)] = cells[k];
    }
  }
  return table;
}

/// A connection that hears all that has come.
class Peer {
 public:
  explicit Peer(const Address& address) : socket_(Socket::connect(address, kLinkPatience)) {}

  void send(Type type, const std::string& body = "") {
    try {
      socket_.send(framed(type, body), kLinkPatience);
    } catch (const LinkError&) {  // closed
      gone = true;
    }
  }
  /// The reason of a refusal that has come since the last call; "": none.
  std::string refusal() {
    try {
      while (!gone && socket_.receive(stream_.bytes(), Socket::Time(0))) {
      }
    } catch (const LinkError&) {
      gone = true;
    }
    std::string reason;
    while (const std::optional<Message> message = stream_.next()) {
      if (message->type == Type::refusal) reason = decode_refusal(message->body).reason;
    }
    return reason;
  }

  bool gone = false;

 private:
  Socket socket_;
  Stream stream_;
};

class RobotsStates : public testing::TestWithParam<bool> {
 protected:
  /// A robot's end in one of the states, with its driver and another connection.
  struct Case {
    explicit Case(const RobotModel& model, bool navigates)
        : served(model, {}, "", Served::Pace::lock_step, navigates) {}

    /// Lets the robot's end hear what was sent.
    void settle() { served.pass(0); }
    void settle(int ticks) { served.pass(ticks); }
    [[nodiscard]] std::ptrdiff_t starts() {
      const std::string log = served.log();
      const std::string line = "a driver has taken over";
      std::ptrdiff_t n = 0;
      for (auto at = log.find(line); at != std::string::npos; at = log.find(line, at + 1))
        ++n;
      return n;
    }

    Served served;
    std::unique_ptr<Peer> driver;
    std::unique_ptr<Peer> other;
    std::unique_ptr<Peer> observer;
    std::unique_ptr<Peer> second_observer;
  };
  using Event = std::function<void(Case&)>;
  using Events = std::vector<std::pair<std::string, Event>>;  // several may belong to one row of the table

  [[nodiscard]] std::unique_ptr<Case> in(const std::string& state) const {
    auto made = std::make_unique<Case>(model_, navigates_);
    if (state.ends_with("welcomed") || state.ends_with("driven")) {
      made->driver = std::make_unique<Peer>(made->served.address());
      made->driver->send(Type::hello, hello());
      if (state.ends_with("driven")) made->driver->send(Type::start, encode(start_of(model_)));
      made->settle();
      made->settle();
    }
    if (state.starts_with("damped"))
      made->served.at_the_robot([](RobotServer& server) { server.damp("by the robot's own key"); });
    made->settle();
    return made;
  }
  /// The state that it is in, and whether a refusal was sent and why: as in the table. Ends the case.
  [[nodiscard]] std::string found(Case& now) const {
    now.settle();
    now.settle();
    std::string reason = now.other ? now.other->refusal() : "";
    if (now.driver) reason += now.driver->refusal();
    RobotServer::State state{};
    now.served.at_the_robot([&](RobotServer& server) { state = server.state(); });
    const bool damped = state == RobotServer::State::damped;
    std::string name = damped ? "damped" : "waiting";
    Peer* const driver = now.driver && !now.driver->gone ? now.driver.get() : now.other.get();
    if (driver != nullptr && !driver->gone) {  // by what a start leads to
      const std::ptrdiff_t before = now.starts();
      driver->send(Type::start, encode(start_of(model_)));
      now.settle();
      now.settle();
      const std::string why = driver->refusal();
      const bool welcomed = now.starts() > before || why == "damped";
      const bool observes = !welcomed && driver == now.other.get();
      if (!observes) name = (damped ? "damped, " : "") + std::string(welcomed ? "welcomed" : "driven");
      EXPECT_EQ(state == RobotServer::State::driven, !observes && !damped);
    } else {
      EXPECT_NE(state, RobotServer::State::driven);
    }
    return reason.empty() ? name : name + " (" + reason + ")";
  }

  void anybody(Case& now, Type type, const std::string& body) const {
    now.other = std::make_unique<Peer>(now.served.address());
    now.other->send(type, body);
  }
  [[nodiscard]] std::string target() const {
    const VecX zero = VecX::Zero(model_.nv() - 6);
    return encode(Target{0, zero, zero, zero});
  }
  [[nodiscard]] Events events() const {
    const std::string stick = encode(StickPosition{});
    const std::string arms = encode(released_arms(model_));
    Start other_servos = start_of(model_);
    other_servos.kp[0] *= 2.0;
    const auto driver_says = [](Type type, const std::string& body) {
      return [type, body](Case& now) { now.driver->send(type, body); };
    };
    const auto other_says = [this](Type type, const std::string& body) {
      return [this, type, body](Case& now) { anybody(now, type, body); };
    };
    const auto key = [](const std::function<void(RobotServer&)>& act) {
      return [act](Case& now) { now.served.at_the_robot(act); };
    };
    Events all{
        {"hello of another driver", other_says(Type::hello, hello())},
        {"hello of an observer", other_says(Type::hello, encode(Hello{kVersion, "", Role::observe}))},
        {"hello with another version", other_says(Type::hello, hello(kVersion + 1))},
        {"hello to damp", other_says(Type::hello, encode(Hello{kVersion, "", Role::damp}))},
        {"no hello from another", other_says(Type::bye, "")},
        {"start", driver_says(Type::start, encode(start_of(model_)))},
        {"start with other servos", driver_says(Type::start, encode(other_servos))},
        {"damp message", driver_says(Type::damp, encode_text("at once"))},
        {"bye", driver_says(Type::bye, "")},
        {"bye", driver_says(Type::bye, "with a body")},
        {"connection closed", [](Case& now) { now.driver.reset(); }},
        {"another or malformed message", driver_says(Type::tick, "")},
        {"another or malformed message", driver_says(Type::fault, encode_text("a knee"))},
        {"fault by key", key([](RobotServer& server) { server.set_fault("a knee"); })},
        {"5 s pass", [](Case& now) { now.settle(1100); }},
        {"damped by key", key([](RobotServer& server) { server.damp("by the robot's own key"); })},
        {"armed by key", key([](RobotServer& server) { server.arm(); })},
    };
    const std::string in_turn = "what it follows, in its turn";
    const std::string other = "what it does not follow";
    all.emplace_back(navigates_ ? in_turn : other, driver_says(Type::command, stick));
    all.emplace_back(navigates_ ? other : in_turn, driver_says(Type::target, target()));
    const std::string driven_arms = navigates_ ? "arms, if it follows commands" : other;
    all.emplace_back(driven_arms, driver_says(Type::arms, arms));
    if (navigates_) all.emplace_back(driven_arms, driver_says(Type::arms, encode(ArmTargets{{"tail"}, {}, {}})));
    return all;
  }

  static std::unique_ptr<Peer> observer(Case& now) {
    auto peer = std::make_unique<Peer>(now.served.address());
    peer->send(Type::hello, encode(Hello{kVersion, "", Role::observe}));
    return peer;
  }
  /// Whether there is an observer, and whether a refusal was sent to one and why: as in the table.
  [[nodiscard]] static std::string looked_at(Case& now) {
    now.settle();
    now.settle();
    std::string reason;
    bool there = false;
    for (const auto* peer : {&now.observer, &now.second_observer}) {
      if (*peer == nullptr) continue;
      reason += (*peer)->refusal();
      there = there || !(*peer)->gone;
    }
    const std::unique_ptr<Peer> next = observer(now);
    now.settle();
    now.settle();
    EXPECT_EQ(next->refusal(), there ? "busy" : "");
    const std::string name = there ? "one observer" : "no observer";
    return reason.empty() ? name : name + " (" + reason + ")";
  }
  [[nodiscard]] Events observers_events() const {
    Events all{{"hello of an observer", [](Case& now) { now.second_observer = observer(now); }},
               {"bye of the observer", [](Case& now) { now.observer->send(Type::bye); }},
               {"connection of the observer closed", [](Case& now) { now.observer.reset(); }},
               {"5 s pass", [](Case& now) { now.settle(1100); }},
               {"damped and armed by key", [](Case& now) {
                  now.served.at_the_robot([](RobotServer& server) { server.damp("by the robot's own key"); });
                  now.served.at_the_robot([](RobotServer& server) { server.arm(); });
                }}};
    for (const auto& [type, body] : std::vector<std::pair<Type, std::string>>{
             {Type::hello, hello()},
             {Type::start, encode(start_of(model_))},
             {Type::target, target()},
             {Type::command, encode(StickPosition{})},
             {Type::arms, encode(released_arms(model_))},
             {Type::damp, encode_text("at once")},
             {Type::tick, ""},
         }) {
      all.emplace_back("another message of the observer",
                       [type = type, body = body](Case& now) { now.observer->send(type, body); });
    }
    return all;
  }

  const RobotModel& model_ = test::robot("mighty");
  const bool navigates_ = GetParam();
};

INSTANTIATE_TEST_SUITE_P(Ends, RobotsStates, testing::Bool(),
                         [](const auto& end) { return end.param ? "Navigates" : "FollowsTargets"; });

TEST_P(RobotsStates, AreThoseOfTheTable) {
  const Table table = table_with("waiting");
  std::set<std::string> tried;
  if (!navigates_) tried.insert("arms, if it follows commands");
  for (const auto& [event, act] : events()) {
    ASSERT_TRUE(table.contains(event)) << event;
    tried.insert(event);
    ASSERT_EQ(table.at(event).size(), 6U);
    for (const auto& [state, expected] : table.at(event)) {
      const bool no_driver = state == "waiting" || state == "damped";
      if (expected == "—") {
        EXPECT_TRUE(no_driver) << state;
        continue;
      }
      const std::unique_ptr<Case> now = in(state);
      act(*now);
      EXPECT_EQ(found(*now), expected) << state << ": " << event;
    }
  }
  EXPECT_EQ(tried.size(), table.size());
}

TEST_P(RobotsStates, OfObserversAreThoseOfTheTableAndTheRobotKeepsItsOwn) {
  const Table table = table_with("one observer");
  std::set<std::string> tried;
  for (const auto& [event, act] : observers_events()) {
    ASSERT_TRUE(table.contains(event)) << event;
    tried.insert(event);
    for (const auto& [observed, expected] : table.at(event)) {
      if (expected == "—") continue;
      for (const char* state : {"waiting", "welcomed", "driven", "damped", "damped, welcomed", "damped, driven"}) {
        const std::unique_ptr<Case> now = in(state);
        if (observed == "one observer") now->observer = observer(*now);
        now->settle();
        act(*now);
        EXPECT_EQ(looked_at(*now), expected) << observed << ", " << state << ": " << event;
        const bool changes = event == "5 s pass" || event == "damped and armed by key";
        if (changes) continue;
        EXPECT_EQ(found(*now), state) << observed << ": " << event;
      }
    }
  }
  EXPECT_EQ(tried.size(), table.size());
}

/// What a robot says in the states of the driver's end.
class DriversStates : public testing::Test {
 protected:
  const RobotModel& model_ = test::robot("mighty");
  const Eigen::Index n_ = model_.nv() - 6;

  [[nodiscard]] std::string welcome(bool navigates, bool another = false) const {
    Welcome welcome;
    welcome.robot = "puppet";
    for (const Joint& joint : model_.joints())
      welcome.joints.push_back(joint.name);
    if (another) welcome.joints.pop_back();
    welcome.period = model_.profile().tick.period;
    welcome.navigates = navigates;
    return framed(Type::welcome, encode(welcome));
  }
  [[nodiscard]] Reading reading(std::uint64_t sequence, bool damped = false) const {
    Reading reading;
    reading.sequence = sequence;
    reading.damped = damped;
    reading.measurement.q = stand(model_, Pose{}, model_.profile().stance.com_height).q.tail(n_);
    reading.measurement.dq = VecX::Zero(n_);
    return reading;
  }
  [[nodiscard]] std::string measurement(std::uint64_t sequence, bool damped = false) const {
    return framed(Type::measurement, encode(reading(sequence, damped)));
  }
  [[nodiscard]] std::string tick(std::uint64_t sequence) const {
    Tick tick;
    tick.reading = reading(sequence);
    tick.target = tick.reading.measurement.q;
    return framed(Type::tick, encode(tick));
  }
  [[nodiscard]] Truth truth() const {
    Truth truth;
    truth.q = VecX::Zero(model_.nq());
    truth.dq = VecX::Zero(model_.nv());
    return truth;
  }
  /// The driver's end hears all of it, and then nothing, or that the connection is closed.
  /// @param ticks that it drives
  /// @param arms that it sends before
  /// @returns whether it came so far
  [[nodiscard]] bool drives(const std::string& said, bool navigates, int ticks, bool hangs_up, Socket::Time patience,
                            const std::optional<ArmTargets>& arms) {
    Socket listener = Socket::listen({"127.0.0.1", 0});
    std::string why;
    std::thread driver([&] {
      why = complaint([&] {
        RemoteRobot::Parameters parameters{{"127.0.0.1", listener.port()}, ""};
        parameters.connecting = parameters.answering = patience;
        RemoteRobot remote(model_, "flat", parameters);
        JointTarget target;
        target.q = remote.read().q;
        target.dq = target.tau = target.ddq = VecX::Zero(n_);
        if (arms) remote.drive_arms(*arms);
        for (int tick = 0; tick < ticks; ++tick) {
          if (navigates) {
            static_cast<void>(remote.guide(Command{}));
          } else {
            remote.write(target);
          }
        }
      });
    });
    std::optional<Socket> peer;
    while (!peer)
      peer = listener.accept();
    peer->send(said, kLinkPatience);
    if (hangs_up) peer.reset();
    driver.join();
    return why.empty();
  }
};

TEST_F(DriversStates, AreThoseOfTheTable) {
  const Table table = table_with("greeting");
  ASSERT_EQ(table.size(), 18U);
  const ArmTargets arms = released_arms(model_);
  for (const auto& row : table) {
    const std::string& event = row.first;
    ASSERT_EQ(row.second.size(), 4U);
    for (const auto& cell : row.second) {
      const std::string& state = cell.first;
      const std::string& expected = cell.second;
      if (expected == "—") continue;
      const bool navigates = state == "driving by commands";
      const bool drives_now = state.starts_with("driving");
      // How it came there; the number of the next measurement or tick; what comes if all is as it should be.
      const std::string before = state == "greeting" ? "" : welcome(navigates) + (drives_now ? measurement(0) : "");
      const std::uint64_t next = drives_now && !navigates ? 1 : 0;
      const auto on = [&](std::uint64_t sequence) { return navigates ? tick(sequence) : measurement(sequence); };
      const std::map<std::string, std::string> said{
          {"welcome", welcome(navigates)},
          {"welcome of another robot", welcome(navigates, true)},
          {"refusal", framed(Type::refusal, encode(Refusal{"busy", "no"}))},
          {"truth", framed(Type::truth, encode(truth()))},
          {"measurement, the next", measurement(next)},
          {"measurement of a damped robot, the next", measurement(next, true)},
          {"measurement, another", measurement(next + 1)},
          {"tick, the next", tick(next)},
          {"tick, another", tick(next + 1)},
          {"rejected", framed(Type::rejected, encode_text("a jump"))},
          {"arms that it has sent", framed(Type::arms, encode(arms))},
          {"other arms", framed(Type::arms, encode(ArmTargets{{"tail"}, {}, {}}))},
          {"damp", framed(Type::damp, encode_text("by key"))},
          {"fault", framed(Type::fault, encode_text("left knee: winding too hot"))},
          {"bye", framed(Type::bye)},
          {"another or malformed message", framed(Type::measurement, "short")},
          {"connection closed", ""},
          {"nothing for too long", ""},
      };
      ASSERT_TRUE(said.contains(event)) << event;
      const bool ends = event == "connection closed" || event == "nothing for too long";
      const std::string& message = said.at(event);
      // What follows if it is then in the state that the table says; if that is gone, whatever follows.
      const bool takes = event.ends_with("the next");
      const auto expect = [&](const std::string& after, int ticks) {
        EXPECT_EQ(drives(before + message + (ends ? "" : after), navigates, ticks, event == "connection closed",
                         event == "nothing for too long" ? Socket::Time(30) : kLinkPatience,
                         navigates ? std::optional(arms) : std::nullopt),
                  expected != "gone")
            << state << ": " << event;
      };
      const auto from = [&](std::uint64_t sequence) {
        std::string after;
        for (const std::uint64_t end = sequence + 4; sequence < end; ++sequence)
          after += !drives_now && sequence == 0 ? measurement(0) : on(sequence);
        return after;
      };
      if (expected == "gone") {
        if (state == "greeting") expect(welcome(false) + from(0), 2);
        for (std::uint64_t sequence = next; sequence < next + 3; ++sequence)
          expect(from(sequence), 2);
      } else if (drives_now) {
        expect(from(takes ? next + 1 : next), takes ? 3 : 2);
      } else {
        expect(from(expected == "starting" ? 0 : 1), 2);
      }
    }
  }
}

TEST_F(DriversStates, EndWithTheReasonOfARefusalThoughNothingCanBeSentAnyMore) {
  Socket listener = Socket::listen({"127.0.0.1", 0});
  std::atomic<bool> closed{false};
  std::string why;
  std::thread driver([&] {
    why = complaint([&] {
      RemoteRobot remote(model_, "flat", {{"127.0.0.1", listener.port()}, ""});
      const VecX zero = VecX::Zero(n_);
      const JointTarget target{remote.read().q, zero, zero, zero, {true, true}, {}};
      while (!closed)
        std::this_thread::yield();
      for (int tick = 0; tick < 5; ++tick)
        remote.write(target);
    });
  });
  std::optional<Socket> peer;
  while (!peer)
    peer = listener.accept();
  std::string said = welcome(false);
  for (std::uint64_t sequence = 0; sequence < 4; ++sequence)
    said += measurement(sequence);
  peer->send(said + framed(Type::refusal, encode(Refusal{"robot", "its own end"})), kLinkPatience);
  Stream heard;
  for (int messages = 0; messages < 2;) {  // hello and start
    if (heard.next()) {
      ++messages;
    } else {
      static_cast<void>(peer->receive(heard.bytes(), kLinkPatience));
    }
  }
  peer.reset();
  closed = true;
  driver.join();
  EXPECT_THAT(why, testing::HasSubstr("refused (robot): its own end"));
}

}  // namespace
}  // namespace baton::link
