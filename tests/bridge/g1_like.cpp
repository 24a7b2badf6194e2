#include "tests/bridge/g1_like.hpp"

#include <fmt/format.h>

#include <filesystem>
#include <fstream>
#include <string>

#include "tests/support/temp.hpp"

namespace baton::test {
namespace {

struct Link {
  const char* joint;  ///< without side
  const char* axis;
  const char* range;     ///< of the left side [rad]
  const char* mirrored;  ///< of the right side [rad]
  double x, y, z;        ///< from the link before; y on the left side [m]
  double mass;           ///< [kg]
  int torque;            ///< [N·m]
};

constexpr Link kLeg[] = {
    {"hip_pitch", "0 1 0", "-2.5 2.8", "-2.5 2.8", 0, 0.09, -0.1, 1.5, 88},
    {"hip_roll", "1 0 0", "-0.5 2.9", "-2.9 0.5", 0, 0.03, -0.03, 1.5, 139},
    {"hip_yaw", "0 0 1", "-2.7 2.7", "-2.7 2.7", 0, 0, -0.1, 1.7, 88},
    {"knee", "0 1 0", "-0.08 2.8", "-0.08 2.8", 0, 0, -0.2, 1.9, 139},
    {"ankle_pitch", "0 1 0", "-0.87 0.52", "-0.87 0.52", 0, 0, -0.3, 0.1, 50},
    {"ankle_roll", "1 0 0", "-0.26 0.26", "-0.26 0.26", 0, 0, -0.02, 0.6, 50},
};
constexpr Link kArm[] = {
    {"shoulder_pitch", "0 1 0", "-3 2.6", "-3 2.6", 0, 0.1, 0.24, 0.7, 25},
    {"shoulder_roll", "1 0 0", "-1.5 2.2", "-2.2 1.5", 0, 0.04, -0.01, 0.6, 25},
    {"shoulder_yaw", "0 0 1", "-2.6 2.6", "-2.6 2.6", 0, 0, -0.1, 0.7, 25},
    {"elbow", "0 1 0", "-1 2", "-1 2", 0.01, 0, -0.1, 0.6, 25},
    {"wrist_roll", "1 0 0", "-1.9 1.9", "-1.9 1.9", 0.1, 0, -0.01, 0.1, 25},
    {"wrist_pitch", "0 1 0", "-1.6 1.6", "-1.6 1.6", 0.04, 0, 0, 0.4, 5},
    {"wrist_yaw", "0 0 1", "-1.6 1.6", "-1.6 1.6", 0.05, 0, 0, 0.2, 5},
};

template <std::size_t n>
std::string limb(const Link (&links)[n], bool left, const std::string& end) {
  std::string opened, closed;
  for (const Link& link : links) {
    opened += fmt::format(
        "<body pos='{} {} {}'><joint name='{}_{}_joint' axis='{}' range='{}' actuatorfrcrange='-{} {}' "
        "armature='0.01'/>"
        "<inertial pos='0 0 -0.02' mass='{}' diaginertia='0.002 0.002 0.002'/>",
        link.x, left ? link.y : -link.y, link.z, left ? "left" : "right", link.joint, link.axis,
        left ? link.range : link.mirrored, link.torque, link.torque, link.mass);
    closed += "</body>";
  }
  return opened + end + closed;
}

std::string limbs(bool left) {
  return limb(kLeg, left, "<geom type='box' size='0.1 0.03 0.01' pos='0.03 0 -0.02' mass='0'/>");
}

std::string arms(bool left) {
  return limb(kArm, left, "<geom type='sphere' size='0.03' pos='0.05 0 0' mass='0'/>");
}

std::string waist_link(const char* name, const char* axis, int torque) {
  return fmt::format(
      "<body><joint name='waist_{}_joint' axis='{}' range='-0.5 0.5' actuatorfrcrange='-{} {}' armature='0.01'/>", name,
      axis, torque, torque);
}

}  // namespace

const RobotModel& g1_like() {
  static const RobotModel robot = [] {
    const std::string folder = temp_folder() + "g1_like/";
    std::filesystem::create_directories(folder);
    std::ofstream(folder + "g1.xml")
        << "<mujoco><compiler angle='radian'/><worldbody><body name='pelvis' pos='0 0 0.8'><freejoint/>"
           "<inertial pos='0 0 -0.05' mass='3.8' diaginertia='0.01 0.01 0.01'/><site name='imu' pos='0.04 0 -0.08'/>"
        << limbs(false) << limbs(true) << waist_link("yaw", "0 0 1", 88)
        << "<inertial pos='0 0 0.02' mass='0.2' diaginertia='0.001 0.001 0.001'/>" << waist_link("roll", "1 0 0", 50)
        << "<inertial pos='0 0 0.02' mass='0.1' diaginertia='0.001 0.001 0.001'/>" << waist_link("pitch", "0 1 0", 50)
        << "<inertial pos='0 0 0.15' mass='7.8' diaginertia='0.12 0.1 0.03'/>" << arms(false) << arms(true)
        << "</body></body></body></body></worldbody></mujoco>";
    std::ofstream(folder + "profile.toml") << "name = 'g1_like'\nmodel = 'g1.xml'\n";
    return RobotModel::load(folder + "profile.toml");
  }();
  return robot;
}

}  // namespace baton::test
