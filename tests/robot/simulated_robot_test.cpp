#include "baton/robot/simulated_robot.hpp"
#include "tests/support/temp.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <fstream>
#include <sstream>

#include "baton/ik/stand.hpp"
#include "baton/model/error.hpp"
#include "baton/run/simulation.hpp"
#include "tests/support/robots.hpp"

namespace baton {
namespace {

using testing::HasSubstr;

class SimulatedRobotTest : public testing::TestWithParam<std::string> {
 protected:
  /// A stick that guides one part after the other, this way and that.
  class Stick {
   public:
    explicit Stick(unsigned seed) : random_(seed) {}
    const Command& at(double t) {
      if (t >= until_) {
        std::uniform_real_distribution<double> uniform(-1.0, 1.0);
        command_.guide = kParts[random_() % kParts.size()];
        for (double& axis : command_.axes)
          axis = uniform(random_);
        until_ = t + 1.0;
      }
      return command_;
    }

   private:
    std::mt19937_64 random_;
    Command command_;
    double until_ = 0.0;
  };

  [[nodiscard]] SimulatedRobot make(const Posture& start, SimulatedRobot::Parameters parameters = {}) const {
    return SimulatedRobot(robot_, world_, start, period_, parameters);
  }

  /// Home, moved and turned as a whole.
  [[nodiscard]] Posture home_moved(const Pose& by) const {
    Posture posture = home_;
    const Eigen::Quaterniond q(home_.q[3], home_.q[4], home_.q[5], home_.q[6]);
    const Pose root = by * Pose{home_.q.head<3>(), q.toRotationMatrix()};
    const Eigen::Quaterniond attitude(root.R);
    posture.q.head<3>() = root.p;
    posture.q.segment<4>(3) << attitude.w(), attitude.x(), attitude.y(), attitude.z();
    return posture;
  }

  /// Joints at home, no feed-forward.
  [[nodiscard]] JointTarget stiff() const {
    const VecX zero = VecX::Zero(robot_.nv() - 6);
    return {home_.q.tail(robot_.nv() - 6), zero, zero, zero, {true, true}, zero};
  }

  [[nodiscard]] Vec2 zmp(const Truth& truth) const {
    return Wrench{truth.sole.left.force + truth.sole.right.force, truth.sole.left.moment + truth.sole.right.moment}.zmp(
        0.0);
  }

