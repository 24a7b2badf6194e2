// Whatever a page sends is a message or malformed, and a command may be acted on once it was sanitised.
#include <cmath>

#include "baton/cockpit/protocol.hpp"
#include "tests/fuzz/fuzz.hpp"

int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using baton::fuzz::require;
  const baton::PageMessage message = baton::parse_page_message(baton::fuzz::text_of(data, size));
  if (const auto* steer = std::get_if<baton::Steer>(&message)) {
    require(size <= baton::kLargestMessage, "no command is larger than a message");
    const baton::Command command = baton::sanitised(steer->command);
    require(command.axes.allFinite() && command.axes.cwiseAbs().maxCoeff() <= 1.0, "axes are in -1..1");
    for (const double lift : {command.lift.left, command.lift.right})
      require(lift >= 0.0 && lift <= 1.0, "lifts are in 0..1");
  } else if (const auto* malformed = std::get_if<baton::Malformed>(&message)) {
    require(!malformed->why.empty(), "what is malformed is told why");
  }
  return 0;
}
