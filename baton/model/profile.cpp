#include "baton/model/profile.hpp"

#include <fmt/format.h>

#include <cmath>
#include <numbers>

#include "baton/model/derive.hpp"
#include "baton/model/error.hpp"
#include "baton/model/toml_reader.hpp"

namespace baton {
namespace {

constexpr double kDegree = std::numbers::pi / 180.0;

std::array<std::string, 2> sided(const TomlReader& read, const std::string& part) {
  return {read.text("parts.left_" + part), read.text("parts.right_" + part)};
}

template <std::size_t N>
std::array<double, N> shares(const TomlReader& read, const std::string& key) {
  const auto values = read.numbers<N>(key, 0.01, 1.0);
  double sum = 0.0;
  for (const double value : values)
    sum += value;
  if (std::abs(sum - 1.0) > 1e-6) read.complain(key, "shares whose sum is 1");
  return values;
}

/// Thermal constants of a kind of motor; the table `key` is optional, its keys are not.
Thermal thermal(const TomlReader& read, const std::string& key) {
  Thermal t;
  t.continuous = read.positive(key + ".continuous", 1);
  t.winding = read.number(key + ".winding", 0.01, 1);
  t.winding_time = read.positive(key + ".winding_time", 1e4);
  t.housing_time = read.positive(key + ".housing_time", 1e5);
  if (t.housing_time < t.winding_time) read.complain(key + ".housing_time", "at least winding_time");
  return t;
}

/// Gains and thermal constants of the joints, by the kind of their servo.
void read_servos(const TomlReader& read, Profile& profile) {
  const toml::array* rows = read.at("drive.gains").as_array();
  if (rows == nullptr) read.complain("drive.gains", "a list of tables {kp, kd, joints}");
  for (std::size_t i = 0; i < rows->size(); ++i) {
    const std::string key = fmt::format("drive.gains[{}]", i);
    const Profile::Gains row{read.positive(key + ".kp", 1e6), read.number(key + ".kd", 0.0, 1e5)};
    const Profile::MotorData motor{read.number_or(key + ".torque", 0.0, 1e5, 0.0),
                                   read.number_or(key + ".armature", 0.0, 1e3, 0.0),
                                   read.number_or(key + ".speed", 0.0, 1e3, 0.0)};
    const toml::array* joints = read.at(key + ".joints").as_array();
    if (joints == nullptr) read.complain(key + ".joints", "a list of joint names");
    for (std::size_t j = 0; j < joints->size(); ++j) {
      const std::string joint = read.text(fmt::format("{}.joints[{}]", key, j));
      profile.gains[joint] = row;
      profile.motors[joint] = motor;
      if (read.at(key + ".heat")) profile.heat[joint] = thermal(read, key + ".heat");
    }
  }
}

/// A list of names; the key is optional.
std::vector<std::string> names(const TomlReader& read, const std::string& key) {
  std::vector<std::string> list;
  const auto node = read.at(key);
  if (!node) return list;
  const toml::array* array = node.as_array();
  if (array == nullptr) read.complain(key, "a list of names");
  for (std::size_t i = 0; i < array->size(); ++i)
    list.push_back(read.text(fmt::format("{}[{}]", key, i)));
  return list;
}

/// Pairs of names; the key is optional.
std::vector<std::array<std::string, 2>> pairs(const TomlReader& read, const std::string& key) {
  std::vector<std::array<std::string, 2>> list;
  const auto node = read.at(key);
  if (!node) return list;
  const toml::array* array = node.as_array();
  if (array == nullptr) read.complain(key, "a list of pairs of names");
  for (std::size_t i = 0; i < array->size(); ++i) {
    const std::string pair = fmt::format("{}[{}]", key, i);
    const toml::array* two = read.at(pair).as_array();
    if (two == nullptr || two->size() != 2) read.complain(pair, "two names");
    list.push_back({read.text(pair + "[0]"), read.text(pair + "[1]")});
  }
  return list;
}

/// Errors of the sensors; what is missing is moderate.
SensorErrors sensor_errors(const TomlReader& read) {
  SensorErrors e;
  e.delay = read.number_or("sensors.delay", 0, 0.1, 0.005);
  e.jitter = read.number_or("sensors.jitter", 0, 0.1, 0.001);
  e.encoder_noise = read.number_or("sensors.encoder_noise", 0, 0.1, 0.0);
  e.encoder_offset = read.number_or("sensors.encoder_offset", 0, 0.2, 0.25 * kDegree);
  e.encoder_step = read.number_or("sensors.encoder_step", 0, 0.1, 0.05 * kDegree);
  e.differenced_speeds = read.flag_or("sensors.differenced_speeds", true);
  e.imu_mount = read.number_or("sensors.imu_mount", 0, 0.2, 0.5 * kDegree);
  e.imu_wander = read.number_or("sensors.imu_wander", 0, 0.2, 0.5 * kDegree);
  e.yaw_drift = read.number_or("sensors.yaw_drift", 0, 0.1, 1.7 / 60.0 * kDegree);
  e.gyro_noise = read.number_or("sensors.gyro_noise", 0, 1, 0.005);
  e.accelerometer_noise = read.number_or("sensors.accelerometer_noise", 0, 10, 0.05);
  e.force_noise = read.number_or("sensors.force_noise", 0, 1, 0.02);
  e.force_gain = read.number_or("sensors.force_gain", 0, 0.5, 0.03);
  e.force_zero = read.number_or("sensors.force_zero", 0, 1, 0.03);
  return e;
}

/// Errors of the actuators; what is missing is moderate.
ActuatorErrors actuator_errors(const TomlReader& read) {
  ActuatorErrors e;
  e.delay = read.number_or("actuators.delay", 0, 0.1, 0.0);
  e.held_targets = read.flag_or("actuators.held_targets", true);
  e.differenced_speeds = read.flag_or("actuators.differenced_speeds", true);
  e.lag = read.number_or("actuators.lag", 0, 0.1, 0.002);
  e.friction = read.number_or("actuators.friction", 0, 0.5, 0.05);
  e.backlash = read.number_or("actuators.backlash", 0, 0.1, 0.25 * kDegree);
  e.hip_compliance = read.number_or("actuators.hip_compliance", 0, 1, 0.02);
  return e;
}

}  // namespace

Drive drive_named(const std::string& name, const std::string& owner) {
  for (const Drive drive : {Drive::torque, Drive::pd, Drive::stiff}) {
    if (name == to_string(drive)) return drive;
  }
  throw InputError(fmt::format("{} is \"{}\" but should be torque, pd or stiff", owner, name));
}

ModelChanges Profile::changes() const {
  ModelChanges changes;
  for (const auto& [joint, motor] : motors) {
    if (motor.torque > 0.0 || motor.armature > 0.0) changes.motors[joint] = {motor.torque, motor.armature};
  }
  changes.sites.assign(parts.foot.begin(), parts.foot.end());
  changes.sites.push_back(imu);
  changes.hands.assign(parts.hand.begin(), parts.hand.end());
  changes.rigid = rigid;
  changes.self_pairs = self_pairs;
  return changes;
}

Profile Profile::load(const std::filesystem::path& file) {
  const bool is_model = file.extension() != ".toml";
  const toml::table given = is_model ? toml::table{{"model", file.filename().string()}} : parse_toml(file, "profile");
  const std::filesystem::path folder = std::filesystem::absolute(file).parent_path();
  static_cast<void>(complete_with(of_no_robot(given), folder, file.string()));
  try {
    return complete_with(complete(given, folder, file.string()), folder, file.string());
  } catch (const InputError& error) {
    const std::string message = error.what();
    if (is_model || message.find(file.string()) != std::string::npos) throw;
    throw InputError(fmt::format("profile {}: {}", file.string(), message));
  }
}

Profile Profile::complete_with(const CompleteProfile& complete, const std::filesystem::path& folder,
                               const std::string& file) {
  const TomlReader read(complete.table, "profile", file);
  Profile p;
  p.sources = complete.sources;
  p.warnings = complete.warnings;
  p.name = read.text("name");
  p.model = (folder / read.text("model")).lexically_normal();
  p.parts = {read.text("parts.trunk"), sided(read, "foot"), sided(read, "hand"), sided(read, "shoulder")};
  if (read.at("parts.imu")) p.imu = read.text("parts.imu");
  p.rigid = names(read, "rigid");
  p.self_pairs = pairs(read, "self_pairs");
  p.stance = {read.positive("stance.width", 2.0), read.positive("stance.com_height", 3.0)};
  for (const auto& [joint, degrees] : read.table("home_deg", -360, 360))
    p.home[joint] = degrees * kDegree;
  p.reach = {read.positive("reach.foot", 2), read.positive("reach.trunk", 2), read.positive("reach.hand", 2),
             read.positive("reach.rotation", 3)};
  p.region = {read.range("region.foot_x", -2, 2),
              read.positive("region.stride", 2),
              read.range("region.foot_lateral", 0, 2),
              read.positive("region.foot_yaw", 1.5),
              read.number("region.sole_gap", 0, 1),
              read.range("region.com_height", 0.01, 3),
              read.number("region.trunk_inclination", 0, 1.5),
              read.positive("region.trunk_yaw", 1.5),
              read.positive("region.hand_distance", 3)};
  p.swing = {read.positive("swing.clearance", 1), read.positive("swing.lift", 1), read.positive("swing.time", 5)};
  p.ground = {read.number("ground.flatness", 0, 0.1), read.number("ground.tilt_deg", 0, 30) * kDegree};
  p.duration = {read.number("duration.default", 0.05, 10), read.number("duration.step", 0.01, 10),
                read.positive("duration.max", 60)};
  if (p.duration.max < p.duration.first) read.complain("duration.max", "at least duration.default");
  p.phases = {shares<3>(read, "phases.step"), shares<2>(read, "phases.lift"), shares<2>(read, "phases.lower"),
              shares<3>(read, "phases.flow"), read.numbers<4>("phases.weights", 1e-6, 1e6)};
  p.margin.zmp_plan = read.number("margin.zmp_plan", 0, 1);
  p.margin.zmp_outward = read.number("margin.zmp_outward", 0, 1);
  p.margin.zmp_verify = read.number("margin.zmp_verify", 0, 1);
  p.margin.zmp_feedback = read.number("margin.zmp_feedback", 0, 1);
  p.margin.stand_on = read.number("margin.stand_on", 0, 1);
  p.margin.joint = read.number("margin.joint", 0, 0.5);
  p.margin.speed = read.positive("margin.speed", 1);
  p.margin.torque = read.positive("margin.torque", 1);
  p.margin.acceleration = read.positive("margin.acceleration", 1e5);
  p.margin.friction = read.positive("margin.friction", 2);
  p.margin.self_collision = read.number("margin.self_collision", 0, 0.2);
  p.margin.edge = read.number("margin.edge", 0, 0.2);
  p.ik = {read.positive("ik.position", 0.01), read.positive("ik.rotation", 0.01), read.positive("ik.hand", 0.1)};
  const double lookahead = read.number("tick.lookahead", 1, 100);
  if (lookahead != std::round(lookahead)) read.complain("tick.lookahead", "a whole number");
  p.tick = {read.number("tick.period", 1e-4, 0.1), static_cast<int>(lookahead)};
  p.stabiliser = {read.number("stabiliser.k_dcm", 0, 20)};
  p.drive = drive_named(read.text("drive.kind"), fmt::format("profile {}: drive.kind", file));
  read_servos(read, p);
  p.sensors = sensor_errors(read);
  p.actuators = actuator_errors(read);
  read.complain_of_unknown_keys();
  return p;
}

}  // namespace baton
