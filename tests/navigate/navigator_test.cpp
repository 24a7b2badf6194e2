#include "baton/navigate/navigator.hpp"
#include "baton/plan/strategy.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <random>
#include <set>

#include "baton/ik/stand.hpp"
#include "tests/guide/commands.hpp"
#include "tests/navigate/trip.hpp"
#include "tests/support/robots.hpp"
#include "tests/support/turned_imu.hpp"

namespace baton {
namespace {

using test::push;
using test::Trip;

/// Anything that a stick may ask for.
Command anything(std::mt19937_64& random) {
  std::uniform_real_distribution<double> uniform(-1.0, 1.0);
  Command command;
  command.guide = kParts[random() % kParts.size()];
  for (double& axis : command.axes)
    axis = random() % 2 == 0 ? uniform(random) : 0.0;
  if (random() % 3 == 0) command.lift = {std::abs(uniform(random)), std::abs(uniform(random))};
  return command;
}

/// How far one posture is from another: parts [m] and their attitudes [rad].
std::pair<double, double> distance(const Posture& a, const Posture& b) {
  double place = (a.com - b.com).norm();
  double attitude = rotation_error(a.trunk, b.trunk).norm();
  for (const Side side : kSides) {
    place = std::max({place, (a.sole[side].p - b.sole[side].p).norm(), (a.hand[side].p - b.hand[side].p).norm()});
    attitude = std::max({attitude, rotation_error(a.sole[side].R, b.sole[side].R).norm(),
                         rotation_error(a.hand[side].R, b.hand[side].R).norm()});
  }
  return {place, attitude};
}

class NavigatorTest : public testing::TestWithParam<std::string> {
 protected:
  const RobotModel& robot_ = test::robot(GetParam());
};

INSTANTIATE_TEST_SUITE_P(Robots, NavigatorTest, testing::ValuesIn(test::robot_names()), test::name_of_param);

TEST_P(NavigatorTest, RestsWhileNothingIsAsked) {
  Trip run(robot_);
  for (int k = 0; k < 200; ++k) {
    const JointTarget& target = run.step({});
    ASSERT_EQ(run.navigator().phase(), Phase::hold);
    ASSERT_LT((target.q - run.home().q.tail(target.q.size())).norm(), 1e-9);
  }
  EXPECT_EQ(run.requests(), 0);
}

TEST_P(NavigatorTest, AHeldStickGivesOneSegmentAfterAnotherWithoutAPause) {
  Trip run(robot_);
  const int lookahead = robot_.profile().tick.lookahead;
  int held = 0;
  for (int k = 0; k < 1200; ++k) {
    run.step(push(Part::trunk, 0));
    if (k > lookahead && run.navigator().phase() == Phase::hold) ++held;
  }
  EXPECT_EQ(held, 0);
  EXPECT_GE(run.navigator().committed(), 5);
  EXPECT_GT(run.navigator().sample().com.x(), 2.0 * robot_.profile().reach.trunk);
}

TEST_P(NavigatorTest, ASwitchOfTheGuidedPartTakesEffectAtTheNextInstantWithoutAPause) {
  Trip run(robot_);
  while (run.navigator().committed() < 2)
    run.step(push(Part::trunk, 0));
  const long before = run.navigator().committed();
  for (int k = 0; k < 20; ++k)
    run.step(push(Part::trunk, 0));
  ASSERT_EQ(run.navigator().committed(), before) << "in the middle of a segment";
  int held = 0;
  while (run.navigator().committed() == before) {
    run.step(push(Part::left_hand, 2, -0.5));
    held += run.navigator().phase() == Phase::hold ? 1 : 0;
  }
  EXPECT_EQ(held, 0);
  ASSERT_NE(run.navigator().motion(), nullptr);
  EXPECT_EQ(run.navigator().motion()->goal.guided, Part::left_hand);
}

TEST_P(NavigatorTest, AnAnswerIsTakenOverAtItsTickOrDropped) {
  Trip run(robot_);
  std::optional<Request> request;
  for (int k = 0; k < 3 && !request; ++k) {
    run.body().write(run.navigator().tick(run.body().read(), push(Part::trunk, 0)));
    request = run.navigator().request();
  }
  ASSERT_TRUE(request.has_value());
  EXPECT_EQ(request->at, run.navigator().now() + robot_.profile().tick.lookahead);
  Answer late = run.strategy().plan(*request);
  EXPECT_FALSE(run.navigator().request().has_value()) << "one request at a time";
  // It is not there at its tick: the robot goes on resting, and asks again.
  while (run.navigator().now() < request->at) {
    run.body().write(run.navigator().tick(run.body().read(), push(Part::trunk, 0)));
  }
  EXPECT_EQ(run.navigator().phase(), Phase::hold);
  run.navigator().answer(std::move(late));
  run.body().write(run.navigator().tick(run.body().read(), push(Part::trunk, 0)));
  EXPECT_EQ(run.navigator().committed(), 0) << "too late is dropped";
  run.step(push(Part::trunk, 0));
  for (int k = 0; k < 2 * robot_.profile().tick.lookahead; ++k)
    run.step(push(Part::trunk, 0));
  EXPECT_EQ(run.navigator().committed(), 1);
}

TEST_P(NavigatorTest, ARefusalIsGivenOnceAndGoesWithTheCommand) {
  Trip run(robot_);
  const Command impossible = push(Part::left_foot, 1, -1.0);  // onto the other foot
  for (int k = 0; k < 400; ++k)
    run.step(impossible);
  EXPECT_EQ(run.requests(), 1);
  ASSERT_TRUE(run.navigator().refusal() != nullptr);
  EXPECT_EQ(run.navigator().refusal()->reason, Reason::foot_region);
  EXPECT_EQ(run.navigator().refusal()->part, Part::left_foot);
  EXPECT_LT(run.navigator().refusal()->value, run.navigator().refusal()->limit);
  run.step({});
  EXPECT_FALSE(run.navigator().refusal() != nullptr);
  for (int k = 0; k < 100; ++k)
    run.step(push(Part::trunk, 0));
  EXPECT_GE(run.navigator().committed(), 1) << "the next command is served";
}

TEST_P(NavigatorTest, TheSameRunTwiceIsTheSameBitByBit) {
  const auto targets = [&] {
    Trip run(robot_);
    std::mt19937_64 random(3);
    Command command;
    std::vector<double> all;
    for (int k = 0; k < 2000; ++k) {
      if (k % 150 == 0) {
        command.guide = kParts[random() % kParts.size()];
        for (double& axis : command.axes)
          axis = std::uniform_real_distribution<double>(-1, 1)(random);
        command.lift.left = (random() % 3) * 0.5;
      }
      const JointTarget& target = run.step(command);
      all.insert(all.end(), target.q.begin(), target.q.end());
      all.insert(all.end(), target.tau.begin(), target.tau.end());
    }
    return all;
  };
  const std::vector<double> first = targets();
  EXPECT_EQ(first, targets());
}

TEST_P(NavigatorTest, WhateverTheStickDoesJointsKeepTheirLimitsAndEveryMotionEndsAtRest) {
  std::mt19937_64 random(17);
  std::uniform_real_distribution<double> unit(-1.5, 1.5);
  for (int script = 0; script < 6; ++script) {
    Trip run(robot_);
    Command command;
    VecX before = run.home().q.tail(robot_.nv() - 6);
    const double period = robot_.profile().tick.period;
    for (int k = 0; k < 3000; ++k) {
      if (random() % 60 == 0) {
        command.guide = kParts[random() % kParts.size()];
        for (double& axis : command.axes)
          axis = random() % 4 == 0 ? std::nan("") : unit(random);
        command.lift = {unit(random), unit(random)};
      }
      const JointTarget& target = run.step(command);
      ASSERT_TRUE(target.q.allFinite() && target.dq.allFinite() && target.tau.allFinite());
      for (std::size_t j = 0; j < robot_.joints().size(); ++j) {
        const auto i = static_cast<Eigen::Index>(j);
        const Joint& joint = robot_.joints()[j];
        ASSERT_GE(target.q[i], joint.position.lo);
        ASSERT_LE(target.q[i], joint.position.hi);
        ASSERT_LE(std::abs(target.q[i] - before[i]), joint.speed * period * 1.001) << joint.name;
        ASSERT_LE(std::abs(target.tau[i]), joint.motor.stall) << joint.name;
      }
      before = target.q;
      if (const PlannedMotion* planned = run.navigator().planned()) {
        ASSERT_TRUE(planned->motion->samples.back().dq.isZero(0.0));
        ASSERT_FALSE(planned->motion.certificate().margins.empty());
      }
    }
    EXPECT_GT(run.navigator().committed(), 3);
  }
}

TEST_P(NavigatorTest, RetracingGoesBackRestByRestToTheStart) {
  std::mt19937_64 random(21);
  int retraced = 0;
  for (const std::string world : {"flat", "room"}) {
    for (int trial = 0; trial < 8; ++trial) {
      const Gait gait = trial % 2 == 0 ? Gait::stop : Gait::flow;
      Trip run(robot_, {.gait = gait}, world);
      const double size = robot_.profile().stance.com_height / 0.26;
      std::vector<Posture> rests{run.home()};
      const auto live = [&](const Command& command) {
        const long before = run.navigator().committed();
        const std::size_t rested = run.navigator().history();
        run.step(command);
        if (run.navigator().committed() == before) return;
        if (run.navigator().history() == rested) rests.pop_back();  // it never came there
        rests.push_back(run.navigator().motion()->end);
      };
      for (int k = 0; k < 40; ++k) {
        const Command command = anything(random);
        for (int tick = 0; tick < 100; ++tick) {
          live(command);
        }
      }
      while (run.navigator().motion() != nullptr) {
        live({});
      }
      ASSERT_GT(rests.size(), gait == Gait::stop ? 10u : 1u);
      ASSERT_EQ(run.navigator().history(), rests.size() - 1);
      Command back;
      back.recall = Recall::retrace;
      while (run.navigator().history() > 0) {
        rests.pop_back();
        const std::size_t left = run.navigator().history();
        while (run.navigator().history() == left) {
          run.step(back);
          ASSERT_FALSE(run.navigator().refusal() != nullptr) << to_string(run.navigator().refusal()->reason);
        }
        ASSERT_TRUE(run.navigator().motion()->retraces);
        const auto [place, attitude] = distance(run.navigator().motion()->end, rests.back());
        ASSERT_LT(place, 0.005 * size);
        ASSERT_LT(attitude, 0.02);
        ++retraced;
      }
      while (run.navigator().motion() != nullptr)
        run.step(back);
      for (int k = 0; k < 100; ++k)
        run.step(back);
      ASSERT_EQ(run.navigator().phase(), Phase::hold);
      EXPECT_EQ(run.navigator().refusal()->reason, Reason::no_history);
      const auto [place, attitude] = distance(posture_of(robot_, run.body().truth()->q), run.home());
      EXPECT_LT(place, 0.005 * size);
      EXPECT_LT(attitude, 0.02);
    }
  }
  EXPECT_GT(retraced, 200);
}

TEST_P(NavigatorTest, AfterASlipTheWayBackIsForgotten) {
  Trip run(robot_, {.gait = Gait::stop}, "flat", StateSource::perfect);
  while (run.navigator().committed() < 3)
    run.step(push(Part::trunk, 0));
  while (run.navigator().motion() != nullptr)
    run.step({});
  ASSERT_EQ(run.navigator().history(), 3u);
  Command back;
  back.recall = Recall::retrace;
  Measurement measurement = run.body().read();
  for (const double share : {0.1, 0.3}) {
    Measurement slid = measurement;
    slid.root->pose.p.x() += share * robot_.profile().reach.foot;
    run.navigator().tick(slid, back);
    run.navigator().poll();
    const std::optional<Request> request = run.navigator().request();
    ASSERT_TRUE(request.has_value());
    EXPECT_EQ(request->start.trail != nullptr, share < 0.2);
    EXPECT_EQ(run.navigator().history(), share < 0.2 ? 3u : 0u);
    EXPECT_EQ(run.navigator().slips(), share < 0.2 ? 0 : 1);
    // In vain: the answer is withheld until its tick has passed.
    while (run.navigator().now() <= request->at)
      run.navigator().tick(slid, {});
  }
}

TEST_P(NavigatorTest, TheFartherItHasGoneTheLessSureIsItsPlace) {
  Trip run(robot_);
  const Odometry& odometry = run.navigator().odometry();
  std::set<double> planned_with{0.0};
  int from_flight = 0;
  int of_flight = 0;
  run.on_request = [&](const Request& request) {
    const Start& start = request.start;
    const double unsure = start.context.place_uncertainty;
    if (start.posture.flight || start.posture.lift_off) {
      ASSERT_TRUE(planned_with.contains(unsure)) << "it stays as it is until the foot has landed";
      of_flight += unsure < odometry.uncertainty() ? 1 : 0;
      return;
    }
    // A robot that walks on never plans while both feet stand. Once this was taken from the step before, and so from
    // the first one: it walked into the wall.
    ASSERT_EQ(unsure, odometry.uncertainty());
    planned_with.insert(unsure);
    const BySide<bool>& stands = run.navigator().sample().contact;
    from_flight += stands.left && stands.right ? 0 : 1;
  };
  int tick = 0;
  while (odometry.uncertainty() < 0.3 * robot_.profile().stance.com_height) {
    run.step(push(Part::trunk, ++tick / 150 % 4 == 0 ? 1 : 0));  // a step is replaced where the stick changes
  }
  EXPECT_GT(from_flight, 20);
  EXPECT_GT(of_flight, 5);
  Trip perfect(robot_, {}, "flat", StateSource::perfect);
  for (int k = 0; k < 1000; ++k)
    perfect.step(push(Part::trunk, 0));
  EXPECT_EQ(perfect.navigator().request_for({}).start.context.place_uncertainty, 0.0);
}

TEST_P(NavigatorTest, NoFootIsLiftedWhileTheOtherStandsOnAnEdge) {
  // The ankle tells that a sole is tilted; who stood on such a one alone fell, in the room, from a step's edge.
  Trip run(robot_, {.gait = Gait::stop}, "flat", StateSource::perfect);
  run.step({});
  const World flat = World::load("flat");
  Strategy strategy(robot_, flat);
  for (const Side tilted : kSides) {
    for (const double angle : {0.05, 0.12}) {
      Measurement measurement = run.body().read();
      measurement.q[robot_.leg(tilted).back()] += tilted == Side::left ? angle : -angle;
      for (const Side lifted : kSides) {
        Navigator navigator(robot_, flat, run.home(), Gait::stop, StateSource::perfect);
        const Command step = push(foot(lifted), 0, 0.5);
        std::optional<Request> request;
        for (double t = 0.0; t < 1.0 && !request; t += robot_.profile().tick.period) {  // joints come to the plan first
          navigator.tick(measurement, step);
          request = navigator.request();
          measurement.t += robot_.profile().tick.period;
        }
        ASSERT_TRUE(request.has_value());
        EXPECT_EQ(request->terrain.inclined.has_value(), angle > 0.1);
        const Answer result = strategy.plan(*request);
        const auto* refusal = std::get_if<Refusal>(&result.outcome);
        const bool refused = angle > 0.1 && lifted != tilted;
        ASSERT_EQ(refusal != nullptr, refused) << (refusal != nullptr ? to_string(refusal->reason) : "");
        if (!refused) continue;
        EXPECT_EQ(refusal->reason, Reason::inclined_sole);
        EXPECT_EQ(refusal->part, foot(tilted));
        EXPECT_NEAR(refusal->value, angle, 0.01);
      }
    }
  }
}

TEST_P(NavigatorTest, WhereASoleStoodInclinedTheGroundCountsAsUnevenForAWhile) {
  Trip run(robot_, {}, "flat", StateSource::perfect);
  const auto uneven_after = [&](double angle, double seconds) {
    Navigator navigator(robot_, run.world(), run.home(), Gait::flow, StateSource::perfect);
    Measurement inclined = run.body().read();
    inclined.q[robot_.leg(Side::left).back()] += angle;
    navigator.tick(inclined, {});
    for (double t = 0.0; t < seconds; t += robot_.profile().tick.period)
      navigator.tick(run.body().read(), {});
    navigator.tick(run.body().read(), push(Part::trunk, 0));
    const std::optional<Request> request = navigator.request();
    EXPECT_TRUE(request.has_value());
    return request && request->terrain.uneven;
  };
  run.step({});
  EXPECT_FALSE(uneven_after(0.01, 0.0));
  EXPECT_TRUE(uneven_after(0.02, 0.0));
  EXPECT_TRUE(uneven_after(0.02, 2.0));
  EXPECT_FALSE(uneven_after(0.02, 4.0));
  EXPECT_TRUE(uneven_after(0.04, 4.0));
}

TEST_P(NavigatorTest, OnUnevenGroundTheZmpKeepsFartherInsideWhereItCan) {
  // Whole motions, seen from the least room that their ZMP leaves on the way.
  Trip run(robot_, {.gait = Gait::stop});
  std::mt19937_64 random(29);
  const auto room = [](const Motion& motion) {
    double least = std::numeric_limits<double>::infinity();
    for (const MotionSample& sample : motion.samples)
      least = std::min(least, sample.zmp_region->margin(sample.zmp));
    return least;
  };
  const Profile::Margin& margin = robot_.profile().margin;
  const double wanted = std::min(2.0 * margin.zmp_plan, margin.stand_on) - margin.zmp_feedback;
  int tight = 0;
  double as_ever = 0.0;
  double careful = 0.0;
  while (tight < 30) {
    const Command command = anything(random);
    for (int k = 0; k < 40; ++k)
      run.step(command);
    for (int k = 0; k < 4000 && run.navigator().motion() != nullptr; ++k)
      run.step({});
    Request request = run.navigator().request_for(anything(random));
    const Answer on_even = run.strategy().plan(request);
    request.terrain.uneven = true;
    const Answer on_uneven = run.strategy().plan(request);
    const auto* even = std::get_if<PlannedMotion>(&on_even.outcome);
    const auto* uneven = std::get_if<PlannedMotion>(&on_uneven.outcome);
    ASSERT_EQ(even == nullptr, uneven == nullptr) << "nothing is refused for it";
    if (even == nullptr || room(*even->motion) > 0.8 * wanted) continue;
    ++tight;
    as_ever += room(*even->motion) / 30;
    careful += room(*uneven->motion) / 30;
  }
  EXPECT_LT(as_ever, 0.6 * wanted);
  EXPECT_GT(careful, 0.95 * wanted);
}

TEST_P(NavigatorTest, WhereNoStepCatchesItWhatWasToBeDoneOtherwiseIsDone) {
  Trip run(robot_);
  run.step({});
  Request request = run.navigator().request_for({});
  const double height = robot_.profile().stance.com_height;
  // From both feet, straight aside: the one that carries cannot step.
  Catch capture{.by = {0.0, 0.2 * height}, .height = run.navigator().anchor().p.z()};
  const auto planned = [&](const std::vector<Intent>& intents) {
    request.intents = intents;
    return run.strategy().plan(request);
  };
  EXPECT_TRUE(std::holds_alternative<std::monostate>(planned({capture}).outcome));
  const Answer stays = planned({capture, Follow{}});
  EXPECT_TRUE(std::holds_alternative<std::monostate>(stays.outcome));  // nothing is asked for
  EXPECT_TRUE(std::holds_alternative<Follow>(stays.intent));
  request.command = push(Part::trunk, 0);
  const Answer follows = planned({capture, Follow{}});
  ASSERT_NE(follows.motion(), nullptr);
  EXPECT_EQ(follows.command, request.command);
  EXPECT_EQ(follows.capture(), nullptr);
  // If it is to fall else, the other foot steps.
  capture.dcm_excess = 0.11 * height;
  const Answer aside = planned({capture, Follow{}});
  ASSERT_NE(aside.capture(), nullptr);
  EXPECT_EQ(aside.motion()->goal.swing, Side::right);
  EXPECT_TRUE(aside.command.neutral());
  // Where one does, it is the answer.
  capture.dcm_excess = 0.0;
  capture.by = {0.2 * height, 0.0};
  EXPECT_NE(planned({capture, Follow{}}).capture(), nullptr);
}

TEST_P(NavigatorTest, HomeIsTheStanceThatItBeganInWhereverItIs) {
  std::mt19937_64 random(22);
  for (int trial = 0; trial < 8; ++trial) {
    Trip run(robot_);
    for (int k = 0; k < 40; ++k) {
      const Command command = anything(random);
      for (int tick = 0; tick < 100; ++tick)
        run.step(command);
    }
    Command home;
    home.recall = Recall::home;
    for (int k = 0; k < 6000; ++k)
      run.step(home);
    ASSERT_EQ(run.navigator().phase(), Phase::hold);
    ASSERT_FALSE(run.navigator().refusal() != nullptr) << to_string(run.navigator().refusal()->reason);
    // The same posture, somewhere else.
    const Posture now = posture_of(robot_, run.body().truth()->q);
    const Pose moved{now.sole.left.p, rotation_z(now.heading())};
    const Pose began{run.home().sole.left.p, rotation_z(run.home().heading())};
    const double size = robot_.profile().stance.com_height / 0.26;
    EXPECT_LT((moved.inverse() * now.com - began.inverse() * run.home().com).norm(), 0.003 * size);
    EXPECT_LT((moved.inverse() * now.sole.right.p - began.inverse() * run.home().sole.right.p).norm(), 0.003 * size);
    for (const Side side : kSides)
      EXPECT_LT((moved.inverse() * now.hand[side].p - began.inverse() * run.home().hand[side].p).norm(), 0.006 * size);
  }
}

TEST_P(NavigatorTest, AGoalOutOfReachIsShrunkAlongItsDirectionAndSaysWhy) {
  std::mt19937_64 random(23);
  int refused = 0;
  int shrunk = 0;
  int along = 0;
  Trip run(robot_);
  Strategy strict(robot_, run.world(), {.on_limit = OnLimit::discard});
  for (int k = 0; k < 450; ++k) {
    const Command command = anything(random);
    for (int tick = 0; tick < 80; ++tick) {
      const JointTarget& target = run.navigator().tick(run.body().read(), command);
      run.body().write(target);
      const auto request = run.navigator().request();
      if (!request) continue;
      const Answer result = run.strategy().plan(*request);
      const Answer discarded = strict.plan(*request);
      const auto* against = std::get_if<Refusal>(&discarded.outcome);
      const auto* planned = std::get_if<PlannedMotion>(&result.outcome);
      if (against == nullptr) {
        ASSERT_EQ(planned != nullptr, std::holds_alternative<PlannedMotion>(discarded.outcome));
        if (planned != nullptr) {
          ASSERT_FALSE(planned->limit.has_value());
        }
      } else {
        ++refused;
        if (planned != nullptr) {
          ++shrunk;
          ASSERT_TRUE(planned->limit.has_value());
          EXPECT_EQ(planned->limit->reason, against->reason);
          ASSERT_FALSE(planned->motion.certificate().margins.empty());
          const VerifiedMotion& motion = planned->motion;
          const Posture& from = request->start.context.from;
          if (command.guide != Part::trunk && motion->goal.guided == command.guide && command.lift.left == 0.0) {
            const Side side = side_of(command.guide);
            const bool is_step = is_foot(command.guide);
            Vec3 asked = rotation_z(from.heading()) * command.axes.head<3>();
            Vec3 made = is_step ? Vec3(motion->end.sole[side].p - from.sole[side].p)
                                : Vec3(motion->end.hand[side].p - from.hand[side].p);
            if (is_step) asked.z() = made.z() = 0.0;
            const double least = 0.001 * robot_.profile().stance.com_height;
            if (made.norm() > least && asked.norm() > 0.0) {
              EXPECT_GT(made.dot(asked), 0.0);
              ++along;
            }
          }
        }
      }
      run.navigator().answer(result);
    }
  }
  EXPECT_GT(refused, 20);
  EXPECT_GT(shrunk, refused / 4);
  EXPECT_GT(along, 5);
}

TEST_P(NavigatorTest, AfterAFallNothingPlannedIsExecuted) {
  Trip run(robot_);
  while (run.navigator().committed() < 1)
    run.step(push(Part::trunk, 0));
  for (int k = 0; k < 20; ++k)
    run.step(push(Part::trunk, 0));
  // It tips over within a second, as all sensors of the IMU agree.
  const double period = robot_.profile().tick.period;
  const Vec3 rate(0.0, 1.0, 0.0);
  double angle = 0.0;
  while (run.navigator().phase() != Phase::fallen) {
    ASSERT_LT(angle, 1.0);
    angle += rate.y() * period;
    Measurement measurement = run.body().read();
    test::turn_imu(measurement, rotation_exp({0.0, angle, 0.0}));
    measurement.imu.rate += measurement.imu.attitude.transpose() * rate;
    run.navigator().tick(measurement, push(Part::trunk, 0));
  }
  for (int k = 0; k < 300; ++k) {
    const Measurement measurement = run.body().read();
    const JointTarget& target = run.navigator().tick(measurement, push(Part::trunk, 0));
    EXPECT_EQ(run.navigator().phase(), Phase::fallen);
    EXPECT_EQ(target.q, measurement.q) << "nothing is asked of the motors";
    EXPECT_TRUE(target.tau.isZero(0.0));
    EXPECT_FALSE(run.navigator().request().has_value());
  }
}

}  // namespace
}  // namespace baton
