/// Constant errors of sensors: with and without them, as a file, and as a robot that is known by them.
#include "baton/robot/calibration.hpp"

#include <fmt/format.h>
#include <gmock/gmock.h>

#include <fstream>

#include "baton/model/error.hpp"
#include "baton/robot/calibrated_robot.hpp"
#include "tests/support/random.hpp"
#include "tests/support/robots.hpp"
#include "tests/support/temp.hpp"

namespace baton {
namespace {

using test::Random;
using testing::AllOf;
using testing::HasSubstr;

Calibration drawn(const RobotModel& robot, Random& random) {
  Calibration c;
  c.encoder_zero = random.vector(robot.nv() - 6, 0.05);
  c.imu_mount = random.vector(2, 0.05);
  for (const Side side : kSides) {
    c.force_gain[side] = 1.0 + random(-0.3, 0.3);
    c.force_zero[side] = random.vector(0.2 * robot.mass() * kGravity);
  }
  return c;
}

Measurement measured(int joints, Random& random) {
  Measurement m;
  m.t = random(-9.0, 9.0);
  m.q = random.vector(joints, 2.0);
  m.dq = random.vector(joints, 5.0);
  m.torque = random.vector(joints, 3.0);
  m.imu = {rotation_exp(random.vector(2.0)), random.vector(3.0), random.vector(20.0)};
  for (const Side side : kSides)
    m.sole[side] = {random.vector(50.0), random.vector(2.0)};
  return m;
}

void expect_near(const Measurement& a, const Measurement& b) {
  constexpr double kSame = 1e-12;
  EXPECT_EQ(a.t, b.t);
  EXPECT_LT((a.q - b.q).norm(), kSame);
  EXPECT_EQ(a.dq, b.dq);
  EXPECT_EQ(a.torque, b.torque);
  EXPECT_LT((a.imu.attitude - b.imu.attitude).norm(), kSame);
  EXPECT_LT((a.imu.rate - b.imu.rate).norm(), kSame);
  EXPECT_LT((a.imu.acceleration - b.imu.acceleration).norm(), kSame);
  for (const Side side : kSides) {
    EXPECT_LT((a.sole[side].force - b.sole[side].force).norm(), 100.0 * kSame);
    EXPECT_LT((a.sole[side].moment - b.sole[side].moment).norm(), kSame);
  }
}

class CalibrationTest : public testing::TestWithParam<std::string> {
 protected:
  const RobotModel& robot_ = test::robot(GetParam());
  const int joints_ = robot_.nv() - 6;
};

INSTANTIATE_TEST_SUITE_P(Robots, CalibrationTest, testing::ValuesIn(test::robot_names()), test::name_of_param);

TEST_P(CalibrationTest, WithErrorsAndWithoutAreInverse) {
  Random random(1);
  for (int k = 0; k < 100; ++k) {
    const Calibration errors = drawn(robot_, random);
    const Measurement exact = measured(joints_, random);
    expect_near(without_errors(with_errors(exact, errors), errors), exact);
    expect_near(with_errors(without_errors(exact, errors), errors), exact);
    expect_near(with_errors(exact, Calibration::none(joints_)), exact);
  }
}

/// Joints that go where their encoders say that they are to go.
class Obedient : public Robot {
 public:
  explicit Obedient(JointTarget* written) : written_(written) {}
  [[nodiscard]] Measurement read() override {
    Measurement m;
    m.q = written_->q + written_->q_correction;
    return m;
  }
  void write(const JointTarget& target) override { *written_ = target; }

