#include "baton/robot/plant.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>

#include "baton/ik/stand.hpp"
#include "baton/model/error.hpp"
#include "baton/proving/scenario.hpp"
#include "baton/robot/simulated_robot.hpp"
#include "baton/run/simulation.hpp"
#include "tests/support/robots.hpp"

namespace baton {
namespace {

using testing::HasSubstr;

constexpr double kStep = 0.001;  ///< of physics [s]

class Random {
 public:
  explicit Random(unsigned seed) : engine_(seed) {}
  double operator()(double lo, double hi) { return std::uniform_real_distribution<double>(lo, hi)(engine_); }
  Vec3 vector(double size) { return {(*this)(-size, size), (*this)(-size, size), (*this)(-size, size)}; }
  /// Horizontal, of this length.
  Vec3 horizontal(double length) { return length * rotation_z((*this)(-M_PI, M_PI)).col(0); }
  Pose on_the_floor() { return {Vec3((*this)(-2, 2), (*this)(-2, 2), 0.0), rotation_z((*this)(-M_PI, M_PI))}; }

 private:
  std::mt19937_64 engine_;
};

/// Mean and standard deviation of what was added.
class Statistics {
 public:
  void add(double x) {
    sum_ += x;
    squares_ += x * x;
    ++n_;
  }
  [[nodiscard]] int n() const { return n_; }
  [[nodiscard]] double mean() const { return sum_ / n_; }
  [[nodiscard]] double deviation() const { return std::sqrt(squares_ / n_ - mean() * mean()); }

 private:
  double sum_ = 0.0;
  double squares_ = 0.0;
  int n_ = 0;
};

class PlantTest : public testing::TestWithParam<std::string> {
 protected:
  [[nodiscard]] static SimulatedRobot::Parameters with(const Plant& plant) {
    SimulatedRobot::Parameters parameters;
    parameters.plant = plant;
    return parameters;
  }
  [[nodiscard]] SimulatedRobot make(const Plant& plant) const {
    return SimulatedRobot(robot_, world_, home_, period_, with(plant));
  }

  /// Joints at home, no feed-forward: so it stands, a little lower.
  [[nodiscard]] JointTarget hold() const {
    JointTarget target;
    target.q = home_.q.tail(n_);
    target.dq = target.ddq = target.tau = VecX::Zero(n_);
    return target;
  }

  /// A target near home that asks no motor for more than it has, not even with the stiffest servos.
  [[nodiscard]] JointTarget near_home() {
    JointTarget target = hold();
    for (int j = 0; j < n_; ++j) {
      const Joint& joint = robot_.joints()[static_cast<std::size_t>(j)];
      target.q[j] += random_(-0.05, 0.05) * joint.motor.stall / joint.gains.kp;
      target.dq[j] = random_(-0.05, 0.05) * joint.motor.stall / joint.gains.kd;
      target.tau[j] = random_(-0.2, 0.2) * joint.motor.stall;
    }
    return target;
  }

  /// What the motors give in the first step of physics, from rest.
  [[nodiscard]] VecX first_torques(const RobotModel& robot, const Plant& plant, const JointTarget& target) const {
    SimulatedRobot body(robot, world_, home_, kStep, with(plant));
    body.write(target);
    const VecX torques = body.read().torque;
    for (int j = 0; j < n_; ++j) {  // and physics felt them
      const int dof = body.model().jnt_dofadr[mj_name2id(&body.model(), mjOBJ_JOINT, name_of_joint(j).c_str())];
      EXPECT_NEAR(torques[j], body.data().qfrc_actuator[dof], 1e-5 * stall(j)) << name_of_joint(j);
    }
    return torques;
  }

  [[nodiscard]] const std::string& name_of_joint(int j) const {
    return robot_.joints()[static_cast<std::size_t>(j)].name;
  }
  [[nodiscard]] double stall(int j) const { return robot_.joints()[static_cast<std::size_t>(j)].motor.stall; }