  const RobotModel& robot_ = test::robot(GetParam());
  const World world_ = World::load("flat");
  const double size_ = robot_.profile().stance.com_height;
  const double period_ = robot_.profile().tick.period;
  const Posture home_ = stand(robot_, Pose{}, size_);
  Kinematics kinematics_{robot_};
};

INSTANTIATE_TEST_SUITE_P(Robots, SimulatedRobotTest, testing::ValuesIn(test::robot_names()), test::name_of_param);

TEST_P(SimulatedRobotTest, IsHeldByNothingButTheGround) {
  Simulation simulation(robot_, world_, Simulation::On::sim);
  Session& session = simulation.session();
  const SimulatedRobot& body = *simulation.simulated();
  const mjModel& m = body.model();
  EXPECT_EQ(m.neq, 0);
  EXPECT_EQ(m.nmocap, 0);
  EXPECT_EQ(m.ntendon, 0);
  EXPECT_EQ(m.nflex, 0);
  EXPECT_TRUE(m.opt.disableflags & mjDSBL_AUTORESET);
  EXPECT_EQ(m.opt.disableflags & ~(mjDSBL_AUTORESET | mjDSBL_SENSOR | mjDSBL_ISLAND), 0);
  EXPECT_LE(m.opt.timestep, 0.002);
  for (int b = 0; b < m.nbody; ++b)
    EXPECT_EQ(m.body_gravcomp[b], 0.0);
  for (int a = 0; a < m.nu; ++a)
    EXPECT_EQ(m.actuator_biastype[a], mjBIAS_NONE);
  EXPECT_EQ(m.nu, static_cast<int>(robot_.joints().size()));
  const int warnings = mujoco_warnings();
  Stick stick(41);
  double t = 0.0;
  while (session.t() < 7.0) {
    session.step(stick.at(session.t()));
    const mjData& d = body.data();
    for (int i = 0; i < m.nv; ++i)
      ASSERT_EQ(d.qfrc_applied[i], 0.0);
    for (int i = 0; i < 6 * m.nbody; ++i)
      ASSERT_EQ(d.xfrc_applied[i], 0.0);
    for (int i = 0; i < 6; ++i) {  // nothing pulls at the trunk
      ASSERT_EQ(d.qfrc_actuator[i], 0.0);
      ASSERT_EQ(d.qfrc_passive[i], 0.0);
    }
    for (std::size_t j = 0; j < robot_.joints().size(); ++j) {
      const Joint& joint = robot_.joints()[j];
      const int dof = m.jnt_dofadr[mj_name2id(&m, mjOBJ_JOINT, joint.name.c_str())];
      ASSERT_LE(std::abs(d.qfrc_actuator[dof]), joint.motor.stall * (1.0 + 1e-9)) << joint.name;
    }
    ASSERT_GT(body.truth()->t, t);
    t = body.truth()->t;
  }
  EXPECT_FALSE(session.fallen()) << session.truth()->fall;
  EXPECT_GT(session.navigator().committed(), 4);
  EXPECT_NEAR(t, session.t(), 1e-9);
  EXPECT_EQ(mujoco_warnings(), warnings);
  for (int i = 0; i < mjNWARNING; ++i)
    EXPECT_EQ(body.data().warning[i].number, 0);
}

TEST_P(SimulatedRobotTest, StepsTheModelThatItShows) {
  const SimulatedRobot body = make(home_);
  const ModelPtr shown = compile_text(body.model_text(), "shown");
  ASSERT_EQ(shown->nq, body.model().nq);
  for (int b = 0; b < shown->nbody; ++b)
    EXPECT_EQ(shown->body_mass[b], body.model().body_mass[b]);
  int stepped = 0;
  for (int g = 0; g < shown->ngeom; ++g) {
    if (shown->geom_contype[g] == 0 && shown->geom_conaffinity[g] == 0) continue;  // only drawn
    ASSERT_LT(stepped, body.model().ngeom);
    for (int i = 0; i < 3; ++i)
      EXPECT_EQ(shown->geom_size[3 * g + i], body.model().geom_size[3 * stepped + i]);
    ++stepped;
  }
  EXPECT_EQ(stepped, body.model().ngeom);
  EXPECT_EQ(shown->opt.timestep, body.model().opt.timestep);
}

TEST_P(SimulatedRobotTest, NamesJointsAsTheModelDoes) {
  SimulatedRobot body = make(home_);
  body.write(stiff());
  const VecX q = body.read().q;
  for (std::size_t j = 0; j < robot_.joints().size(); ++j) {
    const int id = mj_name2id(&body.model(), mjOBJ_JOINT, robot_.joints()[j].name.c_str());
    EXPECT_EQ(q[static_cast<Eigen::Index>(j)], body.data().qpos[body.model().jnt_qposadr[id]]);
  }
}

TEST_P(SimulatedRobotTest, AsksNoMoreOfAMotorThanItCan) {
  SimulatedRobot body = make(home_);
  JointTarget target = stiff();
  for (const Side side : kSides) {
    for (const int j : robot_.arm(side))
      target.q[j] += 3.0;
  }
  bool saturated = false;
  for (int tick = 0; tick < 20; ++tick) {
    body.write(target);
    for (std::size_t j = 0; j < robot_.joints().size(); ++j) {
      const Joint& joint = robot_.joints()[j];
      const int dof = body.model().jnt_dofadr[mj_name2id(&body.model(), mjOBJ_JOINT, joint.name.c_str())];
      const double torque = std::abs(body.data().qfrc_actuator[dof]);
      ASSERT_LE(torque, joint.motor.stall * (1.0 + 1e-9)) << joint.name;
      saturated = saturated || torque > 0.999 * joint.motor.stall;
    }
  }
  EXPECT_TRUE(saturated);
}

TEST_P(SimulatedRobotTest, StandsWithTheZmpBelowTheCom) {
  Simulation simulation(robot_, world_, Simulation::On::sim);
  Session& session = simulation.session();
  while (session.t() < 2.0) {
    session.step({});
    if (session.t() < 0.3) continue;
    const Truth& truth = simulation.truth();
    ASSERT_TRUE(truth.touch.left && truth.touch.right) << session.t();
    kinematics_.set(truth.q);
    ASSERT_LT((zmp(truth) - kinematics_.com().head<2>()).norm(), 0.02 * size_) << session.t();
  }
  EXPECT_FALSE(session.fallen()) << session.truth()->fall;
}

TEST_P(SimulatedRobotTest, AHardPushMakesAFallThatIsNoticedAndStays) {
  for (const Vec3& direction : {Vec3(1, 0, 0), Vec3(0, 1, 0), Vec3(-0.7, -0.7, 0)}) {
    Simulation simulation(robot_, world_, Simulation::On::sim);
    Session& session = simulation.session();
    while (session.t() < 0.5)
      session.step({});
    ASSERT_FALSE(session.fallen());
    simulation.simulated()->push(robot_.mass() * 0.8 * std::sqrt(kGravity * size_) * direction);
    double fell = 0.0;
    std::string why;
    Stick stick(42);
    while (session.t() < 3.0) {
      session.step(stick.at(session.t()));
      if (session.fallen() && why.empty()) {
        fell = session.t();
        why = session.truth()->fall;
      }
      if (!why.empty()) {
        ASSERT_TRUE(session.fallen());
        ASSERT_EQ(session.truth()->fall, why);
      }
      ASSERT_NEAR(session.truth()->t, session.t(), 1e-9);
      ASSERT_TRUE(session.truth()->q.allFinite());
    }
    EXPECT_GT(fell, 0.5);
    EXPECT_LT(fell, 2.5);
    EXPECT_FALSE(why.empty());
    EXPECT_EQ(session.navigator().phase(), Phase::fallen);
    EXPECT_EQ(session.navigator().motion(), nullptr);
    kinematics_.set(session.truth()->q);  // it lies where it fell
    EXPECT_LT(kinematics_.com().z(), 0.7 * size_);
  }
}

TEST_P(SimulatedRobotTest, ALightPushDoesNot) {
  for (const Vec3& direction : {Vec3(1, 0, 0), Vec3(0, -1, 0)}) {
    Simulation simulation(robot_, world_, Simulation::On::sim);
    Session& session = simulation.session();
    while (session.t() < 0.5)
      session.step({});
    simulation.simulated()->push(robot_.mass() * 0.03 * std::sqrt(kGravity * size_) * direction);
    while (session.t() < 2.5)
      session.step({});
    EXPECT_FALSE(session.fallen()) << session.truth()->fall;
  }
}

TEST_P(SimulatedRobotTest, KnowsEveryKindOfFall) {
  const Vec3 up(0, 0, 4.0 * size_);  // in the air nothing touches
  for (const double tilt : {-50.0, -40.0, 40.0, 50.0}) {
    for (const Vec3& axis : {Vec3(1, 0, 0), Vec3(0, 1, 0)}) {
      SimulatedRobot body = make(home_moved({up, rotation_exp(tilt * M_PI / 180.0 * axis)}));
      EXPECT_FALSE(body.truth()->fallen);
      body.write(stiff());
      EXPECT_EQ(body.truth()->fallen, std::abs(tilt) > 45.0);
      EXPECT_THAT(body.truth()->fall, HasSubstr(body.truth()->fallen ? "tilt" : ""));
    }
  }
  for (const double share : {0.45, 0.55}) {  // of a nominal COM height that is another robot's
    SimulatedRobot::Parameters parameters;
    parameters.nominal_com_height = size_ / share;
    SimulatedRobot body = make(home_moved({up, Mat3::Identity()}), parameters);
    body.write(stiff());
    EXPECT_EQ(body.truth()->fallen, share < 0.5);
    EXPECT_THAT(body.truth()->fall, HasSubstr(body.truth()->fallen ? "COM" : ""));
  }
  {  // kneeling: something that is no sole touches the ground, upright as it may be
    SimulatedRobot body = make(home_moved({Vec3(0, 0, -0.6 * size_), Mat3::Identity()}));
    body.write(stiff());
    EXPECT_TRUE(body.truth()->fallen);
    EXPECT_THAT(body.truth()->fall, HasSubstr("touches ground_floor"));
  }
  {  // a broken target is noticed as a failure, not hidden by a reset
    SimulatedRobot body = make(home_);
    for (int tick = 0; tick < 20; ++tick)
      body.write(stiff());
    const double t = body.truth()->t;
    JointTarget broken = stiff();
    broken.q[0] = std::numeric_limits<double>::quiet_NaN();
    body.write(broken);
    EXPECT_TRUE(body.truth()->fallen);
    EXPECT_THAT(body.truth()->fall, HasSubstr("warning"));
    EXPECT_GT(body.truth()->t, t);
  }
}

/// How far a run strays from its plan.
struct Recording {
  std::vector<Vec3> com;
  std::vector<Vec2> zmp;
  double com_error = 0.0;
  double zmp_error = 0.0;
  double load = 0.0;  ///< largest normal force of both soles at rest
};

TEST_P(SimulatedRobotTest, APlantThatIsNotTheModelIsMeasuredAsItIs) {
  const auto run = [&](const Plant& plant) {
    SimulatedRobot::Parameters parameters;
    parameters.plant = plant;
    Simulation simulation(robot_, world_, Simulation::On::sim, {.physics = parameters});
    Session& session = simulation.session();
    Recording result;
    Hooks hooks;
    session.add(hooks);
    hooks.tick = [&](const TickRecord& record) {
      if (session.t() < 1.0) return;
      const MotionSample& planned = record.navigator.sample();
      const Pose& anchor = record.navigator.anchor();
      kinematics_.set(record.truth->q);
      result.com.push_back(kinematics_.com());
      result.zmp.push_back(zmp(*record.truth));
      const Vec2 com = (anchor * planned.com).head<2>();
      const Vec2 planned_zmp = (anchor * Vec3(planned.zmp.x(), planned.zmp.y(), planned.zmp_height)).head<2>();
      result.com_error = std::max(result.com_error, (result.com.back().head<2>() - com).norm());
      result.zmp_error = std::max(result.zmp_error, (result.zmp.back() - planned_zmp).norm());
    };
    while (session.t() < 3.5) {
      Command command;
      if (session.t() > 1.0) command.axes[0] = 1.0;
      session.step(command);
      if (session.t() < 1.0) {
        result.load = session.truth()->sole.left.force.z() + session.truth()->sole.right.force.z();
      }
    }
    EXPECT_FALSE(session.fallen()) << session.truth()->fall;
    return result;
  };
  const Recording nominal = run({});
  EXPECT_NEAR(nominal.load, robot_.mass() * kGravity, 0.02 * robot_.mass() * kGravity);
  // A real body, though the model is exact, is not quite where the plan says.
  EXPECT_GT(nominal.com_error, 1e-4 * size_);
  EXPECT_GT(nominal.zmp_error, 1e-3 * size_);
  Plant heavy;
  heavy.mass = 1.05;
  Plant slippery;
  slippery.friction = 0.5;
  Plant soft;
  soft.actuators.gain = 0.7;
  Plant lopsided;
  lopsided.com_offset = Vec3(0.02, 0.01, 0.0) * size_;
  for (const Plant& plant : {heavy, slippery, soft, lopsided}) {
    const Recording perturbed = run(plant);
    EXPECT_GT(perturbed.com_error, 1e-4 * size_);
    EXPECT_GT(perturbed.zmp_error, 1e-3 * size_);
    ASSERT_EQ(perturbed.com.size(), nominal.com.size());
    double com = 0.0;
    double pressure = 0.0;
    for (std::size_t k = 0; k < nominal.com.size(); ++k) {
      com = std::max(com, (perturbed.com[k] - nominal.com[k]).norm());
      pressure = std::max(pressure, (perturbed.zmp[k] - nominal.zmp[k]).norm());
    }
    EXPECT_GT(com, 1e-7 * size_);  // as long as nothing slips, friction hardly matters
    EXPECT_GT(pressure, 1e-4 * size_);
    EXPECT_NEAR(perturbed.load, plant.mass * robot_.mass() * kGravity, 0.02 * robot_.mass() * kGravity);
  }
}

TEST_P(SimulatedRobotTest, SimulatesTheSameBitByBit) {
  const auto run = [&] {
    Simulation simulation(robot_, world_, Simulation::On::sim);
    Session& session = simulation.session();
    Stick stick(43);
    while (session.t() < 2.0)
      session.step(stick.at(session.t()));
    return session.truth()->q;
  };
  EXPECT_EQ(run(), run());
}

TEST_P(SimulatedRobotTest, RefusesATickThatPhysicsCannotDivide) {
  for (const double period : {0.0042, 0.0004, 0.00501}) {
    EXPECT_THROW(SimulatedRobot(robot_, world_, home_, period), InputError) << period;
  }
  EXPECT_NO_THROW(SimulatedRobot(robot_, world_, home_, 0.004));
}

TEST(SimulatedRobot, AJointWithoutAMotorGetsOneByItsTorqueLimit) {
  const std::filesystem::path folder = std::filesystem::path(BATON_SOURCE_DIR) / "robots" / "mighty";
  std::stringstream text;
  text << std::ifstream(folder / "mighty.xml").rdbuf();
  std::string model = text.str();
  const std::string motor = "<motor name=\"left_elbow_rotation\" joint=\"left_elbow_rotation\" class=\"re_max17\"/>";
  const std::size_t at = model.find(motor);
  ASSERT_NE(at, std::string::npos);
  model.erase(at, motor.size());
  Profile profile = Profile::load(folder / "profile.toml");
  profile.model = std::filesystem::path(test::temp_folder()) / "baton_without_motor.xml";
  std::ofstream(profile.model) << model;
  const RobotModel robot(profile);
  const World world = World::load("flat");
  const Posture home = stand(robot, Pose{}, robot.profile().stance.com_height);
  EXPECT_NO_THROW(SimulatedRobot(robot, world, home, 0.005));
  EXPECT_EQ(robot.mj().nu, static_cast<int>(robot.joints().size()));
  for (std::size_t j = 0; j < robot.joints().size(); ++j)
    EXPECT_EQ(robot.joints()[j].motor.stall, test::robot("mighty").joints()[j].motor.stall) << robot.joints()[j].name;
}

}  // namespace
}  // namespace baton
