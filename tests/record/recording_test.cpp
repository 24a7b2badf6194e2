/// What a recording may hold. tests/app/replay_test.cpp has what a run makes of it.
#include "baton/record/recording.hpp"

#include <gmock/gmock.h>

#include <atomic>
#include <bit>
#include <random>

#include "baton/ik/stand.hpp"
#include "baton/model/error.hpp"
#include "baton/robot/ideal_robot.hpp"
#include "baton/run/session.hpp"
#include "tests/support/random.hpp"
#include "tests/support/recording_edit.hpp"
#include "tests/support/robots.hpp"
#include "tests/support/scratch.hpp"

namespace baton {
namespace {

using nlohmann::json;
using test::RecordingParts;
using test::Scratch;
using testing::AllOf;
using testing::HasSubstr;
using testing::Not;

std::vector<std::string> joint_names(const RobotModel& robot) {
  std::vector<std::string> names;
  for (const Joint& joint : robot.joints())
    names.push_back(joint.name);
  return names;
}

class Recording : public testing::Test {
 protected:
  explicit Recording(const std::string& state = "sensors") {
    const std::string script = scratch_.write("s.jsonl", R"({"t": 0, "axes": [1, 0, 0, 0, 0, 0]})");
    const test::Outcome outcome =
        test::run({"drive", "--on", "sim", "--world", "flat", "--fast", "--seconds", "0.02", "--state", state,
                   "--input", "script:" + script, "--record", scratch_.path("good.mcap")});
    EXPECT_EQ(outcome.code, app::kDone) << outcome.err;
    good_.emplace(scratch_.path("good.mcap"));
    EXPECT_EQ(good_->count("/baton/tick"), 4);
  }

  /// What is said of a recording; empty: nothing.
  [[nodiscard]] std::string complaint(const RecordingParts& parts) const {
    try {
      RecordingReader reader(scratch_.write("run.mcap", parts.bytes()));
      while (reader.next(joints_)) {
      }
    } catch (const InputError& error) {
      EXPECT_THAT(error.what(), AllOf(HasSubstr("run.mcap"), Not(HasSubstr("\n")), Not(HasSubstr("exception"))));
      return error.what();
    }
    return "";
  }
  /// The same with a message changed.
  [[nodiscard]] std::string complaint(const std::string& topic, std::uint32_t tick,
                                      const std::function<void(json&)>& change) const {
    RecordingParts parts = *good_;
    json message = parts.at(topic, tick).json();
    change(message);
    parts.at(topic, tick).data = message.dump();
    return complaint(parts);
  }
  template <typename Message>
  [[nodiscard]] std::string complaint_of(const std::string& topic, const std::function<void(Message&)>& change) const {
    RecordingParts parts = *good_;
    std::string& data = parts.at(topic, 2).data;
    Message message;
    ros::decode(data, message);
    change(message);
    ros::encode(data, message);
    return complaint(parts);
  }

