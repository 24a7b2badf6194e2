// A recording is read to its end or refused at a line, as one of mighty.
#include "baton/model/error.hpp"
#include "baton/record/recording.hpp"
#include "tests/fuzz/fuzz.hpp"

int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using baton::fuzz::require;
  constexpr Eigen::Index kJoints = 20;
  try {
    baton::RecordingReader reader(baton::fuzz::file_of(baton::fuzz::text_of(data, size)));
    while (const auto tick = reader.next(kJoints)) {
      const baton::Measurement& m = tick->measurement;
      require(m.q.size() == kJoints && m.dq.size() == kJoints && tick->target.size() == kJoints,
              "every joint is there");
      require(m.torque.size() == 0 || m.torque.size() == kJoints, "torques of all joints or of none");
      require(tick->fallen || (m.q.allFinite() && m.imu.attitude.allFinite()), "of a robot that stands all is known");
    }
  } catch (const baton::InputError&) {
  }
  return 0;
}
