// What a connection adds to a tick: encoding and decoding, and the way there and back over the loopback device; then a
// robot that navigates, in real time.
#include <atomic>
#include <chrono>
#include <thread>

#include "baton/ik/stand.hpp"
#include "baton/link/remote_robot.hpp"
#include "baton/link/robot_server.hpp"
#include "baton/model/world.hpp"
#include "bench/bench.hpp"
#include "bench/noted_robot.hpp"

namespace baton::bench {

namespace {

/// As many as may be known.
ArmTargets most_targets(const RobotModel& robot) {
  ArmTargets targets = released_arms(robot);
  const auto columns = static_cast<Eigen::Index>(targets.joints.size());
  const auto rows = static_cast<Eigen::Index>(ArmTrajectory::kMostNumbers) / columns;
  targets.q = 0.1 * MatX::Random(rows, columns);
  for (Eigen::Index row = 0; row < rows; ++row)
    targets.t.push_back(static_cast<double>(row) / 30.0);
  return targets;
}

}  // namespace

Rows bench_link(const Options& options) {
  constexpr int kTicks = 5000;
  const RobotModel robot = RobotModel::load(options.robot);
  const World world = World::load("flat");
  const Eigen::Index joints = robot.nv() - 6;
  const Posture start = stand(robot, world.site("start"), robot.profile().stance.com_height);
  NotedRobot served(robot, start);
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
  Row cpu{"link: a tick at both ends", {}, "CPU time without the ideal robot's, mean of all"};
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
  cpu.values.front() += server_us / kTicks - served.own_us();
  Row arms{"link: the most targets for the arms, read", {}, "CPU time"};
  const std::string body = link::encode(most_targets(robot));
  for (int k = 0; k < 50; ++k)
    time(arms, [&] { (void)link::decode_arms(body); });
  Rows rows{coding, arms, turn, cpu};
  std::ranges::copy(link_in_real_time(options), std::back_inserter(rows));
  return rows;
}

}  // namespace baton::bench
