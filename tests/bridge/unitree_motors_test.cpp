/// What the motors of a Unitree G1 are told.
#include <gmock/gmock.h>

#include <algorithm>
#include <cmath>

#include "baton/ik/stand.hpp"
#include "bridge/unitree/joints.hpp"
#include "bridge/unitree/motors.hpp"
#include "bridge/unitree/reading.hpp"
#include "tests/bridge/g1_like.hpp"
#include "tests/bridge/unitree_states.hpp"

namespace baton::unitree {
namespace {

using test::g1_like;
using testing::HasSubstr;

constexpr double kPeriod = 0.002;  ///< of the robot's states [s]

const Motors& fresh() {
  static const Motors motors(g1_like());
  return motors;
}

/// Motors that hear from a robot.
struct Heard {
  explicit Heard(std::uint64_t seed = 1) : random(seed) { hear(); }

  void hear(unsigned buttons = 0) {
    t += kPeriod;
    LowState state = state_at(random, tick += 2);
    press(state, buttons);
    EXPECT_EQ(motors.hear(state, t), std::nullopt);
    motors.pass(t);
  }
  JointTarget target() {
    const Eigen::Index n = g1_like().nv() - 6;
    const VecX q = VecX::NullaryExpr(n, [&] { return between(random, -0.3, 0.3); });
    return {q, VecX::Constant(n, 0.5), VecX::Zero(n), VecX::Constant(n, 2.0), {true, true}, {}};
  }
  std::optional<std::string> engage(double times = 1.0) {
    const Eigen::Index n = g1_like().nv() - 6;
    VecX kp(n), kd(n);
    for (Eigen::Index i = 0; i < n; ++i) {
      kp[i] = times * g1_like().joints()[static_cast<std::size_t>(i)].gains.kp;
      kd[i] = times * g1_like().joints()[static_cast<std::size_t>(i)].gains.kd;
    }
    return motors.engage(kp, kd, t);
  }
  void expect_brake() const {
    const LowCommand command = motors.command(t);
    for (std::size_t i = 0; i < kJoints.size(); ++i) {
      EXPECT_EQ(command.motors[i].kp, 0.0F);
      EXPECT_EQ(command.motors[i].tau, 0.0F);
      EXPECT_EQ(command.motors[i].dq, 0.0F);
      EXPECT_GT(command.motors[i].kd, 0.0F);
    }
  }

