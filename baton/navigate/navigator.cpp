#include "baton/navigate/navigator.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "baton/ik/moving.hpp"
#include "baton/ik/stand.hpp"

namespace baton {
namespace {

constexpr double kPatience = 0.05;        ///< from a refusal at rest to the next request [s]
constexpr double kSlip = 0.2;             ///< jump of the planning frame that is a slip, of the reach of a foot
constexpr double kByEdges = 2.0;          ///< of the feet's largest distance: edges within that may be landed by
constexpr double kSlipByEdges = 0.5;      ///< there, of the margin to them: so far soles may slide on the way back
constexpr double kMakesUp = 0.05;         ///< how much of the trunk's reach a motion makes up for
constexpr std::ptrdiff_t kHistory = 200;  ///< motions that are kept to be retraced
constexpr long kHistoryTicks = 100000;    ///< of all of them together
constexpr int kMostLate = 5;              ///< doublings of the lookahead, at rest, when answers come too late
constexpr double kReplacing = 0.1;        ///< between two replacements of a motion on its way [s]
constexpr double kTube = 0.02;            ///< error of the DCM with which nothing new is begun [COM height]
constexpr double kInPlace = 1e-3;  ///< soles of a robot at rest that are not farther off are in place [COM height, rad]
constexpr double kSameHeight = 4e-3;   ///< nor do heights that differ by less, as soles sink [COM height]
constexpr double kSettles = 3.0;       ///< rate at which the planning frame follows others [1/s]
constexpr double kFallenTilt = 0.8;    ///< [rad] from which a fall is certain
constexpr double kFallenHeight = 0.5;  ///< share of the nominal COM height below which it is
constexpr double kLifted = 0.1;        ///< share of the weight on the soles below which the robot is held by someone
constexpr double kStands = 0.5;        ///< share from which it stands again
constexpr double kSure = 0.15;         ///< for which that has to last [s]
constexpr double kStill = 1.0;         ///< for which a robot that has been stood up has to be still [s]
constexpr double kStillSpeed = 0.1;    ///< and its COM no faster [COM heights/s]
constexpr double kEachCarries = 0.2;   ///< each sole with so much of the weight
constexpr double kReserve = 0.05;      ///< of the ZMP's room, with which a step that catches the robot is made
constexpr double kLacks = 0.02;        ///< of the commanded ZMP that is not there, and does not count [COM height]
constexpr double kLeastCatch = 0.15;   ///< how far such a step goes at least: the push may go on [COM height]
constexpr double kFarther = 1.5;       ///< of that step's way: so much farther, and it is sent there
constexpr double kUneven = 0.015;      ///< inclination to the plan from which the ground is not what the map says [rad]
constexpr double kForgets = 10.0;      ///< time constant with which that is forgotten [s]
constexpr double kUnsure = 0.7;  ///< share of the room on both sides of an edge, as a step goes past it, to stay off it
constexpr double kBack = 0.01;   ///< error below which it is again

/// How much room the longest step past an edge leaves on each side of it, beside the margin to edges [m].
double past_edges(const RobotModel& robot) {
  const Profile& profile = robot.profile();
  double toe = 0.0;
  for (const Vec2& vertex : robot.sole(Side::left).vertices())
    toe = std::max(toe, vertex.x());
  return std::max(0.0, 0.5 * (profile.region.foot_x.hi - 2.0 * toe) - profile.margin.edge);
}

/// A level move, seen from a point: how far it takes it, and how it turns.
struct LevelMove {
  Vec2 shift;
  double turn;

