#include "baton/navigate/due.hpp"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <utility>

#include "baton/ik/moving.hpp"
#include "baton/navigate/drift.hpp"

namespace baton {
namespace {

constexpr double kSameHold = 4e-3;      ///< displacement up to which a refusal holds [COM height]
constexpr double kReplacing = 0.1;      ///< time between two replacements of a motion on its way, for any robot [s]
constexpr double kNearEdges = 2.0;      ///< distance of edges that soles may meet [largest distance of the feet]
constexpr double kSlipByEdges = 0.5;    ///< displacement there at which a way back is ended [margin to edges]
constexpr double kReserve = 0.05;       ///< share of the ZMP's room that a capture step leaves
constexpr double kZmpDeficit = 0.12;    ///< ZMP that the ground does not give, and that does not count [COM height]
constexpr double kLeastCapture = 0.15;  ///< least length of a capture step: the push may go on [COM height]
constexpr double kCooling = 0.25;       ///< time between two requests to stand straighter, for any robot [s]
constexpr double kArmsOff = 0.01;       ///< distance of an arm's joint from its target for which it is moved [rad]
constexpr double kArmsSoonest = 0.1;    ///< from when on it is looked for, on the way, for any robot [s]
constexpr double kArmsLook = 0.1;       ///< how far apart, for any robot [s]
constexpr int kArmsLooks = 5;           ///< how often
constexpr double kLetGo = 0.1;          ///< way of an arm's joint that was let go of, for any robot [s × its speed]
constexpr double kLongestTrail = 60.0;  ///< of arms that go on and on, for any robot [s]
constexpr double kFarther = 1.5;        ///< ratio of lengths from which a longer capture step replaces one under way

bool both_stand(const BySide<bool>& contact) {
  return contact.left && contact.right;
}

/// The requests that there may be in one situation.
class Requests {
 public:
  explicit Requests(const Situation& now)
      : now_(now), profile_(now.robot.profile()), course_(now.course), motion_(now.course.motion()) {}

  [[nodiscard]] std::optional<Request> due() const;
  [[nodiscard]] Request from_rest(const Command& command) const;

 private:
  /// What all requests have in common that replace the motion under way at its sample `at`.
  [[nodiscard]] Request replacing(int at) const;
  /// Replaces it by what the stick asks for.
  [[nodiscard]] Request on_the_way(int at) const;
  /// The same, with the arms as they are driven from outside; and, if they move, without.
  [[nodiscard]] Request with_arms(Request request) const;
  /// The arms alone, from where the robot rests next.
  [[nodiscard]] Request arms_from_rest() const;
  /// Replaces the motion under way by one to the same goal, in which the arms follow what drives them now.
  [[nodiscard]] Request arms_on_the_way(int at) const;
  /// Replaces it by a motion to rest: a foot in the air can only land.
  [[nodiscard]] Request ending(int at) const;
  /// Stops the motion under way, unless it already does that.
  [[nodiscard]] std::optional<Request> stopping(int at) const;
  /// Keeps both feet down, before the swing foot leaves the ground.
  [[nodiscard]] std::optional<Request> staying(int at) const;
  /// With hot motors at rest: puts down a foot, then stands straighter.
  [[nodiscard]] std::optional<Request> cooling() const;
  /// A capture step, if no shift of the ZMP can hold the DCM.
  [[nodiscard]] std::optional<Request> catching() const;

