// Whatever comes from the simulator is a perception with finite numbers, or not understood.
#include "baton/bridge/rcss_message.hpp"
#include "tests/fuzz/fuzz.hpp"

int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using baton::fuzz::require;
  using namespace baton::bridge;
  static const std::vector<RcssJoint> kJoints{{"q_llj1", "lle1"}, {"q_llj2", "lle2"}};
  std::string bytes(baton::fuzz::text_of(data, size));
  try {
    while (const std::optional<std::string> text = take_rcss_message(bytes)) {
      try {
        const Perception p = perception_in(*text, kJoints);
        require(p.q.allFinite() && p.dq.allFinite() && p.torso.p.allFinite(), "what is perceived is finite");
      } catch (const SExprError& error) {
        require(*error.what() != '\0', "what is not understood is told why");
      }
    }
  } catch (const SExprError& error) {
    require(*error.what() != '\0', "what is no message is told why");
  }
  return 0;
}