  Scratch scratch_;
  std::optional<RecordingParts> good_;
  const std::vector<std::string> joints_ = joint_names(test::robot("mighty"));
};

class PerfectRecording : public Recording {
 protected:
  PerfectRecording() : Recording("perfect") {}
};

TEST_F(Recording, JointsAreThoseOfTheRobotInItsOrder) {
  ASSERT_EQ(complaint(*good_), "");
  using Change = std::function<void(ros::JointState&)>;
  const std::vector<std::pair<Change, std::string>> both{
      {[](auto& m) { m.name.pop_back(); }, "name has 19 members: must be a list of 20"},
      {[](auto& m) { m.name.clear(); }, "name has 0 members"},
      {[](auto& m) { std::swap(m.name[1], m.name[2]); }, "name[1] = "},
      {[](auto& m) { m.position = VecX::Zero(21); }, "position has 21 members: must be a list of 20"},
      {[](auto& m) { m.position.resize(0); }, "position has 0 members"}};
  for (const std::string topic : {"/joint_states", "/joint_targets"}) {
    for (const auto& [change, says] : both)
      EXPECT_THAT(complaint_of(topic, change), AllOf(HasSubstr("tick 2: " + topic), HasSubstr(says)));
  }
  const auto states = [&](const Change& change) { return complaint_of<ros::JointState>("/joint_states", change); };
  EXPECT_THAT(states([](auto& m) { m.velocity = VecX::Zero(19); }), HasSubstr("velocity has 19 members"));
  EXPECT_THAT(states([](auto& m) { m.effort = VecX::Zero(1); }), HasSubstr("effort has 1 members"));
  EXPECT_EQ(states([](auto& m) { m.effort.resize(0); }), "") << "not measured";
}

TEST_F(Recording, EveryTickHasWhatAReplayNeeds) {
  for (const std::string topic :
       {"/joint_states", "/imu", "/sole/left", "/sole/right", "/joint_targets", "/baton/tick"}) {
    RecordingParts parts = *good_;
    std::erase_if(parts.messages, [&](const auto& part) { return part.topic == topic && part.sequence == 1; });
    EXPECT_THAT(complaint(parts), AllOf(HasSubstr("tick 1"), HasSubstr(topic + " is missing")));
    parts = *good_;
    const std::string data = parts.at(topic, 1).data;
    for (const std::string& other : {std::string(), data.substr(0, data.size() / 2), std::string(100, '\xff')}) {
      parts.at(topic, 1).data = other;
      EXPECT_THAT(complaint(parts), AllOf(HasSubstr("tick 1"), HasSubstr(topic)));
    }
  }
  RecordingParts parts = *good_;
  std::erase_if(parts.messages, [](const auto& part) { return part.topic == "/baton/command"; });
  EXPECT_THAT(complaint(parts), HasSubstr("tick 0: /baton/command is missing"));
  parts.messages.clear();
  EXPECT_THAT(complaint(parts), HasSubstr("ends before its first message"));
  parts = *good_;
  std::erase_if(parts.messages, [](const auto& part) { return part.topic != "/joy"; });
  EXPECT_THAT(complaint(parts), HasSubstr("holds no ticks"));
}

TEST_F(PerfectRecording, TheMeasuredRootIsThereIfTheStateIsTakenFromIt) {
  ASSERT_EQ(complaint(*good_), "");
  RecordingParts parts = *good_;
  std::erase_if(parts.messages, [](const auto& part) { return part.topic == "/baton/root" && part.sequence == 3; });
  EXPECT_THAT(complaint(parts), HasSubstr("tick 3: /baton/root is missing"));
  for (const char* key : {"position", "attitude", "velocity", "rate"}) {
    for (const json& wrong : {json(nullptr), json("x"), json(1.0), json::array({1.0}), json::object()}) {
      EXPECT_THAT(complaint("/baton/root", 2, [&](json& m) { m[key] = wrong; }),
                  AllOf(HasSubstr("tick 2: /baton/root"), HasSubstr(key)));
    }
    EXPECT_THAT(complaint("/baton/root", 2, [&](json& m) { m.erase(key); }), HasSubstr("is missing"));
    EXPECT_EQ(complaint("/baton/root", 2, [&](json& m) { m[key][1] = nullptr; }), "") << "it may be no number";
  }
}

TEST_F(Recording, AValueThatIsNotAmongTheAllowedOnesIsNamedWithThem) {
  for (const auto& [key, allowed] : {std::pair<std::string, std::string>{"recording", "must be 3"},
                                     {"on", "sim, ideal or real"},
                                     {"duration", "paper or search"},
                                     {"gait", "stop or flow"},
                                     {"on_limit", "discard or shrink"},
                                     {"state", "sensors, torques or perfect"},
                                     {"drive", "torque, pd or stiff"}}) {
    RecordingParts parts = *good_;
    parts.metadata[key] = "gallop";
    EXPECT_THAT(complaint(parts), AllOf(HasSubstr(key + " = "), HasSubstr("gallop"), HasSubstr(allowed)));
    parts.metadata.erase(key);
    EXPECT_THAT(complaint(parts), HasSubstr(key + " is missing"));
  }
  for (const char* start : {"", "x", "5", "[]", "[1, null]", "{}"}) {
    RecordingParts parts = *good_;
    parts.metadata["start"] = start;
    EXPECT_THAT(complaint(parts), HasSubstr("start")) << start;
  }
  struct Case {
    std::string topic;
    std::string key;
    std::string allowed;
  };
  for (const Case& c :
       {Case{"/baton/command", "guide", "left_hand, right_hand or trunk"},
        Case{"/baton/command", "recall", "none, retrace, home or stop"}, Case{"/baton/command", "axes", "6 numbers"},
        Case{"/baton/command", "lift", "2 numbers"}, Case{"/baton/tick", "sum", "a text"},
        Case{"/baton/tick", "age", "a number"}, Case{"/baton/tick", "attitude", "a list of 9"}}) {
    for (const json& wrong : {json(true), json(4), json(-1.5), json("gallop"), json::object(), json::array({1})}) {
      if ((wrong.is_string() && c.key == "sum") || (wrong.is_number() && c.key == "age")) continue;
      const std::string says = complaint(c.topic, 0, [&](json& m) { m[c.key] = wrong; });
      EXPECT_THAT(says, AllOf(HasSubstr("tick 0: " + c.topic), HasSubstr(c.key))) << wrong;
      EXPECT_THAT(says, HasSubstr(wrong.is_boolean() && c.key != "attitude" ? c.allowed : "must be"));
    }
    if (c.key == "attitude") continue;
    EXPECT_THAT(complaint(c.topic, 0, [&](json& m) { m.erase(c.key); }), HasSubstr(c.key + " is missing"));
  }
  for (const auto& wrong : {json::array({0, 0, 0, 0, 0, 0, 0, 0, 0.5}), json::array({0, 0, 0, 0, 0, 0, 0, 0, nullptr}),
                            json::array({0, 0, 0, 0, 0, 0, 0, 0, 18446744073709551615U})}) {
    EXPECT_THAT(complaint("/baton/tick", 1, [&](json& m) { m["attitude"] = wrong; }), HasSubstr("a whole number"));
  }
  EXPECT_EQ(complaint("/baton/tick", 1, [&](json& m) { m["age"] = nullptr; }), "") << "it may be no number";
}

TEST_F(Recording, WhatIsNoRecordingIsRefused) {
  RecordingParts parts = *good_;
  parts.metadata.clear();
  EXPECT_THAT(complaint(parts), HasSubstr("recording is missing"));
  parts = *good_;
  for (mcap::Channel& channel : parts.channels)
    channel.encoding = "xml";
  EXPECT_THAT(complaint(parts), HasSubstr("holds no ticks"));
  parts = *good_;
  for (const std::string& text : {std::string(), std::string("{}\n"), std::string("{\"baton_recording\":2}\n"),
                                  std::string(3 << 20, '\0'), parts.bytes().substr(0, 1000)}) {
    EXPECT_THROW(RecordingReader{scratch_.write("bad.mcap", text)}, InputError) << text.substr(0, 80);
  }
  EXPECT_THROW(RecordingReader{scratch_.path("none.mcap")}, InputError);
  EXPECT_THROW(RecordingReader{"/dev/zero"}, InputError);
  EXPECT_THROW(RecordingReader{"/"}, InputError);
}

/// A robot whose readings are anything.
class AnyRobot : public Robot {
 public:
  AnyRobot(const RobotModel& model, Robot& robot, std::uint64_t seed)
      : joints_(model.nv() - 6), robot_(&robot), random_(seed), turns_(seed) {}
  [[nodiscard]] Measurement read() override {
    Measurement m = robot_->read();
    for (VecX* v : {&m.q, &m.dq, &m.torque}) {
      if (random_() % 4 == 0) v->setConstant(joints_, 0.0);
      for (double& x : *v)
        x = any(x);
    }
    if (random_() % 4 == 0) m.torque.resize(0);
    if (random_() % 2 == 0) m.imu.attitude = rotation_exp(turns_.vector(2.0));
    for (double& x : m.imu.attitude.reshaped())
      x = any(x);
    for (Vec3* v : {&m.imu.rate, &m.imu.acceleration, &m.sole.left.force, &m.sole.left.moment, &m.sole.right.force,
                    &m.sole.right.moment}) {
      for (double& x : *v)
        x = any(x);
    }
    m.age = any(m.age);
    read_.push_back(m);
    return m;
  }
  void write(const JointTarget& target) override { robot_->write(target); }
  [[nodiscard]] const std::vector<Measurement>& all() const { return read_; }

