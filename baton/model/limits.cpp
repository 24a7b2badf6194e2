#include "baton/model/limits.hpp"

#include <algorithm>

namespace baton {
namespace {

constexpr double kUnevenZmp = 2.0;         ///< factor on the planned ZMP's margin on uneven ground
constexpr double kPushAcceleration = 1.5;  ///< factor on joint acceleration in a capture step
constexpr double kPushHeat = 1.25;         ///< largest rise of a winding's temperature in a capture step
constexpr double kPushSwing = 0.7;         ///< factor on swing height and shortest swing time in a capture step

}  // namespace

Limits Limits::normal(const Profile& profile) {
  return {.zmp_plan = profile.margin.zmp_plan,
          .zmp_outward = profile.margin.zmp_outward,
          .zmp_verify = profile.margin.zmp_verify,
          .joint = profile.margin.joint,
          .torque = profile.margin.torque,
          .acceleration = profile.margin.acceleration,
          .heat = 1.0,
          .friction = profile.margin.friction,
          .self_collision = profile.margin.self_collision,
          .swing_clearance = profile.swing.clearance,
          .swing_time = profile.swing.time};
}

Limits Limits::uneven_ground(const Profile& profile) {
  Limits limits = normal(profile);
  limits.zmp_plan = std::min(kUnevenZmp * limits.zmp_plan, profile.margin.stand_on);
  return limits;
}

Limits Limits::push_recovery(const Profile& profile) {
  Limits limits = normal(profile);
  limits.zmp_plan = limits.zmp_outward = profile.margin.zmp_feedback;
  limits.torque = 1.0;
  limits.heat = kPushHeat;
  limits.acceleration *= kPushAcceleration;
  limits.swing_clearance *= kPushSwing;
  limits.swing_time *= kPushSwing;
  return limits;
}

}  // namespace baton
