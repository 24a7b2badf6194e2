/// A scripted operator that does the paper's task in the room by the stick alone: down the steps foot by foot, or, with
/// a robot that flows, by the trunk; across the floor by the trunk, to door B by the hand. It looks, as a person would,
/// with an error. With a robot that comes to rest after each motion it waits for that, decides on one deflection, holds
/// it until the robot moves, and lets go. With one that flows it steers: it holds the stick and corrects it as it goes;
/// foot by foot, it decides as soon as a foot has landed.
#pragma once

#include <random>
#include <string>

#include "baton/run/session.hpp"

namespace baton {

class RoomOperator {
 public:
  struct Parameters {
    double sight_error = 0.001;      ///< standard deviation of seen positions [m]
    double sight_yaw_error = 0.005;  ///< of seen headings [rad]
    double reaction = 0.15;          ///< from rest, or from a refusal, to the next deflection [s]
    double patience = 0.3;           ///< a deflection that moves nothing is given up after this [s]
    double near = 0.004;             ///< the hand is at the door when it is seen as near as this [m]
    double settle = 1.3;             ///< how long the hand is then held there [s]
    bool foot_by_foot = false;       ///< down the steps, as in the paper, also with a robot that flows
    double foresight = 0.2;          ///< what moves is taken to go on for that long after the stick is let go of [s]
  };

  /// @throws InputError the world has no site `door_B`
  RoomOperator(const RobotModel& robot, const World& world, std::uint64_t seed, Gait gait);
  RoomOperator(const RobotModel& robot, const World& world, std::uint64_t seed, Gait gait, Parameters parameters);

  /// The stick at this moment, by what is seen of the session.
  [[nodiscard]] Command decide(const Session& session);

  [[nodiscard]] bool done() const { return stage_ == Stage::done; }
  /// What it is doing, for people.
  [[nodiscard]] std::string_view doing() const;

 private:
  enum class Stage { face, crouch, steps, rise, cross, align, reach, hold, done };

  /// What can be seen of the robot from outside.
  struct Sight {
    BySide<Pose> sole;
    Vec3 com;
    Vec3 hand;               ///< left
    Vec3 shoulder;           ///< left
    double heading = 0.0;    ///< mean yaw of both feet [rad]
    double trunk_yaw = 0.0;  ///< [rad]
    [[nodiscard]] Vec2 feet() const { return 0.5 * (sole.left.p + sole.right.p).head<2>(); }
  };

  [[nodiscard]] Sight look(const Session& session);
  /// Where it will come to rest by itself, by this look and the last.
  [[nodiscard]] Sight foreseen(const Session& session);
  /// One deflection after the other.
  [[nodiscard]] Command step_by_step(const Session& session);
  /// The stick corrected on the way.
  [[nodiscard]] Command steer(const Session& session);
  /// The next deflection of this stage, or nothing if the stage is over.
  [[nodiscard]] std::optional<Command> next(const Sight& sight);
  [[nodiscard]] std::optional<Command> face(const Sight& sight) const;
  [[nodiscard]] std::optional<Command> change_height(const Sight& sight, double height) const;
  [[nodiscard]] std::optional<Command> go_down(const Sight& sight);
  [[nodiscard]] std::optional<Command> walk_down(const Sight& sight) const;
  [[nodiscard]] std::optional<Command> cross(const Sight& sight) const;
  [[nodiscard]] std::optional<Command> align(const Sight& sight);
  [[nodiscard]] std::optional<Command> reach(const Sight& sight) const;
  /// A deflection that brings a foot nearer to a place, on the ground or through the air; nothing when it is there.
  [[nodiscard]] std::optional<Command> move_foot(const Sight& sight, Side side, const Vec2& to, bool through_the_air,
                                                 double tolerance);
  /// `shift` [m, world] as deflection of the three position axes, never more than full.
  [[nodiscard]] Command deflect(Part part, const Sight& sight, const Vec3& shift, double full) const;
  /// The deflection that takes a yaw back to straight ahead.
  [[nodiscard]] double turn_back(double yaw) const;
  [[nodiscard]] Vec2 place_to_reach_from(const Sight& sight) const;

  const RobotModel* robot_;
  Gait gait_;
  bool foot_by_foot_;  ///< down the steps
  Parameters parameters_;
  std::mt19937_64 random_;
  Kinematics kinematics_;
  Vec3 door_;
  std::vector<double> edges_;  ///< x of the edges to go down, in order [m]
  double sole_length_ = 0.0;   ///< half [m]

  Stage stage_ = Stage::face;
  Command stick_;                 ///< as held now
  bool deflected_ = false;        ///< a deflection is held until the robot moves
  long moved_ = 0;                ///< motions before it
  bool swung_ = false;            ///< a foot was up since
  std::optional<Stage> steered_;  ///< the stage in which it has steered as far as that goes
  std::optional<Sight> last_look_;
  double looked_ = 0.0;          ///< when [s]
  double since_ = 0.0;           ///< rest, or the present deflection, began then [s]
  int refusals_ = 0;             ///< in a row
  double reaching_since_ = 0.0;  ///< [s]
  std::size_t approach_ = 0;     ///< places that the hand was stretched out from in vain
  BySide<bool> lifted_{false, false};
  BySide<Vec2> landing_{Vec2::Zero(), Vec2::Zero()};  ///< where a lifted foot is to land
};

}  // namespace baton
