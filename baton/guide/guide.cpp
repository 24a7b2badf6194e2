#include "baton/guide/guide.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "baton/model/contact.hpp"

namespace baton {
namespace {

constexpr double kSamePlace = 1e-3;                    ///< [m] differences below do not decide
constexpr double kSameYaw = 0.01;                      ///< [rad]
constexpr double kLeads = 0.7;                         ///< cosine of the angle between two ways that are one
constexpr double kLeastStep = 0.5;                     ///< shortest step to another place, share of the way asked for
constexpr double kLeastApproach = 0.1;                 ///< shortest step of the other foot, share of the way asked for
constexpr double kSearch = 0.01;                       ///< spacing of the places that a foot is tried at [m]
constexpr double kFineSearch = 0.002;                  ///< the same straight ahead, where edges are [m]
constexpr double kLowestLift = 0.25;                   ///< of a step's clearance: no foot hangs lower
constexpr double kSideways = 0.5;                      ///< of the way ahead: a push farther aside is not stepped into
constexpr double kStraight = 0.1;                      ///< of it: one that is not aside
constexpr std::array<double, 2> kCatches{1.0, 0.5};    ///< of the way that a step should go to catch the robot
constexpr std::array<double, 3> kHalt{1.0, 1.5, 0.5};  ///< ways that a COM is given to halt, in v/ω

/// Attitude with the yaw taken out: how the trunk leans.
Mat3 inclination(const Mat3& R) {
  return rotation_z(-yaw_of(R)) * R;
}

/// An attitude that leans by `most` at most: set upright in the plane it leans in.
Mat3 leaning(const Mat3& R, double most) {
  const double excess = tilt_of(R) - most;
  if (!(excess > 0.0)) return R;
  return rotation_exp(R.col(2).cross(Vec3::UnitZ()).normalized() * excess) * R;
}

/// How far outside its range a value lies; negative inside.
double excess(double value, const Range& range) {
  return std::max(range.lo - value, value - range.hi);
}
/// The range and a value.
Range with(const Range& range, double value) {
  return {std::min(range.lo, value), std::max(range.hi, value)};
}
double nearest_limit(double value, const Range& range) {
  return value < range.lo ? range.lo : range.hi;
}

}  // namespace

struct Guide::Placement {
  Pose sole;
  std::optional<Refusal> against;
};

Goal Guide::stay(const GuideContext& context, Part guided) const {
  Goal goal;
  goal.guided = guided;
  goal.sole = context.from.sole;
  goal.contact = context.from.contact;
  goal.unsure = context.unsure;
  goal.com = context.from.com;
  goal.trunk = leaning(context.from.trunk, robot_->profile().region.trunk_inclination);
  goal.arms = context.from.q.tail(robot_->nv() - 6);
  return goal;
}

void Guide::arms_home(Goal& goal) const {
  for (const Side side : kSides) {
    for (const int j : robot_->arm(side))
      goal.arms[j] = robot_->joints()[static_cast<std::size_t>(j)].home;
  }
}

Vec3 Guide::com_above(const GuideContext& context, const Goal& goal) const {
  const double height = context.from.com.z() - context.from.support_height();
  Vec3 sum = Vec3::Zero();
  int soles = 0;
  for (const Side side : kSides) {
    if (!goal.contact[side]) continue;
    sum += goal.sole[side].p;
    ++soles;
  }
  return sum / soles + Vec3(0, 0, height);
}

Guide::Placement Guide::place(const GuideContext& context, Side side, const Vec2& at, double yaw, double lift,
                              const Range& forward, std::optional<double> edge, bool from_here) const {
  const Profile& profile = robot_->profile();
  const Part part = foot(side);
  const Pose& stance = context.from.sole[other(side)];
  Placement placement;
  placement.sole = {Vec3(at.x(), at.y(), stance.p.z()), rotation_z(yaw)};
  // The region, in the stance sole's frame.
  const double stance_yaw = yaw_of(stance.R);
  const Vec3 relative = rotation_z(-stance_yaw) * (placement.sole.p - stance.p);
  const double lateral = sign_of(side) * relative.y();
  Range ahead = forward;
  Range outward = profile.region.foot_lateral;
  if (from_here) {
    const Vec3 now = rotation_z(-stance_yaw) * (context.from.sole[side].p - stance.p);
    ahead = with(ahead, now.x());
    outward = with(outward, sign_of(side) * now.y());
  }
  const double turned = wrap_angle(yaw - stance_yaw);
  constexpr double kSlack = 1e-9;
  if (excess(relative.x(), ahead) > kSlack) {
    placement.against = {Reason::foot_region, part, relative.x(), nearest_limit(relative.x(), ahead), "forward"};
  } else if (excess(lateral, outward) > kSlack) {
    placement.against = {Reason::foot_region, part, lateral, nearest_limit(lateral, outward), "sideways"};
  } else if (std::abs(turned) > profile.region.foot_yaw + kSlack) {
    placement.against = {Reason::foot_yaw, part, std::abs(turned), profile.region.foot_yaw, ""};
  }
  if (placement.against) return placement;
  const ConvexPolygon outline = sole_outline(*robot_, side, placement.sole);
  const double gap = separation(outline, sole_outline(*robot_, other(side), stance));
  if (gap < profile.region.sole_gap) {
    placement.against = {Reason::sole_gap, part, gap, profile.region.sole_gap, ""};
    return placement;
  }
  const ConvexPolygon in_world = sole_outline(*robot_, side, context.anchor * placement.sole);
  if (lift > 0.0) {
    const double ground = world_->highest_under(in_world) - context.anchor.p.z();
    if (!std::isfinite(ground)) placement.against = {Reason::ground, part, 0, 0, "nothing below"};
    placement.sole.p.z() = ground + lift;
    return placement;
  }
  const Foothold foothold =
      world_->foothold(in_world, profile.ground, edge.value_or(profile.margin.edge + context.unsure));
  if (!foothold.flat) {
    placement.against = {Reason::ground, part, foothold.deviation, profile.ground.flatness, ""};
    return placement;
  }
  placement.sole.p.z() = foothold.height - context.anchor.p.z();
  const Vec3 up = context.anchor.R.transpose() * foothold.normal;
  placement.sole.R = Eigen::Quaterniond::FromTwoVectors(Vec3::UnitZ(), up).toRotationMatrix() * placement.sole.R;
  return placement;
}

Guide::Placement Guide::nearest_place(const GuideContext& context, Side side, const Vec2& at, double yaw,
                                      const Range& forward, const std::function<bool(const Vec2&)>& serves) const {
  const Profile::Region& region = robot_->profile().region;
  const Pose& stance = context.from.sole[other(side)];
  const double stance_yaw = yaw_of(stance.R);
  const double turned = std::clamp(wrap_angle(yaw - stance_yaw), -region.foot_yaw, region.foot_yaw);
  const Mat3 from_stance = rotation_z(stance_yaw);
  const Vec3 wish = from_stance.transpose() * (Vec3(at.x(), at.y(), stance.p.z()) - stance.p);
  // The wish brought into the region first, then the line ahead and a grid over the region, the nearest first.
  std::vector<Vec2> places;
  const double lateral_wish = std::clamp(sign_of(side) * wish.y(), region.foot_lateral.lo, region.foot_lateral.hi);
  places.emplace_back(std::clamp(wish.x(), forward.lo, forward.hi), sign_of(side) * lateral_wish);
  for (double x = forward.lo; x <= forward.hi + 1e-9; x += kFineSearch)
    places.emplace_back(x, places.front().y());
  for (double x = forward.lo; x <= forward.hi + 1e-9; x += kSearch) {
    for (double y = region.foot_lateral.lo; y <= region.foot_lateral.hi + 1e-9; y += kSearch) {
      places.emplace_back(x, sign_of(side) * y);
    }
  }
  const Vec2 target = wish.head<2>();
  std::stable_sort(places.begin(), places.end(), [&](const Vec2& a, const Vec2& b) {
    return (a - target).squaredNorm() < (b - target).squaredNorm();
  });
  Placement first;
  for (const Vec2& candidate : places) {
    const Vec3 p = stance.p + from_stance * Vec3(candidate.x(), candidate.y(), 0);
    if (serves && !serves(p.head<2>())) continue;
    Placement placement = place(context, side, p.head<2>(), stance_yaw + turned, 0.0, forward);
    if (!placement.against) return placement;
    if (!first.against) first = placement;
  }
  return first;
}

GuideResult Guide::goals(const GuideContext& context, const Command& raw) const {
  const Command command = sanitised(raw);
  for (const Side side : kSides) {
    const bool guided = command.guide == foot(side) && command.recall == Recall::none;
    if (!context.from.contact[side] && !guided) return landings(context, side);
  }
  if (context.step && is_foot(command.guide) && side_of(command.guide) != context.step->side) return std::monostate{};
  if (command.recall == Recall::home) return go_home(context);
  if (is_foot(command.guide)) return guide_foot(context, command);
  return command.guide == Part::trunk ? guide_trunk(context, command) : guide_hand(context, command);
}

std::vector<int> Guide::axes_of(Part part) const {
  if (is_foot(part)) return {0, 1, 5};
  if (is_hand(part) && !robot_->hand_has_attitude(side_of(part))) return {0, 1, 2};
  return {0, 1, 2, 3, 4, 5};
}

Command Guide::shortened(const GuideContext& context, const Command& command, double share) const {
  Command shorter = command;
  shorter.axes *= share;
  if (!is_foot(command.guide)) return shorter;
  const Side side = side_of(command.guide);
  double& lift = shorter.lift[side];
  if (lift < kLeastLift) return shorter;  // a foot that is to stand is not left in the air
  double now = 0.0;
  if (!context.from.contact[side]) {
    const Pose in_world = context.anchor * context.from.sole[side];
    now =
        (in_world.p.z() - world_->highest_under(sole_outline(*robot_, side, in_world))) / robot_->profile().swing.lift;
  }
  lift = std::max(kLeastLift, now + share * (lift - now));
  return shorter;
}

Command Guide::within_region(const GuideContext& context, const Command& command) const {
  const Profile& profile = robot_->profile();
  const Side side = side_of(command.guide);
  const Pose& now = context.from.sole[side];
  const Pose& stance = context.from.sole[other(side)];
  const Mat3 heading = rotation_z(context.from.heading());
  const Mat3 from_stance = rotation_z(yaw_of(stance.R));
  Vec3 level = command.axes.head<3>();
  level.z() = 0.0;
  Vec3 there = from_stance.transpose() * (now.p + heading * level * profile.reach.foot - stance.p);
  const Range& ahead = profile.region.foot_x;
  const Range& outward = profile.region.foot_lateral;
  there.x() = std::clamp(there.x(), ahead.lo, ahead.hi);
  there.y() = sign_of(side) * std::clamp(sign_of(side) * there.y(), outward.lo, outward.hi);
  Command within = command;
  within.axes.head<2>() =
      (heading.transpose() * (stance.p + from_stance * there - now.p)).head<2>() / profile.reach.foot;
  return within;
}

GuideResult Guide::go_home(const GuideContext& context) const {
  const Profile& profile = robot_->profile();
  const Posture& from = context.from;
  // Everything but the feet as at the start.
  Goal upright = stay(context, Part::trunk);
  arms_home(upright);
  const auto stand_on = [&](Goal goal) {
    goal.trunk = rotation_z(mean_yaw(goal.sole));
    goal.com = 0.5 * (goal.sole.left.p + goal.sole.right.p) + Vec3(0, 0, profile.stance.com_height);
    return goal;
  };
  std::vector<Goal> goals;
  for (const Side side : {other(context.last_step), context.last_step}) {
    const Pose& stance = from.sole[other(side)];
    const Mat3 R = rotation_z(yaw_of(stance.R));
    const Vec3 at = stance.p + R * Vec3(0, sign_of(side) * profile.stance.width, 0);
    const bool there = (at - from.sole[side].p).head<2>().norm() < kSamePlace &&
                       std::abs(wrap_angle(yaw_of(R) - yaw_of(from.sole[side].R))) < kSameYaw;
    if (there) continue;
    for (const double yaw : {yaw_of(stance.R), yaw_of(from.sole[side].R)}) {
      const Placement placement = nearest_place(context, side, at.head<2>(), yaw, profile.region.foot_x);
      const double nearer = (at - from.sole[side].p).head<2>().norm() - (at - placement.sole.p).head<2>().norm();
      const double turned = std::abs(wrap_angle(yaw_of(stance.R) - yaw_of(from.sole[side].R))) -
                            std::abs(wrap_angle(yaw_of(stance.R) - yaw_of(placement.sole.R)));
      if (placement.against || (nearer < kSamePlace && turned < kSameYaw)) continue;
      Goal goal = upright;
      goal.kind = SegmentKind::step;
      goal.swing = side;
      goal.sole[side] = placement.sole;
      goals.push_back(stand_on(goal));
    }
  }
  const Goal now = stay(context, Part::trunk);
  const Goal home = stand_on(upright);
  const bool there = (home.com - from.com).norm() < kSamePlace &&
                     rotation_error(home.trunk, from.trunk).norm() < kSameYaw &&
                     (home.arms - now.arms).cwiseAbs().maxCoeff() < kSameYaw;
  if (!there) {
    goals.push_back(home);
    for (const double share : {0.5, 0.2}) {  // or nearer to it
      Goal nearer = home;
      nearer.com = from.com + share * (home.com - from.com);
      nearer.trunk = interpolate(from.trunk, home.trunk, share);
      nearer.arms = now.arms + share * (home.arms - now.arms);
      goals.push_back(std::move(nearer));
    }
  }
  if (goals.empty()) return std::monostate{};
  return goals;
}

Goal Guide::landing(const GuideContext& context, Side side, const Pose& sole) const {
  Goal goal = stay(context, foot(side));
  goal.kind = SegmentKind::lower;
  goal.swing = side;
  goal.contact[side] = true;
  goal.sole[side] = sole;
  goal.com = com_above(context, goal);
  goal.trunk = rotation_z(mean_yaw(goal.sole)) * inclination(goal.trunk);
  return goal;
}

GuideResult Guide::landings(const GuideContext& context, Side side) const {
  const Profile& profile = robot_->profile();
  const Range& region = profile.region.foot_x;
  const Pose& now = context.from.sole[side];
  const Pose& last = context.foothold[side];
  const Placement here = place(context, side, now.p.head<2>(), yaw_of(now.R), 0.0, region, {}, true);
  // Where it stood it can stand again, even if the other foot has come to rest a little outside the region since, or
  // it turned out to stand a little nearer to an edge.
  const Range stood{region.lo - profile.reach.foot, region.hi + profile.reach.foot};
  const Placement back = place(context, side, last.p.head<2>(), yaw_of(last.R), 0.0, stood, 0.0, true);
  const Range stride{-profile.region.stride, profile.region.stride};
  const Placement near = nearest_place(context, side, now.p.head<2>(), yaw_of(now.R), stride);
  std::vector<Goal> goals;
  for (const double down : {0.0, profile.reach.trunk}) {
    for (const Placement* placement : {&here, &back, &near}) {
      if (placement->against) continue;
      Goal goal = landing(context, side, placement->sole);
      goal.returns = placement == &back;
      const double height = context.from.com.z() - context.from.support_height();
      goal.com.z() -= std::min(down, std::max(0.0, height - profile.region.com_height.lo));
      goals.push_back(std::move(goal));
    }
  }
  if (goals.empty()) return *here.against;
  return goals;
}

GuideResult Guide::stops(const GuideContext& context) const {
  const Posture& from = context.from;
  if (context.step) {
    GuideResult landed = landings(context, context.step->side);
    const auto* goals = std::get_if<std::vector<Goal>>(&landed);
    if (goals == nullptr) return landed;
    return std::vector<Goal>{landing(context, context.step->side, context.step->to), goals->front()};
  }
  const ConvexPolygon support =
      support_polygon(*robot_, from.sole, from.contact, from.com, support_plane(from.sole, from.contact))
          .inset(robot_->profile().margin.stand_on);
  std::vector<Goal> goals;
  for (const double way : kHalt) {
    Goal goal = stay(context, Part::trunk);
    goal.com.head<2>() = support.nearest((from.com + way / robot_->omega() * from.dcom).head<2>());
    goals.push_back(std::move(goal));
  }
  return goals;
}

GuideResult Guide::catches(const GuideContext& context, const Vec2& by, bool aside) const {
  const Profile& profile = robot_->profile();
  const Posture& from = context.from;
  std::vector<Goal> goals;
  const auto add = [&](Side side, const Vec2& at, double yaw, SegmentKind kind) {
    const Placement placement = nearest_place(context, side, at, yaw, profile.region.foot_x);
    if (placement.against) return;
    Goal goal = landing(context, side, placement.sole);
    goal.kind = kind;
    goals.push_back(goal);
    add_nominal(context, goal, goals);
  };
  const auto land = [&](Side side, const Vec3& at, double yaw, SegmentKind kind) {
    for (const double share : kCatches)
      add(side, at.head<2>() + share * by, yaw, kind);
  };
  const auto beside = [&](Side side) {
    const Pose& stance = from.sole[other(side)];
    return Vec3(stance.p + stance.R * Vec3(0, sign_of(side) * profile.stance.width, 0));
  };
  if (context.step) {
    const Pose& to = context.step->to;
    land(context.step->side, to.p, yaw_of(to.R), SegmentKind::lower);
  } else if (from.contact.left && from.contact.right) {
    const Vec3 ahead = rotation_z(-from.heading()) * Vec3(by.x(), by.y(), 0);
    if (!aside && std::abs(ahead.y()) > kSideways * std::abs(ahead.x())) return std::monostate{};
    // It stands on the foot to whose side it is pushed; if it is to neither, the one that carries less leaves the
    // ground.
    const auto far = [&](Side side) { return (from.sole[side].p - from.com).head<2>().norm(); };
    const bool straight = std::abs(ahead.y()) < kStraight * std::abs(ahead.x());
    const Side first = straight ? (far(Side::left) > far(Side::right) ? Side::left : Side::right)
                                : (ahead.y() < 0.0 ? Side::left : Side::right);
    // A foot that is about to leave the ground may be the one that can, or have all the weight still.
    const Side best = from.lift_off ? from.lift_off->side : first;
    for (const Side side : {best, other(best)}) {
      if (!straight && !from.lift_off && side != best) continue;
      land(side, beside(side), yaw_of(from.sole[other(side)].R), SegmentKind::step);
    }
  } else {
    const Side up = from.contact.left ? Side::right : Side::left;
    const Pose& now = from.sole[up];
    land(up, now.p, yaw_of(now.R), SegmentKind::lower);
    land(up, beside(up), yaw_of(now.R), SegmentKind::lower);
  }
  if (goals.empty()) return std::monostate{};
  return goals;
}

GuideResult Guide::guide_foot(const GuideContext& context, const Command& command) const {
  const Side side = side_of(command.guide);
  const Posture& from = context.from;
  const auto [move, yaw, lift] = foot_wish(context, command);
  const bool deflected = command.axes[0] != 0.0 || command.axes[1] != 0.0 || command.axes[5] != 0.0;
  const Vec2 at = from.sole[side].p.head<2>() + move;
  const Placement placement = place(context, side, at, yaw, lift, robot_->profile().region.foot_x, {}, true);
  const bool up = !from.contact[side];
  const bool rises = up && std::abs(placement.sole.p.z() - from.sole[side].p.z()) > kSamePlace;
  if (!deflected && lift == 0.0 && !up) return std::monostate{};
  if (!deflected && lift > 0.0 && up && !rises) return std::monostate{};
  // The ways down are those that were verified before the foot was lifted: `Strategy::no_landing`.
  if (up && lift == 0.0 && !deflected) return landings(context, side);
  if (placement.against) return *placement.against;
  return foot_goals(context, side, placement.sole, lift == 0.0);
}

Guide::FootWish Guide::foot_wish(const GuideContext& context, const Command& command) const {
  const Profile& profile = robot_->profile();
  const Side side = side_of(command.guide);
  const double throttle = command.lift[side] < kLeastLift ? 0.0 : command.lift[side];
  // A foot that is only just off the ground would scrape over it as soon as it lags behind.
  const double lift =
      throttle == 0.0 ? 0.0 : std::max(throttle * profile.swing.lift, kLowestLift * profile.swing.clearance);
  const Vec3 move = rotation_z(context.from.heading()) * Vec3(command.axes[0], command.axes[1], 0);
  return {profile.reach.foot * move.head<2>(),
          yaw_of(context.from.sole[side].R) + profile.reach.rotation * command.axes[5], lift};
}

std::vector<Goal> Guide::foot_goals(const GuideContext& context, Side side, const Pose& sole, bool stands) const {
  const bool up = !context.from.contact[side];
  Goal goal = stay(context, foot(side));
  goal.swing = side;
  goal.contact[side] = stands;
  goal.sole[side] = sole;
  if (stands) {
    goal.kind = up ? SegmentKind::lower : SegmentKind::step;
  } else {
    goal.kind = up ? SegmentKind::air : SegmentKind::lift;
  }
  goal.com = com_above(context, goal);
  goal.trunk = rotation_z(mean_yaw(goal.sole)) * inclination(goal.trunk);
  std::vector<Goal> goals{goal};
  add_nominal(context, goal, goals);
  return goals;
}

GuideResult Guide::nearest_step(const GuideContext& context, const Command& raw) const {
  const Command command = sanitised(raw);
  const Side side = side_of(command.guide);
  const FootWish wished = foot_wish(context, command);
  const double length = wished.move.norm();
  if (wished.lift > 0.0 || length < kSamePlace) return std::monostate{};
  const Vec2 from = context.from.sole[side].p.head<2>();
  const Vec2 direction = wished.move / length;
  const auto leads = [&](const Vec2& at) {
    const double ahead = (at - from).dot(direction);
    return ahead >= kLeastStep * length && ahead >= kLeads * (at - from).norm();
  };
  const Placement placement =
      nearest_place(context, side, from + wished.move, wished.yaw, robot_->profile().region.foot_x, leads);
  if (placement.against || !leads(placement.sole.p.head<2>())) return std::monostate{};
  return foot_goals(context, side, placement.sole, true);
}

GuideResult Guide::other_foot_first(const GuideContext& context, const Command& raw) const {
  const Command command = sanitised(raw);
  const Side side = side_of(command.guide);
  const Posture& from = context.from;
  const FootWish wished = foot_wish(context, command);
  const Vec2& move = wished.move;
  const double length = move.norm();
  if (wished.lift > 0.0 || length < kSamePlace || context.step || !from.contact.left || !from.contact.right)
    return std::monostate{};
  const Side steps = other(side);
  const Vec3 beside = rotation_z(from.heading()) * Vec3(0, sign_of(steps) * robot_->profile().stance.width, 0);
  const Vec2 wish = (from.sole[side].p + beside).head<2>() + move;
  const Vec2 direction = move / length;
  const auto leads = [&](const Vec2& at) {
    return (at - from.sole[steps].p.head<2>()).dot(direction) >= kLeastApproach * length;
  };
  const Placement placement =
      nearest_place(context, steps, wish, yaw_of(from.sole[side].R), robot_->profile().region.foot_x, leads);
  if (placement.against || !leads(placement.sole.p.head<2>())) return std::monostate{};
  return foot_goals(context, steps, placement.sole, true);
}

void Guide::add_nominal(const GuideContext& context, Goal goal, std::vector<Goal>& goals) const {
  const double height = context.from.com.z() - context.from.support_height();
  const double asked = goal.com.z();
  const double rise = com_above(context, goal).z() - height + robot_->profile().stance.com_height - asked;
  if (std::abs(rise) > kSamePlace) {
    for (const double share : {0.5, 1.0}) {
      goal.com.z() = asked + share * rise;
      goals.push_back(goal);
    }
  }
  if (tilt_of(goal.trunk) < kSameYaw) return;
  goal.trunk = rotation_z(mean_yaw(goal.sole));
  goals.push_back(std::move(goal));
}

GuideResult Guide::guide_trunk(const GuideContext& context, const Command& command) const {
  if (command.axes.isZero(0.0)) return std::monostate{};
  const Profile& profile = robot_->profile();
  const Posture& from = context.from;
  const Mat3 heading = rotation_z(from.heading());
  Goal goal = stay(context, Part::trunk);
  goal.com += heading * command.axes.head<3>() * profile.reach.trunk;
  const double support = from.support_height();
  const double asked = goal.com.z() - support;
  goal.com.z() = support + std::clamp(asked, profile.region.com_height.lo, profile.region.com_height.hi);
  const Mat3 turned = rotation_exp(heading * command.axes.tail<3>() * profile.reach.rotation) * from.trunk;
  const double most = profile.region.trunk_inclination;
  // One that leans as far as it may leans no farther, but it goes on.
  goal.trunk = leaning(turned, most);
  const bool still = (goal.com - from.com).norm() < 1e-6;
  if (still && tilt_of(turned) > std::max(most, tilt_of(from.trunk) - 1e-9))
    return Refusal{Reason::trunk_inclination, Part::trunk, tilt_of(turned), most, ""};
  if (still && rotation_error(goal.trunk, from.trunk).norm() < 1e-6) {
    return Refusal{Reason::com_height, Part::trunk, asked, nearest_limit(asked, profile.region.com_height), ""};
  }
  goal.com.head<2>() = (context.back * goal.com).head<2>();
  goal.trunk = context.back.R * goal.trunk;
  arms_home(goal);
  GuideResult result = stand_under(context, goal);
  auto* goals = std::get_if<std::vector<Goal>>(&result);
  for (std::size_t i = 0; goals != nullptr && i < goals->size(); ++i) {
    // Where no foot gets there, only the turn is made up for.
    Goal& made = (*goals)[i];
    const bool there = (made.com - goal.com).head<2>().norm() < kSamePlace;
    made.back = there ? context.back : Pose{made.com - context.back.R * made.com, context.back.R};
  }
  return result;
}

GuideResult Guide::guide_hand(const GuideContext& context, const Command& command) const {
  const Side side = side_of(command.guide);
  const bool turns = robot_->hand_has_attitude(side) && !command.axes.tail<3>().isZero(0.0);
  if (command.axes.head<3>().isZero(0.0) && !turns) return std::monostate{};
  const Profile& profile = robot_->profile();
  const Posture& from = context.from;
  const Mat3 heading = rotation_z(from.heading());
  Goal goal = stay(context, command.guide);
  goal.kind = SegmentKind::reach;
  Pose hand = from.hand[side];
  hand.p += heading * command.axes.head<3>() * profile.reach.hand;
  if (turns) hand.R = rotation_exp(heading * command.axes.tail<3>() * profile.reach.rotation) * hand.R;
  goal.hand[side] = hand;

  // Only a vertical wish changes how high the COM is, and only that way.
  const double up = command.axes[2];
  const auto with_body_moved_by = [&](const Vec3& shift) {
    Goal moved = goal;
    moved.com += Vec3(shift.x(), shift.y(), up * shift.z() > 0.0 ? shift.z() : 0.0);
    const double support = from.support_height();
    moved.com.z() =
        support + std::clamp(moved.com.z() - support, profile.region.com_height.lo, profile.region.com_height.hi);
    return moved;
  };
  if (context.step) return std::vector<Goal>{stepping(context, goal, context.step->side, context.step->to)};
  std::vector<Goal> goals;
  std::optional<Refusal> against;
  const auto add = [&](const GuideResult& more) {
    const auto* list = std::get_if<std::vector<Goal>>(&more);
    if (list != nullptr) goals.insert(goals.end(), list->begin(), list->end());
    if (list == nullptr && !against) against = std::get<Refusal>(more);
  };
  const Vec3 move = hand.p - from.hand[side].p;
  const Vec3 stretch = hand.p - from.shoulder[side];
  const double length = stretch.norm();
  if (length > profile.region.hand_distance) {
    add(stand_under(context, with_body_moved_by((length - profile.region.hand_distance) / length * stretch)));
  } else {
    goals.push_back(goal);
  }
  // What the arm cannot do, the body may: it goes along with the hand.
  add(stand_under(context, with_body_moved_by(move)));
  if (goals.empty()) return *against;
  // Or it makes a step that leads the same way and takes the arm along as it is, to go on from there.
  const auto leads = std::find_if(goals.begin(), goals.end(), [&](const Goal& step) {
    const Vec3 way = step.com - from.com;
    const bool same = way.dot(move) > kLeads * way.norm() * move.norm() && way.norm() <= move.norm();
    return step.kind == SegmentKind::step && same;
  });
  if (leads != goals.end()) {
    goals.push_back(*leads);
    goals.back().hand[side].reset();
  }
  return goals;
}

GuideResult Guide::stand_under(const GuideContext& context, const Goal& goal) const {
  const Profile& profile = robot_->profile();
  const Posture& from = context.from;
  const double yaw = yaw_of(goal.trunk);
  const ConvexPolygon support =
      support_polygon(*robot_, from.sole, from.contact, goal.com, support_plane(from.sole, from.contact));
  const Vec2 target = goal.com.head<2>();
  const bool turn = goal.guided == Part::trunk && std::abs(wrap_angle(yaw - from.heading())) > profile.region.trunk_yaw;
  const bool stands = support.margin(target) >= profile.margin.stand_on;
  std::vector<Goal> goals;
  const bool stays = stands && !turn && !context.step;
  const bool walks = context.goes_on && goal.guided == Part::trunk;
  // A COM that does not move sideways, and need not turn, is not helped by a step.
  if (stays && (target - from.com.head<2>()).norm() < kSamePlace) return std::vector<Goal>{goal};
  if (stays && !walks) goals.push_back(goal);
  const double stride = profile.region.stride;
  std::optional<Refusal> against = add_steps(context, goal, turn, {-stride, stride}, goals);
  if (goals.empty()) against = add_steps(context, goal, turn, profile.region.foot_x, goals);
  if (context.step) goals.push_back(stepping(context, goal, context.step->side, context.step->to));
  if (stays && walks) goals.push_back(goal);
  // If no foot can follow, the trunk can still turn, as far as feet may be turned at all.
  const bool turns_alone = stands && turn && !context.step;
  if (turns_alone && std::abs(wrap_angle(yaw - from.heading())) <= profile.region.foot_yaw) goals.push_back(goal);
  const auto step = std::find_if(goals.begin(), goals.end(), [](const Goal& g) { return g.kind == SegmentKind::step; });
  if (step != goals.end()) add_nominal(context, *step, goals);
  if (!goals.empty()) return goals;
  return refusal_by(Reason::no_progress, *against);
}

Goal Guide::stepping(const GuideContext& context, const Goal& goal, Side side, const Pose& sole) const {
  Goal stepping = goal;
  stepping.kind = SegmentKind::step;
  stepping.swing = side;
  stepping.sole[side] = sole;
  // Above the middle of the feet, at the height above the supports that was asked for.
  const double height = goal.com.z() - context.from.support_height();
  stepping.com = 0.5 * (stepping.sole.left.p + stepping.sole.right.p) + Vec3(0, 0, height);
  return stepping;
}

std::optional<Refusal> Guide::add_steps(const GuideContext& context, const Goal& goal, bool turn, const Range& forward,
                                        std::vector<Goal>& goals) const {
  const Posture& from = context.from;
  const double yaw = yaw_of(goal.trunk);
  const Vec2 target = goal.com.head<2>();
  // The farther foot first; at a tie, the one that did not step last.
  const auto distance = [&](Side side) { return (from.sole[side].p.head<2>() - target).norm(); };
  Side first = other(context.last_step);
  if (std::abs(distance(Side::left) - distance(Side::right)) > kSamePlace) {
    first = distance(Side::left) > distance(Side::right) ? Side::left : Side::right;
  }
  const auto wish = [&](Side side) -> Vec2 { return 2.0 * target - from.sole[other(side)].p.head<2>(); };
  std::optional<Refusal> against;
  const std::vector<Side> feet = context.step ? std::vector{context.step->side} : std::vector{first, other(first)};
  for (const Side side : feet) {
    const Placement placement = place(context, side, wish(side), yaw, 0.0, forward);
    if (!placement.against) goals.push_back(stepping(context, goal, side, placement.sole));
    if (placement.against && !against) against = placement.against;
  }
  // Then, of both feet, the place whose middle is nearest to the goal, if that is progress.
  const Vec2 middle = 0.5 * (from.sole.left.p + from.sole.right.p).head<2>();
  std::vector<std::pair<double, std::pair<Side, Pose>>> nearest;
  for (const Side side : feet) {
    const Placement candidate = nearest_place(context, side, wish(side), yaw, forward);
    if (candidate.against) continue;
    const double left = 0.5 * (candidate.sole.p.head<2>() - wish(side)).norm();
    const double turned =
        std::abs(wrap_angle(yaw - yaw_of(from.sole[side].R))) - std::abs(wrap_angle(yaw - yaw_of(candidate.sole.R)));
    const bool nearer = left < (middle - target).norm() - kSamePlace;
    const bool turns = turn && turned > kSameYaw && left < (middle - target).norm() + robot_->profile().reach.trunk;
    if (left > kSamePlace && (nearer || turns)) nearest.push_back({left, {side, candidate.sole}});
  }
  if (nearest.size() == 2 && nearest[1].first < nearest[0].first - kSamePlace) std::swap(nearest[0], nearest[1]);
  for (const auto& [left, placed] : nearest)
    goals.push_back(stepping(context, goal, placed.first, placed.second));
  return against;
}

}  // namespace baton
