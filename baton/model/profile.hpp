/// The profile: what a robot needs beyond its model file (docs/robots.md lists every key).
#pragma once

#include <algorithm>
#include <array>
#include <filesystem>
#include <map>
#include <string>
#include <string_view>
#include <vector>

#include "baton/model/hardware_errors.hpp"
#include "baton/model/heat.hpp"
#include "baton/model/robot_file.hpp"

namespace baton {

struct CompleteProfile;

/// Closed interval.
struct Range {
  double lo = 0.0;
  double hi = 0.0;

  /// The nearest value inside.
  [[nodiscard]] double clamped(double value) const { return std::clamp(value, lo, hi); }
};

/// What the joint servos are commanded with.
enum class Drive {
  torque,  ///< angle, speed and feed-forward torque
  pd,  ///< angle and speed; torque = kp (q − q_m) + kd (q̇ − q̇_m), so feed-forward torque is added to q as τ/kp
  stiff,  ///< angle only: torque and damping are added to q, as (τ + kd q̇)/kp
};

[[nodiscard]] constexpr std::string_view to_string(Drive drive) {
  constexpr std::array<std::string_view, 3> names{"torque", "pd", "stiff"};
  return names[static_cast<std::size_t>(drive)];
}

/// @throws InputError no such drive; the message has `owner`
[[nodiscard]] Drive drive_named(const std::string& name, const std::string& owner);

/// Contents of a robot's `profile.toml`, in SI units and radians.
struct Profile {
  std::string name;
  std::filesystem::path model;  ///< MJCF file, absolute

  /// Names in the model. A foot or hand is a site, or a body: then a site of its name is added to it (`ModelChanges`).
  struct Parts {
    std::string trunk;                    ///< body
    std::array<std::string, 2> foot;      ///< on the sole plane, x forward, z up; its body is the foot
    std::array<std::string, 2> hand;      ///< the guided point
    std::array<std::string, 2> shoulder;  ///< body whose origin is the shoulder
  } parts;

  std::string imu;  ///< site of the IMU, or a body for one at its origin; empty: none

  std::vector<std::string> rigid;                      ///< joints that are held at zero, and are no joints any more
  std::vector<std::array<std::string, 2>> self_pairs;  ///< geoms that must not touch; empty: the model's pairs

  struct Stance {
    double width = 0.0;       ///< lateral distance between the sole centres [m]
    double com_height = 0.0;  ///< nominal, above the soles [m]
  } stance;

  std::map<std::string, double> home;  ///< home pose of the arms: joint name → angle [rad]

  /// Displacement of the guided part in one segment at full stick. Not the workspace.
  struct Reach {
    double foot = 0.0;      ///< [m]
    double trunk = 0.0;     ///< [m]
    double hand = 0.0;      ///< [m]
    double rotation = 0.0;  ///< [rad]
  } reach;

  /// Where goals may lie.
  struct Region {
    Range foot_x;                    ///< foothold in the stance sole's frame, forward [m]
    double stride = 0.0;             ///< largest |x| of steps that the robot chooses, if one of those will do [m]
    Range foot_lateral;              ///< the same sideways, away from the stance foot [m]
    double foot_yaw = 0.0;           ///< largest |yaw| between the soles [rad]
    double sole_gap = 0.0;           ///< least gap between the soles' outlines [m]
    Range com_height;                ///< above the mean height of the supporting soles [m]
    double trunk_inclination = 0.0;  ///< largest tilt of the trunk from upright [rad]
    double trunk_yaw = 0.0;          ///< yaw of the trunk relative to the feet that triggers a step [rad]
    double hand_distance = 0.0;      ///< largest comfortable distance from shoulder to hand [m]
  } region;

  struct Swing {
    double clearance = 0.0;  ///< apex above the higher foothold [m]
    double lift = 0.0;       ///< foot height at full throttle [m]
    double time = 0.0;       ///< shortest swing of a step [s]
  } swing;

  /// Ground that counts as flat enough to stand on.
  struct Ground {
    double flatness = 0.0;  ///< largest deviation from a plane under the sole [m]
    double tilt = 0.0;      ///< largest tilt of that plane [rad]
  } ground;

