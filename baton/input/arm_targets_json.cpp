#include "baton/input/arm_targets_json.hpp"

namespace baton {

nlohmann::json to_json(const ArmTargets& targets) {
  nlohmann::json json = {{"joints", targets.joints}};
  if (targets.t.empty()) return json;
  json["at"] = targets.t;
  for (const auto& row : targets.q.rowwise())
    json["q"].push_back(std::vector<double>(row.begin(), row.end()));
  return json;
}

ArmTargets arm_targets_in(const JsonReader& read) {
  ArmTargets targets;
  for (const JsonReader& joint : read.at("joints").list())
    targets.joints.push_back(joint.text());
  if (!read.has("at") && !read.has("q")) return targets;
  for (const JsonReader& t : read.at("at").list())
    targets.t.push_back(t.number());
  const auto columns = static_cast<Eigen::Index>(targets.joints.size());
  std::vector<VecX> rows;
  for (const JsonReader& row : read.at("q").list(targets.t.size()))
    rows.push_back(row.vector(columns));
  // Only now: many names and times alone would make it larger than any memory.
  targets.q.resize(static_cast<Eigen::Index>(rows.size()), columns);
  for (std::size_t i = 0; i < rows.size(); ++i)
    targets.q.row(static_cast<Eigen::Index>(i)) = rows[i].transpose();
  return targets;
}

}  // namespace baton
