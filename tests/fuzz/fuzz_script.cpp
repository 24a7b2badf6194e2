// A script is read or refused; what was read is in range, and survives being written and read again.
#include <cmath>

#include "baton/input/script.hpp"
#include "baton/model/error.hpp"
#include "tests/fuzz/fuzz.hpp"

namespace {

using baton::Script;
using baton::fuzz::require;

/// The same number, or both none.
bool same(double a, double b) {
  return a == b || (std::isnan(a) && std::isnan(b));
}

bool same(const baton::Command& a, const baton::Command& b) {
  bool equal = a.guide == b.guide && a.recall == b.recall;
  for (Eigen::Index i = 0; i < a.axes.size(); ++i)
    equal = equal && same(a.axes[i], b.axes[i]);
  return equal && same(a.lift.left, b.lift.left) && same(a.lift.right, b.lift.right);
}

}  // namespace

int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  try {
    Script script = Script::parse(baton::fuzz::text_of(data, size), "fuzzed");
    std::string again;
    for (const auto& [t, command] : script.entries()) {
      require(t >= 0.0 && t <= script.duration(), "times are in order");
      for (const double axis : command.axes)
        require(std::isnan(axis) || std::abs(axis) <= 1.0, "axes are in -1..1");
      for (const double lift : {command.lift.left, command.lift.right})
        require(std::isnan(lift) || (lift >= 0.0 && lift <= 1.0), "lifts are in 0..1");
      again += baton::script_line(t, command) + '\n';
    }
    const Script copy = Script::parse(again, "written again");
    require(copy.entries().size() == script.entries().size(), "as many entries as were written");
    for (std::size_t i = 0; i < copy.entries().size(); ++i) {
      const auto& [t, command] = script.entries()[i];
      require(copy.entries()[i].t == t && same(copy.entries()[i].command, command), "the entry that was written");
    }
    require(same(script.read(script.duration()), script.entries().back().command), "the last entry is held");
  } catch (const baton::InputError&) {
  }
  return 0;
}