  /// Duration correction (docs/theory.md §4) [s].
  struct Duration {
    double first = 0.0;  ///< tried first; key `default`
    double step = 0.0;   ///< increment
    double max = 0.0;    ///< longest
  } duration;

  /// Shares of the duration by contact phase, and weights of the VRP knots at the phase borders.
  struct Phases {
    std::array<double, 3> step{};   ///< double, single, double support
    std::array<double, 2> lift{};   ///< double, single
    std::array<double, 2> lower{};  ///< single, double
    std::array<double, 3> flow{};   ///< step from a moving state: double, single, double
    std::array<double, 4> weights{};
  } phases;

  struct Margin {
    double zmp_plan = 0.0;        ///< of the planned point-mass ZMP inside the support polygon [m]
    double zmp_outward = 0.0;     ///< of the planned point-mass ZMP from the outer edges of the soles, if more [m]
    double zmp_verify = 0.0;      ///< of the whole-body ZMP, in verification [m]
    double zmp_feedback = 0.0;    ///< of the ZMP that the stabiliser commands [m]
    double stand_on = 0.0;        ///< of the COM at rest [m]
    double joint = 0.0;           ///< distance from position limits [rad]
    double speed = 0.0;           ///< largest share of the no-load speed
    double torque = 0.0;          ///< largest share of the stall torque
    double acceleration = 0.0;    ///< largest joint acceleration [rad/s²]
    double friction = 0.0;        ///< largest ratio of tangential to normal force
    double self_collision = 0.0;  ///< least distance between links, and of links from obstacles [m]
    double edge = 0.0;            ///< least distance of a foothold from terrain edges [m]
  } margin;

  /// Tolerated residuals of inverse kinematics.
  struct Ik {
    double position = 0.0;  ///< of soles and COM [m]
    double rotation = 0.0;  ///< of soles [rad]
    double hand = 0.0;      ///< of the guided hand, at the end of a motion [m]
  } ik;

  struct Tick {
    double period = 0.0;  ///< [s]
    int lookahead = 0;    ///< [ticks] from a planning request to its take-over
  } tick;

  struct Stabiliser {
    double k_dcm = 0.0;  ///< DCM feedback gain, k_p in docs/theory.md §6 [1/s]
  } stabiliser;

  Drive drive = Drive::pd;

  /// Servo gains of one joint [N·m/rad], [N·m·s/rad].
  struct Gains {
    double kp = 0.0;
    double kd = 0.0;
  };
  std::map<std::string, Gains> gains;  ///< by joint name

  /// What the profile says about the motor of a joint; 0: the model says it.
  struct MotorData {
    double torque = 0.0;    ///< stall torque [N·m]
    double armature = 0.0;  ///< reflected inertia [kg·m²]
    double speed = 0.0;     ///< no-load speed; 0: stall torque / damping [rad/s]
  };
  std::map<std::string, MotorData> motors;  ///< by joint name
  std::map<std::string, Thermal> heat;      ///< by joint name; a motor without an entry never gets warm

  SensorErrors sensors;      ///< of a simulated robot, as of the real one; optional keys
  ActuatorErrors actuators;  ///< the same

  std::map<std::string, std::string> sources;  ///< of the values that were derived: key → where they come from
  std::vector<std::string> warnings;           ///< what the model lacks and was assumed

  /// What the profile adds to the model.
  [[nodiscard]] ModelChanges changes() const;

  /// Reads and validates a profile, and derives from the model what it leaves out (`complete`). A model file, MJCF or
  /// URDF, stands for a profile that leaves out everything.
  /// @throws InputError file missing or not TOML; key unknown, of the wrong type, not finite or out of range; model
  /// unusable
  [[nodiscard]] static Profile load(const std::filesystem::path& file);

  /// Validates a profile that is complete.
  /// @param folder that its `model` is relative to
  /// @param file its name in messages
  /// @throws InputError as above
  [[nodiscard]] static Profile complete_with(const CompleteProfile& complete, const std::filesystem::path& folder,
                                             const std::string& file);
};

}  // namespace baton