  [[nodiscard]] Vec3 momentum(const Truth& truth) {
    kinematics_.set(truth.q);
    JacobianRows jacobian(3, robot_.nv());
    kinematics_.com_jacobian(jacobian);
    return robot_.mass() * (jacobian * truth.dq);
  }

  [[nodiscard]] static Vec3 middle(const Posture& posture) {
    return 0.5 * (posture.sole.left.p + posture.sole.right.p);
  }

  /// Of a geom of a body of the world.
  [[nodiscard]] static Pose pose_of_geom(const SimulatedRobot& body, int geom) {
    return {Eigen::Map<const Vec3>(body.data().geom_xpos + 3 * geom),
            Eigen::Map<const Eigen::Matrix<double, 3, 3, Eigen::RowMajor>>(body.data().geom_xmat + 9 * geom)};
  }

  /// Seen from above, a square of tiled ground.
  struct Tile {
    Vec2 centre;
    double half;
    double top;
    [[nodiscard]] bool under(const Vec2& point) const { return (point - centre).cwiseAbs().maxCoeff() <= half; }
  };
  [[nodiscard]] static std::vector<Tile> tiles_of(const mjModel& m) {
    std::vector<Tile> tiles;
    for (int g = 0; g < m.ngeom; ++g) {
      if (!name_of(m, mjOBJ_GEOM, g).starts_with("ground_tile")) continue;
      const double* at = m.geom_pos + 3 * g;
      const double* half = m.geom_size + 3 * g;
      EXPECT_EQ(half[0], half[1]);
      tiles.push_back({{at[0], at[1]}, half[0], at[2] + half[2]});
    }
    return tiles;
  }
  [[nodiscard]] std::string tiled(const Plant& plant, const Vec3& at) const {
    return with_ground(world_.compose(robot_, kStep), plant, root_, at);
  }

