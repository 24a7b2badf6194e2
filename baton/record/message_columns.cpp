#include "baton/record/message_columns.hpp"

#include <fmt/format.h>

#include <cmath>

#include "baton/input/json_reader.hpp"
#include "baton/mcap/bytes.hpp"
#include "baton/model/error.hpp"
#include "baton/record/ros_messages.hpp"

namespace baton {
namespace {

class Row {
 public:
  void add(std::string name, double value) {
    columns_.emplace_back(std::move(name), std::isfinite(value) ? fmt::format("{}", value) : "nan");
  }
  void add(const std::string& name, const Vec3& v) {
    for (Eigen::Index i = 0; i < 3; ++i)
      add(fmt::format("{}_{}", name, "xyz"[i]), v[i]);
  }
  void add(const std::string& name, const Eigen::Vector4d& quaternion) {
    for (Eigen::Index i = 0; i < 4; ++i)
      add(fmt::format("{}_{}", name, "xyzw"[i]), quaternion[i]);
  }
  void add(const ros::Header& header) { add("stamp", 1e-9 * static_cast<double>(header.stamp)); }
  void add(const std::string& name, const nlohmann::json& value) {
    const std::string prefix = name.empty() ? "" : name + "_";
    if (value.is_object()) {
      for (const auto& [key, member] : value.items())
        add(prefix + key, member);
    } else if (value.is_array()) {
      for (std::size_t i = 0; i < value.size(); ++i)
        add(prefix + std::to_string(i), value[i]);
    } else if (value.is_number()) {
      add(name, value.get<double>());
    } else {
      columns_.emplace_back(name, value.is_string() ? value.get<std::string>()
                                  : value.is_null() ? "nan"
                                                    : value.dump());
    }
  }

  [[nodiscard]] std::vector<Column> columns() && { return std::move(columns_); }

 private:
  std::vector<Column> columns_;
};

template <typename Message>
Message decoded(std::string_view bytes) {
  Message message;
  ros::decode(bytes, message);
  return message;
}

void add(Row& row, const ros::JointState& m) {
  row.add(m.header);
  for (const auto& [what, values] : {std::pair<const char*, const VecX*>{"position", &m.position},
                                     {"velocity", &m.velocity},
                                     {"effort", &m.effort}}) {
    for (Eigen::Index i = 0; i < values->size(); ++i) {
      const auto joint = static_cast<std::size_t>(i);
      row.add(fmt::format("{}_{}", what, joint < m.name.size() ? m.name[joint] : std::to_string(joint)), (*values)[i]);
    }
  }
}

void add(Row& row, const ros::Imu& m) {
  row.add(m.header);
  row.add("orientation", m.orientation);
  row.add("angular_velocity", m.angular_velocity);
  row.add("linear_acceleration", m.linear_acceleration);
}

void add(Row& row, const ros::WrenchStamped& m) {
  row.add(m.header);
  row.add("force", m.wrench.force);
  row.add("torque", m.wrench.moment);
}

void add(Row& row, const ros::Joy& m) {
  row.add(m.header);
  for (std::size_t i = 0; i < m.axes.size(); ++i)
    row.add(fmt::format("axes_{}", i), static_cast<double>(m.axes[i]));
  for (std::size_t i = 0; i < m.buttons.size(); ++i)
    row.add(fmt::format("buttons_{}", i), static_cast<double>(m.buttons[i]));
}

void add(Row& row, const ros::Transform& m) {
  row.add(m.header);
  row.add("translation", m.translation);
  row.add("rotation", m.rotation);
}

}  // namespace

std::vector<Column> columns_of(const mcap::Channel& channel, const mcap::Schema* schema, std::string_view message) {
  Row row;
  if (channel.encoding == "json") {
    try {
      row.add("", parse_json(message, channel.topic));
    } catch (const InputError& error) {
      throw mcap::Malformed(error.what());
    }
    return std::move(row).columns();
  }
  if (channel.encoding != "cdr" || schema == nullptr) return {};
  const std::string& name = schema->name;
  if (name == "sensor_msgs/msg/JointState") add(row, decoded<ros::JointState>(message));
  if (name == "sensor_msgs/msg/Imu") add(row, decoded<ros::Imu>(message));
  if (name == "geometry_msgs/msg/WrenchStamped") add(row, decoded<ros::WrenchStamped>(message));
  if (name == "sensor_msgs/msg/Joy") add(row, decoded<ros::Joy>(message));
  if (name == "tf2_msgs/msg/TFMessage") add(row, decoded<ros::Transform>(message));
  return std::move(row).columns();
}

}  // namespace baton
