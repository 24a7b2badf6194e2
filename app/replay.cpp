#include <fmt/format.h>

#include <algorithm>
#include <bit>
#include <cmath>

#include "app/app.hpp"
#include "app/commands.hpp"
#include "app/inputs.hpp"
#include "app/replayer.hpp"

namespace baton::app {

int replay(const ReplayOptions& o) {
  Replayer run(o.recording, o.verify);
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