  const RobotModel& robot_ = test::robot(GetParam());
  const World world_ = World::load("flat");
  const double size_ = robot_.profile().stance.com_height;
  const double period_ = robot_.profile().tick.period;
  const double weight_ = robot_.mass() * kGravity;
  const int n_ = robot_.nv() - 6;
  const Posture home_ = stand(robot_, Pose{}, size_);
  const std::string root_ = name_of(robot_.mj(), mjOBJ_BODY, 1);
  Kinematics kinematics_{robot_};
  Random random_{17};
};

INSTANTIATE_TEST_SUITE_P(Robots, PlantTest, testing::ValuesIn(test::robot_names()), test::name_of_param);

TEST(Plant, TheForcesOfPushesAddUpToTheirImpulses) {
  Random random(1);
  for (int trial = 0; trial < 100; ++trial) {
    Plant plant;
    Vec3 impulse = Vec3::Zero();
    double most = 0.0;  // of an impulse that a border of a push can hide
    const double dt = 1e-4;
    for (int k = 0; k < 1 + trial % 5; ++k) {  // they may overlap
      plant.pushes.push_back({random(0.0, 1.0), random(0.01, 0.3), random.vector(3.0)});
      impulse += plant.pushes.back().impulse;
      most += plant.pushes.back().impulse.norm() * dt / plant.pushes.back().duration;
    }
    Vec3 sum = Vec3::Zero();
    for (int k = 0; k < 15000; ++k)
      sum += dt * plant.force((k + 0.5) * dt);
    ASSERT_LT((sum - impulse).norm(), 2.0 * most + 1e-9);
  }
  Plant plant;
  EXPECT_TRUE(plant.force(0.0).isZero(0.0));
  plant.pushes = {{2.0, 0.1, Vec3(1, 0, 0)}};
  for (const double outside : {0.0, 1.9999, 2.1001, 100.0})
    EXPECT_TRUE(plant.force(outside).isZero(0.0));
  for (const double inside : {2.0001, 2.05, 2.0999})
    EXPECT_LT((plant.force(inside) - Vec3(10, 0, 0)).norm(), 1e-9);
}

TEST_P(PlantTest, APushIsThatMuchMomentum) {
  // On ice nothing but the push moves the COM to a side.
  Plant ice;
  ice.friction = 1e-9;
  SimulatedRobot alone = make(ice);
  const double most = 0.1 * robot_.mass() * std::sqrt(kGravity * size_);
  std::vector<Vec3> impulses;
  std::vector<SimulatedRobot> pushed;
  for (int k = 0; k < 4; ++k) {
    impulses.push_back(random_.horizontal(random_(0.3, 1.0) * most));
    Plant plant = ice;
    plant.pushes = {{0.0201, 0.05, impulses.back()}};
    pushed.push_back(make(plant));
  }
  for (int tick = 0; tick * period_ < 0.1; ++tick) {
    alone.write(hold());
    const Vec3 before = momentum(*alone.truth());
    for (std::size_t k = 0; k < pushed.size(); ++k) {
      pushed[k].write(hold());
      const Vec3 gained = momentum(*pushed[k].truth()) - before;
      if (pushed[k].truth()->t < 0.0201) {
        ASSERT_EQ(pushed[k].truth()->q, alone.truth()->q);
      } else if (pushed[k].truth()->t > 0.072) {
        // It may last one step of physics more or less.
        ASSERT_LT((gained - impulses[k]).head<2>().norm(), 0.03 * impulses[k].norm()) << pushed[k].truth()->t;
      }
    }
  }
}

TEST_P(PlantTest, TargetsActAsLateAsTheyAreDelayed) {
  struct Case {
    double period;
    double delay;
    int ticks;  ///< that a target comes later
    bool moving;
  };
  for (const Case& c : {Case{kStep, 0.001, 1, false}, Case{kStep, 0.004, 4, true}, Case{kStep, 0.0025, 3, false},
                        Case{kStep, 0.010, 10, false}, Case{0.005, 0.005, 1, true}, Case{0.005, 0.010, 2, false}}) {
    // The arms are sent here and there.
    std::vector<JointTarget> stream(60, hold());
    for (std::size_t k = 1; k < stream.size(); ++k) {
      stream[k].q = stream[k - 1].q;
      stream[k].dq = stream[k - 1].dq;
      if (k % 7 != 0) continue;
      for (const Side side : kSides) {
        for (const int j : robot_.arm(side)) {
          stream[k].q[j] = home_.q[7 + j] + random_(-0.1, 0.1);
          if (c.moving) stream[k].dq[j] = random_(-1.0, 1.0);
        }
      }
    }
    const auto run = [&](double delay, int later) {
      Plant plant;
      plant.actuators.delay = delay;
      SimulatedRobot body(robot_, world_, home_, c.period, with(plant));
      std::vector<VecX> way;
      for (int k = 0; k < static_cast<int>(stream.size()); ++k) {
        body.write(stream[static_cast<std::size_t>(std::max(0, k - later))]);
        way.push_back(body.truth()->q);
      }
      return way;
    };
    const std::vector<VecX> delayed = run(c.delay, 0);
    const std::vector<VecX> sent_later = run(0.0, c.ticks);
    const std::vector<VecX> sent_sooner = run(0.0, c.ticks - 1);
    double differs = 0.0;
    for (std::size_t k = 0; k < stream.size(); ++k) {
      if (c.moving) {
        ASSERT_LT((delayed[k] - sent_later[k]).norm(), 1e-9) << c.delay << " at " << k;
      } else {
        ASSERT_EQ(delayed[k], sent_later[k]) << c.delay << " at " << k;
      }
      differs = std::max(differs, (delayed[k] - sent_sooner[k]).norm());
    }
    EXPECT_GT(differs, 1e-6) << c.delay;
  }
}

TEST_P(PlantTest, EncodersAreAsNoisyAsTheyShallBe) {
  Plant plant;
  plant.sensors.encoder_noise = random_(0.001, 0.003);
  plant.seed = 5;
  SimulatedRobot body = make(plant);
  Statistics angles;
  Statistics speeds;
  Statistics successive;
  std::vector<Statistics> by_joint(static_cast<std::size_t>(n_));
  VecX before = VecX::Zero(n_);
  for (int tick = 0; tick < 400; ++tick) {
    const Measurement m = body.read();
    const VecX error = m.q - body.truth()->q.tail(n_);
    const VecX speed = m.dq - body.truth()->dq.tail(n_);
    // Speeds are differences of angles.
    ASSERT_LT((speed - (error - before) / period_).norm(), 1e-9);
    for (int j = 0; j < n_; ++j) {
      angles.add(error[j]);
      by_joint[static_cast<std::size_t>(j)].add(error[j]);
      if (tick > 0) {
        speeds.add(speed[j]);
        successive.add(error[j] * before[j]);
      }
    }
    before = error;
    body.write(hold());
  }
  const double noise = plant.sensors.encoder_noise;
  EXPECT_NEAR(angles.deviation(), noise, 0.05 * noise);
  EXPECT_NEAR(angles.mean(), 0.0, 0.06 * noise);
  EXPECT_NEAR(speeds.deviation(), std::sqrt(2.0) * noise / period_, 0.05 * std::sqrt(2.0) * noise / period_);
  EXPECT_NEAR(successive.mean(), 0.0, 0.06 * noise * noise);
  for (const Statistics& joint : by_joint)
    EXPECT_NEAR(joint.deviation(), noise, 0.2 * noise);
  // What the sensors say otherwise is true, and without noise the encoders say it too.
  EXPECT_EQ(body.read().root->velocity, body.truth()->dq.head<3>());
  SimulatedRobot quiet = make({});
  for (int tick = 0; tick < 20; ++tick) {
    quiet.write(hold());
    ASSERT_EQ(quiet.read().q, quiet.truth()->q.tail(n_));
    ASSERT_EQ(quiet.read().dq, quiet.truth()->dq.tail(n_));
  }
}

TEST_P(PlantTest, TheSameSeedGivesTheSameBits) {
  const auto run = [&](std::uint64_t seed) {
    Plant plant;
    plant.sensors.encoder_noise = 0.002;
    plant.sensors.force_noise = 0.05;
    plant.seed = seed;
    SimulatedRobot body = make(plant);
    std::vector<double> all;
    const auto add = [&](const auto& values) { all.insert(all.end(), values.begin(), values.end()); };
    for (int tick = 0; tick < 30; ++tick) {
      body.write(hold());
      const Measurement m = body.read();
      add(body.truth()->q);
      add(m.q);
      add(m.dq);
      add(m.sole.left.force);
      add(m.sole.right.moment);
    }
    return all;
  };
  const std::vector<double> once = run(3);
  EXPECT_EQ(once, run(3));
  EXPECT_NE(once, run(4));
}

TEST_P(PlantTest, ForcesAreAsNoisyAsTheyShallBeAndChangeNothingElse) {
  Plant plant;
  plant.sensors.force_noise = random_(0.02, 0.1);
  SimulatedRobot body = make(plant);
  SimulatedRobot quiet = make({});
  Statistics normal;
  Statistics all;
  for (int tick = 0; tick < 600; ++tick) {
    body.write(hold());
    quiet.write(hold());
    ASSERT_EQ(body.truth()->q, quiet.truth()->q);
    const Measurement m = body.read();
    const Measurement exact = quiet.read();
    ASSERT_EQ(m.q, exact.q);
    for (const Side side : kSides) {
      ASSERT_EQ(body.truth()->sole[side].force, quiet.truth()->sole[side].force);
      for (int axis = 0; axis < 3; ++axis) {
        const double force = exact.sole[side].force[axis];
        const double moment = exact.sole[side].moment[axis];
        if (std::abs(force) > 1e-4 * weight_) all.add(m.sole[side].force[axis] / force - 1.0);
        if (std::abs(moment) > 1e-4 * weight_ * size_) all.add(m.sole[side].moment[axis] / moment - 1.0);
      }
      if (exact.sole[side].force.z() > 0.1 * weight_) {
        normal.add(m.sole[side].force.z() / exact.sole[side].force.z() - 1.0);
      }
    }
  }
  ASSERT_GT(normal.n(), 1000);
  EXPECT_GT(all.n(), normal.n());
  for (const Statistics& ratios : {normal, all}) {
    EXPECT_NEAR(ratios.deviation(), plant.sensors.force_noise, 0.1 * plant.sensors.force_noise);
    EXPECT_NEAR(ratios.mean(), 0.0, 0.15 * plant.sensors.force_noise);
  }
}

TEST_P(PlantTest, TheAttitudeOfTheImuIsOffByItsBias) {
  SimulatedRobot straight = make({});
  Plant plant;
  plant.sensors.imu_bias = random_.vector(0.02);
  SimulatedRobot body = make(plant);
  for (int tick = 0; tick < 60; ++tick) {
    const Measurement m = body.read();
    const Measurement exact = straight.read();
    ASSERT_LT((rotation_error(m.imu.attitude, exact.imu.attitude) - plant.sensors.imu_bias).norm(), 1e-9);
    ASSERT_EQ(m.imu.rate, exact.imu.rate);
    ASSERT_EQ(m.imu.acceleration, exact.imu.acceleration);
    ASSERT_EQ(m.q, exact.q);
    ASSERT_EQ(body.truth()->q, straight.truth()->q);
    const Pose& sensor = *robot_.imu_in_root();
    ASSERT_LT(rotation_error(exact.imu.attitude, exact.root->pose.R * sensor.R).norm(), 0.01);
    body.write(hold());
    straight.write(hold());
  }
}

TEST_P(PlantTest, MotorsGiveTheShareThatTheyHave) {
  for (int trial = 0; trial < 3; ++trial) {
    const JointTarget target = near_home();
    Plant weak;
    weak.actuators.gain = random_(0.5, 0.95);
    const VecX nominal = first_torques(robot_, {}, target);
    EXPECT_GT(nominal.cwiseAbs().minCoeff(), 0.0);
    const VecX less = first_torques(robot_, weak, target);
    for (int j = 0; j < n_; ++j)
      EXPECT_NEAR(less[j], weak.actuators.gain * nominal[j], 1e-9 * stall(j)) << name_of_joint(j);

    // Far away, every motor is at its end.
    JointTarget far = target;
    for (int j = 0; j < n_; ++j)
      far.q[j] += target.q[j] > home_.q[7 + j] ? 3.0 : -3.0;
    Plant small;
    small.actuators.strength = random_(0.5, 0.95);
    const VecX most = first_torques(robot_, small, far);
    for (int j = 0; j < n_; ++j) {
      const double sign = far.q[j] > home_.q[7 + j] ? 1.0 : -1.0;
      EXPECT_NEAR(most[j], sign * small.actuators.strength * stall(j), 1e-9 * stall(j)) << name_of_joint(j);
    }
    // Where no more is asked for than that, it does not matter.
    EXPECT_EQ(first_torques(robot_, small, target), nominal);
  }
}

TEST_P(PlantTest, ServosAreAsStiffAsTheyAre) {
  for (int trial = 0; trial < 3; ++trial) {
    JointTarget target = near_home();
    target.dq.setZero();
    target.tau.setZero();
    Plant plant;
    plant.actuators.kp = random_(0.5, 1.5);
    const VecX nominal = first_torques(robot_, {}, target);
    const VecX other = first_torques(robot_, plant, target);
    for (int j = 0; j < n_; ++j) {
      const Joint& joint = robot_.joints()[static_cast<std::size_t>(j)];
      EXPECT_NEAR(nominal[j], joint.gains.kp * (target.q[j] - home_.q[7 + j]), 1e-9 * stall(j)) << joint.name;
      EXPECT_NEAR(other[j], plant.actuators.kp * nominal[j], 1e-9 * stall(j)) << joint.name;
    }
  }
}

TEST_P(PlantTest, DrivesDifferInWhatTheyMakeOfATorque) {
  const RobotModel torque = with_drive(robot_, Drive::torque);
  const RobotModel pd = with_drive(robot_, Drive::pd);
  const RobotModel stiff = with_drive(robot_, Drive::stiff);
  for (int trial = 0; trial < 3; ++trial) {
    const JointTarget target = near_home();
    JointTarget untold = target;
    untold.tau.setZero();
    Plant soft;
    soft.actuators.kp = random_(0.5, 0.9);
    const VecX by_torque = first_torques(torque, {}, target);
    const VecX by_pd = first_torques(pd, {}, target);
    const VecX rest = first_torques(pd, {}, untold);
    const VecX soft_torque = first_torques(torque, soft, target);
    const VecX soft_pd = first_torques(pd, soft, target);
    for (int j = 0; j < n_; ++j) {
      EXPECT_NEAR(by_torque[j], by_pd[j], 1e-9 * stall(j)) << name_of_joint(j);
      EXPECT_NEAR(by_pd[j] - rest[j], target.tau[j], 1e-9 * stall(j)) << name_of_joint(j);
      // Folded into the angle, it is only as true as the stiffness.
      EXPECT_NEAR(soft_torque[j] - soft_pd[j], (1.0 - soft.actuators.kp) * target.tau[j], 1e-9 * stall(j))
          << name_of_joint(j);
    }
    EXPECT_EQ(first_torques(stiff, {}, target), first_torques(stiff, {}, untold));

    JointTarget still = untold;
    still.dq.setZero();
    const VecX firm = first_torques(stiff, {}, still);
    const VecX usual = first_torques(pd, {}, still);
    for (int j = 0; j < n_; ++j)
      EXPECT_NEAR(firm[j], kStiff * usual[j], 1e-9 * stall(j)) << name_of_joint(j);
  }
}

TEST_P(PlantTest, FrictionAndSoftnessAreTheSoles) {
  Plant plant;
  plant.friction = 0.37;
  plant.solref = 0.0123;
  const SimulatedRobot nominal = make({});
  const SimulatedRobot body = make(plant);
  const mjModel& m = body.model();
  ASSERT_EQ(m.ngeom, nominal.model().ngeom);
  int soles = 0;
  for (int g = 0; g < m.ngeom; ++g) {
    const std::string owner = name_of(m, mjOBJ_BODY, m.geom_bodyid[g]);
    bool sole = m.geom_contype[g] != 0 || m.geom_conaffinity[g] != 0;
    sole = sole && (owner == name_of(robot_.mj(), mjOBJ_BODY, robot_.foot_body(Side::left)) ||
                    owner == name_of(robot_.mj(), mjOBJ_BODY, robot_.foot_body(Side::right)));
    EXPECT_EQ(m.geom_friction[3 * g], sole ? 0.37 : nominal.model().geom_friction[3 * g]);
    EXPECT_EQ(m.geom_solref[2 * g], sole ? 0.0123 : nominal.model().geom_solref[2 * g]);
    soles += sole ? 1 : 0;
  }
  EXPECT_GE(soles, 2);
}

TEST_P(PlantTest, TheGroundIsTurnedAboutTheStartAndTheRobotWithIt) {
  for (int trial = 0; trial < 5; ++trial) {
    Plant plant;
    plant.tilt = random_.horizontal(random_(0.01, 0.1));
    const Mat3 tilt = rotation_exp(plant.tilt);
    const Posture start = stand(robot_, random_.on_the_floor(), size_);
    SimulatedRobot body(robot_, world_, start, period_, with(plant));
    const Pose ground = pose_of_geom(body, find_id(body.model(), mjOBJ_GEOM, "ground_floor", "test"));
    EXPECT_LT((ground.R.col(2) - tilt.col(2)).norm(), 1e-5);
    EXPECT_NEAR(ground.R.col(2).dot(middle(start) - ground.p), 0.0, 1e-4 * size_) << "the start stays";
    // Both soles lie on it, and the robot stands as it was to.
    kinematics_.set(body.truth()->q);
    for (const Side side : kSides) {
      const Pose sole = kinematics_.sole(side);
      EXPECT_NEAR(ground.R.col(2).dot(sole.p - ground.p), 0.0, 1e-4 * size_);
      EXPECT_LT((sole.R.col(2) - ground.R.col(2)).norm(), 1e-4);
      EXPECT_LT((sole.R - tilt * start.sole[side].R).norm(), 1e-4);
    }
    EXPECT_EQ(body.truth()->q.tail(n_), start.q.tail(n_));
    EXPECT_EQ(body.read().q, start.q.tail(n_));
  }
}

TEST_P(PlantTest, EverythingInTheWorldIsTurnedTogether) {
  const World room = World::load("room");
  const Posture start = stand(robot_, room.site("start"), size_);
  Plant plant;
  plant.tilt = random_.vector(0.05);
  const SimulatedRobot level(robot_, room, start, period_);
  const SimulatedRobot body(robot_, room, start, period_, with(plant));
  const mjModel& m = body.model();
  ASSERT_EQ(m.ngeom, level.model().ngeom);
  const Mat3 tilt = rotation_exp(plant.tilt);
  const Pose by{middle(start) - tilt * middle(start), tilt};
  int compared = 0;
  for (int g = 0; g < m.ngeom; ++g) {
    if (m.body_weldid[m.geom_bodyid[g]] != 0) continue;
    const Pose expected = by * pose_of_geom(level, g);
    const Pose found = pose_of_geom(body, g);
    EXPECT_LT((found.p - expected.p).norm(), 1e-5) << name_of(m, mjOBJ_GEOM, g);
    EXPECT_LT((found.R - expected.R).norm(), 1e-5) << name_of(m, mjOBJ_GEOM, g);
    ++compared;
  }
  EXPECT_GT(compared, 5);
}

TEST_P(PlantTest, ItStandsOnTiltedGround) {
  for (int trial = 0; trial < 3; ++trial) {
    Plant plant;
    plant.tilt = random_.horizontal(0.045);
    Simulation simulation(robot_, world_, Simulation::On::sim, {.physics = with(plant)});
    Session& session = simulation.session();
    const Pose ground = pose_of_geom(*simulation.simulated(),
                                     find_id(simulation.simulated()->model(), mjOBJ_GEOM, "ground_floor", "test"));
    while (session.t() < 1.0) {
      session.step({});
      const Truth& truth = simulation.truth();
      kinematics_.set(truth.q);
      for (const Side side : kSides) {
        const Pose sole = kinematics_.sole(side);
        ASSERT_NEAR(ground.R.col(2).dot(sole.p - ground.p), 0.0, 2e-3 * size_) << session.t();
        ASSERT_LT((sole.R.col(2) - ground.R.col(2)).norm(), 5e-3) << session.t();
        ASSERT_LT((sole.p - (middle(home_) + rotation_exp(plant.tilt) * (home_.sole[side].p - middle(home_)))).norm(),
                  5e-3 * size_)
            << "it slides";
      }
      if (session.t() > 0.3) {
        ASSERT_TRUE(truth.touch.left && truth.touch.right) << session.t();
      }
    }
    EXPECT_FALSE(session.fallen()) << session.truth()->fall;
  }
}

TEST_P(PlantTest, TilesAreHigherOrLowerWithinTheirBound) {
  for (int trial = 0; trial < 2; ++trial) {
    Plant plant;
    plant.tiles = random_(0.005, 0.03) * size_;
    plant.seed = static_cast<std::uint64_t>(trial);
    const Vec3 at(random_(-1.0, 1.0), random_(-1.0, 1.0), 0.0);
    const ModelPtr model = compile_text(tiled(plant, at), "tiled");
    const std::vector<Tile> tiles = tiles_of(*model);
    ASSERT_GT(tiles.size(), 1000u);
    Statistics heights;
    double lowest = 0.0;
    double highest = 0.0;
    for (const Tile& tile : tiles) {
      EXPECT_LE(std::abs(tile.top), plant.tiles * (1.0 + 1e-4));
      lowest = std::min(lowest, tile.top);
      highest = std::max(highest, tile.top);
      heights.add(tile.top);
    }
    EXPECT_GT(highest, 0.95 * plant.tiles);
    EXPECT_LT(lowest, -0.95 * plant.tiles);
    EXPECT_NEAR(heights.deviation(), plant.tiles / std::sqrt(3.0), 0.1 * plant.tiles);
    EXPECT_NEAR(heights.mean(), 0.0, 0.1 * plant.tiles);
    // The plane shows nowhere: below them all, and the tiles leave no gap.
    const int floor = find_id(*model, mjOBJ_GEOM, "ground_floor", "test");
    EXPECT_LT(model->geom_pos[3 * floor + 2], lowest);
    for (int point = 0; point < 100; ++point) {
      const Vec2 where = at.head<2>() + Vec2(random_(-1.5, 1.5), random_(-1.5, 1.5));
      const auto under = [&](const Tile& tile) { return tile.under(where); };
      EXPECT_EQ(std::count_if(tiles.begin(), tiles.end(), under), 1) << where.transpose();
    }
    // All the same with the same seed.
    EXPECT_EQ(tiled(plant, at), tiled(plant, at));
    Plant others = plant;
    others.seed += 100;
    EXPECT_NE(tiled(plant, at), tiled(others, at));
  }
  // None are asked for: the text is the same.
  const std::string text = world_.compose(robot_, kStep);
  EXPECT_EQ(with_ground(text, {}, root_, Vec3(1, 2, 0)), text);
}

TEST_P(PlantTest, TilesUnderTheStartAreLevel) {
  Plant plant;
  plant.tiles = 0.015 * size_;
  for (std::uint64_t seed = 0; seed < 3; ++seed) {
    plant.seed = seed;
    const Posture start = stand(robot_, {Vec3(0.7, -0.4, 0.0), Mat3::Identity()}, size_);
    const SimulatedRobot body(robot_, world_, start, period_, with(plant));
    const std::vector<Tile> tiles = tiles_of(body.model());
    for (const Side side : kSides) {
      for (const Vec2& corner : sole_outline(robot_, side, start.sole[side]).vertices()) {
        const auto under = [&](const Tile& tile) { return tile.under(corner); };
        const auto tile = std::find_if(tiles.begin(), tiles.end(), under);
        ASSERT_NE(tile, tiles.end());
        EXPECT_NEAR(tile->top, 0.0, 1e-5 * size_) << "under " << (corner - middle(start).head<2>()).transpose();
      }
      EXPECT_LT(body.truth()->sole[side].force.z(), weight_) << "put down into the ground";
    }
  }
}

TEST_P(PlantTest, OnlyAPlaneCanBeTiled) {
  const World room = World::load("room");
  const Posture start = stand(robot_, room.site("start"), size_);
  Plant plant;
  plant.tiles = 0.01 * size_;
  try {
    const SimulatedRobot body(robot_, room, start, period_, with(plant));
    FAIL() << "no InputError";
  } catch (const InputError& error) {
    EXPECT_THAT(error.what(), HasSubstr("tiles"));
    EXPECT_THAT(error.what(), HasSubstr("one plane"));
  }
  EXPECT_NO_THROW(SimulatedRobot(robot_, world_, home_, period_, with(plant)));
}

}  // namespace
}  // namespace baton
