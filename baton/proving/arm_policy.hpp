/// Something that drives arms at random, as a learned policy would: a piece of a smooth path every half second, known a
/// second ahead. And how well the arms follow it.
#pragma once

#include "baton/guide/arm_trajectory.hpp"
#include "baton/model/kinematics.hpp"
#include "baton/proving/dice.hpp"
#include "baton/run/sink.hpp"

namespace baton {

class ArmPolicy : public Sink {
 public:
  /// Targets within 0.6 rad of the home pose, 1.5 s apart. A function of its seed. The robot must outlive the object.
  ArmPolicy(const RobotModel& robot, std::uint64_t seed);

  /// Targets that are known at `t` and were not at the last call; null: none.
  [[nodiscard]] const ArmTargets* next(double t);

  void on_tick(const TickRecord& record) override;

  /// Ticks of each arm since the first target was due, while it was asked for targets, but for those in which the
  /// stick guided that hand; and of these, those in which all of its joints were within 0.05 rad of theirs, by the
  /// truth.
  [[nodiscard]] long ticks() const { return ticks_; }
  [[nodiscard]] long on_target() const { return on_target_; }

 private:
  /// Whether the way to the next target is free of other links.
  [[nodiscard]] bool is_free();

  const RobotModel* robot_;
  Kinematics kinematics_;
  VecX home_;  ///< configuration of the stance (nq)
  Dice dice_;
  std::vector<int> joints_;
  VecX from_, to_;          ///< of the path under way [rad]
  double began_ = 0.0;      ///< when it begins [s]
  double known_ = 0.0;      ///< up to when targets were given [s]
  double asked_at_ = -1.0;  ///< the last time that targets were asked for [s]
  ArmTargets targets_;
  long ticks_ = 0;
  long on_target_ = 0;
};

}  // namespace baton
