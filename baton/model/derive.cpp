#include "baton/model/derive.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdlib>
#include <limits>
#include <numbers>
#include <optional>
#include <random>
#include <set>

#include "baton/model/anatomy.hpp"
#include "baton/model/error.hpp"
#include "baton/model/robot_file.hpp"
#include "baton/model/urdf.hpp"

namespace baton {
namespace {

namespace fs = std::filesystem;

constexpr double kDegrees = 180.0 / std::numbers::pi;
constexpr double kStraight = 0.92;         ///< COM height over that with straight legs
constexpr double kStraightest = 0.97;      ///< the same, where the knee is too weak for that
constexpr double kReachable = 0.994;       ///< the same, of what there is room for
constexpr double kKneeLoad = 0.6;          ///< static torque of the knee on one leg that is aimed at [stall torque]
constexpr double kAssumedArmature = 1e-4;  ///< of a motor whose model states none [kg·m² per N·m of stall torque]
constexpr double kAssumedSpeed = 2.5;      ///< largest speed of a joint whose model states none [ω]
constexpr double kFastest = 20.0;  ///< a larger no-load speed by damping is none: the damping is not the motor's [ω]
constexpr double kServoDamping = 0.5;  ///< damping ratio of a servo with the inertia that it moves at q = 0
constexpr double kStallAngle = 0.25;   ///< error at which a servo gives its stall torque, if soft enough [rad]
constexpr int kHomeSamples = 4000;     ///< postures of an arm that are looked at for its home
constexpr int kPairSamples = 200;      ///< postures in which the distances of links are looked at
constexpr double kApart = 0.015;       ///< links that are nearer at home are made to be [COM height]
constexpr double kNear = 0.05;         ///< links that never come nearer need no check [COM height]

double rounded(double value, double unit) {
  return std::round(value / unit) * unit;
}

/// With four significant digits.
double to_digits(double value) {
  if (value == 0.0) return 0.0;
  const double unit = std::pow(10.0, std::floor(std::log10(std::abs(value))) - 3.0);
  return std::strtod(fmt::format("{:.9g}", rounded(value, unit)).c_str(), nullptr);
}

/// Fills a table; keys that it has stay.
class Filler {
 public:
  explicit Filler(CompleteProfile& profile) : profile_(profile) {}

  template <typename Value>
  void operator()(const std::string& key, Value&& value, const std::string& source) {
    if (profile_.table.at_path(key)) return;
    toml::table* table = &profile_.table;
    std::string rest = key;
    for (std::size_t dot = rest.find('.'); dot != std::string::npos; dot = rest.find('.')) {
      const std::string name = rest.substr(0, dot);
      if (!table->contains(name)) table->insert(name, toml::table{});
      table = table->get_as<toml::table>(name);
      if (table == nullptr) return;  // not a table: whoever reads it complains
      rest = rest.substr(dot + 1);
    }
    table->insert(rest, std::forward<Value>(value));
    profile_.sources[key] = source;
  }
  void length(const std::string& key, double factor, double unit, const char* symbol) {
    (*this)(key, to_digits(factor * unit), fmt::format("{:.3g} {}", factor, symbol));
  }
  [[nodiscard]] double number(const std::string& key, double missing) const {
    return profile_.table.at_path(key).value<double>().value_or(missing);
  }
  [[nodiscard]] std::string text(const std::string& key) const {
    return profile_.table.at_path(key).value<std::string>().value_or("");
  }

 private:
  CompleteProfile& profile_;
};

toml::array interval(double lo, double hi) {
  return toml::array{to_digits(lo), to_digits(hi)};
}

std::vector<std::string> texts(const toml::node* node) {
  std::vector<std::string> list;
  const toml::array* array = node == nullptr ? nullptr : node->as_array();
  for (std::size_t i = 0; array != nullptr && i < array->size(); ++i)
    list.push_back((*array)[i].value<std::string>().value_or(""));
  return list;
}

/// A compiled model, posed.
class Posed {
 public:
  /// At q = 0, the first body level at the origin.
  explicit Posed(const mjModel& model) : m(model), data(mj_makeData(&model)) {
    std::fill_n(data->qpos, 7, 0.0);
    data->qpos[3] = 1.0;
    mj_kinematics(&m, data.get());
  }

  [[nodiscard]] Pose body(int b) const {
    return {Eigen::Map<const Vec3>(data->xpos + 3 * b),
            Eigen::Map<const Eigen::Matrix<double, 3, 3, Eigen::RowMajor>>(data->xmat + 9 * b)};
  }
  void set(int joint, double angle) { data->qpos[m.jnt_qposadr[joint]] = angle; }
  void update() { mj_kinematics(&m, data.get()); }
  [[nodiscard]] double com_height() {
    mj_comPos(&m, data.get());
    return data->subtree_com[3 * 1 + 2];
  }

