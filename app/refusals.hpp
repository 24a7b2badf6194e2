/// Recent refusals, for the log and the page.
#pragma once

#include <optional>

#include "baton/cockpit/frame.hpp"
#include "baton/navigate/navigator.hpp"

namespace baton::app {

class Refusals {
 public:
  /// Call after every tick.
  void look(const Navigator& navigator);

  /// The newest refusal.
  [[nodiscard]] const std::optional<Refusal>& newest() const { return newest_; }
  /// Number of refusals since the start.
  [[nodiscard]] int count() const { return count_; }
  /// A part that was refused three times in a row without any motion in between.
  [[nodiscard]] const std::optional<Stuck>& stuck() const { return stuck_; }

 private:
  std::optional<Refusal> newest_;
  int count_ = 0;
  Part part_ = Part::trunk;  ///< last refused part
  Command refused_;          ///< last refused command
  bool changed_ = false;     ///< the command has changed since
  int times_ = 0;            ///< consecutive refusals
  bool retrace_ = false;     ///< retrace was refused since the last motion
  bool home_ = false;        ///< going home was refused since the last motion
  std::optional<Stuck> stuck_;
};

}  // namespace baton::app
