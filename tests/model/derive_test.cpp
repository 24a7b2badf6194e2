#include "baton/model/derive.hpp"

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <fstream>
#include <random>
#include <set>

#include "baton/ik/stand.hpp"
#include "baton/model/anatomy.hpp"
#include "baton/model/error.hpp"
#include "baton/model/input_file.hpp"
#include "baton/model/robot_file.hpp"
#include "baton/model/robot_model.hpp"
#include "baton/model/urdf.hpp"
#include "tests/support/robots.hpp"
#include "tests/support/scratch.hpp"

namespace baton {
namespace {

using test::Scratch;
using testing::HasSubstr;

std::filesystem::path folder_of_mighty() {
  return share_dir() / "robots" / "mighty";
}

/// A profile with all keys, with the values that it was tuned to.
std::filesystem::path tuned_profile(const std::string& robot) {
  return robot == "scaled" ? std::filesystem::path(BATON_SCALED_ROBOT) / "profile.toml"
                           : std::filesystem::path(BATON_SOURCE_DIR) / "tests" / "robots" / "tuned" / "profile.toml";
}

/// What a robot's profile keeps when everything that follows from the model is left out.
toml::table short_profile(const std::string& robot) {
  const std::filesystem::path file = tuned_profile(robot);
  const toml::table whole = toml::parse_file(file.string());
  toml::table kept;
  kept.insert("model", (file.parent_path() / whole["model"].value_or(std::string())).string());
  for (const char* key : {"parts", "home_deg"})
    kept.insert(key, *whole[key].as_table());
  kept.insert("stance", toml::table{{"com_height", whole["stance"]["com_height"].value_or(0.0)}});
  return kept;
}

/// Values of a type (double for all numbers) in a table by key; those of an array count up.
template <typename T>
void collect(const toml::node& node, const std::string& key, std::map<std::string, T>& values) {
  if (const toml::table* table = node.as_table()) {
    for (const auto& [name, child] : *table)
      collect(child, key + "." + std::string(name.str()), values);
  } else if (const toml::array* array = node.as_array()) {
    for (std::size_t i = 0; i < array->size(); ++i)
      collect((*array)[i], key + "." + std::to_string(i), values);
  } else if (const auto value = node.value<T>()) {
    values[key] = *value;
  }
}

class DeriveTest : public testing::TestWithParam<std::string> {};
INSTANTIATE_TEST_SUITE_P(Robots, DeriveTest, testing::ValuesIn(test::robot_names()), test::name_of_param);

TEST_P(DeriveTest, GivesTheValuesThatTheProfileWasTunedTo) {
  toml::table tuned = toml::parse_file(tuned_profile(GetParam()).string());
  toml::table derived = complete(short_profile(GetParam()), "/", "short.toml").table;
  for (toml::table* table : {&tuned, &derived})
    table->erase("drive");  // servos belong to the motors, not to the size
  std::map<std::string, double> wanted;
  std::map<std::string, double> found;
  collect(tuned, "", wanted);
  collect(derived, "", found);
  EXPECT_GT(wanted.size(), 60U);
  for (const auto& [key, value] : wanted) {
    ASSERT_TRUE(found.contains(key)) << key;
    EXPECT_NEAR(found[key], value, 2e-3 * std::abs(value) + (GetParam() == "scaled" ? 6e-3 : 0.0)) << key;
  }
}

TEST(MightysProfile, IsShortAndLeavesNothingOutThatIsNotDerivedToTheBit) {
  const toml::table given = toml::parse_file(profile_file("mighty").string());
  toml::table derived = complete(given, folder_of_mighty(), "profile.toml").table;
  toml::table tuned = complete(toml::parse_file(tuned_profile("mighty").string()),
                               tuned_profile("mighty").parent_path(), "profile.toml")
                          .table;
  std::map<std::string, double> wanted;
  std::map<std::string, double> found;
  collect(tuned, "", wanted);
  collect(derived, "", found);
  EXPECT_EQ(found, wanted);
  std::map<std::string, std::string> wanted_texts;
  std::map<std::string, std::string> found_texts;
  collect(tuned, "", wanted_texts);
  collect(derived, "", found_texts);
  for (std::map<std::string, std::string>* texts : {&wanted_texts, &found_texts})
    texts->erase(".model");
  EXPECT_EQ(found_texts, wanted_texts);
  std::map<std::string, double> stated;
  collect(given, "", stated);
  EXPECT_LT(stated.size(), 40U);  // most of them of home and of the motors' heat
}

TEST_P(DeriveTest, FindsThePartsWithoutTheirNames) {
  const RobotModel& robot = test::robot(GetParam());
  const Anatomy parts = find_parts(robot.mj());
  EXPECT_EQ(parts.no_legs, "");
  EXPECT_EQ(parts.no_arms, "");
  EXPECT_EQ(parts.trunk, robot.trunk_body());
  EXPECT_TRUE(parts.fingers.empty());
  for (const Side side : kSides) {
    EXPECT_EQ(parts.foot[side], robot.foot_body(side));
    EXPECT_EQ(parts.hand[side], robot.hand_body(side));
    const int shoulder = robot.shoulder_body(side);  // its axis is the second of the arm
    EXPECT_TRUE(parts.shoulder[side] == shoulder || parts.shoulder[side] == robot.mj().body_parentid[shoulder]);
  }
  EXPECT_EQ(parts.imu, robot.profile().imu);
}

TEST_P(DeriveTest, TheModelAloneMakesARobotThatStands) {
  const RobotModel robot = RobotModel::load(test::robot(GetParam()).profile().model.string());
  const Posture posture = stand(robot, Pose{}, robot.profile().stance.com_height);
  Kinematics kinematics(robot);
  kinematics.set(posture.q);
  for (const Side side : kSides) {
    EXPECT_NEAR(kinematics.sole(side).p.z(), 0.0, 1e-5);
    EXPECT_LT(tilt_of(kinematics.sole(side).R), 1e-5);
    EXPECT_GT(kinematics.sole(side).p.y() * sign_of(side), 0.0);
  }
  for (std::size_t j = 0; j < robot.joints().size(); ++j) {
    const double q = posture.q[7 + static_cast<Eigen::Index>(j)];
    EXPECT_GT(q, robot.joints()[j].position.lo) << robot.joints()[j].name;
    EXPECT_LT(q, robot.joints()[j].position.hi) << robot.joints()[j].name;
  }
  EXPECT_GT(kinematics.self_distance(1.0, nullptr), 0.0);
}

TEST(Derive, WeakKneesStandStraighterAsFarAsTheyHaveTo) {
  const auto height = [](double torque) {
    toml::table given = short_profile("mighty");
    given.erase("stance");
    toml::table servo{{"kp", 100.0}, {"kd", 1.0}, {"torque", torque}};
    servo.insert("joints", toml::array{"left_knee_flexion", "right_knee_flexion"});
    given.insert("drive", toml::table{{"gains", toml::array{std::move(servo)}}});
    CompleteProfile whole = complete(given, "/", "short.toml");
    return std::pair(whole.table["stance"]["com_height"].value_or(0.0), whole.sources["stance.com_height"]);
  };
  const double bent = height(100.0).first;
  const double straight = bent / 0.92;
  double before = bent;
  std::set<double> heights;
  for (double torque = 8.0; torque > 0.2; torque *= 0.9) {
    const auto [now, source] = height(torque);
    EXPECT_GE(now, before) << torque;
    EXPECT_LE(now, 0.971 * straight + 1e-3) << torque;
    EXPECT_EQ(source.find("the knees are weak") != std::string::npos, now > bent) << torque;
    before = now;
    heights.insert(now);
  }
  EXPECT_NEAR(before, 0.97 * straight, 2e-3);
  EXPECT_GT(heights.size(), 4U);
}

TEST(Derive, WhatIsGivenStaysAndTheRestFollows) {
  toml::table given = short_profile("mighty");
  const toml::table before = complete(given, "/", "short.toml").table;
  std::map<std::string, double> numbers;
  collect(before, "", numbers);
  int tried = 0;
  for (const auto& [dotted, value] : numbers) {
    const std::string key = dotted.substr(1);
    if (key.starts_with("drive.") || std::isdigit(static_cast<unsigned char>(key.back())) != 0) continue;
    toml::table changed = given;
    const std::size_t dot = key.find('.');
    const std::string table = key.substr(0, dot);
    if (!changed.contains(table)) changed.insert(table, toml::table{});
    changed[table].as_table()->insert_or_assign(key.substr(dot + 1), 1.07 * value);
    const CompleteProfile after = complete(changed, "/", "short.toml");
    EXPECT_EQ(after.table.at_path(key).value<double>(), 1.07 * value) << key;
    EXPECT_FALSE(after.sources.contains(key)) << key;
    ++tried;
  }
  EXPECT_GT(tried, 30);
  given["stance"].as_table()->insert_or_assign("com_height", 0.25);
  const toml::table lower = complete(given, "/", "short.toml").table;
  EXPECT_NEAR(lower.at_path("reach.foot").value_or(0.0), 0.05 * 0.25 / 0.26, 1e-5);
  EXPECT_EQ(lower.at_path("margin.zmp_plan").value_or(0.0), before.at_path("margin.zmp_plan").value_or(1.0));
}

TEST(Derive, TellsAllFindingsAtOnce) {
  toml::table given = short_profile("mighty");
  given["parts"].as_table()->insert_or_assign("left_foot", "hoof");
  given["parts"].as_table()->insert_or_assign("right_hand", "claw");
  try {
    static_cast<void>(complete(given, "/", "short.toml"));
    FAIL() << "no InputError";
  } catch (const InputError& error) {
    EXPECT_THAT(error.what(), testing::AllOf(HasSubstr("short.toml"), HasSubstr("mighty.xml"), HasSubstr("'hoof'"),
                                             HasSubstr("'claw'")));
  }
}

TEST(Derive, WhatAModelDoesNotSayOfItsMotorsIsAssumedAndSaid) {
  toml::table given = short_profile("mighty");
  const toml::table row{{"kp", 15.0}, {"kd", 0.1}, {"joints", toml::array{"left_elbow_rotation", "left_knee_flexion"}}};
  given.insert("drive", toml::table{{"gains", toml::array{row}}});
  const Scratch scratch;
  std::string text = read_input(folder_of_mighty() / "mighty.xml", "model");
  const std::string stated = "armature=\"0.00469\" damping=\"0.119\"";
  ASSERT_NE(text.find(stated), std::string::npos);
  text.replace(text.find(stated), stated.size(), "");
  given.insert_or_assign("model", scratch.write("bare.xml", text));
  const CompleteProfile profile = complete(given, "/", "bare.toml");
  EXPECT_THAT(profile.warnings, testing::ElementsAre(testing::AllOf(HasSubstr("2 joints (left_elbow_rotation, …)"),
                                                                    HasSubstr("armature")),
                                                     HasSubstr("speed limit")));
  const RobotModel robot(Profile::complete_with(profile, "/", "bare.toml"));
  const double omega = robot.omega();
  for (const Joint& joint : robot.joints()) {
    const bool bare = joint.name.ends_with("_elbow_rotation");
    const double armature = robot.mj().dof_armature[6 + (&joint - robot.joints().data())];
    EXPECT_GT(armature, 0.0) << joint.name;
    if (bare) {
      EXPECT_NEAR(joint.motor.no_load, 2.5 * omega, 1e-2 * omega);
      EXPECT_NEAR(armature, 1e-4 * joint.motor.stall, 1e-7);
    } else {
      EXPECT_EQ(joint.motor.no_load, joint.motor.stall / joint.motor.damping) << joint.name;
    }
  }
  EXPECT_EQ(robot.joints()[2].name, "left_elbow_rotation");
  EXPECT_EQ(robot.joints()[2].gains.kp, 15.0);
}

/// Profiles and models that broke a reader: refused in one line, or taken; never a crash.
TEST(Derive, WhateverIsNamedIsRefusedInOneLine) {
  const Scratch scratch;
  const std::string model = (folder_of_mighty() / "mighty.xml").string();
  const std::vector<std::pair<std::string, std::string>> cases{
      {"[parts]\nimu = \"world\"", "world"},
      {"[parts]\nleft_foot = \"world\"", "must be a part of the robot"},
      {"[parts]\nleft_hand = \"right_hand\"", "does not hang from"},
      {"[parts]\nleft_foot = \"imu\"", "0 joints of its own"},
      {"parts = 3", "parts"},
      {"home_deg = 1", "home_deg"},
      {"drive = 3", "drive"},
      {"rigid = 5", "rigid"},
      {"rigid = [\"nope\"]", "'nope'"},
      {"rigid = [\"root\"]", "'root'"},
      {"rigid = [\"left_knee_flexion\"]", "6 hinges"},
      {"self_pairs = [[\"a\"]]", "self_pairs[0]"},
      {"self_pairs = [[\"a\", \"b\"]]", "'a'"},
      {"[stance]\ncom_height = 1e-310", "com_height"},
      {"[stance]\ncom_height = nan", "stance.com_height"},
  };
  for (const auto& [text, says] : cases) {
    const std::string file = scratch.write("odd.toml", "model = \"" + model + "\"\n" + text + "\n");
    try {
      static_cast<void>(stand(RobotModel::load(file), Pose{}, 0.26));
      ADD_FAILURE() << "taken: " << text;
    } catch (const InputError& error) {
      EXPECT_THAT(error.what(), HasSubstr(says)) << text;
      EXPECT_EQ(std::string(error.what()).find('\n'), std::string::npos) << error.what();
    }
  }
  // A given duration is not held against that of no robot.
  EXPECT_NO_THROW(static_cast<void>(
      Profile::load(scratch.write("slow.toml", "model = \"" + model + "\"\n[duration]\ndefault = 2.0\n"))));
}

TEST(Derive, DoesNotDependOnHowTheModelLies) {
  std::string text = read_input(folder_of_mighty() / "mighty.xml", "model");
  const std::string at = "<body name=\"body\" pos=\"0 0 0.3667\">";
  ASSERT_NE(text.find(at), std::string::npos);
  text.replace(text.find(at), at.size(), "<body name=\"body\" pos=\"1 2 3\" quat=\"0.5 0.5 -0.5 0.5\">");
  const Scratch scratch;
  const Profile lying = Profile::load(scratch.write("lying.xml", text));
  const Profile upright = Profile::load(folder_of_mighty() / "mighty.xml");
  EXPECT_EQ(lying.home, upright.home);
  EXPECT_EQ(lying.stance.width, upright.stance.width);
  EXPECT_EQ(lying.stance.com_height, upright.stance.com_height);
}

/// A foot whose colliders are these geoms, turned against the world.
ModelPtr foot_model(const std::string& geoms, const Eigen::Quaterniond& turned) {
  return compile_text(
      fmt::format("<mujoco><asset><mesh name='m' vertex='-.1 -.04 -.02 .1 -.04 -.02 -.1 .04 -.02 .1 .04 "
                  "-.02 0 0 .05'/></asset><worldbody><body name='foot' quat='{} {} {} {}'><freejoint/>"
                  "{}</body></worldbody></mujoco>",
                  turned.w(), turned.x(), turned.y(), turned.z(), geoms),
      "foot");
}

TEST(SoleShape, IsThatOfAPlaneBelowWhateverTheGeoms) {
  // The same rectangle of 0.2 m × 0.08 m, 0.02 m below the origin.
  const std::vector<std::string> feet{
      "<geom type='box' size='.1 .04 .01' pos='0 0 -.01'/>",
      "<geom type='sphere' size='.005' pos='.1 .04 -.015'/><geom type='sphere' size='.005' pos='.1 -.04 -.015'/>"
      "<geom type='sphere' size='.005' pos='-.1 .04 -.015'/><geom type='sphere' size='.005' pos='-.1 -.04 -.015'/>",
      "<geom type='capsule' size='.01' fromto='-.1 .04 -.01 .1 .04 -.01'/>"
      "<geom type='capsule' size='.01' fromto='-.1 -.04 -.01 .1 -.04 -.01'/>",
      "<geom type='cylinder' size='.01' fromto='-.1 .04 -.01 .1 .04 -.01'/>"
      "<geom type='cylinder' size='.01' fromto='-.1 -.04 -.01 .1 -.04 -.01'/>",
      "<geom type='ellipsoid' size='.03 .02 .01' pos='.1 .04 -.01'/><geom type='ellipsoid' size='.03 .02 .01' "
      "pos='.1 -.04 -.01'/><geom type='ellipsoid' size='.03 .02 .01' pos='-.1 .04 -.01'/>"
      "<geom type='ellipsoid' size='.03 .02 .01' pos='-.1 -.04 -.01'/>"};
  std::mt19937_64 random(3);
  std::normal_distribution<double> normal;
  for (int trial = 0; trial < 50; ++trial) {
    const Eigen::Quaterniond turned =
        Eigen::Quaterniond(normal(random), normal(random), normal(random), normal(random)).normalized();
    for (const std::string& geoms : feet) {
      const ModelPtr model = foot_model(geoms, turned);
      const SoleShape sole = sole_shape(*model, 1, Pose{});
      EXPECT_NEAR(sole.height, -0.02, 1e-9) << geoms;
      EXPECT_LT(sole.centre.norm(), 1e-9) << geoms;
      ASSERT_FALSE(sole.outline.empty()) << geoms;
      EXPECT_NEAR(sole.outline.margin(Vec2::Zero()), 0.04, 1e-9) << geoms;
      EXPECT_NEAR(sole.outline.inset(0.04 - 1e-6).nearest(Vec2(1, 0)).x(), 0.06, 1e-4) << geoms;
    }
  }
  // What does not touch the plane is not part of the sole, and a foot without colliders has none.
  const ModelPtr spiked = foot_model("<geom type='mesh' mesh='m'/>", Eigen::Quaterniond::Identity());
  const SoleShape sole = sole_shape(*spiked, 1, Pose{});
  EXPECT_NEAR(sole.outline.margin(Vec2::Zero()), 0.04, 1e-6);
  const ModelPtr ghost =
      foot_model("<geom type='box' size='.1 .04 .01' contype='0' conaffinity='0'/>", Eigen::Quaterniond::Identity());
  EXPECT_TRUE(sole_shape(*ghost, 1, Pose{}).outline.empty());
}

std::string text_of_mighty() {
  std::ostringstream text;
  text << std::ifstream(folder_of_mighty() / "mighty.xml").rdbuf();
  return text.str();
}

void put_in(std::string& text, const std::string& from, const std::string& to) {
  const std::size_t at = text.find(from);
  ASSERT_NE(at, std::string::npos) << from;
  for (std::size_t k = at; k != std::string::npos; k = text.find(from, k + to.size()))
    text.replace(k, from.size(), to);
}

TEST(RobotFile, AModelOfThatFormIsLeftAsItIs) {
  const std::filesystem::path file = folder_of_mighty() / "mighty.xml";
  const SpecPtr read = read_robot(file, test::robot("mighty").profile().changes());
  const SpecPtr plain = parse_model(file);
  static_cast<void>(compile_model(*read, "read"));
  static_cast<void>(compile_model(*plain, "plain"));
  EXPECT_EQ(text_of(*read, "read"), text_of(*plain, "plain"));
}

TEST(RobotFile, WithoutVisualsItWeighsAndTouchesTheSame) {
  const Scratch scratch;
  const std::string tetrahedron = "vertex='0 0 0  .1 0 0  0 .1 0  0 0 .1'";
  const std::filesystem::path file = scratch.write("drawn.xml", "<mujoco><asset><mesh name='shown' " + tetrahedron +
                                                                    "/><mesh name='shell' " + tetrahedron +
                                                                    "/></asset><worldbody>"
                                                                    R"(
    <body name='trunk'><freejoint/><inertial pos='0 0 0' mass='2' diaginertia='.1 .1 .1'/>
      <geom name='drawn' type='mesh' mesh='shown' contype='0' conaffinity='0'/>
      <geom name='felt' type='mesh' mesh='shell' contype='0' conaffinity='0'/>
      <geom name='box' type='box' size='.1 .1 .1'/>
      <body name='arm'><joint name='hinge' range='-1 1' limited='true'/>
        <geom name='heavy' type='sphere' size='.1' contype='0' conaffinity='0'/>
        <geom name='ball' type='sphere' size='.05'/>
    </body></body></worldbody>
    <contact><pair geom1='felt' geom2='ball'/></contact></mujoco>)");
  const ModelPtr whole = compile_model(*read_robot(file, {}), "whole");
  const ModelPtr bare = compile_model(*read_robot(file, {}, Visuals::drop), "bare");
  EXPECT_EQ(whole->ngeom, 5);
  EXPECT_EQ(whole->nmesh, 2);
  EXPECT_EQ(bare->ngeom, 4);  // 'heavy' makes the arm's inertia, 'felt' is in a pair
  EXPECT_EQ(bare->nmesh, 1);
  EXPECT_EQ(mj_name2id(bare.get(), mjOBJ_GEOM, "drawn"), -1);
  ASSERT_EQ(whole->nbody, bare->nbody);
  for (int i = 0; i < 3 * bare->nbody; ++i) {
    EXPECT_EQ(whole->body_mass[i / 3], bare->body_mass[i / 3]);
    EXPECT_EQ(whole->body_inertia[i], bare->body_inertia[i]);
    EXPECT_EQ(whole->body_ipos[i], bare->body_ipos[i]);
  }
}

TEST(RobotFile, HoweverTheModelIsWrittenTheRobotIsTheSame) {
  // Position servos, a world around it, no free joint, geoms that touch each other.
  std::string text = text_of_mighty();
  put_in(text, "<freejoint name=\"root\"/>", "");
  put_in(text, "<motor name", "<position kp=\"30\" name");
  for (const char* range : {"-1.31 1.31", "-2.79 2.79", "-3.34 3.34", "-6.62 6.62"})
    put_in(text, fmt::format("<motor ctrlrange=\"{}\"/>", range), "");
  put_in(text, "contype=\"2\" conaffinity=\"1\"", "contype=\"1\" conaffinity=\"1\"");
  put_in(
      text, "<worldbody>",
      "<worldbody><geom name=\"floor\" type=\"plane\" size=\"1 1 1\"/><light pos=\"0 0 3\"/><body name=\"table\"><geom "
      "type=\"box\" size=\"1 1 1\"/></body>");
  const std::size_t keys = text.find("<keyframe>");
  text.erase(keys, text.find("</keyframe>") + 11 - keys);
  const Scratch scratch;
  Profile profile = test::robot("mighty").profile();
  profile.model = scratch.write("odd.xml", text);
  const RobotModel odd(profile);
  const RobotModel& mighty = test::robot("mighty");
  ASSERT_EQ(odd.nv(), mighty.nv());
  EXPECT_EQ(odd.mj().nbody, mighty.mj().nbody);
  EXPECT_EQ(odd.mj().npair, mighty.mj().npair);
  EXPECT_NEAR(odd.mass(), mighty.mass(), 1e-12);
  for (std::size_t j = 0; j < odd.joints().size(); ++j) {
    EXPECT_EQ(odd.joints()[j].name, mighty.joints()[j].name);
    EXPECT_EQ(odd.joints()[j].motor.stall, mighty.joints()[j].motor.stall);
    EXPECT_EQ(odd.joints()[j].motor.no_load, mighty.joints()[j].motor.no_load);
  }
  const mjModel& m = odd.mj();
  EXPECT_EQ(m.nu, 20);
  for (int a = 0; a < m.nu; ++a)
    EXPECT_EQ(m.actuator_biastype[a], mjBIAS_NONE);
  for (int a = 0; a < m.ngeom; ++a) {
    for (int b = 0; b < m.ngeom; ++b)
      EXPECT_EQ(m.geom_contype[a] & m.geom_conaffinity[b], 0);
  }
}

/// A biped of boxes as a URDF: legs of six joints, arms of three.
std::string urdf(const std::string& extra) {
  std::string text =
      "<robot name='boxes'><link name='base'><inertial><mass value='8'/><inertia ixx='.1' iyy='.1' "
      "izz='.1' ixy='0' ixz='0' iyz='0'/></inertial></link>";
  const auto link = [&](const std::string& name, double mass, const std::string& collision) {
    text += fmt::format(
        "<link name='{}'><inertial><origin xyz='0 0 -.05'/><mass value='{}'/><inertia ixx='.004' "
        "iyy='.004' izz='.004' ixy='0' ixz='0' iyz='0'/></inertial>{}</link>",
        name, mass, collision);
  };
  const auto joint = [&](const std::string& name, const std::string& parent, const std::string& child,
                         const std::string& xyz, const std::string& axis, double lo, double hi) {
    text += fmt::format(
        "<joint name='{}' type='revolute'><parent link='{}'/><child link='{}'/><origin xyz='{}'/><axis "
        "xyz='{}'/><limit lower='{}' upper='{}' effort='60' velocity='7'/></joint>",
        name, parent, child, xyz, axis, lo, hi);
  };
  for (const auto& [side, y] : {std::pair("l", 0.09), std::pair("r", -0.09)}) {
    const std::string s = side;
    const auto of = [&s](const char* name) { return s + "_" + name; };
    link(of("hip1"), 0.5, "");
    link(of("hip2"), 0.5, "");
    link(of("thigh"), 1.5, "");
    link(of("shank"), 1.0, "");
    link(of("ankle"), 0.2, "");
    link(of("foot"), 0.4,
         "<collision><origin xyz='.03 0 -.05'/><geometry><box size='.2 .1 .02'/></geometry></collision>");
    joint(of("yaw"), "base", of("hip1"), fmt::format("0 {} -.05", y), "0 0 1", -1, 1);
    joint(of("roll"), of("hip1"), of("hip2"), "0 0 0", "1 0 0", -0.6, 0.6);
    joint(of("pitch"), of("hip2"), of("thigh"), "0 0 0", "0 1 0", -1.8, 1);
    joint(of("knee"), of("thigh"), of("shank"), "0 0 -.25", "0 1 0", 0, 2.4);
    joint(of("ap"), of("shank"), of("ankle"), "0 0 -.25", "0 1 0", -1, 1);
    joint(of("ar"), of("ankle"), of("foot"), "0 0 0", "1 0 0", -0.6, 0.6);
    link(of("upper"), 0.4, "");
    link(of("mid"), 0.4, "");
    link(of("fore"), 0.4, "");
    joint(of("sp"), "base", of("upper"), fmt::format("0 {} .35", 1.6 * y), "0 1 0", -2, 2);
    joint(of("sr"), of("upper"), of("mid"), "0 0 0", "1 0 0", -1.5, 1.5);
    joint(of("el"), of("mid"), of("fore"), "0 0 -.2", "0 1 0", -2, 0);
  }
  return text + extra + "</robot>";
}

TEST(Urdf, BecomesARobotThatStandsByItsLimits) {
  const Scratch scratch;
  const RobotModel robot = RobotModel::load(scratch.write("boxes.urdf", urdf("")));
  EXPECT_EQ(robot.nv(), 6 + 18);
  EXPECT_NEAR(robot.mass(), 8.0 + 2.0 * (4.1 + 1.2), 1e-9);
  for (const Joint& joint : robot.joints()) {
    EXPECT_EQ(joint.motor.stall, 60.0);
    EXPECT_EQ(joint.motor.no_load, 7.0);
  }
  EXPECT_EQ(robot.profile().parts.foot[0], "l_foot");
  EXPECT_EQ(robot.profile().parts.hand[1], "r_fore");
  EXPECT_EQ(robot.profile().parts.trunk, "base");
  EXPECT_NEAR(robot.sole(Side::left).margin(Vec2::Zero()), 0.05, 1e-9);
  static_cast<void>(stand(robot, Pose{}, robot.profile().stance.com_height));
  EXPECT_FALSE(robot.profile().warnings.empty()) << "it has neither armature nor IMU";
}

TEST(Urdf, NamesAMeshThatIsNowhere) {
  const Scratch scratch;
  const std::string mesh =
      "<link name='hat'><visual><geometry><mesh filename='package://boxes/hat.stl'/></geometry></visual></link><joint "
      "name='on' type='fixed'><parent link='base'/><child link='hat'/></joint>";
  EXPECT_THAT([&] { static_cast<void>(parse_urdf(scratch.write("boxes.urdf", urdf(mesh)))); },
              testing::ThrowsMessage<InputError>(testing::AllOf(HasSubstr("hat.stl"), HasSubstr("ROS_PACKAGE_PATH"))));
  EXPECT_THAT([&] { static_cast<void>(parse_urdf(scratch.write("broken.urdf", "<robot><link"))); },
              testing::ThrowsMessage<InputError>(HasSubstr("broken.urdf")));
  EXPECT_THAT([&] { static_cast<void>(parse_urdf(scratch.write("other.urdf", "<mujoco/>"))); },
              testing::ThrowsMessage<InputError>(HasSubstr("<robot>")));
}

TEST(Urdf, ReadsColladaAndPackagesBesideIt) {
  const Scratch scratch;
  std::filesystem::create_directories(scratch.path("boxes"));
  std::ofstream(scratch.path("boxes/hat.dae")) << R"(<?xml version="1.0"?>
<COLLADA xmlns="http://www.collada.org/2005/11/COLLADASchema" version="1.4.1"><asset><up_axis>Z_UP</up_axis></asset>
<library_geometries><geometry id="g"><mesh><source id="p"><float_array id="a" count="12">0 0 0 .1 0 0 0 .1 0 0 0 .1</float_array>
<technique_common><accessor source="#a" count="4" stride="3"><param name="X" type="float"/><param name="Y" type="float"/>
<param name="Z" type="float"/></accessor></technique_common></source><vertices id="v"><input semantic="POSITION" source="#p"/>
</vertices><triangles count="4"><input semantic="VERTEX" source="#v" offset="0"/><p>0 2 1 0 1 3 0 3 2 1 2 3</p></triangles>
</mesh></geometry></library_geometries><library_visual_scenes><visual_scene id="s"><node><instance_geometry url="#g"/></node>
</visual_scene></library_visual_scenes><scene><instance_visual_scene url="#s"/></scene></COLLADA>)";
  const std::string hat =
      "<link name='hat'><inertial><mass value='.1'/><inertia ixx='1e-3' iyy='1e-3' izz='1e-3' ixy='0' ixz='0' "
      "iyz='0'/></inertial><collision><geometry><mesh filename='package://boxes/hat.dae'/></geometry></collision>"
      "</link><joint name='on' type='fixed'><parent link='base'/><child link='hat'/><origin xyz='0 0 .4'/></joint>";
  const RobotModel robot = RobotModel::load(scratch.write("boxes.urdf", urdf(hat)));
  ASSERT_EQ(robot.mj().nmesh, 1);
  EXPECT_EQ(robot.mj().mesh_vertnum[0], 4);
  EXPECT_NEAR(robot.mass(), 8.1 + 2.0 * (4.1 + 1.2), 1e-9);
}

TEST(Urdf, JointsThatFollowOthersAndFingersAreRigid) {
  const Scratch scratch;
  std::string fingers;
  for (const std::string side : {"l", "r"}) {
    for (const std::string finger : {"thumb", "index"}) {
      fingers += fmt::format(
          "<link name='{0}_{1}'><inertial><mass value='.02'/><inertia ixx='1e-4' iyy='1e-4' izz='1e-4' ixy='0' ixz='0' "
          "iyz='0'/></inertial></link><joint name='{0}_{1}_joint' type='revolute'><parent link='{0}_fore'/><child "
          "link='{0}_{1}'/><origin xyz='0 0 -.2'/><axis xyz='0 1 0'/><limit lower='-1' upper='1' effort='1' "
          "velocity='3'/>{2}</joint>",
          side, finger, finger == "index" ? fmt::format("<mimic joint='{}_thumb_joint'/>", side) : "");
    }
    fingers += fmt::format(
        "<link name='{0}_little'><inertial><mass value='.02'/><inertia ixx='1e-4' iyy='1e-4' izz='1e-4' ixy='0' "
        "ixz='0' "
        "iyz='0'/></inertial></link><joint name='{0}_little_joint' type='revolute'><parent link='{0}_fore'/><child "
        "link='{0}_little'/><origin xyz='0 0 -.2'/><axis xyz='0 1 0'/><limit lower='-1' upper='1' effort='1' "
        "velocity='3'/></joint>",
        side);
  }
  const RobotModel robot = RobotModel::load(scratch.write("boxes.urdf", urdf(fingers)));
  EXPECT_EQ(robot.nv(), 6 + 18) << "thumb and little finger are rigid, the index follows";
  EXPECT_EQ(robot.profile().parts.hand[0], "l_fore");
  EXPECT_EQ(robot.profile().rigid.size(), 4U);
}

TEST(RobotModel, WaistAndNeckKeepTheirHomeAndBelongToNoLimb) {
  std::string text = text_of_mighty();
  put_in(text, "<site name=\"imu\" pos=\"0.039 0 0.05\"/>",
         "<site name=\"imu\" pos=\"0.039 0 0.05\"/><body name=\"head\" pos=\"0 0 0.2\"><inertial pos=\"0 0 0.05\" "
         "mass=\"0.1\" diaginertia=\"1e-4 1e-4 1e-4\"/><joint name=\"neck\" axis=\"0 0 1\" range=\"0 1\" "
         "damping=\"0.1\" armature=\"0.001\" actuatorfrcrange=\"-1 1\"/></body>");
  const std::size_t keys = text.find("<keyframe>");
  text.erase(keys, text.find("</keyframe>") + 11 - keys);
  const Scratch scratch;
  const RobotModel robot = RobotModel::load(scratch.write("necked.xml", text));
  ASSERT_EQ(robot.idle().size(), 1U);
  const int neck = robot.idle().front();
  const Joint& joint = robot.joints()[static_cast<std::size_t>(neck)];
  EXPECT_EQ(joint.name, "neck");
  EXPECT_GT(joint.home, 0.0) << "its range begins at zero";
  const Posture posture = stand(robot, Pose{}, robot.profile().stance.com_height);
  EXPECT_NEAR(posture.q[7 + neck], joint.home, 1e-6);
  // Wherever trunk and hands are sent, the neck stays.
  InverseKinematics ik(robot);
  std::mt19937_64 random(5);
  std::uniform_real_distribution<double> draw(-1.0, 1.0);
  const double h = robot.profile().stance.com_height;
  for (int trial = 0; trial < 200; ++trial) {
    IkTargets targets;
    targets.com = posture.com + 0.05 * h * Vec3(draw(random), draw(random), draw(random));
    targets.trunk = posture.trunk * rotation_exp(0.2 * Vec3(draw(random), draw(random), draw(random)));
    targets.sole = posture.sole;
    targets.arms = posture.q.tail(robot.nv() - 6);
    if (trial % 2 == 0) targets.hand.left = posture.hand.left;
    VecX q = posture.q;
    q[7 + neck] += 0.1 * draw(random) * draw(random);
    static_cast<void>(ik.solve(targets, q, std::numeric_limits<double>::infinity(), q, 30));
    EXPECT_NEAR(q[7 + neck], joint.home, 1e-6);
  }
}

}  // namespace
}  // namespace baton
