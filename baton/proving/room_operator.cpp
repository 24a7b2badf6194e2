#include "baton/proving/room_operator.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

namespace baton {
namespace {

constexpr double kCrouch = 0.245 / 0.26;    ///< COM height on the steps, fraction of nominal
constexpr double kBeforeEdge = 0.0045;      ///< toe to edge before a step down [m]
constexpr double kPastEdge = 0.0050;        ///< edge to heel after it [m]
constexpr double kFootTolerance = 0.0035;   ///< position tolerance of a foot [m]
constexpr double kFootDoubt = 0.0025;       ///< it looks at the feet until they are known so well [m]
constexpr double kLift = 0.4;               ///< throttle; little is needed on the way down
constexpr double kHeightTolerance = 0.003;  ///< [m]
constexpr double kLeastSteering = 0.5;      ///< deflection below which steering ends
constexpr double kYawTolerance = 0.05;      ///< of a foot before a step down [rad]
constexpr double kFacing = 0.12;            ///< the trunk's to begin with; what is left is corrected on the way [rad]
constexpr double kStraight = 0.10;          ///< the feet's on the way [rad]
constexpr double kStandingThere = 0.025;    ///< of the place to reach from [m]
/// Distance of the shoulder from the hand's target, in reaches; the next is tried if the arm cannot do it.
constexpr std::array<double, 3> kFromTarget{0.95, 0.85, 1.0};
constexpr double kOutward = 0.17;       ///< of the hand from the shoulder, in reaches
constexpr double kStepBack = 1.0;       ///< it goes back for so long when it is stuck at a step [s]
constexpr double kCoast = 0.2;          ///< the robot goes on for so long once the stick is let go of [s]
constexpr double kLeastDoubt = 0.0005;  ///< of what a tap does [m]
constexpr double kDoubt = 0.03;         ///< of what a tap does, share of what it asks for
constexpr double kHome = 4.0;           ///< for which `home` is held at the steps [s]
constexpr int kBacks = 3;               ///< every so many times that it is stuck there it tries that, else a step back
constexpr double kAnswered = 0.1;       ///< from a tap to when the page shows what comes of it [s]

}  // namespace

RoomOperator::RoomOperator(const RobotModel& robot, const World& world, std::uint64_t seed)
    : RoomOperator(robot, world, seed, Parameters{}) {}

RoomOperator::RoomOperator(const RobotModel& robot, const World& world, std::uint64_t seed, Parameters parameters)
    : robot_(&robot),
      parameters_(parameters),
      eyes_(robot, seed, parameters.eyes),
      means_(Mean(parameters.eyes)),
      room_{world.site("door_B").p, {}} {
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
    case Stage::reach:
      return "reaches for the door";
  }
  return "";
}

Command RoomOperator::decide(const View& view) {
  const Seen* seen = eyes_.look(view);
  if (seen == nullptr) return stick_;
  note(*seen);
  const bool steers = (stage_ == Stage::steps && !parameters_.foot_by_foot) || (stage_ == Stage::cross && !steered_);
  return steers ? steer(view.t) : tap(*seen, view.t);
}

void RoomOperator::note(const Seen& seen) {
  const Page& page = seen.page;
  if (page.activity != Activity::rest) {
    rests_since_ = page.t;
    deflection_.moved = true;
    deflection_.limited = deflection_.limited || page.limited;
    for (const Side side : kSides) {
      const bool guided = deflection_.pending && stick_.guide == foot(side);
      if (!page.contact[side] && !guided) means_.sole[side].forget();
    }
    if (!deflection_.pending) means_.forget_body();
  } else {
    if (deflection_.pending && page.t >= deflection_.since + kAnswered) conclude(page);
    means_.see(seen);
  }
  looked_ = page.t - rests_since_;
}

void RoomOperator::conclude(const Page& page) {
  deflection_.pending = false;
  const bool refused = page.refusals > deflection_.refused || !deflection_.moved;
  deflection_.refusals = refused ? deflection_.refusals + 1 : 0;
  if (!deflection_.moved) return;
  const Vec3& shift = deflection_.shift;
  const double doubt = deflection_.limited ? shift.norm() : kLeastDoubt + kDoubt * shift.norm();
  if (stick_.guide == Part::trunk && !deflection_.turned) {
    for (Mean* mean : {&means_.trunk, &means_.hand, &means_.shoulder})
      mean->moved(shift, doubt);
  } else {  // the body may have gone along
    const Mean hand = means_.hand;
    means_.forget_body();
    if (is_foot(stick_.guide)) means_.sole[side_of(stick_.guide)].moved(shift, doubt);
    if (stick_.guide == Part::left_hand) (means_.hand = hand).moved(shift, doubt);
  }
}

void RoomOperator::Means::see(const Seen& seen) {
  const double t = seen.page.t;
  for (const Side side : kSides)
    sole[side].see(t, seen.sight.sole[side]);
  trunk.see(t, seen.sight.trunk);
  hand.see(t, seen.sight.hand);
  shoulder.see(t, seen.sight.shoulder);
}

void RoomOperator::Means::forget_body() {
  trunk.forget();
  hand.forget();
  shoulder.forget();
}