  LevelMove(const Pose& move, const Vec3& point) : shift((move * point - point).head<2>()), turn(yaw_of(move.R)) {}
  void bound(double most, double most_turn) {
    shift = bounded(shift, most);
    turn = std::clamp(turn, -most_turn, most_turn);
  }
  [[nodiscard]] Pose pose(const Vec3& point) const {
    const Mat3 R = rotation_z(turn);
    Vec3 p = point - R * point;
    p.head<2>() += shift;
    return {p, R};
  }
};

/// How far apart two frames put a point [m]: their origins may be far away from it.
double apart(const Pose& a, const Pose& b, const Vec3& point) {
  return (a * point - b * point).norm();
}

/// Where the feet stand, and which stepped last, once a goal is reached.
void note_steps(const Goal& goal, Side& last_step, BySide<Pose>& foothold) {
  for (const Side side : kSides) {
    if (goal.contact[side]) foothold[side] = goal.sole[side];
  }
  if (goal.swing) last_step = *goal.swing;
}

}  // namespace

Navigator::Navigator(const RobotModel& robot, const World& world, const Posture& start, Gait gait, StateSource source)
    : robot_(&robot),
      world_(&world),
      gait_(gait),
      odometry_(robot, world, source, start),
      estimator_(robot),
      stabiliser_(robot),
      past_edges_(past_edges(robot)),
      posture_(start),
      held_(resting(robot, start)),
      sample_(&held_),
      foothold_(start.sole) {
  const VecX zero = VecX::Zero(robot.nv() - 6);
  soft_ = {zero, zero, zero, zero, {false, false}, zero};
  history_.reserve(static_cast<std::size_t>(kHistory) + 1);
}

const JointTarget& Navigator::tick(const Measurement& measurement, const Command& command) {
  ++tick_;
  command_ = sanitised(command);
  if (!(command_ == refused_)) drop_refusal();
  stop_pressed_ = stop_pressed_ || command_.recall == Recall::stop;

  if (motion_ && ++index_ == motion_->ticks()) end_of_motion();
  sample_ = motion_ ? &motion_->samples[static_cast<std::size_t>(index_)] : &held();
  const Measurement& measured = odometry_.update(measurement, *sample_);
  state_ = &estimator_.update(measured, anchor_);
  watch();
  if (take_over()) {  // the new motion begins where the old one is, in a planning frame of its own
    sample_ = &motion_->samples.front();
    state_ = &estimator_.update(measured, anchor_);
    update_slip();
  }
  if (guard_ == Guard::fallen || guard_ == Guard::stood_up) {
    soft_.q = measurement.q;
    return soft_;
  }
  const MotionSample& next = motion_ ? motion_->samples[static_cast<std::size_t>(index_) + 1] : held();
  const JointTarget& target = stabiliser_.target(*sample_, next, *state_);
  if (!motion_ || motion_->retraces) settle();  // a way back may be minutes long, and soles slide on each step of it
  if (!motion_ && command_.neutral()) way_ = anchor_;  // who sees it stand there goes on from there
  return target;
}

void Navigator::poll() {
  past_motion_.reset();
  past_rest_.reset();
  past_refusal_.reset();
  if (guard_ == Guard::stood_up && command_.neutral() && supported()) begin_anew();
  if (slipped_) history_.clear();  // what led here does not lead back
  if (slipped_ || !motion_ || !motion_->retraces) retraced_.reset();
  forget();
}

void Navigator::watch() {
  update_guard();
  if (guard_ == Guard::fallen || guard_ == Guard::stood_up) return;
  update_disturbed();
  update_slip();
  feel_ground();
}

void Navigator::update_disturbed() {
  const double omega = robot_->omega();
  const Vec3 error = state_->dcm(omega) - slid() * Vec3(sample_->com + sample_->dcom / omega);
  dcm_error_ = (anchor_.R * error).head<2>();
  disturbed_ = dcm_error_.norm() > (disturbed_ ? kBack : kTube) * robot_->profile().stance.com_height;
}

void Navigator::update_slip() {
  for (const Side side : kSides) {
    if (sample_->contact[side] && !odometry_.touch()[side]) return;  // only what stands can slide
  }
  const Pose stands = anchor_ * slid();
  const double slip = apart(stands, anchor_, sample_->com);
  const bool slipped = slip > kSlip * robot_->profile().reach.foot;
  if (slipped && !slipped_) ++slips_;
  slipped_ = slipped;
  if (!slipped) return;
  last_slip_ = slip;
  way_ = stands;  // nor does the robot make up for so much
}

Pose Navigator::slid() const {
  Pose slid = anchor_correction(sample_->sole, state_->sole, sample_->contact);
  // A frame that followed how soles sink would bring every next step down by that: ways back would end in the air.
  const double most = kSameHeight * robot_->profile().stance.com_height;
  slid.p.z() -= std::clamp(slid.p.z(), -most, most);
  return slid;
}

void Navigator::feel_ground() {
  inclined_ *= 1.0 - robot_->profile().tick.period / kForgets;
  const double carries = kEachCarries * robot_->mass() * kGravity;
  for (const Side side : kSides) {
    if (!sample_->contact[side] || odometry_.load()[side] < carries) continue;
    inclined_ = std::max(inclined_, tilt_of(sample_->sole[side].R.transpose() * state_->sole[side].R));
  }
}

std::optional<Request::Tilted> Navigator::tilted() const {
  if (!sample_->contact.left || !sample_->contact.right) return std::nullopt;
  BySide<double> by;
  for (const Side side : kSides) {
    const Mat3 turned = sample_->sole[side].R.transpose() * state_->sole[side].R;
    by[side] = odometry_.touch()[side] ? tilt_of(turned) : 0.0;
  }
  const Side side = by.left > by.right ? Side::left : Side::right;
  if (by[side] <= kFlatSole) return std::nullopt;
  return Request::Tilted{side, by[side]};
}

void Navigator::settle() {
  const Pose slid = this->slid();
  const double yaw = yaw_of(slid.R);
  const double in_place = kInPlace * robot_->profile().stance.com_height;
  if (apart(slid, {}, sample_->com) < in_place && std::abs(yaw) < kInPlace) return;
  const double share = std::min(1.0, kSettles * robot_->profile().tick.period);
  anchor_ = anchor_ * Pose{share * slid.p, rotation_z(share * yaw)};
}

std::optional<Request> Navigator::request() {
  if (guard_ != Guard::armed || tick_ < 0 || waits_) return std::nullopt;
  std::optional<Request> due = this->due();
  if (!due) return std::nullopt;
  asked_at_ = tick_;
  stop_pressed_ = false;
  asked_ = std::move(due);
  waits_ = true;
  return asked_;
}

std::optional<Request> Navigator::due() const {
  const int lookahead = robot_->profile().tick.lookahead;
  const bool on_the_way = motion_ && motion_->ticks() - index_ > lookahead;
  // A way back rests where it can once it is let go of, the robot is pushed, or soles slid too far for its margins.
  const auto slid_too_far = [&] {
    const Profile& profile = robot_->profile();
    const double most = edges_near() ? kSlipByEdges * profile.margin.edge : kSlip * profile.reach.foot;
    return apart(anchor_, base_.anchor, sample_->com) > most;
  };
  const bool ends_back = on_the_way && motion_->retraces && (command_.neutral() || disturbed_ || slid_too_far());
  const bool stops = command_.recall == Recall::stop || ends_back;
  const std::optional<Request::Tilted> tilted = this->tilted();
  const bool leaves_tilted = tilted && motion_ && motion_->goal.swing == other(tilted->side);
  std::optional<Request> due;
  std::optional<Request> stays;
  // Pushed off its way, or about to be: the motion under way ends at rest, and the robot stays there until it is back.
  if (disturbed_) due = request_catching();
  if ((disturbed_ || leaves_tilted) && on_the_way && !stops) stays = request_staying(index_ + lookahead);
  if (!due) due.swap(stays);
  if (due || (disturbed_ && !stops)) {
    // A step that catches it, a foot that stays down, or nothing.
  } else if (on_the_way) {
    if (stops) due = request_stopping(index_ + lookahead);
    if (!stops && replaceable(index_ + lookahead)) due = request_on_the_way(index_ + lookahead);
  } else if (!rest().contact.left || !rest().contact.right) {
    due = request_for(command_);
  } else if (!stops && !command_.neutral()) {
    due = request_for(command_);
  }
  if (!due) return std::nullopt;
  const bool uneven = inclined_ > kUneven;
  due->tilted = tilted;
  due->uneven = uneven;
  if (stays) {
    stays->uneven = uneven;
    due->otherwise = std::make_shared<const Request>(*std::move(stays));
  }
  // What was refused would be refused again, from the same place.
  const bool same_place = apart(due->context.anchor, refused_at_, sample_->com) < 1e-3;
  const bool again = !motion_ && ((refusal_ && refused_at_rest_ && same_place) || tick_ < not_before_);
  if (again && !due->catches) return std::nullopt;
  return due;
}

bool Navigator::edges_near() const {
  const std::optional<GroundPoint> ground = world_->ground((anchor_ * sample_->com).head<2>());
  return !ground || ground->edge < kByEdges * robot_->profile().region.foot_lateral.hi;
}

bool Navigator::replaceable(int at) const {
  if (gait_ == Gait::stop || motion_->retraces || halts_ || command_.recall != Recall::none || command_.neutral())
    return false;
  const Goal& goal = motion_->goal;
  const int last_phase = motion_->last_phase();
  const bool swings = motion_->phases.size() > 1 && goal.swing;
  const bool lands = swings && goal.contact[*goal.swing];
  // A held stick goes on from where a foot has landed; with no foot to land, from halfway through the last phase.
  const bool foot_again = is_foot(command_.guide) && !differs(command_, motion_for_);
  const int goes_on = !lands ? (last_phase + motion_->ticks()) / 2 : (foot_again ? motion_->ticks() : last_phase);
  if (at == goes_on && !command_.axes.isZero(0.0)) return true;
  const double period = robot_->profile().tick.period;
  if (tick_ < asked_at_ + std::lround(kReplacing / period)) return false;
  const int lift_off = motion_->phases.front().ticks;
  const int change = at < lift_off ? lift_off : last_phase;
  if (swings && at < change && (change - at) * period < kLeastFlight) return false;
  // A stick that is let go of, a lever as it was: what is under way serves.
  if (command_.axes.isZero(0.0) && !lever_moved(command_, asked_for_)) return false;
  return at > goes_on || differs(command_, asked_for_);
}

GuideContext Navigator::context_at_rest() const {
  GuideContext context{rest(), anchor_ * slid(), last_step_, foothold_};
  if (motion_) note_steps(motion_->goal, context.last_step, context.foothold);
  context.way = way_;
  // With a foot in the air it stays what that was to land with.
  context.unsure = sample_->contact.left && sample_->contact.right ? unsure() : base_.unsure;
  return context;
}

double Navigator::unsure() const {
  return std::min(odometry_.uncertainty(), kUnsure * past_edges_);
}

Pose Navigator::way_back(const GuideContext& context, const Command& command) const {
  const Vec3 led(command.axes[0], command.axes[1], command.axes[5]);
  if (command.guide != Part::trunk || command.recall != Recall::none || led.isZero(0.0)) return {};
  const Vec3& com = context.from.com;
  LevelMove back(context.anchor.inverse() * context.way, com);
  if (back.shift.norm() < kInPlace * robot_->profile().stance.com_height && std::abs(back.turn) < kInPlace) return {};
  const Profile::Reach& reach = robot_->profile().reach;
  const double share = kMakesUp * std::min(1.0, led.norm());
  back.bound(share * reach.trunk, share * reach.rotation);
  return back.pose(com);
}

Request Navigator::request_for(const Command& command) const {
  Request due{tick_ + (static_cast<long>(robot_->profile().tick.lookahead) << late_), command, context_at_rest(),
              rest(), history_.empty() ? nullptr : history_.back()};
  due.context.back = way_back(due.context, command);
  return due;
}

std::optional<Flight> Navigator::flight(int at) const {
  const MotionSample& sample = motion_->samples[static_cast<std::size_t>(at)];
  if (sample.contact.left && sample.contact.right) return std::nullopt;
  const double period = robot_->profile().tick.period;
  const Side up = sample.contact.left ? Side::right : Side::left;
  const int arrives = motion_->goal.contact[up] ? motion_->last_phase() : motion_->ticks();
  const double left = std::max((arrives - at) * period, kLeastFlight);
  return Flight{up, motion_->swing.lift_off, left, motion_->swing.apex_t - at * period, motion_->swing.apex};
}

Request Navigator::request_replacing(int at) const {
  const auto sample = motion_->samples.begin() + at;
  // The motion to a rest on the way back is on no trail.
  Request due{tick_ + robot_->profile().tick.lookahead,
              command_,
              context_at_rest(),
              passing(*robot_, *sample),
              history_.empty() || halts_ ? nullptr : history_.back(),
              at};
  if (at > 0) due.start.contact_before = std::prev(sample)->contact;
  return due;
}

std::optional<Halt> Navigator::halt_from(int at) const {
  if (!retraced_) return std::nullopt;
  const int leaves = motion_->leaves.value_or(motion_->ticks());
  const std::vector<Halt> rests = halts(*retraced_);
  const auto next = std::find_if(rests.begin(), rests.end(),
                                 [&](const Halt& rest) { return rest.passed > at && rest.passed <= leaves; });
  const auto both_stand = [](const MotionSample& s) { return s.contact.left && s.contact.right; };
  const auto sample = motion_->samples.begin();
  if (next == rests.end() || !std::all_of(sample + at, sample + next->passed, both_stand)) return std::nullopt;
  return *next;
}

std::optional<Request> Navigator::request_stopping(int at) const {
  if (motion_->retraces) {
    const std::optional<Halt> halt = halt_from(at);
    if (!halt) return std::nullopt;
    Request due = request_replacing(at);
    due.command.recall = Recall::stop;
    due.trail = retraced_;
    due.halt = halt;
    return due;
  }
  const bool again = asked_ && asked_->command.recall == Recall::stop;
  if (halts_ || motion_for_.recall == Recall::stop ||
      (again && tick_ < asked_at_ + std::lround(kReplacing / motion_->period)))
    return std::nullopt;
  return request_ending(at);
}

std::optional<Request> Navigator::request_staying(int at) const {
  const bool lifts = motion_->goal.swing && motion_->phases.size() > 1 && at < motion_->phases.front().ticks;
  if (!lifts || motion_->retraces || catches_) return std::nullopt;
  Request due = request_ending(at);
  due.command.recall = Recall::stop;
  return due;
}

Request Navigator::request_ending(int at) const {
  Request due = request_replacing(at);
  due.start.flight = flight(at);
  const Goal& goal = motion_->goal;
  if (goal.swing && at < motion_->last_phase()) {  // the step is not done
    due.context.last_step = base_.last_step;
    due.context.foothold = base_.foothold;
  }
  if (due.start.flight) {
    const Side up = due.start.flight->side;
    due.context.step = {up, goal.contact[up] ? goal.sole[up] : base_.foothold[up]};
  }
  due.context.from = due.start;
  return due;
}

std::optional<Request> Navigator::request_catching() const {
  const Vec2 error = (anchor_.R.transpose() * Vec3(dcm_error_.x(), dcm_error_.y(), 0)).head<2>();
  // The DCM drifts away from the plan's unless the ZMP can be shifted as far as it is off.
  const double size = error.norm();
  const Vec2 holds = sample_->zmp + (1.0 + kReserve) * error;
  const Profile& profile = robot_->profile();
  const auto along = [&](const Vec2& v) { return v.dot(error) / size; };
  double room = std::max(0.0, along(sample_->zmp_region->nearest(holds) - sample_->zmp));
  // Soles that stand on edges do not take the ZMP where they should.
  const double lacks = along(correction().lacks) - kLacks * profile.stance.com_height;
  if (lacks > 0.0) room = std::clamp(along(correction().zmp - sample_->zmp) - lacks, 0.0, room);
  if (sample_->zmp_region->margin(holds) >= 0.0 && room >= size) return std::nullopt;
  const int lookahead = profile.tick.lookahead;
  Request due = request_for(Command{.guide = command_.guide});
  std::optional<Vec2> catching;  // such a step is under way, and is so much longer for it
  double lands = profile.phases.flow[1] * profile.duration.first;
  if (due.start.contact.left && due.start.contact.right) lands += profile.phases.flow[0] * profile.duration.first;
  if (motion_) {
    const int at = index_ + lookahead;
    if (motion_->retraces || at >= motion_->ticks()) return std::nullopt;
    catching = at < motion_->last_phase() ? catches_ : std::nullopt;
    due = request_ending(at);
    due.command = Command{.guide = command_.guide};
    const Goal& goal = motion_->goal;
    const int lift_off = motion_->phases.front().ticks;
    if (due.start.flight) {
      if (catching) due.context.step->to.p.head<2>() -= *catching;
      lands = due.start.flight->left;
    } else if (goal.swing && motion_->phases.size() > 1 && at < lift_off) {
      due.start.lift_off = LiftOff{*goal.swing, (lift_off - at) * motion_->period};
      due.context.from.lift_off = due.start.lift_off;
      lands = due.start.lift_off->left + profile.phases.flow[1] * profile.duration.first;
    }
  }
  // A sole that tips over its edge says nothing about the height of the ground.
  due.context.anchor.p.z() = anchor_.p.z();
  const double beyond = std::max(0.0, size - room);
  const double until = lookahead * profile.tick.period + lands;
  const double least = std::max(size, kLeastCatch * profile.stance.com_height);
  const double then = std::min(least + beyond * (std::exp(robot_->omega() * until) - 1.0), profile.region.foot_x.hi);
  if (catching && then < kFarther * catching->norm()) return std::nullopt;
  due.catches = then / size * error;
  due.beyond = beyond;
  if (due.start.flight) due.lands = until;
  if (catching) due.gains = along(*catching);
  return due;
}

Request Navigator::request_on_the_way(int at) const {
  const Goal& goal = motion_->goal;
  const MotionSample& sample = motion_->samples[static_cast<std::size_t>(at)];
  const double period = robot_->profile().tick.period;
  const int last_phase = motion_->last_phase();
  const bool both_end = goal.contact.left && goal.contact.right;
  Request due = request_replacing(at);
  Posture& start = due.start;
  Posture& from = due.context.from;
  const Part guided = command_.guide;
  // A lever that moves while the stick is centred changes how high the foot is, not where it goes.
  if (command_.axes.isZero(0.0) && command_.guide == motion_for_.guide) due.command.axes = motion_for_.axes;
  due.context.goes_on = command_.guide == motion_for_.guide && !motion_for_.axes.isZero(0.0);
  due.context.back = way_back(due.context, due.command);

  start.flight = flight(at);
  // Once a foot is up that stays up, all that is left is its way through the air.
  const bool several = motion_->phases.size() > 1 && (at < last_phase || both_end);
  const int lift_off = motion_->phases.front().ticks;
  if (goal.swing && sample.contact.left && sample.contact.right && at < lift_off && several)
    start.lift_off = LiftOff{*goal.swing, (lift_off - at) * period};
  if (several && at >= last_phase && both_end) return due;  // on from the rest that the step leads to
  if (several) {
    // The same step again, to another goal.
    const Pose anchor = due.context.anchor;
    const bool goes_on = due.context.goes_on;
    due.context = base_;
    due.context.anchor = anchor;
    due.context.goes_on = goes_on;
    from.q.tail(robot_->nv() - 6) = motion_->end.q.tail(robot_->nv() - 6);
    if (start.flight && from.contact.left && from.contact.right) {
      const Side up = start.flight->side;
      due.context.step = {up, goal.contact[up] ? goal.sole[up] : from.sole[up]};
    }
  }
  // The guided part goes on from where it is; a foot, from where it began to move.
  if (guided == Part::trunk) {
    from.com = start.com;
    from.trunk = start.trunk;
  } else if (is_hand(guided)) {
    from.hand[side_of(guided)] = start.hand[side_of(guided)];
    from.shoulder[side_of(guided)] = start.shoulder[side_of(guided)];
  } else if (!several) {
    from.sole[side_of(guided)] = start.sole[side_of(guided)];
  }
  return due;
}

void Navigator::offer(Answer result) {
  if (!waits_ || result.take_over != asked_->take_over || result.take_over <= tick_) return;
  offered_ = std::move(result);
  answered_ = true;
}

void Navigator::end_of_motion() {
  note_steps(motion_->goal, last_step_, foothold_);
  past_rest_.swap(rested_);
  rested_ = planned_->motion;
  past_motion_ = std::move(planned_);
  planned_.reset();
  motion_ = nullptr;
}

void Navigator::drop_refusal() {
  if (!refusal_) return;
  past_refusal_ = std::move(refusal_);
  refusal_.reset();
}

void Navigator::put_refusal(Refusal& refusal) {
  drop_refusal();
  std::swap(refusal_.emplace(), refusal);
}

bool Navigator::take_over() {
  if (!waits_ || asked_->take_over > tick_) return false;
  waits_ = false;
  const bool answered = std::exchange(answered_, false);
  if (!answered) {
    ++dropped_;
    asked_at_ = 0;  // again, at once
  }
  // At rest nothing is lost by waiting longer for the next answer.
  late_ = answered ? 0 : std::min(late_ + (motion_ ? 0 : 1), kMostLate);
  if (!answered || guard_ != Guard::armed) return false;
  Answer& result = *offered_;
  const bool stops = result.command.recall == Recall::stop;
  const bool urgent = stops || result.catches.has_value();
  if (disturbed_ && !urgent) return false;  // pushed meanwhile
  // Let go of meanwhile: the motion under way ends at rest.
  if (!urgent && (stop_pressed_ || (motion_ && command_.neutral()))) return false;
  if (const auto* planned = std::get_if<PlannedMotion>(&result.outcome)) {
    const Motion* motion = &*planned->motion;
    if (motion->retraces && history_.empty()) return false;  // a slip has ended the way back meanwhile
    if (stops && motion_ && !motion_->retraces && motion->ticks() >= motion_->ticks() - index_)
      return false;  // not sooner
    motion_for_ = asked_for_ = result.command;
    catches_ = result.catches;
    caught_ += catches_.has_value() ? 1 : 0;
    commit(result);
    return true;
  }
  if (motion_ && urgent) return false;  // the motion under way ends at rest
  auto* refusal = std::get_if<Refusal>(&result.outcome);
  if (motion_) {
    // Not on the way; it is asked again where the motion can go on, or at rest.
    asked_for_ = result.command;
    refused_at_rest_ = false;
    if (refusal != nullptr && !result.context.goes_on) put_refusal(*refusal);
    refused_ = result.command;
  } else if (refusal != nullptr) {
    put_refusal(*refusal);
    refused_at_rest_ = true;
    refused_ = result.command;
    refused_at_ = result.context.anchor;
    not_before_ = tick_ + std::lround(kPatience / robot_->profile().tick.period);
  }
  return false;
}

void Navigator::commit(Answer& result) {
  auto& planned = std::get<PlannedMotion>(result.outcome);
  const Motion& motion = *planned.motion;
  halts_ = motion_ && motion_->retraces;
  if (motion.retraces) {
    retraced_.swap(history_.back());
    result.trail.swap(history_.back());  // of a part of the way back: what is left of it
    if (!motion.leaves) history_.pop_back();
  } else if (!motion_) {
    history_.push_back(std::move(result.trail));
  } else if (motion_->retraces && !motion_->leaves) {
    if (retraced_) history_.push_back(std::move(result.trail));  // or a slip has ended that way back
  } else if (!history_.empty()) {
    history_.back().swap(result.trail);
  }
  if (planned_) {
    std::swap(*planned_, planned);
  } else {
    planned_ = std::move(planned);
  }
  motion_ = &motion;
  index_ = 0;
  std::swap(base_, result.context);
  anchor_ = base_.anchor;
  way_ = base_.way * motion_->goal.back.inverse();
  last_step_ = base_.last_step;
  foothold_ = base_.foothold;
  ++committed_;
  drop_refusal();
}

void Navigator::forget() {
  if (!history_.empty() && !history_.back()) history_.clear();  // it never got to the rest that leads back
  long ticks = 0;
  auto oldest = history_.end();
  while (oldest != history_.begin() && history_.end() - oldest < kHistory &&
         (ticks += (*std::prev(oldest))->ticks()) <= kHistoryTicks)
    --oldest;
  history_.erase(history_.begin(), oldest);
}

void Navigator::update_guard() {
  const double height = robot_->profile().stance.com_height;
  const BySide<double>& load = odometry_.load();
  const double carried = (load.left + load.right) / (robot_->mass() * kGravity);
  const double lower = std::min(state_->sole.left.p.z(), state_->sole.right.p.z());
  const double tilt = tilt_of(state_->trunk);
  const auto lasts = [this](bool condition, double seconds) {
    guard_ticks_ = condition ? guard_ticks_ + 1 : 0;
    return guard_ticks_ * robot_->profile().tick.period >= seconds;
  };
  switch (guard_) {
    case Guard::armed:
      if (tilt > kFallenTilt || state_->com.z() - lower < kFallenHeight * height) return fall();
      if (lasts(carried < kLifted, kSure)) guard_ = Guard::lifted;
      break;
    case Guard::lifted:
      if (lasts(carried > kStands && command_.neutral(), kSure)) guard_ = Guard::armed;
      break;
    case Guard::fallen:
      if (lasts(stands_upright(), kStill)) guard_ = Guard::stood_up;
      break;
    case Guard::stood_up:
      if (!stands_upright()) guard_ = Guard::fallen;
      break;
  }
}

bool Navigator::stands_upright() const {
  const Profile& profile = robot_->profile();
  const double weight = robot_->mass() * kGravity;
  bool stands = tilt_of(state_->trunk) < profile.region.trunk_inclination &&
                state_->dcom.norm() < kStillSpeed * profile.stance.com_height;
  for (const Side side : kSides)
    stands = stands && odometry_.load()[side] > kEachCarries * weight && tilt_of(state_->sole[side].R) < kFlatSole;
  return stands;
}

bool Navigator::supported() const {
  const BySide<bool> both{true, true};
  const ConvexPolygon support =
      support_polygon(*robot_, state_->sole, both, state_->com, support_plane(state_->sole, both));
  return support.margin(state_->com.head<2>()) > robot_->profile().margin.stand_on;
}

void Navigator::begin_anew() {
  rested_.reset();
  posture_ = posture_of(*robot_, state_->q);
  held_ = resting(*robot_, posture_);
  foothold_ = posture_.sole;
  way_ = anchor_;
  base_ = {};
  sample_ = &held_;
  stabiliser_.reset();
  history_.clear();
  retraced_.reset();
  halts_ = false;
  inclined_ = 0.0;
  drop_refusal();
  guard_ = Guard::armed;
}

void Navigator::fall() {
  guard_ = Guard::fallen;
  guard_ticks_ = 0;
  if (planned_) past_motion_ = std::move(planned_);
  planned_.reset();
  motion_ = nullptr;
  waits_ = answered_ = false;
  disturbed_ = slipped_ = false;
  dcm_error_.setZero();
  sample_ = &held();
}

Intent Navigator::intent() const {
  if (!motion_) return Intent::none;
  if (catches_) return Intent::capture;
  switch (motion_for_.recall) {
    case Recall::retrace:
      return Intent::retrace;
    case Recall::home:
      return Intent::home;
    case Recall::stop:
      return Intent::stop;
    case Recall::none:
      break;
  }
  return Intent::follow;
}

Phase Navigator::phase() const {
  if (guard_ == Guard::fallen || guard_ == Guard::stood_up) return Phase::fallen;
  if (!motion_) return Phase::hold;
  if (sample_->contact.left && sample_->contact.right) return Phase::double_support;
  return sample_->contact.left ? Phase::single_left : Phase::single_right;
}

}  // namespace baton
