/// A humanoid as the other rooms know it: body parts, soles, joints, motors and limits, read once from a
/// model file and its profile.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "baton/math/polygon.hpp"
#include "baton/model/mujoco.hpp"
#include "baton/model/profile.hpp"
#include "baton/model/side.hpp"

namespace baton {

/// A geared DC motor at its joint: the torque left at speed ω is stall − damping·ω.
struct Motor {
  double stall = 0.0;    ///< [N·m]
  double damping = 0.0;  ///< back-EMF and gear friction, as the model's joint damping [N·m·s/rad]
  double no_load = 0.0;  ///< stall / damping [rad/s]

  /// Share of the stall torque in use when the links ask for `rigid` [N·m] at `speed` [rad/s]. The speed
  /// counts as a burden in both directions, so that the way back fits too (docs/theory.md §8).
  [[nodiscard]] double load(double rigid, double speed) const {
    return (std::abs(rigid) + damping * std::abs(speed)) / stall;
  }
};

/// A hinge joint with its motor.
struct Joint {
  std::string name;
  Range position;      ///< [rad]
  double speed = 0.0;  ///< largest |q̇|: the profile's share of the no-load speed [rad/s]
  Motor motor;
  Profile::Gains gains;
  double home = 0.0;  ///< [rad], of arm joints
};

/// Immutable. Configurations are q = (position 3, quaternion wxyz 4, joints n), velocities
/// q̇ = (linear in the world 3, angular in the trunk 3, joints n), as in MuJoCo.
/// Where the profile of a robot is that is given by its file, or by the name of a folder of `robots/`.
[[nodiscard]] std::filesystem::path profile_file(const std::string& name_or_file);

class RobotModel {
 public:
  /// @throws InputError the profile or the model cannot be used; the message says why
  explicit RobotModel(Profile profile);

  /// Loads a profile by file, or by the name of a folder of `robots/`.
  [[nodiscard]] static RobotModel load(const std::string& name_or_file);

  [[nodiscard]] const Profile& profile() const { return profile_; }
  [[nodiscard]] const mjModel& mj() const { return *model_; }
  [[nodiscard]] int nq() const { return model_->nq; }
  [[nodiscard]] int nv() const { return model_->nv; }
  [[nodiscard]] const std::vector<Joint>& joints() const { return joints_; }
  [[nodiscard]] double mass() const { return mass_; }
  /// Natural frequency of the pendulum at the nominal COM height [rad/s].
  [[nodiscard]] double omega() const { return omega_; }

  /// The inertial sensor in the frame of the body with the free joint, if it is fixed to that.
  [[nodiscard]] const std::optional<Pose>& imu_in_root() const { return imu_; }

  [[nodiscard]] int trunk_body() const { return trunk_body_; }
  [[nodiscard]] int foot_body(Side side) const { return foot_[side].body; }
  [[nodiscard]] int hand_body(Side side) const { return hand_[side].body; }
  [[nodiscard]] int shoulder_body(Side side) const { return shoulder_body_[side]; }
  /// Sole frame (origin: centre of the contact polygon, z: normal) in the foot's body.
  [[nodiscard]] const Pose& sole_in_foot(Side side) const { return foot_[side].frame; }
  [[nodiscard]] const Pose& hand_in_body(Side side) const { return hand_[side].frame; }
  /// Outline of the sole in its frame [m].
  [[nodiscard]] const ConvexPolygon& sole(Side side) const { return sole_[side]; }
  [[nodiscard]] const BySide<std::vector<int>>& sole_geoms() const { return sole_geoms_; }

  /// Joints (indices into `joints()`) that move one hand alone, and those from the root to a foot.
  [[nodiscard]] const std::vector<int>& arm(Side side) const { return arm_[side]; }
  [[nodiscard]] const std::vector<int>& leg(Side side) const { return leg_[side]; }
  /// Degrees of freedom that move a body: 1 where the chain from the root holds the dof.
  [[nodiscard]] const std::vector<int>& dofs_to(int body) const { return dofs_to_[static_cast<std::size_t>(body)]; }
  /// An arm of fewer than six joints follows the hand's position only.
  [[nodiscard]] bool hand_has_attitude(Side side) const { return arm_[side].size() >= 6; }

  /// The model's text (MJCF), to be composed with a world.
  [[nodiscard]] SpecPtr spec() const;

 private:
  struct Frame {
    int body = -1;
    Pose frame;
  };
  [[nodiscard]] Frame site_frame(const std::string& site, const std::string& owner) const;
  void read_joints(const std::string& owner);
  void read_sole(Side side);
  [[nodiscard]] std::vector<int> chain(int body) const;

  Profile profile_;
  ModelPtr model_;
  std::vector<Joint> joints_;
  double mass_ = 0.0;
  double omega_ = 0.0;
  int trunk_body_ = -1;
  std::optional<Pose> imu_;
  BySide<Frame> foot_;
  BySide<Frame> hand_;
  BySide<int> shoulder_body_;
  BySide<ConvexPolygon> sole_;
  BySide<std::vector<int>> sole_geoms_;
  BySide<std::vector<int>> arm_;
  BySide<std::vector<int>> leg_;
  std::vector<std::vector<int>> dofs_to_;
};

/// Folder that holds `robots/`, `worlds/` and the page: $BATON_SHARE, else the one compiled in.
[[nodiscard]] std::filesystem::path share_dir();

}  // namespace baton
