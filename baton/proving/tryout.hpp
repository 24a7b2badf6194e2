/// Tries out a robot that nobody has driven before: what a biped is expected to do, one manoeuvre after another, each
/// from a fresh start.
#pragma once

#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "baton/input/script.hpp"
#include "baton/run/simulation.hpp"

namespace baton {

/// Something that a robot is asked to do by the stick.
struct Manoeuvre {
  std::string name;
  std::vector<Script::Entry> stick;  ///< empty: a random stick
  double seconds = 0.0;              ///< of simulated time
  double turn = 0.0;                 ///< trunk yaw that has to be reached [rad]
  double way = 0.0;                  ///< distance that the COM has to travel [m]
};

/// Standing, shifting, squatting, lifting and stepping with each foot, turning by 180°, walking, reaching with each
/// hand, and 60 s of a random stick. Times scale with the robot's longest segment.
[[nodiscard]] std::vector<Manoeuvre> manoeuvres(const RobotModel& robot);

/// How a manoeuvre went.
struct Attempt {
  std::string manoeuvre;
  std::string fall;      ///< why it counts as a fall; "" if the robot did not fall
  double t = 0.0;        ///< simulated time [s]
  long given = 0;        ///< commands (docs/report.md)
  long moved = 0;        ///< of these, those that moved their part
  double travel = 0.0;   ///< of the COM [m]
  double turned = 0.0;   ///< yaw of the trunk, at the end [rad]
  double idle = 0.0;     ///< largest distance of a joint of neither leg nor arm from its home, at the end [rad]
  double com_rms = 0.0;  ///< error of the COM against the plan [m]
  std::string refusal;   ///< most frequent reason of refusals; "" without any
  std::string problem;   ///< what was not as it should be; "" if the manoeuvre is done
  VecX q;                ///< true configuration at the end (nq)

  [[nodiscard]] bool done() const { return problem.empty(); }
  [[nodiscard]] nlohmann::json json() const;
};

/// Least share of the commands of a manoeuvre that have to move their part. A random stick's many commands have no time
/// to take effect, so it only must not make the robot fall.
inline constexpr double kMovedShare = 0.6;

class Tryout {
 public:
  /// `robot` and `world` must outlive this object.
  /// @param seed of the plant `real` (in physics) and of the random stick
  /// @throws InputError robot and world cannot be combined
  Tryout(const RobotModel& robot, const World& world, Simulation::On on, std::uint64_t seed);

  [[nodiscard]] Attempt run(const Manoeuvre& manoeuvre);

  [[nodiscard]] const Simulation& simulation() const { return simulation_; }

 private:
  const RobotModel* robot_;
  Simulation simulation_;
  std::uint64_t seed_;
};

}  // namespace baton
