#include "baton/verify/verifier.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <utility>

#include "baton/model/place_margins.hpp"

namespace baton {
namespace {

constexpr double kWrenchTolerance = 1e-3;  ///< share of the weight that vertex forces may miss: a rounding error
constexpr double kTiltSlack = 0.01;        ///< by which the trunk may lean farther in motion than at rest [rad]
constexpr double kTiltRounding = 1e-6;     ///< [rad]
constexpr double kDistanceSlack = 1e-5;    ///< rounding error of a distance that is below its limit already [m]
constexpr double kHeatSlack = 0.1;         ///< by which a motor that is too hot already may get hotter [permitted rise]
constexpr double kTravelClearance = 0.2;   ///< clearance of a travelling foot, share of the swing clearance
constexpr double kTravelSlope = 0.3;       ///< height over horizontal distance, near lift-off and touchdown
constexpr double kContactHeight = -2.0;    ///< of a sole above the terrain, at lift-off and touchdown [`ik.position`]
constexpr double kMarginStep = 0.25;       ///< step by which the edge margin is reduced, as share of it

bool is_finite(const MotionSample& sample) {
  const auto pose = [](const Pose& x) { return x.p.allFinite() && x.R.allFinite(); };
  return sample.q.allFinite() && sample.dq.allFinite() && sample.ddq.allFinite() && sample.com.allFinite() &&
         sample.dcom.allFinite() && pose(sample.sole.left) && pose(sample.sole.right);
}

/// The first sample with a foot in the air, or the end.
std::vector<MotionSample>::const_iterator first_swing_sample(const Motion& motion) {
  return std::find_if(motion.samples.begin(), motion.samples.end(),
                      [](const MotionSample& s) { return !s.contact.left || !s.contact.right; });
}

}  // namespace

/// Records the worst value of each quantity, and the first violation. A violation that no duration can fix replaces one
/// that a longer duration may fix.
class Verifier::Ledger {
 public:
  void enter(Reason quantity, Part part, double value, double limit, double t, int subject) {
    const double slack = info(quantity).bound == Bound::at_most ? limit - value : value - limit;
    Entry& entry = entries_[static_cast<std::size_t>(quantity)];
    if (!entry.known || !(slack >= entry.slack)) entry = {true, slack, part, value, limit, t, subject};
    if (slack >= 0.0) return;
    first_violation_ = std::min(first_violation_, t);
    if (!violation_ || (mends_with_time(*violation_) && !mends_with_time(quantity))) violation_ = quantity;
  }

  [[nodiscard]] bool violated() const { return violation_.has_value(); }

  template <typename Name>
  [[nodiscard]] std::optional<Refusal> refusal(const Name& name) const {
    if (!violation_) return std::nullopt;
    const Entry& e = entries_[static_cast<std::size_t>(*violation_)];
    return Refusal{*violation_, e.part, e.value, e.limit, name(*violation_, e.subject), first_violation_};
  }

  template <typename Name>
  [[nodiscard]] Certificate certificate(const Name& name) const {
    Certificate certificate;
    for (std::size_t i = 0; i < kReasons; ++i) {
      const Entry& e = entries_[i];
      const auto quantity = static_cast<Reason>(i);
      if (e.known) certificate.margins.push_back({quantity, e.value, e.limit, e.t, name(quantity, e.subject)});
    }
    return certificate;
  }