  const mjModel& m;
  DataPtr data;
};

/// Hinges on the way from an ancestor to a body, nearest to the ancestor first.
std::vector<int> chain(const mjModel& m, int ancestor, int body) {
  std::vector<int> joints;
  for (int b = body; b > ancestor; b = m.body_parentid[b]) {
    for (int j = m.body_jntadr[b] + m.body_jntnum[b] - 1; j >= m.body_jntadr[b] && m.body_jntadr[b] >= 0; --j) {
      if (m.jnt_type[j] == mjJNT_HINGE) joints.push_back(j);
    }
  }
  std::ranges::reverse(joints);
  return joints;
}

/// Index of the body that a part's name stands for: a body, or the one that a site is on. −1: there is none.
int body_of(const mjModel& m, const std::string& name) {
  const int site = mj_name2id(&m, mjOBJ_SITE, name.c_str());
  return site >= 0 ? m.site_bodyid[site] : mj_name2id(&m, mjOBJ_BODY, name.c_str());
}

/// The leg between hip (its third axis) and ankle (its last but one).
struct Knee {
  int joint = -1;                   ///< that changes their distance most
  double now = 0.0;                 ///< distance at q = 0 [m]
  double straight = 0.0;            ///< largest distance [m]
  double thigh = 0.0, shank = 0.0;  ///< [m]