 private:
  double any(double x) {
    switch (random_() % 40) {
      case 0:
        return std::numeric_limits<double>::quiet_NaN();
      case 1:
        return -std::numeric_limits<double>::infinity();
      case 2:
        return std::bit_cast<double>(random_());
      case 3:
        return -0.0;
      default:
        return x;
    }
  }

  Eigen::Index joints_;
  Robot* robot_;
  std::mt19937_64 random_;
  test::Random turns_;
  std::vector<Measurement> read_;
};

std::vector<std::uint64_t> bits(const Measurement& m) {
  std::vector<std::uint64_t> all;
  const auto add = [&all](const auto& v) {
    for (Eigen::Index i = 0; i < v.size(); ++i)
      all.push_back(std::bit_cast<std::uint64_t>(v.data()[i]));
    all.push_back(static_cast<std::uint64_t>(v.size()));
  };
  for (const VecX* v : {&m.q, &m.dq, &m.torque})
    add(*v);
  add(m.imu.attitude);
  for (const Vec3* v : {&m.imu.rate, &m.imu.acceleration, &m.sole.left.force, &m.sole.left.moment, &m.sole.right.force,
                        &m.sole.right.moment}) {
    add(*v);
  }
  return all;
}

TEST(RecordingWriter, AnyReadingIsKeptToTheLastBit) {
  const RobotModel& model = test::robot("mighty");
  const World world = World::load("flat");
  const Posture start = stand(model, world.site("start"), model.profile().stance.com_height);
  const Scratch scratch;
  long read = 0;
  for (std::uint64_t seed = 0; seed < 20; ++seed) {
    IdealRobot ideal(model, start, model.profile().tick.period);
    AnyRobot any(model, ideal, seed);
    Session session(model, world, any, start);
    std::string bytes;
    json head{{"robot", "mighty"}, {"world", "flat"},      {"on", "ideal"},      {"duration", "paper"},
              {"gait", "flow"},    {"on_limit", "shrink"}, {"state", "sensors"}, {"drive", "pd"}};
    RecordingWriter writer(model, "test", std::make_unique<test::Memory>(bytes), head, {.live = seed % 2 == 0});
    session.add(writer);
    Command command;
    command.axes[0] = 0.1;
    for (int tick = 0; tick < 100; ++tick)
      session.step(command);
    EXPECT_EQ(writer.close(), "");
    RecordingReader reader(scratch.write("run.mcap", bytes));
    for (const Measurement& m : any.all()) {
      const auto tick = reader.next(joint_names(model));
      ASSERT_TRUE(tick);
      ASSERT_EQ(bits(tick->measurement), bits(m)) << seed << ' ' << tick->number;
      const bool same_age = tick->measurement.age == m.age;
      ASSERT_TRUE(same_age || (std::isnan(tick->measurement.age) && !std::isfinite(m.age)));
      ASSERT_TRUE(tick->command == command);
      ++read;
    }
    EXPECT_FALSE(reader.next(joint_names(model)));
  }
  EXPECT_EQ(read, 2000);
}

/// Takes nothing while it is shut.
class Gate : public mcap::Output {
 public:
  struct State {
    std::atomic<bool> open{false};
    std::atomic<int> writes{0};
    std::string bytes;
  };
  explicit Gate(State& state) : state_(&state), memory_(state.bytes) {}
  void write(std::string_view bytes, std::string_view end) override {
    state_->open.wait(false);
    memory_.write(bytes, end);
    ++state_->writes;
    state_->writes.notify_all();
  }