Sight RoomOperator::steady() const {
  const Means& m = means_;
  return {{m.sole.left.place(), m.sole.right.place()}, m.trunk.place(), m.hand.place(), m.shoulder.place()};
}

Command RoomOperator::steer(double t) {
  const bool back = stage_ == Stage::steps && stick_.axes[0] < 0.0;
  const double holds = stick_.recall == Recall::home ? kHome : back ? kStepBack : parameters_.glance;
  if (t - deflection_.since < holds) return stick_;
  stick_.recall = Recall::none;
  deflection_.since = t;
  deflection_.pending = false;
  const bool idle = !stick_.axes.isZero(0.0) && looked_ > parameters_.glance;
  deflection_.refusals = idle ? deflection_.refusals + 1 : 0;
  const Sight sight = eyes_.foresee(parameters_.eyes.reaction + kCoast);
  std::optional<Command> command = next(sight);
  if (!command && stage_ == Stage::steps) {  // down the steps; go on without a rest
    stage_ = Stage::cross;
    command = next(sight);
  }
  if (command && command->axes.cwiseAbs().maxCoeff() > kLeastSteering && deflection_.refusals < 3) {
    stick_ = *command;
    return stick_;
  }
  stick_.axes.setZero();
  if (stage_ == Stage::steps) {  // stuck: other footholds may do, or other feet
    if (++backs_ % kBacks == 0) {
      stick_.recall = Recall::home;
    } else {
      stick_.axes[0] = -1.0;
    }
    deflection_.refusals = 0;
  } else {
    steered_ = true;  // close: go on by taps
  }
  return stick_;
}

Command RoomOperator::tap(const Seen& seen, double t) {
  const Page& page = seen.page;
  if (deflection_.pending && t - deflection_.since >= parameters_.tap) {
    stick_.axes.setZero();  // a lifted foot stays up
    stick_.recall = Recall::none;
  }
  if (page.t < deflection_.since + kAnswered || page.activity != Activity::rest) return stick_;
  if (stage_ == Stage::reach && (deflection_.refusals > 0 || deflection_.limited)) {  // retry from elsewhere
    ++approach_;
    stage_ = Stage::cross;
    deflection_.refusals = 0;
    goes_home_ = approach_ % kFromTarget.size() == 0;
  }
  const bool places_feet = stage_ == Stage::steps && !feet_.lifted.left && !feet_.lifted.right;
  if (places_feet && std::max(means_.sole.left.doubt(), means_.sole.right.doubt()) > kFootDoubt) return stick_;
  std::optional<Command> command = next(steady());
  if (std::exchange(goes_home_, false)) command = Command{.recall = Recall::home};
  while (!command && stage_ != Stage::reach) {
    stage_ = static_cast<Stage>(static_cast<int>(stage_) + 1);
    deflection_.refusals = 0;
    command = next(steady());
  }
  if (!command) return stick_;
  stick_ = *command;
  deflection_.pending = true;
  deflection_.since = t;
  deflection_.refused = page.refusals;
  deflection_.shift = asked(stick_, steady());
  deflection_.turned = stick_.axes[5] != 0.0 || stick_.recall == Recall::home;
  deflection_.moved = deflection_.limited = false;
  return stick_;
}

std::optional<Command> RoomOperator::next(const Sight& sight) {
  const double nominal = robot_->profile().stance.com_height;
  switch (stage_) {
    case Stage::face:
      return face(sight);
    case Stage::crouch:
      return parameters_.foot_by_foot ? change_height(sight, kCrouch * nominal) : std::nullopt;
    case Stage::steps:
      return parameters_.foot_by_foot ? go_down(sight) : walk_down(sight);
    case Stage::rise:
      return parameters_.foot_by_foot ? change_height(sight, nominal) : std::nullopt;
    case Stage::cross:
      return cross(sight);
    case Stage::reach:
      return reach(sight);
  }
  return std::nullopt;
}

Command RoomOperator::deflect(Part part, const Sight& sight, const Vec3& shift) const {
  Command command;
  command.guide = part;
  Vec3 axes = (rotation_z(-sight.heading()) * shift).cwiseQuotient(reach_of(*robot_, part).head<3>());
  axes /= std::max(1.0, axes.cwiseAbs().maxCoeff());
  command.axes.head<3>() = axes;
  return command;
}

Vec3 RoomOperator::asked(const Command& command, const Sight& sight) const {
  return rotation_z(sight.heading()) * requested_move(*robot_, command).head<3>();
}

double RoomOperator::turn_back(double yaw) const {
  return std::clamp(-yaw / robot_->profile().reach.rotation, -1.0, 1.0);
}

std::optional<Command> RoomOperator::face(const Sight& sight) const {
  // The trunk turns first; the feet follow when necessary.
  const bool trunk = std::abs(sight.trunk[3]) < kFacing;
  if ((trunk && std::abs(sight.heading()) < kFacing) || deflection_.refusals > 6) return std::nullopt;
  Command command;
  command.axes[5] = turn_back(trunk ? sight.heading() : sight.trunk[3]);
  return command;
}

