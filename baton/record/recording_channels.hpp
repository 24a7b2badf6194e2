/// The channels of a recording: topic, message, encoding (docs/recording.md).
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

#include "baton/mcap/format.hpp"

namespace baton {

inline constexpr int kRecordingVersion = 3;  ///< 1 and 2 were JSON Lines

/// What a channel is about; its number in a file that we write is one more.
enum class Topic : std::uint8_t {
  joint_states,
  imu,
  sole_left,
  sole_right,
  joint_targets,
  tick,
  command,
  planner,
  root,
  arms,
  events,
  segments,
  estimates,
  pushes,
  falls,
  tf,
  joy,
  link,
};

struct TopicInfo {
  std::string_view topic;
  std::string_view schema;
  bool ros = false;  ///< a message of ROS 2, in CDR; else one of ours, in JSON
};

inline constexpr std::array<TopicInfo, 18> kTopics{{
    {"/joint_states", "sensor_msgs/msg/JointState", true},
    {"/imu", "sensor_msgs/msg/Imu", true},
    {"/sole/left", "geometry_msgs/msg/WrenchStamped", true},
    {"/sole/right", "geometry_msgs/msg/WrenchStamped", true},
    {"/joint_targets", "sensor_msgs/msg/JointState", true},
    {"/baton/tick", "baton.Tick"},
    {"/baton/command", "baton.Command"},
    {"/baton/planner", "baton.Planner"},
    {"/baton/root", "baton.Root"},
    {"/baton/arms", "baton.ArmTargets"},
    {"/baton/events", "baton.Event"},
    {"/baton/segments", "baton.Segment"},
    {"/baton/estimates", "baton.Estimates"},
    {"/baton/pushes", "baton.Push"},
    {"/baton/falls", "baton.Fall"},
    {"/tf", "tf2_msgs/msg/TFMessage", true},
    {"/joy", "sensor_msgs/msg/Joy", true},
    {"/baton/link", "baton.Link"},
}};

[[nodiscard]] constexpr const TopicInfo& info(Topic topic) {
  return kTopics[static_cast<std::size_t>(topic)];
}

/// The topic of a channel, if it is one of ours.
[[nodiscard]] std::optional<Topic> topic_of(const mcap::Channel& channel, const mcap::Schema* schema);

/// The schema of a topic's messages.
[[nodiscard]] mcap::Schema schema_of(Topic topic);

}  // namespace baton