  Random random;
  Motors motors = fresh();
  double t = 100.0;
  std::uint32_t tick = 0;
};

TEST(UnitreeMotors, BrakeAtFirstAndSayWhatTheRobotExpects) {
  Heard it;
  EXPECT_EQ(it.motors.state(), Motors::State::braking);
  it.expect_brake();
  const LowCommand command = it.motors.command(it.t);
  EXPECT_EQ(command.mode_pr, 0);
  EXPECT_EQ(command.mode_machine, 5);
  EXPECT_EQ(command.crc, checksum(command));
  for (std::size_t i = 0; i < kSlots; ++i)
    EXPECT_EQ(command.motors[i].mode, i < kJoints.size() ? 1 : 0);
}

TEST(UnitreeMotors, FollowTheDriverFromItsFirstTargetOnWithItsGains) {
  Heard it;
  ASSERT_EQ(it.engage(1.5), std::nullopt);
  it.hear();
  it.expect_brake();  // nothing was asked for yet
  const JointTarget target = it.target();
  const double end = it.t + 0.005;
  it.motors.follow(target, end, it.t);
  EXPECT_EQ(it.motors.state(), Motors::State::driven);
  for (const double t : {it.t, it.t + 0.002, it.t + 0.004, end, end + 0.004, end + 0.006}) {
    const LowCommand command = it.motors.command(t);
    for (std::size_t i = 0; i < kJoints.size(); ++i) {
      const auto at = static_cast<Eigen::Index>(i);
      const MotorCommand& motor = command.motors[it.motors.motors()[i]];
      const double left = std::max(end - t, 0.0);
      EXPECT_NEAR(motor.q, target.q[at] - 0.5 * left, 1e-6);
      EXPECT_EQ(motor.dq, t < end + 0.005 ? 0.5F : 0.0F) << "of a target that is past, nothing moves";
      EXPECT_EQ(motor.tau, 2.0F);
      EXPECT_FLOAT_EQ(motor.kp, static_cast<float>(1.5 * g1_like().joints()[i].gains.kp));
      EXPECT_FLOAT_EQ(motor.kd, static_cast<float>(1.5 * g1_like().joints()[i].gains.kd));
    }
  }
  it.motors.release();
  it.expect_brake();
  it.motors.follow(target, end, it.t);
  it.expect_brake();
}

TEST(UnitreeMotors, RefuseGainsThatAreMoreThanTwiceTheProfiles) {
  Heard it;
  EXPECT_THAT(it.engage(2.1).value_or(""), HasSubstr("must be at most"));
  EXPECT_THAT(it.engage(-0.1).value_or(""), HasSubstr("must be at most"));
  EXPECT_THAT(it.engage(std::nan("")).value_or(""), HasSubstr("must be at most"));
  it.motors.follow(it.target(), it.t, it.t);
  it.expect_brake();
}

TEST(UnitreeMotors, GoToTheStanceWithoutAJumpAndNoFasterThanStated) {
  const VecX stance = stand(g1_like(), Pose{}, g1_like().profile().stance.com_height).q.tail(g1_like().nv() - 6);
  for (std::uint64_t seed = 0; seed < 4; ++seed) {
    Heard it(seed);
    const Measurement before = measurement_of(it.motors.heard()->state, it.motors.motors(), it.t);
    ASSERT_EQ(it.motors.pose(it.t), std::nullopt);
    VecX last = before.q;
    for (int i = 0; i < 4000; ++i) {
      const LowCommand command = it.motors.command(it.t);
      VecX q(last.size());
      for (Eigen::Index at = 0; at < q.size(); ++at)
        q[at] = command.motors[it.motors.motors()[static_cast<std::size_t>(at)]].q;
      ASSERT_LE((q - last).cwiseAbs().maxCoeff(), 1.5 * 0.3 * kPeriod + 1e-6);
      last = q;
      it.hear();
    }
    ASSERT_LE((last - stance).cwiseAbs().maxCoeff(), 1e-5);
    // And stays there while a driver prepares, until its first target.
    ASSERT_EQ(it.engage(), std::nullopt);
    EXPECT_EQ(it.motors.state(), Motors::State::posing);
  }
}

TEST(UnitreeMotors, DampWhenTheRobotIsSilentFrozenOrItsDriverIs) {
  for (const bool frozen : {false, true}) {
    Heard it;
    const LowState last = it.motors.heard()->state;
    const auto pass = [&](double time) {
      for (const double until = it.t + time; it.t < until; it.t += kPeriod) {
        if (frozen) {
          EXPECT_EQ(it.motors.hear(last, it.t), std::nullopt);
        }
        it.motors.pass(it.t);
      }
    };
    pass(0.095);
    EXPECT_EQ(it.motors.state(), Motors::State::braking);
    pass(0.01);
    EXPECT_EQ(it.motors.state(), Motors::State::damped);
    EXPECT_EQ(it.motors.damped_because(), "nothing new from the robot for 100 ms");
    EXPECT_EQ(it.motors.arm(it.t), "nothing is heard from the robot");
  }
  Heard it;
  ASSERT_EQ(it.engage(), std::nullopt);
  for (int i = 0; i < 1000; ++i)
    it.hear();  // until its first target it may take its time
  it.motors.follow(it.target(), it.t, it.t);
  for (int i = 0; i < 249; ++i)
    it.hear();
  EXPECT_EQ(it.motors.state(), Motors::State::driven);
  for (int i = 0; i < 3; ++i)
    it.hear();
  EXPECT_EQ(it.motors.damped_because(), "no target from the driver for 500 ms");
}

TEST(UnitreeMotors, AnotherMachineOrAnAnkleModeThatIsNotTheirsIsNotFollowed) {
  Heard it;
  LowState other = state_at(it.random, it.tick + 2);
  other.mode_machine = 6;
  seal(other);
  EXPECT_EQ(it.motors.hear(other, it.t), "another mode_machine than before");
  EXPECT_EQ(it.motors.heard()->state.mode_machine, 5);
  LowState ab = state_at(it.random, it.tick + 4);
  ab.mode_pr = 1;
  seal(ab);
  EXPECT_EQ(it.motors.hear(ab, it.t), std::nullopt);
  EXPECT_EQ(it.motors.state(), Motors::State::braking);
  EXPECT_THAT(it.engage().value_or(""), HasSubstr("ankles are in mode 1"));
}

/// Whatever happens in whatever order: the table of states in the header holds, and what is sent is safe.
TEST(UnitreeMotors, KeepTheirPromisesInAnyOrderOfEvents) {
  for (std::uint64_t seed = 0; seed < 3000; ++seed) {
    Heard it(seed);
    bool engaged = false;  // a driver is there, as far as it was told
    bool damped = false;   // something has damped, and nobody armed
    bool remote = false;   // the remote's buttons are held
    double heard_at = it.t;
    for (int i = 0; i < 40; ++i) {
      const Motors::State before = it.motors.state();
      switch (it.random() % 10) {
        case 0:
          if (it.engage() == std::nullopt) engaged = true;
          break;
        case 1:
        case 2:
          it.motors.follow(it.target(), it.t + 0.005, it.t);
          break;
        case 3:
          it.motors.release();
          engaged = false;
          break;
        case 4:
          if (it.motors.pose(it.t) == std::nullopt) {
            ASSERT_TRUE(before == Motors::State::braking && !engaged);
          }
          break;
        case 5:
          if (it.random() % 4 == 0) it.motors.damp("by a test");
          break;
        case 6: {
          const bool allowed = before == Motors::State::damped && it.t - heard_at <= 0.1 && !remote;
          ASSERT_EQ(it.motors.arm(it.t) == std::nullopt, allowed);
          if (allowed) damped = engaged = false;
          break;
        }
        case 7:
          it.t += between(it.random, 0.0, 0.12);
          it.motors.pass(it.t);
          break;
        default:
          remote = it.random() % 8 == 0;
          it.hear(remote ? kL2 | kB : it.random() % 4 == 0 ? kStart : 0U);
          heard_at = it.t;
          break;
      }
      const Motors::State now = it.motors.state();
      if (before == Motors::State::damped && damped) {
        ASSERT_EQ(now, Motors::State::damped) << "latched";
      }
      if (now == Motors::State::damped) {
        damped = true;
        engaged = false;
      }
      if (remote && heard_at == it.t) {
        ASSERT_EQ(now, Motors::State::damped);
      }
      if (now == Motors::State::driven) {
        ASSERT_TRUE(engaged);
        ASSERT_LE(it.t - heard_at, 0.1 + 0.12) << "at the latest when time is looked at";
      }
      const LowCommand command = it.motors.command(it.t);
      ASSERT_EQ(command.crc, checksum(command));
      for (const MotorCommand& motor : command.motors) {
        ASSERT_TRUE(std::isfinite(motor.q) && std::isfinite(motor.dq) && std::isfinite(motor.tau));
        if (now == Motors::State::braking || now == Motors::State::damped) {
          ASSERT_EQ(motor.kp, 0.0F);
          ASSERT_EQ(motor.tau, 0.0F);
        }
      }
    }
  }
}

}  // namespace
}  // namespace baton::unitree
