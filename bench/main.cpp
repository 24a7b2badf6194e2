#include <fmt/format.h>

#include "baton/ik/stand.hpp"
#include "bench/bench.hpp"

namespace baton::bench {

std::vector<Row> yardstick() {
  const RobotModel robot = RobotModel::load("mighty");
  const Posture home = stand(robot, Pose{}, robot.profile().stance.com_height);
  Kinematics kinematics(robot);
  Row row{"yardstick: kinematics of mighty", {}, "MuJoCo's mj_kinematics and mj_comPos, 20 calls"};
  for (int k = 0; k < 5000; ++k) {
    time(row, [&] {
      for (int i = 0; i < 20; ++i)
        kinematics.set(home.q);
    });
  }
  for (double& us : row.us)
    us /= 20.0;
  return {row};
}

}  // namespace baton::bench

int main() {
  using namespace baton::bench;
  fmt::print("{:<42} {:>10} {:>10} {:>8} {:>9}  {}\n", "thread CPU time", "median us", "p99 us", "calls", "/ yard", "");
  double yard = 0.0;
  for (const auto& group : {yardstick, bench_plan, bench_ik, bench_run}) {
    for (const Row& row : group()) {
      if (yard == 0.0) yard = row.quantile(0.5);
      fmt::print("{:<42} {:>10.2f} {:>10.2f} {:>8} {:>9.1f}  {}\n", row.name, row.quantile(0.5), row.quantile(0.99),
                 row.us.size(), row.quantile(0.5) / yard, row.remark);
    }
  }
  return 0;
}