 private:
  State* state_;
  test::Memory memory_;
};

TEST(RecordingWriter, ADiskThatIsTooSlowCostsWholeTicksAndOneWarning) {
  const RobotModel& model = test::robot("mighty");
  const World world = World::load("flat");
  const Posture start = stand(model, world.site("start"), model.profile().stance.com_height);
  IdealRobot ideal(model, start, model.profile().tick.period);
  Session session(model, world, ideal, start);
  Gate::State gate;
  std::vector<std::string> warnings;
  const json head{{"robot", "mighty"}, {"world", "flat"},      {"on", "ideal"},      {"duration", "paper"},
                  {"gait", "flow"},    {"on_limit", "shrink"}, {"state", "sensors"}, {"drive", "pd"}};
  RecordingWriter writer(model, "test", std::make_unique<Gate>(gate), head,
                         {.live = true, .warn = [&](const std::string& why) { warnings.push_back(why); }});
  session.add(writer);
  Command command;
  command.guide = Part::left_hand;
  const int shut = 3000, all = 4000;
  for (int tick = 0; tick < shut; ++tick)
    session.step(command);
  EXPECT_EQ(warnings, std::vector<std::string>{"test: the disk is too slow: ticks are left out"});
  gate.open = true;
  gate.open.notify_all();
  const int waiting = 1 + 128;  // the head, and all chunks
  for (int writes = 0; (writes = gate.writes) < waiting;)
    gate.writes.wait(writes);
  for (int tick = shut; tick < all; ++tick)
    session.step(command);
  EXPECT_THAT(writer.close(), HasSubstr("ticks were left out, as the disk was too slow"));
  EXPECT_EQ(warnings.size(), 1U);

  const Scratch scratch;
  RecordingReader reader(scratch.write("run.mcap", gate.bytes));
  EXPECT_TRUE(reader.file().finished());
  std::vector<long> gaps;
  long next = 0, read = 0;
  while (const auto tick = reader.next(joint_names(model))) {
    EXPECT_TRUE(tick->command == command) << "it is said again after a gap";
    if (tick->number != next) gaps.push_back(next);
    next = tick->number + 1;
    ++read;
  }
  ASSERT_EQ(gaps.size(), 1U);
  EXPECT_GT(gaps[0], 2000) << "10 s are kept";
  EXPECT_LT(gaps[0], shut);
  EXPECT_EQ(next, all);
  EXPECT_LT(read, all);
}

}  // namespace
}  // namespace baton
