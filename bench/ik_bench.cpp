// Inverse kinematics on a walk and a reach, as the planner realises them: one solve a tick.
#include <fmt/format.h>

#include <fstream>

#include "baton/ik/inverse_kinematics.hpp"
#include "baton/model/error.hpp"
#include "baton/plan/segment.hpp"
#include "baton/record/json.hpp"
#include "baton/run/simulation.hpp"
#include "bench/bench.hpp"

namespace baton::bench {
namespace {

nlohmann::json to_json(const Pose& pose) {
  const Eigen::Quaterniond q(pose.R);
  return {{"p", vector_json(pose.p)}, {"quat_wxyz", {q.w(), q.x(), q.y(), q.z()}}};
}

nlohmann::json frame_json(const RobotModel& robot, int body, const Pose& in_body) {
  nlohmann::json frame = to_json(in_body);
  frame["body"] = mj_id2name(&robot.mj(), mjOBJ_BODY, body);
  return frame;
}

/// Links, joints and frames, for a library that does not read the model's file.
nlohmann::json robot_json(const RobotModel& robot) {
  const mjModel& m = robot.mj();
  nlohmann::json bodies = nlohmann::json::array();
  for (int body = 1; body < m.nbody; ++body) {
    const auto numbers = [&](const mjtNum* of, int width) {
      return std::vector<double>(of + static_cast<std::ptrdiff_t>(width) * body,
                                 of + static_cast<std::ptrdiff_t>(width) * (body + 1));
    };
    nlohmann::json& entry = bodies.emplace_back(nlohmann::json{{"name", mj_id2name(&m, mjOBJ_BODY, body)},
                                                               {"p", numbers(m.body_pos, 3)},
                                                               {"quat_wxyz", numbers(m.body_quat, 4)},
                                                               {"mass", m.body_mass[body]},
                                                               {"com", numbers(m.body_ipos, 3)}});
    if (m.body_parentid[body] > 0) entry["parent"] = mj_id2name(&m, mjOBJ_BODY, m.body_parentid[body]);
    const int joint = m.body_jntadr[body];
    if (joint < 0 || m.jnt_type[joint] != mjJNT_HINGE) continue;
    if (m.body_jntnum[body] > 1 ||
        Eigen::Map<const Vec3>(m.jnt_pos + 3 * static_cast<std::ptrdiff_t>(joint)).norm() > 0)
      throw InputError(
          fmt::format("{}: has several joints, or one that is not at its origin", entry["name"].get<std::string>()));
    const mjtNum* axis = m.jnt_axis + 3 * static_cast<std::ptrdiff_t>(joint);
    const mjtNum* range = m.jnt_range + 2 * static_cast<std::ptrdiff_t>(joint);
    entry["joint"] = {{"name", mj_id2name(&m, mjOBJ_JOINT, joint)},
                      {"axis", {axis[0], axis[1], axis[2]}},
                      {"range", {range[0], range[1]}}};
  }
  nlohmann::json joints = nlohmann::json::array();
  for (const Joint& joint : robot.joints())
    joints.push_back(joint.name);
  nlohmann::json json = {{"bodies", bodies},
                         {"joints", joints},
                         {"arms", {robot.arm(Side::left), robot.arm(Side::right)}},
                         {"hand_has_attitude", robot.hand_has_attitude(Side::left)},
                         {"trunk", mj_id2name(&m, mjOBJ_BODY, robot.trunk_body())}};
  for (const Side side : kSides) {
    json["soles"].push_back(frame_json(robot, robot.foot_body(side), robot.sole_in_foot(side)));
    json["hands"].push_back(frame_json(robot, robot.hand_body(side), robot.hand_in_body(side)));
  }
  return json;
}

nlohmann::json to_json(const IkTargets& targets) {
  nlohmann::json json = {{"com", vector_json(targets.com)},
                         {"trunk", to_json(Pose{Vec3::Zero(), targets.trunk})},
                         {"arms", vector_json(targets.arms)}};
  for (const Side side : kSides) {
    json["soles"].push_back(to_json(targets.sole[side]));
    json["hands"].push_back(targets.hand[side] ? to_json(*targets.hand[side]) : nlohmann::json());
  }
  return json;
}

}  // namespace

Rows ik_rows(const RobotModel& robot, const std::string& prefix, nlohmann::json* motions) {
  const World world = World::load("flat");
  Simulation simulation(robot, world, Simulation::On::ideal);
  Session& session = simulation.session();
  Hooks hooks;
  session.add(hooks);
  struct Recorded {
    Posture from;
    VerifiedMotion motion;
  };
  std::vector<Recorded> recorded;
  hooks.plan = [&](const PlanRecord& record) {
    if (const auto* planned = std::get_if<PlannedMotion>(&record.answer.outcome)) {
      recorded.push_back({record.request.start.posture, planned->motion});
    }
  };
  while (session.t() < 20.0) {
    Command command;
    command.guide = session.t() < 14.0 ? Part::trunk : Part::left_hand;
    command.axes[0] = 1.0;
    if (command.guide == Part::left_hand) command.axes[2] = 0.5;
    session.step(command);
  }
  InverseKinematics ik(robot);
  Kinematics kinematics(robot);
  Row walk{prefix + "ik: a solve on a walk", {}, ""};
  Row reach{prefix + "ik: a solve on a reach", {}, ""};
  for (Row* row : {&walk, &reach}) {
    double worst = 0.0;
    for (const Recorded& segment_record : recorded) {
      const Posture& from = segment_record.from;
      const Motion& motion = *segment_record.motion;
      if ((row == &reach) != (motion.goal.guided == Part::left_hand)) continue;
      const Segment segment(robot, from, motion.goal, Limits::normal(robot.profile()), part_rates(kinematics, from));
      Timing timing{motion.period, {0}};
      for (const ContactPhase& phase : motion.phases)
        timing.border.push_back(timing.border.back() + phase.ticks);
      VecX before = from.q;
      integrate(robot, before, from.dq, -motion.period);
      VecX previous = from.q;
      nlohmann::json ticks;
      for (int k = 1; k <= motion.ticks(); ++k) {
        const IkTargets targets = segment.targets(motion.com, timing, k * motion.period);
        VecX q = previous;
        q.tail(robot.nv() - 6) += (previous - before).tail(robot.nv() - 6);
        q.head<3>() += (previous - before).head<3>();
        IkResult result;
        time(*row, [&] { result = ik.solve(targets, previous, motion.period, q, 3); });
        worst = std::max({worst, result.residual.com, result.residual.sole_position});
        if (motions != nullptr)
          ticks.push_back({{"targets", to_json(targets)}, {"q", vector_json(q)}, {"us", row->values.back()}});
        before = previous;
        previous = q;
      }
      if (motions != nullptr)
        motions->push_back({{"row", row->name}, {"from", vector_json(from.q)}, {"ticks", std::move(ticks)}});
    }
    row->remark = fmt::format("worst residual of feet and COM {:.1e} m", worst);
  }
  return {walk, reach};
}

Rows bench_ik(const Options& options) {
  const RobotModel robot = RobotModel::load(options.robot);
  if (options.ik_targets.empty()) return ik_rows(robot, "");
  nlohmann::json file = robot_json(robot);
  Rows rows = ik_rows(robot, "", &file["motions"]);
  std::ofstream out(options.ik_targets);
  if (!(out << file << std::flush)) throw InputError(fmt::format("{}: cannot be written", options.ik_targets));
  return rows;
}

}  // namespace baton::bench
