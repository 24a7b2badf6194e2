/// Summary statistics of a run (explained in docs/report.md).
#pragma once

#include <limits>
#include <nlohmann/json.hpp>

#include "baton/record/command_account.hpp"
#include "baton/record/durations.hpp"
#include "baton/record/segment_count.hpp"
#include "baton/record/tracking_error.hpp"
#include "baton/run/sink.hpp"

namespace baton {

class Report : public Sink {
 public:
  /// `robot` must outlive this object.
  explicit Report(const RobotModel& robot);

  void on_tick(const TickRecord& record) override;
  void on_plan(const PlanRecord& record) override;

  /// @param wall wall-clock duration of the run [s]
  [[nodiscard]] nlohmann::json json(const std::string& world, const std::string& on, long seed, double wall) const;

 private:
  /// COM height above the soles at the end of the first and the last rest on both feet [m].
  struct RestHeight {
    double first = 0.0;
    double last = 0.0;
    bool rests = false;
  };

  void note_zmp_margin(const Truth& truth);
  void note_height(const Navigator& navigator);
  void note_sensors(const Navigator& navigator);
  void note_heat(const Navigator& navigator);

  const RobotModel* robot_;
  Kinematics kinematics_;  ///< true configuration
  double duration_ = 0.0;
  bool has_truth_ = true;  ///< without truth, quantities that only a simulator knows are null
  bool fallen_ = false;
  double tilt_ = 0.0;  ///< largest tilt of the trunk [rad]
  CommandAccount commands_;
  SegmentCount segments_;
  TrackingError tracking_;
  Durations plan_;
  Durations tick_;
  double zmp_margin_ = std::numeric_limits<double>::infinity();  ///< least margin of the measured ZMP [m]
  RestHeight height_;
  struct SensorCount {
    long rejected = 0;  ///< ticks
    long lost = 0;      ///< times
  };
  BySensor<SensorCount> sensors_;
  struct HeatCount {
    Hottest most;    ///< of all motors, at any time
    long hot = 0;    ///< ticks
    long times = 0;  ///< that the robot got hot
  };
  HeatCount heat_;
};

}  // namespace baton