  /// What the goal of the motion under way is relative to, in the place and for the stick that `context` has.
  void make_same_step(GuideContext& context) const;
  /// Whether a request was made too short a time ago for the motion under way to be replaced.
  [[nodiscard]] bool asked_lately() const;
  /// Whether a foot is about to leave the ground, or to land: the ZMP would have to jump.
  [[nodiscard]] bool contact_changes_soon(int at) const;
  [[nodiscard]] bool replaceable(int at) const;
  /// Whether the arms may be asked for now.
  [[nodiscard]] bool arms_due() const;
  /// Whether the motion under way is to be replaced for the arms.
  [[nodiscard]] bool arms_replaceable(int at) const;
  /// Whether arms that are driven from outside are planned to be elsewhere soon than they are to be.
  /// @param at sample of the motion under way; null: where the robot rests next
  /// @param until last sample of it that is looked at
  [[nodiscard]] bool arms_stray(const int* at, int until = 0) const;
  /// Whether what the stick asks for has lately been found to have no motion, so that arms come first.
  [[nodiscard]] bool stick_waits() const;
  /// Whether a joint follows in the motion under way what it is not driven by any more.
  [[nodiscard]] bool let_go(int joint) const;
  /// Whether soles slid farther on a way back than its margins allow.
  [[nodiscard]] bool slid_too_far() const;
  /// Whether the ground has edges where the robot is.
  [[nodiscard]] bool edges_near() const;
  /// The foot that is in the air at a sample, if one is.
  [[nodiscard]] std::optional<Flight> flight(int at) const;
  /// Whether the foot that swings in this motion is in its first phase there: it has not left the ground, or not
  /// landed.
  [[nodiscard]] bool in_first_phase_of_swing(int at) const;
  /// The foot that is about to leave the ground at a sample, if one is.
  [[nodiscard]] std::optional<LiftOff> lift_off(int at) const;
  /// The rest on the way back that can be stopped at from there: both feet stand until it is passed.
  [[nodiscard]] std::optional<TrailRest> halt_from(int at) const;
  /// Contacts where the next motion begins.
  [[nodiscard]] const BySide<bool>& next_contact() const;
  /// Planning frame of the next motion, by the soles. A foot that lands by then counts too, unless it is far off: it
  /// moves with the trunk (see `Footing`), so by the other foot alone the next motion would begin with the trunk's
  /// error.
  [[nodiscard]] Pose next_anchor() const;
  /// What goals are relative to where the robot rests next.
  [[nodiscard]] GuideContext context_at_rest() const;
  /// Whether what was refused would be refused again.
  [[nodiscard]] bool refused_here(const Pose& anchor) const;

