#include "baton/record/plan_json.hpp"

#include "baton/record/json.hpp"

namespace baton {
namespace {

nlohmann::json pose_rpy_json(const Pose& pose) {
  return {{"p", vector_json(pose.p)}, {"rpy", vector_json(rpy_of(pose.R))}};
}

}  // namespace

nlohmann::json to_json(const Refusal& refusal) {
  return {{"reason", to_string(refusal.reason)},
          {"part", to_string(refusal.part)},
          {"value", refusal.value},
          {"limit", refusal.limit},
          {"where", place(refusal)}};
}

nlohmann::json to_json(const std::optional<Refusal>& refusal) {
  return refusal ? to_json(*refusal) : nlohmann::json(nullptr);
}

nlohmann::json to_json(const Certificate& certificate) {
  nlohmann::json margins = nlohmann::json::array();
  for (const Margin& margin : certificate.margins) {
    margins.push_back({{"quantity", to_string(margin.quantity)},
                       {"value", margin.value},
                       {"limit", margin.limit},
                       {"t", margin.t},
                       {"where", margin.where}});
  }
  return margins;
}

nlohmann::json to_json(const PlannedMotion& planned, const Pose& anchor) {
  const Motion& motion = *planned.motion;
  nlohmann::json phases = nlohmann::json::array();
  for (const ContactPhase& phase : motion.phases) {
    phases.push_back({{"duration", phase.ticks * motion.period},
                      {"contact", {{"left", phase.contact.left}, {"right", phase.contact.right}}}});
  }
  nlohmann::json knots = nlohmann::json::array();
  for (std::size_t k = 0; k < motion.com.knots().size(); ++k) {
    knots.push_back({{"t", motion.com.times()[k]}, {"v", vector_json(anchor * motion.com.knots()[k])}});
  }
  const Posture& end = motion.end;
  nlohmann::json goal = {{"com", vector_json(anchor * end.com)},
                         {"trunk", {{"rpy", vector_json(rpy_of(anchor.R * end.trunk))}}}};
  for (const Side side : kSides) {
    goal[std::string(to_string(foot(side)))] = pose_rpy_json(anchor * end.sole[side]);
    goal[std::string(to_string(foot(side)))]["contact"] = end.contact[side];
    goal[std::string(to_string(hand(side)))] = pose_rpy_json(anchor * end.hand[side]);
  }
  nlohmann::json json = {{"kind", to_string(motion.goal.kind)},
                         {"guided", to_string(motion.goal.guided)},
                         {"swing", nullptr},
                         {"T", motion.duration()},
                         {"durations_tried", planned.durations_tried},
                         {"not_shorter", to_json(planned.not_shorter)},
                         {"retraces", motion.retraces},
                         {"limit", to_json(planned.limit)},
                         {"phases", phases},
                         {"knots", knots},
                         {"margins", to_json(planned.motion.certificate())},
                         {"goal", goal}};
  if (motion.goal.swing) json["swing"] = to_string(foot(*motion.goal.swing));
  return json;
}

}  // namespace baton
