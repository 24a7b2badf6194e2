#include "baton/robot/servo.hpp"

#include <gtest/gtest.h>

#include <random>

#include "tests/support/robots.hpp"

namespace baton {
namespace {

constexpr int kCases = 300;

/// A joint with a random target, state and time.
struct Case {
  std::size_t joint = 0;
  JointTarget target;
  double to_end = 0.0;
  double q = 0.0;
  double dq = 0.0;
};

class ServoTest : public testing::TestWithParam<std::string> {
 protected:
  [[nodiscard]] RobotModel with_drive(Drive drive) const {
    Profile profile = test::robot(GetParam()).profile();
    profile.drive = drive;
    return RobotModel(std::move(profile));
  }

  [[nodiscard]] Case draw() {
    Case c;
    const Eigen::Index n = torque_.nv() - 6;
    c.joint = std::uniform_int_distribution<std::size_t>(0, torque_.joints().size() - 1)(random_);
    const auto vector = [&](double size) {
      return VecX(VecX::NullaryExpr(n, [&] { return size * uniform_(random_); }));
    };
    c.target.q = vector(1.0);
    c.target.dq = vector(5.0);
    c.target.tau = vector(3.0);
    if (uniform_(random_) > 0.0) c.target.q_correction = vector(0.1);
    c.to_end = 0.005 * uniform_(random_);
    c.q = uniform_(random_);
    c.dq = 5.0 * uniform_(random_);
    return c;
  }

  /// Where the joint shall be at the time of a case.
  [[nodiscard]] static double due(const Case& c) {
    const auto j = static_cast<Eigen::Index>(c.joint);
    return c.target.q[j] + (c.target.q_correction.size() > 0 ? c.target.q_correction[j] : 0.0) -
           c.to_end * c.target.dq[j];
  }
  [[nodiscard]] static double speed(const Case& c) { return c.target.dq[static_cast<Eigen::Index>(c.joint)]; }
  [[nodiscard]] static double told(const Case& c) { return c.target.tau[static_cast<Eigen::Index>(c.joint)]; }
  [[nodiscard]] static double torque(const RobotModel& robot, const Case& c, double q, double dq) {
    return servo_torque(robot.joints()[c.joint].gains, servo_command(robot, c.joint, c.target, c.to_end), q, dq);
  }
  [[nodiscard]] double tolerance(const Case& c) const { return 1e-12 * (1.0 + torque_.joints()[c.joint].gains.kp); }

  const RobotModel torque_ = with_drive(Drive::torque);
  const RobotModel pd_ = with_drive(Drive::pd);
  const RobotModel stiff_ = with_drive(Drive::stiff);
  std::mt19937_64 random_{23};
  std::uniform_real_distribution<double> uniform_{-1.0, 1.0};
};

TEST_P(ServoTest, AJointThatIsWhereItShallBeGetsTheTorqueThatItIsTold) {
  for (int i = 0; i < kCases; ++i) {
    const Case c = draw();
    EXPECT_NEAR(torque(torque_, c, due(c), speed(c)), told(c), tolerance(c));
    EXPECT_NEAR(torque(pd_, c, due(c), speed(c)), told(c), tolerance(c));
    EXPECT_NEAR(torque(stiff_, c, due(c), speed(c)), told(c), tolerance(c));
  }
}

TEST_P(ServoTest, AnErrorIsAnsweredByStiffnessAndDamping) {
  for (int i = 0; i < kCases; ++i) {
    const Case c = draw();
    const Profile::Gains& gains = pd_.joints()[c.joint].gains;
    const double answer = gains.kp * (due(c) - c.q) + gains.kd * (speed(c) - c.dq);
    EXPECT_NEAR(torque(torque_, c, c.q, c.dq), told(c) + answer, tolerance(c));
    EXPECT_NEAR(torque(pd_, c, c.q, c.dq), told(c) + answer, tolerance(c));
    EXPECT_NEAR(torque(stiff_, c, c.q, c.dq), told(c) + answer, tolerance(c));
  }
}

TEST_P(ServoTest, AStiffDriveIsToldAnAngleAlone) {
  for (int i = 0; i < kCases; ++i) {
    const Case c = draw();
    const ServoCommand command = servo_command(stiff_, c.joint, c.target, c.to_end);
    EXPECT_EQ(command.dq, 0.0);
    EXPECT_EQ(command.tau, 0.0);
  }
}

TEST_P(ServoTest, FoldedIntoTheAngleATorqueIsAsTrueAsTheStiffness) {
  for (int i = 0; i < kCases; ++i) {
    const Case c = draw();
    const double share = 1.0 + 0.5 * uniform_(random_);
    Profile::Gains soft = pd_.joints()[c.joint].gains;
    soft.kp *= share;
    const double by_pd = servo_torque(soft, servo_command(pd_, c.joint, c.target, c.to_end), due(c), speed(c));
    EXPECT_NEAR(by_pd, share * told(c), tolerance(c));
  }
}

TEST_P(ServoTest, TheAngleMovesAtTheSpeedAndIsThereWhenTheTickEnds) {
  for (int i = 0; i < kCases; ++i) {
    const Case c = draw();
    for (const RobotModel* robot : {&torque_, &pd_, &stiff_}) {
      const ServoCommand now = servo_command(*robot, c.joint, c.target, c.to_end);
      const ServoCommand end = servo_command(*robot, c.joint, c.target, 0.0);
      EXPECT_NEAR(now.q + c.to_end * speed(c), end.q, 1e-12);
      EXPECT_EQ(now.dq, end.dq);
      EXPECT_EQ(now.tau, end.tau);
    }
    JointTarget flat = c.target;
    flat.q_correction = VecX::Zero(flat.q.size());
    JointTarget none = c.target;
    none.q_correction = {};
    EXPECT_EQ(servo_command(pd_, c.joint, flat, c.to_end).q, servo_command(pd_, c.joint, none, c.to_end).q);
  }
}

TEST_P(ServoTest, AMotorGivesWhatItIsAskedForUpToItsStallTorque) {
  for (int i = 0; i < kCases; ++i) {
    const Motor& motor = pd_.joints()[draw().joint].motor;
    const double asked = 2.0 * motor.stall * uniform_(random_);
    const double given = motor_torque(motor, asked);
    EXPECT_LE(std::abs(given), motor.stall);
    EXPECT_EQ(given, -motor_torque(motor, -asked));
    if (std::abs(asked) <= motor.stall) {
      EXPECT_EQ(given, asked);
    }
  }
}

INSTANTIATE_TEST_SUITE_P(Robots, ServoTest, testing::ValuesIn(test::robot_names()), test::name_of_param);

}  // namespace
}  // namespace baton
