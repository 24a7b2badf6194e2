// A motion file is read or refused, as one of mighty; what was read can be handed to the verifier.
#include "baton/model/error.hpp"
#include "baton/record/motion_file.hpp"
#include "tests/fuzz/fuzz.hpp"

int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using baton::fuzz::require;
  static const baton::RobotModel robot = baton::RobotModel::load("mighty");
  const std::filesystem::path& file = baton::fuzz::file_of(baton::fuzz::text_of(data, size));
  try {
    static_cast<void>(baton::read_motion_place(file));
  } catch (const baton::InputError&) {
  }
  try {
    const baton::Motion motion = baton::read_motion(file, robot);
    require(motion.ticks() >= 1 && !motion.phases.empty(), "a motion takes time");
    for (const baton::MotionSample& sample : motion.samples) {
      require(sample.q.size() == robot.nq() && sample.dq.size() == robot.nv(), "samples are of the robot");
      require(sample.contact.left || sample.contact.right, "a sole stands");
    }
  } catch (const baton::InputError&) {
  }
  return 0;
}
