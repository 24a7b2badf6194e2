// A profile is read or refused.
#include <cmath>

#include "baton/model/error.hpp"
#include "baton/model/profile.hpp"
#include "tests/fuzz/fuzz.hpp"

int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using baton::fuzz::require;
  try {
    const baton::Profile p = baton::Profile::load(baton::fuzz::file_of(baton::fuzz::text_of(data, size)));
    require(!p.name.empty() && p.model.is_absolute(), "the robot has a name and a model");
    require(p.tick.period > 0.0 && p.tick.lookahead >= 1, "there are ticks");
    require(p.region.foot_x.lo < p.region.foot_x.hi && p.duration.first <= p.duration.max, "ranges are in order");
    for (const auto& [joint, angle] : p.home)
      require(std::isfinite(angle), "arms have angles at home");
  } catch (const baton::InputError&) {
  }
  return 0;
}