 private:
  struct Entry {
    bool known = false;
    double slack = 0.0;
    Part part = Part::trunk;
    double value = 0.0;
    double limit = 0.0;
    double t = 0.0;
    int subject = -1;  ///< joint, or pair of geoms as first · ngeom + second; −1: none
  };
  std::array<Entry, kReasons> entries_{};
  std::optional<Reason> violation_;
  double first_violation_ = std::numeric_limits<double>::infinity();  ///< time of the first violation [s]
};

Verifier::Verifier(const RobotModel& robot, const World& world)
    : robot_(&robot),
      world_(&world),
      kinematics_(robot),
      forces_(robot, Limits::normal(robot.profile())),
      obstacles_(robot, world),
      tau_(VecX::Zero(robot.nv() - 6)),
      heat_model_(robot) {
  const mjModel& m = robot.mj();
  links_.resize(static_cast<std::size_t>(m.nbody) - 1);
  extent_.assign(links_.size(), 0.0);
  for (int g = 0; g < m.ngeom; ++g) {
    if (m.geom_bodyid[g] == 0) continue;
    double& extent = extent_[static_cast<std::size_t>(m.geom_bodyid[g]) - 1];
    extent = std::max(extent, Eigen::Map<const Vec3>(m.geom_pos + 3 * g).norm() + m.geom_rbound[g]);
  }
}

void Verifier::check_joints(const MotionSample& sample, double jump, double t, Ledger& ledger) const {
  const double margin = bounds_.limits.joint;
  const double most = bounds_.limits.acceleration;
  for (std::size_t j = 0; j < robot_->joints().size(); ++j) {
    const Joint& joint = robot_->joints()[j];
    const auto i = static_cast<Eigen::Index>(j);
    const double q = sample.q[7 + i];
    const double room = std::min(q - joint.position.lo, joint.position.hi - q);
    const auto subject = static_cast<int>(j);
    ledger.enter(Reason::joint_limit, Part::trunk, room, margin, t, subject);
    ledger.enter(Reason::joint_speed, Part::trunk, std::abs(sample.dq[6 + i]), joint.speed, t, subject);
    ledger.enter(Reason::joint_acceleration, Part::trunk, jump * std::abs(sample.ddq[6 + i]), most, t, subject);
  }
}

void Verifier::check_wrench(Motion& motion, int tick, double t, Ledger& ledger) {
  const Limits& limits = bounds_.limits;
  auto& samples = motion.samples;
  MotionSample& sample = samples[static_cast<std::size_t>(tick)];
  Wrench total = ground_wrench(kinematics_, sample.force);
  sample.zmp_height = support_plane(sample.sole, sample.contact);
  sample.zmp = total.zmp(sample.zmp_height);
  total = with_com_offset(total, limits.com_offset);
  const Vec2 zmp = sample.zmp + limits.com_offset;
  // At a phase border, the ZMP must lie in the support polygon of the soles that stand in both phases.
  const auto& before = tick == 0 ? motion.contact_before : samples[static_cast<std::size_t>(tick) - 1].contact;
  const BySide<bool> contact{sample.contact.left && before.left, sample.contact.right && before.right};
  const bool changes = before.left != sample.contact.left || before.right != sample.contact.right;
  const auto support = [&](const BySide<bool>& standing) {
    return support_polygon(*robot_, sample.sole, standing, sample.com, sample.zmp_height);
  };
  const bool level = on_one_plane(sample.sole, sample.contact, sample.zmp_height);
  if (tick > 0 && !changes && level) {
    sample.zmp_region = samples[static_cast<std::size_t>(tick) - 1].zmp_region;
  } else {
    support_ = support(sample.contact);
    sample.zmp_region = std::make_shared<const ConvexPolygon>(support_.inset(robot_->profile().margin.zmp_feedback));
  }
  const double inside = changes ? support(contact).margin(zmp) : support_.margin(zmp);
  ledger.enter(Reason::zmp, Part::trunk, inside, limits.zmp_verify, t, -1);
  const double friction = total.force.head<2>().norm() / total.force.z();
  ledger.enter(Reason::friction, Part::trunk, friction, limits.friction, t, -1);
  const double missing = forces_.missing(sample.sole, contact, total, sample.com);
  ledger.enter(Reason::contact_wrench, Part::trunk, missing, kWrenchTolerance, t, -1);
  const auto check_torques = [&](const BySide<bool>& standing) {
    joint_torques(kinematics_, sample.force, share_wrench(*robot_, sample.sole, standing, total), tau_);
    for (std::size_t j = 0; j < robot_->joints().size(); ++j) {
      const auto i = static_cast<Eigen::Index>(j);
      const double load = robot_->joints()[j].motor.load(tau_[i], sample.dq[6 + i]);
      ledger.enter(Reason::joint_torque, Part::trunk, load, limits.torque, t, static_cast<int>(j));
    }
  };
  check_torques(sample.contact);
  check_heat(motion, t, ledger);
  // In reverse, the contacts of the phase before hold at this sample.
  if (changes) check_torques(before);
}

void Verifier::check_heat(const Motion& motion, double t, Ledger& ledger) {
  if (!heat_model_.limited()) return;
  heat_model_.step(heat_, tau_);
  for (std::size_t j = 0; j < heat_.size(); ++j) {
    const double start = motion.heat.empty() ? 0.0 : motion.heat[j].total();
    const double limit = start > bounds_.limits.heat ? start + kHeatSlack : bounds_.limits.heat;
    ledger.enter(Reason::motor_heat, Part::trunk, heat_[j].total(), limit, t, static_cast<int>(j));
  }
}

Hottest Verifier::held(const MotionSample& last) {
  if (!heat_model_.limited()) return {};
  const VecX still = VecX::Zero(robot_->nv());
  VecX force = still;
  kinematics_.inverse_dynamics(last.q, still, still, force);
  const Wrench total = with_com_offset(ground_wrench(kinematics_, force), bounds_.limits.com_offset);
  joint_torques(kinematics_, force, share_wrench(*robot_, last.sole, last.contact, total), tau_);
  return heat_model_.held(tau_);
}

void Verifier::check_tracking(const MotionSample& sample, double t, Ledger& ledger) {
  const Profile::Ik& ik = robot_->profile().ik;
  double position = (kinematics_.com() - sample.com).norm();
  double rotation = 0.0;
  for (const Side side : kSides) {
    const Pose sole = kinematics_.sole(side);
    position = std::max(position, (sole.p - sample.sole[side].p).norm());
    rotation = std::max(rotation, rotation_error(sample.sole[side].R, sole.R).norm());
  }
  // On one scale: both tolerances count as 1.
  constexpr double kRounding = 1.01;
  const double residual = std::max(position / ik.position, rotation / ik.rotation);
  ledger.enter(Reason::unreachable, Part::trunk, residual * ik.position, kRounding * ik.position, t, -1);
}

double Verifier::max_tilt(const Motion& motion) {
  const auto lean = [this](const MotionSample& sample) {
    kinematics_.set(sample.q);
    return tilt_of(kinematics_.trunk().R);
  };
  // A trunk that leans too far already, as after a slip, must be able to straighten up; and to retrace its way.
  const double start = lean(motion.samples.front());
  return std::max({robot_->profile().region.trunk_inclination + kTiltSlack, start + kTiltRounding,
                   motion.retraces ? lean(motion.samples.back()) + kTiltRounding : 0.0});
}

double Verifier::edge_margin(const Motion& motion) const {
  // A foot may return to a foothold, even if a slip of a millimetre has moved that into the margin.
  return motion.retraces || motion.goal.returns ? 0.0 : baton::edge_margin(*robot_, motion.goal.place_uncertainty);
}

double Verifier::contact_height() const {
  return kContactHeight * robot_->profile().ik.position;
}

double Verifier::swing_margin(const Motion& motion, const Pose& anchor) const {
  const double most = edge_margin(motion);
  const auto up = first_swing_sample(motion);
  if (most == 0.0 || up == motion.samples.end()) return most;
  const Side swing = up->contact.left ? Side::right : Side::left;
  const Pose from = anchor * motion.swing.lift_off;
  const ConvexPolygon outline = sole_outline(*robot_, swing, from);
  for (double margin = most; margin > 0.0; margin -= kMarginStep * most) {
    if (from.p.z() - world_->highest_under(outline.inset(-margin)) >= contact_height()) return margin;
  }
  return 0.0;
}

double Verifier::least_height(const Motion& motion, const Pose& anchor) const {
  // A foot that stands lower than the mapped terrain lifts off from where it is.
  const auto up = first_swing_sample(motion);
  if (up == motion.samples.end()) return contact_height();
  const Side swing = up->contact.left ? Side::right : Side::left;
  const Pose from = anchor * motion.swing.lift_off;
  const double off =
      from.p.z() - world_->highest_under(sole_outline(*robot_, swing, from).inset(-bounds_.swing_margin));
  return std::clamp(off - kDistanceSlack, -robot_->profile().ground.flatness, contact_height());
}

double Verifier::clearance(const Motion& motion, std::size_t tick) const {
  const MotionSample& sample = motion.samples[tick];
  const Side swing = sample.contact.left ? Side::right : Side::left;
  const MotionSample& end = motion.samples.back();
  if (motion.retraces) return 0.0;
  const auto travel = [&](const Pose& there) {
    const double turn = wrap_angle(yaw_of(there.R) - yaw_of(sample.sole[swing].R));
    return (there.p - sample.sole[swing].p).head<2>().norm() + std::abs(turn) * robot_->profile().reach.foot;
  };
  double way = travel(motion.swing.lift_off);
  if (end.contact[swing]) way = std::min(way, travel(end.sole[swing]));
  return std::min(kTravelClearance * bounds_.limits.swing_clearance, kTravelSlope * way);
}

void Verifier::check_soles(const Motion& motion, std::size_t tick, const Pose& anchor, Ledger& ledger) const {
  const Profile& profile = robot_->profile();
  const MotionSample& sample = motion.samples[tick];
  const double t = static_cast<double>(tick) * motion.period;
  if (sample.contact.left && sample.contact.right) return;
  const Side swing = sample.contact.left ? Side::right : Side::left;
  const ConvexPolygon outline = sole_outline(*robot_, swing, sample.sole[swing]);
  const ConvexPolygon stance = sole_outline(*robot_, other(swing), sample.sole[other(swing)]);
  ledger.enter(Reason::sole_gap, foot(swing), separation(outline, stance), profile.region.sole_gap, t, -1);
  const Pose in_world = anchor * sample.sole[swing];
  const double ground = world_->highest_under(sole_outline(*robot_, swing, in_world).inset(-bounds_.swing_margin));
  const double least = bounds_.least_height + clearance(motion, tick);
  ledger.enter(Reason::swing_ground, foot(swing), in_world.p.z() - ground, least, t, -1);
}

void Verifier::check_footholds(const Motion& motion, const Pose& anchor, Ledger& ledger) const {
  // Only touchdowns are checked: soles in contact at the start stand already.
  const Profile& profile = robot_->profile();
  std::size_t tick = 0;
  for (std::size_t i = 1; i < motion.phases.size(); ++i) {
    tick += static_cast<std::size_t>(motion.phases[i - 1].ticks);
    for (const Side side : kSides) {
      if (!motion.phases[i].contact[side] || motion.phases[i - 1].contact[side]) continue;
      const Pose sole = anchor * motion.samples[tick].sole[side];
      const Foothold foothold =
          world_->foothold(sole_outline(*robot_, side, sole), profile.ground, edge_margin(motion));
      const double off = foothold.flat ? std::abs(sole.p.z() - foothold.height)
                                       : std::max(foothold.deviation, 2.0 * profile.ground.flatness);
      ledger.enter(Reason::ground, foot(side), off, profile.ground.flatness, static_cast<double>(tick) * motion.period,
                   -1);
    }
  }
}

double Verifier::travel() {
  double most = 0.0;
  for (std::size_t b = 0; b < links_.size(); ++b) {
    const Pose now = kinematics_.body(static_cast<int>(b) + 1);
    const double moved = (now.p - links_[b].p).norm() + extent_[b] * (now.R - links_[b].R).norm();
    most = std::max(most, moved);
    links_[b] = now;
  }
  return most;
}

void Verifier::check_distances(const MotionSample& sample, const Pose& anchor, bool first, double t, Ledger& ledger) {
  const double margin = bounds_.limits.self_collision;
  const double near = 4.0 * margin + 0.01;  // larger distances all count as this one
  const auto subject = [](const std::array<int, 2>& pair, int geoms) {
    return pair[0] < 0 ? -1 : pair[0] * geoms + pair[1];
  };
  // The travel of the links bounds how much a distance can shrink. It is measured again only when it may have become
  // the smallest so far.
  const double moved = travel();
  const auto due = [first](Gap& gap, double approach) {
    if (first) gap = {};
    gap.lower_bound -= approach;
    return first || gap.lower_bound < gap.smallest;
  };
  // Links that are too close already, as after a slip, must come no closer: they could not move apart otherwise.
  const auto enter = [&](Gap& gap, Reason reason, double touching, double distance, int pair) {
    const bool near_already = distance > touching && distance < margin;
    if (first) gap.limit = near_already ? distance - kDistanceSlack : margin;
    gap.lower_bound = distance;
    gap.smallest = std::min({gap.smallest, distance, near});
    ledger.enter(reason, Part::trunk, std::min(distance, near), gap.limit, t, distance < near ? pair : -1);
  };
  if (due(self_gap_, 2.0 * moved)) {
    std::array<int, 2> pair{-1, -1};
    const double distance = kinematics_.self_distance(2.0 * near, &pair);
    enter(self_gap_, Reason::self_collision, 0.0, distance, subject(pair, robot_->mj().ngeom));
  }
  bool set = false;
  for (const bool by_map : {false, true}) {
    Gap& gap = by_map ? map_gap_ : world_gap_;
    if (!due(gap, moved)) continue;
    if (!std::exchange(set, true)) {
      in_world_ = sample.q;
      set_root(in_world_, anchor * kinematics_.body(1));
      obstacles_.set(in_world_);
    }
    std::array<int, 2> pair{-1, -1};
    const double unsure = by_map ? bounds_.uncertainty : 0.0;
    const double distance = obstacles_.distance(by_map, 2.0 * near + unsure, pair) - unsure;
    enter(gap, Reason::obstacle, -unsure, distance, subject(pair, obstacles_.geoms()));
  }
}

std::variant<VerifiedMotion, Refusal> Verifier::verify(Motion motion, const Pose& anchor, const Limits& limits) {
  Ledger ledger;
  const auto name = [this](Reason quantity, int subject) -> std::string {
    if (subject < 0) return "";
    if (quantity == Reason::obstacle) {
      return fmt::format("{} and {}", obstacles_.name(subject / obstacles_.geoms()),
                         obstacles_.name(subject % obstacles_.geoms()));
    }
    if (quantity != Reason::self_collision) return robot_->joints()[static_cast<std::size_t>(subject)].name;
    const int n = robot_->mj().ngeom;
    return fmt::format("{} and {}", name_of(robot_->mj(), mjOBJ_GEOM, subject / n),
                       name_of(robot_->mj(), mjOBJ_GEOM, subject % n));
  };
  const VecX& last = motion.samples.back().q;
  const auto is_last = [&last](const VecX& q) { return q.size() == last.size() && q == last; };
  if (!is_last(motion.end.q) || !is_last(motion.rest.q))
    throw std::invalid_argument("a motion must rest in the posture of its last sample");
  bounds_.limits = limits;
  forces_.set(limits);
  bounds_.swing_margin = swing_margin(motion, anchor);
  bounds_.least_height = least_height(motion, anchor);
  // Cheap checks first, at all ticks even after a violation: the worst speed tells how much longer the motion must be.
  for (int k = 0; k <= motion.ticks(); ++k) {
    const MotionSample& sample = motion.samples[static_cast<std::size_t>(k)];
    if (!is_finite(sample)) return Refusal{Reason::not_finite, Part::trunk, 0, 0, ""};
    // The next motion may begin at once where this one ends at rest, so their accelerations may add up.
    const bool rests = k == motion.ticks() || (k == 0 && motion.dq0.isZero(0.0));
    check_joints(sample, rests ? 2.0 : 1.0, k * motion.period, ledger);
    check_soles(motion, static_cast<std::size_t>(k), anchor, ledger);
  }
  check_footholds(motion, anchor, ledger);
  bounds_.tilt = max_tilt(motion);
  bounds_.uncertainty = obstacle_uncertainty(*robot_, motion.retraces ? 0.0 : motion.goal.place_uncertainty);
  heat_ = motion.heat.empty() ? heat_model_.cold() : motion.heat;
  for (int k = 0; k <= motion.ticks() && !ledger.violated(); ++k) {
    MotionSample& sample = motion.samples[static_cast<std::size_t>(k)];
    const double t = k * motion.period;
    sample.force.resize(robot_->nv());
    kinematics_.inverse_dynamics(sample.q, sample.dq, sample.ddq, sample.force);
    check_tracking(sample, t, ledger);
    ledger.enter(Reason::trunk_inclination, Part::trunk, tilt_of(kinematics_.trunk().R), bounds_.tilt, t, -1);
    check_wrench(motion, k, t, ledger);
    check_distances(sample, anchor, k == 0, t, ledger);
  }
  if (std::optional<Refusal> refusal = ledger.refusal(name)) return *std::move(refusal);
  motion.end.heat = heat_;
  motion.held = held(motion.samples.back());
  return VerifiedMotion(std::move(motion), ledger.certificate(name));
}

}  // namespace baton
