#include "baton/model/profile.hpp"
#include "tests/support/temp.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <toml++/toml.h>

#include <fstream>
#include <sstream>

#include "baton/model/error.hpp"
#include "tests/support/robots.hpp"

namespace baton {
namespace {

using testing::AllOf;
using testing::HasSubstr;

const std::filesystem::path kMighty = std::filesystem::path(BATON_SOURCE_DIR) / "robots" / "mighty";
/// With all of its keys.
const std::filesystem::path kWhole =
    std::filesystem::path(BATON_SOURCE_DIR) / "tests" / "robots" / "tuned" / "profile.toml";

std::string text_of(const std::filesystem::path& file) {
  std::stringstream text;
  text << std::ifstream(file).rdbuf();
  return text.str();
}

std::filesystem::path write(const std::string& name, const std::string& text) {
  const auto file = std::filesystem::path(test::temp_folder()) / name;
  std::ofstream(file) << text;
  return file;
}

/// mighty's profile, beside no model: it points to the one in the repository.
toml::table mighty_profile() {
  toml::table table = toml::parse_file(kWhole.string());
  table.insert_or_assign("model", (kMighty / "mighty.xml").string());
  return table;
}

std::filesystem::path write(const toml::table& table) {
  std::stringstream text;
  text << table;
  return write("baton_profile.toml", text.str());
}

/// The message of the InputError that loading the robot gives; empty if there is none.
std::string complaint(const std::filesystem::path& file) {
  try {
    static_cast<void>(RobotModel::load(file.string()));
  } catch (const InputError& error) {
    EXPECT_EQ(std::string(error.what()).find('\n'), std::string::npos) << error.what();
    return error.what();
  }
  return "";
}

/// A value of the profile: where it is, and how to put another in its place.
struct Leaf {
  std::string key;   ///< as a complaint names it: of the array, for a number in an array
  std::string path;  ///< of the value itself
  bool text = false;
};

/// All values, with a way to reach each in another copy of the table.
void collect(const toml::node& node, const std::string& path, const std::string& key, std::vector<Leaf>& leaves) {
  if (const toml::table* table = node.as_table()) {
    for (const auto& [name, child] : *table) {
      const std::string next = path.empty() ? std::string(name.str()) : path + "." + std::string(name.str());
      collect(child, next, next, leaves);
    }
  } else if (const toml::array* array = node.as_array()) {
    for (std::size_t i = 0; i < array->size(); ++i) {
      const std::string next = path + "[" + std::to_string(i) + "]";
      const bool number = (*array)[i].is_number();
      collect((*array)[i], next, number ? key : next, leaves);
    }
  } else {
    leaves.push_back({key, path, node.is_string()});
  }
}

std::vector<Leaf> leaves() {
  std::vector<Leaf> all;
  collect(mighty_profile(), "", "", all);
  return all;
}

/// Replaces, or with no value removes, what is at a path.
template <typename Value>
void put(toml::table& root, const std::string& path, const Value* value) {
  const std::size_t bracket = path.back() == ']' ? path.rfind('[') : std::string::npos;
  if (bracket != std::string::npos) {
    toml::array& array = *root.at_path(path.substr(0, bracket)).as_array();
    const auto index = array.begin() + std::stol(path.substr(bracket + 1));
    value != nullptr ? array.replace(index, *value) : array.erase(index);
    return;
  }
  const std::size_t dot = path.rfind('.');
  toml::table& table = dot == std::string::npos ? root : *root.at_path(path.substr(0, dot)).as_table();
  const std::string name = dot == std::string::npos ? path : path.substr(dot + 1);
  value != nullptr ? void(table.insert_or_assign(name, *value)) : void(table.erase(name));
}

template <typename Value>
std::string complaint_with(const std::string& path, const Value& value) {
  toml::table table = mighty_profile();
  put(table, path, &value);
  return complaint(write(table));
}

std::string complaint_without(const std::string& path) {
  toml::table table = mighty_profile();
  put<int>(table, path, nullptr);
  return complaint(write(table));
}

TEST(Profile, OfMightyIsAsWritten) {
  const Profile p = Profile::load(kMighty / "profile.toml");
  EXPECT_EQ(p.name, "mighty");
  EXPECT_EQ(p.model, kMighty / "mighty.xml");
  EXPECT_EQ(p.parts.foot[0], "left_sole");
  EXPECT_EQ(p.parts.hand[1], "right_hand");
  EXPECT_EQ(p.stance.com_height, 0.26);
  EXPECT_NEAR(p.home.at("left_elbow_rotation"), 70.0 * M_PI / 180.0, 1e-12);
  EXPECT_EQ(p.region.foot_x.lo, -p.region.foot_x.hi);
  EXPECT_NEAR(p.ground.tilt, 3.0 * M_PI / 180.0, 1e-12);
  EXPECT_EQ(p.duration.first, 0.5);
  EXPECT_EQ(p.duration.step, 0.1);
  EXPECT_EQ(p.phases.step[1], 0.40);
  EXPECT_EQ(p.tick.lookahead, 6);
  EXPECT_EQ(p.gains.at("right_elbow_rotation").kp, 15);
  EXPECT_EQ(complaint(write(mighty_profile())), "");
  EXPECT_GT(leaves().size(), 80u);
}

TEST(Profile, WhatIsMissingIsDerived) {
  for (const Leaf& leaf : leaves()) {
    const std::string message = complaint_without(leaf.path);
    const bool of_a_list = leaf.path.back() == ']' && !leaf.path.starts_with("drive.gains");
    const bool of_a_row = leaf.path.starts_with("drive.gains[") && !leaf.text;
    if (leaf.path == "model" || of_a_list || of_a_row) {
      EXPECT_THAT(message, AllOf(HasSubstr("baton_profile.toml"), HasSubstr(leaf.key + " "))) << leaf.path;
    } else {
      EXPECT_EQ(message, "") << leaf.path;
    }
  }
  for (const auto& [name, node] : mighty_profile()) {
    if (!node.is_table()) continue;
    EXPECT_EQ(complaint_without(std::string(name.str())), "") << name.str();
  }
}

TEST(Profile, SaysWhichValueIsOfTheWrongKind) {
  for (const Leaf& leaf : leaves()) {
    const auto expect = [&](const std::string& message) {
      EXPECT_THAT(message, AllOf(HasSubstr("baton_profile.toml"), HasSubstr(leaf.key + " "))) << leaf.path;
    };
    expect(complaint_with(leaf.path, true));
    expect(complaint_with(leaf.path, toml::array{1, 2, 3, 4, 5, 6, 7}));
    expect(complaint_with(leaf.path, toml::table{}));
    if (leaf.text) {
      expect(complaint_with(leaf.path, 1.5));
      expect(complaint_with(leaf.path, std::string{}));
    } else {
      expect(complaint_with(leaf.path, std::string("0.1")));
    }
  }
}

TEST(Profile, SaysWhichNumberIsNone) {
  for (const Leaf& leaf : leaves()) {
    if (leaf.text) continue;
    for (const double value : {std::numeric_limits<double>::quiet_NaN(), std::numeric_limits<double>::infinity(),
                               -std::numeric_limits<double>::infinity(), 1e9, -1e9, 1e300}) {
      EXPECT_THAT(complaint_with(leaf.path, value), AllOf(HasSubstr("baton_profile.toml"), HasSubstr(leaf.key + " ")))
          << leaf.path << " = " << value;
    }
    const bool negative_is_fine = leaf.path.starts_with("home_deg.") || leaf.key == "region.foot_x";
    if (negative_is_fine) continue;
    EXPECT_THAT(complaint_with(leaf.path, -0.01), AllOf(HasSubstr("baton_profile.toml"), HasSubstr(leaf.key + " ")))
        << leaf.path;
  }
}

TEST(Profile, SaysWhichKeyItDoesNotKnow) {
  // A misspelt key would silently keep its old meaning, or none.
  for (const std::string table : {"", "parts", "stance", "reach", "region", "swing", "ground", "duration", "phases",
                                  "margin", "ik", "tick", "stabiliser", "drive", "drive.gains[1]", "nowhere"}) {
    toml::table profile = mighty_profile();
    if (table == "nowhere") profile.insert("nowhere", toml::table{});
    const std::string key = table.empty() ? "comheight" : table + ".comheight";
    const double value = 0.26;
    put(profile, key, &value);
    EXPECT_THAT(complaint(write(profile)), AllOf(HasSubstr("baton_profile.toml"), HasSubstr(key)));
  }
}

TEST(Profile, MayStateTheErrorsOfSensorsAndActuators) {
  const std::string stem = text_of(kWhole);
  const auto with = [&](const std::string& tables) {
    toml::table table = toml::parse(stem + tables);
    table.insert_or_assign("model", (kMighty / "mighty.xml").string());
    return write(table);
  };
  const Profile moderate = Profile::load(with(""));
  EXPECT_EQ(moderate.sensors.delay, 0.005);
  EXPECT_NEAR(moderate.sensors.imu_wander, 0.5 * M_PI / 180.0, 1e-12);
  EXPECT_TRUE(moderate.sensors.differenced_speeds);
  EXPECT_EQ(moderate.actuators.friction, 0.05);
  EXPECT_TRUE(moderate.actuators.held_targets);
  EXPECT_EQ(moderate.actuators.gain, 1.0);
  const Profile own = Profile::load(with(R"(
[sensors]
delay = 0.012
differenced_speeds = false
[actuators]
backlash = 0
)"));
  EXPECT_EQ(own.sensors.delay, 0.012);
  EXPECT_FALSE(own.sensors.differenced_speeds);
  EXPECT_EQ(own.sensors.jitter, moderate.sensors.jitter);
  EXPECT_EQ(own.actuators.backlash, 0.0);
  EXPECT_EQ(own.actuators.lag, moderate.actuators.lag);
  EXPECT_THAT(complaint(with("[sensors]\ndelay = -1\n")), AllOf(HasSubstr("sensors.delay = -1"), HasSubstr("0.1")));
  EXPECT_THAT(complaint(with("[actuators]\nheld_targets = 1\n")),
              AllOf(HasSubstr("actuators.held_targets = 1"), HasSubstr("true or false")));
  EXPECT_THAT(complaint(with("[sensors]\nimu_wobble = 1\n")), HasSubstr("sensors.imu_wobble"));
}

TEST(Profile, MayStateWhatMotorsSustain) {
  EXPECT_EQ(Profile::load(kMighty / "profile.toml").heat.at("left_knee_flexion").continuous, 0.25);
  toml::table table = mighty_profile();
  for (toml::node& row : *table.at_path("drive.gains").as_array())
    row.as_table()->erase("heat");
  const RobotModel robot = RobotModel::load(write(table).string());
  for (const Joint& joint : robot.joints())
    EXPECT_EQ(steady(joint.motor.thermal, 1.0), 0.0) << "without it, nothing";
}

TEST(Profile, RefusesWhatDoesNotGoTogether) {
  const auto expect = [](const std::string& path, const auto& value, const std::string& key) {
    EXPECT_THAT(complaint_with(path, value), AllOf(HasSubstr("baton_profile.toml"), HasSubstr(key))) << path;
  };
  expect("region.foot_x", toml::array{0.1, -0.1}, "region.foot_x");
  expect("region.com_height", toml::array{0.25, 0.25}, "region.com_height");
  expect("phases.step", toml::array{0.25, 0.40, 0.36}, "phases.step");
  expect("phases.lift", toml::array{1.0, 0.0}, "phases.lift");
  expect("duration.max", 0.4, "duration.max");
  expect("duration.step", 1e-9, "duration.step");  // or the search would never end
  expect("duration.default", 1e-9, "duration.default");
  expect("tick.lookahead", 6.5, "tick.lookahead");
  expect("drive.kind", std::string("hope"), "drive.kind");
  expect("drive.gains[0].heat.housing_time", 9.0, "drive.gains[0].heat.housing_time");
}

TEST(Profile, NamesWhatTheModelHasNot) {
  for (const std::string part :
       {"trunk", "left_foot", "right_foot", "left_hand", "right_hand", "left_shoulder", "right_shoulder"}) {
    EXPECT_THAT(complaint_with("parts." + part, std::string("nobody")),
                AllOf(HasSubstr("mighty.xml"), HasSubstr("nobody")));
  }
  EXPECT_THAT(complaint_with("home_deg.left_tentacle", 3.0), HasSubstr("left_tentacle"));
  EXPECT_THAT(complaint_with("home_deg.left_elbow_flexion", 170.0), HasSubstr("left_elbow_flexion"));
  EXPECT_THAT(complaint_with("drive.gains[0].joints[0]", std::string("left_tentacle")), HasSubstr("left_tentacle"));
  EXPECT_THAT(complaint_with("parts.left_foot", std::string("imu")), HasSubstr("imu"));
}

TEST(Profile, NamesAFileThatIsNotOne) {
  EXPECT_THAT(complaint("nobody"), AllOf(HasSubstr("nobody"), HasSubstr("robots")));
  EXPECT_THAT(complaint("/no/such/place.toml"), HasSubstr("/no/such/place.toml"));
  const std::string whole = text_of(kWhole);
  // Cut off anywhere, or with a stray character, it is either not TOML or not a profile.
  std::mt19937_64 random(21);
  for (int trial = 0; trial < 100; ++trial) {
    const std::string cut = whole.substr(0, random() % (whole.size() - 400));
    EXPECT_THAT(complaint(write("baton_cut.toml", cut)), HasSubstr("baton_cut.toml"));
  }
  EXPECT_THAT(complaint(write("baton_broken.toml", "name = \"x\"\n[stance\n")),
              AllOf(HasSubstr("baton_broken.toml"), HasSubstr("line 2")));
  EXPECT_THAT(complaint(write("baton_twice.toml", "name = 1\nname = 2\n")), HasSubstr("line 2"));
  EXPECT_THAT(complaint(write("baton_binary.toml", std::string("\0\xff\xfe\x80", 4))), HasSubstr("baton_binary.toml"));
  const auto folder = std::filesystem::path(test::temp_folder()) / "baton_folder.toml";
  std::filesystem::create_directories(folder);
  EXPECT_THAT(complaint(folder), HasSubstr("baton_folder.toml"));
  EXPECT_THAT(complaint_with("model", std::string("nowhere.xml")), HasSubstr("nowhere.xml"));
  const auto not_a_model = write("baton_not_a_model.xml", "<mujoco><worldbody>");
  EXPECT_THAT(complaint_with("model", not_a_model.string()), HasSubstr("baton_not_a_model.xml"));
}

/// mighty's model with a change, under mighty's profile.
std::string complaint_of_model(const std::vector<std::pair<std::string, std::string>>& changes) {
  std::string text = text_of(kMighty / "mighty.xml");
  for (const auto& [from, to] : changes) {
    const std::size_t at = text.find(from);
    if (at == std::string::npos) {
      ADD_FAILURE() << "the model has no " << from;
      return "";
    }
    text.replace(at, from.size(), to);
  }
  const std::size_t keys = text.find("<keyframe>");  // poses of the joints that there were
  text.erase(keys, text.find("</keyframe>") + std::string("</keyframe>").size() - keys);
  const auto file = write("baton_model.xml", text);
  const std::string message = complaint_with("model", file.string());
  EXPECT_THAT(message, HasSubstr("baton_model.xml"));
  return message;
}

TEST(RobotModelInput, NamesWhatAModelLacks) {
  EXPECT_THAT(complaint_of_model({{" range=\"0 1.7453293\"", ""}}),
              AllOf(HasSubstr("left_knee_flexion"), HasSubstr("range")));
  EXPECT_THAT(
      complaint_of_model({{"name=\"left_knee_flexion\" class", "name=\"left_knee_flexion\" type=\"slide\" class"}}),
      AllOf(HasSubstr("left_knee_flexion"), HasSubstr("hinge")));
  EXPECT_THAT(complaint_of_model(
                  {{" actuatorfrcrange=\"-1.31 1.31\"", ""},
                   {"<motor name=\"left_elbow_rotation\" joint=\"left_elbow_rotation\" class=\"re_max17\"/>", ""}}),
              AllOf(HasSubstr("left_elbow_rotation"), HasSubstr("torque")));
  EXPECT_THAT(complaint_of_model({{"name=\"left_sole_col\" class=\"sole\"",
                                   "name=\"left_sole_col\" class=\"sole\" contype=\"0\" conaffinity=\"0\""}}),
              AllOf(HasSubstr("left_ankle_abduction"), HasSubstr("stand")));
  EXPECT_THAT(complaint_of_model({{"mass=\"2.2450703\"", "mass=\"nan\""}}), HasSubstr("baton_model.xml"));
  EXPECT_THAT(complaint_of_model({{"axis=\"0 -1 0\"", "axis=\"0 0 0\""}}), HasSubstr("left_hip_flexion"));
}

}  // namespace
}  // namespace baton
