#include "baton/record/motion_file.hpp"

#include <fmt/format.h>

#include <cmath>
#include <fstream>

#include "baton/model/error.hpp"
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

/// One object of the file; every complaint names the file and the place in it.
class Node {
 public:
  Node(const Json& json, std::string place) : json_(json), place_(std::move(place)) {}

  [[nodiscard]] Node at(const char* key) const {
    if (!json_.is_object() || !json_.contains(key)) throw InputError(fmt::format("{}: {} is missing", place_, key));
    return {json_[key], fmt::format("{}.{}", place_, key)};
  }
  [[nodiscard]] std::vector<Node> list() const {
    if (!json_.is_array() || json_.empty()) complain("a list that is not empty");
    std::vector<Node> nodes;
    for (std::size_t i = 0; i < json_.size(); ++i)
      nodes.emplace_back(json_[i], fmt::format("{}[{}]", place_, i));
    return nodes;
  }
  [[nodiscard]] std::string text() const {
    if (!json_.is_string()) complain("a text");
    return json_.get<std::string>();
  }
  [[nodiscard]] bool truth() const {
    if (!json_.is_boolean()) complain("true or false");
    return json_.get<bool>();
  }
  [[nodiscard]] double number() const {
    if (!json_.is_number() || !std::isfinite(json_.get<double>())) complain("a number");
    return json_.get<double>();
  }
  [[nodiscard]] int count() const {
    if (!json_.is_number_integer() || json_.get<long>() < 1 || json_.get<long>() > 1000000) complain("a whole number");
    return json_.get<int>();
  }
  [[nodiscard]] VecX vector(Eigen::Index size) const {
    if (!json_.is_array() || static_cast<Eigen::Index>(json_.size()) != size)
      complain(fmt::format("a list of {} numbers", size));
    VecX v(size);
    for (Eigen::Index i = 0; i < size; ++i)
      v[i] = Node(json_[static_cast<std::size_t>(i)], fmt::format("{}[{}]", place_, i)).number();
    return v;
  }
  [[nodiscard]] Pose pose() const {
    const VecX q = at("quat").vector(4);
    if (std::abs(q.norm() - 1.0) > 1e-6) at("quat").complain("a unit quaternion [w, x, y, z]");
    return {Vec3(at("p").vector(3)), Eigen::Quaterniond(q[0], q[1], q[2], q[3]).toRotationMatrix()};
  }
  [[nodiscard]] BySide<bool> contact() const { return {at("left").truth(), at("right").truth()}; }
  [[noreturn]] void complain(const std::string& wanted) const {
    std::string shown = json_.dump(-1, ' ', true, Json::error_handler_t::replace);
    if (shown.size() > 60) shown = shown.substr(0, 57) + "...";
    throw InputError(fmt::format("{} = {}: must be {}", place_, shown, wanted));
  }

 private:
  const Json& json_;
  std::string place_;
};

Json parsed(const std::filesystem::path& file) {
  std::ifstream in(file);
  if (!in) throw InputError(fmt::format("motion {}: no such file", file.string()));
  Json json = Json::parse(in, nullptr, false);
  if (json.is_discarded()) throw InputError(fmt::format("motion {}: not JSON", file.string()));
  return json;
}

std::string place_of(const std::filesystem::path& file) {
  return fmt::format("motion {}: motion", file.string());
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
          {"lift_off", pose_json(motion.lift_off)},
          {"retraces", motion.retraces},
          {"returns", motion.goal.returns},
          {"unsure", motion.goal.unsure},
          {"samples", samples}};
}

MotionPlace read_motion_place(const std::filesystem::path& file) {
  const Json json = parsed(file);
  const Node node(json, place_of(file));
  return {node.at("robot").text(), node.at("world").text(), node.at("anchor").pose()};
}

Motion read_motion(const std::filesystem::path& file, const RobotModel& robot) {
  const Json json = parsed(file);
  const Node node(json, place_of(file));
  Motion motion;
  motion.period = node.at("period").number();
  if (std::abs(motion.period - robot.profile().tick.period) > 1e-9) {
    node.at("period").complain(fmt::format("{}, the robot's", robot.profile().tick.period));
  }
  for (const Node& sample : node.at("samples").list()) {
    MotionSample& s = motion.samples.emplace_back();
    s.q = sample.at("q").vector(robot.nq());
    if (std::abs(s.q.segment<4>(3).norm() - 1.0) > 1e-6) sample.at("q").complain("with a unit quaternion at 3…6");
    s.com = sample.at("com").vector(3);
    s.sole = {sample.at("left_sole").pose(), sample.at("right_sole").pose()};
  }
  int sum = 0;
  for (const Node& phase : node.at("phases").list()) {
    motion.phases.push_back({phase.at("ticks").count(), phase.at("contact").contact()});
    const BySide<bool>& contact = motion.phases.back().contact;
    if (!contact.left && !contact.right) phase.at("contact").complain("at least one sole that stands");
    sum += motion.phases.back().ticks;
  }
  if (sum != motion.ticks()) {
    throw InputError(
        fmt::format("motion {}: the phases have {} ticks, the samples {}: must be one sample more than ticks",
                    file.string(), sum, motion.samples.size()));
  }
  set_contacts(motion);
  motion.lift_off = node.at("lift_off").pose();
  motion.contact_before = node.at("contact_before").contact();
  motion.retraces = node.at("retraces").truth();
  motion.goal.returns = node.at("returns").truth();
  motion.goal.unsure = node.at("unsure").number();
  motion.dq0 = node.at("dq0").vector(robot.nv());
  differentiate(robot, motion);
  return motion;
}

}  // namespace baton
