/// Command → goals: the guiding rule of the guided part, and the synergetic rules of all others (docs/theory.md §2).
/// Results depend on the arguments only.
#pragma once

#include <functional>
#include <optional>
#include <variant>

#include "baton/guide/command.hpp"
#include "baton/model/world.hpp"
#include "baton/motion/goal.hpp"
#include "baton/motion/refusal.hpp"

namespace baton {

/// State that the rules depend on, beside the command. Poses are in the planning frame unless noted.
struct GuideContext {
  /// Planned posture that goals are relative to. For a request from rest, the posture at rest. While moving: the rest
  /// that the motion leads to, or the posture it began in, with the guided part where it is now (`due`). For `stops`
  /// and `capture_steps`: the moving posture itself.
  Posture from;
  Pose anchor;                   ///< planning frame in the world: position and yaw
  Side last_step = Side::right;  ///< the foot that stepped last
  BySide<Pose> foothold;         ///< latest foothold of each foot

  /// A step under way.
  struct Step {
    Side side = Side::left;  ///< the foot in the air: the other cannot step
    Pose to;                 ///< planned foothold
  };
  std::optional<Step> step{};
  bool stick_held = false;  ///< a guided trunk then prefers stepping to shifting the COM

  /// Offset of the robot's COM from the model's (`Correction::com_offset`), in the planning frame [m]. COM positions of
  /// postures and goals are the model's.
  Vec2 com_offset{Vec2::Zero()};

  double place_uncertainty = 0.0;  ///< error bound of the robot's position [m]

  Pose slip_free_frame{};   ///< where the planning frame would be in the world if no sole had slipped
  Pose drift_correction{};  ///< correction towards `slip_free_frame`, in the planning frame, for a guided trunk
};

/// Displacement requested of the guided part.
struct Target {
  Part part = Part::trunk;
  Vec6 move = Vec6::Zero();  ///< of the sole, the hand, or COM and trunk, in the heading frame: position [m], rotation
                             ///< vector [rad]
  double lift = 0.0;         ///< of a foot above the terrain [m]; 0: it stands
};

/// Nothing requested; goals, the preferred one first; or the reason why there is none.
using GuideResult = std::variant<std::monostate, std::vector<Goal>, Refusal>;

class Guide {
 public:
  /// Robot and world must outlive the object.
  Guide(const RobotModel& robot, const World& world) : robot_(&robot), world_(&world) {}

  /// Goals for a command. Sanitises the command.
  [[nodiscard]] GuideResult goals(const GuideContext& context, const Command& command) const;

  /// The target of a command that guides by the stick. Nothing for recalls, and while a foot in the air is to land
  /// first. Sanitises the command.
  [[nodiscard]] std::optional<Target> target(const GuideContext& context, const Command& command) const;

  /// Goals with the guided part at its target, and all other parts by rule.
  [[nodiscard]] GuideResult goals(const GuideContext& context, const Target& target) const;

  /// The first `share` of the target's displacement.
  [[nodiscard]] Target part_of(const GuideContext& context, const Target& target, double share) const;

  /// The target's displacement along each axis alone, the largest first, relative to the part's reach.
  [[nodiscard]] std::vector<Target> single_axes(const Target& target) const;

  /// The target of a foot, clamped to the foot's region.
  [[nodiscard]] Target within_region(const GuideContext& context, const Target& target) const;

  /// For a guided foot whose target is on a terrain edge: the nearest valid foothold in the same direction, before the
  /// edge or past it. Nothing if there is none, or the foot is to stay in the air.
  [[nodiscard]] GuideResult nearest_step(const GuideContext& context, const Target& target) const;

  /// For a guided foot that cannot step, at the border of its region or before an edge it cannot pass: a step of the
  /// other foot in the same direction. Nothing if that step would be too short.
  [[nodiscard]] GuideResult other_foot_first(const GuideContext& context, const Target& target) const;

