/// The profile: what a robot needs beyond its model file (docs/robots.md lists every key).
#pragma once

#include <array>
#include <filesystem>
#include <map>
#include <string>
#include <string_view>
#include <vector>

namespace baton {

/// Closed interval.
struct Range {
  double lo = 0.0;
  double hi = 0.0;
};

/// What the servos of the joints take.
enum class Drive {
  torque,  ///< angle, speed, and a feed-forward torque
  pd,  ///< angle and speed: torque = kp (q − q_m) + kd (q̇ − q̇_m), so that a torque can be folded into the angle
  stiff,  ///< the angle alone, which they hold as firmly as they can
};

[[nodiscard]] constexpr std::string_view to_string(Drive drive) {
  constexpr std::array<std::string_view, 3> names{"torque", "pd", "stiff"};
  return names[static_cast<std::size_t>(drive)];
}

/// @throws InputError no such drive; the message names `owner`
[[nodiscard]] Drive drive_named(const std::string& name, const std::string& owner);

/// Values are SI and radians; every one comes from the robot's `profile.toml`.
struct Profile {
  std::string name;
  std::filesystem::path model;  ///< MJCF or URDF, absolute

  /// Names in the model.
  struct Parts {
    std::string trunk;                    ///< body
    std::array<std::string, 2> foot;      ///< site on the sole plane, x forward, z up; its body is the foot
    std::array<std::string, 2> hand;      ///< site
    std::array<std::string, 2> shoulder;  ///< body whose origin is the shoulder
  } parts;

  std::string imu;  ///< site of the inertial sensor; empty: none

  struct Stance {
    double width = 0.0;       ///< lateral distance of the sole centres [m]
    double com_height = 0.0;  ///< nominal, above the soles [m]
  } stance;

  std::map<std::string, double> home;  ///< arms at home: joint name → angle [rad]

  /// Displacement of the guided part a segment at full stick.
  struct Reach {
    double foot = 0.0;      ///< [m]
    double trunk = 0.0;     ///< [m]
    double hand = 0.0;      ///< [m]
    double rotation = 0.0;  ///< [rad]
  } reach;

  /// Where goals may lie.
  struct Region {
    Range foot_x;                    ///< of a foothold in the stance sole's frame [m]
    double stride = 0.0;             ///< largest |x| that the robot itself chooses while it can do with it [m]
    Range foot_lateral;              ///< the same, away from the stance foot [m]
    double foot_yaw = 0.0;           ///< largest |yaw| between the soles [rad]
    double sole_gap = 0.0;           ///< least gap of the two soles' outlines [m]
    Range com_height;                ///< above the mean height of the supporting soles [m]
    double trunk_inclination = 0.0;  ///< largest tilt of the trunk from upright [rad]
    double trunk_yaw = 0.0;          ///< difference of trunk and feet that makes a step due [rad]
    double hand_distance = 0.0;      ///< largest comfortable distance of hand and shoulder [m]
  } region;

  struct Swing {
    double clearance = 0.0;  ///< apex above the higher end of a step [m]
    double lift = 0.0;       ///< height of a lifted foot at full throttle [m]
    double time = 0.0;       ///< shortest time that a foot is in the air on a step [s]
  } swing;

  /// Flat enough to stand on.
  struct Ground {
    double flatness = 0.0;  ///< largest distance of a point under the sole from a plane [m]
    double tilt = 0.0;      ///< largest tilt of that plane [rad]
  } ground;

  /// Duration correction (docs/theory.md §4) [s].
  struct Duration {
    double first = 0.0;
    double step = 0.0;
    double max = 0.0;
  } duration;

  /// Shares of the duration, by contact phase, and weights of the VRP knots at their borders.
  struct Phases {
    std::array<double, 3> step{};   ///< double, single, double support
    std::array<double, 2> lift{};   ///< double, single
    std::array<double, 2> lower{};  ///< single, double
    std::array<double, 3> flow{};   ///< of a step that begins on the way: double, single, double
    std::array<double, 4> weights{};
  } phases;

  struct Margin {
    double zmp_plan = 0.0;        ///< of the point mass's ZMP, inside the support polygon [m]
    double zmp_verify = 0.0;      ///< of the whole body's ZMP [m]
    double zmp_feedback = 0.0;    ///< of the ZMP that the stabiliser may ask for [m]
    double stand_on = 0.0;        ///< of a resting COM [m]
    double joint = 0.0;           ///< from position limits [rad]
    double speed = 0.0;           ///< largest share of the no-load speed
    double torque = 0.0;          ///< largest share of the stall torque
    double acceleration = 0.0;    ///< largest of a joint [rad/s²]
    double friction = 0.0;        ///< largest tangential over normal force
    double self_collision = 0.0;  ///< least distance of two links [m]
    double edge = 0.0;            ///< least distance of a sole from an edge of the ground [m]
  } margin;

  /// Tolerated residual of inverse kinematics: of feet and COM, and of the guided hand at the end.
  struct Ik {
    double position = 0.0;  ///< [m]
    double rotation = 0.0;  ///< [rad]
    double hand = 0.0;      ///< [m]
  } ik;

  struct Tick {
    double period = 0.0;  ///< [s]
    int lookahead = 0;    ///< [ticks] from a planning request to its take-over
  } tick;

  struct Stabiliser {
    double k_dcm = 0.0;  ///< gain on the DCM error, k_p of docs/theory.md §6 [1/s]
  } stabiliser;

  Drive drive = Drive::pd;

  /// Servo gains of one joint [N·m/rad], [N·m·s/rad].
  struct Gains {
    double kp = 0.0;
    double kd = 0.0;
  };
  std::map<std::string, Gains> gains;  ///< by joint name

  /// Reads and validates a profile.
  /// @throws InputError file missing or not TOML; key missing, of the wrong type, not finite or out of its
  /// sensible range
  [[nodiscard]] static Profile load(const std::filesystem::path& file);
};

}  // namespace baton
