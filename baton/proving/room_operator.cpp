#include "baton/proving/room_operator.hpp"

#include <algorithm>
#include <cmath>

namespace baton {
namespace {

constexpr double kCrouch = 0.245 / 0.26;    ///< COM height on the steps, fraction of nominal
constexpr double kBeforeEdge = 0.0045;      ///< toe to edge before a step down [m]
constexpr double kPastEdge = 0.0050;        ///< edge to heel after it [m]
constexpr double kFootTolerance = 0.0035;   ///< position tolerance of a foot [m]
constexpr double kLift = 0.4;               ///< throttle; little is needed on the way down
constexpr double kHeightTolerance = 0.003;  ///< [m]
constexpr double kLeastSteering = 0.5;      ///< deflection below which steering ends
constexpr double kYawTolerance = 0.03;      ///< [rad]
/// Distance of the shoulder from the hand's target, in reaches; the next is tried if the hand does not arrive in time.
constexpr std::array<double, 3> kFromTarget{0.95, 0.85, 1.0};
constexpr double kReachPatience = 6.0;  ///< [s]

}  // namespace

RoomOperator::RoomOperator(const RobotModel& robot, const World& world, std::uint64_t seed, Gait gait)
    : RoomOperator(robot, world, seed, gait, Parameters{}) {}

RoomOperator::RoomOperator(const RobotModel& robot, const World& world, std::uint64_t seed, Gait gait,
                           Parameters parameters)
    : robot_(&robot),
      gait_(gait),
      parameters_(parameters),
      eyes_(robot, seed, parameters.eyes),
      room_{world.site("door_B").p, {}},
      foot_by_foot_(gait == Gait::stop || parameters.foot_by_foot) {
  const Vec3 start = world.site("start").p;
  double height = start.z();
  for (double x = start.x(); x < room_.door.x(); x += 1e-4) {
    const auto ground = world.ground({x, start.y()});
    if (ground && ground->height < height - 1e-3) room_.edges.push_back(x);
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

Command RoomOperator::decide(const View& view) {
  const bool by_steps = (stage_ == Stage::steps && foot_by_foot_) || stage_ == Stage::align || stage_ >= Stage::hold;
  return gait_ == Gait::stop || by_steps || steered_ == stage_ ? step_by_step(view) : steer(view);
}

Command RoomOperator::steer(const View& view) {
  const double t = view.t;
  if (t - deflection_.since < parameters_.reaction) return stick_;
  deflection_.since = t;
  deflection_.refusals = view.navigator.refusal() ? deflection_.refusals + 1 : 0;
  const Sight sight = eyes_.foresee(view, 2.0 * parameters_.reaction);
  std::optional<Command> command = next(sight);
  if (!command && stage_ == Stage::steps) {  // down the steps; continue without a rest
    stage_ = Stage::cross;
    command = next(sight);
  }
  if (command && command->axes.cwiseAbs().maxCoeff() > kLeastSteering && deflection_.refusals < 3) {
    stick_ = *command;
    return stick_;
  }
  // Close: continue step by step. If walking down fails, go down foot by foot.
  stick_.axes.setZero();
  steered_ = stage_;
  if (stage_ == Stage::steps) {
    foot_by_foot_ = true;
    stage_ = Stage::crouch;
    deflection_.refusals = 0;
  }
  return stick_;
}

Command RoomOperator::step_by_step(const View& view) {
  const Navigator& robot = view.navigator;
  const bool lifted = feet_.lifted.left || feet_.lifted.right;
  deflection_.swung = deflection_.swung || robot.phase() == Phase::single_left || robot.phase() == Phase::single_right;
  const bool landed = gait_ == Gait::flow && deflection_.swung && !lifted && robot.phase() == Phase::double_support;
  const bool ready = robot.motion() == nullptr || landed;
  const double t = view.t;
  if (deflection_.held) {
    const bool refused = robot.refusal() != nullptr && t - deflection_.since > parameters_.patience;
    if (robot.committed() == deflection_.moved && !refused) return stick_;
    deflection_.refusals = refused ? deflection_.refusals + 1 : 0;
    // It moves, or it refuses: release, but keep a lifted foot up.
    deflection_.held = false;
    stick_.axes.setZero();
    deflection_.since = t;
    return stick_;
  }
  if (!ready) {
    deflection_.since = t;
    return stick_;
  }
  if (stage_ == Stage::hold) {
    if (t - deflection_.since >= parameters_.settle) stage_ = Stage::done;
    return stick_;
  }
  if (t - deflection_.since < parameters_.reaction || stage_ == Stage::done) return stick_;
  const Sight sight = eyes_.look(view);
  if (stage_ == Stage::reach && t - reaching_since_ > kReachPatience) {  // retry from another position, arm down first
    ++approach_;
    stage_ = Stage::cross;
    steered_.reset();
    deflection_.refusals = 0;
  }
  std::optional<Command> command = next(sight);
  while (!command && stage_ != Stage::hold) {
    stage_ = static_cast<Stage>(static_cast<int>(stage_) + 1);
    deflection_.refusals = 0;
    if (stage_ == Stage::reach) reaching_since_ = t;
    if (stage_ != Stage::hold) command = next(sight);
  }
  deflection_.since = t;
  if (!command) return stick_;
  stick_ = *command;
  deflection_.held = true;
  deflection_.moved = robot.committed();
  deflection_.swung = false;
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
  // The trunk turns first; the feet follow when necessary.
  const double trunk = sight.trunk_yaw;
  if ((std::abs(trunk) < kYawTolerance && std::abs(sight.heading) < 2.0 * kYawTolerance) || deflection_.refusals > 6)
    return std::nullopt;
  Command command;
  command.axes[5] = turn_back(std::abs(trunk) < kYawTolerance ? sight.heading : trunk);
  return command;
}

std::optional<Command> RoomOperator::change_height(const Sight& sight, double height) const {
  const double error = height - (sight.com.z() - 0.5 * (sight.sole.left.p.z() + sight.sole.right.p.z()));
  if (std::abs(error) < kHeightTolerance || deflection_.refusals > 3) return std::nullopt;
  return deflect(Part::trunk, sight, {0, 0, error}, robot_->profile().reach.trunk);
}

std::optional<Command> RoomOperator::move_foot(const Sight& sight, Side side, const Vec2& to, bool through_the_air,
                                               double tolerance) {
  const Profile::Reach& full = robot_->profile().reach;
  const Pose& foot_now = sight.sole[side];
  Vec2 shift = to - foot_now.p.head<2>();
  const double yaw = yaw_of(foot_now.R);
  const bool there = shift.norm() < tolerance && std::abs(yaw) < kYawTolerance;
  if (there && !feet_.lifted[side]) return std::nullopt;
  // After refusals, move away from the other foot.
  if (deflection_.refusals > 1 && !through_the_air)
    shift.y() += 0.005 * std::min(deflection_.refusals, 4) * sign_of(side);
  Command command = deflect(foot(side), sight, Vec3(shift.x(), shift.y(), 0), full.foot);
  command.axes.z() = 0.0;
  // After a refusal, try less.
  command.axes.head<2>() *= std::pow(0.7, deflection_.refusals % 6);
  if (std::abs(yaw) > kYawTolerance) command.axes[5] = turn_back(yaw);
  feet_.lifted[side] = through_the_air && !(feet_.lifted[side] && there);
  if (feet_.lifted[side]) command.lift[side] = kLift;
  if (there) command.axes.setZero();
  return command;
}

std::optional<Command> RoomOperator::go_down(const Sight& sight) {
  const double half_width = 0.5 * robot_->profile().stance.width;
  const Vec2 middle = sight.feet();
  const auto lane = [&](Side side) { return middle.y() + sign_of(side) * half_width; };
  for (const Side side : kSides) {
    if (feet_.lifted[side]) return move_foot(sight, side, feet_.landing[side], true, kFootTolerance);
  }
  // The next edge for the left foot, which goes first, or for the right foot after it.
  for (std::size_t i = 0; i < room_.edges.size(); ++i) {
    const double before = room_.edges[i] - sole_length_ - kBeforeEdge;
    const double past = room_.edges[i] + sole_length_ + kPastEdge;
    const bool left_past = sight.sole.left.p.x() > room_.edges[i];
    const bool right_past = sight.sole.right.p.x() > room_.edges[i];
    if (left_past && right_past) continue;
    if (!left_past) {
      // Bring both feet up to the edge, the rear one first.
      Side behind = sight.sole.left.p.x() < sight.sole.right.p.x() ? Side::left : Side::right;
      if (deflection_.refusals % 2 == 1) behind = other(behind);
      for (const Side side : {behind, other(behind)}) {
        const double y = std::abs(sight.sole.left.p.y() - sight.sole.right.p.y() - 2.0 * half_width) < 0.01
                             ? sight.sole[side].p.y()
                             : lane(side);
        const double x =
            side == Side::left ? std::min(before, sight.sole.right.p.x() + robot_->profile().reach.foot) : before;
        if (side == Side::left && sight.sole.left.p.x() > before - 0.015 &&
            std::abs(yaw_of(sight.sole.left.R)) < kYawTolerance)
          continue;
        if (auto command = move_foot(sight, side, {x, y}, false, kFootTolerance)) return command;
      }
    }
    const Side side = left_past ? Side::right : Side::left;
    double x = past;
    if (side == Side::right) {
      // Beside the left foot, or up to the next edge.
      x = sight.sole.left.p.x();
      if (i + 1 < room_.edges.size()) x = room_.edges[i + 1] - sole_length_ - kBeforeEdge;
    }
    const double y = sight.sole[other(side)].p.y() + sign_of(side) * 2.0 * half_width;
    feet_.landing[side] = {x, y};
    if (auto command = move_foot(sight, side, feet_.landing[side], true, kFootTolerance)) return command;
  }
  return std::nullopt;
}

std::optional<Command> RoomOperator::walk_down(const Sight& sight) const {
  const double past = room_.edges.empty() ? -1.0 : room_.edges.back();
  if (std::min(sight.sole.left.p.x(), sight.sole.right.p.x()) > past) return std::nullopt;
  Command command;
  command.axes[0] = 1.0;
  if (std::abs(sight.heading) > kYawTolerance) command.axes[5] = turn_back(sight.heading);
  return command;
}

Vec2 RoomOperator::place_to_reach_from(const Sight& sight) const {
  const double comfortable = kFromTarget[approach_ % kFromTarget.size()] * robot_->profile().region.hand_distance;
  const double below = sight.shoulder.z() - room_.door.z();
  const double ahead = std::sqrt(std::max(0.0, comfortable * comfortable - below * below));
  const Vec2 shoulder = (sight.shoulder - sight.com).head<2>();
  return room_.door.head<2>() - Vec2(ahead, 0) - shoulder;
}

std::optional<Command> RoomOperator::cross(const Sight& sight) const {
  const Vec2 shift = place_to_reach_from(sight) - sight.com.head<2>();
  const double yaw = sight.heading;
  if ((shift.norm() < 0.02 && std::abs(yaw) < 2.0 * kYawTolerance) || deflection_.refusals > 8) return std::nullopt;
  Command command = deflect(Part::trunk, sight, Vec3(shift.x(), shift.y(), 0), robot_->profile().reach.trunk);
  command.axes.z() = 0.0;
  command.axes.head<2>() *= std::pow(0.7, deflection_.refusals);
  if (std::abs(yaw) > kYawTolerance) command.axes[5] = turn_back(yaw);
  return command;
}

std::optional<Command> RoomOperator::align(const Sight& sight) {
  const Vec2 middle = place_to_reach_from(sight);
  const double half_width = 0.5 * robot_->profile().stance.width;
  // The foot farther from its target first.
  const auto place = [&](Side side) -> Vec2 { return middle + Vec2(0, sign_of(side) * half_width); };
  const auto off = [&](Side side) { return (place(side) - sight.sole[side].p.head<2>()).norm(); };
  Side first = off(Side::left) > off(Side::right) ? Side::left : Side::right;
  if (deflection_.refusals % 2 == 1) first = other(first);
  if (deflection_.refusals > 8) return std::nullopt;
  for (const Side side : {first, other(first)}) {
    if (auto command = move_foot(sight, side, place(side), false, 0.008)) return command;
  }
  return std::nullopt;
}

std::optional<Command> RoomOperator::reach(const Sight& sight) const {
  Vec3 shift = room_.door - sight.hand;
  if (shift.norm() < parameters_.near) return std::nullopt;
  // What fails in one move may succeed axis by axis and in smaller moves.
  const int way = deflection_.refusals % 4;
  if (way > 0) {
    for (int axis = 0; axis < 3; ++axis) {
      if (axis != (way + 1) % 3) shift[axis] = 0.0;
    }
  }
  Command command = deflect(Part::left_hand, sight, shift, robot_->profile().reach.hand);
  command.axes *= std::pow(0.6, deflection_.refusals / 4);
  return command;
}

}  // namespace baton
