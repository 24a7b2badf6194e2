// A recording is read to its end or refused at a place in it, as one of a robot with two joints.
#include "baton/model/error.hpp"
#include "baton/record/recording.hpp"
#include "tests/fuzz/fuzz.hpp"

int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using baton::fuzz::require;
  const std::vector<std::string> joints{"a", "b"};
  try {
    baton::RecordingReader reader(baton::fuzz::file_of(baton::fuzz::text_of(data, size)));
    while (const auto tick = reader.next(joints)) {
      const baton::Measurement& m = tick->measurement;
      require(m.q.size() == 2 && m.dq.size() == 2 && tick->target.size() == 2, "every joint is there");
      require(m.torque.size() == 0 || m.torque.size() == 2, "torques of all joints or of none");
      require(static_cast<int>(tick->command.recall) <= 3 && tick->command.axes.allFinite(), "the command is one");
      require(reader.head().state != "perfect" || m.root.has_value(), "the root is there if it is needed");
    }
  } catch (const baton::InputError&) {
  }
  return 0;
}