std::optional<Command> RoomOperator::change_height(const Sight& sight, double height) const {
  const double error = height - (sight.trunk.z() - 0.5 * (sight.sole.left.z() + sight.sole.right.z()));
  if (std::abs(error) < kHeightTolerance || deflection_.refusals > 3) return std::nullopt;
  return deflect(Part::trunk, sight, {0, 0, error});
}

std::optional<Command> RoomOperator::move_foot(const Sight& sight, Side side, const Vec2& to, bool through_the_air) {
  Vec2 shift = to - sight.sole[side].head<2>();
  const double yaw = sight.sole[side][3];
  const bool there = shift.norm() < kFootTolerance && std::abs(yaw) < kYawTolerance;
  if (there && !feet_.lifted[side]) return std::nullopt;
  // After refusals, move away from the other foot.
  if (deflection_.refusals > 1 && !through_the_air)
    shift.y() += 0.005 * std::min(deflection_.refusals, 4) * sign_of(side);
  Command command = deflect(foot(side), sight, Vec3(shift.x(), shift.y(), 0));
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
    if (feet_.lifted[side]) return move_foot(sight, side, feet_.landing[side], true);
  }
  // The next edge for the left foot, which goes first, or for the right foot after it.
  for (std::size_t i = 0; i < room_.edges.size(); ++i) {
    const double before = room_.edges[i] - sole_length_ - kBeforeEdge;
    const double past = room_.edges[i] + sole_length_ + kPastEdge;
    const bool left_past = sight.sole.left.x() > room_.edges[i];
    const bool right_past = sight.sole.right.x() > room_.edges[i];
    if (left_past && right_past) continue;
    if (!left_past) {
      // Bring both feet up to the edge, the rear one first.
      Side behind = sight.sole.left.x() < sight.sole.right.x() ? Side::left : Side::right;
      if (deflection_.refusals % 2 == 1) behind = other(behind);
      for (const Side side : {behind, other(behind)}) {
        const double y = std::abs(sight.sole.left.y() - sight.sole.right.y() - 2.0 * half_width) < 0.01
                             ? sight.sole[side].y()
                             : lane(side);
        const double x =
            side == Side::left ? std::min(before, sight.sole.right.x() + robot_->profile().reach.foot) : before;
        if (side == Side::left && sight.sole.left.x() > before - 0.015 && std::abs(sight.sole.left[3]) < kYawTolerance)
          continue;
        if (auto command = move_foot(sight, side, {x, y}, false)) return command;
      }
    }
    const Side side = left_past ? Side::right : Side::left;
    double x = past;
    if (side == Side::right) {
      // Beside the left foot, or up to the next edge.
      x = sight.sole.left.x();
      if (i + 1 < room_.edges.size()) x = room_.edges[i + 1] - sole_length_ - kBeforeEdge;
    }
    const double y = sight.sole[other(side)].y() + sign_of(side) * 2.0 * half_width;
    feet_.landing[side] = {x, y};
    if (auto command = move_foot(sight, side, feet_.landing[side], true)) return command;
  }
  return std::nullopt;
}

std::optional<Command> RoomOperator::walk_down(const Sight& sight) const {
  const double past = room_.edges.empty() ? -1.0 : room_.edges.back();
  if (std::min(sight.sole.left.x(), sight.sole.right.x()) > past) return std::nullopt;
  Command command;
  command.axes[0] = 1.0;
  if (std::abs(sight.heading()) > kStraight && deflection_.refusals == 0) command.axes[5] = turn_back(sight.heading());
  return command;
}

Vec2 RoomOperator::place_to_reach_from(const Sight& sight) const {
  const double comfortable = kFromTarget.at(approach_ % kFromTarget.size()) * robot_->profile().region.hand_distance;
  const double below = sight.shoulder.z() - room_.door.z();
  const double ahead = std::sqrt(std::max(0.0, comfortable * comfortable - below * below));
  const Vec2 shoulder = (sight.shoulder - sight.trunk).head<2>();
  return room_.door.head<2>() - Vec2(ahead, kOutward * robot_->profile().region.hand_distance) - shoulder;
}

std::optional<Command> RoomOperator::cross(const Sight& sight) const {
  const Vec2 shift = place_to_reach_from(sight) - sight.trunk.head<2>();
  const double yaw = sight.heading();
  if ((shift.norm() < kStandingThere && std::abs(yaw) < 1.5 * kStraight) || deflection_.refusals > 8)
    return std::nullopt;
  Command command = deflect(Part::trunk, sight, Vec3(shift.x(), shift.y(), 0));
  command.axes.z() = 0.0;
  command.axes.head<2>() *= std::pow(0.7, deflection_.refusals);
  if (std::abs(yaw) > kStraight) command.axes[5] = turn_back(yaw);
  return command;
}

std::optional<Command> RoomOperator::reach(const Sight& sight) const {
  const Vec3 shift = room_.door - sight.hand.head<3>();
  const bool near = shift.norm() < parameters_.near;
  if (near && (looked_ < parameters_.look || shift.norm() < parameters_.fine)) return std::nullopt;
  return deflect(Part::left_hand, sight, shift);
}

}  // namespace baton
