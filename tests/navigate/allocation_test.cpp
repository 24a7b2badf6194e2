/// The tick asks for no memory and gives none back.
#include <gtest/gtest.h>

#include <algorithm>
#include <cstdlib>
#include <random>
#include <utility>

#include "baton/balance/odometry.hpp"
#include "baton/robot/simulated_robot.hpp"
#include "tests/navigate/fuzzed_run.hpp"
#include "tests/navigate/trip.hpp"
#include "tests/support/robots.hpp"

#if defined(__SANITIZE_ADDRESS__)
#define BATON_COUNTS_ALLOCATIONS 0
#elif defined(__has_feature)
#if __has_feature(address_sanitizer)
#define BATON_COUNTS_ALLOCATIONS 0
#endif
#endif
#ifndef BATON_COUNTS_ALLOCATIONS
#define BATON_COUNTS_ALLOCATIONS 1
#endif

namespace {

thread_local bool counting = false;
thread_local long calls = 0;
volatile double seen = 0.0;

}  // namespace

#if BATON_COUNTS_ALLOCATIONS
// In place of the C library's, which they hand on to: operator new and Eigen come here too.
extern "C" {
void* __libc_malloc(std::size_t size);
void* __libc_calloc(std::size_t count, std::size_t size);
void* __libc_realloc(void* block, std::size_t size);
void* __libc_memalign(std::size_t alignment, std::size_t size);
void __libc_free(void* block);

void* malloc(std::size_t size) {
  if (counting) ++calls;
  return __libc_malloc(size);
}
void* calloc(std::size_t count, std::size_t size) {
  if (counting) ++calls;
  return __libc_calloc(count, size);
}
void* realloc(void* block, std::size_t size) {
  if (counting) ++calls;
  return __libc_realloc(block, size);
}
void* aligned_alloc(std::size_t alignment, std::size_t size) {
  if (counting) ++calls;
  return __libc_memalign(alignment, size);
}
int posix_memalign(void** block, std::size_t alignment, std::size_t size) {
  if (counting) ++calls;
  *block = __libc_memalign(alignment, size);
  return *block == nullptr ? 12 : 0;  // ENOMEM
}
void free(void* block) {
  if (counting && block != nullptr) ++calls;
  __libc_free(block);
}
}
#endif

namespace baton {
namespace {

class AllocationTest : public testing::Test {
 protected:
  void SetUp() override {
    if (!BATON_COUNTS_ALLOCATIONS) GTEST_SKIP() << "the sanitizer has the allocator";
  }
};

TEST_F(AllocationTest, WhatCountsSeesMemoryThatIsAskedForAndGivenBack) {
  counting = true;
  {
    const auto one = std::make_unique<VecX>(100);
    seen = (*one)[0];  // or else the compiler leaves it out
  }
  counting = false;
  EXPECT_EQ(std::exchange(calls, 0), 4);
}

TEST_F(AllocationTest, NoTickOfARandomRunAllocates) {
  for (const char* name : {"mighty", "scaled"}) {
    const RobotModel& robot = test::robot(name);
    for (const Gait gait : {Gait::stop, Gait::flow}) {
      std::mt19937_64 random(7);
      std::uniform_real_distribution<double> uniform(-1.0, 1.0);
      test::Trip trip(robot, Modes{.gait = gait});
      trip.on_tick = [](bool begins) { counting = begins; };
      Command command;
      for (int k = 0; k < 12000; ++k) {
        if (random() % 60 == 0) {
          command.guide = kParts[random() % kParts.size()];
          for (double& axis : command.axes)
            axis = random() % 3 == 0 ? 0.0 : uniform(random);
          command.lift = {random() % 4 == 0 ? 0.6 : 0.0, random() % 4 == 0 ? 0.6 : 0.0};
          command.recall = random() % 8 == 0 ? static_cast<Recall>(random() % 4) : Recall::none;
        }
        if (random() % 200 == 0) {  // between ticks
          ArmTargets targets = released_arms(robot);
          targets.t = {0.005 * k + 0.5, 0.005 * k + 1.0};
          targets.q = MatX::Constant(2, std::ssize(targets.joints), 0.2 * uniform(random));
          trip.navigator().drive_arms(targets);
        }
        trip.step(command);
        ASSERT_EQ(std::exchange(calls, 0), 0) << name << " at tick " << k;
      }
      EXPECT_GT(trip.navigator().committed(), 40);
    }
  }
}

TEST_F(AllocationTest, NorDoesTheEstimateOfForcesByMotorTorques) {
  for (const char* name : {"mighty", "scaled"}) {
    const RobotModel& robot = test::robot(name);
    const Posture home = stand(robot, Pose{}, robot.profile().stance.com_height);
    const World world = World::load("flat");
    Odometry odometry(robot, world, StateSource::torques, home);
    SimulatedRobot body(robot, world, home, robot.profile().tick.period);
    Measurement measurement = body.read();
    MotionSample planned;
    planned.q = home.q;
    planned.dq = planned.ddq = VecX::Zero(robot.nv());
    planned.sole = home.sole;
    for (int k = 0; k < 200; ++k) {
      planned.contact = {k % 40 < 30, true};
      measurement.torque = VecX::Constant(robot.nv() - 6, 0.01 * (k % 20));
      counting = true;
      seen = odometry.update(measurement, planned).q[0];
      counting = false;
      ASSERT_EQ(std::exchange(calls, 0), 0) << name << " at " << k;
    }
  }
}

TEST_F(AllocationTest, NorWhenItIsPushedSlipsIsLiftedFallsAndAnswersAreLate) {
  const World world = World::load("flat");
  for (const std::uint64_t seed : {1, 2, 4, 5, 7, 8}) {
    test::FuzzedRun run(test::robot("mighty"), world, seed);
    long most = 0;
    run.on_tick = [&](bool begins) {
      counting = begins;
      most = std::max(most, std::exchange(calls, 0));
    };
    run.drive(10.0);
    EXPECT_EQ(most, 0) << "seed " << seed;
  }
}

}  // namespace
}  // namespace baton