  /// Distance of the knee's axis from the line between hip and ankle.
  /// @param d from hip to ankle [m]
  [[nodiscard]] double lever(double d) const {
    const double along = (d * d + thigh * thigh - shank * shank) / (2.0 * d);
    return std::sqrt(std::max(0.0, thigh * thigh - along * along));
  }
};

Knee knee_of(const mjModel& m, const std::vector<int>& leg) {
  Posed posed(m);
  const auto distance = [&posed](int from, int to) {
    const auto at = [&posed](int j) { return Vec3(Eigen::Map<const Vec3>(posed.data->xanchor + 3 * j)); };
    return (at(from) - at(to)).norm();
  };
  const int hip = leg[2];
  const int ankle = leg[leg.size() - 2];
  Knee knee;
  knee.now = knee.straight = distance(hip, ankle);
  double widest = -1.0;
  for (std::size_t i = 3; i + 2 < leg.size(); ++i) {
    const int j = leg[i];
    const double before = m.qpos0[m.jnt_qposadr[j]];
    double least = knee.now;
    double most = knee.now;
    for (int k = 0; k <= 40; ++k) {
      posed.set(j, m.jnt_range[2 * j] + k / 40.0 * (m.jnt_range[2 * j + 1] - m.jnt_range[2 * j]));
      posed.update();
      least = std::min(least, distance(hip, ankle));
      most = std::max(most, distance(hip, ankle));
    }
    knee.straight = std::max(knee.straight, most);
    if (most - least > widest) {
      widest = most - least;
      knee.joint = j;
    }
    posed.set(j, before);
  }
  posed.update();
  if (knee.joint < 0) return knee;
  knee.thigh = distance(hip, knee.joint);
  knee.shank = distance(knee.joint, ankle);
  return knee;
}

/// COM height over that with straight legs: as bent as mighty's, or straighter, if the knee is too weak to carry the
/// robot on one leg like that.
/// @param height of the COM with straight legs [m]
/// @param stall torque of the knee [N·m]
double straightness(const Knee& knee, double height, double weight, double stall) {
  double straight = kStraight;
  const auto load = [&] { return weight * knee.lever(knee.straight - (1.0 - straight) * height) / stall; };
  while (knee.joint >= 0 && stall > 0.0 && straight < kStraightest - 1e-9 && load() > kKneeLoad)
    straight += 0.005;
  return straight;
}

/// Home of an arm [rad]: of many postures, the one whose hand is nearest to half an arm's length before and below the
/// shoulder and a quarter outside it, joints far from their limits.
std::vector<double> arm_home(const mjModel& m, const std::vector<int>& arm, int shoulder, int hand, Side side) {
  Posed posed(m);
  double length = 0.0;
  for (int b = hand; b != shoulder; b = m.body_parentid[b])
    length += Eigen::Map<const Vec3>(m.body_pos + 3 * b).norm();
  const Vec3 tip = Eigen::Map<const Vec3>(m.body_ipos + 3 * hand);
  length += tip.norm();
  const Vec3 at = posed.body(shoulder).p;
  const Vec3 wanted = at + length * Vec3(0.45, 0.25 * sign_of(side), -0.5);
  const auto cost = [&](const std::vector<double>& angles) {
    double sum = 0.0;
    for (std::size_t k = 0; k < arm.size(); ++k) {
      posed.set(arm[k], angles[k]);
      const double lo = m.jnt_range[2 * arm[k]];
      const double hi = m.jnt_range[2 * arm[k] + 1];
      const double from_centre = (angles[k] - 0.5 * (lo + hi)) / (hi - lo);
      sum += 0.02 * angles[k] * angles[k] + 0.5 * std::pow(std::max(0.0, std::abs(from_centre) - 0.4) / 0.1, 2);
    }
    posed.update();
    const Vec3 error = (posed.body(hand) * tip - wanted) / length;
    return sum + 20.0 * error.squaredNorm();
  };
  std::mt19937_64 random(1);
  std::vector<double> best(arm.size());
  for (std::size_t k = 0; k < arm.size(); ++k)
    best[k] = std::clamp(0.0, m.jnt_range[2 * arm[k]], m.jnt_range[2 * arm[k] + 1]);
  double least = cost(best);
  for (int sample = 0; sample < kHomeSamples; ++sample) {
    const double spread = sample < kHomeSamples / 4 ? 1.0 : std::exp(-6.0 * sample / kHomeSamples);
    std::vector<double> angles(arm.size());
    for (std::size_t k = 0; k < arm.size(); ++k) {
      const double lo = m.jnt_range[2 * arm[k]];
      const double hi = m.jnt_range[2 * arm[k] + 1];
      std::uniform_real_distribution<double> draw(-0.5 * spread * (hi - lo), 0.5 * spread * (hi - lo));
      angles[k] = std::clamp((spread < 1.0 ? best[k] : 0.5 * (lo + hi)) + draw(random), lo, hi);
    }
    const double c = cost(angles);
    if (c >= least) continue;
    least = c;
    best = angles;
  }
  return best;
}

/// The other arm's home, mirrored. Empty if the arms are no mirror images.
std::vector<double> mirrored(const mjModel& m, const std::vector<int>& from, const std::vector<int>& to,
                             const std::vector<double>& angles) {
  if (from.size() != to.size()) return {};
  const Posed posed(m);
  std::vector<double> result;
  for (std::size_t k = 0; k < from.size(); ++k) {
    const Vec3 axis = Eigen::Map<const Vec3>(posed.data->xaxis + 3 * from[k]);
    const Vec3 there = Eigen::Map<const Vec3>(posed.data->xaxis + 3 * to[k]);
    const double sign = Vec3(-axis.x(), axis.y(), -axis.z()).dot(there);
    if (std::abs(sign) < 0.99) return {};
    result.push_back(
        std::clamp(std::copysign(1.0, sign) * angles[k], m.jnt_range[2 * to[k]], m.jnt_range[2 * to[k] + 1]));
  }
  return result;
}

/// Number of hinges between two bodies.
int joints_between(const mjModel& m, int a, int b) {
  const int common = common_ancestor(m, a, b);
  return static_cast<int>(chain(m, common, a).size() + chain(m, common, b).size());
}

/// Pairs of links that come near each other in some postures, but not at home. Links that two joints connect, or the
/// three of a hip, are no pair: their joints' ranges keep them apart.
toml::array self_pairs(const mjModel& m, const BySide<int>& foot, const std::map<std::string, double>& home, double h) {
  Posed posed(m);
  std::vector<int> colliders;
  for (int g = 0; g < m.ngeom; ++g) {
    if (m.geom_contype[g] != 0 || m.geom_conaffinity[g] != 0) colliders.push_back(g);
  }
  std::vector<std::pair<int, int>> candidates;
  for (std::size_t i = 0; i < colliders.size(); ++i) {
    for (std::size_t k = i + 1; k < colliders.size(); ++k) {
      const int a = m.geom_bodyid[colliders[i]];
      const int b = m.geom_bodyid[colliders[k]];
      const bool hip = std::ranges::any_of(kSides, [&](Side side) {
        return common_ancestor(m, std::max(a, b), foot[side]) == std::max(a, b);  // the farther one is of that leg
      });
      if (joints_between(m, a, b) <= (hip ? 3 : 2)) continue;
      candidates.emplace_back(colliders[i], colliders[k]);
    }
  }
  const auto distance = [&](const std::pair<int, int>& pair) {
    const auto [a, b] = pair;
    const Vec3 between =
        Eigen::Map<const Vec3>(posed.data->geom_xpos + 3 * a) - Eigen::Map<const Vec3>(posed.data->geom_xpos + 3 * b);
    const double far = kNear * h;
    if (between.norm() - m.geom_rbound[a] - m.geom_rbound[b] >= far) return far;
    return mj_geomDistance(&m, posed.data.get(), a, b, far, nullptr);
  };
  for (int j = 1; j < m.njnt; ++j) {
    const auto angle = home.find(name_of(m, mjOBJ_JOINT, j));
    posed.set(j, angle == home.end() ? std::clamp(0.0, m.jnt_range[2 * j], m.jnt_range[2 * j + 1]) : angle->second);
  }
  posed.update();
  std::erase_if(candidates, [&](const auto& pair) { return distance(pair) < kApart * h; });
  std::vector<bool> near(candidates.size(), false);
  std::mt19937_64 random(1);
  for (int sample = 0; sample < kPairSamples; ++sample) {
    for (int j = 1; j < m.njnt; ++j) {
      std::uniform_real_distribution<double> draw(m.jnt_range[2 * j], m.jnt_range[2 * j + 1]);
      posed.set(j, draw(random));
    }
    posed.update();
    for (std::size_t k = 0; k < candidates.size(); ++k) {
      if (!near[k] && distance(candidates[k]) < kNear * h) near[k] = true;
    }
  }
  toml::array pairs;
  for (std::size_t k = 0; k < candidates.size(); ++k) {
    if (!near[k]) continue;
    pairs.push_back(
        toml::array{name_of(m, mjOBJ_GEOM, candidates[k].first), name_of(m, mjOBJ_GEOM, candidates[k].second)});
  }
  return pairs;
}

/// What is known of the motors, joint by joint.
class Motors {
 public:
  Motors(const mjModel& model, const fs::path& file, double omega)
      : m_(model), omega_(omega), inertia_(static_cast<std::size_t>(model.nv * model.nv)) {
    if (is_urdf(file)) speeds_ = urdf_speed_limits(file);
    Posed posed(m_);
    mj_comPos(&m_, posed.data.get());
    mj_crb(&m_, posed.data.get());
    mj_fullM(&m_, posed.data.get(), inertia_.data());
  }

