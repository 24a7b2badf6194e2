#include "baton/robot/calibration.hpp"

#include <fmt/format.h>

#include <numbers>

#include "baton/model/toml_reader.hpp"

namespace baton {
namespace {

constexpr double kDegree = std::numbers::pi / 180.0;

// Largest plausible errors: beyond them something is broken, or the file is that of another robot.
constexpr double kMostAngle = 5.0;  ///< [deg]
constexpr double kLeastGain = 0.5;
constexpr double kMostGain = 2.0;
constexpr double kMostZero = 0.5;  ///< [weight]

constexpr std::array<const char*, 2> kTilts{"roll", "pitch"};
constexpr std::array<const char*, 3> kAxes{"x", "y", "z"};

Mat3 mount(const Calibration& errors) {
  return rotation_exp({errors.imu_mount.x(), errors.imu_mount.y(), 0.0});
}

std::string line(const std::string& key, double value, double sigma, double prior) {
  const std::string number = fmt::format("{} = {:.9g}", key, value);
  return fmt::format("{:<44}# ± {:.2g}{}\n", number, sigma,
                     poorly_observable(sigma, prior) ? ", poorly observable" : "");
}

}  // namespace

Calibration Calibration::none(int joints) {
  Calibration none;
  none.encoder_zero = VecX::Zero(joints);
  return none;
}

Calibration Calibration::load(const std::filesystem::path& file, const RobotModel& robot) {
  const toml::table table = parse_toml(file, "calibration");
  const TomlReader read(table, "calibration", file);
  const std::string& name = robot.profile().name;
  if (read.text("robot") != name) read.complain("robot", fmt::format("\"{}\", the robot that is driven", name));
  Calibration c = none(robot.nv() - 6);
  for (std::size_t j = 0; j < robot.joints().size(); ++j) {
    c.encoder_zero[static_cast<Eigen::Index>(j)] =
        kDegree * read.number("encoder_zero_deg." + robot.joints()[j].name, -kMostAngle, kMostAngle);
  }
  for (std::size_t i = 0; i < kTilts.size(); ++i) {
    c.imu_mount[static_cast<Eigen::Index>(i)] =
        kDegree * read.number(fmt::format("imu_mount_deg.{}", kTilts[i]), -kMostAngle, kMostAngle);
  }
  const double most = kMostZero * robot.mass() * kGravity;
  for (const Side side : kSides) {
    const std::string sole = fmt::format("{}_force.", to_string(side));
    c.force_gain[side] = read.number(sole + "gain", kLeastGain, kMostGain);
    for (std::size_t i = 0; i < kAxes.size(); ++i)
      c.force_zero[side][static_cast<Eigen::Index>(i)] =
          read.number(fmt::format("{}zero_{}", sole, kAxes[i]), -most, most);
  }
  read.complain_of_unknown_keys();
  return c;
}

Measurement with_errors(Measurement measurement, const Calibration& errors) {
  const Mat3 by = mount(errors);
  measurement.q += errors.encoder_zero;
  Measurement::Imu& imu = measurement.imu;
  imu = {imu.attitude * by, by.transpose() * imu.rate, by.transpose() * imu.acceleration};
  for (const Side side : kSides) {
    Wrench& sole = measurement.sole[side];
    const double gain = errors.force_gain[side];
    sole = {gain * sole.force + errors.force_zero[side], gain * sole.moment};
  }
  return measurement;
}

Measurement without_errors(Measurement measurement, const Calibration& errors) {
  const Mat3 by = mount(errors);
  measurement.q -= errors.encoder_zero;
  Measurement::Imu& imu = measurement.imu;
  imu = {imu.attitude * by.transpose(), by * imu.rate, by * imu.acceleration};
  for (const Side side : kSides) {
    Wrench& sole = measurement.sole[side];
    const double gain = errors.force_gain[side];
    sole = {(sole.force - errors.force_zero[side]) / gain, sole.moment / gain};
  }
  return measurement;
}

std::string text_of(const Calibration& calibration, const Calibration& sigma, const Calibration& prior,
                    const RobotModel& robot) {
  std::string text = fmt::format(
      "# Constant errors of the sensors of one robot, found by baton calibrate; for --calibration.\n"
      "# ± is the standard deviation. Of what is poorly observable, as it hardly shows while standing, only a part is "
      "found.\n\n"
      "robot = \"{}\"\n\n"
      "[encoder_zero_deg]  # [deg] what each encoder reads where the joint is at the model's zero\n",
      robot.profile().name);
  for (std::size_t j = 0; j < robot.joints().size(); ++j) {
    const auto i = static_cast<Eigen::Index>(j);
    text += line(robot.joints()[j].name, calibration.encoder_zero[i] / kDegree, sigma.encoder_zero[i] / kDegree,
                 prior.encoder_zero[i] / kDegree);
  }
  text += "\n[imu_mount_deg]  # [deg] turn of the IMU against the model's, a rotation vector in the IMU's frame\n";
  for (std::size_t k = 0; k < kTilts.size(); ++k) {
    const auto i = static_cast<Eigen::Index>(k);
    text +=
        line(kTilts[k], calibration.imu_mount[i] / kDegree, sigma.imu_mount[i] / kDegree, prior.imu_mount[i] / kDegree);
  }
  for (const Side side : kSides) {
    text += fmt::format("\n[{}_force]  # gain of force and moment; zeros [N] in the sole's frame\n", to_string(side));
    text += line("gain", calibration.force_gain[side], sigma.force_gain[side], prior.force_gain[side]);
    for (std::size_t k = 0; k < kAxes.size(); ++k) {
      const auto i = static_cast<Eigen::Index>(k);
      text += line(fmt::format("zero_{}", kAxes[k]), calibration.force_zero[side][i], sigma.force_zero[side][i],
                   prior.force_zero[side][i]);
    }
  }
  return text;
}

}  // namespace baton
