#include "bridge/unitree/low_level.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <utility>

#include "bridge/unitree/reading.hpp"

namespace baton::unitree {
namespace {

constexpr double kPeriod = 0.002;   ///< of commands, if no states come [s]
constexpr double kLate = 0.5e-3;    ///< that a state may be before a command goes out without [s]
constexpr double kStrangers = 1.0;  ///< [s]
constexpr std::chrono::milliseconds kFarewell{500};
constexpr std::size_t kMostKinds = 50;  ///< of what is ignored, which others cannot let grow

}  // namespace

LowLevel::LowLevel(const RobotModel& model, const std::string& interface, Network::Speaks speaks)
    : network_(interface, speaks), motors_(model), thread_([this] { run(); }) {}

LowLevel::~LowLevel() {
  with_motors([](Motors& motors) { motors.damp("the bridge ends"); });
  if (commanding_) std::this_thread::sleep_for(kFarewell);
  stop_ = true;
  thread_.join();
}

double LowLevel::now() const {
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - start_).count();
}

std::vector<std::string> LowLevel::messages() {
  const std::scoped_lock lock(mutex_);
  return std::exchange(messages_, {});
}

std::string LowLevel::ignored() {
  const std::scoped_lock lock(mutex_);
  std::vector<std::string> all;
  for (const auto& [what, times] : ignored_)
    all.push_back(fmt::format("{} × {}", times, what));
  return fmt::format("{}", fmt::join(all, ", "));
}

std::string LowLevel::broken() {
  const std::scoped_lock lock(mutex_);
  return broken_;
}

void LowLevel::complain(const std::string& what) {
  if (!ignored_.contains(what) && ignored_.size() >= kMostKinds) return;
  if (ignored_[what]++ == 0) messages_.push_back("ignored: " + what + "; the next ones are counted");
}

void LowLevel::run() {
  try {
    while (!stop_)
      turn();
  } catch (const std::exception& error) {
    const std::scoped_lock lock(mutex_);
    broken_ = error.what();
  }
}

void LowLevel::turn() {
  network_.wait(commanded_at_ + kPeriod + kLate - now());
  const double t = now();
  const std::scoped_lock lock(mutex_);
  const auto ignore = [this](const std::string& what) { complain(what); };
  bool heard = false;
  while (const std::optional<LowState> state = network_.state(ignore)) {
    const std::optional<std::string> why = motors_.hear(*state, t);
    if (why) complain("a state: " + *why);
    heard = heard || !why;
  }
  motors_.pass(t);
  if (network_.foreign_command()) {
    foreign_at_ = t;
    if (commanding_) {
      complain("a command of somebody else on rt/lowcmd");
      motors_.damp("somebody else commands the motors");
    }
  }
  if (t - strangers_at_ > kStrangers) {
    strangers_at_ = t;
    network_.look_for_strangers(ignore);
  }
  if (!heard && t - commanded_at_ < kPeriod) return;
  commanded_at_ = t;
  if (commanding_ && motors_.heard()) network_.send(motors_.command(t));
}

Measurement G1::read() {
  read_at_ = low_level_->now();
  return low_level_->with_motors([this](const Motors& motors) {
    Measurement measured = measurement_of(motors.heard()->state, motors.motors(), motors.heard()->t);
    measured.age = read_at_ - measured.t;
    return measured;
  });
}

void G1::write(const JointTarget& target) {
  const double end = read_at_ + model_->profile().tick.period;
  low_level_->with_motors([&](Motors& motors) { motors.follow(target, end, low_level_->now()); });
}

}  // namespace baton::unitree
