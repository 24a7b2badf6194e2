/// What measurements tell about the robot, once a tick: where it is, whether it may be moved, how far it is off its
/// plan.
#pragma once

#include "baton/balance/odometry.hpp"
#include "baton/balance/sensor_check.hpp"
#include "baton/balance/state.hpp"
#include "baton/navigate/thermometer.hpp"
#include "baton/plan/request.hpp"

namespace baton {

/// Whether the robot may be moved. Falls and lifting are detected from measurements.
enum class Guard {
  armed,
  lifted,    ///< no sole carries: nothing new is begun until it stands again and the stick is centred
  fallen,    ///< the plan is dropped and the motors give no torque
  stood_up,  ///< after a fall, on its feet and still: armed as soon as the stick is centred
};

[[nodiscard]] constexpr std::string_view to_string(Guard guard) {
  constexpr std::array<std::string_view, 4> names{"armed", "lifted", "fallen", "stood_up"};
  return names[static_cast<std::size_t>(guard)];
}

class Watch {
 public:
  /// Robot and world must outlive the object.
  /// @param start posture that the robot stands in, at rest, in the world
  /// @throws InputError the robot lacks the sensors for that source
  Watch(const RobotModel& robot, const World& world, StateSource source, const Posture& start);

  /// Estimates the state, once a tick. Throws only with `StateSource::perfect`, if the measurement has no root pose.
  /// @param planned sample of this tick
  /// @param anchor planning frame in the world
  void estimate(const Measurement& measurement, const MotionSample& planned, const Pose& anchor);
  /// Re-expresses the state in the frame of a motion that was just committed, and updates the slip.
  void change_frame(const MotionSample& planned, const Pose& anchor);
  /// Updates guard, DCM error, slip and inclination, once a tick, after `estimate`.
  /// @param centred whether the stick is centred
  void judge(const MotionSample& planned, const Pose& anchor, bool centred);

  /// Updates the motors' heat, once a tick, last.
  /// @param commanded what the robot is told in this tick
  void warm(const JointTarget& commanded) { thermometer_.update(*measured_, commanded); }

  /// Says that the robot hangs, before the first tick: it is armed once it stands.
  void hang() { guard_ = Guard::lifted; }
  /// How far the robot stands by itself, from 0 to 1: 1, unless it was lifted and its soles carry less than half of its
  /// weight.
  [[nodiscard]] double stands() const;
  /// Re-arms the robot, once it stands again.
  void arm();

  /// Requires a previous `estimate`.
  [[nodiscard]] const State& state() const { return *state_; }
  [[nodiscard]] const Odometry& odometry() const { return odometry_; }
  [[nodiscard]] Guard guard() const { return guard_; }
  /// Whether the robot has fallen and is not armed again.
  [[nodiscard]] bool soft() const { return guard_ == Guard::fallen || guard_ == Guard::stood_up; }
  /// Plausibility of the sensors' readings.
  [[nodiscard]] const SensorCheck& sensors() const { return sensors_; }
  /// How hot the motors are.
  [[nodiscard]] const Thermometer& thermometer() const { return thermometer_; }
  /// Whether no motion is begun: a sensor is lost, or the DCM error was above 0.02 of the nominal COM height, or a
  /// share of a narrow sole, and has not been below 0.01 since.
  [[nodiscard]] bool disturbed() const { return disturbed_ || sensors_.lost(); }
  /// Estimated − planned DCM, in world axes, less its steady part, which sensor offsets and slopes cause [m]. The plan
  /// is first displaced by the slip of the soles.
  [[nodiscard]] const Vec2& dcm_error() const { return dcm_error_; }
  /// Whether soles stand so far from their plan that the history can no longer be retraced.
  [[nodiscard]] bool slipped() const { return slip_.now; }
  /// Whether the slip was measured in this tick: that needs every planned stance sole in contact.
  [[nodiscard]] bool slip_found() const { return slip_.found; }
  [[nodiscard]] long slips() const { return slip_.count; }
  [[nodiscard]] double last_slip() const { return slip_.distance; }  ///< [m]
  /// Whether soles were recently inclined relative to the plan.
  [[nodiscard]] bool uneven() const;

  /// Displacement of the stance soles from their plan, as one displacement of the planning frame.
  [[nodiscard]] Pose slid(const MotionSample& planned) const { return slid(planned, planned.contact); }
  /// @param stands the soles to go by
  [[nodiscard]] Pose slid(const MotionSample& planned, const BySide<bool>& stands) const;
  /// In double support: the sole that is inclined relative to the plan, as on an edge.
  [[nodiscard]] std::optional<Terrain::Inclined> inclined_sole(const MotionSample& planned) const;
  /// Whether the COM is inside the stand-on region.
  [[nodiscard]] bool supported() const;

 private:
  /// By the soles, of the weight.
  [[nodiscard]] double carried() const;
  /// Whether that is measured: else the plan takes its place, by which a robot that hangs stands.
  [[nodiscard]] bool feels() const;
  void update_guard(bool centred);
  void fall();
  void update_disturbed(const MotionSample& planned, const Pose& anchor);
  void update_slip(const MotionSample& planned, const Pose& anchor);
  void update_inclination(const MotionSample& planned);
  /// Whether the robot stands on both feet and still, so that it could be armed.
  [[nodiscard]] bool stands_upright() const;

  const RobotModel* robot_;
  SensorCheck sensors_;
  Odometry odometry_;
  Estimator estimator_;
  Thermometer thermometer_;
  const Measurement* measured_ = nullptr;
  const State* state_ = nullptr;
  Guard guard_ = Guard::armed;
  int guard_ticks_ = 0;    ///< for which the condition that would change the guard has held
  int falling_ticks_ = 0;  ///< for which trunk and COM have been as in a fall
  Vec2 dcm_error_ = Vec2::Zero();
  Vec2 steady_dcm_error_ = Vec2::Zero();  ///< in the heading frame [m]
  bool disturbed_ = false;                ///< by the DCM error
  struct Slip {
    bool now = false;
    bool found = false;  ///< in this tick
    long count = 0;
    double distance = 0.0;  ///< the last time [m]
  };
  Slip slip_;
  double inclination_ = 0.0;  ///< recent maximum of a sole's inclination relative to the plan [rad]
};

}  // namespace baton
