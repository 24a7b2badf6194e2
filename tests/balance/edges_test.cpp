/// Edges that are not where the map has them.
#include <gtest/gtest.h>

#include <fstream>
#include <iterator>
#include <random>

#include "baton/ik/stand.hpp"
#include "baton/navigate/navigator.hpp"
#include "baton/plan/strategy.hpp"
#include "baton/robot/simulated_robot.hpp"
#include "tests/support/robots.hpp"
#include "tests/support/temp.hpp"

namespace baton {
namespace {

/// The room, its stage and tread `by` longer [m].
World longer(double by) {
  std::ifstream file(share_dir() / "worlds" / "room.xml");
  std::string text(std::istreambuf_iterator<char>(file), {});
  const auto put = [&](const std::string& from, const std::string& to) {
    const auto at = text.find(from);
    EXPECT_NE(at, std::string::npos) << from;
    text.replace(at, from.size(), to);
  };
  put("pos=\"-0.14 0 0.015\"", "pos=\"" + std::to_string(-0.14 + by) + " 0 0.015\"");
  put("pos=\"0.18 0 0.0075\"", "pos=\"" + std::to_string(0.18 + by) + " 0 0.0075\"");
  const std::string name = test::temp_folder() + "/baton_longer_" + std::to_string(by) + ".xml";
  std::ofstream(name) << text;
  return World(name);
}

/// Up and down the steps, now and then by a foot; by how much a sole tilted, at most [rad].
double up_and_down(const World& world, double seconds, std::mt19937_64& random) {
  const auto within = [&](double most) { return std::uniform_real_distribution<double>(-most, most)(random); };
  const RobotModel& robot = test::robot("mighty");
  const World map = World::load("room");
  const Posture start = stand(robot, map.site("start"), robot.profile().stance.com_height);
  SimulatedRobot body(robot, world, start, robot.profile().tick.period);
  Navigator navigator(robot, map, start);
  Strategy strategy(robot, map);
  Kinematics truth(robot);
  Command command;
  double ahead = 1.0;
  double tilt = 0.0;
  const int second = static_cast<int>(std::lround(1.0 / robot.profile().tick.period));
  for (int tick = 0; tick < seconds * second; ++tick) {
    const VecX& q = body.truth()->q;
    if (tick % second == 0) {
      if (q[0] > 0.3) ahead = -1.0;
      if (q[0] < 0.0) ahead = 1.0;
      command.guide = within(1.0) < 0.4 ? Part::trunk : within(1.0) > 0.0 ? Part::left_foot : Part::right_foot;
      command.axes << ahead, std::abs(q[1]) > 0.15 ? -std::copysign(0.5, q[1]) : within(0.3), 0, 0, 0, within(0.3);
    }
    body.write(navigator.tick(body.read(), command));
    navigator.poll();
    if (const auto request = navigator.request()) navigator.answer(strategy.plan(*request));
    if (body.truth()->fallen) {
      ADD_FAILURE() << body.truth()->fall << " at " << body.truth()->t;
      break;
    }
    truth.set(q);
    for (const Side side : kSides) {
      if (body.truth()->touch[side]) tilt = std::max(tilt, tilt_of(truth.sole(side).R));
    }
  }
  return tilt;
}

TEST(EdgesElsewhere, ItStumblesAndStaysOnItsFeet) {
  std::mt19937_64 random(31);
  int stumbled = 0;
  for (int trial = 0; trial < 6; ++trial) {
    const World world = longer(std::uniform_real_distribution<double>(0.002, 0.008)(random));
    stumbled += up_and_down(world, 30.0, random) > 0.1 ? 1 : 0;
  }
  EXPECT_GE(stumbled, 2);
}

}  // namespace
}  // namespace baton
