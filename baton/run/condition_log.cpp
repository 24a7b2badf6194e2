#include "baton/run/condition_log.hpp"

#include <fmt/format.h>

#include <cmath>

#include "baton/balance/check_limits.hpp"

namespace baton {
namespace {

std::string numbers(const Vec3& v) {
  return fmt::format("({:.2f}, {:.2f}, {:.2f})", v.x(), v.y(), v.z());
}

/// The joint whose reading is farthest from what is believed; one that is not a number is farther than any.
Eigen::Index farthest(const VecX& read, const VecX& believed) {
  Eigen::Index found = 0;
  for (Eigen::Index j = 0; j < read.size(); ++j) {
    if (std::isnan(read[j])) return j;
    if (std::abs(read[j] - believed[j]) > std::abs(read[found] - believed[found])) found = j;
  }
  return found;
}

std::string shown(const Wrench& wrench) {
  return fmt::format("{} N, {} N m", numbers(wrench.force), numbers(wrench.moment));
}

std::string_view text_of(const GuardChanged& changed) {
  switch (changed.to) {
    case Guard::armed:
      return "stands, and can be guided";
    case Guard::lifted:
      return "lifted, or its soles carry nothing by its sensors: no motion begins before it stands";
    case Guard::fallen:
      return changed.from == Guard::stood_up ? "stands still no longer: its motors give no torque"
                                             : "has fallen, by its sensors: its motors give no torque";
    case Guard::stood_up:
      return "stands upright again: centre the stick to arm it";
  }
  return "";
}

}  // namespace

std::string rejected_reading(const RobotModel& robot, Sensor sensor, const Measurement& read,
                             const Measurement& believed) {
  const auto joint = [&](Eigen::Index j) { return robot.joints()[static_cast<std::size_t>(j)].name; };
  switch (sensor) {
    case Sensor::encoders: {
      const Eigen::Index by_angle = farthest(read.q, believed.q);
      const bool same_angles = std::abs(read.q[by_angle] - believed.q[by_angle]) < 1e-3;
      const Eigen::Index j = same_angles ? farthest(read.dq, believed.dq) : by_angle;
      return fmt::format("{} at {:.3f} rad and {:.2f} rad/s, expected about {:.3f} rad and {:.2f} rad/s", joint(j),
                         read.q[j], read.dq[j], believed.q[j], believed.dq[j]);
    }
    case Sensor::torques: {
      if (read.torque.size() == 0 || believed.torque.size() != read.torque.size()) return "none";
      const Eigen::Index j = farthest(read.torque, believed.torque);
      return fmt::format("{} with {:.2f} N m, expected about {:.2f} N m", joint(j), read.torque[j], believed.torque[j]);
    }
    case Sensor::attitude: {
      const Mat3& R = read.imu.attitude;
      if (!check::is_rotation(R))
        return fmt::format("no rotation matrix: rows {}, {}, {}", numbers(R.row(0)), numbers(R.row(1)),
                           numbers(R.row(2)));
      const Vec3 off = rotation_log(believed.imu.attitude.transpose() * R);
      return fmt::format("turned by {:.2f} rad from what is expected, about {} in its axes", off.norm(),
                         numbers(off.normalized()));
    }
    case Sensor::gyro:
      return fmt::format("{} rad/s, expected about {} rad/s", numbers(read.imu.rate), numbers(believed.imu.rate));
    case Sensor::accelerometer:
      return fmt::format("{} m/s², expected about {} m/s²", numbers(read.imu.acceleration),
                         numbers(believed.imu.acceleration));
    case Sensor::forces: {
      const auto off = [&](Side side) {
        const double force = (read.sole[side].force - believed.sole[side].force).norm();
        const double moment = (read.sole[side].moment - believed.sole[side].moment).norm();
        return force + moment / robot.profile().stance.com_height;
      };
      const Side side = off(Side::left) >= off(Side::right) || std::isnan(off(Side::left)) ? Side::left : Side::right;
      return fmt::format("{} sole with {}, expected about {}", side == Side::left ? "left" : "right",
                         shown(read.sole[side]), shown(believed.sole[side]));
    }
  }
  return "";
}

void ConditionLog::on_tick(const TickRecord& record) {
  for (const Event& event : record.navigator.events()) {
    const auto* changed = std::get_if<GuardChanged>(&event);
    if (changed == nullptr) continue;
    const bool falls = changed->to == Guard::fallen && changed->from != Guard::stood_up;
    say(record, falls, "guard", std::string(text_of(*changed)));
  }
  const SensorCheck& sensors = record.navigator.sensors();
  if (sensors.frozen() && sensors.lost() && !std::exchange(told_frozen_, true))
    say(record, true, "sensor",
        "all readings stay the same while the robot moves: no motion begins before they change");
  if (told_frozen_) {  // one line, not one for each sensor
    if (sensors.lost()) return;
    told_frozen_ = false;
    say(record, false, "sensor", "readings are plausible again");
  }
  for (const Sensor sensor : kSensors)
    look_at(sensor, record);
}

void ConditionLog::look_at(Sensor sensor, const TickRecord& record) {
  const SensorCheck& sensors = record.navigator.sensors();
  const Health health = sensors.health(sensor);
  if (health == Health::good && std::exchange(told_lost_[sensor], false)) {
    say(record, false, "sensor", fmt::format("{}: readings are plausible again", to_string(sensor)));
  } else if (health == Health::lost && !told_lost_[sensor] && record.t >= told_[sensor] + kAgain) {
    told_[sensor] = record.t;
    told_lost_[sensor] = true;
    say(record, true, "sensor",
        fmt::format("{}: readings are rejected: {}; no motion begins before they are plausible", to_string(sensor),
                    rejected_reading(*robot_, sensor, record.measurement, sensors.believed())));
  }
}

}  // namespace baton
