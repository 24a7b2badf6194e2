#include "app/remote_end.hpp"

#include <fmt/format.h>
#include <spdlog/spdlog.h>

#include <cmath>

#include "app/inputs.hpp"
#include "app/options.hpp"
#include "baton/ik/stand.hpp"
#include "baton/link/echoed_planning.hpp"
#include "baton/link/engage.hpp"
#include "baton/link/hanging.hpp"
#include "baton/link/onboard.hpp"
#include "baton/model/error.hpp"

namespace baton::app {
namespace {

constexpr double kSettled = 0.5;          ///< time of rest after which a robot has taken its stance, or cannot [s]
constexpr double kLate = 0.1;             ///< delay of measurements from which the stick counts as centred [s]
constexpr double kLow = 0.2;              ///< charge of a battery of which the driver is warned
constexpr std::size_t kMostNotes = 1000;  ///< in the report

}  // namespace

RemoteEnd::RemoteEnd(const DriveOptions& o, const RobotModel& robot, const World& world)
    : address_(o.on), model_(&robot), hangs_(o.gantry) {
  check_physics(o.physics, o.on);
  const link::NavigationOptions navigation{modes_of(o.modes), state_named(o.physics.state), o.gantry};
  const auto accept = [&](const link::Welcome& robots_end) {
    const auto belongs_there = [&](const char* option, bool given) {
      if (given && robots_end.navigates)
        throw InputError(
            fmt::format("{} with --on {}: that robot navigates by itself; it goes with a robot that follows "
                        "targets (baton robot --targets)",
                        option, o.on));
    };
    belongs_there("--calibration", o.calibration.has_value());
    belongs_there("--answer-delay", o.answers.delay_ms > 0.0);
    belongs_there("--answer-loss", o.answers.loss > 0.0);
  };
  owned_ = std::make_unique<link::RemoteRobot>(
      robot, world.name(),
      link::RemoteRobot::Parameters{
          .address = Address::parse(o.on), .token = token_in(o.token), .navigation = navigation, .accept = accept});
  remote_ = owned_.get();
  for (const auto& check : {link::lacks, link::in_other_units}) {
    if (const auto what = check(remote_->read(), navigation.source))
      throw InputError(fmt::format("the robot at {}: {}", o.on, *what));
  }
}

std::map<std::string, std::string> RemoteEnd::settings() const {
  return plant_settings(welcome().settings);
}

Posture RemoteEnd::start(const World& world, const std::optional<Calibration>& calibration) {
  if (hangs_ && !welcome().navigates) return stand(*model_, world.site("start"), model_->profile().stance.com_height);
  const Measurement seen = calibration ? without_errors(remote_->read(), *calibration) : remote_->read();
  const Posture start = named_in(address_, [&] { return link::engage(*model_, world.site("start"), seen.q); });
  in_stance_ = link::in_stance(*model_, start.q.tail(seen.q.size()));
  engaging_ = !in_stance_;
  if (engaging_) spdlog::info("takes its stance first");
  return start;
}

std::unique_ptr<Planning> RemoteEnd::planning(std::unique_ptr<Planning> planner) const {
  if (!welcome().navigates) return planner;
  return std::make_unique<link::EchoedPlanning>(*remote_, std::move(planner));
}

void RemoteEnd::begin(const std::optional<Calibration>& calibration, const std::function<bool()>& go_on) {
  if (welcome().navigates) return;  // the session runs each tick
  remote_->catch_up();
  if (!hangs_) return;
  spdlog::info("hangs: takes its stance");
  const Calibration errors = calibration ? *calibration : Calibration::none(model_->nv() - 6);
  named_in(address_, [&] { link::take_stance(*model_, *remote_, errors, go_on); });
  spdlog::info("in its stance: lower it until it stands, then slacken the ropes");
}

bool RemoteEnd::step(Session& session, const std::function<Command()>& stick) {
  try {
    if (welcome().navigates) {
      const Command followed = remote_->guide(stick);
      for (const ArmTargets& targets : remote_->accepted_arms())
        session.drive_arms(targets);
      session.step(followed);
    } else {
      look_held(session);
      const Command command = stick();
      session.step(held_ ? Command{} : command);
      look_late();
    }
    t_ = session.t();
    look_fault();
    if (engaging_) look_engaged(session);
    warn();
    if (const std::string why = remote_->follows_no_longer(); !why.empty()) end(why);
  } catch (const LinkError& error) {
    end(error.what());
  }
  return broken_.empty();
}

void RemoteEnd::drive_arms(Session& session, const ArmTargets& targets) {
  if (!welcome().navigates) {
    if (!held_) session.drive_arms(targets);
    return;
  }
  try {
    remote_->drive_arms(targets);
  } catch (const LinkError& error) {
    end(error.what());
  }
}

void RemoteEnd::damp(const std::string& because) {
  if (damped_) return;
  try {
    remote_->damp(because);
    damped_ = true;
  } catch (const LinkError& error) {
    if (!std::exchange(undamped_, true)) spdlog::error("{}: not damped: {}", address_, error.what());
  }
}

void RemoteEnd::meanwhile(std::function<void()> passing) {
  remote_->meanwhile(std::move(passing));
}

void RemoteEnd::note(bool warning, const char* what, const std::string& text) {
  spdlog::log(warning ? spdlog::level::warn : spdlog::level::info, "{}", text);
  new_notes_.push_back({t_, what, text});
  if (notes_.size() < kMostNotes) notes_.push_back(new_notes_.back());
}

void RemoteEnd::end(const std::string& why) {
  if (!broken_.empty()) return;
  broken_ = why;  // logged as the reason of the run's end
  new_notes_.push_back({t_, remote_->damped() ? "damped" : "broken", why});
  if (notes_.size() < kMostNotes) notes_.push_back(new_notes_.back());
}

void RemoteEnd::look_held(Session& session) {
  const bool was_held = std::exchange(held_, late_ || !remote_->fault().empty());
  if (held_ && !was_held) session.drive_arms(released_arms(*model_));
}

void RemoteEnd::look_late() {
  const bool was_late = std::exchange(late_, remote_->late() > kLate);
  if (late_) ++late_ticks_;
  if (late_ == was_late) return;
  if (late_) {
    note(true, "late", fmt::format("link: the robot's measurements come {:.2f} s late: it rests", remote_->late()));
  } else {
    note(false, "in_time", "link: the robot's measurements are in time again");
  }
}

void RemoteEnd::look_fault() {
  if (remote_->fault() == fault_) return;
  fault_ = remote_->fault();
  if (fault_.empty()) {
    note(false, "fault_over", "the robot reports no fault any more");
  } else {
    note(true, "fault", fmt::format("the robot reports a fault: {}: it rests", fault_));
  }
}

std::string RemoteEnd::notice() const {
  if (!fault_.empty()) return fmt::format("The robot reports a fault: {}. No new motion until it is over.", fault_);
  if (late_ || stale_) return "The connection to the robot is slow: no new motion until it is faster.";
  return "";
}

void RemoteEnd::look_engaged(const Session& session) {
  const bool held = held_ || (welcome().navigates && remote_->tick().stale);
  rested_ = session.resting() && !held ? rested_ + 1 : 0;
  engaging_ = static_cast<double>(rested_) * model_->profile().tick.period < kSettled;
  if (engaging_) return;
  const VecX& q = session.navigator().state().q;
  if (link::in_stance(*model_, q.tail(q.size() - 7))) {
    spdlog::info("in its stance");
  } else {
    const bool refused = session.navigator().refusal() != nullptr;
    spdlog::warn("does not find to its stance{}: guide it from where it is", refused ? ", refused" : "");
  }
}

void RemoteEnd::warn() {
  if (remote_->battery() < kLow && !std::exchange(low_, true))
    note(true, "battery", fmt::format("the robot's battery is at {:.0f} %", 100.0 * remote_->battery()));
  if (remote_->rejected() > 0 && !std::exchange(told_, true))
    note(true, "rejected", fmt::format("the robot has rejected a target: {}", remote_->rejection()));
  if (!welcome().navigates || !fault_.empty()) return;  // a fault makes it count as stale
  if (std::exchange(stale_, remote_->tick().stale) == remote_->tick().stale) return;
  if (stale_) {
    note(true, "late",
         fmt::format("link: the stick's positions are more than {} s old when they come to the robot: it rests",
                     link::Onboard::kFresh));
  } else {
    note(false, "in_time", "link: the stick's positions are in time again");
  }
}

nlohmann::json RemoteEnd::json() const {
  nlohmann::json notes = nlohmann::json::array();
  for (const LinkNote& note : notes_)
    notes.push_back({{"t", note.t}, {"what", note.what}, {"text", note.text}});
  return {{"notes", std::move(notes)},
          {"address", address_},
          {"navigates", welcome().navigates},
          {"rejected", remote_->rejected()},
          {"stale", remote_->stale()},
          {"late", late_ticks_},
          {"battery", std::isfinite(remote_->battery()) ? nlohmann::json(remote_->battery()) : nlohmann::json()},
          {"broken", broken_}};
}

}  // namespace baton::app
