/// When a motion is bankrupt: seen from outside, the same for whoever made it.
#pragma once

#include <array>
#include <optional>
#include <string_view>

#include "baton/model/contact.hpp"

namespace baton::bench {

enum class Cause {
  following,  ///< feet or COM are not where they should be
  joint,      ///< a joint beyond its range or its speed
  collision,  ///< links, or soles, in each other
  zmp,        ///< the whole body's ZMP out of the support: it tips over
};
inline constexpr std::size_t kCauses = 4;

[[nodiscard]] constexpr std::string_view to_string(Cause cause) {
  constexpr std::array<std::string_view, kCauses> names{"cannot follow", "joint", "collision", "zmp"};
  return names[static_cast<std::size_t>(cause)];
}

/// Looks at one configuration after another. Without any of a plan's margins: what is bankrupt here is so on the robot.
/// Each cause must last for 20 ms on end, so that a single tick's rounding does not count.
class Judge {
 public:
  /// @param robot must outlive the object
  explicit Judge(const RobotModel& robot);

  /// @param q configuration at this tick
  /// @param sole, com where they should be at this tick
  /// @param contact soles that are meant to stand then
  /// @returns the cause, if the robot has just become bankrupt
  std::optional<Cause> see(const VecX& q, const BySide<Pose>& sole, const Vec3& com, const BySide<bool>& contact);

 private:
  struct Seen {
    VecX q;
    BySide<Pose> sole;
    Vec3 com;
    BySide<bool> contact;
  };
  [[nodiscard]] bool lasts(Cause cause, bool bad);

  const RobotModel* robot_;
  Kinematics kinematics_;
  double dt_;
  int held_;                           ///< ticks that a cause must last
  std::optional<Seen> last_, before_;  ///< the middle one is judged: its derivatives need both neighbours
  std::array<int, kCauses> since_{};
  long ticks_ = 0;
  bool collides_ = false;
  VecX dq_, ddq_, dq_next_, force_;
};

}  // namespace baton::bench
