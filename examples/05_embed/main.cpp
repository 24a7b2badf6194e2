// The library in a program of its own: a navigator, a planner, and a body in MuJoCo physics, 5 ms at a time.
// The trunk is asked to go forward for 8 s; the feet follow by themselves.
#include <algorithm>
#include <baton/ik/stand.hpp>
#include <baton/navigate/navigator.hpp>
#include <baton/plan/strategy.hpp>
#include <cstdio>

using namespace baton;

int main() {
  const RobotModel robot = RobotModel::load(SHARE "/robots/mighty/profile.toml");
  const World world = World::load(SHARE "/worlds/flat.xml");
  const Posture start = stand(robot, world.site("start"), robot.profile().stance.com_height);
  Navigator navigator(robot, world, start, Gait::flow, StateSource::perfect);
  Strategy planning(robot, world);

  const double h = 0.001;  // of physics [s]
  const double period = robot.profile().tick.period;
  const ModelPtr model = compile_text(world.compose(robot, h), "flat world with mighty");
  const DataPtr body(mj_makeData(model.get()));
  std::copy(start.q.begin(), start.q.end(), body->qpos);
  mj_forward(model.get(), body.get());

  while (body->time < 10.0) {
    Command stick;  // the trunk is guided
    stick.axes[0] = body->time < 8.0 ? 1.0 : 0.0;

    Measurement sensed;  // the root's pose comes from the simulator: a robot would have an IMU instead
    sensed.q = Eigen::Map<const VecX>(body->qpos + 7, robot.nq() - 7);
    sensed.dq = Eigen::Map<const VecX>(body->qvel + 6, robot.nv() - 6);
    const mjtNum* q = body->qpos;
    sensed.root = RootMeasurement{{{q[0], q[1], q[2]}, Eigen::Quaterniond(q[3], q[4], q[5], q[6]).toRotationMatrix()},
                                  Eigen::Map<const Vec3>(body->qvel),
                                  Eigen::Map<const Vec3>(body->qvel + 3)};

    const JointTarget& target = navigator.tick(sensed, stick);
    for (double left = period; left > 0.5 * h; left -= h) {  // servos; targets are for the tick's end
      for (int a = 0; a < model->nu; ++a) {
        const int j = model->actuator_trnid[2 * a] - 1;  // joint 0 is the free one
        const Joint& joint = robot.joints()[j];
        const double torque =
            target.tau[j] + joint.gains.kp * (target.q[j] + target.shift[j] - left * target.dq[j] - body->qpos[7 + j]) +
            joint.gains.kd * (target.dq[j] - body->qvel[6 + j]);
        body->ctrl[a] = std::clamp(torque, -joint.motor.stall, joint.motor.stall);
      }
      mj_step(model.get(), body.get());
    }
    // After the targets are out: planning, here in the same thread; a program may use another.
    navigator.poll();
    if (const auto request = navigator.request()) navigator.answer(planning.plan(*request));
  }
  const double forward = body->qpos[0] - start.q[0];
  std::printf("%ld segments, %.3f m forward\n", navigator.committed(), forward);
  return forward > 0.2 && body->qpos[2] > 0.8 * start.q[2] ? 0 : 1;  // went, and did not fall
}
