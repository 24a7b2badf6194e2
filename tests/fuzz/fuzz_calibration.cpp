// A calibration of mighty is read or refused; what was read is finite, and survives being written and read again.
#include "baton/model/error.hpp"
#include "baton/robot/calibration.hpp"
#include "tests/fuzz/fuzz.hpp"

int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using baton::Calibration;
  using baton::fuzz::file_of;
  using baton::fuzz::require;
  static const baton::RobotModel robot = baton::RobotModel::load("mighty");
  try {
    const Calibration read = Calibration::load(file_of(baton::fuzz::text_of(data, size)), robot);
    require(read.encoder_zero.size() == robot.nv() - 6 && read.encoder_zero.allFinite(), "each encoder has a zero");
    require(read.imu_mount.allFinite(), "the IMU is mounted somehow");
    const std::string text = text_of(read, read, read, robot);
    const Calibration again = Calibration::load(file_of(text), robot);
    require((again.encoder_zero - read.encoder_zero).cwiseAbs().maxCoeff() < 1e-4, "what was written is read");
  } catch (const baton::InputError&) {
  }
  return 0;
}
