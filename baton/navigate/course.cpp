#include "baton/navigate/course.hpp"

#include <algorithm>
#include <cmath>
#include <type_traits>
#include <utility>

#include "baton/ik/stand.hpp"

namespace baton {
namespace {

constexpr double kSettles = 0.5;   ///< rate at which the planning frame follows the soles [ω]
constexpr double kInPlace = 1e-3;  ///< displacement and turn of the soles that it does not follow [COM height, rad]

Course::Rest rest_at(const RobotModel& robot, const Posture& posture) {
  return {std::make_shared<const Posture>(posture), std::make_shared<const MotionSample>(resting(robot, posture))};
}

}  // namespace

Course::Course(const RobotModel& robot, const Posture& start)
    : robot_(&robot), rest_(rest_at(robot, start)), sample_(rest_.sample.get()), foothold_(start.sole) {}

void Course::advance(Retired& retired) {
  const Motion* motion = this->motion();
  if (motion != nullptr && ++index_ == motion->ticks()) {
    note_steps(last_step_, foothold_);
    const std::shared_ptr<const Answer> ended = *handle();
    retired.keep(std::move(rest_.posture));
    retired.keep(std::move(rest_.sample));
    rest_ = {std::shared_ptr<const Posture>(ended, &motion->end),
             std::shared_ptr<const MotionSample>(ended, &motion->rest)};
    retire(retired);
    motion = nullptr;
  }
  sample_ = motion != nullptr ? &motion->samples[static_cast<std::size_t>(index_)] : rest_.sample.get();
}

void Course::commit(std::shared_ptr<const Answer> answer, std::shared_ptr<const Trail> trail, Retired& retired) {
  retire(retired);
  const Motion& motion = *answer->motion();
  const GuideContext& context = answer->context;
  index_ = 0;
  sample_ = &motion.samples.front();
  anchor_ = context.anchor;
  slip_free_frame_ = context.slip_free_frame * motion.goal.drift_correction.inverse();
  last_step_ = context.last_step;
  foothold_ = context.foothold;
  uncertainty_ = context.place_uncertainty;
  ++committed_;
  if (answer->capture() != nullptr) {
    ++caught_;
    state_ = Catching{std::move(answer)};
  } else if (std::holds_alternative<Retrace>(answer->intent)) {
    state_ = Retracing{{std::move(answer)}, std::move(trail)};
  } else if (std::holds_alternative<HaltAt>(answer->intent)) {
    state_ = Halting{std::move(answer)};
  } else if (std::holds_alternative<Stop>(answer->intent)) {
    state_ = Stopping{std::move(answer)};
  } else {
    state_ = Moving{std::move(answer)};
  }
}

void Course::drop(Retired& retired) {
  retire(retired);
  sample_ = rest_.sample.get();
}

void Course::settle(const Pose& slid) {
  const double yaw = yaw_of(slid.R);
  const double in_place = kInPlace * robot_->profile().stance.com_height;
  if (distance_at(slid, {}, sample_->com) < in_place && std::abs(yaw) < kInPlace) return;
  const double share = std::min(1.0, kSettles * robot_->omega() * robot_->profile().tick.period);
  anchor_ = anchor_ * Pose{share * slid.p, rotation_z(share * yaw)};
}

void Course::forget_trail() {
  if (auto* back = std::get_if<Retracing>(&state_)) back->trail.reset();
}

void Course::begin_anew(const Posture& posture) {
  rest_ = rest_at(*robot_, posture);
  sample_ = rest_.sample.get();
  foothold_ = posture.sole;
  slip_free_frame_ = anchor_;
  uncertainty_ = 0.0;
}

const MotionSample& Course::next_sample() const {
  const Motion* motion = this->motion();
  return motion != nullptr ? motion->samples[static_cast<std::size_t>(index_) + 1] : *rest_.sample;
}

void Course::note_steps(Side& last_step, BySide<Pose>& foothold) const {
  const Goal& goal = motion()->goal;
  for (const Side side : kSides) {
    if (goal.contact[side]) foothold[side] = goal.sole[side];
  }
  if (goal.swing) last_step = *goal.swing;
}

const std::shared_ptr<const Answer>* Course::handle() const {
  return std::visit(
      [](const auto& state) -> const std::shared_ptr<const Answer>* {
        if constexpr (std::is_base_of_v<Executing, std::decay_t<decltype(state)>>) return &state.answer;
        return nullptr;
      },
      state_);
}

void Course::retire(Retired& retired) {
  if (const auto* answer = handle()) retired.keep(*answer);
  if (auto* back = std::get_if<Retracing>(&state_)) retired.keep(std::move(back->trail));
  state_ = Resting{};
}

}  // namespace baton
