/// What was refused of late, for the log and the page.
#pragma once

#include <optional>

#include "baton/cockpit/frame.hpp"
#include "baton/navigate/navigator.hpp"

namespace baton::app {

class Refusals {
 public:
  /// To be called after every tick.
  void look(const Navigator& navigator);

  /// The newest.
  [[nodiscard]] const std::optional<Refusal>& newest() const { return newest_; }
  /// Since the start.
  [[nodiscard]] int count() const { return count_; }
  /// A part that was refused three times in a row, with no motion of any part since the first.
  [[nodiscard]] const std::optional<Stuck>& stuck() const { return stuck_; }

 private:
  std::optional<Refusal> newest_;
  int count_ = 0;
  Part part_ = Part::trunk;  ///< that was refused last
  Command refused_;          ///< what was
  bool changed_ = false;     ///< something else was asked for since
  int times_ = 0;            ///< how often in a row
  bool retrace_ = false;     ///< was refused since the last motion
  bool home_ = false;        ///< the same
  std::optional<Stuck> stuck_;
};

}  // namespace baton::app
