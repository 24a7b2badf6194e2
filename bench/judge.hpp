/// Detects failed motions by the same external criteria for every controller.
#pragma once

#include <array>
#include <optional>
#include <string_view>

#include "baton/model/contact.hpp"

namespace baton::bench {

enum class Cause {
  following,  ///< feet or COM are off their targets
  joint,      ///< a joint exceeds its range or speed
  collision,  ///< links or soles penetrate each other
  zmp,        ///< whole-body ZMP outside the support: the robot tips over
};
inline constexpr std::size_t kCauses = 4;

[[nodiscard]] constexpr std::string_view to_string(Cause cause) {
  constexpr std::array<std::string_view, kCauses> names{"cannot follow", "joint", "collision", "zmp"};
  return names[static_cast<std::size_t>(cause)];
}

/// Judges one configuration after another, without the plan's margins: a failure here is one on the robot. A cause must
/// last 20 ms, so that the rounding of a single tick does not count.
class Judge {
 public:
  /// @param robot must outlive this object
  explicit Judge(const RobotModel& robot);

  /// @param q configuration at this tick
  /// @param sole, com targets at this tick
  /// @param contact intended stance soles
  /// @returns the cause, if the robot has just failed
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
  int held_;                           ///< least ticks a cause must last
  std::optional<Seen> last_, before_;  ///< the middle sample is judged: its derivatives need both neighbours
  std::array<int, kCauses> since_{};
  long ticks_ = 0;
  bool collides_ = false;
  VecX dq_, ddq_, dq_next_, force_;
};

}  // namespace baton::bench
