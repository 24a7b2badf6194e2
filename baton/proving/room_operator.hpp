/// A scripted operator that does the paper's task in the room by the stick alone: down the steps by the trunk, or foot
/// by foot; across the floor by the trunk, to door B by the hand. It knows the room and the robot's sizes, sees the
/// robot as a person does (`Eyes`), and reads the page. To walk it holds the stick and corrects it now and then; for
/// all that is finer it taps the stick, waits for rest, and looks.
#pragma once

#include <optional>
#include <string_view>
#include <vector>

#include "baton/proving/eyes.hpp"

namespace baton {

class RoomOperator : public Operator {
 public:
  struct Parameters {
    Eyes::Parameters eyes{};
    double tap = 0.1;           ///< a tapped stick is let go of after this: one segment [s]
    double glance = 0.25;       ///< between two corrections of a held stick [s]
    double look = 1.4;          ///< the hand is looked at for so long before a fine correction [s]
    double near = 0.02;         ///< distance of the hand from the door below which corrections are fine [m]
    double fine = 0.002;        ///< least fine correction [m]
    bool foot_by_foot = false;  ///< go down the steps foot by foot, as in the paper
  };

  /// @throws InputError the world has no site `door_B`
  RoomOperator(const RobotModel& robot, const World& world, std::uint64_t seed);
  RoomOperator(const RobotModel& robot, const World& world, std::uint64_t seed, Parameters parameters);

  [[nodiscard]] Command decide(const View& view) override;

  /// Current activity, for display.
  [[nodiscard]] std::string_view doing() const;

 private:
  enum class Stage { face, crouch, steps, rise, cross, reach };

  /// Takes in what is seen: where things are while the robot rests, and what became of the last tap.
  void note(const Seen& seen);
  /// Takes in what became of the last tap.
  void conclude(const Page& page);
  /// One deflection at a time.
  [[nodiscard]] Command tap(const Seen& seen, double t);
  /// Continuous steering.
  [[nodiscard]] Command steer(double t);
  /// The next deflection of this stage; none if there is nothing to do.
  [[nodiscard]] std::optional<Command> next(const Sight& sight);
  [[nodiscard]] std::optional<Command> face(const Sight& sight) const;
  [[nodiscard]] std::optional<Command> change_height(const Sight& sight, double height) const;
  [[nodiscard]] std::optional<Command> go_down(const Sight& sight);
  [[nodiscard]] std::optional<Command> walk_down(const Sight& sight) const;
  [[nodiscard]] std::optional<Command> cross(const Sight& sight) const;
  [[nodiscard]] std::optional<Command> reach(const Sight& sight) const;
  /// A deflection that moves a foot towards a position, on the ground or through the air; none once it is there.
  [[nodiscard]] std::optional<Command> move_foot(const Sight& sight, Side side, const Vec2& to, bool through_the_air);
  /// `shift` [m, world frame] as deflection of the three position axes, clamped to what full stick gives.
  [[nodiscard]] Command deflect(Part part, const Sight& sight, const Vec3& shift) const;
  /// The shift that a deflection asks for [m, world frame].
  [[nodiscard]] Vec3 asked(const Command& command, const Sight& sight) const;
  /// The deflection that turns a yaw back to straight ahead.
  [[nodiscard]] double turn_back(double yaw) const;
  [[nodiscard]] Vec2 place_to_reach_from(const Sight& sight) const;
  /// Where things are, from all that was seen since they moved.
  [[nodiscard]] Sight steady() const;

  /// What it knows of the room.
  struct Room {
    Vec3 door;                  ///< target position of the hand
    std::vector<double> edges;  ///< x of the edges on the way down, in order [m]
  };
  /// What it has done with the stick, and what came of it.
  struct Deflection {
    bool pending = false;  ///< it is not yet known what came of a tap
    double since = 0.0;    ///< stick last moved [s]
    int refusals = 0;      ///< taps without effect in a row; while steering, glances at a robot that rests
    int refused = 0;       ///< refusals that the page showed before the tap
    Vec3 shift;            ///< asked for by the tap [m, world frame]
    bool turned = false;   ///< by that tap
    bool moved = false;    ///< the robot has moved since
    bool limited = false;  ///< by less than that
  };
  /// Feet guided through the air.
  struct Feet {
    BySide<bool> lifted{false, false};
    BySide<Vec2> landing{Vec2::Zero(), Vec2::Zero()};  ///< target footholds
  };
  /// Means of what is seen, while it stands still.
  struct Means {
    explicit Means(const Mean& none) : sole{none, none}, trunk(none), hand(none), shoulder(none) {}
    void see(const Seen& seen);
    /// Trunk and arm have moved who knows where.
    void forget_body();

    BySide<Mean> sole;
    Mean trunk;
    Mean hand;
    Mean shoulder;
  };

  const RobotModel* robot_;
  Parameters parameters_;
  Eyes eyes_;
  Means means_;
  Room room_;
  double sole_length_ = 0.0;  ///< half length [m]

  Stage stage_ = Stage::face;
  bool steered_ = false;  ///< across the room, until close
  Command stick_;         ///< currently held
  Deflection deflection_;
  std::size_t approach_ = 0;  ///< positions from which the arm could not do it
  int backs_ = 0;             ///< how often it was stuck at the steps
  bool goes_home_ = false;    ///< next, as it could do it from none: feet that are apart may be in the way
  double rests_since_ = 0.0;  ///< as seen, [s]
  double looked_ = 0.0;       ///< time since then [s]
  Feet feet_;
};

}  // namespace baton
