/// A scripted operator that does the paper's task in the room by the stick alone: down the steps foot by foot, or by
/// the trunk in gait `flow`; across the floor by the trunk, to door B by the hand. Its sight has an error, like a
/// person's. In gait `stop` it waits for rest, chooses one deflection, holds it until the robot moves, and releases. In
/// gait `flow` it holds the stick and corrects it continuously; foot by foot, it decides at each touchdown.
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
    double reaction = 0.15;     ///< from rest or refusal to the next deflection [s]
    double patience = 0.3;      ///< a deflection without effect is given up after this [s]
    double near = 0.004;        ///< seen distance at which the hand is at the door [m]
    double settle = 1.3;        ///< time the hand is held there [s]
    bool foot_by_foot = false;  ///< go down the steps foot by foot, as in the paper, also in gait `flow`
  };

  /// @throws InputError the world has no site `door_B`
  RoomOperator(const RobotModel& robot, const World& world, std::uint64_t seed, Gait gait);
  RoomOperator(const RobotModel& robot, const World& world, std::uint64_t seed, Gait gait, Parameters parameters);

  [[nodiscard]] Command decide(const View& view) override;

  [[nodiscard]] bool done() const { return stage_ == Stage::done; }
  /// Current activity, for display.
  [[nodiscard]] std::string_view doing() const;

 private:
  enum class Stage { face, crouch, steps, rise, cross, align, reach, hold, done };

  /// One deflection at a time.
  [[nodiscard]] Command step_by_step(const View& view);
  /// Continuous steering.
  [[nodiscard]] Command steer(const View& view);
  /// The next deflection of this stage; none if the stage is done.
  [[nodiscard]] std::optional<Command> next(const Sight& sight);
  [[nodiscard]] std::optional<Command> face(const Sight& sight) const;
  [[nodiscard]] std::optional<Command> change_height(const Sight& sight, double height) const;
  [[nodiscard]] std::optional<Command> go_down(const Sight& sight);
  [[nodiscard]] std::optional<Command> walk_down(const Sight& sight) const;
  [[nodiscard]] std::optional<Command> cross(const Sight& sight) const;
  [[nodiscard]] std::optional<Command> align(const Sight& sight);
  [[nodiscard]] std::optional<Command> reach(const Sight& sight) const;
  /// A deflection that moves a foot towards a position, on the ground or through the air; none once it is there.
  [[nodiscard]] std::optional<Command> move_foot(const Sight& sight, Side side, const Vec2& to, bool through_the_air,
                                                 double tolerance);
  /// `shift` [m, world frame] as deflection of the three position axes, clamped to `full`.
  [[nodiscard]] Command deflect(Part part, const Sight& sight, const Vec3& shift, double full) const;
  /// The deflection that turns a yaw back to straight ahead.
  [[nodiscard]] double turn_back(double yaw) const;
  [[nodiscard]] Vec2 place_to_reach_from(const Sight& sight) const;

  /// What it knows of the room.
  struct Room {
    Vec3 door;                  ///< target position of the hand
    std::vector<double> edges;  ///< x of the edges on the way down, in order [m]
  };
  /// A deflection, held until the robot moves.
  struct Deflection {
    bool held = false;
    long moved = 0;      ///< motions before the deflection
    bool swung = false;  ///< a foot has been up since
    double since = 0.0;  ///< start of the deflection or of rest [s]
    int refusals = 0;    ///< in a row
  };
  /// Feet guided through the air.
  struct Feet {
    BySide<bool> lifted{false, false};
    BySide<Vec2> landing{Vec2::Zero(), Vec2::Zero()};  ///< target footholds
  };

  const RobotModel* robot_;
  Gait gait_;
  Parameters parameters_;
  Eyes eyes_;
  Room room_;
  double sole_length_ = 0.0;  ///< half length [m]

  Stage stage_ = Stage::face;
  bool foot_by_foot_;             ///< down the steps
  std::optional<Stage> steered_;  ///< stage in which steering has come to its end
  Command stick_;                 ///< currently held
  Deflection deflection_;
  double reaching_since_ = 0.0;  ///< [s]
  std::size_t approach_ = 0;     ///< positions from which reaching failed
  Feet feet_;
};

}  // namespace baton
