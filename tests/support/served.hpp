/// A robot's end in a thread, for tests of connections; and a connection that says whatever a test wants.
#pragma once

#include <netinet/in.h>
#include <sys/socket.h>

#include <atomic>
#include <functional>
#include <limits>
#include <mutex>
#include <string>
#include <thread>
#include <vector>

#include "baton/ik/stand.hpp"
#include "baton/link/remote_robot.hpp"
#include "baton/link/robot_server.hpp"
#include "baton/robot/simulated_robot.hpp"

namespace baton::test {

using link::Message;
using link::RobotServer;

inline constexpr Socket::Time kLinkPatience{20'000};

/// A simulated robot that is served by a thread.
class Served {
 public:
  /// How time passes in real time: when the test says so, or when a measurement has been answered.
  enum class Pace { lock_step, by_test, by_answers };

  explicit Served(const RobotModel& model, const Plant& plant = {}, const std::string& token = "",
                  Pace pace = Pace::lock_step, bool navigates = false)
      : period_(std::chrono::duration_cast<RobotServer::Clock::duration>(
            std::chrono::duration<double>(model.profile().tick.period))),
        pace_(pace),
        robot_(model, world_, stand(model, world_.site("start"), model.profile().stance.com_height),
               model.profile().tick.period, physics(plant)),
        server_(model, robot_,
                {.listen = {"127.0.0.1", 0},
                 .token = token,
                 .world = "flat",
                 .settings = {{"plant", "real"}},
                 .real_time = pace != Pace::lock_step,
                 .navigates_in = navigates ? &world_ : nullptr,
                 .now = [this] { return now_; },
                 .log = [this](const std::string& text) { log_.push_back(text); }}),
        address_(server_.address()),
        thread_([this] { serve(); }) {}
  ~Served() {
    stop_ = true;
    thread_.join();
  }

  [[nodiscard]] const Address& address() const { return address_; }
  [[nodiscard]] const World& world() const { return world_; }

  /// Lets some ticks pass.
  void pass(int ticks) {
    at_the_robot([&](RobotServer&) { now_ += ticks * period_; });
    at_the_robot([](RobotServer&) {});  // it has been served in between
  }

  /// Calls this in the thread, between two messages.
  void at_the_robot(const std::function<void(RobotServer&)>& act) {
    {
      const std::lock_guard lock(mutex_);
      due_ = act;
    }
    while (true) {
      const std::lock_guard lock(mutex_);
      if (!due_) return;
    }
  }
  /// Only for `at_the_robot`.
  [[nodiscard]] const Truth& truth() const { return *robot_.truth(); }
  /// What was logged so far, line by line.
  [[nodiscard]] std::string log() {
    std::string all;
    at_the_robot([&](RobotServer&) {
      for (const std::string& line : log_)
        all += line + '\n';
    });
    return all;
  }

 private:
  static SimulatedRobot::Parameters physics(const Plant& plant) {
    SimulatedRobot::Parameters parameters;
    parameters.plant = plant;
    return parameters;
  }
  void serve() {
    while (!stop_) {
      server_.serve(Socket::Time(1));
      const std::lock_guard lock(mutex_);
      if (due_) due_(server_);
      due_ = nullptr;
      if (pace_ == Pace::by_answers && server_.answered()) now_ += period_;
    }
  }

  const RobotServer::Clock::duration period_;
  const Pace pace_;
  RobotServer::Clock::time_point now_;
  const World world_ = World::load("flat");
  SimulatedRobot robot_;
  std::vector<std::string> log_;
  RobotServer server_;
  const Address address_;
  std::mutex mutex_;
  std::function<void(RobotServer&)> due_;
  std::atomic<bool> stop_{false};
  std::thread thread_;
};

/// A connection without manners.
class Raw {
 public:
  explicit Raw(const Address& address) : socket_(Socket::connect(address, kLinkPatience)) {}

  /// Makes the robot's end, if it is in this process, send little at a time.
  void narrow() const {
    constexpr int kDescriptors = 1024;
    for (int descriptor = 0; descriptor < kDescriptors; ++descriptor) {
      sockaddr_in peer{};
      socklen_t size = sizeof peer;
      const int little = 1;
      if (getpeername(descriptor, reinterpret_cast<sockaddr*>(&peer), &size) == 0 &&
          ntohs(peer.sin_port) == socket_.port())
        static_cast<void>(setsockopt(descriptor, SOL_SOCKET, SO_SNDBUF, &little, sizeof little));
    }
  }
  void send(const std::string& bytes) { socket_.send(bytes, kLinkPatience); }
  void send(link::Type type, const std::string& body) { send(link::framed(type, body)); }
  Message receive() {
    while (true) {
      if (const std::optional<Message> message = stream_.next()) return *message;
      if (!socket_.receive(stream_.bytes(), kLinkPatience)) throw LinkError("nothing came");
    }
  }
  /// The next message that is not truth.
  Message answer() {
    Message message = receive();
    while (message.type == link::Type::truth)
      message = receive();
    return message;
  }
  /// Whether the other end closes the connection.
  bool closed() {
    try {
      while (socket_.receive(stream_.bytes(), kLinkPatience)) {
      }
    } catch (const LinkError&) {
      return true;
    }
    return false;
  }

 private:
  Socket socket_;
  link::Stream stream_;
};

inline std::string hello(int version = link::kVersion, const std::string& token = "") {
  return encode(link::Hello{version, token, link::Role::drive});
}

/// "reason: text" of a refusal.
inline std::string refused(const Message& message) {
  if (message.type != link::Type::refusal) return "";
  const link::Refusal refusal = link::decode_refusal(message.body);
  return refusal.reason + ": " + refusal.text;
}

/// What is thrown; "": nothing.
template <typename Thrower>
std::string complaint(const Thrower& thrower) {
  try {
    thrower();
  } catch (const std::runtime_error& error) {
    return error.what();
  }
  return "";
}

}  // namespace baton::test