  /// Steps that end a stance longer than `stride`, as a capture step may leave it: a foot goes beside the other, or
  /// nearer to there. None for other stances, or on one foot.
  /// @param forward which foot comes first: the one behind, or the one ahead
  [[nodiscard]] std::vector<Goal> closing_steps(const GuideContext& context, bool forward) const;

  /// The goal in which nothing moves but what drives the arms.
  [[nodiscard]] Goal staying(const GuideContext& context, Part guided) const;

  /// Landings of a foot in the air: below it, on its latest foothold, or on the nearest valid foothold; with the COM at
  /// its current height, then lower.
  [[nodiscard]] GuideResult landings(const GuideContext& context, Side side) const;

  /// Goals that bring a moving posture, `context.from`, to rest. On both feet, the COM is halted ahead of where it is.
  /// A foot in the air lands, preferably on its planned foothold.
  [[nodiscard]] GuideResult stops(const GuideContext& context) const;

  /// Goals that stand straighter, for motors to cool, from a rest on both feet: the COM above the middle of the feet,
  /// as high as it may be, then less high; then the same with the trunk upright. None if the COM is there already.
  [[nodiscard]] std::vector<Goal> straighter(const GuideContext& context) const;

  /// Capture steps after a push, from `context.from`, which may move: of the foot in the air, else of the one about to
  /// lift off, else of the less loaded one, or of either after a push straight ahead. The foothold is displaced by
  /// `by`, or by half of it, within its region. Nothing for a sideways push on both feet, as the foot on that side
  /// carries the weight.
  /// @param by displacement of the foothold, in the planning frame [m]
  /// @param aside after a sideways push, step with the other foot all the same
  [[nodiscard]] GuideResult capture_steps(const GuideContext& context, const Vec2& by, bool aside = false) const;

 private:
  struct Placement;  ///< a foothold, or the reason why it is invalid

  /// Where a foot may be placed, in the stance sole's frame [m].
  struct FootRegion {
    Range forward;
    Range outward;  ///< away from the stance foot
  };

  /// The foot in the air that has to land before the command can be followed.
  [[nodiscard]] std::optional<Side> lands_first(const GuideContext& context, const Command& command) const;
  [[nodiscard]] std::optional<Target> foot_target(const GuideContext& context, const Command& command) const;
  [[nodiscard]] GuideResult guide_foot(const GuideContext& context, const Target& target) const;
  [[nodiscard]] GuideResult guide_trunk(const GuideContext& context, const Target& target) const;
  [[nodiscard]] GuideResult guide_hand(const GuideContext& context, const Target& target) const;
  /// The displacement of a trunk, in the heading frame [m]. While the stick is held it counts from above the foot
  /// ahead, not from between the feet, so that the feet pass each other in turn; but it is at most doubled.
  [[nodiscard]] Vec3 walking_on(const GuideContext& context, Vec3 move) const;
  /// Goals towards the initial stance, at the feet's current place: steps first, then COM, trunk and arms.
  [[nodiscard]] GuideResult go_home(const GuideContext& context) const;
  /// Steps that bring a foot beside the other, or nearer to there, with the body as in the initial stance.
  [[nodiscard]] std::vector<Goal> home_steps(const GuideContext& context) const;
  /// Decides whether and where a foot steps, given COM and trunk attitude of `goal`.
  [[nodiscard]] GuideResult stand_under(const GuideContext& context, const Goal& goal) const;

