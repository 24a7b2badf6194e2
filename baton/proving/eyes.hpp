/// The robot and the page as a person sees them: with errors that last, and acted upon only after a reaction time.
#pragma once

#include <array>
#include <deque>
#include <optional>
#include <random>

#include "baton/proving/page.hpp"

namespace baton {

/// Position in the world frame [m] and yaw [rad].
using Place = Eigen::Vector4d;

/// What is seen of the robot.
struct Sight {
  BySide<Place> sole{Place::Zero(), Place::Zero()};
  Place trunk = Place::Zero();     ///< position of the COM, yaw of the trunk
  Place hand = Place::Zero();      ///< left; no yaw
  Place shoulder = Place::Zero();  ///< left; no yaw

  [[nodiscard]] std::array<Place*, 5> all() { return {&sole.left, &sole.right, &trunk, &hand, &shoulder}; }
  /// Middle between the feet [m], and their mean yaw [rad].
  [[nodiscard]] Vec2 feet() const { return 0.5 * (sole.left + sole.right).head<2>(); }
  [[nodiscard]] double heading() const { return 0.5 * (sole.left[3] + sole.right[3]); }
};

/// Robot and page at one time, `Page::t`.
struct Seen {
  Sight sight;
  Page page;
};

class Eyes {
 public:
  /// Each coordinate of each thing errs by a first-order Gauss-Markov process of its own.
  struct Parameters {
    double error = 0.005;           ///< standard deviation of positions [m]
    double yaw_error = 0.0349;      ///< of yaws: 2° [rad]
    double correlation_time = 1.0;  ///< [s]
    double reaction = 0.25;         ///< from what is seen to what is done about it, a whole number of ticks [s]

    /// Positions that err by so much, and yaws in proportion.
    [[nodiscard]] static Parameters with_error(double error);
  };

  /// @param robot must outlive this object
  Eyes(const RobotModel& robot, std::uint64_t seed, const Parameters& parameters);

  /// Looks at robot and page, once per tick.
  /// @returns what was seen a reaction time ago; null if nothing was seen then
  /// @throws std::logic_error the robot has no truth
  [[nodiscard]] const Seen* look(const Operator::View& view);

  /// That sight, with the motion of trunk and arm before it continued for `ahead` [s]. Call after `look` has returned
  /// one.
  [[nodiscard]] Sight foresee(double ahead) const;

 private:
  [[nodiscard]] Sight truth(const Truth& truth);

  Parameters parameters_;
  double period_;
  std::size_t delay_;  ///< [ticks]
  std::size_t kept_;   ///< sights kept to see motion [ticks]
  std::mt19937_64 random_;
  std::normal_distribution<double> normal_;
  Kinematics kinematics_;
  PageReader page_;
  std::optional<Sight> error_;  ///< as of now
  std::deque<Seen> seen_;       ///< newest last
};

/// Mean of what is seen of a thing that stands still, in the best way for errors that are correlated in time; moves of
/// known size in between are taken into account.
class Mean {
 public:
  explicit Mean(const Eyes::Parameters& parameters) : parameters_(parameters) {}

  /// The thing is seen standing still.
  /// @param t [s], not before that of the last call
  void see(double t, const Place& place);
  /// It has moved since.
  /// @param doubt standard deviation of `by` [m]
  void moved(const Vec3& by, double doubt);
  /// It has moved who knows where.
  void forget() { weight_ = 0.0; }

  /// Requires a sight.
  [[nodiscard]] const Place& place() const { return mean_; }
  /// Standard deviation of each coordinate of its position [m]; infinite without a sight.
  [[nodiscard]] double doubt() const { return parameters_.error / std::sqrt(weight_); }

 private:
  Eyes::Parameters parameters_;
  double weight_ = 0.0;  ///< number of independent sights that the mean is as good as
  double t_ = 0.0;       ///< of the last sight [s]
  Place last_ = Place::Zero();
  Place mean_ = Place::Zero();
};

}  // namespace baton
