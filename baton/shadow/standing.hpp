/// Where measurements and model disagree while the robot stands still on both soles.
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "baton/balance/sole_wrenches.hpp"
#include "baton/balance/state.hpp"
#include "baton/balance/state_source.hpp"
#include "baton/shadow/statistic.hpp"

namespace baton::shadow {

/// One number that is 0 if measurements and model agree.
struct Comparison {
  std::string what;
  std::string unit;
  double limit = 0.0;  ///< of the mean: what the robot's profile says of its sensors and actuators may explain so much
  std::string cause;   ///< what more than that may come from
  /// Where the other component of the same vector is, from here; the limit is that of the vector. 0: it is no vector.
  int other = 0;
  Statistic value{};
};

class Standing {
 public:
  /// The robot must outlive the object.
  Standing(const RobotModel& robot, StateSource source);

  /// Compares, once a tick.
  /// @param t time of it [s]
  /// @param measured as the robot gave it
  /// @param state estimated from it, with the contact wrenches
  void compare(double t, const Measurement& measured, const State& state);
  /// The robot does not stand still any more.
  void pause();

  [[nodiscard]] const std::vector<Comparison>& all() const { return all_; }
  /// Those beyond their limit; of a vector, its larger component.
  [[nodiscard]] std::vector<Comparison> disagreements() const;
  /// For how long it was compared [s].
  [[nodiscard]] double seconds() const;
  /// Whether that is long enough for means to say something.
  [[nodiscard]] bool enough() const { return seconds() >= 0.5; }
  /// How fast the IMU's yaw turns against the soles [rad/s]; 0 before it has stood still for `kDrifting`.
  [[nodiscard]] double yaw_drift() const;
  [[nodiscard]] double yaw_drift_limit() const;
  static constexpr double kDrifting = 5.0;  ///< [s]

 private:
  Comparison& of(std::string_view what);
  void compare_torques(double t, const Measurement& measured, const State& state);
  void compare_forces(double t, const State& state);
  void compare_attitude(double t, const Measurement& measured, const State& state);

  /// Least squares of a straight line through the yaw over time.
  struct Line {
    double n = 0.0, t = 0.0, y = 0.0, tt = 0.0, ty = 0.0;
    double first = 0.0;  ///< yaw [rad]
    double began = 0.0;  ///< [s]
  };

  /// What all lines together tell.
  struct Drift {
    double time = 0.0, tt = 0.0, ty = 0.0;
  };
  [[nodiscard]] Drift drift() const;

  const RobotModel* robot_;
  StateSource source_;
  Kinematics kinematics_;
  SoleWrenches wrenches_;
  VecX zero_;                    ///< (nv)
  VecX force_;                   ///< (nv)
  VecX torque_;                  ///< by the model (n) [N·m]
  std::vector<Comparison> all_;  ///< the joints' torques first
  Line line_;
  Drift drift_;  ///< by the lines before
  long ticks_ = 0;
};

}  // namespace baton::shadow