  /// Reflected inertia that has to be assumed; 0 if the model states one [kg·m²].
  [[nodiscard]] double assumed_armature(int joint) const {
    const bool stated = m_.dof_armature[m_.jnt_dofadr[joint]] > 0.0;
    return stated ? 0.0 : to_digits(kAssumedArmature * torque(joint));
  }
  /// No-load speed by the file or, if nothing sets one, assumed; 0 if damping sets it [rad/s].
  [[nodiscard]] double speed(int joint, bool& assumed) const {
    const auto stated = speeds_.find(name_of(m_, mjOBJ_JOINT, joint));
    const double damping = m_.dof_damping[m_.jnt_dofadr[joint]];
    assumed = stated == speeds_.end() && (damping <= 0.0 || torque(joint) / damping > kFastest * omega_);
    if (stated != speeds_.end()) return stated->second;
    return assumed ? to_digits(kAssumedSpeed * omega_) : 0.0;
  }
  [[nodiscard]] double torque(int joint) const { return m_.jnt_actfrcrange[2 * joint + 1]; }
  /// Inertia that the joint moves at q = 0, with this armature [kg·m²].
  [[nodiscard]] double inertia(int joint, double armature) const {
    const int dof = m_.jnt_dofadr[joint];
    return inertia_[static_cast<std::size_t>(dof * (m_.nv + 1))] - m_.dof_armature[dof] + armature;
  }

