/// The mirror at the plane y = 0: left and right change places, y changes its sign, roll and yaw change theirs. And a
/// robot that looks the same in it.
#pragma once

#include <algorithm>
#include <cmath>
#include <memory>
#include <regex>
#include <utility>

#include "baton/guide/guide.hpp"
#include "baton/motion/motion.hpp"
#include "tests/support/changed_model.hpp"

namespace baton::test {

/// The robot of that name with its trunk's centre of mass and principal axes in the plane of symmetry, made once a
/// process. All else of mighty is symmetric; its trunk, as measured by its makers, is off by 0.8 mm.
inline const RobotModel& symmetric_robot(const std::string& name) {
  static std::map<std::string, std::unique_ptr<RobotModel>> made;
  auto& robot = made[name];
  if (robot) return *robot;
  const RobotModel& as_measured = test::robot(name);
  robot = std::make_unique<RobotModel>(with_changed_model(as_measured, name + "_symmetric", [&](std::string model) {
    const std::size_t trunk = model.find("<body name=\"" + as_measured.profile().parts.trunk + "\"");
    EXPECT_NE(trunk, std::string::npos);
    // pos="x y z" mass="m" fullinertia="xx yy zz xy xz yz": y, xy and yz to 0
    const std::regex inertial(
        R"re(<inertial pos="(\S+) \S+ (\S+)" mass="(\S+)" fullinertia="(\S+ \S+ \S+) \S+ (\S+) \S+")re");
    std::smatch found;
    const std::string rest = model.substr(trunk);
    EXPECT_TRUE(std::regex_search(rest, found, inertial));
    model.replace(trunk + static_cast<std::size_t>(found.position()), static_cast<std::size_t>(found.length()),
                  found.format(R"re(<inertial pos="$1 0 $2" mass="$3" fullinertia="$4 0 $5 0")re"));
    return model;
  }));
  return *robot;
}

class Mirror {
 public:
  /// The robot must outlive the object.
  explicit Mirror(const RobotModel& robot) : twin_(robot.joints().size(), -1), sign_(robot.joints().size(), 0.0) {
    // How a joint's twin turns follows from the axes at zero angles: what turns is mirrored as (−x, y, −z).
    const DataPtr data(mj_makeData(&robot.mj()));
    mj_kinematics(&robot.mj(), data.get());
    const auto axis = [&](int joint) {
      const int id = robot.mj().dof_jntid[6 + joint];
      return Vec3(Eigen::Map<const Vec3>(data->xaxis + 3 * id));
    };
    const auto pair = [&](const std::vector<int>& left, const std::vector<int>& right) {
      ASSERT_EQ(left.size(), right.size());
      for (std::size_t i = 0; i < left.size(); ++i) {
        const Vec3 mirrored = Vec3(-1, 1, -1).cwiseProduct(axis(left[i]));
        const double same = mirrored.dot(axis(right[i]));
        ASSERT_NEAR(std::abs(same), 1.0, 1e-6);
        for (const auto& [a, b] : {std::pair(left[i], right[i]), std::pair(right[i], left[i])}) {
          twin_[static_cast<std::size_t>(a)] = b;
          sign_[static_cast<std::size_t>(a)] = same > 0.0 ? 1.0 : -1.0;
        }
      }
    };
    pair(robot.arm(Side::left), robot.arm(Side::right));
    pair(robot.leg(Side::left), robot.leg(Side::right));
    EXPECT_EQ(std::count(twin_.begin(), twin_.end(), -1), 0) << "every joint has a twin";
  }

  [[nodiscard]] static Vec2 of(const Vec2& v) { return {v.x(), -v.y()}; }
  [[nodiscard]] static Vec3 of(const Vec3& v) { return {v.x(), -v.y(), v.z()}; }
  [[nodiscard]] static Mat3 of(const Mat3& R) {
    const Vec3 s(1, -1, 1);
    return s.asDiagonal() * R * s.asDiagonal();
  }
  [[nodiscard]] static Pose of(const Pose& pose) { return {of(pose.p), of(pose.R)}; }
  [[nodiscard]] static Side of(Side side) { return other(side); }
  [[nodiscard]] static Part of(Part part) {
    return is_foot(part) ? foot(other(side_of(part))) : is_hand(part) ? hand(other(side_of(part))) : part;
  }
  [[nodiscard]] static bool of(bool value) { return value; }
  [[nodiscard]] static double of(double value) { return value; }
  template <typename T>
  [[nodiscard]] static std::optional<T> of(const std::optional<T>& value) {
    return value ? std::optional<T>(of(*value)) : std::nullopt;
  }
  template <typename T>
  [[nodiscard]] static BySide<T> of(const BySide<T>& value) {
    return {of(value.right), of(value.left)};
  }
  [[nodiscard]] static Flight of(const Flight& f) { return {of(f.side), of(f.from), f.remaining, f.to_apex, f.apex}; }
  [[nodiscard]] static LiftOff of(const LiftOff& l) { return {of(l.side), l.remaining}; }
  [[nodiscard]] static GuideContext::Step of(const GuideContext::Step& s) { return {of(s.side), of(s.to)}; }
  [[nodiscard]] static SwingArc of(const SwingArc& s) { return {of(s.lift_off), s.apex_t, s.apex}; }

