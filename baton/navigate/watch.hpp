/// What the measurements say of the robot, once a tick: where it is, whether it may be moved, how far it is off its
/// plan.
#pragma once

#include "baton/balance/odometry.hpp"
#include "baton/balance/state.hpp"
#include "baton/plan/request.hpp"

namespace baton {

/// Whether the robot may be moved. It sees for itself that it falls or is lifted off the ground.
enum class Guard {
  armed,
  lifted,    ///< no sole carries: nothing new is begun until it stands again and the stick is centred
  fallen,    ///< the plan is dropped and the motors are soft
  stood_up,  ///< after a fall, on its feet and still: armed as soon as the stick is centred
};

class Watch {
 public:
  /// Robot and world must outlive the object.
  /// @param start posture that the robot stands in, at rest, in the world
  /// @throws InputError the robot lacks the sensors for that source
  Watch(const RobotModel& robot, const World& world, StateSource source, const Posture& start);

  /// The state, estimated from a measurement. Once a tick; throws only if a perfect state is to be used and the
  /// measurement has none.
  /// @param planned sample of this tick
  /// @param anchor planning frame in the world
  void estimate(const Measurement& measurement, const MotionSample& planned, const Pose& anchor);
  /// The same state in another planning frame, for a motion that has just been committed.
  void change_frame(const MotionSample& planned, const Pose& anchor);
  /// Brings guard, DCM error, slip and inclination up to date. Once a tick, after `estimate`.
  /// @param centred the stick is
  void judge(const MotionSample& planned, const Pose& anchor, bool centred);

  /// The robot stands again and may be moved.
  void arm();

  /// Not before the first `estimate`.
  [[nodiscard]] const State& state() const { return *state_; }
  [[nodiscard]] const Odometry& odometry() const { return odometry_; }
  [[nodiscard]] Guard guard() const { return guard_; }
  /// Whether the robot has fallen and is not armed again.
  [[nodiscard]] bool soft() const { return guard_ == Guard::fallen || guard_ == Guard::stood_up; }
  /// Whether the DCM is so far off that nothing new is begun: hysteresis from 0.02 to 0.01 of the nominal COM height.
  [[nodiscard]] bool disturbed() const { return disturbed_; }
  /// Estimated − planned DCM, along the axes of the world [m]; soles that slid have taken the plan along.
  [[nodiscard]] const Vec2& dcm_error() const { return dcm_error_; }
  /// Whether soles stand so far from where they were planned that the way back is lost.
  [[nodiscard]] bool slipped() const { return slip_.now; }
  /// Whether that was found in this tick: only soles that all touch the ground tell.
  [[nodiscard]] bool slip_found() const { return slip_.found; }
  [[nodiscard]] long slips() const { return slip_.count; }
  [[nodiscard]] double last_slip() const { return slip_.distance; }  ///< [m]
  /// Whether soles stood inclined against the plan of late.
  [[nodiscard]] bool uneven() const;

  /// How far the standing soles are from where they were planned, as one move of the planning frame.
  [[nodiscard]] Pose slid(const MotionSample& planned) const;
  /// The sole that stands inclined against the plan, as on an edge, while both feet are to stand.
  [[nodiscard]] std::optional<Terrain::Inclined> inclined_sole(const MotionSample& planned) const;
  /// Whether the COM is where the robot may rest.
  [[nodiscard]] bool supported() const;

 private:
  void update_guard(bool centred);
  void fall();
  void update_disturbed(const MotionSample& planned, const Pose& anchor);
  void update_slip(const MotionSample& planned, const Pose& anchor);
  void update_inclination(const MotionSample& planned);
  /// Whether it stands on both feet, still, so that it could be armed.
  [[nodiscard]] bool stands_upright() const;

  const RobotModel* robot_;
  Odometry odometry_;
  Estimator estimator_;
  const Measurement* measured_ = nullptr;
  const State* state_ = nullptr;
  Guard guard_ = Guard::armed;
  int guard_ticks_ = 0;  ///< for which the condition that would change the guard has held
  Vec2 dcm_error_ = Vec2::Zero();
  bool disturbed_ = false;
  struct Slip {
    bool now = false;
    bool found = false;  ///< in this tick
    long count = 0;
    double distance = 0.0;  ///< the last time [m]
  };
  Slip slip_;
  double inclination_ = 0.0;  ///< of a sole against the plan, the largest of late [rad]
};

}  // namespace baton
