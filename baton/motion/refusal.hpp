/// Refusals of commands, and certificates of motions.
#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "baton/motion/posture.hpp"
#include "baton/motion/reason.hpp"

namespace baton {

/// Why a command has no verified motion.
struct Refusal {
  Reason reason = Reason::not_finite;
  Part part = Part::trunk;  ///< body part concerned
  double value = 0.0;       ///< value that violates the limit
  double limit = 0.0;       ///< what is allowed
  std::string where;        ///< joint, link pair or place; may be empty
  double t = 0.0;           ///< time of the first violation, from the start of the motion [s]
  /// The underlying reason, if there is one. Part, value and limit are then its.
  std::optional<Reason> cause{};
};

/// A refusal caused by another one.
[[nodiscard]] inline Refusal refusal_by(Reason reason, const Refusal& cause) {
  return {reason, cause.part, cause.value, cause.limit, "", 0.0, cause.reason};
}

/// Name of the cause if there is one, else `where`, for plans and logs.
[[nodiscard]] inline std::string_view place(const Refusal& refusal) {
  return refusal.cause ? to_string(*refusal.cause) : std::string_view(refusal.where);
}

/// The worst value of one quantity along a verified motion.
struct Margin {
  Reason quantity = Reason::zmp;
  double value = 0.0;
  double limit = 0.0;
  double t = 0.0;     ///< time of the worst value, from the start of the motion [s]
  std::string where;  ///< joint or link pair; may be empty
};

/// Result of a verification that passed: the worst value of every quantity.
struct Certificate {
  std::vector<Margin> margins;
};

}  // namespace baton
