/// How many motions a run committed, cut short and refused, and how far they went.
#pragma once

#include <limits>
#include <map>
#include <nlohmann/json.hpp>
#include <string>

#include "baton/navigate/navigator.hpp"

namespace baton {

class SegmentCount {
 public:
  /// One tick.
  /// @param com of the robot [m]
  void add(const Navigator& navigator, const Vec3& com);

  /// {"committed", "caught", "slips", "shrunk", "refused"}.
  [[nodiscard]] nlohmann::json json() const;

  /// Horizontal displacement of the COM, summed over motions [m].
  /// @param com where it is now
  [[nodiscard]] double travel(const Vec3& com) const;

  /// Least certified distance of the planned ZMP inside the support polygon [m]; infinite without a motion.
  [[nodiscard]] double zmp_margin() const { return zmp_margin_; }

 private:
  bool executing_ = false;
  Vec3 com_start_ = Vec3::Zero();  ///< where the COM was when the motion began [m]
  double travel_ = 0.0;            ///< by motions that are over [m]
  long committed_ = 0;
  long caught_ = 0;
  long slips_ = 0;
  std::map<std::string, long> shrunk_;  ///< reason → motions that are a part of the way
  std::map<std::string, long> refused_;
  Command command_;           ///< of the tick before
  std::string last_refused_;  ///< reason and part, since the command changed
  double zmp_margin_ = std::numeric_limits<double>::infinity();
};

}  // namespace baton
