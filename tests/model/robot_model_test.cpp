#include "baton/model/robot_model.hpp"

#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <iterator>

#include "baton/ik/stand.hpp"
#include "baton/model/contact.hpp"
#include "tests/support/robots.hpp"
#include "tests/support/temp.hpp"

namespace baton {
namespace {

class RobotModelTest : public testing::TestWithParam<std::string> {
 protected:
  const RobotModel& robot_ = test::robot(GetParam());
};

INSTANTIATE_TEST_SUITE_P(Robots, RobotModelTest, testing::ValuesIn(test::robot_names()), test::name_of_param);

TEST_P(RobotModelTest, HasLegsArmsAndSoles) {
  for (const Side side : kSides) {
    EXPECT_EQ(robot_.leg(side).size(), 6u);
    EXPECT_EQ(robot_.arm(side).size(), 4u);
    EXPECT_FALSE(robot_.hand_has_attitude(side));
    EXPECT_EQ(robot_.sole(side).vertices().size(), 4u);
    EXPECT_NEAR(robot_.sole(side).centre().norm(), 0.0, 1e-9);
  }
}

TEST_P(RobotModelTest, JacobiansAreTheDerivativesOfTheKinematics) {
  Kinematics k(robot_);
  const Posture home = stand(robot_, Pose{}, robot_.profile().stance.com_height);
  JacobianRows com(3, robot_.nv());
  JacobianRows point(3, robot_.nv());
  JacobianRows rotation(3, robot_.nv());
  std::mt19937_64 random(7);
  std::normal_distribution<double> normal;
  for (int trial = 0; trial < 100; ++trial) {
    VecX q = home.q;
    VecX dq = VecX::NullaryExpr(robot_.nv(), [&] { return normal(random); });
    integrate(robot_, q, dq, 0.2);
    dq = VecX::NullaryExpr(robot_.nv(), [&] { return normal(random); });
    k.set(q);
    k.com_jacobian(com);
    const int body = robot_.hand_body(Side::left);
    k.point_jacobian(body, k.hand(Side::left).p, point);
    k.rotation_jacobian(body, rotation);
    const double h = 1e-6;
    VecX ahead = q;
    integrate(robot_, ahead, dq, h);
    const Vec3 com0 = k.com();
    const Pose hand0 = k.hand(Side::left);
    k.set(ahead);
    EXPECT_LT(((k.com() - com0) / h - com * dq).norm(), 1e-4);
    EXPECT_LT(((k.hand(Side::left).p - hand0.p) / h - point * dq).norm(), 1e-4);
    EXPECT_LT((rotation_error(k.hand(Side::left).R, hand0.R) / h - rotation * dq).norm(), 1e-4);
  }
}

/// Links and axes against those of MuJoCo.
void expect_links(const Kinematics& k, const mjData& data) {
  const mjModel& m = k.robot().mj();
  const double fine = 1e-12 * k.robot().profile().stance.com_height;
  for (int b = 1; b < m.nbody; ++b) {
    ASSERT_LT((k.body(b).p - Eigen::Map<const Vec3>(data.xpos + 3 * b)).norm(), fine);
    const Eigen::Map<const Eigen::Matrix<double, 3, 3, Eigen::RowMajor>> R(data.xmat + 9 * b);
    ASSERT_LT((k.body(b).R - R).norm(), 1e-12);
  }
  for (int dof = 6; dof < m.nv; ++dof) {
    const Kinematics::Axis& axis = k.dof_axis(dof);
    ASSERT_LT((axis.direction - Eigen::Map<const Vec3>(data.xaxis + 3 * m.dof_jntid[dof])).norm(), 1e-12);
    ASSERT_LT((axis.point - Eigen::Map<const Vec3>(data.xanchor + 3 * m.dof_jntid[dof])).norm(), fine);
  }
}

/// At random configurations, however they are set.
void expect_as_in_the_simulator(const RobotModel& robot) {
  const mjModel& m = robot.mj();
  const DataPtr data(mj_makeData(&m));
  Kinematics k(robot);
  Kinematics unmoved(robot);
  Kinematics moved(robot);
  std::vector<int> links;
  for (int b = 2; b < m.nbody; ++b)
    links.push_back(b);
  std::mt19937_64 random(11);
  std::normal_distribution<double> normal;
  const double fine = 1e-12 * robot.profile().stance.com_height;
  for (int trial = 0; trial < 1000; ++trial) {
    VecX q = Eigen::Map<const VecX>(m.qpos0, m.nq);
    integrate(robot, q, VecX::NullaryExpr(robot.nv(), [&] { return normal(random); }), 1.0);
    q.segment<4>(3) *= std::exp(normal(random));  // of any norm
    mju_copy(data->qpos, q.data(), m.nq);
    mj_kinematics(&m, data.get());
    mj_comPos(&m, data.get());
    k.set(q);
    expect_links(k, *data);
    ASSERT_LT((k.com() - Eigen::Map<const Vec3>(data->subtree_com + 3)).norm(), fine);
    // The root's pose, then the joints.
    VecX at_origin = q;
    set_root(at_origin, Pose{});
    unmoved.set(at_origin);
    moved.set_moved(unmoved, k.body(1), q);
    expect_links(moved, *data);
    ASSERT_LT((moved.com() - k.com()).norm(), fine);
    ASSERT_LT((moved.inertia() - k.inertia()).norm(), 1e-12 * k.inertia().norm());
    VecX other = q;
    other.tail(m.nq - 7) *= 0.5;
    k.set(other);
    k.set_links(q, links);
    expect_links(k, *data);
  }
}

TEST_P(RobotModelTest, LinksAreWhereTheSimulatorHasThem) {
  expect_as_in_the_simulator(robot_);
}

TEST(Mighty, LinksAreWhereTheSimulatorHasThemHoweverTheModelIsWritten) {
  // Turned links, joints beside the links' origins and not at zero, two of them in one link.
  const std::filesystem::path folder = std::filesystem::path(test::temp_folder()) / "baton_odd_mighty";
  std::filesystem::create_directories(folder);
  const std::filesystem::path source = share_dir() / "robots" / "mighty";
  std::filesystem::copy_file(source / "profile.toml", folder / "profile.toml",
                             std::filesystem::copy_options::overwrite_existing);
  std::ifstream file(source / "mighty.xml");
  std::string text(std::istreambuf_iterator<char>(file), {});
  const auto flexion = text.find("<joint name=\"left_elbow_flexion\"");
  const std::string joint = text.substr(flexion, text.find("/>", flexion) + 2 - flexion);
  text.erase(flexion, joint.size());
  text.insert(text.find("/>", text.find("<joint name=\"left_elbow_rotation\"")) + 2, joint);
  const auto everywhere = [&](const std::string& what, const std::string& before) {
    for (auto at = text.find(what); at != std::string::npos; at = text.find(what, at + before.size() + what.size()))
      text.insert(at, before);
  };
  everywhere(" axis=\"", " pos=\"0.01 -0.02 0.03\" ref=\"0.1\"");
  everywhere(" pos=\"0 0 -0.044\"", " euler=\"10 20 30\"");
  std::ofstream(folder / "mighty.xml") << text;
  const RobotModel robot = RobotModel::load((folder / "profile.toml").string());
  EXPECT_EQ(robot.nv(), test::robot("mighty").nv());
  expect_as_in_the_simulator(robot);
}

TEST_P(RobotModelTest, AtRestTheGroundCarriesTheWeightBelowTheCom) {
  const Posture home = stand(robot_, Pose{}, robot_.profile().stance.com_height);
  Kinematics k(robot_);
  const VecX zero = VecX::Zero(robot_.nv());
  VecX force = zero;
  k.inverse_dynamics(home.q, zero, zero, force);
  const Wrench wrench = ground_wrench(k, force);
  EXPECT_NEAR(wrench.force.z(), robot_.mass() * kGravity, 1e-6);
  EXPECT_NEAR(wrench.force.head<2>().norm(), 0.0, 1e-9);
  EXPECT_LT((wrench.zmp(0.0) - home.com.head<2>()).norm(), 1e-6);
  const BySide<Wrench> shared = share_wrench(robot_, home.sole, home.contact, wrench);
  EXPECT_NEAR(shared.left.force.z(), shared.right.force.z(), 0.02 * wrench.force.z());
  EXPECT_LT((shared.left.force + shared.right.force - wrench.force).norm(), 1e-9);
  EXPECT_LT((shared.left.moment + shared.right.moment - wrench.moment).norm(), 1e-9);
}

TEST(Mighty, StandsAsInTheFacts) {
  const RobotModel& robot = test::robot("mighty");
  EXPECT_NEAR(robot.mass(), 5.531, 0.001);
  EXPECT_NEAR(robot.omega(), 6.14, 0.005);
  struct Row {
    double com, body, hip, knee, ankle;
  };
  for (const Row& row :
       {Row{0.28, .3485, 15.4, 41.0, 25.6}, Row{0.27, .3353, 22.0, 55.2, 33.2}, Row{0.26, .3220, 27.2, 66.8, 39.6},
        Row{0.25, .3088, 31.6, 76.9, 45.2}, Row{0.24, .2956, 35.5, 86.0, 50.5}}) {
    const Posture posture = stand(robot, Pose{}, row.com);
    EXPECT_NEAR(posture.q[2], row.body, 0.001);
    const auto degrees = [&](const std::string& name) {
      for (std::size_t j = 0; j < robot.joints().size(); ++j) {
        if (robot.joints()[j].name == name) return posture.q[7 + static_cast<Eigen::Index>(j)] * 180.0 / M_PI;
      }
      return 1e9;
    };
    EXPECT_NEAR(degrees("left_hip_flexion"), row.hip, 0.3);
    EXPECT_NEAR(degrees("left_knee_flexion"), row.knee, 0.3);
    EXPECT_NEAR(degrees("left_ankle_flexion"), row.ankle, 0.3);
  }
}

}  // namespace
}  // namespace baton
