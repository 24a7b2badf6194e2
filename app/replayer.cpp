#include "app/replayer.hpp"

#include <fmt/format.h>

#include <bit>
#include <cmath>
#include <utility>

#include "app/inputs.hpp"
#include "app/options.hpp"
#include "baton/ik/stand.hpp"
#include "baton/model/error.hpp"
#include "baton/record/event_json.hpp"

namespace baton::app {
namespace {

Modes modes_in(const RecordingHead& head) {
  return modes_of({head.duration, head.gait, head.on_limit});
}

/// @throws InputError it is one of another robot
Posture start_of(const RecordingReader& recording, const RobotModel& robot, const World& world) {
  const RecordingHead& head = recording.head();
  if (head.start.empty()) return stand(robot, world.site("start"), robot.profile().stance.com_height);
  if (head.start.size() != static_cast<std::size_t>(robot.nq())) {
    throw InputError(fmt::format("{}: start has {} members: must be a list of {} numbers", recording.place(),
                                 head.start.size(), robot.nq()));
  }
  return posture_of(robot, Eigen::Map<const VecX>(head.start.data(), robot.nq()));
}

bool same_bits(double a, double b) {
  return std::bit_cast<std::uint64_t>(a) == std::bit_cast<std::uint64_t>(b);
}

/// The joint whose target differs most, and by how much; "": none does.
/// @param recorded `recorded_angle` of each
std::string difference_of(const VecX& target, const VecX& recorded, const std::vector<std::string>& joints) {
  double most = -1.0;
  std::size_t joint = 0;
  for (Eigen::Index j = 0; j < target.size(); ++j) {
    const double by = std::abs(target[j] - recorded[j]);
    if (same_bits(recorded_angle(target[j]), recorded[j]) || by <= most) continue;
    most = std::isnan(by) ? HUGE_VAL : by;
    joint = static_cast<std::size_t>(j);
  }
  if (most < 0.0) return "";
  return fmt::format("the joint targets differ from the recorded ones by up to {:.3g} rad, at {}: {} instead of {}",
                     most, joints[joint], target[static_cast<Eigen::Index>(joint)],
                     recorded[static_cast<Eigen::Index>(joint)]);
}

std::string listed(const std::vector<nlohmann::json>& events) {
  std::string text;
  for (const nlohmann::json& event : events)
    text += (text.empty() ? "" : " ") + event.dump();
  return text.empty() ? "nothing" : text;
}

}  // namespace

Replayer::Replayer(const std::filesystem::path& recording, bool verify)
    : recording_(recording),
      verify_(verify),
      robot_(
          named_in(recording_.place(), [&] { return load_robot(recording_.head().robot, recording_.head().drive); })),
      world_(named_in(recording_.place(), [&] { return World::load(recording_.head().world); })),
      strategy_(robot_, world_, modes_in(recording_.head())) {
  for (const Joint& joint : robot_.joints())
    joints_.push_back(joint.name);
  navigator_.emplace(robot_, world_, start_of(recording_, robot_, world_), modes_in(recording_.head()).gait,
                     state_named(recording_.head().state));
  if (recording_.head().hangs) navigator_->hang();
}

bool Replayer::step() {
  std::optional<RecordedTick> next = recording_.next(joints_);
  if (!next) return false;
  gap_ = next->number - (navigator_->now() + 1);
  if (gap_ != 0) return false;
  tick_ = std::move(next);
  for (const ArmTargets& targets : tick_->arms)
    named_in(recording_.place(), [&] { navigator_->drive_arms(targets); });
  target_ = &navigator_->tick(tick_->measurement, tick_->command);
  if (verify_) compare();
  navigator_->poll();
  plan();
  return true;
}

void Replayer::compare() {
  difference_ = difference_of(target_->q, tick_->target, joints_);
  if (!difference_.empty()) return;
  if (checksum(*target_) != tick_->checksum) {
    difference_ =
        "the joint targets differ from the recorded ones: angles by less than 1e-6 rad, or speeds, accelerations, "
        "torques or contacts";
    return;
  }
  const std::vector<nlohmann::json> events = event_messages(*navigator_);
  if (events != tick_->events)
    difference_ = fmt::format("{} happens, in the recording {}", listed(events), listed(tick_->events));
}

void Replayer::plan() {
  for (const PlanningEvent call : tick_->calls) {
    if (call == PlanningEvent::answer) {
      if (answer_) navigator_->answer(*std::exchange(answer_, std::nullopt));
      continue;
    }
    const std::optional<Request> request = navigator_->request();
    if (!request && verify_ && difference_.empty()) difference_ = "no planning request is due, unlike in the recording";
    if (request) answer_ = strategy_.plan(*request);
  }
}

}  // namespace baton::app
