/// The robot model: body parts, soles, joints and motors, read once from a model file and its profile.
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

/// A geared DC motor, seen from the joint: the torque available at speed ω is stall − damping·ω.
struct Motor {
  double stall = 0.0;    ///< [N·m]
  double damping = 0.0;  ///< back-EMF and gear friction, as the model's joint damping [N·m·s/rad]
  double no_load = 0.0;  ///< as the profile says, else stall / damping [rad/s]
  Thermal thermal;

  /// Share of the stall torque used for the rigid-body torque `rigid` [N·m] at `speed` [rad/s]. Damping counts as a
  /// load in both directions, so that a motion's reverse passes too (docs/theory.md §8).
  [[nodiscard]] double load(double rigid, double speed) const {
    return (std::abs(rigid) + damping * std::abs(speed)) / stall;
  }
};

/// A hinge joint with its motor.
struct Joint {
  std::string name;
  Range position;      ///< [rad]
  double speed = 0.0;  ///< limit of |q̇|: the profile's share of the no-load speed [rad/s]
  Motor motor;
  Profile::Gains gains;
  double home = 0.0;  ///< angle at rest of a joint that is not a leg's, inside its range by the profile's margin [rad]
};

/// The profile of a robot that is given by that file, or by the name of a folder in `robots/`.
[[nodiscard]] std::filesystem::path profile_file(const std::string& name_or_file);

/// Immutable. Configurations (nq) are q = (root position 3, root quaternion wxyz 4, joints n); velocities (nv) are
/// q̇ = (root linear in the world 3, root angular in the root frame 3, joints n), as in MuJoCo.
class RobotModel {
 public:
  /// @throws InputError profile or model unusable; the message says why
  explicit RobotModel(Profile profile);

  /// Loads a robot by the file of its profile, or by the name of a folder in `robots/`.
  [[nodiscard]] static RobotModel load(const std::string& name_or_file);

  [[nodiscard]] const Profile& profile() const { return profile_; }
  [[nodiscard]] const mjModel& mj() const { return *model_; }
  [[nodiscard]] int nq() const { return model_->nq; }
  [[nodiscard]] int nv() const { return model_->nv; }
  [[nodiscard]] const std::vector<Joint>& joints() const { return joints_; }
  [[nodiscard]] double mass() const { return mass_; }
  /// Natural frequency of the linear inverted pendulum at the nominal COM height [rad/s].
  [[nodiscard]] double omega() const { return omega_; }

  /// IMU frame in the root (the body with the free joint). None if the profile names no IMU there.
  [[nodiscard]] const std::optional<Pose>& imu_in_root() const { return imu_; }

  [[nodiscard]] int trunk_body() const { return trunk_body_; }
  [[nodiscard]] int foot_body(Side side) const { return foot_[side].body; }
  [[nodiscard]] int hand_body(Side side) const { return hand_[side].body; }
  [[nodiscard]] int shoulder_body(Side side) const { return shoulder_body_[side]; }
  /// Sole frame in the foot body: origin at the centre of the contact polygon, x forward, z normal.
  [[nodiscard]] const Pose& sole_in_foot(Side side) const { return foot_[side].frame; }
  [[nodiscard]] const Pose& hand_in_body(Side side) const { return hand_[side].frame; }
  /// Outline of the sole in the sole frame [m].
  [[nodiscard]] const ConvexPolygon& sole(Side side) const { return sole_[side]; }
  /// Half of the narrower sole's width: what errors of ZMP and DCM are compared with [m].
  [[nodiscard]] double sole_half_width() const { return sole_half_width_; }
  /// The part of it where the whole weight can be without too much torque at the leg's last two joints, the ankle: for
  /// each of them |u · ((p − a) × m g e_z)| ≤ 0.85 × the torque that the profile allows, with axis u and anchor a [m].
  [[nodiscard]] const ConvexPolygon& support(Side side) const { return support_[side]; }
  [[nodiscard]] const BySide<std::vector<int>>& sole_geoms() const { return sole_geoms_; }

  /// Joints that move this hand but not the other, and the same for the feet: indices into `joints()`.
  [[nodiscard]] const std::vector<int>& arm(Side side) const { return arm_[side]; }
  [[nodiscard]] const std::vector<int>& leg(Side side) const { return leg_[side]; }
  /// Joints of neither leg nor arm: waist, neck. They keep their home angle.
  [[nodiscard]] const std::vector<int>& idle() const { return idle_; }
  /// Degrees of freedom that move a body: indices of those on the chain from the root to it.
  [[nodiscard]] const std::vector<int>& dofs_to(int body) const { return dofs_to_[static_cast<std::size_t>(body)]; }
  /// Whether the hand can be given an attitude: its arm has at least six joints.
  [[nodiscard]] bool hand_has_attitude(Side side) const { return arm_[side].size() >= 6; }

  /// The model's specification, to be combined with a world.
  [[nodiscard]] SpecPtr spec(Visuals visuals = Visuals::keep) const;

 private:
  struct Frame {
    int body = -1;
    Pose frame;
  };
  [[nodiscard]] Frame site_frame(const std::string& site, const std::string& owner) const;
  void read_joints(const std::string& owner);
  void read_sole(Side side);
  void limit_support(Side side);
  [[nodiscard]] std::vector<int> chain(int body) const;
  /// Joints that move `body` but not its `opposite`.
  [[nodiscard]] std::vector<int> joints_of_one(int body, int opposite) const;

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
  double sole_half_width_ = 0.0;
  BySide<ConvexPolygon> support_;
  BySide<std::vector<int>> sole_geoms_;
  BySide<std::vector<int>> arm_;
  BySide<std::vector<int>> leg_;
  std::vector<int> idle_;
  std::vector<std::vector<int>> dofs_to_;
};

/// Folder of `robots/`, `worlds/` and the web page: $BATON_SHARE, else that of `use_share_dir`, else the one compiled
/// in.
[[nodiscard]] std::filesystem::path share_dir();
/// For a program that is installed where it was not compiled for. Call it before any other thread asks for the folder.
void use_share_dir(std::filesystem::path folder);

}  // namespace baton
