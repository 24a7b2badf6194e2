#include <fmt/format.h>
#include <spdlog/spdlog.h>

#include <utility>

#include "app/app.hpp"
#include "app/commands.hpp"
#include "app/inputs.hpp"
#include "app/outputs.hpp"
#include "app/replayer.hpp"
#include "baton/input/json_reader.hpp"

namespace baton::app {

namespace {

/// Says in what program, model, world and profile are not those of the recording.
void compare_origins(const Replayer& run) {
  const mcap::Metadata& there = run.recording().file().metadata().at("baton");
  const nlohmann::json here = origins_of(run.recording().head().robot, run.robot(), run.world()).sums;
  for (const auto& [key, what] :
       {std::pair("baton", "version of baton"), std::pair("mujoco", "version of MuJoCo"),
        std::pair("model_sum", "model (checksum)"), std::pair("world_sum", "world (checksum)"),
        std::pair("profile_sum", "profile (checksum)")}) {
    const auto found = there.find(key);
    const std::string now = here.at(key);
    if (found == there.end() || found->second == now) continue;
    spdlog::warn("the recording is of another {}: {}, here {}: the replay may differ", what,
                 shortened(found->second, 60), now);
  }
}

}  // namespace

int replay(const ReplayOptions& o) {
  Replayer run(o.recording, o.verify);
  compare_origins(run);
  const auto differs = [&](const std::string& what) {
    fmt::print("tick {}: {}\n", run.navigator().now(), what);
    return kFailed;
  };
  while (run.step()) {
    if (interrupted) return differs("interrupted");
    if (!run.difference().empty()) return differs(run.difference());
    for (const Event& event : run.navigator().events()) {
      if (const auto* changed = std::get_if<SensorChanged>(&event)) {
        fmt::print("tick {}: sensor {} is {}\n", run.navigator().now(), to_string(changed->sensor),
                   to_string(changed->health));
      }
    }
  }
  const Navigator& navigator = run.navigator();
  const long ticks = navigator.now() + 1;
  fmt::print("{} ticks, {:.1f} s: {} segments, {} answers too late{}{}\n", ticks,
             static_cast<double>(ticks) * run.robot().profile().tick.period, navigator.committed(), navigator.dropped(),
             o.verify ? ", joint targets identical bit for bit" : "",
             run.recording().file().finished() ? "" : "; the recording was not finished");
  if (run.gap() == 0) return kDone;
  return differs(
      fmt::format("{} ticks are missing in the recording after this one: the rest cannot be replayed", run.gap()));
}

}  // namespace baton::app
