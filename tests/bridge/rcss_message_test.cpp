#include "baton/bridge/rcss_message.hpp"

#include <fmt/format.h>
#include <gmock/gmock.h>

#include <cmath>

#include "tests/support/random.hpp"

namespace baton::bridge {
namespace {

using testing::HasSubstr;

const std::vector<RcssJoint> kTwo{{"q_llj1", "lle1"}, {"q_llj2", "lle2"}};

/// As the simulator does it: cut off, towards zero.
double cut(double value, double digit) {
  return std::trunc(value / digit) * digit;
}

std::string perception_text(const std::string& joints, const std::string& time = "12.34") {
  return "(time (now " + time + "))(GS (t 0.0)(pm BeforeKickOff)(tl baton)(sl 0)(sr 0))" +
         "(quat (n torso_quat) (q 0.707 0.0 0.0 -0.707))(pos (n torso_pos) (p -3.0 21.0 0.673))" +
         "(GYR (n torso_gyro) (rt 0.0 90.0 -180.0))(ACC (n torso_acc) (a 0.0 -0.0 9.8))" + joints +
         "(See (B (pol 21.12 8.17 -2.68))(P (team x)(id 1)(head (pol 1 2 3))))";
}

const std::string kTwoText = "(HJ (n q_llj2)(ax -45.0)(vx 1.5))(HJ (n q_llj1)(ax 90.0)(vx -0.0))";

std::string misread(const std::string& text) {
  try {
    static_cast<void>(perception_in(text, kTwo));
  } catch (const SExprError& error) {
    return error.what();
  }
  return "";
}

TEST(RcssMessageTest, PerceivesInRadiansAndTheOrderAskedFor) {
  const Perception p = perception_in(perception_text(kTwoText), kTwo);
  const double half = 0.005 * M_PI / 180.0;
  EXPECT_EQ(p.play_mode, "BeforeKickOff");
  EXPECT_NEAR(p.q[0], M_PI / 2.0 + half, 1e-12);
  EXPECT_NEAR(p.q[1], -M_PI / 4.0 - half, 1e-12);
  EXPECT_EQ(p.dq[0], 0.0);
  EXPECT_NEAR(p.rate.y(), M_PI / 2.0 + half, 1e-12);
  EXPECT_NEAR(p.rate.z(), -M_PI - half, 1e-12);
  EXPECT_NEAR(p.acceleration.z(), 9.805, 1e-12);
  EXPECT_NEAR((p.torso.R * Vec3::UnitX() + Vec3::UnitY()).norm(), 0.0, 2e-3);
  EXPECT_NEAR(p.torso.p.y(), 21.0, 1e-3);
}

TEST(RcssMessageTest, TimesThatAreCutOffAreOfTheSameCycle) {
  for (long cycle = 1; cycle < 200'000; cycle += 7) {
    const double t = static_cast<double>(cycle) * kRcssCycle;
    for (const double read : {t, t - 0.01}) {  // the simulator cuts off what its sum of steps is too low by
      const std::string text = perception_text(kTwoText, fmt::format("{:.2f}", read));
      ASSERT_EQ(perception_in(text, kTwo).cycle, cycle) << text;
    }
  }
}

TEST(RcssMessageTest, HalfADigitIsTheMostThatCuttingOffLeaves) {
  test::Random random(1);
  for (int i = 0; i < 10'000; ++i) {
    const double value = random(-180.0, 180.0);
    const double read = cut(value, 0.01);
    EXPECT_LE(std::abs(uncut(read, 0.01) - value), std::abs(value) < 0.01 ? 0.01 : 0.005 + 1e-9);
  }
  EXPECT_EQ(uncut(0.0, 0.01), 0.0);
  EXPECT_EQ(uncut(-0.0, 0.01), 0.0);
}

TEST(RcssMessageTest, SaysWhatIsMissingOrTooMuch) {
  EXPECT_EQ(misread(perception_text(kTwoText)), "");
  EXPECT_THAT(misread(perception_text("(HJ (n q_llj1)(ax 0)(vx 0))")), HasSubstr("no joint 'q_llj2'"));
  EXPECT_THAT(misread(perception_text(kTwoText + "(HJ (n q_tj1)(ax 0)(vx 0))")), HasSubstr("'q_tj1'"));
  EXPECT_THAT(misread("(syn)"), HasSubstr("no (time ...)"));
  EXPECT_THAT(misread("(error)"), HasSubstr("no (time ...)"));
  EXPECT_THAT(misread("HTTP/1.1 400 Bad Request"), HasSubstr("no (time ...)"));
  std::string fallen = perception_text(kTwoText);
  fallen.replace(fallen.find("-0.707"), 6, "9.9999");
  EXPECT_THAT(misread(fallen), HasSubstr("quaternion"));
}

TEST(RcssMessageTest, BrokenPerceptionsAreReadOrRefused) {
  int refusals = 0;
  for (int seed = 0; seed < 5000; ++seed) {
    test::Random random(static_cast<std::uint64_t>(seed));
    std::string text = perception_text(kTwoText);
    for (std::size_t i = 0; i <= random.below(4); ++i)
      text[random.below(text.size())] = static_cast<char>(random.integer(-128, 127));
    try {
      const Perception p = perception_in(text, kTwo);
      EXPECT_TRUE(p.q.allFinite() && p.dq.allFinite() && p.rate.allFinite() && p.acceleration.allFinite());
    } catch (const SExprError&) {
      ++refusals;
    }
  }
  EXPECT_GT(refusals, 1000);
}

TEST(RcssMessageTest, WritesDegrees) {
  EXPECT_EQ(init_text("K1", "baton", 1), "(init K1 baton 1)");
  EXPECT_EQ(beam_text({-2.0, 1.0, M_PI / 2.0}), "(beam -2 1 90)");
  EXPECT_EQ(servo_text(kTwo[0], {M_PI, -M_PI / 2.0, 80.0, 2.5, -1.25}), "(lle1 180 -90 80 2.5 -1.25)");
}

TEST(RcssMessageTest, MessagesComeOutOfBytesHoweverTheyArrive) {
  for (int seed = 0; seed < 1000; ++seed) {
    test::Random random(static_cast<std::uint64_t>(seed));
    std::vector<std::string> sent;
    std::string bytes;
    for (std::size_t i = 0; i < 5; ++i) {
      sent.emplace_back(random.below(700) + 1, static_cast<char>('a' + i));
      bytes += rcss_framed(sent.back());
    }
    std::string arrived;
    std::vector<std::string> received;
    while (!bytes.empty()) {
      const std::size_t part = std::min(bytes.size(), random.below(300) + 1);
      arrived += bytes.substr(0, part);
      bytes.erase(0, part);
      while (std::optional<std::string> text = take_rcss_message(arrived))
        received.push_back(*text);
    }
    EXPECT_EQ(received, sent);
    EXPECT_TRUE(arrived.empty());
  }
}

TEST(RcssMessageTest, AMessageOfAbsurdLengthIsNone) {
  for (std::string bytes : {std::string(4, '\0'), std::string("HTTP/1.1"), std::string(8, '\xff')})
    EXPECT_THROW(static_cast<void>(take_rcss_message(bytes)), SExprError);
}

}  // namespace
}  // namespace baton::bridge
