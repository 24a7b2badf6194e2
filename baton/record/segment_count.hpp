/// Counts committed, shrunk and refused motions, and the distance travelled.
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
  /// @param com the robot's COM [m]
  void add(const Navigator& navigator, const Vec3& com);

  /// {"committed", "caught", "slips", "shrunk", "refused"}.
  [[nodiscard]] nlohmann::json json() const;

  /// Horizontal displacement of the COM, summed over motions [m].
  /// @param com current COM
  [[nodiscard]] double travel(const Vec3& com) const;

  /// Least certified margin of the planned ZMP inside the support polygon [m]; infinite without a motion.
  [[nodiscard]] double zmp_margin() const { return zmp_margin_; }

 private:
  bool executing_ = false;
  Vec3 com_start_ = Vec3::Zero();  ///< COM at the start of the motion [m]
  double travel_ = 0.0;            ///< of completed motions [m]
  long committed_ = 0;
  long caught_ = 0;
  long slips_ = 0;
  std::map<std::string, long> shrunk_;  ///< reason → number of shrunk motions
  std::map<std::string, long> refused_;
  Command command_;           ///< of the previous tick
  std::string last_refused_;  ///< reason and part of the last refusal since the command changed
  double zmp_margin_ = std::numeric_limits<double>::infinity();
};

}  // namespace baton
