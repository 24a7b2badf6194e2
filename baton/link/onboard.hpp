/// A navigator at the robot's end, so that balance and planning never wait for a network. It follows a driver's
/// commands while they are fresh; without, the motion under way ends, a foot in the air comes down, and the robot
/// rests.
#pragma once

#include <cstdint>
#include <limits>
#include <memory>

#include "baton/link/message.hpp"
#include "baton/run/session.hpp"

namespace baton::link {

class Onboard : private Sink {
 public:
  struct Parameters {
    NavigationOptions navigation{};
    bool lock_step = true;                 ///< each tick has a command of its own, which is fresh
    std::unique_ptr<Planning> planning{};  ///< null: synchronous, in `step`
  };

  /// How long after the newest tick that its driver knew of a command is fresh [s]: it is as old as that tick is.
  static constexpr double kFresh = 0.5;

  /// Begins with the joints where they are (`engage`). `model`, `world` and `robot` must outlive this object.
  /// @throws InputError the robot does not stand on both soles
  Onboard(const RobotModel& model, const World& world, Robot& robot, Parameters parameters);

  /// The stick's position, if it is not older than the last one. It knows of no tick that has not been.
  void hear(const StickPosition& stick) {
    if (!stick_ || stick.seen >= stick_->seen) stick_ = stick;
  }
  /// Drives the arms, from the next tick on. A stick that is too old lets go of them.
  /// @throws InputError the targets are none of this robot, or the stick is too old
  void drive_arms(const ArmTargets& targets);
  /// So much time has passed without ticks: what the driver knew of before is older by that [s].
  void lose(double time);
  /// While `held`, the stick counts as centred, and nothing drives the arms.
  void hold(bool held) { held_ = held; }
  /// There is no driver any more.
  void driver_gone();

  /// Runs a tick.
  /// @param battery of the robot, for who reads the tick: 0 to 1; NaN: unknown
  /// @returns what was done: `tick`
  const Tick& step(double battery = std::numeric_limits<double>::quiet_NaN());
  /// The last tick.
  [[nodiscard]] const Tick& tick() const { return tick_; }

  /// Ticks so far.
  [[nodiscard]] std::uint64_t ticks() const { return ticks_; }
  /// Whether the stick was not followed in the last of them: too old, or on hold.
  [[nodiscard]] bool stale() const { return tick_.stale; }
  /// Whether the robot is at rest on both feet.
  [[nodiscard]] bool rests() const;
  [[nodiscard]] const Session& session() const { return session_; }
  [[nodiscard]] Session& session() { return session_; }

 private:
  /// How long ago the newest tick was that its driver knew of [s].
  [[nodiscard]] double age(const StickPosition& stick) const;
  void on_tick(const TickRecord& record) override;
  void on_planning(PlanningEvent event) override { tick_.planning.push_back(event); }

  const RobotModel* model_;
  Parameters parameters_;
  Session session_;
  std::optional<StickPosition> stick_;
  bool held_ = false;
  double lost_ = 0.0;          ///< time that was left out since the tick that the stick's driver knew of [s]
  std::uint64_t lost_at_ = 0;  ///< ticks before the last of it
  Tick tick_;
  std::uint64_t ticks_ = 0;
};

}  // namespace baton::link
