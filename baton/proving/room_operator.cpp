#include "baton/proving/room_operator.hpp"

#include <algorithm>
#include <cmath>

namespace baton {
namespace {

constexpr double kCrouch = 0.245 / 0.26;  ///< share of the nominal COM height on the steps
constexpr double kBeforeEdge = 0.0045;    ///< from toe to edge before a step down [m]
constexpr double kPastEdge = 0.0050;      ///< from edge to heel after it [m]
constexpr double kFootSpot = 0.0035;      ///< a foot is where it should be when it is as near as this [m]
constexpr double kLift = 0.4;             ///< of the throttle: a little is enough on the way down
constexpr double kHeightSpot = 0.003;     ///< [m]
constexpr double kFar = 0.5;              ///< deflection below which one does not steer any more
constexpr double kYawSpot = 0.03;         ///< [rad]
/// How far from the hand's target the shoulder is taken, of the reach; the next where it did not get there in time.
constexpr std::array<double, 3> kFromTarget{0.95, 0.85, 1.0};
constexpr double kReachPatience = 6.0;  ///< [s]

}  // namespace

RoomOperator::RoomOperator(const RobotModel& robot, const World& world, std::uint64_t seed, Gait gait)
    : RoomOperator(robot, world, seed, gait, Parameters{}) {}

RoomOperator::RoomOperator(const RobotModel& robot, const World& world, std::uint64_t seed, Gait gait,
                           Parameters parameters)
    : robot_(&robot),
      gait_(gait),
      foot_by_foot_(gait == Gait::stop || parameters.foot_by_foot),
      parameters_(parameters),
      random_(seed),
      kinematics_(robot),
      door_(world.site("door_B").p) {
  const Vec3 start = world.site("start").p;
  double height = start.z();
  for (double x = start.x(); x < door_.x(); x += 1e-4) {
    const auto ground = world.ground({x, start.y()});
    if (ground && ground->height < height - 1e-3) edges_.push_back(x);
    if (ground) height = ground->height;
  }
  for (const Vec2& vertex : robot.sole(Side::left).vertices())
    sole_length_ = std::max(sole_length_, vertex.x());
}

std::string_view RoomOperator::doing() const {
  switch (stage_) {
    case Stage::face:
      return "turns to the steps";
    case Stage::crouch:
      return "bends the knees";
    case Stage::steps:
      return "goes down the steps";
    case Stage::rise:
      return "straightens up";
    case Stage::cross:
      return "crosses the room";
    case Stage::align:
      return "sets the feet";
    case Stage::reach:
      return "reaches for the door";
    case Stage::hold:
      return "holds the hand at the door";
    case Stage::done:
      return "is done";
  }
  return "";
}

RoomOperator::Sight RoomOperator::look(const Session& session) {
  std::normal_distribution<double> normal;
  const auto seen = [&](const Vec3& p) -> Vec3 {
    return p + parameters_.sight_error * Vec3(normal(random_), normal(random_), normal(random_));
  };
  kinematics_.set(session.truth().q);
  Sight sight;
  for (const Side side : kSides) {
    const Pose sole = kinematics_.sole(side);
    sight.sole[side] = {seen(sole.p), rotation_z(yaw_of(sole.R) + parameters_.sight_yaw_error * normal(random_))};
  }
  sight.com = seen(kinematics_.com());
  sight.hand = seen(kinematics_.hand(Side::left).p);
  sight.shoulder = seen(kinematics_.shoulder(Side::left));
  sight.trunk_yaw = yaw_of(kinematics_.trunk().R) + parameters_.sight_yaw_error * normal(random_);
  sight.heading = mean_yaw(sight.sole);
  return sight;
}

RoomOperator::Sight RoomOperator::foreseen(const Session& session) {
  const Sight now = look(session);
  Sight then = now;
  const double since = session.t() - looked_;
  if (last_look_ && since < 2.0 * parameters_.reaction) {
    const double share = parameters_.foresight / since;
    const Vec3 moved = now.com - last_look_->com;
    then.com += share * moved;
    then.shoulder += share * moved;
    then.hand += share * (now.hand - last_look_->hand);
    then.trunk_yaw += share * wrap_angle(now.trunk_yaw - last_look_->trunk_yaw);
  }
  last_look_ = now;
  looked_ = session.t();
  return then;
}

Command RoomOperator::decide(const Session& session) {
  const bool by_steps = (stage_ == Stage::steps && foot_by_foot_) || stage_ == Stage::align || stage_ >= Stage::hold;
  return gait_ == Gait::stop || by_steps || steered_ == stage_ ? step_by_step(session) : steer(session);
}

Command RoomOperator::steer(const Session& session) {
  const double t = session.t();
  if (t - since_ < parameters_.reaction) return stick_;
  since_ = t;
  refusals_ = session.navigator().refusal() ? refusals_ + 1 : 0;
  const Sight sight = foreseen(session);
  std::optional<Command> command = next(sight);
  if (!command && stage_ == Stage::steps) {  // down, and on without a rest
    stage_ = Stage::cross;
    command = next(sight);
  }
  if (command && command->axes.cwiseAbs().maxCoeff() > kFar && refusals_ < 3) {
    stick_ = *command;
    return stick_;
  }
  // Near: the rest step by step. If it does not go down like this, then foot by foot.
  stick_.axes.setZero();
  steered_ = stage_;
  if (stage_ == Stage::steps) {
    foot_by_foot_ = true;
    stage_ = Stage::crouch;
    refusals_ = 0;
  }
  return stick_;
}

Command RoomOperator::step_by_step(const Session& session) {
  const Navigator& robot = session.navigator();
  const bool lifted = lifted_.left || lifted_.right;
  swung_ = swung_ || robot.phase() == Phase::single_left || robot.phase() == Phase::single_right;
  const bool landed = gait_ == Gait::flow && swung_ && !lifted && robot.phase() == Phase::double_support;
  const bool ready = session.resting() || landed;
  const double t = session.t();
  if (deflected_) {
    const bool refused = robot.refusal().has_value() && t - since_ > parameters_.patience;
    if (robot.committed() == moved_ && !refused) return stick_;
    refusals_ = refused ? refusals_ + 1 : 0;
    // It moves, or it does not want to: let go, but keep a lifted foot up.
    deflected_ = false;
    stick_.axes.setZero();
    since_ = t;
    return stick_;
  }
  if (!ready) {
    since_ = t;
    return stick_;
  }
  if (stage_ == Stage::hold) {
    if (t - since_ >= parameters_.settle) stage_ = Stage::done;
    return stick_;
  }
  if (t - since_ < parameters_.reaction || stage_ == Stage::done) return stick_;
  const Sight sight = look(session);
  if (stage_ == Stage::reach && t - reaching_since_ > kReachPatience) {  // from another place, the arm down first
    ++approach_;
    stage_ = Stage::cross;
    steered_.reset();
    refusals_ = 0;
  }
  std::optional<Command> command = next(sight);
  while (!command && stage_ != Stage::hold) {
    stage_ = static_cast<Stage>(static_cast<int>(stage_) + 1);
    refusals_ = 0;
    if (stage_ == Stage::reach) reaching_since_ = t;
    if (stage_ != Stage::hold) command = next(sight);
  }
  since_ = t;
  if (!command) return stick_;
  stick_ = *command;
  deflected_ = true;
  moved_ = robot.committed();
  swung_ = false;
  return stick_;
}

std::optional<Command> RoomOperator::next(const Sight& sight) {
  const double nominal = robot_->profile().stance.com_height;
  switch (stage_) {
    case Stage::face:
      return face(sight);
    case Stage::crouch:
      return foot_by_foot_ ? change_height(sight, kCrouch * nominal) : std::nullopt;
    case Stage::steps:
      return foot_by_foot_ ? go_down(sight) : walk_down(sight);
    case Stage::rise:
      return change_height(sight, nominal);
    case Stage::cross:
      return cross(sight);
    case Stage::align:
      return align(sight);
    case Stage::reach:
      return reach(sight);
    case Stage::hold:
    case Stage::done:
      break;
  }
  return std::nullopt;
}

Command RoomOperator::deflect(Part part, const Sight& sight, const Vec3& shift, double full) const {
  Command command;
  command.guide = part;
  Vec3 axes = rotation_z(-sight.heading) * shift / full;
  axes /= std::max(1.0, axes.cwiseAbs().maxCoeff());
  command.axes.head<3>() = axes;
  return command;
}

double RoomOperator::turn_back(double yaw) const {
  return std::clamp(-yaw / robot_->profile().reach.rotation, -1.0, 1.0);
}

std::optional<Command> RoomOperator::face(const Sight& sight) const {
  // The trunk turns first, the feet follow when they must.
  const double trunk = sight.trunk_yaw;
  if ((std::abs(trunk) < kYawSpot && std::abs(sight.heading) < 2.0 * kYawSpot) || refusals_ > 6) return std::nullopt;
  Command command;
  command.axes[5] = turn_back(std::abs(trunk) < kYawSpot ? sight.heading : trunk);
  return command;
}

std::optional<Command> RoomOperator::change_height(const Sight& sight, double height) const {
  const double error = height - (sight.com.z() - 0.5 * (sight.sole.left.p.z() + sight.sole.right.p.z()));
  if (std::abs(error) < kHeightSpot || refusals_ > 3) return std::nullopt;
  return deflect(Part::trunk, sight, {0, 0, error}, robot_->profile().reach.trunk);
}

std::optional<Command> RoomOperator::move_foot(const Sight& sight, Side side, const Vec2& to, bool through_the_air,
                                               double tolerance) {
  const Profile::Reach& full = robot_->profile().reach;
  const Pose& foot_now = sight.sole[side];
  Vec2 shift = to - foot_now.p.head<2>();
  const double yaw = yaw_of(foot_now.R);
  const bool there = shift.norm() < tolerance && std::abs(yaw) < kYawSpot;
  if (there && !lifted_[side]) return std::nullopt;
  // After refusals, away from the other foot.
  if (refusals_ > 1 && !through_the_air) shift.y() += 0.005 * std::min(refusals_, 4) * sign_of(side);
  Command command = deflect(foot(side), sight, Vec3(shift.x(), shift.y(), 0), full.foot);
  command.axes.z() = 0.0;
  // After a refusal, try less.
  command.axes.head<2>() *= std::pow(0.7, refusals_ % 6);
  if (std::abs(yaw) > kYawSpot) command.axes[5] = turn_back(yaw);
  lifted_[side] = through_the_air && !(lifted_[side] && there);
  if (lifted_[side]) command.lift[side] = kLift;
  if (there) command.axes.setZero();
  return command;
}

std::optional<Command> RoomOperator::go_down(const Sight& sight) {
  const double half_width = 0.5 * robot_->profile().stance.width;
  const Vec2 middle = sight.feet();
  const auto lane = [&](Side side) { return middle.y() + sign_of(side) * half_width; };
  for (const Side side : kSides) {
    if (lifted_[side]) return move_foot(sight, side, landing_[side], true, kFootSpot);
  }
  // The edge that the left foot, which goes first, has not passed yet; or the right one after it.
  for (std::size_t i = 0; i < edges_.size(); ++i) {
    const double before = edges_[i] - sole_length_ - kBeforeEdge;
    const double past = edges_[i] + sole_length_ + kPastEdge;
    const bool left_past = sight.sole.left.p.x() > edges_[i];
    const bool right_past = sight.sole.right.p.x() > edges_[i];
    if (left_past && right_past) continue;
    if (!left_past) {
      // Both feet up to the edge, the one that is behind first.
      Side behind = sight.sole.left.p.x() < sight.sole.right.p.x() ? Side::left : Side::right;
      if (refusals_ % 2 == 1) behind = other(behind);
      for (const Side side : {behind, other(behind)}) {
        const double y = std::abs(sight.sole.left.p.y() - sight.sole.right.p.y() - 2.0 * half_width) < 0.01
                             ? sight.sole[side].p.y()
                             : lane(side);
        const double x =
            side == Side::left ? std::min(before, sight.sole.right.p.x() + robot_->profile().reach.foot) : before;
        if (side == Side::left && sight.sole.left.p.x() > before - 0.015 &&
            std::abs(yaw_of(sight.sole.left.R)) < kYawSpot)
          continue;
        if (auto command = move_foot(sight, side, {x, y}, false, kFootSpot)) return command;
      }
    }
    const Side side = left_past ? Side::right : Side::left;
    double x = past;
    if (side == Side::right) {
      // Beside the left foot, or up to the next edge.
      x = sight.sole.left.p.x();
      if (i + 1 < edges_.size()) x = edges_[i + 1] - sole_length_ - kBeforeEdge;
    }
    const double y = sight.sole[other(side)].p.y() + sign_of(side) * 2.0 * half_width;
    landing_[side] = {x, y};
    if (auto command = move_foot(sight, side, landing_[side], true, kFootSpot)) return command;
  }
  return std::nullopt;
}

std::optional<Command> RoomOperator::walk_down(const Sight& sight) const {
  const double past = edges_.empty() ? -1.0 : edges_.back();
  if (std::min(sight.sole.left.p.x(), sight.sole.right.p.x()) > past) return std::nullopt;
  Command command;
  command.axes[0] = 1.0;
  if (std::abs(sight.heading) > kYawSpot) command.axes[5] = turn_back(sight.heading);
  return command;
}

Vec2 RoomOperator::place_to_reach_from(const Sight& sight) const {
  const double comfortable = kFromTarget[approach_ % kFromTarget.size()] * robot_->profile().region.hand_distance;
  const double below = sight.shoulder.z() - door_.z();
  const double ahead = std::sqrt(std::max(0.0, comfortable * comfortable - below * below));
  const Vec2 shoulder = (sight.shoulder - sight.com).head<2>();
  return door_.head<2>() - Vec2(ahead, 0) - shoulder;
}

std::optional<Command> RoomOperator::cross(const Sight& sight) const {
  const Vec2 shift = place_to_reach_from(sight) - sight.com.head<2>();
  const double yaw = sight.heading;
  if ((shift.norm() < 0.02 && std::abs(yaw) < 2.0 * kYawSpot) || refusals_ > 8) return std::nullopt;
  Command command = deflect(Part::trunk, sight, Vec3(shift.x(), shift.y(), 0), robot_->profile().reach.trunk);
  command.axes.z() = 0.0;
  command.axes.head<2>() *= std::pow(0.7, refusals_);
  if (std::abs(yaw) > kYawSpot) command.axes[5] = turn_back(yaw);
  return command;
}

std::optional<Command> RoomOperator::align(const Sight& sight) {
  const Vec2 middle = place_to_reach_from(sight);
  const double half_width = 0.5 * robot_->profile().stance.width;
  // The foot that is farther from its place first.
  const auto place = [&](Side side) -> Vec2 { return middle + Vec2(0, sign_of(side) * half_width); };
  const auto off = [&](Side side) { return (place(side) - sight.sole[side].p.head<2>()).norm(); };
  Side first = off(Side::left) > off(Side::right) ? Side::left : Side::right;
  if (refusals_ % 2 == 1) first = other(first);
  if (refusals_ > 8) return std::nullopt;
  for (const Side side : {first, other(first)}) {
    if (auto command = move_foot(sight, side, place(side), false, 0.008)) return command;
  }
  return std::nullopt;
}

std::optional<Command> RoomOperator::reach(const Sight& sight) const {
  Vec3 shift = door_ - sight.hand;
  if (shift.norm() < parameters_.near) return std::nullopt;
  // What does not go in one go may go one axis after the other, and in smaller moves.
  const int way = refusals_ % 4;
  if (way > 0) {
    for (int axis = 0; axis < 3; ++axis) {
      if (axis != (way + 1) % 3) shift[axis] = 0.0;
    }
  }
  Command command = deflect(Part::left_hand, sight, shift, robot_->profile().reach.hand);
  command.axes *= std::pow(0.6, refusals_ / 4);
  return command;
}

}  // namespace baton
