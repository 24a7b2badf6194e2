#include "baton/proving/judges.hpp"

#include <algorithm>
#include <utility>

#include "baton/ik/stand.hpp"

namespace baton {
namespace {

constexpr int kRefusedInARow = 200;            ///< consecutive refusals that trigger the test
constexpr double kPositionTolerance = 0.0192;  ///< at the end of a retrace [COM height]: 5 mm for mighty
constexpr double kRotationTolerance = 0.02;    ///< [rad]

}  // namespace

void Failures::add(const std::string& kind, double t, double value, double limit, const std::string& where) {
  const long segment = session_->navigator().committed();
  if (segment != segment_) kinds_.clear();
  if (kinds_.empty()) ++tally_->failures;
  segment_ = segment;
  if (!kinds_.insert(kind).second) return;
  ++tally_->bad[kind];
  if (tally_->listed.size() < Tally::kListed) tally_->listed.push_back({kind, episode_, t, value, limit, where});
}

void TickJudge::on_tick(const TickRecord& record) {
  const Navigator& navigator = record.navigator;
  last_ = record.truth->q;
  if (navigator.phase() == Phase::fallen) return;
  if (find_event<Committed>(navigator.events()) != nullptr) tally_->shrunk += navigator.planned()->limit ? 1 : 0;
  if (!checker_) return;
  tick_ = {record.t,
           exact_ ? Pose{} : navigator.anchor(),
           exact_ ? record.truth->q : navigator.sample().q,
           navigator.sample().contact,
           navigator.phase() == Phase::hold,
           navigator.catching(),
           record.target.q};
  for (const Checker::Violation& v : checker_->add(tick_))
    failures_->add(std::string(Checker::kNames[static_cast<std::size_t>(v.kind)]), v.t, v.value, v.limit, v.where);
  if (!record.truth->q.allFinite() || !record.target.tau.allFinite())
    failures_->add("not_finite", record.t, 0.0, 0.0, "");
}

void WayBack::on_tick(const TickRecord& record) {
  const Navigator& navigator = record.navigator;
  if (navigator.phase() == Phase::fallen) return;
  const VecX& q = record.truth->q;
  const Motion* motion = navigator.motion();
  const bool begins = find_event<Committed>(navigator.events()) != nullptr;
  const bool from_rest = motion == nullptr || navigator.now() >= motion_ends_;
  if (begins) motion_ends_ = navigator.now() + motion->ticks();
  if (back_to_ && (begins || motion == nullptr)) {
    if (from_rest && going_ && !part_) judge_end(record.t, q);
    if (!from_rest || part_) rests_.push_back(*back_to_);  // it ended before that point
    back_to_.reset();
  }
  if (begins && motion->retraces) {
    part_ = navigator.planned()->limit.has_value();
    back_to_ = rests_.back();
    rests_.pop_back();
  } else if (begins && from_rest) {
    rests_.push_back(q);
  }
  while (rests_.size() > navigator.history())  // dropped from history: too old, or after a slip
    rests_.pop_front();
}

void WayBack::judge_end(double t, const VecX& q) {
  const Posture there = posture_of(*robot_, *back_to_);
  const Posture here = posture_of(*robot_, q);
  const double turned = rotation_error(there.trunk, here.trunk).norm();
  double off = (there.com - here.com).norm();
  for (const Side side : kSides)
    off = std::max(off, (there.sole[side].p - here.sole[side].p).norm());
  ++sum_->tried;
  sum_->worst_m = std::max(sum_->worst_m, off);
  sum_->worst_rad = std::max(sum_->worst_rad, turned);
  const double most_off = kPositionTolerance * robot_->profile().stance.com_height;
  const bool turned_too_far = turned > kRotationTolerance;
  if (off <= most_off && !turned_too_far) {
    ++sum_->arrived;
  } else if (exact_) {
    failures_->add("retrace", t, turned_too_far ? turned : off, turned_too_far ? kRotationTolerance : most_off,
                   turned_too_far ? "trunk" : "");
  }
}

void WayBack::on_plan(const PlanRecord& record) {
  const auto* refusal = std::get_if<Refusal>(&record.answer.outcome);
  const bool retraces = std::holds_alternative<Retrace>(record.answer.intent);  // or halts there, with hot motors
  if (!going_ || refusal == nullptr || !retraces || !record.request.start.trail) return;
  ++sum_->tried;
  ++sum_->refused;
  if (exact_)
    failures_->add("retrace", record.t, refusal->value, refusal->limit, std::string(to_string(refusal->reason)));
}

void StuckJudge::on_plan(const PlanRecord& record) {
  if (std::holds_alternative<PlannedMotion>(record.answer.outcome)) refused_in_a_row_ = 0;
  if (std::holds_alternative<Refusal>(record.answer.outcome)) ++refused_in_a_row_;
}

void StuckJudge::look() {
  if (refused_in_a_row_ != kRefusedInARow || !session_->resting()) return;
  ++refused_in_a_row_;  // test once
  test();
}

void StuckJudge::test() {
  if (stuck(strategy_, session_->navigator().request_for({}))) failures_->add("stuck", session_->t(), 0.0, 0.0, "");
}

bool stuck(Strategy& strategy, Request request) {
  request.intents.clear();  // what each command asks for
  const auto goes = [&](const Command& command) {
    request.command = command;
    return std::holds_alternative<PlannedMotion>(strategy.plan(request).outcome);
  };
  Command command;
  for (const double size : {0.5, 1.0, 0.1}) {
    for (const Part part : {Part::trunk, Part::left_foot, Part::right_foot, Part::left_hand, Part::right_hand}) {
      command.guide = part;
      for (const double lift : {0.0, 0.5, 1.0}) {
        if (lift > 0.0 && !is_foot(part)) continue;
        command.lift = {lift, lift};
        for (int direction = 0; direction < 27; ++direction) {
          if (direction == 13) continue;  // none
          const Eigen::Vector3i way(direction / 9 - 1, direction / 3 % 3 - 1, direction % 3 - 1);
          command.axes.head<3>() = size * way.cast<double>();
          if (goes(command)) return false;
        }
      }
    }
  }
  command = {};
  command.recall = Recall::retrace;
  return !goes(command);
}

}  // namespace baton
