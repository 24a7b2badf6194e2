/// The motors' end: a thread of its own that listens to the robot, decides what its motors are told, and tells them.
///
/// Each new state of the robot is answered by a command, so that commands go out at the robot's own rate (500 Hz) and
/// with its newest state; if states stay out, commands go out by the clock. The robot's end of the protocol runs in
/// another thread: if that one hangs, on a log that nobody reads for example, the motors' end notices and damps.
#pragma once

#include <atomic>
#include <chrono>
#include <map>
#include <mutex>
#include <string>
#include <thread>
#include <vector>

#include "baton/robot/robot.hpp"
#include "bridge/unitree/motors.hpp"
#include "bridge/unitree/network.hpp"

namespace baton::unitree {

class LowLevel {
 public:
  /// `model` must outlive this object. It listens, and says nothing to the motors yet.
  /// @throws InputError the model is not that of a G1, or there is no such interface
  /// @param speaks whether it can ever say something
  LowLevel(const RobotModel& model, const std::string& interface, Network::Speaks speaks);
  /// Before it ends, the motors are told to brake for a while.
  ~LowLevel();
  LowLevel(const LowLevel&) = delete;
  LowLevel& operator=(const LowLevel&) = delete;

  /// By which states arrive: from the start of this object [s].
  [[nodiscard]] double now() const;
  [[nodiscard]] Network& network() { return network_; }
  /// From now on the motors are commanded.
  void command() { commanding_ = true; }
  /// Does something with the motors while nobody else does.
  template <typename Do>
  auto with_motors(Do&& something) {
    const std::scoped_lock lock(mutex_);
    return something(motors_);
  }
  /// Time since somebody else sent a command, or since this object listens [s].
  [[nodiscard]] double alone_for() const { return now() - foreign_at_; }
  /// What is worth a log, since the last call.
  [[nodiscard]] std::vector<std::string> messages();
  /// What was ignored, and how often: "2 × wrong checksum"; "": nothing was.
  [[nodiscard]] std::string ignored();
  /// Why the thread has ended; "": it has not.
  [[nodiscard]] std::string broken();

 private:
  void run();
  void turn();
  /// Counts what is ignored. The first of a kind is a message.
  void complain(const std::string& what);

  std::chrono::steady_clock::time_point start_ = std::chrono::steady_clock::now();
  Network network_;
  mutable std::mutex mutex_;
  Motors motors_;
  std::vector<std::string> messages_;
  std::map<std::string, long> ignored_;
  std::string broken_;
  double commanded_at_ = 0.0;  ///< [s]
  double strangers_at_ = 0.0;  ///< when they were looked for [s]
  std::atomic<double> foreign_at_{0.0};
  std::atomic<bool> commanding_{false};
  std::atomic<bool> stop_{false};
  std::thread thread_;
};

/// A G1 as the robot's end of the protocol moves it (RobotServer with `immediate`).
class G1 : public Robot {
 public:
  /// Both must outlive this object.
  G1(const RobotModel& model, LowLevel& low_level) : model_(&model), low_level_(&low_level) {}

  [[nodiscard]] Measurement read() override;
  void write(const JointTarget& target) override;
  void reset() override {}  ///< it stays where it is

 private:
  const RobotModel* model_;
  LowLevel* low_level_;
  double read_at_ = 0.0;  ///< [s]
};

}  // namespace baton::unitree
