#include "baton/record/motion_file.hpp"

#include <fmt/format.h>

#include <cmath>

#include "baton/input/json_reader.hpp"
#include "baton/model/error.hpp"
#include "baton/model/input_file.hpp"
#include "baton/plan/retrace.hpp"
#include "baton/record/json.hpp"

namespace baton {
namespace {

using Json = nlohmann::json;

Json pose_json(const Pose& pose) {
  const Eigen::Quaterniond q(pose.R);
  return {{"p", vector_json(pose.p)}, {"quat", {q.w(), q.x(), q.y(), q.z()}}};
}

Json contact_json(const BySide<bool>& contact) {
  return {{"left", contact.left}, {"right", contact.right}};
}

Pose pose_in(const JsonReader& read) {
  const VecX q = read.at("quat").vector(4);
  if (!(std::abs(q.norm() - 1.0) <= 1e-6)) read.at("quat").fail("a unit quaternion [w, x, y, z]");
  return {Vec3(read.at("p").vector(3)), Eigen::Quaterniond(q[0], q[1], q[2], q[3]).toRotationMatrix()};
}

BySide<bool> contact_in(const JsonReader& read) {
  return {read.at("left").boolean(), read.at("right").boolean()};
}

Json heat_json(const Heat& heat) {
  Json motors = Json::array();
  for (const Warmth& motor : heat)
    motors.push_back({motor.winding, motor.housing});
  return motors;
}

Heat heat_in(const JsonReader& read, const RobotModel& robot) {
  Heat heat;
  for (const JsonReader& motor : read.list()) {
    const VecX parts = motor.vector(2);
    if (!(parts.minCoeff() >= 0.0)) motor.fail("the heat of winding and housing, neither below 0");
    heat.push_back({parts[0], parts[1]});
  }
  if (!heat.empty() && heat.size() != robot.joints().size())
    read.fail(fmt::format("the heat of none or of all {} motors", robot.joints().size()));
  return heat;
}

std::string place_of(const std::filesystem::path& file) {
  return fmt::format("motion {}", file.string());
}

Json parsed(const std::filesystem::path& file) {
  return parse_json(read_input(file, "motion"), place_of(file));
}

}  // namespace

Json motion_file(const Motion& motion, const MotionPlace& place) {
  Json phases = Json::array();
  for (const ContactPhase& phase : motion.phases)
    phases.push_back({{"ticks", phase.ticks}, {"contact", contact_json(phase.contact)}});
  Json samples = Json::array();
  for (const MotionSample& sample : motion.samples) {
    samples.push_back({{"q", vector_json(sample.q)},
                       {"com", vector_json(sample.com)},
                       {"left_sole", pose_json(sample.sole.left)},
                       {"right_sole", pose_json(sample.sole.right)}});
  }
  return {{"robot", place.robot},
          {"world", place.world},
          {"anchor", pose_json(place.anchor)},
          {"period", motion.period},
          {"phases", phases},
          {"dq0", vector_json(motion.dq0)},
          {"contact_before", contact_json(motion.contact_before)},
          {"lift_off", pose_json(motion.swing.lift_off)},
          {"retraces", motion.retraces},
          {"returns", motion.goal.returns},
          {"unsure", motion.goal.place_uncertainty},
          {"heat", heat_json(motion.heat)},
          {"samples", samples}};
}

MotionPlace read_motion_place(const std::filesystem::path& file) {
  const Json json = parsed(file);
  const JsonReader read(json, place_of(file));
  return {read.at("robot").text(), read.at("world").text(), pose_in(read.at("anchor"))};
}

Motion read_motion(const std::filesystem::path& file, const RobotModel& robot) {
  const Json json = parsed(file);
  const JsonReader read(json, place_of(file));
  Motion motion;
  motion.period = read.at("period").number();
  if (!(std::abs(motion.period - robot.profile().tick.period) <= 1e-9)) {
    read.at("period").fail(fmt::format("{}, the robot's", robot.profile().tick.period));
  }
  for (const JsonReader& sample : read.at("samples").list()) {
    MotionSample& s = motion.samples.emplace_back();
    s.q = sample.at("q").vector(robot.nq());
    if (!(std::abs(s.q.segment<4>(3).norm() - 1.0) <= 1e-6)) sample.at("q").fail("with a unit quaternion at 3…6");
    s.com = sample.at("com").vector(3);
    s.sole = {pose_in(sample.at("left_sole")), pose_in(sample.at("right_sole"))};
  }
  long sum = 0;
  for (const JsonReader& phase : read.at("phases").list()) {
    motion.phases.push_back({static_cast<int>(phase.at("ticks").integer(1, 1000000)), contact_in(phase.at("contact"))});
    const BySide<bool>& contact = motion.phases.back().contact;
    if (!contact.left && !contact.right) phase.at("contact").fail("at least one sole that stands");
    sum += motion.phases.back().ticks;
  }
  if (sum != motion.ticks()) {
    throw InputError(
        fmt::format("motion {}: the phases have {} ticks, the samples {}: must be one sample more than ticks",
                    file.string(), sum, motion.samples.size()));
  }
  motion.end.q = motion.rest.q = motion.samples.back().q;
  set_contacts(motion);
  motion.swing.lift_off = pose_in(read.at("lift_off"));
  motion.contact_before = contact_in(read.at("contact_before"));
  motion.retraces = read.at("retraces").boolean();
  motion.goal.returns = read.at("returns").boolean();
  motion.goal.place_uncertainty = read.at("unsure").number();
  motion.heat = heat_in(read.at("heat"), robot);
  motion.dq0 = read.at("dq0").vector(robot.nv());
  differentiate(robot, motion);
  return motion;
}

}  // namespace baton