  const Situation& now_;
  const Profile& profile_;
  const Course& course_;
  const Motion* motion_;
};

std::optional<Request> Requests::due() const {
  const int at = course_.index() + profile_.tick.lookahead;
  const bool on_the_way = motion_ != nullptr && at < motion_->ticks();
  const Command& command = now_.command;
  const bool disturbed = now_.watch.disturbed();
  const bool hot = now_.watch.thermometer().hot();
  const bool ends_back =
      on_the_way && course_.is<Retracing>() && (command.neutral() || disturbed || hot || slid_too_far());
  const bool stops = command.recall == Recall::stop || ends_back;
  const std::optional<Terrain::Inclined> inclined = now_.watch.inclined_sole(course_.sample());
  const bool leaves_inclined = inclined && motion_ != nullptr && motion_->goal.swing == other(inclined->side);
  // Pushed, or about to stand on an edge alone: the motion under way ends at rest, and the robot stays there.
  std::optional<Request> due = disturbed ? catching() : std::nullopt;
  const bool catches = due.has_value();
  const bool cools = hot && !on_the_way && !stops;
  std::optional<Request> stays;
  if ((disturbed || leaves_inclined) && on_the_way && !stops) stays = staying(at);
  if (due && stays) due->intents.emplace_back(Stop{});
  if (!due) due.swap(stays);
  if (due || (disturbed && !stops)) {
    // A capture step, a foot that stays down, or nothing.
  } else if (on_the_way) {
    if (stops) due = stopping(at);
    if (!stops && replaceable(at)) due = with_arms(this->on_the_way(at));
    if (!stops && !due && arms_replaceable(at)) due = arms_on_the_way(at);
  } else if (cools) {
    due = cooling();
  } else if (!now_.correction.settling && (!both_stand(course_.rest().contact) || (!stops && !command.neutral()))) {
    due = with_arms(from_rest(command));
  }
  if (due && !catches && !cools && refused_here(due->start.context.anchor)) due.reset();
  const bool rests = !on_the_way && !disturbed && !cools && !stops && !now_.correction.settling;
  if (rests && (!due || stick_waits()) && arms_due() && arms_stray(nullptr)) due = arms_from_rest();
  if (!due) return std::nullopt;
  due->terrain = {inclined, now_.watch.uneven()};
  return due;
}

bool Requests::refused_here(const Pose& anchor) const {
  if (motion_ != nullptr) return false;
  const LastRefusal& refused = now_.refused;
  const bool same_place =
      distance_at(anchor, refused.anchor, course_.sample().com) < kSameHold * profile_.stance.com_height;
  return (refused.refusal && refused.at_rest && same_place) || now_.tick < refused.retry_at;
}

Request Requests::from_rest(const Command& command) const {
  Request request{now_.tick + (static_cast<long>(profile_.tick.lookahead) << now_.exchange.late),
                  command,
                  {course_.rest(), context_at_rest(), now_.history.newest()},
                  {},
                  nullptr,
                  nullptr,
                  {intent_of(command)}};
  request.start.context.drift_correction = drift_correction(now_.robot, request.start.context, command);
  request.start.posture.heat = now_.watch.thermometer().heat();
  return request;
}

Request Requests::with_arms(Request request) const {
  if (request.command.recall != Recall::none) return request;
  const double start = static_cast<double>(request.at) * profile_.tick.period;
  request.arms = now_.arms.governed(request.start.posture, start);
  if (request.arms && !request.arms->still()) request.intents.emplace_back(Follow{.arms = false});
  return request;
}

Request Requests::arms_from_rest() const {
  Request request = with_arms(from_rest(Command{.guide = now_.command.guide}));
  request.command = now_.command;
  request.start.context.drift_correction = {};
  request.intents = {MoveArms{}};
  return request;
}

Request Requests::arms_on_the_way(int at) const {
  const bool swings = motion_->phases.size() > 1 && motion_->goal.swing;
  const bool landed = swings && at >= motion_->last_phase();
  Request request = with_arms(replacing(at));
  Posture& start = request.start.posture;
  start.flight = flight(at);
  start.lift_off = lift_off(at);
  GuideContext& context = request.start.context;
  Goal goal = motion_->goal;
  if (swings && !landed) {  // the same step again
    make_same_step(context);
  } else {
    goal.drift_correction = {};                          // the slip-free frame has it already
    context.place_uncertainty = goal.place_uncertainty;  // what it is verified with
    if (landed && both_stand(goal.contact)) {
      goal.swing.reset();
      goal.kind = SegmentKind::shift;
    }
  }
  // What was let go of comes to rest soon.
  for (int j = 0; j < goal.arms.size(); ++j) {
    if (let_go(j)) goal.arms[j] = start.q[7 + j] + kLetGo * start.dq[6 + j];
  }
  goal.arm_path = nullptr;
  goal.duration = (motion_->ticks() - at) * motion_->period;
  if (goal.kind == SegmentKind::arms && request.arms) goal.duration = request.arms->duration;
  request.goal = std::make_shared<const Goal>(std::move(goal));
  request.intents = {MoveArms{}};
  return request;
}

bool Requests::arms_due() const {
  return now_.command.recall == Recall::none && now_.tick >= now_.exchange.arms_again;
}

bool Requests::stick_waits() const {
  return now_.tick < now_.exchange.stick_again && !differs(now_.command, now_.exchange.in_vain);
}

bool Requests::let_go(int joint) const {
  const ArmPath* path = motion_ != nullptr ? motion_->goal.arm_path.get() : nullptr;
  return path != nullptr && !now_.arms.drives(joint) && std::ranges::find(path->joints, joint) != path->joints.end();
}

bool Requests::arms_replaceable(int at) const {
  if (!arms_due() || now_.gait == Gait::stop || now_.watch.thermometer().hot() || !course_.is<Moving>()) return false;
  if (asked_lately() || contact_changes_soon(at)) return false;
  const double period = profile_.tick.period;
  const bool alone = motion_->goal.kind == SegmentKind::arms;
  // Now and then they come to rest, so that a way back has a beginning.
  if (alone && now_.history.newest() && now_.history.newest()->ticks() > std::lround(kLongestTrail / period))
    return false;
  if (in_first_phase_of_swing(at) && !motion_->goal.contact[*motion_->goal.swing]) return false;  // it would begin anew
  const ArmPath* path = motion_->goal.arm_path.get();
  const int brakes = motion_->ticks() - (path != nullptr ? static_cast<int>(path->braking / period) : 0);
  const bool known = path != nullptr && path->version == now_.arms.version();
  // What only goes on where the motion brakes is followed by the next one; but the arms alone need not brake.
  const bool ends = alone && at + std::lround(kReplacing / period) >= brakes;
  return (!known || ends) && arms_stray(&at, ends ? motion_->ticks() : brakes);
}

bool Requests::arms_stray(const int* at, int until) const {
  const Command& command = now_.command;
  const double period = profile_.tick.period;
  const int first = at != nullptr ? *at + static_cast<int>(kArmsSoonest / period) : 0;
  const auto guided = [&](int joint) {
    return std::ranges::any_of(kSides, [&](Side side) {
      const bool by_hand =
          (command.guide == hand(side) && !command.neutral()) || (at != nullptr && motion_->goal.hand[side]);
      return by_hand && std::ranges::find(now_.robot.arm(side), joint) != now_.robot.arm(side).end();
    });
  };
  const auto planned = [&](int index, int joint) {
    return at == nullptr || index >= motion_->ticks() ? course_.rest().q[7 + joint]
                                                      : motion_->samples[static_cast<std::size_t>(index)].q[7 + joint];
  };
  for (int joint = 0; joint < now_.robot.nv() - 6; ++joint) {
    if (at != nullptr && let_go(joint) && std::abs(planned(motion_->ticks(), joint) - planned(first, joint)) > kArmsOff)
      return true;
    if (!now_.arms.drives(joint) || guided(joint)) continue;
    for (int k = 0; k < kArmsLooks; ++k) {
      const int index = first + static_cast<int>(std::lround(kArmsLook * k / period));
      if (at != nullptr && index > until) break;
      const long tick = now_.tick + index - (at != nullptr ? course_.index() : 0);
      if (std::abs(now_.arms.at(joint, static_cast<double>(tick) * period) - planned(index, joint)) > kArmsOff)
        return true;
    }
  }
  return false;
}

Request Requests::replacing(int at) const {
  const auto sample = motion_->samples.begin() + at;
  // The motion to a rest on the way back is on no trail.
  Request request{
      now_.tick + profile_.tick.lookahead,
      now_.command,
      {passing(now_.robot, *sample), context_at_rest(), course_.is<Halting>() ? nullptr : now_.history.newest(), at},
      {},
      nullptr,
      nullptr,
      {Follow{}}};
  if (at > 0) request.start.posture.contact_before = std::prev(sample)->contact;
  request.start.posture.heat = now_.watch.thermometer().heat();
  return request;
}

void Requests::make_same_step(GuideContext& context) const {
  GuideContext same = course_.answer()->context;
  same.anchor = context.anchor;
  same.com_offset = context.com_offset;
  same.stick_held = context.stick_held;
  context = std::move(same);
}

Request Requests::on_the_way(int at) const {
  const Goal& goal = motion_->goal;
  const Answer& answer = *course_.answer();
  const int last_phase = motion_->last_phase();
  const bool both_end = both_stand(goal.contact);
  Request request = replacing(at);
  Posture& start = request.start.posture;
  GuideContext& context = request.start.context;
  const Part guided = now_.command.guide;
  // A lever that moves while the stick is centred changes how high the foot is, not where it goes.
  if (now_.command.axes.isZero(0.0) && guided == answer.command.guide) request.command.axes = answer.command.axes;
  context.stick_held = guided == answer.command.guide && !answer.command.axes.isZero(0.0);
  context.drift_correction = drift_correction(now_.robot, context, request.command);

  start.flight = flight(at);
  start.lift_off = lift_off(at);
  // Once a foot is up that stays up, all that is left is its way through the air.
  const bool several = motion_->phases.size() > 1 && (at < last_phase || both_end);
  if (several && at >= last_phase && both_end) return request;  // on from the rest that the step leads to
  if (several) {
    // The same step again, to another goal.
    make_same_step(context);
    const int joints = now_.robot.nv() - 6;
    context.from.q.tail(joints) = motion_->end.q.tail(joints);
    if (start.flight && both_stand(context.from.contact)) {
      const Side up = start.flight->side;
      context.step = {up, goal.contact[up] ? goal.sole[up] : context.from.sole[up]};
    }
  }
  // The guided part goes on from where it is; a foot, from where it began to move.
  Posture& from = context.from;
  if (guided == Part::trunk) {
    from.com = start.com;
    from.trunk = start.trunk;
  } else if (is_hand(guided)) {
    from.hand[side_of(guided)] = start.hand[side_of(guided)];
    from.shoulder[side_of(guided)] = start.shoulder[side_of(guided)];
  } else if (!several) {
    from.sole[side_of(guided)] = start.sole[side_of(guided)];
  }
  return request;
}

Request Requests::ending(int at) const {
  Request request = replacing(at);
  Posture& start = request.start.posture;
  GuideContext& context = request.start.context;
  start.flight = flight(at);
  start.lift_off = lift_off(at);
  const Goal& goal = motion_->goal;
  const GuideContext& base = course_.answer()->context;
  if (goal.swing && at < motion_->last_phase()) {  // the step is not done
    context.last_step = base.last_step;
    context.foothold = base.foothold;
  }
  if (start.flight) {
    const Side up = start.flight->side;
    context.step = {up, goal.contact[up] ? goal.sole[up] : base.foothold[up]};
  }
  context.from = start;
  request.intents = {Stop{}};
  return request;
}

std::optional<Request> Requests::stopping(int at) const {
  if (course_.is<Retracing>()) {
    const std::optional<TrailRest> halt = halt_from(at);
    if (!halt) return std::nullopt;
    Request request = replacing(at);
    request.start.trail = std::get<Retracing>(course_.state()).trail;
    request.intents = {HaltAt{*halt}};
    return request;
  }
  const Exchange& exchange = now_.exchange;
  const bool asked = exchange.for_stop && asked_lately();
  if (course_.is<Halting>() || course_.is<Stopping>() || asked) return std::nullopt;
  return ending(at);
}

std::optional<Request> Requests::staying(int at) const {
  if (!in_first_phase_of_swing(at) || course_.is<Retracing>() || course_.is<Catching>()) return std::nullopt;
  return ending(at);
}

std::optional<Request> Requests::cooling() const {
  const bool stands = both_stand(course_.rest().contact);
  const long again =
      stands ? now_.exchange.asked_at + std::lround(kCooling / profile_.tick.period) : now_.refused.retry_at;
  if (now_.tick < again) return std::nullopt;
  Request request = from_rest(Command{.guide = now_.command.guide});
  request.intents = {stands ? Intent{Cool{}} : Intent{Stop{}}};
  return request;
}

std::optional<Request> Requests::catching() const {
  const MotionSample& sample = course_.sample();
  const Pose& anchor = course_.anchor();
  const Vec2& world_error = now_.watch.dcm_error();
  const Vec2 error = (anchor.R.transpose() * Vec3(world_error.x(), world_error.y(), 0)).head<2>();
  // The DCM drifts away from the plan's unless the ZMP can be shifted as far as it is off.
  const double size = error.norm();
  const Vec2 zmp = sample.zmp + now_.correction.com_offset;
  const Vec2 holds = zmp + (1.0 + kReserve) * error;
  const auto along = [&](const Vec2& v) { return v.dot(error) / size; };
  double room = std::max(0.0, along(sample.zmp_region->nearest(holds) - zmp));
  // Soles that stand on edges do not take the ZMP where they should.
  const double deficit = along(now_.correction.zmp_deficit);
  if (deficit > kZmpDeficit * profile_.stance.com_height)
    room = std::clamp(along(now_.correction.zmp - zmp) - deficit, 0.0, room);
  if (sample.zmp_region->margin(holds) >= 0.0 && room >= size) return std::nullopt;

  const int lookahead = profile_.tick.lookahead;
  const double swing = profile_.phases.flow[1] * profile_.duration.first;
  double lands_in = swing;  // after the take-over
  if (both_stand(course_.rest().contact)) lands_in += profile_.phases.flow[0] * profile_.duration.first;
  Request request;
  Catch capture;
  const Catch* under_way = nullptr;
  if (motion_ != nullptr) {
    const int at = course_.index() + lookahead;
    if (course_.is<Retracing>() || at >= motion_->ticks()) return std::nullopt;
    request = ending(at);
    if (at < motion_->last_phase()) under_way = course_.answer()->capture();
    const Posture& start = request.start.posture;
    if (start.flight) {
      lands_in = start.flight->remaining;
    } else if (start.lift_off) {
      lands_in = start.lift_off->remaining + swing;
    }
    lands_in += lookahead * profile_.tick.period;
    if (start.flight) capture.lands_in = lands_in;
  } else {
    request = from_rest(Command{.guide = now_.command.guide});
    lands_in += lookahead * profile_.tick.period;
  }
  // Until the foot lands, the part of the error that no ZMP holds grows.
  const double excess = std::max(0.0, size - room);
  const double least = std::max(size, kLeastCapture * profile_.stance.com_height);
  const double then =
      std::min(least + excess * (std::exp(now_.robot.omega() * lands_in) - 1.0), profile_.region.foot_x.hi);
  if (under_way != nullptr && then < kFarther * under_way->by.norm()) return std::nullopt;
  capture.by = then / size * error;
  capture.dcm_excess = excess;
  capture.height = anchor.p.z();
  if (under_way != nullptr) {
    capture.gain = along(under_way->by);
    if (request.start.posture.flight) capture.moved = under_way->by;
  }
  request.intents = {capture};
  return request;
}

bool Requests::asked_lately() const {
  return now_.tick < now_.exchange.asked_at + std::lround(kReplacing / profile_.tick.period);
}

bool Requests::contact_changes_soon(int at) const {
  const int lift_off = motion_->phases.front().ticks;
  const int change = at < lift_off ? lift_off : motion_->last_phase();
  const bool swings = motion_->phases.size() > 1 && motion_->goal.swing;
  return swings && at < change && (change - at) * profile_.tick.period < least_flight(profile_);
}

bool Requests::replaceable(int at) const {
  const Command& command = now_.command;
  if (now_.gait == Gait::stop || now_.watch.thermometer().hot() || course_.is<Retracing>() || course_.is<Halting>() ||
      command.recall != Recall::none || command.neutral())
    return false;
  const Goal& goal = motion_->goal;
  if (goal.kind == SegmentKind::arms)  // which goes on and on
    return !stick_waits() && !asked_lately();
  const int last_phase = motion_->last_phase();
  const bool swings = motion_->phases.size() > 1 && goal.swing;
  const bool lands = swings && goal.contact[*goal.swing];
  // A held stick goes on from where a foot has landed; with no foot to land, from halfway through the last phase.
  const bool foot_again = is_foot(command.guide) && !differs(command, course_.answer()->command);
  const int continues_at = !lands ? (last_phase + motion_->ticks()) / 2 : (foot_again ? motion_->ticks() : last_phase);
  if (at == continues_at && !command.axes.isZero(0.0)) return true;
  if (asked_lately() || contact_changes_soon(at)) return false;
  // A released stick and an unmoved lever: the motion under way serves.
  if (command.axes.isZero(0.0) && !lever_moved(command, now_.exchange.answered)) return false;
  return at > continues_at || differs(command, now_.exchange.answered);
}

bool Requests::slid_too_far() const {
  const double most = edges_near() ? kSlipByEdges * profile_.margin.edge : kSlip * profile_.reach.foot;
  return distance_at(course_.anchor(), course_.answer()->context.anchor, course_.sample().com) > most;
}

bool Requests::edges_near() const {
  const std::optional<GroundPoint> ground = now_.world.ground((course_.anchor() * course_.sample().com).head<2>());
  return !ground || ground->edge < kNearEdges * profile_.region.foot_lateral.hi;
}

std::optional<Flight> Requests::flight(int at) const {
  const MotionSample& sample = motion_->samples[static_cast<std::size_t>(at)];
  if (both_stand(sample.contact)) return std::nullopt;
  const double period = profile_.tick.period;
  const Side up = sample.contact.left ? Side::right : Side::left;
  const int arrives = motion_->goal.contact[up] ? motion_->last_phase() : motion_->ticks();
  const double left = std::max((arrives - at) * period, least_flight(profile_));
  return Flight{up, motion_->swing.lift_off, left, motion_->swing.apex_t - at * period, motion_->swing.apex};
}

bool Requests::in_first_phase_of_swing(int at) const {
  return motion_->goal.swing && motion_->phases.size() > 1 && at < motion_->phases.front().ticks;
}

std::optional<LiftOff> Requests::lift_off(int at) const {
  const MotionSample& sample = motion_->samples[static_cast<std::size_t>(at)];
  if (!both_stand(sample.contact) || !in_first_phase_of_swing(at)) return std::nullopt;
  return LiftOff{*motion_->goal.swing, (motion_->phases.front().ticks - at) * motion_->period};
}

std::optional<TrailRest> Requests::halt_from(int at) const {
  const std::shared_ptr<const Trail>& trail = std::get<Retracing>(course_.state()).trail;
  if (!trail) return std::nullopt;
  const int leaves = motion_->leaves.value_or(motion_->ticks());
  const std::vector<TrailRest> rests = rests_on(*trail);
  const auto next = std::find_if(rests.begin(), rests.end(),
                                 [&](const TrailRest& rest) { return rest.passed > at && rest.passed <= leaves; });
  const auto sample = motion_->samples.begin();
  if (next == rests.end() ||
      !std::all_of(sample + at, sample + next->passed, [](const MotionSample& s) { return both_stand(s.contact); }))
    return std::nullopt;
  return *next;
}

const BySide<bool>& Requests::next_contact() const {
  const int at = course_.index() + profile_.tick.lookahead;
  const bool on_the_way = motion_ != nullptr && at < motion_->ticks();
  return on_the_way ? motion_->samples[static_cast<std::size_t>(at)].contact : course_.rest().contact;
}

Pose Requests::next_anchor() const {
  const MotionSample& sample = course_.sample();
  const BySide<bool>& then = next_contact();
  const Pose slid = now_.watch.slid(sample);
  Pose landed = now_.watch.slid(sample, {sample.contact.left || then.left, sample.contact.right || then.right});
  landed.p.z() = slid.p.z();
  const bool lands_there = distance_at(landed, slid, sample.com) < kSlip * profile_.reach.foot;
  return course_.anchor() * (lands_there ? landed : slid);
}

GuideContext Requests::context_at_rest() const {
  const Pose anchor = next_anchor();
  GuideContext context{course_.rest(), anchor, course_.last_step(), course_.foothold()};
  if (motion_ != nullptr) course_.note_steps(context.last_step, context.foothold);
  context.slip_free_frame = course_.slip_free_frame();
  context.com_offset = now_.correction.com_offset;
  // With a foot in the air it stays what that was to land with; if the foot has landed by then, that step counts next.
  context.place_uncertainty = both_stand(next_contact()) ? now_.watch.odometry().uncertainty() : course_.uncertainty();
  return context;
}

}  // namespace

std::optional<Request> due(const Situation& now) {
  return Requests(now).due();
}

Request request_from_rest(const Situation& now, const Command& command) {
  return Requests(now).from_rest(command);
}

}  // namespace baton
