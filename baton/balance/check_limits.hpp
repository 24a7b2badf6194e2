/// Limits that the checks of all sensors share.
#pragma once

namespace baton::check {

inline constexpr double kMoves = 0.1;    ///< planned speed from which readings change: norm over the joints [rad/s]
inline constexpr double kSame = 0.02;    ///< longest time between two readings of a slow sensor [s]
inline constexpr double kMemory = 0.05;  ///< time constant with which contradictions add up [s]

/// How far beyond its range a joint may be measured: zero errors, play [rad].
inline constexpr double kBeyondRange = 0.3;

}  // namespace baton::check
