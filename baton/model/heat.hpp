/// Temperature of the motors' windings by the I²t model with two time constants (docs/theory.md §10): what a torque
/// does to it, and what a torque held for ever leads to.
#pragma once

#include <limits>
#include <vector>

#include "baton/math/pose.hpp"

namespace baton {

class RobotModel;

/// Thermal constants of a motor, as its data sheet has them. The default never gets warm.
struct Thermal {
  /// Torque sustained for ever in still air [share of the stall torque].
  double continuous = std::numeric_limits<double>::infinity();
  double winding = 0.2;        ///< share of the final rise that is between winding and housing
  double winding_time = 10.0;  ///< time constant of that share: of the winding [s]
  double housing_time = 450;   ///< time constant of the rest: of the whole motor [s]
};

/// Rise of a winding above the surroundings, in units of the rise permitted: 1 is the limit.
struct Warmth {
  double winding = 0.0;  ///< of the winding above its housing
  double housing = 0.0;  ///< of the housing

  [[nodiscard]] double total() const { return winding + housing; }
  bool operator==(const Warmth&) const = default;
};

/// What that rise becomes if a torque is held for ever.
/// @param torque of the winding's current [share of the stall torque]
[[nodiscard]] double steady(const Thermal& motor, double torque);

/// The warmth after a torque was constant for `time` [s]; exact.
/// @param torque of the winding's current [share of the stall torque]
[[nodiscard]] Warmth after(const Thermal& motor, const Warmth& before, double torque, double time);

/// Of all motors (n); empty: all are as cold as the surroundings.
using Heat = std::vector<Warmth>;

/// The motor that is nearest to its limit.
struct Hottest {
  int joint = -1;      ///< −1: none, all are cold
  double total = 0.0;  ///< its rise [permitted rise]
};
[[nodiscard]] Hottest hottest(const Heat& heat);

/// The same motors, each at least so warm that its rise is `total`.
[[nodiscard]] Heat at_least(Heat heat, double total);

/// The motors of one robot.
class HeatModel {
 public:
  /// The robot must outlive the object.
  explicit HeatModel(const RobotModel& robot);

  /// Whether any motor has thermal constants.
  [[nodiscard]] bool limited() const { return limited_; }
  [[nodiscard]] Heat cold() const { return Heat(motors_.size()); }

  /// Advances by one tick. Allocates nothing.
  /// @param heat of all motors (n)
  /// @param torque of the currents, constant during the tick (n) [N·m]: without back-EMF, which takes voltage
  void step(Heat& heat, const VecX& torque) const;

  /// The motor that gets the hottest if these torques are held for ever.
  [[nodiscard]] Hottest held(const VecX& torque) const;

 private:
  /// A motor, and what one tick changes.
  struct Part {
    Thermal thermal;
    double stall = 0.0;         ///< [N·m]
    double winding_step = 0.0;  ///< 1 − exp(−period / winding_time)
    double housing_step = 0.0;
  };
  std::vector<Part> motors_;
  bool limited_ = false;
};

}  // namespace baton
