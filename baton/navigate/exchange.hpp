/// The exchange with the planner: what was asked, what is awaited, and what was refused.
#pragma once

#include <memory>

#include "baton/plan/request.hpp"

namespace baton {

/// The newest request and its answer.
struct Exchange {
  long asked_at = 0;                       ///< tick of the newest request; 0: ask again at once
  long take_over = 0;                      ///< its take-over tick
  bool awaited = false;                    ///< the answer is awaited
  bool for_stop = false;                   ///< the request is a stop
  bool countered = false;                  ///< a stop was pressed since the request
  std::shared_ptr<const Answer> answer{};  ///< the answer, once it is there
  /// The command that was answered last since the motion under way began.
  Command answered;
  long dropped = 0;      ///< requests whose answer was not there at the take-over
  long stick_again = 0;  ///< until then, arms that are driven from outside come before `in_vain`
  Command in_vain;       ///< the newest command that had no motion
  long arms_again = 0;   ///< earliest tick of the next request for the arms alone
  int late = 0;          ///< consecutive late answers at rest; each doubles the lookahead of the next request
};

/// The newest refusal.
struct LastRefusal {
  std::shared_ptr<const Refusal> refusal{};  ///< while the command still stands; else null
  Command command;                           ///< the command refused
  Pose anchor;                               ///< planning frame at the refusal
  bool at_rest = false;
  long retry_at = 0;  ///< earliest tick of the next request from rest
};

}  // namespace baton
