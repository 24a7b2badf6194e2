#include "app/condition_log.hpp"

#include <fmt/format.h>

#include <cmath>

namespace baton::app {
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

std::string_view text(Guard guard) {
  switch (guard) {
    case Guard::armed:
      return "stands, and can be guided";
    case Guard::lifted:
      return "lifted, or its soles carry nothing by its sensors: no motion begins before it stands";
    case Guard::fallen:
      return "has fallen, by its sensors: its motors give no torque";
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
      const Eigen::Index by_speed = farthest(read.dq, believed.dq);
      const Eigen::Index by_angle = farthest(read.q, believed.q);
      const bool same_angles = std::abs(read.q[by_angle] - believed.q[by_angle]) < 1e-3;
      const Eigen::Index j = same_angles ? by_speed : by_angle;
      return fmt::format("{} at {:.3f} rad and {:.2f} rad/s, expected about {:.3f} rad and {:.2f} rad/s", joint(j),
                         read.q[j], read.dq[j], believed.q[j], believed.dq[j]);
    }
    case Sensor::torques: {
      const Eigen::Index j = farthest(read.torque, believed.torque);
      return fmt::format("{} with {:.2f} N m, expected about {:.2f} N m", joint(j), read.torque[j], believed.torque[j]);
    }
    case Sensor::attitude:
      return fmt::format("the z axis along {}, expected about {}", numbers(read.imu.attitude.col(2)),
                         numbers(believed.imu.attitude.col(2)));
    case Sensor::gyro:
      return fmt::format("{} rad/s, expected about {} rad/s", numbers(read.imu.rate), numbers(believed.imu.rate));
    case Sensor::accelerometer:
      return fmt::format("{} m/s², expected about {} m/s²", numbers(read.imu.acceleration),
                         numbers(believed.imu.acceleration));
    case Sensor::forces:
      return fmt::format("{} N on the left sole and {} N on the right, expected about {} N and {} N",
                         numbers(read.sole.left.force), numbers(read.sole.right.force),
                         numbers(believed.sole.left.force), numbers(believed.sole.right.force));
  }
  return "";
}

void ConditionLog::on_tick(const TickRecord& record) {
  for (const Event& event : record.navigator.events()) {
    if (const auto* changed = std::get_if<GuardChanged>(&event)) {
      lines_.push_back({record.t, changed->to == Guard::fallen, "guard", std::string(text(changed->to))});
    }
    const auto* changed = std::get_if<SensorChanged>(&event);
    if (changed == nullptr) continue;
    const Sensor sensor = changed->sensor;
    if (changed->health == Health::lost && record.t >= told_[sensor] + kAgain) {
      told_[sensor] = record.t;
      told_lost_[sensor] = true;
      const Measurement& believed = record.navigator.sensors().believed();
      lines_.push_back(
          {record.t, true, "sensor",
           fmt::format("{}: readings are rejected: {}; no motion begins before they are plausible", to_string(sensor),
                       rejected_reading(*robot_, sensor, record.measurement, believed))});
    } else if (changed->health == Health::good && std::exchange(told_lost_[sensor], false)) {
      lines_.push_back({record.t, false, "sensor", fmt::format("{}: readings are plausible again", to_string(sensor))});
    }
  }
}

}  // namespace baton::app
