#include "baton/input/arm_script.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>

#include "baton/input/arm_targets_json.hpp"
#include "baton/model/error.hpp"
#include "baton/model/input_file.hpp"

namespace baton {
namespace {

constexpr std::array<std::string_view, 4> kArmKeys{"t", "joints", "at", "q"};
constexpr double kSameTick = 1e-9;  // [s] tolerance for floating-point tick times

}  // namespace

ArmScript ArmScript::load(const std::filesystem::path& file, const RobotModel& robot) {
  return parse(read_input(file, "script of arms"), file.string(), robot);
}

ArmScript ArmScript::parse(std::string_view text, const std::string& name, const RobotModel& robot) {
  std::vector<Entry> entries;
  const ArmTrajectory none(robot);
  const VecX q = VecX::Zero(robot.nv() - 6);
  for (int number = 1; !text.empty(); ++number) {
    const std::size_t length = std::min(text.find('\n'), text.size());
    const std::string_view line = text.substr(0, length);
    text.remove_prefix(std::min(length + 1, text.size()));
    if (line.find_first_not_of(" \t\r") == std::string_view::npos) continue;
    const std::string place = fmt::format("script of arms {}: line {}", name, number);
    const nlohmann::json json = parse_json(line, place);
    const JsonReader read(json, place);
    for (const auto& [key, value] : json.items()) {
      if (std::ranges::find(kArmKeys, key) == kArmKeys.end())
        throw InputError(
            fmt::format("{}: unknown key {}: must be t, joints, at or q", place, shown(nlohmann::json(key))));
    }
    Entry entry{read.at("t").number(), arm_targets_in(read)};
    const double earliest = entries.empty() ? 0.0 : entries.back().t;
    if (!(entry.t >= earliest)) read.at("t").fail(fmt::format("at least {}", earliest));
    try {
      static_cast<void>(none.continued(entry.targets, entry.t, q));
    } catch (const InputError& error) {
      throw InputError(fmt::format("{}: {}", place, error.what()));
    }
    entries.push_back(std::move(entry));
  }
  if (entries.empty()) throw InputError(fmt::format("script of arms {}: empty: must hold a line with targets", name));
  return ArmScript(std::move(entries));
}

const ArmTargets* ArmScript::next(double t) {
  if (next_ == entries_.size() || entries_[next_].t > t + kSameTick) return nullptr;
  return &entries_[next_++].targets;
}

}  // namespace baton
