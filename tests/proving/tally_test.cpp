#include "baton/proving/tally.hpp"

#include <gtest/gtest.h>

namespace baton {
namespace {

TEST(FailureRate, IsTheExactBound) {
  EXPECT_NEAR(failure_rate_95(0, 1), 0.95, 1e-12);
  EXPECT_NEAR(failure_rate_95(0, 59), 0.0495, 1e-4);
  EXPECT_NEAR(failure_rate_95(0, 1000000), 2.99573e-6, 1e-10);
  EXPECT_NEAR(failure_rate_95(1, 100), 0.0465598, 1e-6);
  EXPECT_NEAR(failure_rate_95(5, 50), 0.1988330, 1e-6);
  EXPECT_NEAR(failure_rate_95(10, 1000000), 1.6962160e-5, 1e-10);
  EXPECT_EQ(failure_rate_95(0, 0), 1.0);
  EXPECT_EQ(failure_rate_95(3, 3), 1.0);
}

}  // namespace
}  // namespace baton
