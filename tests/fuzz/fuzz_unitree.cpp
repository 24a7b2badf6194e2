// Whatever comes from a Unitree robot's network: a state is doubted, or all that is measured and commanded from it is
// finite; an answer of its motion switcher ends the factory gait only if it names none.
#include <cmath>
#include <cstring>

#include "bridge/unitree/factory_gait.hpp"
#include "bridge/unitree/motors.hpp"
#include "bridge/unitree/reading.hpp"
#include "tests/bridge/g1_like.hpp"
#include "tests/fuzz/fuzz.hpp"

namespace {

using baton::fuzz::require;
using namespace baton::unitree;

constexpr std::uint8_t kSeal = 1U;  ///< the checksum is put right, or nothing else would be looked at
constexpr std::uint8_t kPose = 2U;

/// Frames of a byte that says what to do, and a state.
void hear(std::string_view bytes) {
  static const Motors fresh(baton::test::g1_like());
  Motors motors = fresh;
  double t = 0.0;
  for (; bytes.size() > sizeof(LowState); bytes.remove_prefix(1 + sizeof(LowState))) {
    const auto what = static_cast<std::uint8_t>(bytes[0]);
    LowState state;
    std::memcpy(static_cast<void*>(&state), bytes.data() + 1, sizeof(state));
    if ((what & kSeal) != 0) state.crc = checksum(state);
    const bool doubted = doubt(state).has_value();
    t += 0.002;
    require(!doubted || motors.hear(state, t).has_value(), "a state that is doubted is ignored");
    if (!doubted) {
      static_cast<void>(motors.hear(state, t));
      const baton::Measurement measured = measurement_of(state, motors.motors(), t);
      require(measured.q.allFinite() && measured.dq.allFinite() && measured.torque.allFinite(), "joints are finite");
      require(measured.imu.attitude.isUnitary(1e-6), "the attitude is a rotation");
      require(measured.imu.rate.allFinite() && measured.imu.acceleration.allFinite(), "the IMU is finite");
    }
    if ((what & kPose) != 0) static_cast<void>(motors.pose(t));
    motors.pass(t);
    if (!motors.heard()) continue;
    const LowCommand command = motors.command(t + 1.0);
    require(command.crc == checksum(command), "a command has its checksum");
    for (const MotorCommand& motor : command.motors)
      require(std::isfinite(motor.q) && std::isfinite(motor.kp) && std::isfinite(motor.kd), "commands are finite");
  }
}

void answer(std::string_view bytes) {
  FactoryGait gait(1);
  for (double t = 0.0; gait.state() == FactoryGait::State::asking && t < 100.0; t += 0.5) {
    if (const std::optional<FactoryGait::Request> request = gait.next(t))
      gait.answer(request->id, 0, std::string(bytes), t);
  }
  require(gait.state() != FactoryGait::State::asking, "it comes to an end");
  require(gait.state() == FactoryGait::State::released || !gait.why().empty(), "a failure is told why");
}

}  // namespace

int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const std::string_view bytes = baton::fuzz::text_of(data, size);
  hear(bytes);
  if (size <= sizeof(LowState)) answer(bytes);
  return 0;
}
