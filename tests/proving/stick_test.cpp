#include "baton/proving/stick.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <set>

#include "baton/input/script.hpp"

namespace baton {
namespace {

constexpr double kPeriod = 0.005;

bool same(const Command& a, const Command& b) {
  return sanitised(a) == sanitised(b) && std::signbit(a.axes[0]) == std::signbit(b.axes[0]);
}

TEST(Stick, TheSameSeedGivesTheSameStick) {
  Stick a(7, kPeriod);
  Stick b(7, kPeriod);
  Stick c(8, kPeriod);
  int differs = 0;
  for (int k = 0; k < 20000; ++k) {
    const Command command = a.next();
    ASSERT_TRUE(same(command, b.next()));
    differs += same(command, c.next()) ? 0 : 1;
  }
  EXPECT_GT(differs, 10000);
  EXPECT_NE(mixed_seed(1, 2), mixed_seed(2, 1));
  // As on every computer.
  EXPECT_EQ(mixed_seed(1, 2), 13608149317741381227ULL);
}

TEST(Stick, IsDeflectedMostOfTheTimeAndKnowsEveryStyle) {
  std::set<Stick::Style> styles;
  std::set<Part> parts;
  int not_a_number = 0;
  int denormal = 0;
  int out_of_range = 0;
  int both_levers = 0;
  int switches = 0;
  double pinned = 0.0;
  int centred = 0;
  for (std::uint64_t seed = 0; seed < 40; ++seed) {
    Stick stick(seed, kPeriod);
    int deflected = 0;
    Command last;
    double still = 0.0;
    constexpr int kTicks = 24000;
    for (int k = 0; k < kTicks; ++k) {
      const Command command = stick.next();
      styles.insert(stick.style());
      parts.insert(command.guide);
      deflected += Stick::deflected(command) ? 1 : 0;
      for (const double axis : command.axes) {
        not_a_number += std::isnan(axis) ? 1 : 0;
        denormal += axis != 0.0 && std::abs(axis) < 1e-300 ? 1 : 0;
        out_of_range += std::abs(axis) > 1.0 ? 1 : 0;
      }
      both_levers += command.lift.left > 0.1 && command.lift.right > 0.1 ? 1 : 0;
      switches += command.guide == last.guide ? 0 : 1;
      still = same(command, last) ? still + kPeriod : 0.0;
      pinned = std::max(pinned, still);
      last = command;
    }
    EXPECT_GE(deflected, 7 * kTicks / 10) << seed;
    centred += kTicks - deflected;
  }
  EXPECT_EQ(styles.size(), Stick::kNames.size());
  EXPECT_EQ(parts.size(), kParts.size());
  EXPECT_GT(not_a_number, 1000);
  EXPECT_GT(denormal, 1000);
  EXPECT_GT(out_of_range, 1000);
  EXPECT_GT(both_levers, 10000);
  EXPECT_GT(switches, 20000);
  EXPECT_GT(pinned, 100.0);
  EXPECT_GT(centred, 10000);
}

TEST(Stick, AsAScriptItIsTheSame) {
  for (std::uint64_t seed = 0; seed < 10; ++seed) {
    constexpr long kTicks = 4000;
    Stick again(seed, kPeriod);
    Script script = Script::parse(stick_script(again, kPeriod, kTicks), "stick");
    Stick stick(seed, kPeriod);
    for (long k = 0; k < kTicks; ++k) {
      const Command command = stick.next();
      ASSERT_TRUE(same(command, script.read(static_cast<double>(k) * kPeriod))) << seed << " " << k;
    }
    EXPECT_TRUE(script.read(kTicks * kPeriod) == Command{});
  }
}

}  // namespace
}  // namespace baton