  [[nodiscard]] static Target of(const Target& target) {
    Target mirrored{.part = of(target.part), .move = target.move, .lift = target.lift};
    for (const int axis : {1, 3, 5})
      mirrored.move[axis] *= -1.0;
    return mirrored;
  }
  [[nodiscard]] static Command of(const Command& command) {
    Command result = command;
    result.guide = of(command.guide);
    for (const int axis : {1, 3, 5})
      result.axes[axis] = -command.axes[axis];
    result.lift = of(command.lift);
    return result;
  }

  /// Angles, speeds or accelerations of all joints.
  [[nodiscard]] VecX joints(const VecX& v) const {
    VecX result(v.size());
    for (std::size_t i = 0; i < twin_.size(); ++i)
      result[twin_[i]] = sign_[i] * v[static_cast<Eigen::Index>(i)];
    return result;
  }
  [[nodiscard]] VecX configuration(const VecX& q) const {
    VecX result = q;
    result[1] = -q[1];  // y
    result[4] = -q[4];  // of the quaternion wxyz: x, z
    result[6] = -q[6];
    result.tail(q.size() - 7) = joints(q.tail(q.size() - 7));
    return result;
  }
  /// Of the root in the world and in the trunk, and of the joints; empty stays empty.
  [[nodiscard]] VecX velocity(const VecX& v) const {
    if (v.size() == 0) return v;
    VecX result = v;
    for (const int i : {1, 3, 5})
      result[i] = -v[i];
    result.tail(v.size() - 6) = joints(v.tail(v.size() - 6));
    return result;
  }

  [[nodiscard]] Heat of(const Heat& heat) const {
    Heat result = heat;
    for (std::size_t i = 0; i < heat.size(); ++i)
      result[static_cast<std::size_t>(twin_[i])] = heat[i];
    return result;
  }
  [[nodiscard]] Posture of(const Posture& p) const {
    Posture result = p;
    result.q = configuration(p.q);
    result.dq = velocity(p.dq);
    result.ddq = velocity(p.ddq);
    result.com = of(p.com);
    result.dcom = of(p.dcom);
    result.ddcom = of(p.ddcom);
    result.trunk = of(p.trunk);
    result.sole = of(p.sole);
    result.hand = of(p.hand);
    result.shoulder = of(p.shoulder);
    result.contact = of(p.contact);
    result.contact_before = of(p.contact_before);
    result.lift_off = of(p.lift_off);
    result.flight = of(p.flight);
    result.heat = of(p.heat);
    return result;
  }
  [[nodiscard]] GuideContext of(const GuideContext& c) const {
    const Vec3 offset = of(Vec3(c.com_offset.x(), c.com_offset.y(), 0.0));
    return {of(c.from),   of(c.anchor),     of(c.last_step),     of(c.foothold),        of(c.step),
            c.stick_held, offset.head<2>(), c.place_uncertainty, of(c.slip_free_frame), of(c.drift_correction)};
  }
  [[nodiscard]] Goal of(const Goal& g) const {
    Goal result = g;
    result.guided = of(g.guided);
    result.swing = of(g.swing);
    result.drift_correction = of(g.drift_correction);
    result.sole = of(g.sole);
    result.contact = of(g.contact);
    result.com = of(g.com);
    result.trunk = of(g.trunk);
    result.hand = of(g.hand);
    result.arms = joints(g.arms);
    return result;
  }
  /// A motion as it is to be verified: its samples. The COM's path, and what verification completes, stay as they were.
  [[nodiscard]] Motion of(const Motion& motion) const {
    Motion result = motion;
    result.goal = of(motion.goal);
    result.dq0 = velocity(motion.dq0);
    result.contact_before = of(motion.contact_before);
    result.heat = of(motion.heat);
    for (ContactPhase& phase : result.phases)
      phase.contact = of(phase.contact);
    for (MotionSample& sample : result.samples)
      sample = of(sample);
    result.end = of(motion.end);
    result.rest = of(motion.rest);
    result.swing = of(motion.swing);
    return result;
  }
  [[nodiscard]] MotionSample of(const MotionSample& sample) const {
    MotionSample result = sample;
    result.q = configuration(sample.q);
    result.dq = velocity(sample.dq);
    result.ddq = velocity(sample.ddq);
    result.com = of(sample.com);
    result.dcom = of(sample.dcom);
    result.sole = of(sample.sole);
    result.contact = of(sample.contact);
    return result;
  }

 private:
  std::vector<int> twin_;     ///< the joint on the other side
  std::vector<double> sign_;  ///< ±1: whether that turns the mirrored way
};

}  // namespace baton::test
