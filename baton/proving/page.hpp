/// What an operator reads on the page (docs/page.md): all that it knows of the navigator.
#pragma once

#include "baton/cockpit/frame.hpp"
#include "baton/run/operator.hpp"

namespace baton {

/// Members of the page's `state` message.
struct Page {
  double t = 0.0;  ///< [s]
  Activity activity = Activity::rest;
  BySide<bool> contact{true, true};  ///< stance soles
  bool limited = false;              ///< the motion under way does only part of the request
  int refusals = 0;                  ///< since the start
};

class PageReader {
 public:
  /// Call after every tick.
  [[nodiscard]] const Page& read(const Operator::View& view);

 private:
  Page page_;
};

}  // namespace baton
