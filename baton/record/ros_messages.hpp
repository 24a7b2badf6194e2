/// The messages of ROS 2 that recordings hold, since viewers know them: their schemas, and their bytes in CDR.
#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "baton/mcap/format.hpp"
#include "baton/model/contact.hpp"

namespace baton::ros {

/// Schema by the name of the message: sensor_msgs/msg/JointState, sensor_msgs/msg/Imu, sensor_msgs/msg/Joy,
/// geometry_msgs/msg/WrenchStamped, tf2_msgs/msg/TFMessage.
[[nodiscard]] mcap::Schema schema(const std::string& name);

/// When a message was true, and in which frame.
struct Header {
  std::int64_t stamp = 0;  ///< [ns]
  std::string frame;
};

/// Members that are not known are empty.
struct JointState {
  Header header;
  std::vector<std::string> name;
  VecX position;  ///< [rad]
  VecX velocity;  ///< [rad/s]
  VecX effort;    ///< [N·m]
};

struct Imu {
  Header header;
  Eigen::Vector4d orientation;  ///< quaternion x, y, z, w; zero: unknown
  Vec3 angular_velocity;        ///< in the sensor's frame [rad/s]
  Vec3 linear_acceleration;     ///< specific force, in the sensor's frame [m/s²]
};

struct WrenchStamped {
  Header header;
  Wrench wrench;
};

struct Joy {
  Header header;
  std::vector<float> axes;
  std::vector<std::int32_t> buttons;
};

/// A TFMessage with one transform.
struct Transform {
  Header header;  ///< its frame is the parent
  std::string child;
  Vec3 translation;          ///< [m]
  Eigen::Vector4d rotation;  ///< quaternion x, y, z, w
};

/// Replaces `out` by the message.
void encode(std::string& out, const JointState& message);
void encode(std::string& out, const Imu& message);
void encode(std::string& out, const WrenchStamped& message);
void encode(std::string& out, const Joy& message);
void encode(std::string& out, const Transform& message);

/// @throws mcap::Malformed the bytes are no such message
void decode(std::string_view bytes, JointState& message);
void decode(std::string_view bytes, Imu& message);
void decode(std::string_view bytes, WrenchStamped& message);
void decode(std::string_view bytes, Joy& message);
void decode(std::string_view bytes, Transform& message);

/// Quaternion x, y, z, w of a rotation; zero if that has members that are not finite.
[[nodiscard]] Eigen::Vector4d quaternion(const Mat3& rotation);
/// The rotation of a quaternion, but for rounding.
[[nodiscard]] Mat3 rotation(const Eigen::Vector4d& quaternion);

}  // namespace baton::ros
