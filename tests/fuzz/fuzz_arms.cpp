// A script of targets for mighty's arms is read or refused; what was read is of its arms, and in order.
#include <algorithm>

#include "baton/input/arm_script.hpp"
#include "baton/model/error.hpp"
#include "tests/fuzz/fuzz.hpp"

int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using baton::fuzz::require;
  static const baton::RobotModel robot = baton::RobotModel::load("mighty");
  try {
    baton::ArmScript script = baton::ArmScript::parse(baton::fuzz::text_of(data, size), "fuzzed", robot);
    int read = 0;
    for (; const baton::ArmTargets* targets = script.next(1e300); ++read) {
      const auto times = static_cast<Eigen::Index>(targets->t.size());
      const auto joints = static_cast<Eigen::Index>(targets->joints.size());
      require(joints > 0 && targets->q.rows() == times && (times == 0 || targets->q.cols() == joints), "a row each");
      require(targets->q.allFinite(), "angles are finite");
      require(std::ranges::is_sorted(targets->t), "times are in order");
    }
    require(read > 0, "a script has targets");
  } catch (const baton::InputError&) {
  }
  return 0;
}
