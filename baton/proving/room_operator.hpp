/// A scripted operator that does the paper's task in the room by the stick alone: down the steps foot by foot, or, with
/// a robot that flows, by the trunk; across the floor by the trunk, to door B by the hand. It looks, as a person would,
/// with an error. With a robot that comes to rest after each motion it waits for that, decides on one deflection, holds
/// it until the robot moves, and lets go. With one that flows it steers: it holds the stick and corrects it as it goes;
/// foot by foot, it decides as soon as a foot has landed.
#pragma once

#include <optional>
#include <string_view>
#include <vector>

#include "baton/plan/modes.hpp"
#include "baton/proving/eyes.hpp"

namespace baton {

class RoomOperator : public Operator {
 public:
  struct Parameters {
    Eyes::Parameters eyes{};
    double reaction = 0.15;     ///< from rest, or from a refusal, to the next deflection [s]
    double patience = 0.3;      ///< a deflection that moves nothing is given up after this [s]
    double near = 0.004;        ///< the hand is at the door when it is seen as near as this [m]
    double settle = 1.3;        ///< how long the hand is then held there [s]
    bool foot_by_foot = false;  ///< down the steps, as in the paper, also with a robot that flows
  };

  /// @throws InputError the world has no site `door_B`
  RoomOperator(const RobotModel& robot, const World& world, std::uint64_t seed, Gait gait);
  RoomOperator(const RobotModel& robot, const World& world, std::uint64_t seed, Gait gait, Parameters parameters);

  [[nodiscard]] Command decide(const View& view) override;

  [[nodiscard]] bool done() const { return stage_ == Stage::done; }
  /// What it is doing, for people.
  [[nodiscard]] std::string_view doing() const;

 private:
  enum class Stage { face, crouch, steps, rise, cross, align, reach, hold, done };

  /// One deflection after the other.
  [[nodiscard]] Command step_by_step(const View& view);
  /// The stick corrected on the way.
  [[nodiscard]] Command steer(const View& view);
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

  /// What it knows of the room.
  struct Room {
    Vec3 door;                  ///< where the hand is to be held
    std::vector<double> edges;  ///< x of the edges to go down, in order [m]
  };
  /// A deflection, held until the robot moves.
  struct Deflection {
    bool held = false;
    long moved = 0;      ///< motions before it
    bool swung = false;  ///< a foot was up since
    double since = 0.0;  ///< it, or rest, began then [s]
    int refusals = 0;    ///< in a row
  };
  /// Feet that go through the air.
  struct Feet {
    BySide<bool> lifted{false, false};
    BySide<Vec2> landing{Vec2::Zero(), Vec2::Zero()};  ///< where they are to land
  };

  const RobotModel* robot_;
  Gait gait_;
  Parameters parameters_;
  Eyes eyes_;
  Room room_;
  double sole_length_ = 0.0;  ///< half [m]

  Stage stage_ = Stage::face;
  bool foot_by_foot_;             ///< down the steps
  std::optional<Stage> steered_;  ///< the stage in which it has steered as far as that goes
  Command stick_;                 ///< as held now
  Deflection deflection_;
  double reaching_since_ = 0.0;  ///< [s]
  std::size_t approach_ = 0;     ///< places that the hand was stretched out from in vain
  Feet feet_;
};

}  // namespace baton
