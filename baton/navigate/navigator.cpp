#include "baton/navigate/navigator.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "baton/ik/stand.hpp"

namespace baton {
namespace {

constexpr double kPatience = 0.05;      ///< time from a refusal at rest to the next request, for any robot [s]
constexpr double kArmsPatience = 0.25;  ///< the same for the arms alone, also on the way, for any robot [s]
constexpr double kStickPatience = 0.5;  ///< for which arms come before a command that has no motion, any robot [s]
constexpr int kMostLate = 5;            ///< doublings of the lookahead at rest, when answers come too late

/// Whether an answer is taken over in spite of a push or a centred stick.
bool urgent(const Answer& answer) {
  return stops(answer.intent) || answer.capture() != nullptr;
}

}  // namespace

Navigator::Navigator(const RobotModel& robot, const World& world, const Posture& start, Gait gait, StateSource source)
    : robot_(&robot),
      world_(&world),
      gait_(gait),
      watch_(robot, world, source, start),
      course_(robot, start),
      stabiliser_(robot),
      arms_(robot) {
  const VecX zero = VecX::Zero(robot.nv() - 6);
  soft_ = {zero, zero, zero, zero, {false, false}, zero};
}

const JointTarget& Navigator::tick(const Measurement& measurement, const Command& command) {
  ++tick_;
  events_.clear();
  command_ = sanitised(command);
  if (!(command_ == refused_.command)) drop_refusal();
  exchange_.countered = exchange_.countered || command_.recall == Recall::stop;

  course_.advance(retired_);
  tell_end();
  watch_.estimate(measurement, course_.sample(), course_.anchor());
  const bool soft = watch_.soft();
  watch_.judge(course_.sample(), course_.anchor(), command_.neutral());
  if (watch_.soft() && !soft) drop_plan();
  // A new motion begins where the old one is, in a planning frame of its own.
  if (take_over()) watch_.change_frame(course_.sample(), course_.anchor());
  if (watch_.slip_found()) course_.accept_slip(watch_.slid(course_.sample()));
  tell_changes();
  if (watch_.soft()) {
    // Where the joints are, so that a servo gives no torque either.
    const Eigen::Index n = soft_.q.size();
    for (Eigen::Index j = 0; j < n; ++j)
      soft_.q[j] = std::isfinite(measurement.q[j]) ? measurement.q[j] : watch_.state().q[7 + j];
    watch_.warm(soft_);
    return soft_;
  }
  const JointTarget& target = stabiliser_.target(course_.sample(), course_.next_sample(), watch_.state(),
                                                 watch_.stands(), watch_.odometry().play());
  watch_.warm(target);
  // A way back may be minutes long, and soles slide on each step of it.
  if (motion() == nullptr || course_.is<Retracing>()) course_.settle(watch_.slid(course_.sample()));
  if (motion() == nullptr && command_.neutral()) course_.accept_place();
  return target;
}

void Navigator::drive_arms(const ArmTargets& targets) {
  const double now = static_cast<double>(tick_ + 1) * robot_->profile().tick.period;
  arms_ = arms_.continued(targets, now, course_.sample().q.tail(robot_->nv() - 6));
  arms_refusal_ = nullptr;
}

void Navigator::poll() {
  retired_.clear();
  if (watch_.guard() == Guard::stood_up && command_.neutral() && watch_.supported()) begin_anew();
  if (watch_.slipped()) {  // what led here does not lead back
    history_.clear();
    course_.forget_trail();
  }
  history_.forget();
}

Situation Navigator::situation() const {
  return {*robot_,      *world_,   gait_,    course_,  history_, watch_,
          correction(), exchange_, refused_, command_, arms_,    tick_};
}

std::optional<Request> Navigator::request() {
  if (watch_.guard() != Guard::armed || tick_ < 0 || exchange_.awaited) return std::nullopt;
  std::optional<Request> request = due(situation());
  if (!request) return std::nullopt;
  exchange_.asked_at = tick_;
  exchange_.take_over = request->at;
  exchange_.awaited = true;
  const Intent& first = request->intents.front();
  exchange_.for_stop = stops(first);
  exchange_.countered = false;
  return request;
}

Request Navigator::request_for(const Command& command) const {
  return request_from_rest(situation(), command);
}

void Navigator::answer(Answer answer) {
  if (!exchange_.awaited || answer.at != exchange_.take_over || answer.at <= tick_) return;
  exchange_.answer = std::make_shared<const Answer>(std::move(answer));
}

bool Navigator::take_over() {
  if (!exchange_.awaited || exchange_.take_over > tick_) return false;
  exchange_.awaited = false;
  const std::shared_ptr<const Answer> answer = std::exchange(exchange_.answer, nullptr);
  retired_.keep(answer);
  if (!answer) {
    ++exchange_.dropped;
    exchange_.asked_at = 0;  // again, at once
    events_.add(AnswerLate{});
  }
  // At rest nothing is lost by waiting longer for the next answer.
  exchange_.late = answer ? 0 : std::min(exchange_.late + (motion() != nullptr ? 0 : 1), kMostLate);
  if (!answer) return false;
  if (!valid(*answer)) {
    if (std::holds_alternative<MoveArms>(answer->intent)) rest_arms();
    return false;
  }
  if (answer->motion() != nullptr) {
    commit(answer);
    return true;
  }
  if (motion() == nullptr || !urgent(*answer)) refuse(answer);  // else the motion under way ends at rest
  return false;
}

bool Navigator::valid(const Answer& answer) const {
  if (watch_.guard() != Guard::armed) return false;
  const bool ordinary = !urgent(answer);
  if (watch_.disturbed() && ordinary) return false;  // pushed meanwhile
  if (motion() == nullptr && correction().settling && ordinary) return false;
  // Let go of meanwhile: the motion under way ends at rest.
  const bool arms = std::holds_alternative<MoveArms>(answer.intent);
  if (arms && command_.recall != Recall::none) return false;
  if (ordinary && (exchange_.countered || (motion() != nullptr && command_.neutral() && !arms))) return false;
  const Motion* next = answer.motion();
  if (next == nullptr) return true;
  if (std::holds_alternative<Retrace>(answer.intent) && history_.empty()) return false;  // a slip has ended it
  // Who holds the stick does not wait for arms.
  const bool alone = motion() == nullptr || motion()->goal.kind == SegmentKind::arms || command_.neutral();
  if (arms && !alone && next->ticks() > motion()->ticks() - course_.index()) return false;
  const bool sooner = motion() == nullptr || next->ticks() < motion()->ticks() - course_.index();
  return !stops(answer.intent) || course_.is<Retracing>() || sooner;
}

void Navigator::commit(std::shared_ptr<const Answer> answer) {
  const bool arms = std::holds_alternative<MoveArms>(answer->intent);
  if (!arms || motion() == nullptr) exchange_.answered = answer->command;
  std::shared_ptr<const Trail> retraced;
  const auto* back = std::get_if<Retracing>(&course_.state());
  if (std::holds_alternative<Retrace>(answer->intent)) {
    retraced = history_.retrace(*answer);
  } else if (motion() == nullptr) {
    history_.append(answer->trail);
  } else if (back != nullptr && !motion()->leaves) {
    if (back->trail) history_.append(answer->trail);  // or a slip has ended that way back
  } else {
    history_.replace_newest(answer->trail, retired_);
  }
  const std::optional<Refusal>& why = arms ? answer->planned()->limit : answer->arms_rest;
  if (why || answer->motion()->goal.arm_path) note_arms(answer, why ? &*why : nullptr);
  course_.commit(std::move(answer), std::move(retraced), retired_);
  if (!arms) drop_refusal();
  told_.executing = true;
  events_.add(Committed{course_.committed() - 1});
}

void Navigator::rest_arms() {
  exchange_.arms_again = tick_ + std::lround(kArmsPatience / robot_->profile().tick.period);
}

void Navigator::note_arms(const std::shared_ptr<const Answer>& answer, const Refusal* why) {
  const bool before = arms_refusal_ != nullptr;
  retired_.keep(std::exchange(arms_refusal_, nullptr));
  if (why == nullptr) return;
  arms_refusal_ = {answer, why};
  if (!before) events_.add(ArmsRefused{});
}

void Navigator::refuse(const std::shared_ptr<const Answer>& answer) {
  const Refusal* refusal = answer->refusal();
  if (std::holds_alternative<MoveArms>(answer->intent)) {
    note_arms(answer, refusal);
    rest_arms();
    return;
  }
  const bool at_rest = motion() == nullptr;
  exchange_.in_vain = answer->command;
  exchange_.stick_again = tick_ + std::lround(kStickPatience / robot_->profile().tick.period);
  if (at_rest && refusal == nullptr) return;
  if (refusal != nullptr && (at_rest || !answer->context.stick_held)) {
    events_.add(Refused{refused_.refusal != nullptr});
    drop_refusal();
    refused_.refusal = {answer, refusal};
  }
  refused_.at_rest = at_rest;
  refused_.command = answer->command;
  if (at_rest) {
    refused_.anchor = answer->context.anchor;
    refused_.retry_at = tick_ + std::lround(kPatience / robot_->profile().tick.period);
  } else {
    exchange_.answered = answer->command;  // it is asked again where the motion can go on, or at rest
  }
}

void Navigator::drop_refusal() {
  retired_.keep(std::exchange(refused_.refusal, nullptr));
}

void Navigator::drop_plan() {
  course_.drop(retired_);
  exchange_.awaited = false;
  retired_.keep(std::exchange(exchange_.answer, nullptr));
}

void Navigator::begin_anew() {
  course_.begin_anew(posture_of(*robot_, watch_.state().q));
  stabiliser_.reset();
  history_.clear();
  drop_refusal();
  arms_ = ArmTrajectory(*robot_);  // they do not go on by themselves
  arms_refusal_ = nullptr;
  watch_.arm();
}

void Navigator::tell_end() {
  if (std::exchange(told_.executing, motion() != nullptr) && motion() == nullptr) events_.add(Ended{});
}

void Navigator::tell_changes() {
  tell_end();
  if (watch_.slips() != told_.slips) events_.add(Slipped{watch_.last_slip()});
  if (watch_.disturbed() != told_.disturbed) events_.add(DisturbedChanged{watch_.disturbed()});
  if (watch_.guard() != told_.guard) events_.add(GuardChanged{told_.guard, watch_.guard()});
  const bool hot = watch_.thermometer().hot();
  if (std::exchange(told_.hot, hot) != hot) events_.add(HeatChanged{hot});
  told_.executing = motion() != nullptr;
  told_.guard = watch_.guard();
  told_.disturbed = watch_.disturbed();
  told_.slips = watch_.slips();
  for (const Sensor sensor : kSensors) {
    const Health health = watch_.sensors().health(sensor);
    if (std::exchange(told_.health[sensor], health) != health) events_.add(SensorChanged{sensor, health});
  }
}

Purpose Navigator::purpose() const {
  if (motion() == nullptr) return Purpose::none;
  const Intent& intent = course_.answer()->intent;
  if (std::holds_alternative<Catch>(intent)) return Purpose::capture;
  if (std::holds_alternative<Retrace>(intent)) return Purpose::retrace;
  if (std::holds_alternative<Home>(intent)) return Purpose::home;
  if (std::holds_alternative<Cool>(intent)) return Purpose::cool;
  return stops(course_.answer()->intent) ? Purpose::stop : Purpose::follow;
}

const PlannedMotion* Navigator::planned() const {
  return motion() != nullptr ? course_.answer()->planned() : nullptr;
}

Phase Navigator::phase() const {
  if (watch_.soft()) return Phase::fallen;
  if (motion() == nullptr) return Phase::hold;
  const BySide<bool>& contact = course_.sample().contact;
  if (contact.left && contact.right) return Phase::double_support;
  return contact.left ? Phase::single_left : Phase::single_right;
}

}  // namespace baton
