#include "baton/guide/command.hpp"

#include <algorithm>
#include <cmath>

namespace baton {
namespace {

constexpr double kJitter = 0.05;  ///< change of an axis or lift that counts as jitter

}  // namespace

Command sanitised(const Command& command) {
  Command result = command;
  for (double& axis : result.axes)
    axis = std::isnan(axis) ? 0.0 : std::clamp(axis, -1.0, 1.0);
  for (const Side side : kSides) {
    const double lift = command.lift[side];
    result.lift[side] = std::isnan(lift) ? 0.0 : std::clamp(lift, 0.0, 1.0);
  }
  return result;
}

Vec6 reach_of(const RobotModel& robot, Part part) {
  const Profile::Reach& reach = robot.profile().reach;
  const double length = is_foot(part) ? reach.foot : is_hand(part) ? reach.hand : reach.trunk;
  Vec6 full;
  full << Vec3::Constant(length), Vec3::Constant(reach.rotation);
  return full;
}

Vec6 requested_move(const RobotModel& robot, const Command& command) {
  Vec6 move = command.axes.cwiseProduct(reach_of(robot, command.guide));
  if (is_foot(command.guide)) move.segment<3>(2).setZero();
  if (is_hand(command.guide) && !robot.hand_has_attitude(side_of(command.guide))) move.tail<3>().setZero();
  return move;
}

bool lever_moved(const Command& a, const Command& b) {
  if (!is_foot(a.guide)) return false;
  const Side side = side_of(a.guide);
  return a.guide != b.guide || std::abs(a.lift[side] - b.lift[side]) > kJitter;
}

bool differs(const Command& a, const Command& b) {
  return a.guide != b.guide || (a.axes - b.axes).cwiseAbs().maxCoeff() > kJitter || lever_moved(a, b);
}

}  // namespace baton
