// The library in a program of its own: the loop that drives every robot, here one in MuJoCo physics. An operator of
// ours asks the trunk to go forward for 8 s; the feet follow by themselves.
#include <baton/ik/stand.hpp>
#include <baton/robot/simulated_robot.hpp>
#include <baton/run/session.hpp>
#include <cstdio>

using namespace baton;

/// Decides on the command of each tick, by what is to be seen of the run.
class Forward : public Operator {
 public:
  Command decide(const View& view) override {
    Command stick;  // the trunk is guided
    stick.axes[0] = view.t < 8.0 ? 1.0 : 0.0;
    return stick;
  }
};

int main() {
  const RobotModel model = RobotModel::load(SHARE "/robots/mighty/profile.toml");
  const World world = World::load(SHARE "/worlds/flat.xml");
  const Posture start = stand(model, world.site("start"), model.profile().stance.com_height);
  SimulatedRobot robot(model, world, start, model.profile().tick.period);  // or yours: whatever is a baton::Robot
  Session session(model, world, robot, start);
  Forward forward;
  while (session.t() < 10.0 && !session.fallen())
    session.step(forward);

  const double way = robot.truth()->q[0] - start.q[0];
  std::printf("%ld segments, %.3f m forward\n", session.navigator().committed(), way);
  return way > 0.2 && !session.fallen() ? 0 : 1;
}
