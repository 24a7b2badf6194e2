// A URDF becomes a model or is refused.
#include "baton/model/error.hpp"
#include "baton/model/urdf.hpp"
#include "tests/fuzz/fuzz.hpp"

int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using baton::fuzz::require;
  const auto& file = baton::fuzz::file_of(baton::fuzz::text_of(data, size));
  try {
    const baton::SpecPtr spec = baton::parse_urdf(file);
    require(spec != nullptr, "what is not refused is a model");
  } catch (const baton::InputError&) {
  }
  try {
    for (const auto& [joint, speed] : baton::urdf_speed_limits(file))
      require(speed > 0.0, "a speed limit is positive");
  } catch (const baton::InputError&) {
  }
  return 0;
}
