// What a connection adds to a tick: encoding and decoding, and the way there and back over the loopback device.
#include <atomic>
#include <chrono>
#include <thread>

#include "baton/ik/stand.hpp"
#include "baton/link/remote_robot.hpp"
#include "baton/link/robot_server.hpp"
#include "baton/model/world.hpp"
#include "baton/robot/ideal_robot.hpp"
#include "bench/bench.hpp"

namespace baton::bench {

Rows bench_link(const Options& options) {
  constexpr int kTicks = 5000;
  const RobotModel robot = RobotModel::load(options.robot);
  const World world = World::load("flat");
  const Eigen::Index joints = robot.nv() - 6;
  const Posture start = stand(robot, world.site("start"), robot.profile().stance.com_height);
  IdealRobot served(robot, start, robot.profile().tick.period);
  link::RobotServer server(
      robot, served,
      {.listen = {"127.0.0.1", 0}, .token = "", .on = "ideal", .world = "flat", .log = [](const auto&) {}});
  const Address address = server.address();
  std::atomic<bool> stop{false};
  std::atomic<double> server_us{0.0};
  std::thread thread([&] {
    const double before = cpu_us();
    while (!stop)
      server.serve(Socket::Time(10));
    server_us = cpu_us() - before;
  });

  Row coding{"link: target and measurement, coded twice", {}, "CPU time of both ends together"};
  Row turn{"link: there and back over loopback", {}, "wall time, an ideal robot at the other end"};
  Row cpu{"link: a tick at both ends", {}, "CPU time, the ideal robot's included, mean of all"};
  {
    link::RemoteRobot remote(robot, "flat", {address, ""});
    const Measurement measured = remote.read();
    const VecX zero = VecX::Zero(joints);
    const JointTarget target{measured.q, zero, zero, zero, {true, true}, {}};
    for (int k = 0; k < kTicks; ++k) {
      time(coding, [&] {
        (void)link::decode_target(link::encode(link::Target{1, target.q, target.dq, target.tau}), joints);
        (void)link::decode_reading(link::encode(link::Reading{1, false, 1.0, measured}), joints);
      });
    }
    const double before = cpu_us();
    for (int k = 0; k < kTicks; ++k) {
      const auto began = std::chrono::steady_clock::now();
      remote.write(target);
      turn.values.push_back(
          std::chrono::duration<double, std::micro>(std::chrono::steady_clock::now() - began).count());
    }
    cpu.values.push_back((cpu_us() - before) / kTicks);
  }
  stop = true;
  thread.join();
  cpu.values.front() += server_us / kTicks;
  return {coding, turn, cpu};
}

}  // namespace baton::bench
