#include "baton/robot/plant.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>

#include "baton/ik/stand.hpp"
#include "baton/model/error.hpp"
#include "baton/proving/scenario.hpp"
#include "baton/robot/backlash.hpp"
#include "baton/robot/simulated_robot.hpp"
#include "baton/run/simulation.hpp"
#include "tests/support/random.hpp"
#include "tests/support/robots.hpp"

namespace baton {
namespace {

using test::Random;
using testing::HasSubstr;

constexpr double kStep = 0.001;  ///< of physics [s]

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
    return with_plant(world_.compose(robot_, kStep), plant, robot_, at);
  }

  const RobotModel& robot_ = test::robot(GetParam());
  const World world_ = World::load("flat");
  const double size_ = robot_.profile().stance.com_height;
  const double period_ = robot_.profile().tick.period;
  const double weight_ = robot_.mass() * kGravity;
  const int n_ = robot_.nv() - 6;
  const Posture home_ = stand(robot_, Pose{}, size_);
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
    impulses.push_back(random_(0.3, 1.0) * most * random_.direction());
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

TEST_P(PlantTest, AForceOnAHandActsThere) {
  const auto applied = [](const SimulatedRobot& body, int id) {
    return Vec6(Eigen::Map<const Vec6>(body.data().xfrc_applied + 6 * id));
  };
  kinematics_.set(home_.q);
  for (int trial = 0; trial < 20; ++trial) {
    const Side side = trial % 2 == 0 ? Side::left : Side::right;
    const Vec3 force = 0.1 * weight_ * random_.direction();
    Plant plant;
    plant.pushes = {{0.0, 2.0, 2.0 * force, side}};
    EXPECT_TRUE(plant.force(1.0).isZero(0.0)) << "not on the trunk";
    EXPECT_TRUE(plant.force(1.0, other(side)).isZero(0.0));
    SimulatedRobot body(robot_, world_, home_, kStep, with(plant));
    body.write(hold());
    for (int b = 0; b < body.model().nbody; ++b) {
      const bool pulled =
          name_of(body.model(), mjOBJ_BODY, b) == name_of(robot_.mj(), mjOBJ_BODY, robot_.hand_body(side));
      const Vec6 wrench = applied(body, b);
      ASSERT_LT((wrench.head<3>() - (pulled ? force : Vec3(Vec3::Zero()))).norm(), 1e-12 * weight_);
      const Eigen::Map<const Vec3> centre(body.data().xipos + 3 * b);
      const Vec3 at_hand = wrench.tail<3>() + (centre - kinematics_.hand(side).p).cross(wrench.head<3>());
      ASSERT_LT(at_hand.norm(), 1e-4 * force.norm() * size_) << "a moment about the hand";
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
    const VecX by_stiff = first_torques(stiff, {}, target);
    const VecX stiff_rest = first_torques(stiff, {}, untold);
    for (int j = 0; j < n_; ++j)
      EXPECT_NEAR(by_stiff[j] - stiff_rest[j], target.tau[j], 1e-9 * stall(j)) << name_of_joint(j);

    JointTarget still = untold;
    still.dq.setZero();
    const VecX firm = first_torques(stiff, {}, still);
    const VecX usual = first_torques(pd, {}, still);
    for (int j = 0; j < n_; ++j)
      EXPECT_NEAR(firm[j], kStiff * usual[j], 1e-9 * stall(j)) << name_of_joint(j);
  }
}

TEST_P(PlantTest, StiffServosThatLagStandStill) {
  const RobotModel stiff = with_drive(robot_, Drive::stiff);
  Simulation::Parameters parameters;
  parameters.physics.plant.actuators = {
      .held_targets = true, .differenced_speeds = true, .lag = stiff.profile().actuators.lag};
  Simulation simulation(stiff, world_, Simulation::On::sim, parameters);
  const double weight = stiff.mass() * kGravity;
  while (simulation.session().t() < 4.0) {
    simulation.session().step(Command{});
    if (simulation.session().t() < 2.0) continue;
    const Measurement m = simulation.simulated()->read();
    for (const Side side : kSides)
      ASSERT_NEAR(m.sole[side].force.z(), 0.5 * weight, 0.2 * weight) << simulation.session().t();
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
    plant.tilt = random_(0.01, 0.1) * random_.direction();
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
    plant.tilt = 0.045 * random_.direction();
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
        ASSERT_LT((sole.R.col(2) - ground.R.col(2)).norm(), 7e-3) << session.t();
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
  EXPECT_EQ(with_plant(text, {}, robot_, Vec3(1, 2, 0)), text);
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

TEST_P(PlantTest, MeasurementsAreAsOldAsTheyAre) {
  for (const double delay : {0.0, 0.003, 0.005, 0.012, 0.02}) {
    for (const double jitter : {0.0, 0.002, 0.011}) {
      Plant plant;
      plant.sensors.delay = delay;
      plant.sensors.jitter = jitter;
      plant.seed = 3;
      SimulatedRobot late = make(plant);
      SimulatedRobot fine(robot_, world_, home_, kStep, {});  // read after each step of physics
      std::vector<Measurement> at{fine.read()};               // by that step
      const auto steps = static_cast<int>(std::lround(period_ / kStep));
      double oldest = 0.0;
      double newest = 1.0;
      double before = 0.0;
      for (int tick = 0; tick < 60; ++tick) {
        const Measurement m = late.read();
        ASSERT_GE(m.t, before);
        before = m.t;
        const double now = tick * period_;
        ASSERT_EQ(late.truth()->t, at.back().t) << "the truth is never late";
        if (now > delay + jitter) {
          oldest = std::max(oldest, now - m.t);
          newest = std::min(newest, now - m.t);
        }
        const Measurement& then = at[static_cast<std::size_t>(std::lround(m.t / kStep))];
        ASSERT_EQ(m.q, then.q) << tick;
        ASSERT_EQ(m.imu.attitude, then.imu.attitude) << tick;
        ASSERT_LT((m.sole.left.force - then.sole.left.force).norm(), 1e-9);
        late.write(hold());
        for (int step = 0; step < steps; ++step) {
          fine.write(hold());
          at.push_back(fine.read());
        }
      }
      EXPECT_GE(newest, delay - 0.51 * kStep);
      EXPECT_LE(oldest, delay + jitter + 0.51 * kStep);
      if (jitter > 2.0 * kStep) {
        EXPECT_GT(oldest, newest + 0.3 * jitter);
      } else if (jitter == 0.0) {
        EXPECT_NEAR(oldest, newest, 1e-9);
      }
      late.reset();
      EXPECT_EQ(late.read().t, 0.0);
      EXPECT_EQ(late.read().q, at.front().q);
    }
  }
}

TEST_P(PlantTest, EncodersHaveZeroErrorsAndSteps) {
  Plant plant;
  plant.sensors.encoder_offset = 0.02;
  plant.sensors.encoder_step = 0.001;
  plant.sensors.differenced_speeds = true;
  Statistics offsets;
  for (plant.seed = 0; plant.seed < 10; ++plant.seed) {
    SimulatedRobot body = make(plant);
    const VecX first = body.read().q - body.truth()->q.tail(n_);
    VecX before = body.read().q;
    EXPECT_EQ(body.read().dq, VecX::Zero(n_));
    for (int tick = 0; tick < 20; ++tick) {
      body.write(hold());
      const Measurement m = body.read();
      for (int j = 0; j < n_; ++j) {
        const double steps = m.q[j] / plant.sensors.encoder_step;
        ASSERT_NEAR(steps, std::round(steps), 1e-6);
        ASSERT_NEAR(m.q[j] - body.truth()->q[7 + j], first[j], plant.sensors.encoder_step);
        ASSERT_NEAR(m.dq[j], (m.q[j] - before[j]) / period_, 1e-9);
      }
      before = m.q;
    }
    for (const double offset : first) {
      ASSERT_LT(std::abs(offset), plant.sensors.encoder_offset + plant.sensors.encoder_step);
      offsets.add(offset);
    }
  }
  EXPECT_NEAR(offsets.deviation(), plant.sensors.encoder_offset / std::sqrt(3.0), 0.15 * plant.sensors.encoder_offset);
}

TEST_P(PlantTest, TheImuErrsAsItShall) {
  SimulatedRobot straight = make({});
  Plant plant;
  plant.sensors.imu_mount = 0.02;
  SimulatedRobot askew = make(plant);
  plant = {};
  plant.sensors.yaw_drift = 0.05;
  SimulatedRobot drifts = make(plant);
  plant = {};
  plant.sensors.gyro_noise = 0.03;
  plant.sensors.accelerometer_noise = 0.2;
  SimulatedRobot noisy = make(plant);
  Statistics gyro;
  Statistics accelerometer;
  for (int tick = 0; tick < 200; ++tick) {
    const Measurement::Imu exact = straight.read().imu;
    // A sensor that is mounted askew turns all of its readings.
    const Measurement::Imu tilted = askew.read().imu;
    const Mat3 mount = exact.attitude.transpose() * tilted.attitude;
    EXPECT_NEAR(rotation_error(mount, Mat3::Identity()).norm(), 0.02, 1e-9);
    EXPECT_NEAR(rotation_error(mount, Mat3::Identity()).z(), 0.0, 1e-9);
    EXPECT_LT((mount * tilted.rate - exact.rate).norm(), 1e-9);
    EXPECT_LT((mount * tilted.acceleration - exact.acceleration).norm(), 1e-9);
    // Yaw drifts, and the gyro agrees.
    const Measurement drifting = drifts.read();
    const Vec3 turned = rotation_error(drifting.imu.attitude, exact.attitude);
    EXPECT_LT(turned.head<2>().norm(), 1e-6);
    EXPECT_NEAR(std::abs(turned.z()), 0.05 * drifting.t, 1e-6);
    EXPECT_NEAR((exact.attitude * (drifting.imu.rate - exact.rate)).z() * drifting.t, turned.z(), 1e-6);
    const Measurement::Imu noise = noisy.read().imu;
    EXPECT_EQ(noise.attitude, exact.attitude);
    for (int axis = 0; axis < 3; ++axis) {
      gyro.add(noise.rate[axis] - exact.rate[axis]);
      accelerometer.add(noise.acceleration[axis] - exact.acceleration[axis]);
    }
    for (SimulatedRobot* body : {&straight, &askew, &drifts, &noisy})
      body->write(hold());
  }
  EXPECT_NEAR(gyro.deviation(), 0.03, 0.003);
  EXPECT_NEAR(accelerometer.deviation(), 0.2, 0.02);
}

TEST(Sensors, AttitudesWanderSlowlyAndAsFarAsTheyShall) {
  constexpr double sigma = 0.03;
  constexpr double period = 0.005;
  Statistics all;
  double fastest = 0.0;
  for (std::uint64_t seed = 0; seed < 20; ++seed) {
    Sensors sensors({.imu_wander = sigma}, 0, period, 50.0, seed);
    Vec3 before = Vec3::Zero();
    for (int tick = 0; tick < 20000; ++tick) {
      Measurement m;
      m.t = tick * period;
      sensors.disturb(m);
      const Vec3 error = rotation_error(m.imu.attitude, Mat3::Identity());
      EXPECT_NEAR(error.z(), 0.0, 1e-12);
      all.add(error.x());
      all.add(error.y());
      if (tick > 0) fastest = std::max(fastest, (error - before).norm() / period);
      before = error;
    }
  }
  EXPECT_NEAR(all.deviation(), sigma, 0.1 * sigma);
  EXPECT_NEAR(all.mean(), 0.0, 0.1 * sigma);
  EXPECT_LT(fastest, 2.0 * M_PI / 4.0 * 4.0 * sigma) << "within seconds, not at once";
}

TEST(Sensors, ForcesHaveZeroAndGainErrors) {
  Statistics zeros;
  Statistics gains;
  for (std::uint64_t seed = 0; seed < 300; ++seed) {
    Sensors sensors({.force_gain = 0.04, .force_zero = 0.1}, 0, 0.005, 50.0, seed);
    Measurement empty;
    Measurement loaded;
    for (const Side side : kSides)
      loaded.sole[side] = {Vec3(1, 2, 30), Vec3(0.1, 0.2, 0.3)};
    sensors.disturb(empty);
    sensors.disturb(loaded);
    for (const Side side : kSides) {
      const Vec3 zero = empty.sole[side].force;
      EXPECT_LE(std::abs(zero.z()), 5.0);
      EXPECT_LE(zero.head<2>().cwiseAbs().maxCoeff(), 0.5);
      EXPECT_TRUE(empty.sole[side].moment.isZero(0.0));
      const double gain = (loaded.sole[side].force.z() - zero.z()) / 30.0;
      EXPECT_NEAR(gain, 1.0, 0.04);
      EXPECT_NEAR(loaded.sole[side].moment.y(), 0.2 * gain, 1e-12);
      zeros.add(zero.z());
      gains.add(gain);
    }
  }
  EXPECT_NEAR(zeros.deviation(), 5.0 / std::sqrt(3.0), 0.3);
  EXPECT_NEAR(gains.deviation(), 0.04 / std::sqrt(3.0), 0.002);
}

TEST(Backlash, AMotorCrossesThePlayBeforeItDrives) {
  constexpr double inertia = 0.01;
  constexpr double dt = 0.001;
  for (const double play : {0.001, 0.01, 0.05}) {
    for (const double torque : {0.1, -0.4, 2.0}) {
      Backlash backlash(play, inertia);
      EXPECT_EQ(backlash.angle(), 0.0);
      for (double way : {play, 2.0 * play}) {  // from the middle, then back from one end to the other
        const double sign = way == play ? 1.0 : -1.0;
        double waited = 0.0;
        while (backlash.transmit(sign * torque, dt) == 0.0) {
          EXPECT_LE(std::abs(backlash.angle()), play);
          waited += dt;
          ASSERT_LT(waited, 1.0);
        }
        EXPECT_NEAR(waited, std::sqrt(2.0 * way * inertia / std::abs(torque)), 2.0 * dt);
        EXPECT_EQ(backlash.angle(), sign * std::copysign(play, torque));
        EXPECT_EQ(backlash.speed(), 0.0);
        EXPECT_EQ(backlash.transmit(sign * 0.5 * torque, dt), sign * 0.5 * torque);
      }
    }
  }
  Backlash none(0.0, inertia);
  for (const double torque : {1.0, -1.0, 0.0, 0.5})
    EXPECT_EQ(none.transmit(torque, dt), torque);
}

TEST_P(PlantTest, EncodersAreOnTheMotorsSideOfThePlay) {
  Plant plant;
  plant.actuators.backlash = 0.01;
  SimulatedRobot body = make(plant);
  VecX farthest = VecX::Zero(n_);
  for (int tick = 0; tick < 40; ++tick) {
    body.write(hold());
    const VecX beyond = body.read().q - body.truth()->q.tail(n_);
    ASSERT_LE(beyond.cwiseAbs().maxCoeff(), 0.01 + 1e-12);
    farthest = farthest.cwiseMax(beyond.cwiseAbs());
  }
  EXPECT_GT((farthest.array() > 0.01 - 1e-12).count(), n_ / 3) << "gravity takes it up in many joints";
}

TEST_P(PlantTest, ServosErrAsTheyShall) {
  const auto torques = [&](const ActuatorErrors& errors, const JointTarget& target, int steps) {
    Plant plant;
    plant.actuators = errors;
    SimulatedRobot body(robot_, world_, home_, kStep, with(plant));
    std::vector<VecX> way;
    for (int k = 0; k < steps; ++k) {
      body.write(k == 0 ? hold() : target);
      way.push_back(body.read().torque);
    }
    return way;
  };
  JointTarget jump = hold();
  for (int j = 0; j < n_; ++j)
    jump.q[j] += 1e-4 * stall(j) / robot_.joints()[static_cast<std::size_t>(j)].gains.kp;
  // The torque follows with its time constant.
  const std::vector<VecX> prompt = torques({}, jump, 2);
  const std::vector<VecX> lagging = torques({.lag = 0.004}, jump, 2);
  const double share = 1.0 - std::exp(-kStep / 0.004);
  ASSERT_LT((lagging[0] - prompt[0]).norm(), 1e-9);
  EXPECT_LT((lagging[1] - lagging[0] - share * (prompt[1] - prompt[0])).norm(), 1e-3 * (prompt[1] - prompt[0]).norm());
  // A held target is at the end of its tick from the beginning.
  JointTarget moving = hold();
  moving.dq.setConstant(0.1);
  const auto first = [&](bool held) {
    Plant plant;
    plant.actuators.held_targets = held;
    SimulatedRobot body(robot_, world_, home_, 0.005, with(plant));
    body.write(moving);
    return body.read().torque;
  };
  const VecX difference = first(true) - first(false);
  EXPECT_GT(difference.minCoeff(), 0.0);
}

TEST_P(PlantTest, DryFrictionHoldsAJointAndPayloadsAndMatsAreInTheModel) {
  Plant plant;
  plant.actuators.friction = 0.07;
  plant.payload = {0.04 * robot_.mass(), 0.0};
  plant.mass = 1.1;
  plant.com_offset = Vec3(0.01, 0.0, 0.0) * size_;
  const SimulatedRobot body = make(plant);
  const mjModel& m = body.model();
  // The very model that is stepped can be written and read.
  const ModelPtr read = compile_text(body.model_text(), "saved");
  ASSERT_EQ(read->nbody, m.nbody);
  for (int b = 0; b < m.nbody; ++b) {
    EXPECT_EQ(read->body_mass[b], m.body_mass[b]);
    for (int axis = 0; axis < 3; ++axis) {
      EXPECT_EQ(read->body_inertia[3 * b + axis], m.body_inertia[3 * b + axis]);
      EXPECT_EQ(read->body_ipos[3 * b + axis], m.body_ipos[3 * b + axis]);
    }
  }
  const int root = find_id(m, mjOBJ_BODY, name_of(robot_.mj(), mjOBJ_BODY, 1), "test");
  EXPECT_NEAR(m.body_subtreemass[root], 1.1 * 1.04 * robot_.mass(), 1e-4 * robot_.mass());
  EXPECT_NEAR(m.body_ipos[3 * root], robot_.mj().body_ipos[3] + 0.01 * size_, 1e-5 * size_);
  for (int j = 0; j < n_; ++j) {
    const int dof = m.jnt_dofadr[find_id(m, mjOBJ_JOINT, name_of_joint(j), "test")];
    EXPECT_NEAR(m.dof_frictionloss[dof], 0.07 * stall(j), 1e-4 * stall(j));
  }
}

TEST_P(PlantTest, AStandingRobotSinksIntoAMatAsDeepAsItShall) {
  const auto height = [&](const Plant& plant) {
    Simulation simulation(robot_, world_, Simulation::On::sim, {.physics = with(plant)});
    Session& session = simulation.session();
    while (session.t() < 2.0)
      session.step({});
    EXPECT_FALSE(session.fallen());
    kinematics_.set(session.truth()->q);
    return 0.5 * (kinematics_.sole(Side::left).p.z() + kinematics_.sole(Side::right).p.z());
  };
  const double firm = height({});
  for (const double depth : {0.005, 0.012}) {
    Plant plant;
    plant.mat = depth * size_;
    EXPECT_NEAR(firm - height(plant), plant.mat, 0.3 * plant.mat);
  }
}

TEST_P(PlantTest, ACompliantHipYieldsByItsLoad) {
  Plant plant;
  plant.actuators.hip_compliance = 0.1;
  const SimulatedRobot body = make(plant);
  const mjModel& m = body.model();
  ASSERT_EQ(m.nv, make({}).model().nv + 2);
  SimulatedRobot standing = make(plant);
  for (int tick = 0; tick * period_ < 0.3; ++tick)
    standing.write(hold());
  for (int j = 0; j < n_; ++j) {
    const int spring = mj_name2id(&m, mjOBJ_JOINT, flexible(name_of_joint(j)).c_str());
    const double beyond = standing.truth()->q[7 + j] - standing.read().q[j];
    if (spring < 0) {
      EXPECT_EQ(beyond, 0.0) << "no other joint yields";
      continue;
    }
    EXPECT_NEAR(beyond, standing.data().qpos[m.jnt_qposadr[spring]], 1e-12);
    EXPECT_GT(std::abs(beyond), 1e-5);
    // The load is what the motor gives.
    const double load = standing.read().torque[j] / (weight_ * size_);
    EXPECT_NEAR(beyond, -0.1 * load, 0.1 * std::abs(0.1 * load) + 1e-6);
  }
}

}  // namespace
}  // namespace baton
