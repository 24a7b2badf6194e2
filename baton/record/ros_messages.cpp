#include "baton/record/ros_messages.hpp"

#include <algorithm>
#include <map>
#include <span>

#include "baton/mcap/cdr.hpp"

namespace baton::ros {
namespace {

using mcap::CdrReader;
using mcap::CdrWriter;

constexpr std::int64_t kSecond = 1'000'000'000;

/// Definitions by name, each with what it refers to. The order is that of the members in CDR.
struct Definition {
  std::string text;
  std::vector<std::string> parts;
};

const std::map<std::string, Definition>& definitions() {
  static const std::map<std::string, Definition> all{
      {"builtin_interfaces/Time", {"int32 sec\nuint32 nanosec\n", {}}},
      {"std_msgs/Header", {"builtin_interfaces/Time stamp\nstring frame_id\n", {"builtin_interfaces/Time"}}},
      {"geometry_msgs/Vector3", {"float64 x\nfloat64 y\nfloat64 z\n", {}}},
      {"geometry_msgs/Quaternion", {"float64 x\nfloat64 y\nfloat64 z\nfloat64 w\n", {}}},
      {"geometry_msgs/Wrench",
       {"geometry_msgs/Vector3 force\ngeometry_msgs/Vector3 torque\n", {"geometry_msgs/Vector3"}}},
      {"geometry_msgs/Transform",
       {"geometry_msgs/Vector3 translation\ngeometry_msgs/Quaternion rotation\n",
        {"geometry_msgs/Vector3", "geometry_msgs/Quaternion"}}},
      {"geometry_msgs/TransformStamped",
       {"std_msgs/Header header\nstring child_frame_id\ngeometry_msgs/Transform transform\n",
        {"std_msgs/Header", "geometry_msgs/Transform"}}},
      {"geometry_msgs/WrenchStamped",
       {"std_msgs/Header header\ngeometry_msgs/Wrench wrench\n", {"std_msgs/Header", "geometry_msgs/Wrench"}}},
      {"sensor_msgs/JointState",
       {"std_msgs/Header header\nstring[] name\nfloat64[] position\nfloat64[] velocity\nfloat64[] effort\n",
        {"std_msgs/Header"}}},
      {"sensor_msgs/Imu",
       {"std_msgs/Header header\ngeometry_msgs/Quaternion orientation\nfloat64[9] orientation_covariance\n"
        "geometry_msgs/Vector3 angular_velocity\nfloat64[9] angular_velocity_covariance\n"
        "geometry_msgs/Vector3 linear_acceleration\nfloat64[9] linear_acceleration_covariance\n",
        {"std_msgs/Header", "geometry_msgs/Quaternion", "geometry_msgs/Vector3"}}},
      {"sensor_msgs/Joy", {"std_msgs/Header header\nfloat32[] axes\nint32[] buttons\n", {"std_msgs/Header"}}},
      {"tf2_msgs/TFMessage", {"geometry_msgs/TransformStamped[] transforms\n", {"geometry_msgs/TransformStamped"}}},
  };
  return all;
}

/// Appends the definitions of the parts that are not there yet.
void add_parts(const Definition& definition, std::vector<std::string>& there, std::string& text) {
  for (const std::string& part : definition.parts) {
    if (std::find(there.begin(), there.end(), part) != there.end()) continue;
    there.push_back(part);
    const Definition& known = definitions().at(part);
    text += std::string(80, '=') + "\nMSG: " + part + "\n" + known.text;
    add_parts(known, there, text);
  }
}

void put(CdrWriter& writer, const Header& header) {
  std::int64_t seconds = header.stamp / kSecond;
  std::int64_t rest = header.stamp % kSecond;
  if (rest < 0) rest += kSecond, --seconds;
  writer.number<std::int32_t>(static_cast<std::int32_t>(seconds));
  writer.number<std::uint32_t>(static_cast<std::uint32_t>(rest)).text(header.frame);
}

void get(CdrReader& reader, Header& header) {
  const std::int64_t seconds = reader.number<std::int32_t>();
  header.stamp = seconds * kSecond + reader.number<std::uint32_t>();
  header.frame = reader.text();
}

template <typename Vector>
std::span<const double> numbers(const Vector& vector) {
  return {vector.data(), static_cast<std::size_t>(vector.size())};
}

template <typename Vector>
std::span<double> room(Vector& vector) {
  return {vector.data(), static_cast<std::size_t>(vector.size())};
}

constexpr std::array<double, 9> kNoCovariance{};

void skip_covariance(CdrReader& reader) {
  std::array<double, 9> covariance{};
  reader.array<double>(covariance);
}

}  // namespace

mcap::Schema schema(const std::string& name) {
  std::string key = name;
  key.erase(key.find("/msg"), 4);
  const Definition& definition = definitions().at(key);
  mcap::Schema schema{name, "ros2msg", definition.text};
  std::vector<std::string> there;
  add_parts(definition, there, schema.text);
  return schema;
}

void encode(std::string& out, const JointState& message) {
  CdrWriter writer(out);
  put(writer, message.header);
  writer.number<std::uint32_t>(static_cast<std::uint32_t>(message.name.size()));
  for (const std::string& name : message.name)
    writer.text(name);
  for (const VecX* values : {&message.position, &message.velocity, &message.effort})
    writer.sequence(numbers(*values));
}

void decode(std::string_view bytes, JointState& message) {
  CdrReader reader(bytes);
  get(reader, message.header);
  const auto names = reader.number<std::uint32_t>();
  if (names > CdrReader::kMost) throw mcap::Malformed("has too many names");
  message.name.resize(names);
  for (std::string& name : message.name)
    name = reader.text();
  for (VecX* values : {&message.position, &message.velocity, &message.effort})
    *values = reader.sequence<VecX>();
}

void encode(std::string& out, const Imu& message) {
  CdrWriter writer(out);
  put(writer, message.header);
  std::array<double, 9> covariance{};
  if (message.orientation.isZero(0.0)) covariance[0] = -1.0;  // there is no orientation
  writer.array(numbers(message.orientation)).array<double>(covariance);
  writer.array(numbers(message.angular_velocity)).array<double>(kNoCovariance);
  writer.array(numbers(message.linear_acceleration)).array<double>(kNoCovariance);
}

void decode(std::string_view bytes, Imu& message) {
  CdrReader reader(bytes);
  get(reader, message.header);
  reader.array(room(message.orientation));
  skip_covariance(reader);
  reader.array(room(message.angular_velocity));
  skip_covariance(reader);
  reader.array(room(message.linear_acceleration));
  skip_covariance(reader);
}

void encode(std::string& out, const WrenchStamped& message) {
  CdrWriter writer(out);
  put(writer, message.header);
  writer.array(numbers(message.wrench.force)).array(numbers(message.wrench.moment));
}

void decode(std::string_view bytes, WrenchStamped& message) {
  CdrReader reader(bytes);
  get(reader, message.header);
  reader.array(room(message.wrench.force));
  reader.array(room(message.wrench.moment));
}

void encode(std::string& out, const Joy& message) {
  CdrWriter writer(out);
  put(writer, message.header);
  writer.sequence<float>(message.axes).sequence<std::int32_t>(message.buttons);
}

void decode(std::string_view bytes, Joy& message) {
  CdrReader reader(bytes);
  get(reader, message.header);
  message.axes = reader.sequence<std::vector<float>>();
  message.buttons = reader.sequence<std::vector<std::int32_t>>();
}

void encode(std::string& out, const Transform& message) {
  CdrWriter writer(out);
  writer.number<std::uint32_t>(1);
  put(writer, message.header);
  writer.text(message.child).array(numbers(message.translation)).array(numbers(message.rotation));
}

void decode(std::string_view bytes, Transform& message) {
  CdrReader reader(bytes);
  if (reader.number<std::uint32_t>() != 1) throw mcap::Malformed("has not one transform");
  get(reader, message.header);
  message.child = reader.text();
  reader.array(room(message.translation));
  reader.array(room(message.rotation));
}

Eigen::Vector4d quaternion(const Mat3& rotation) {
  if (!rotation.allFinite()) return Eigen::Vector4d::Zero();
  return Eigen::Quaterniond(rotation).coeffs();
}

Mat3 rotation(const Eigen::Vector4d& quaternion) {
  return Eigen::Quaterniond(quaternion).toRotationMatrix();
}

}  // namespace baton::ros