  /// A goal in which nothing moves.
  [[nodiscard]] Goal stay(const GuideContext& context, Part guided) const;
  /// A goal in which a foot lands on `sole`, with the COM above the middle of the feet.
  [[nodiscard]] Goal landing(const GuideContext& context, Side side, const Pose& sole) const;
  /// Appends alternatives for a posture too low, too high or too inclined for stepping: `goal` with the COM halfway to
  /// and at its nominal height, then with the trunk upright, too.
  void add_nominal(const GuideContext& context, Goal goal, std::vector<Goal>& goals) const;
  /// `goal` with trunk and COM as in the initial stance, above the goal's feet.
  [[nodiscard]] Goal initial_stance(const GuideContext& context, Goal goal) const;
  /// Sets the arms to the home pose.
  void arms_home(Goal& goal) const;
  /// Distance below which two places are the same [m].
  [[nodiscard]] double same_place() const;
  /// Height of a sole above the highest terrain under it [m].
  [[nodiscard]] double height_above_terrain(const GuideContext& context, Side side) const;
  /// The profile's region.
  [[nodiscard]] FootRegion foot_region() const;
  /// The same, for steps that the robot chooses by itself: shorter, and farther from the other foot.
  [[nodiscard]] FootRegion stride_region() const;
  /// A region extended to the foot's present place, which is outside if the soles are turned against each other.
  [[nodiscard]] static FootRegion extended(FootRegion region, const GuideContext& context, Side side);
  /// Places a foot on the terrain, or in the air above it.
  /// @param at position of the sole [m]
  /// @param lift height above the terrain [m]; 0: it stands
  /// @param edge distance from terrain edges [m]; by default `edge_margin` of the position's uncertainty
  [[nodiscard]] Placement place(const GuideContext& context, Side side, const Vec2& at, double yaw, double lift,
                                const FootRegion& region, std::optional<double> edge = {}) const;
  /// The valid foothold nearest to `at`, by a grid search over the region.
  /// @param serves if given, restricts the positions [m]
  [[nodiscard]] Placement nearest_place(const GuideContext& context, Side side, const Vec2& at, double yaw,
                                        const FootRegion& region,
                                        const std::function<bool(const Vec2&)>& serves = {}) const;
  /// The foothold nearest to `at` that brings a foot forward in the direction of `move`, if there is one.
  /// @param least progress, as share of `move`
  /// @param direction least cosine of the angle between the step and `move`
  [[nodiscard]] GuideResult step_along(const GuideContext& context, Side side, const Vec2& at, double yaw,
                                       const Vec2& move, double least, double direction) const;
  /// Goals with the guided foot at `sole` and all other parts by rule.
  /// @param stands on the ground, not in the air
  [[nodiscard]] std::vector<Goal> foot_goals(const GuideContext& context, Side side, const Pose& sole,
                                             bool stands) const;
  /// Appends goals with a step that serves COM and trunk of `goal`, the preferred one first. Returns the refusal of the
  /// first foothold that is invalid.
  /// @param turn whether a step is due to turn the feet
  std::optional<Refusal> add_steps(const GuideContext& context, const Goal& goal, bool turn, const FootRegion& region,
                                   std::vector<Goal>& goals) const;
  /// Where a foot steps to bring the middle of the feet to `target` [m]. With a turn the line between the feet turns
  /// too, about the other foot, which leaves the middle off. Each step leaves it off by a little, to either side in
  /// turn, to bring the feet's lateral distance back to the stance width: soles that slip change it.
  /// @param yaw of the heading after the step
  [[nodiscard]] Vec2 opposite(const GuideContext& context, Side side, const Vec2& target, double yaw) const;
  /// The foot farther from a place; at a tie, the one that did not step last.
  [[nodiscard]] Side farther_foot(const GuideContext& context, const Vec2& place) const;
  /// `goal` with a step to `sole`, and the COM above the middle of the feet.
  [[nodiscard]] Goal stepping(const GuideContext& context, const Goal& goal, Side side, const Pose& sole) const;
  /// Position of the model's COM that brings the robot's to `at` [m].
  [[nodiscard]] static Vec3 com_for(const GuideContext& context, const Vec3& at);
  /// COM position above the middle of the goal's soles in contact, at its current height above the soles in contact.
  [[nodiscard]] Vec3 com_above(const GuideContext& context, const Goal& goal) const;

  const RobotModel* robot_;
  const World* world_;
};

}  // namespace baton
