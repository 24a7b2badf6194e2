/// The driver's seat and its heartbeat, by a clock that stands still until a test moves it.
#include "baton/cockpit/page_device.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <limits>
#include <random>

#include "baton/model/error.hpp"

namespace baton {
namespace {

using testing::HasSubstr;

class PageDeviceTest : public testing::Test {
 protected:
  static constexpr PageDevice::Page kPage = 7;

  void drive() {
    ASSERT_TRUE(device_.take(kPage));
    ASSERT_TRUE(device_.give(kPage, {}, true));
  }
  void give(const Command& command, bool deadman = true) { EXPECT_TRUE(device_.give(kPage, command, deadman)); }
  Command read() { return device_.read(0.0); }

  static Command reach() {
    Command command{.guide = Part::right_hand};
    command.axes[0] = 1.0;
    return command;
  }
  static Command lifted() { return {.guide = Part::left_foot, .lift = {1.0, 0.0}}; }

  double now_ = 1000.0;
  PageDevice device_{[this] { return now_; }};
};

TEST_F(PageDeviceTest, ADriverThatIsSilentForAQuarterOfASecondCountsAsCentred) {
  drive();
  give(reach());
  now_ += 0.25;
  EXPECT_EQ(read(), reach());
  EXPECT_TRUE(device_.status().armed);
  now_ += 0.001;
  EXPECT_EQ(read(), Command{.guide = Part::right_hand});
  EXPECT_FALSE(device_.status().connected);
  EXPECT_FALSE(device_.status().armed);
  EXPECT_THAT(device_.status().hint, HasSubstr("No signal"));
  EXPECT_EQ(device_.driver(), kPage) << "the seat stays its own";
}

TEST_F(PageDeviceTest, TheSameCommandAgainAndAgainIsAHeartbeat) {
  drive();
  for (int i = 0; i < 1000; ++i) {
    give(reach());
    now_ += 0.1;
    ASSERT_EQ(read(), reach());
  }
}

TEST_F(PageDeviceTest, AfterASilenceItHasToBeAtRestOnceMore) {
  drive();
  give(reach());
  now_ += 0.3;
  EXPECT_TRUE(read().neutral());
  give(reach());
  EXPECT_TRUE(read().neutral()) << "the key is still held";
  EXPECT_TRUE(device_.status().connected);
  EXPECT_THAT(device_.status().hint, HasSubstr("Release"));
  give({.guide = Part::right_hand});
  give(reach());
  EXPECT_EQ(read(), reach());
  EXPECT_EQ(device_.status().hint, "");
}

TEST_F(PageDeviceTest, ASilenceCountsThoughNobodyLookedMeanwhile) {
  drive();
  give(reach());
  now_ += 0.3;  // the program was busy
  give(reach());
  EXPECT_TRUE(read().neutral());
}

TEST_F(PageDeviceTest, TheTimeOfTheRunPlaysNoPart) {
  drive();
  give(reach());
  EXPECT_EQ(device_.read(0.0), reach());
  EXPECT_EQ(device_.read(100.0), reach()) << "the run makes up for ticks that were late";
  now_ += 0.3;
  EXPECT_TRUE(device_.read(100.0).neutral()) << "the run stands still";
}

TEST_F(PageDeviceTest, WhateverEndsTheSignalReleasesTheThrottleToo) {
  using End = std::function<void()>;
  const End silent = [&] { now_ += 0.3; };
  const End hand_off = [&] { give(lifted(), /*deadman=*/false); };
  const End closed = [&] { device_.release(kPage); };
  for (const End& end : {silent, hand_off, closed}) {
    device_.take(kPage);
    give({});
    give(lifted());
    ASSERT_EQ(read(), lifted());
    end();
    EXPECT_EQ(read(), Command{.guide = Part::left_foot});
    device_.release(kPage);
  }
}

TEST_F(PageDeviceTest, AThrottleThatIsStillUpIsNotAtRestWhicheverPartIsGuided) {
  drive();
  give(lifted());
  now_ += 0.3;
  EXPECT_TRUE(read().neutral());
  give({.guide = Part::trunk, .lift = {1.0, 0.0}});
  give(lifted());
  EXPECT_EQ(read(), Command{.guide = Part::left_foot});
  EXPECT_FALSE(device_.status().armed);
  give({.guide = Part::left_foot});
  give(lifted());
  EXPECT_EQ(read(), lifted());
}

TEST_F(PageDeviceTest, WhatIsHeldBesideAStopCountsOnceItWasLetGoOf) {
  drive();
  give(reach());
  Command stop = reach();
  stop.recall = Recall::stop;
  give(stop);
  EXPECT_EQ(read(), stop);
  for (const Command& held : {reach(), lifted(), Command{.recall = Recall::home}}) {
    give(stop);
    give(held);
    EXPECT_TRUE(read().neutral()) << "it was held beside the stop";
    EXPECT_THAT(device_.status().hint, HasSubstr("Release"));
  }
  give({.guide = Part::right_hand});
  give(reach());
  EXPECT_EQ(read(), reach());
}

TEST_F(PageDeviceTest, AStopCountsThoughTheStickDoesNot) {
  ASSERT_TRUE(device_.take(kPage));
  give(reach());
  EXPECT_TRUE(read().neutral());
  Command stop = reach();
  stop.recall = Recall::stop;
  give(stop);
  EXPECT_EQ(read(), stop);
  EXPECT_TRUE(device_.status().armed);
  now_ += 0.3;
  EXPECT_TRUE(read().neutral()) << "a frozen page does not stop for ever";
  give(stop);
  device_.release(kPage);
  ASSERT_TRUE(device_.take(kPage + 1));
  EXPECT_EQ(read().recall, Recall::none) << "nor one that is gone";
}

TEST_F(PageDeviceTest, WhatIsNotANumberIsCentred) {
  drive();
  const double nan = std::numeric_limits<double>::quiet_NaN();
  Command broken = lifted();
  broken.axes.setConstant(nan);
  broken.lift = {nan, nan};
  give(broken);
  EXPECT_EQ(read(), Command{.guide = Part::left_foot});
}

TEST_F(PageDeviceTest, ADriverThatNeverSaysAnythingIsSilent) {
  ASSERT_TRUE(device_.take(kPage));
  EXPECT_THAT(device_.status().hint, HasSubstr("Release"));
  now_ += 0.3;
  EXPECT_THAT(device_.status().hint, HasSubstr("No signal"));
}

/// Against the rule in words, over histories of everything that can happen to a seat.
TEST_F(PageDeviceTest, ACommandCountsOnlyWhileHeardAndAtRestOnceSinceTheLastSilenceOrStop) {
  std::mt19937_64 random(3);
  PageDevice::Page driver = 0;  // nobody
  double heard_at = 0.0;
  bool rested = false;  // since it came, or since the last silence or stop
  Command newest;
  int counted = 0;
  int silences = 0;
  for (int i = 0; i < 20000; ++i) {
    const PageDevice::Page page = random() % 10 == 0 ? 8 : kPage;
    const auto event = random() % 40;
    if (event == 0) {
      if (driver == 0) {
        driver = page;
        heard_at = now_;
        rested = false;
      }
      EXPECT_EQ(device_.take(page), driver == page);
    } else if (event == 1) {
      if (driver == page) {
        driver = 0;
        newest = {.guide = newest.guide};
      }
      device_.release(page);
    } else {
      Command command{.guide = kParts[random() % kParts.size()]};
      if (random() % 4 != 0) command.axes[static_cast<Eigen::Index>(random() % 6)] = 1.0;
      if (random() % 4 == 0) command.lift.left = 0.5;
      if (random() % 8 == 0) command.recall = Recall::stop;
      const bool deadman = random() % 8 != 0;
      EXPECT_EQ(device_.give(page, command, deadman), driver == page);
      if (driver == page) {
        const bool stopped = newest.recall == Recall::stop;
        newest = deadman ? command : Command{.guide = command.guide};
        if (now_ - heard_at > 0.25 || (stopped && newest.recall != Recall::stop)) rested = false;
        heard_at = now_;
        rested = rested || controls_released(newest);
      }
    }
    now_ += random() % 20 == 0 ? 0.5 : 0.03;
    const bool silent = now_ - heard_at > 0.25;
    if (random() % 3 == 0) continue;  // nobody looks
    const Command command = read();
    const bool counts = driver != 0 && !silent && (rested || newest.recall == Recall::stop);
    ASSERT_EQ(command, counts ? newest : Command{.guide = newest.guide});
    ASSERT_EQ(device_.status().armed, counts);
    ASSERT_EQ(device_.status().connected, driver != 0 && !silent);
    ASSERT_EQ(device_.status().hint.empty(), counts);
    counted += counts && !command.neutral() ? 1 : 0;
    silences += driver != 0 && silent ? 1 : 0;
  }
  EXPECT_GT(counted, 1000);
  EXPECT_GT(silences, 200);
}

TEST(PageDevice, RefusesASilenceThatIsNone) {
  for (const double silence : {0.0, -1.0, std::nan("")}) {
    EXPECT_THROW(PageDevice([] { return 0.0; }, {.silence = silence}), InputError);
  }
}

}  // namespace
}  // namespace baton
