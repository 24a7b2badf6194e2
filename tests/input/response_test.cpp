#include "baton/input/response.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <random>

#include "baton/model/error.hpp"

namespace baton {
namespace {

TEST(Response, IsOddRisingAndContinuousAndReachesTheEnds) {
  std::mt19937_64 random(1);
  std::uniform_real_distribution<double> dead(0.0, 0.9), curve(0.0, 1.0), position(-1.5, 1.5);
  for (int trial = 0; trial < 2000; ++trial) {
    const Response::Parameters p{dead(random), curve(random)};
    const Response response(p);
    const double a = position(random);
    const double b = position(random);
    EXPECT_EQ(response(-a), -response(a));
    EXPECT_LE(std::abs(response(a)), 1.0);
    if (a <= b) {
      EXPECT_LE(response(a), response(b));
    }
    EXPECT_NEAR(response(a), response(a + 1e-9), 1e-9 * 3.0 / (1.0 - p.dead_zone) + 1e-15);
    EXPECT_DOUBLE_EQ(response(1.0), 1.0);
    EXPECT_EQ(response(p.dead_zone * position(random) / 1.5), 0.0);
  }
}

TEST(Response, FollowsTheFormula) {
  const Response response({.dead_zone = 0.1, .curve = 0.5});
  EXPECT_DOUBLE_EQ(response(0.55), 0.5 * 0.5 + 0.5 * 0.125);
  const Response straight({.dead_zone = 0.0, .curve = 0.0});
  EXPECT_DOUBLE_EQ(straight(-0.3), -0.3);
}

TEST(Response, TakesWhatABrokenDeviceGives) {
  const Response response;
  EXPECT_EQ(response(std::numeric_limits<double>::quiet_NaN()), 0.0);
  EXPECT_DOUBLE_EQ(response(std::numeric_limits<double>::infinity()), 1.0);
  EXPECT_FALSE(std::signbit(response(-0.01)));
}

TEST(Response, RefusesParametersOutOfRange) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  for (const Response::Parameters& bad :
       {Response::Parameters{-0.01, 0.5}, Response::Parameters{1.0, 0.5}, Response::Parameters{nan, 0.5},
        Response::Parameters{0.1, -0.1}, Response::Parameters{0.1, 1.1}, Response::Parameters{0.1, nan}}) {
    EXPECT_THROW(Response{bad}, InputError) << bad.dead_zone << " " << bad.curve;
  }
}

}  // namespace
}  // namespace baton
