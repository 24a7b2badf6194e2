/// Beside another controller: what baton would have known, thought and done, by the robot's measurements alone. It says
/// where measurements, the model and its own judgement disagree (docs/shadow.md). Nothing of it reaches the robot.
#pragma once

#include <deque>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

#include "baton/link/message.hpp"
#include "baton/navigate/watch.hpp"
#include "baton/plan/strategy.hpp"
#include "baton/shadow/standing.hpp"
#include "baton/shadow/timing.hpp"

namespace baton::shadow {

/// What would have become of a command.
struct Tried {
  double t = 0.0;  ///< [s]
  Command command;
  enum class Outcome { possible, in_part, nothing, refused } outcome = Outcome::nothing;
  double duration = 0.0;           ///< of the motion [s]
  std::optional<Refusal> refusal;  ///< why it was refused, or done only in part
  std::string why;                 ///< why it could not be planned at all: how the robot stands
};

[[nodiscard]] constexpr std::string_view to_string(Tried::Outcome outcome) {
  constexpr std::array<std::string_view, 4> names{"possible", "in_part", "nothing", "refused"};
  return names[static_cast<std::size_t>(outcome)];
}

/// The guard has judged otherwise than before.
struct Judged {
  double t = 0.0;  ///< [s]
  Guard from = Guard::armed;
  Guard to = Guard::armed;
  std::optional<bool> truly{};  ///< whether a simulator agrees that it has fallen, or stands on nothing; none: unknown
};

/// A joint's angle, speed or torque beyond what the profile knows.
struct Beyond {
  std::string joint;
  std::string what;  ///< angle, speed or torque
  std::string unit;
  double limit = 0.0;
  long n = 0;          ///< measurements
  double value = 0.0;  ///< the worst
  double t = 0.0;      ///< then [s]
};

/// Something that somebody should look at.
struct Finding {
  std::string what;
  double value = 0.0;
  double limit = 0.0;
  std::string unit;
  std::string verdict;  ///< one line
};

class Shadow {
 public:
  struct Parameters {
    Modes modes{};
    StateSource source = StateSource::sensors;
  };

  /// Robot and world must outlive the object.
  /// @throws InputError the robot lacks the sensors for that source
  Shadow(const RobotModel& robot, const World& world, Parameters parameters);

  /// Takes a measurement. Plans when the robot stands still and the stick asks for something, at most once a second for
  /// the same command.
  /// @param truth of a simulator, as it was said with the measurement; null: none
  /// @param command where the stick is
  void tick(const link::Reading& reading, const Truth* truth, const Command& command);

  /// Time that was seen [s].
  [[nodiscard]] double seconds() const { return timing_.seconds(); }
  /// Whether the robot stands still on both soles, as far as its sensors tell.
  [[nodiscard]] bool still() const;
  /// How the robot stood when it was first seen; none: nothing usable was measured yet.
  [[nodiscard]] const std::optional<Posture>& start() const { return start_; }
  [[nodiscard]] const Timing& timing() const { return timing_; }
  [[nodiscard]] const Standing& standing() const { return standing_; }
  [[nodiscard]] const std::vector<Judged>& judged() const { return judged_; }
  [[nodiscard]] const std::vector<Tried>& tried() const { return tried_; }
  [[nodiscard]] const std::vector<Beyond>& beyond() const { return beyond_; }

  /// All that disagrees, the gravest first.
  [[nodiscard]] std::vector<Finding> findings() const;
  /// For the report.
  [[nodiscard]] nlohmann::json json() const;
  /// For people, some lines.
  [[nodiscard]] std::string summary() const;

 private:
  /// Begins with the robot as it was measured, its lower sole on the ground at the world's start.
  void begin(const Measurement& measured);
  /// What is expected of the next measurement: that the robot goes on as it does.
  void expect(const Measurement& measured);
  void judge(const Truth* truth);
  void look_at_sensors(const Measurement& measured);
  void look_at_joints(const Measurement& measured);
  void try_out(const Command& command);

  const RobotModel* robot_;
  const World* world_;
  Parameters parameters_;
  Strategy strategy_;
  Timing timing_;
  Standing standing_;
  std::optional<Watch> watch_;  ///< none: nothing usable was measured yet
  std::optional<Posture> start_;
  MotionSample expected_;
  Kinematics kinematics_;
  VecX zero_;
  VecX speed_;  ///< of the joints, low-passed (n) [rad/s]
  JointTarget commanded_;
  struct Seen {
    double t = 0.0;  ///< [s]
    Measurement measured;
    State state;
  };
  std::deque<Seen> pending_;  ///< standing still, but a motion may have begun
  double still_ = 0.0;        ///< for how long it has stood still [s]
  bool damped_ = false;
  double damped_time_ = 0.0;  ///< [s]
  double unusable_ = 0.0;     ///< time without a measurement to begin with [s]
  double hottest_ = 0.0;      ///< [permitted rise]
  struct Rejected {
    long ticks = 0;
    long not_finite = 0;  ///< of these
    long times = 0;       ///< in a row count once
    long lost = 0;
    double first = 0.0;  ///< [s]
    Health health = Health::good;
  };
  BySensor<Rejected> rejected_;
  std::vector<Judged> judged_;
  double fallen_unnoticed_ = 0.0;  ///< time for which a simulator's robot had fallen, and the guard did not know [s]
  std::vector<Tried> tried_;
  std::vector<Beyond> beyond_;
};

}  // namespace baton::shadow