 private:
  const mjModel& m_;
  double omega_;
  std::vector<double> inertia_;
  std::map<std::string, double> speeds_;
};

/// Adds rows for the joints that have none, and to given rows what the model lacks.
void derive_servos(const mjModel& m, const fs::path& model, double omega, double weight_height, CompleteProfile& out) {
  const Motors motors(m, model, omega);
  std::vector<std::string> slow;
  std::vector<std::string> light;
  const auto speed_of = [&](int joint) {
    bool assumed = false;
    const double speed = motors.speed(joint, assumed);
    if (assumed) slow.push_back(name_of(m, mjOBJ_JOINT, joint));
    return speed;
  };
  const auto armature_of = [&](int joint) {
    const double armature = motors.assumed_armature(joint);
    if (armature > 0.0) light.push_back(name_of(m, mjOBJ_JOINT, joint));
    return armature;
  };
  toml::array rows;
  std::set<std::string> named;
  if (const toml::array* given = out.table.at_path("drive.gains").as_array()) {
    for (const toml::node& node : *given) {
      const toml::table& row = *node.as_table();  // as validated
      std::map<std::array<double, 2>, toml::array> lacking;
      for (const std::string& name : texts(row.get("joints"))) {
        named.insert(name);
        const int joint = mj_name2id(&m, mjOBJ_JOINT, name.c_str());
        const bool known = joint > 0 && m.jnt_type[joint] == mjJNT_HINGE;
        const double armature = known && !row.contains("armature") ? armature_of(joint) : 0.0;
        const double speed = known && !row.contains("speed") ? speed_of(joint) : 0.0;
        lacking[{armature, speed}].push_back(name);
      }
      for (auto& [what, joints] : lacking) {
        toml::table part = row;
        part.insert_or_assign("joints", joints);
        if (what[0] > 0.0) part.insert("armature", what[0]);
        if (what[1] > 0.0) part.insert("speed", what[1]);
        rows.push_back(std::move(part));
      }
    }
  }
  std::map<std::array<double, 5>, toml::array> kinds;  // torque, armature, speed, kp, kd → joints
  for (int j = 1; j < m.njnt; ++j) {
    const std::string joint = name_of(m, mjOBJ_JOINT, j);
    if (named.contains(joint)) continue;
    const double assumed = armature_of(j);
    const double armature = assumed > 0.0 ? assumed : m.dof_armature[m.jnt_dofadr[j]];
    const double kp = to_digits(std::min(motors.torque(j) / kStallAngle, weight_height));
    const double kd = to_digits(2.0 * kServoDamping * std::sqrt(kp * motors.inertia(j, armature)));
    kinds[{motors.torque(j), armature, speed_of(j), kp, kd}].push_back(joint);
  }
  const auto missing = [&out](const std::vector<std::string>& joints, const std::string& what) {
    if (joints.empty()) return;
    out.warnings.push_back(
        fmt::format("{} joints ({}{}): {}", joints.size(), joints.front(), joints.size() > 1 ? ", …" : "", what));
  };
  missing(light, fmt::format("the model states no armature; {} kg·m² per N·m of stall torque are assumed "
                             "(drive.gains.armature)",
                             kAssumedArmature));
  missing(slow, fmt::format("the model states no speed limit; {} rad/s are assumed (drive.gains.speed)",
                            to_digits(kAssumedSpeed * omega)));
  for (auto& [kind, joints] : kinds) {
    const auto& [torque, armature, speed, kp, kd] = kind;
    toml::table row{{"kp", kp}, {"kd", kd}, {"torque", torque}, {"armature", armature}};
    if (speed > 0.0) row.insert("speed", speed);
    row.insert("joints", joints);
    rows.push_back(std::move(row));
  }
  if (!out.table.contains("drive")) out.table.insert("drive", toml::table{});
  out.table["drive"].as_table()->insert_or_assign("gains", std::move(rows));
  if (kinds.empty()) return;
  out.sources["drive.gains"] = fmt::format(
      "kp: stall torque per {} rad, at most m g h; kd: damping ratio {} at q = 0; torque, armature, speed: the model",
      kStallAngle, kServoDamping);
}

constexpr double kNarrowSole = 0.1;  ///< half-width below which a sole is narrow [COM height]

/// What lengths and times are derived from.
struct Size {
  double h = 0.0;           ///< COM height [m]
  double w = 0.0;           ///< half-width of a sole [m]
  double width = 0.0;       ///< of the stance [m]
  double arm_length = 0.0;  ///< from shoulder to hand [m]
  double straight = 0.0;    ///< COM height with straight legs [m]
};

/// Everything that depends on the size alone.
void fill_from(const Size& size, Filler& fill) {
  const auto [h, w, width, arm_length, straight] = size;
  fill.length("reach.foot", 0.05 / 0.26, h, "h");
  fill.length("reach.trunk", 0.03 / 0.26, h, "h");
  fill.length("reach.hand", 0.03 / 0.1939, arm_length, "of the arm's length");
  fill("reach.rotation", 0.2, "fixed");
  fill("region.foot_x", interval(-0.11 / 0.26 * h, 0.11 / 0.26 * h), "0.423 h");
  fill.length("region.stride", 0.07 / 0.26, h, "h");
  fill("region.foot_lateral", interval(2.0 * w + 0.004 / 0.26 * h, width + 0.066 / 0.26 * h),
       "2 w + 0.0154 h to the stance width + 0.254 h");
  fill("region.foot_yaw", 0.35, "fixed");
  fill.length("region.sole_gap", 0.006 / 0.26, h, "h");
  fill("region.com_height", interval(0.235 / 0.26 * h, std::max(h, std::min(0.28 / 0.26 * h, kReachable * straight))),
       "0.904 to 1.08 h, at most 0.994 of straight legs");
  fill("region.trunk_inclination", 0.3, "fixed");
  fill("region.trunk_yaw", 0.15, "fixed");
  fill.length("region.hand_distance", 0.18 / 0.1939, arm_length, "of the arm's length");
  fill.length("swing.clearance", 0.02 / 0.26, h, "h");
  fill.length("swing.lift", 0.03 / 0.26, h, "h");
  const auto time = [&fill, h = h](const std::string& key, double of_mighty) {
    fill(key, rounded(of_mighty * std::sqrt(h / 0.26), 0.01),
         fmt::format("{:.3g} / ω", of_mighty * std::sqrt(kGravity / 0.26)));
  };
  time("swing.time", 0.2);
  fill.length("ground.flatness", 0.002 / 0.26, h, "h");
  fill("ground.tilt_deg", 3.0, "fixed");
  time("duration.default", 0.5);
  time("duration.step", 0.1);
  time("duration.max", 3.0);
  fill("phases.step", toml::array{0.25, 0.40, 0.35}, "fixed");
  fill("phases.lift", toml::array{0.5, 0.5}, "fixed");
  fill("phases.lower", toml::array{0.5, 0.5}, "fixed");
  const bool narrow = w < kNarrowSole * h;
  if (narrow) {  // with less room for the ZMP the transfer of the weight takes longer
    fill("phases.flow", toml::array{0.20, 0.42, 0.38}, fmt::format("w < {} h", kNarrowSole));
  } else {
    fill("phases.flow", toml::array{0.15, 0.45, 0.40}, fmt::format("w ≥ {} h", kNarrowSole));
  }
  fill("phases.weights", toml::array{1.0, 3.0, 3.0, 1.0}, "fixed");
  // Soles that are narrow tip outward sooner, and what tips them is a matter of angles, so of the height. Inward there
  // is the other foot: half of what that leaves of the width is for the ZMP.
  fill.length("margin.zmp_outward", narrow ? 0.065 : 0.012 / 0.26, h, "h");
  const double left = (2.0 * w - fill.number("margin.zmp_outward", 0.0)) / 4.0;
  if (left < w / 3.0) {
    fill("margin.zmp_plan", to_digits(std::max(left, w / 12.0)), "(2 w - zmp_outward) / 4, at least w / 12");
  } else {
    fill.length("margin.zmp_plan", 12.0 / 36.0, w, "w");
  }
  fill.length("margin.zmp_verify", 3.0 / 36.0, w, "w");
  fill.length("margin.zmp_feedback", 4.0 / 36.0, w, "w");
  fill.length("margin.stand_on", 25.0 / 36.0, w, "w");
  fill("margin.joint", 0.02, "fixed");
  fill("margin.speed", 0.85, "fixed");
  fill("margin.torque", 0.9, "fixed");
  fill("margin.acceleration", to_digits(220.0 * 0.26 / h), "5.83 ω²");
  fill("margin.friction", 0.5, "fixed");
  fill.length("margin.self_collision", 0.003 / 0.26, h, "h");
  fill.length("margin.edge", 0.002 / 0.26, h, "h");
  fill.length("ik.position", 1e-4 / 0.26, h, "h");
  fill("ik.rotation", 1e-4, "fixed");
  fill.length("ik.hand", 2e-3 / 0.26, h, "h");
  fill("tick.period", 0.005, "fixed");
  fill("tick.lookahead", 6, "fixed");
  fill("stabiliser.k_dcm", 3.0, "fixed");
  fill("drive.kind", "pd", "fixed");
}

}  // namespace

CompleteProfile of_no_robot(const toml::table& given) {
  CompleteProfile out;
  out.table = given;
  Filler fill(out);
  fill("name", "robot", "");
  for (const char* key :
       {"trunk", "left_foot", "right_foot", "left_hand", "right_hand", "left_shoulder", "right_shoulder"})
    fill(fmt::format("parts.{}", key), "part", "");
  const Size size{0.05, 0.01, 0.05, 0.05, 0.06};  // small, so that no derived bound is above a given one
  fill("stance.com_height", size.h, "");
  fill("stance.width", size.width, "");
  fill("home_deg", toml::table{}, "");
  fill("duration.max", std::max(60.0, fill.number("duration.default", 0.0)), "");
  fill("duration.default", 0.05, "");
  fill_from(size, fill);
  if (!out.table.at_path("drive.gains")) fill("drive.gains", toml::array{}, "");
  return out;
}

CompleteProfile complete(const toml::table& given, const fs::path& folder, const std::string& file) {
  CompleteProfile out;
  out.table = given;
  Filler fill(out);
  const std::string model_name = fill.text("model");
  if (model_name.empty()) return out;  // whoever reads it complains
  const fs::path path = (folder / model_name).lexically_normal();
  fill("name", fs::path(model_name).stem().string(), "the model's file");
  const std::string owner = fmt::format("model {}", path.string());
  std::error_code ignored;
  if (*fs::path(model_name).begin() == "model" && !fs::exists(path, ignored)) {
    throw InputError(
        fmt::format("profile {}: its model {} is not there: `make robots` (or `python -m baton.fetch_robots`) "
                    "fetches the models of the robots that are shipped as profiles",
                    file, path.string()));
  }

  ModelChanges changes;
  changes.rigid = texts(out.table.get("rigid"));
  const auto compiled = [&] {
    const SpecPtr spec = read_robot(path, changes, Visuals::drop);
    spec->compiler.discardvisual = 1;
    return compile_model(*spec, owner);
  };
  ModelPtr model = compiled();
  const Anatomy parts = find_parts(*model);
  const auto body = [&](int id) { return id < 0 ? std::string() : name_of(*model, mjOBJ_BODY, id); };
  const auto part = [&](const std::string& key, int id, const char* how) {
    if (id >= 0) fill("parts." + key, body(id), how);
  };
  part("trunk", parts.trunk, "the last body that both arms hang from");
  for (const Side side : kSides) {
    const std::string of(to_string(side));
    part(of + "_foot", parts.foot[side], "the lowest end of a chain of six hinges or more");
    part(of + "_hand", parts.hand[side], "the end of the heaviest limb on that side, fingers aside");
    part(of + "_shoulder", parts.shoulder[side], "the first body of that limb");
  }
  fill("parts.imu", parts.imu.empty() ? body(1) : parts.imu, parts.imu.empty() ? "assumed" : "the model");
  if (parts.imu.empty() && fill.text("parts.imu") == body(1)) {
    out.warnings.push_back(
        fmt::format("the model has no IMU on its first body; one at the origin of '{}' is assumed "
                    "(parts.imu)",
                    body(1)));
  }
  if (!parts.fingers.empty()) {
    toml::array rigid;
    for (const std::string& joint : parts.fingers)
      rigid.push_back(joint);
    if (!out.table.contains("rigid")) {
      out.warnings.push_back(fmt::format("{} joints beyond the hands ({}, …) are held at zero (rigid)",
                                         parts.fingers.size(), parts.fingers.front()));
    }
    fill("rigid", rigid, "joints beyond the hands");
    changes.rigid = texts(out.table.get("rigid"));
    model = compiled();
  }
  const mjModel& m = *model;
  std::map<std::string, double> given_torques;  // of joints
  if (const toml::array* rows = out.table.at_path("drive.gains").as_array()) {
    for (const toml::node& row : *rows) {
      const toml::table* table = row.as_table();
      if (table == nullptr || !table->contains("torque")) continue;
      for (const std::string& joint : texts(table->get("joints")))
        given_torques[joint] = table->get("torque")->value<double>().value_or(0.0);
    }
  }

  // What the parts say.
  BySide<int> foot{-1, -1};
  BySide<int> hand{-1, -1};
  BySide<int> shoulder{-1, -1};
  std::vector<std::string> problems;
  for (const Side side : kSides) {
    const std::string of(to_string(side));
    foot[side] = body_of(m, fill.text("parts." + of + "_foot"));
    hand[side] = body_of(m, fill.text("parts." + of + "_hand"));
    shoulder[side] = body_of(m, fill.text("parts." + of + "_shoulder"));
    for (const auto& [name, found] :
         {std::pair("foot", foot[side]), std::pair("hand", hand[side]), std::pair("shoulder", shoulder[side])}) {
      const std::string key = fmt::format("parts.{}_{}", of, name);
      const std::string value = fill.text(key);
      if (found == 0) problems.push_back(fmt::format("{} = '{}': must be a part of the robot", key, value));
      if (found < 0 && !value.empty())
        problems.push_back(fmt::format("{} = '{}': the model has no such body or site", key, value));
      if (found < 0 && value.empty()) problems.push_back(fmt::format("{} is missing: must be a body or site", key));
    }
  }
  if (!parts.no_arms.empty() && std::min({hand.left, hand.right, shoulder.left, shoulder.right}) < 0) {
    problems.insert(problems.begin(), parts.no_arms);
  }
  if (!parts.no_legs.empty() && std::min(foot.left, foot.right) < 0) problems.insert(problems.begin(), parts.no_legs);
  for (const Side side : kSides) {
    const std::string of(to_string(side));
    if (foot.left >= 0 && foot.right >= 0) {
      const std::size_t joints = chain(m, common_ancestor(m, foot.left, foot.right), foot[side]).size();
      if (joints < 6) {
        problems.push_back(
            fmt::format("the leg to parts.{}_foot = '{}' has {} joints of its own: at least 6 are needed", of,
                        fill.text("parts." + of + "_foot"), joints));
      }
    }
    if (hand[side] >= 0 && shoulder[side] >= 0 && common_ancestor(m, hand[side], shoulder[side]) != shoulder[side]) {
      problems.push_back(fmt::format("parts.{0}_hand = '{1}' does not hang from parts.{0}_shoulder = '{2}'", of,
                                     fill.text("parts." + of + "_hand"), fill.text("parts." + of + "_shoulder")));
    }
  }
  Posed posed(m);
  BySide<Pose> foot_frame;  // of the sole's attitude, in the foot
  BySide<SoleShape> sole;
  for (const Side side : kSides) {
    if (foot[side] < 0) continue;
    const int site = mj_name2id(&m, mjOBJ_SITE, fill.text(fmt::format("parts.{}_foot", to_string(side))).c_str());
    foot_frame[side] = site >= 0 ? local_pose(m.site_pos + 3 * site, m.site_quat + 4 * site)
                                 : Pose{Vec3::Zero(), posed.body(foot[side]).R.transpose() * posed.body(1).R};
    sole[side] = sole_shape(m, foot[side], foot_frame[side]);
    if (sole[side].outline.empty()) {
      problems.push_back(fmt::format("body '{}' of the {} foot {}", body(foot[side]), to_string(side),
                                     sole[side].geoms.empty()
                                         ? "has no colliding geom to stand on: give it one with contype and conaffinity"
                                         : "touches a plane in a point or a line: a sole needs an area"));
    }
  }
  for (int j = 1; j < m.njnt; ++j) {
    const std::string joint = name_of(m, mjOBJ_JOINT, j);
    if (m.jnt_type[j] != mjJNT_HINGE)
      problems.push_back(fmt::format("joint '{}' is not a hinge: only hinges can be driven", joint));
    if (!m.jnt_limited[j]) problems.push_back(fmt::format("joint '{}' has no range", joint));
    if (!m.jnt_actfrclimited[j] && !given_torques.contains(joint)) {
      problems.push_back(
          fmt::format("joint '{}' has no torque limit (actuatorfrcrange, forcerange, ctrlrange of a motor, "
                      "effort, or drive.gains.torque)",
                      joint));
    }
  }
  if (!problems.empty()) {
    throw InputError(fmt::format("profile {}: {}: {}", file, owner, fmt::join(problems, "; ")));
  }

  // Size: COM height, sole's half-width, arm's length.
  const std::vector<int> leg = chain(m, common_ancestor(m, foot.left, foot.right), foot.left);
  const auto sole_at = [&](Side side) {
    const Vec3 centre(sole[side].centre.x(), sole[side].centre.y(), sole[side].height);
    return Vec3(posed.body(foot[side]) * foot_frame[side] * centre);
  };
  const Knee knee = knee_of(m, leg);
  const double straight = posed.com_height() - sole_at(Side::left).z() + knee.straight - knee.now;
  double stall = 0.0;
  if (knee.joint >= 0) {
    const auto torque = given_torques.find(name_of(m, mjOBJ_JOINT, knee.joint));
    stall = torque != given_torques.end() ? torque->second : m.jnt_actfrcrange[2 * knee.joint + 1];
  }
  const double share = straightness(knee, straight, m.body_subtreemass[1] * kGravity, stall);
  fill("stance.com_height", rounded(share * straight, 1e-3),
       fmt::format("{:.3g} of {:.3f} m, that of straight legs{}", share, straight,
                   share > kStraight ? ", as the knees are weak" : ""));
  const double h = fill.number("stance.com_height", straight);
  const double omega = std::sqrt(kGravity / h);
  const double w = std::min(half_width(sole.left.outline), half_width(sole.right.outline));
  const double apart = std::abs(sole_at(Side::left).y() - sole_at(Side::right).y());
  fill("stance.width", to_digits(std::max(apart, 2.0 * w + 0.03 * h)), "the soles' distance at q = 0");
  const double width = fill.number("stance.width", apart);
  double arm_length = 0.0;
  for (int b = hand.left; b != shoulder.left; b = m.body_parentid[b])
    arm_length += Eigen::Map<const Vec3>(m.body_pos + 3 * b).norm();
  const int hand_site = mj_name2id(&m, mjOBJ_SITE, fill.text("parts.left_hand").c_str());
  arm_length +=
      Eigen::Map<const Vec3>(hand_site >= 0 ? m.site_pos + 3 * hand_site : m.body_ipos + 3 * hand.left).norm();

  // Home of the arms.
  std::map<std::string, double> home;
  const BySide<std::vector<int>> arm{chain(m, m.body_parentid[shoulder.left], hand.left),
                                     chain(m, m.body_parentid[shoulder.right], hand.right)};
  if (!out.table.contains("home_deg")) {
    const std::vector<double> left = arm_home(m, arm.left, shoulder.left, hand.left, Side::left);
    std::vector<double> right = mirrored(m, arm.left, arm.right, left);
    if (right.empty()) right = arm_home(m, arm.right, shoulder.right, hand.right, Side::right);
    toml::table angles;
    for (const Side side : kSides) {
      for (std::size_t k = 0; k < arm[side].size(); ++k) {
        const double degrees = std::round((side == Side::left ? left : right)[k] * kDegrees);
        angles.insert(name_of(m, mjOBJ_JOINT, arm[side][k]), degrees);
      }
    }
    fill("home_deg", angles, "the hands before and below the shoulders, joints far from their limits");
  }
  if (const toml::table* angles = out.table["home_deg"].as_table()) {
    for (const auto& [joint, degrees] : *angles)
      home[std::string(joint.str())] = degrees.value<double>().value_or(0.0) / kDegrees;
  }

  fill_from({h, w, width, arm_length, straight}, fill);
  derive_servos(m, path, omega, m.body_subtreemass[1] * kGravity * h, out);
  if (m.npair == 0 && !out.table.contains("self_pairs")) {
    fill("self_pairs", self_pairs(m, foot, home, h),
         fmt::format("links that come nearer than {} h to each other in some of {} postures, and do not touch at home",
                     kNear, kPairSamples));
  }
  return out;
}

}  // namespace baton
