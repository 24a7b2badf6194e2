/// Command → goal: the guiding rule of the guided part and the synergetic rules of all others
/// (docs/theory.md §2). A pure function: nothing is remembered here.
#pragma once

#include <functional>
#include <optional>
#include <variant>

#include "baton/guide/command.hpp"
#include "baton/model/world.hpp"
#include "baton/motion/goal.hpp"
#include "baton/motion/refusal.hpp"

namespace baton {

/// What the rules need to know besides the command.
struct GuideContext {
  /// Planned posture that goals are relative to, at rest, in the planning frame. With a step under way: the one that
  /// it began in, both feet standing.
  Posture from;
  Pose anchor;                   ///< planning frame in the world: position and yaw
  Side last_step = Side::right;  ///< the foot that stepped last
  BySide<Pose> foothold;         ///< where each foot stood last, in the planning frame

  /// A step under way.
  struct Step {
    Side side = Side::left;  ///< the foot that is in the air: no other can step
    Pose to;                 ///< where it lands if nothing else is asked for
  };
  std::optional<Step> step{};
  bool goes_on = false;  ///< the stick is held: better a step now than where there is no other way

  double place_uncertainty = 0.0;  ///< how far off the robot's place may be: edges are kept so much farther away [m]

  Pose slip_free_frame{};   ///< where the planning frame would be if no sole had slid
  Pose drift_correction{};  ///< of the move there, in the planning frame, what a guided trunk makes up for now
};

/// Nothing is asked for; goals, the one that the rules prefer first and then what else would serve the command; or
/// the reason why there is none.
using GuideResult = std::variant<std::monostate, std::vector<Goal>, Refusal>;

class Guide {
 public:
  /// Lifts below this share of the throttle count as zero.
  static constexpr double kLeastLift = 0.05;

  /// Robot and world must outlive the object.
  Guide(const RobotModel& robot, const World& world) : robot_(&robot), world_(&world) {}

  /// The goals that `command` asks for. The command is sanitised here.
  [[nodiscard]] GuideResult goals(const GuideContext& context, const Command& command) const;

  /// The axes that a part can use.
  [[nodiscard]] std::vector<int> axes_of(Part part) const;

  /// The same command, its goal only a share of the way from where the guided part is now.
  [[nodiscard]] Command shortened(const GuideContext& context, const Command& command, double share) const;

  /// The same command of a foot, its goal brought into the foot's region.
  [[nodiscard]] Command within_region(const GuideContext& context, const Command& command) const;

  /// Where the foothold that a command of a foot asks for is on an edge: the nearest one that leads the same way and
  /// can be stood on, short of the edge or past it. Nothing if there is none, or the foot is to be in the air.
  [[nodiscard]] GuideResult nearest_step(const GuideContext& context, const Command& command) const;

  /// A step of the other foot towards where the guided foot is to go, for when that one cannot step: at an edge that is
  /// out of its region, or at its region's forward border. Nothing if the other foot gains too little by a step.
  [[nodiscard]] GuideResult other_foot_first(const GuideContext& context, const Command& command) const;

  /// Ways to put down a foot that is in the air: where it is, where it stood last, at the nearest place; with the
  /// COM as high as it is, or lower.
  [[nodiscard]] GuideResult landings(const GuideContext& context, Side side) const;

  /// Ways to come to rest from a posture that moves, `context.from`: with both feet where they stand, the COM where it
  /// can be halted; with a foot in the air, by putting it down, first where it was to land.
  [[nodiscard]] GuideResult stops(const GuideContext& context) const;

  /// Steps for a robot that is pushed off its way, from the posture `context.from`, which may move: the foot that is in
  /// the air, or about to leave the ground, or one of both, lands `by` farther [m], or half as far, as its region
  /// allows. Nothing where no step helps: sideways on both feet, as the one that would have to step carries the weight.
  /// @param aside the other one steps there all the same, as near to it as its region allows
  [[nodiscard]] GuideResult catches(const GuideContext& context, const Vec2& by, bool aside = false) const;

 private:
  struct Placement;  ///< a foot somewhere, and what speaks against it

  [[nodiscard]] GuideResult guide_foot(const GuideContext& context, const Command& command) const;
  [[nodiscard]] GuideResult guide_trunk(const GuideContext& context, const Command& command) const;
  [[nodiscard]] GuideResult guide_hand(const GuideContext& context, const Command& command) const;
  /// Back to the stance that the robot began in, where the feet are now: by steps, COM, trunk and arms.
  [[nodiscard]] GuideResult go_home(const GuideContext& context) const;
  /// Decides whether and where a foot steps for the COM and trunk attitude of `goal`.
  [[nodiscard]] GuideResult stand_under(const GuideContext& context, const Goal& goal) const;

  /// A goal in which nothing moves.
  [[nodiscard]] Goal stay(const GuideContext& context, Part guided) const;
  /// A goal in which a foot is put down there, and the COM goes above the middle.
  [[nodiscard]] Goal landing(const GuideContext& context, Side side, const Pose& sole) const;
  /// What else may be done if the legs cannot step with the COM so low or high, or the trunk so inclined: the same with
  /// the COM as high as at the start, and with the trunk upright too.
  void add_nominal(const GuideContext& context, Goal goal, std::vector<Goal>& goals) const;
  void arms_home(Goal& goal) const;
  /// The foot at a place on the ground, as far from edges as the profile and the place's uncertainty say, or as given,
  /// or in the air `lift` above it.
  /// @param from_here a foot that is outside its region, as one is when soles are turned against each other, may stay
  /// there or come nearer
  [[nodiscard]] Placement place(const GuideContext& context, Side side, const Vec2& at, double yaw, double lift,
                                const Range& forward, std::optional<double> edge = {}, bool from_here = false) const;
  /// Of the places in the foot's region, the nearest to `at` that can be stood on.
  /// @param serves if given, of those for which it is true [m, planning frame]
  [[nodiscard]] Placement nearest_place(const GuideContext& context, Side side, const Vec2& at, double yaw,
                                        const Range& forward,
                                        const std::function<bool(const Vec2&)>& serves = {}) const;
  /// Where a command sends the foot that it guides.
  struct FootWish {
    Vec2 move;          ///< [m]
    double yaw = 0.0;   ///< [rad]
    double lift = 0.0;  ///< height above the ground; 0: it is to stand [m]
  };
  [[nodiscard]] FootWish foot_wish(const GuideContext& context, const Command& command) const;
  /// The guided foot to `sole`, all else by rule.
  [[nodiscard]] std::vector<Goal> foot_goals(const GuideContext& context, Side side, const Pose& sole,
                                             bool stands) const;
  /// Appends the steps that serve a COM and trunk goal, with soles that far apart; returns what speaks against
  /// the preferred one.
  std::optional<Refusal> add_steps(const GuideContext& context, const Goal& goal, bool turn, const Range& forward,
                                   std::vector<Goal>& goals) const;
  /// `goal` with a step to `sole`.
  [[nodiscard]] Goal stepping(const GuideContext& context, const Goal& goal, Side side, const Pose& sole) const;
  /// COM above the supporting soles' middle, at the height that it has above its supports now.
  [[nodiscard]] Vec3 com_above(const GuideContext& context, const Goal& goal) const;

  const RobotModel* robot_;
  const World* world_;
};

}  // namespace baton