 private:
  JointTarget* written_;
};

TEST_P(CalibrationTest, WhatIsWrittenToACalibratedRobotIsWhatItReads) {
  Random random(2);
  for (int k = 0; k < 100; ++k) {
    const Calibration errors = drawn(robot_, random);
    JointTarget target;
    for (VecX* v : {&target.q, &target.dq, &target.ddq, &target.tau, &target.q_correction})
      *v = random.vector(joints_, 1.0);
    target.contact = {true, false};
    JointTarget written;
    CalibratedRobot robot(std::make_unique<Obedient>(&written), errors);
    robot.write(target);
    EXPECT_LT((written.q - target.q - errors.encoder_zero).norm(), 1e-12) << "in the encoders' own angles";
    EXPECT_LT((robot.read().q - target.q - target.q_correction).norm(), 1e-12);
    EXPECT_EQ(written.dq, target.dq);
    EXPECT_EQ(written.ddq, target.ddq);
    EXPECT_EQ(written.tau, target.tau);
    EXPECT_EQ(written.contact, target.contact);
    EXPECT_EQ(robot.truth(), nullptr);
  }
}

std::filesystem::path written(const std::string& text) {
  const auto file = std::filesystem::path(test::temp_folder()) / "baton_calibration.toml";
  std::ofstream(file) << text;
  return file;
}

TEST_P(CalibrationTest, AFileGivesBackWhatWasWritten) {
  Random random(3);
  for (int k = 0; k < 30; ++k) {
    const Calibration c = drawn(robot_, random);
    const Calibration again = Calibration::load(written(text_of(c, drawn(robot_, random), c, robot_)), robot_);
    EXPECT_LT((again.encoder_zero - c.encoder_zero).norm(), 1e-9);
    EXPECT_LT((again.imu_mount - c.imu_mount).norm(), 1e-9);
    for (const Side side : kSides) {
      EXPECT_NEAR(again.force_gain[side], c.force_gain[side], 1e-8);
      EXPECT_LT((again.force_zero[side] - c.force_zero[side]).norm(), 1e-6);
    }
  }
}

TEST_P(CalibrationTest, ABadFileIsRefusedInOneLineWithKeyValueAndWhatIsRight) {
  const Calibration none = Calibration::none(joints_);
  const std::string good = text_of(none, none, none, robot_);
  const std::string joint = robot_.joints().back().name;
  const std::string zero = joint + " = 0";
  ASSERT_THAT(good, HasSubstr(zero));
  const auto with = [&](const std::string& from, const std::string& to) {
    std::string text = good;
    text.replace(text.find(from), from.size(), to);
    return text;
  };
  const std::string key = "encoder_zero_deg." + joint;
  for (const auto& [text, says] : std::vector<std::pair<std::string, std::string>>{
           {with(zero, joint + " = nan"), key + " = nan: must be a number from -5 to 5"},
           {with(zero, joint + " = 5.5"), key + " = 5.5: must be a number from -5 to 5"},
           {with(zero, joint + " = \"x\""), key + " = 'x': must be a number from -5 to 5"},
           {with(zero, ""), key + " is missing: must be a number from -5 to 5"},
           {with(zero, "tail = 0\n" + zero), "encoder_zero_deg.tail: a calibration has no such key"},
           {with("roll = 0", "roll = -6"), "imu_mount_deg.roll = -6: must be a number from -5 to 5"},
           {with("gain = 1", "gain = 0"), "left_force.gain = 0: must be a number from 0.5 to 2"},
           {with("zero_x = 0", "zero_x = inf"), "left_force.zero_x = inf: must be a number from -"},
           {with("robot = \"", "robot = \"not_"), fmt::format("must be \"{}\"", robot_.profile().name)},
           {with("robot = ", "# "), "robot is missing"},
           {"robot = ", "line 1"}}) {
    try {
      static_cast<void>(Calibration::load(written(text), robot_));
      ADD_FAILURE() << says;
    } catch (const InputError& error) {
      EXPECT_THAT(error.what(), AllOf(HasSubstr("baton_calibration.toml"), HasSubstr(says)));
      EXPECT_EQ(std::string(error.what()).find('\n'), std::string::npos) << error.what();
    }
  }
  EXPECT_THROW(static_cast<void>(Calibration::load("/nowhere.toml", robot_)), InputError);
}

}  // namespace
}  // namespace baton
