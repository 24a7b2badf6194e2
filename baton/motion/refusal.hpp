/// Why a command has no motion, and how far a motion stays from each limit.
#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "baton/motion/posture.hpp"
#include "baton/motion/reason.hpp"

namespace baton {

/// A command that has no verified motion.
struct Refusal {
  Reason reason = Reason::not_finite;
  Part part = Part::trunk;  ///< the navigation point concerned
  double value = 0.0;       ///< what the motion would have needed
  double limit = 0.0;       ///< what is allowed
  std::string where;        ///< joint, link pair or place; may be empty
  double t = 0.0;           ///< when a limit is exceeded first, from the start of the motion [s]
  /// The reason behind it: part, value and limit are then those of that.
  std::optional<Reason> cause{};
};

/// A refusal that has another one behind it.
[[nodiscard]] inline Refusal refusal_by(Reason reason, const Refusal& cause) {
  return {reason, cause.part, cause.value, cause.limit, "", 0.0, cause.reason};
}

/// `where`, or the name of the cause: what plans and logs say of the place.
[[nodiscard]] inline std::string_view place(const Refusal& refusal) {
  return refusal.cause ? to_string(*refusal.cause) : std::string_view(refusal.where);
}

/// The worst value of one quantity along a verified motion.
struct Margin {
  Reason quantity = Reason::zmp;
  double value = 0.0;
  double limit = 0.0;
  double t = 0.0;     ///< when, from the start of the motion [s]
  std::string where;  ///< joint, link pair; may be empty
};

/// Proof that a motion was verified whole.
struct Certificate {
  std::vector<Margin> margins;
};

}  // namespace baton
