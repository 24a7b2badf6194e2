#include "baton/link/message.hpp"

#include <gmock/gmock.h>

#include <cstring>
#include <functional>
#include <limits>
#include <random>

#include "baton/model/error.hpp"

namespace baton::link {
namespace {

using testing::HasSubstr;

template <typename Thrower>
std::string malformed(const Thrower& thrower) {
  try {
    thrower();
  } catch (const LinkError& error) {
    return error.what();
  }
  return "";
}

/// Any bit pattern, so infinite and not-a-number too.
double any_double(std::mt19937_64& random) {
  const std::uint64_t bits = random();
  double value = 0.0;
  std::memcpy(&value, &bits, sizeof value);
  return value;
}

VecX any_vector(Eigen::Index size, std::mt19937_64& random) {
  VecX v(size);
  for (double& value : v)
    value = any_double(random);
  return v;
}

Wrench any_wrench(std::mt19937_64& random) {
  const VecX v = any_vector(6, random);
  return {v.head<3>(), v.tail<3>()};
}

Reading any_reading(Eigen::Index joints, std::mt19937_64& random) {
  Reading reading;
  reading.sequence = random();
  reading.damped = random() % 2 == 0;
  reading.battery = any_double(random);
  Measurement& m = reading.measurement;
  m.t = any_double(random);
  m.age = any_double(random);
  m.q = any_vector(joints, random);
  m.dq = any_vector(joints, random);
  if (random() % 2 == 0) m.torque = VecX::Random(joints);
  m.imu.attitude = Eigen::Map<const Mat3>(any_vector(9, random).data());
  m.imu.rate = any_vector(3, random);
  m.imu.acceleration = any_vector(3, random);
  m.sole = {any_wrench(random), any_wrench(random)};
  if (random() % 2 == 0) {
    m.root.emplace();
    m.root->pose = {any_vector(3, random), Eigen::Map<const Mat3>(any_vector(9, random).data())};
    m.root->velocity = any_vector(3, random);
    m.root->rate = any_vector(3, random);
  }
  return reading;
}

Command any_command(std::mt19937_64& random) {
  Command command;
  command.guide = kParts[random() % kParts.size()];
  command.axes = any_vector(6, random);
  command.lift = {any_double(random), any_double(random)};
  command.recall = static_cast<Recall>(random() % 4);
  return command;
}

Tick any_tick(Eigen::Index joints, std::mt19937_64& random) {
  Tick tick{any_reading(joints, random), any_command(random), random() % 2 == 0, {}, any_vector(joints, random)};
  for (std::size_t i = 0; i < random() % (Tick::kMostPlanning + 1); ++i)
    tick.planning.push_back(random() % 2 == 0 ? PlanningEvent::ask : PlanningEvent::answer);
  return tick;
}

TEST(LinkMessage, NumbersArriveBitByBitWhateverTheyAre) {
  std::mt19937_64 random(1);
  for (int run = 0; run < 2000; ++run) {
    const auto joints = static_cast<Eigen::Index>(1 + random() % 40);
    const std::string reading = encode(any_reading(joints, random));
    EXPECT_EQ(encode(decode_reading(reading, joints)), reading);
    const Target target{random(), any_vector(joints, random), any_vector(joints, random), any_vector(joints, random)};
    EXPECT_EQ(encode(decode_target(encode(target), joints)), encode(target));
    Truth truth;
    truth.t = any_double(random);
    truth.q = any_vector(joints + 7, random);
    truth.dq = any_vector(joints + 6, random);
    truth.sole = {any_wrench(random), any_wrench(random)};
    truth.touch = {random() % 2 == 0, random() % 2 == 0};
    truth.fallen = random() % 2 == 0;
    truth.fall = truth.fallen ? "left_hand touches the floor" : "";
    EXPECT_EQ(encode(decode_truth(encode(truth), joints)), encode(truth));
    EXPECT_EQ(decode_truth(encode(truth), joints).fall, truth.fall);
    const StickPosition stick{random(), any_command(random)};
    EXPECT_EQ(encode(decode_stick(encode(stick))), encode(stick));
    const Tick tick = any_tick(joints, random);
    EXPECT_EQ(encode(decode_tick(encode(tick), joints)), encode(tick));
    EXPECT_EQ(decode_tick(encode(tick), joints).planning, tick.planning);
  }
}

TEST(LinkMessage, EachFieldOfAReadingIsWhereTheDocumentSaysItIs) {
  std::mt19937_64 random(2);
  Reading reading = any_reading(2, random);
  reading.measurement.torque = Vec2(5.0, 6.0);
  reading.measurement.root.reset();
  const std::string bytes = encode(reading);
  const auto number_at = [&](std::size_t offset) {
    double value = 0.0;
    std::memcpy(&value, bytes.data() + offset, sizeof value);
    return value;
  };
  // sequence 8, state 4, faults 4; then t, age, battery, q, dq, torque, attitude by rows, rate, acceleration, soles
  ASSERT_EQ(bytes.size(), 16 + 8 * (3 + 3 * 2 + 9 + 3 + 3 + 12));
  EXPECT_EQ(number_at(16 + 8 * 7), 5.0);
  EXPECT_EQ(number_at(16 + 8 * 8), 6.0);
  const auto same = [](double a, double b) { return std::memcmp(&a, &b, sizeof a) == 0; };
  EXPECT_TRUE(same(number_at(16 + 8 * 10), reading.measurement.imu.attitude(0, 1)));
  EXPECT_TRUE(same(number_at(16 + 8 * 24), reading.measurement.sole.left.force.x()));
  EXPECT_TRUE(same(number_at(16 + 8 * 35), reading.measurement.sole.right.moment.z()));
}

TEST(LinkMessage, EachFieldOfACommandAndATickIsWhereTheDocumentSaysItIs) {
  std::mt19937_64 random(4);
  const StickPosition stick{7, {Part::trunk, Vec6::LinSpaced(1.0, 6.0), {0.25, 0.75}, Recall::stop}};
  const std::string bytes = encode(stick);
  const auto number_in = [](const std::string& body, std::size_t offset) {
    double value = 0.0;
    std::memcpy(&value, body.data() + offset, sizeof value);
    return value;
  };
  ASSERT_EQ(bytes.size(), 8U + 2 + 8 * 8);
  EXPECT_EQ(bytes[0], 7);
  EXPECT_EQ(bytes[8], 4);  // trunk
  EXPECT_EQ(bytes[9], 3);  // stop
  EXPECT_EQ(number_in(bytes, 10), 0.25);
  EXPECT_EQ(number_in(bytes, 26), 1.0);
  Tick tick = any_tick(2, random);
  tick.command = stick.command;
  tick.stale = true;
  tick.planning = {PlanningEvent::answer, PlanningEvent::ask};
  tick.target = Vec2(8.0, 9.0);
  const std::string body = encode(tick);
  EXPECT_EQ(body.substr(0, 66), bytes.substr(8));
  EXPECT_EQ(body.substr(66, 4), std::string("\1\2\1\0", 4));
  EXPECT_EQ(number_in(body, 78), 9.0);
  EXPECT_EQ(body.substr(86), encode(tick.reading));
}

TEST(LinkMessage, ACommandOfAPartOrRecallThatThereIsNotIsMalformed) {
  const std::string good = encode(StickPosition{});
  for (int value = 0; value < 256; ++value) {
    std::string part = good;
    part[8] = static_cast<char>(value);
    EXPECT_EQ(malformed([&] { (void)decode_stick(part); }).empty(), value < 5) << value;
    std::string recall = good;
    recall[9] = static_cast<char>(value);
    EXPECT_EQ(malformed([&] { (void)decode_stick(recall); }).empty(), value < 4) << value;
  }
  EXPECT_THAT(malformed([&] { (void)decode_stick(good + "x"); }), HasSubstr("a command of 75 bytes: must be 74"));
  EXPECT_THAT(malformed([&] { (void)decode_stick(good.substr(1)); }), HasSubstr("of 73 bytes: must be 74"));
}

TEST(LinkMessage, TheMannerOfNavigationIsWhatWasAskedFor) {
  for (int k = 0; k < 24; ++k) {
    const NavigationOptions asked{
        {static_cast<DurationRule>(k % 2), static_cast<OnLimit>(k / 2 % 2), static_cast<Gait>(k / 4 % 2)},
        static_cast<StateSource>(k / 8),
        k % 3 == 0};
    const Start start = decode_start(encode(Start{"pd", Vec2(1.0, 2.0), Vec2(3.0, 4.0), asked}), 2);
    const NavigationOptions read = start.navigation.value();
    EXPECT_EQ(read.modes.duration, asked.modes.duration);
    EXPECT_EQ(read.modes.on_limit, asked.modes.on_limit);
    EXPECT_EQ(read.modes.gait, asked.modes.gait);
    EXPECT_EQ(read.source, asked.source);
    EXPECT_EQ(read.hangs, asked.hangs);
  }
  const std::string bare = encode(Start{"pd", Vec2(1.0, 2.0), Vec2(3.0, 4.0)});  // for a robot that follows targets
  EXPECT_EQ(bare, R"({"drive":"pd","kd":[3.0,4.0],"kp":[1.0,2.0]})");
  EXPECT_EQ(decode_start(bare, 2).navigation.value().source, StateSource::sensors);
  EXPECT_THAT(malformed([] { (void)decode_start(R"({"drive": "pd", "kp": [1], "kd": [3], "gait": "gallop"})", 1); }),
              HasSubstr("gait"));
}

TEST(LinkMessage, AStreamIsTakenApartWhereverItIsCut) {
  std::mt19937_64 random(3);
  for (int run = 0; run < 500; ++run) {
    std::vector<Message> sent;
    std::string bytes;
    for (std::size_t i = 0; i < 1 + random() % 6; ++i) {
      const auto type = static_cast<Type>(1 + random() % 12);
      sent.push_back({type, std::string(random() % 300, static_cast<char>(random()))});
      bytes += framed(type, sent.back().body);
    }
    Stream stream;
    std::size_t received = 0;
    while (!bytes.empty()) {
      const std::size_t some = std::min<std::size_t>(1 + random() % 50, bytes.size());
      stream.bytes() += bytes.substr(0, some);
      bytes.erase(0, some);
      while (const std::optional<Message> message = stream.next()) {
        ASSERT_LT(received, sent.size());
        EXPECT_EQ(message->type, sent[received].type);
        EXPECT_EQ(message->body, sent[received].body);
        ++received;
      }
    }
    EXPECT_EQ(received, sent.size());
  }
}

TEST(LinkMessage, WhatIsNoMessageIsSaidAtOnce) {
  Stream http;
  http.bytes() = "GET / HTTP/1.1\r\n";
  EXPECT_THAT(malformed([&] { (void)http.next(); }), HasSubstr("is this a baton link?"));
  Stream unknown;
  unknown.bytes() = std::string("\x01\x00\x00\x00\x2a", 5);
  EXPECT_THAT(malformed([&] { (void)unknown.next(); }), HasSubstr("unknown type 42"));
}

TEST(LinkMessage, ABodyOfAnyOtherLengthIsRefused) {
  std::mt19937_64 random(4);
  Reading reading = any_reading(3, random);
  reading.measurement.root.reset();
  const std::string whole = encode(reading);
  const std::string target = encode(Target{1, VecX::Zero(3), VecX::Zero(3), VecX::Zero(3)});
  for (std::size_t size = 0; size < whole.size() + 200; ++size) {
    std::string body = whole;
    body.resize(size);
    const bool right = size == whole.size() || size == whole.size() + 18 * 8;  // with the root
    EXPECT_EQ(malformed([&] { (void)decode_reading(body, 3); }).empty(), right) << size;
    body.resize(std::min(size, target.size() + 50));
    EXPECT_EQ(malformed([&] { (void)decode_target(body, 3); }).empty(), body.size() == target.size());
  }
}

TEST(LinkMessage, HandshakesSurviveTheWayAndSayWhatIsWrong) {
  const Hello hello = decode_hello(encode(Hello{1, "a \"secret\" \xc3\xa9", Role::damp}));
  EXPECT_EQ(hello.token, "a \"secret\" \xc3\xa9");
  EXPECT_EQ(hello.role, Role::damp);
  EXPECT_EQ(decode_hello(R"({"baton": 1})").role, Role::drive);
  EXPECT_EQ(decode_hello(R"({"baton": 2, "role": 7})").version, 2);
  EXPECT_EQ(decode_welcome(R"({"baton": 2})").version, 2);

  const Welcome welcome = decode_welcome(encode(Welcome{1, "mighty", {"a", "b"}, 0.005, true, "sim", "room"}));
  EXPECT_EQ(welcome.joints, (std::vector<std::string>{"a", "b"}));
  EXPECT_EQ(welcome.period, 0.005);
  EXPECT_EQ(welcome.world, "room");
  EXPECT_FALSE(welcome.limits);
  Welcome limited{1, "r", {"a", "b"}, 0.005, true, "real", "flat"};
  limited.limits = {VecX::Random(2), VecX::Random(2), VecX::Random(2), VecX::Random(2)};
  const Welcome found = decode_welcome(encode(limited));
  ASSERT_TRUE(found.limits);
  EXPECT_EQ(found.limits->lower, limited.limits->lower);
  EXPECT_EQ(found.limits->upper, limited.limits->upper);
  EXPECT_EQ(found.limits->speed, limited.limits->speed);
  EXPECT_EQ(found.limits->torque, limited.limits->torque);
  limited.settings = {{"plant", "real"}, {"scenario", "push\n"}};
  EXPECT_EQ(decode_welcome(encode(limited)).settings,
            (std::map<std::string, std::string>{{"plant", "real"}, {"scenario", "push "}}));
  limited.limits->speed.resize(1);
  EXPECT_THROW((void)decode_welcome(encode(limited)), Malformed);

  const Start start = decode_start(encode(Start{"pd", Vec2(1, 2), Vec2(3, 4)}), 2);
  EXPECT_EQ(start.kd[1], 4.0);

  const std::vector<std::pair<std::function<void()>, std::string>> cases{
      {[] { (void)decode_hello("{"); }, "hello"},
      {[] { (void)decode_hello("{}"); }, "baton"},
      {[] { (void)decode_hello(R"({"baton": 1.0})"); }, "baton"},
      {[] { (void)decode_hello(R"({"baton": "1"})"); }, "baton"},
      {[] { (void)decode_hello(R"({"baton": 1, "role": "king"})"); }, "role"},
      {[] { (void)decode_welcome(R"({"baton": 1, "robot": "r", "joints": [1], "period": 1, "lock_step": true})"); },
       "joints"},
      {[] { (void)decode_welcome(R"({"baton": 1, "robot": "r", "joints": ["a"], "period": 0, "lock_step": true})"); },
       "period"},
      {[] { (void)decode_start(R"({"drive": "pd", "kp": [1, 2], "kd": [1]})", 2); }, "kd"},
      {[] { (void)decode_start(R"({"drive": "fast", "kp": [1], "kd": [1]})", 1); }, "drive"},
  };
  for (const auto& [read, named] : cases)
    EXPECT_THAT(malformed(read), HasSubstr(named));
}

TEST(LinkMessage, WhatTheOtherEndSaysDoesNothingToATerminal) {
  EXPECT_EQ(decode_text(encode_text("red \x1b[31m\nnext")), "red  [31m next");
  EXPECT_EQ(decode_text(encode_text("bad \xff")), "bad \xef\xbf\xbd");  // no UTF-8
  const std::string why = malformed([] { (void)decode_hello("{\"baton\": \"\x1b[2J\"}"); });
  EXPECT_FALSE(why.empty());
  EXPECT_EQ(why.find('\x1b'), std::string::npos);
}

TEST(LinkMessage, AnAddressIsReadOrRefused) {
  EXPECT_EQ(Address::parse("tcp://robot.local:7447").host, "robot.local");
  EXPECT_EQ(Address::parse("127.0.0.1:7").port, 7);
  EXPECT_EQ(Address::parse("[::1]:80").text(), "tcp://[::1]:80");
  for (const char* bad : {"", "tcp://", "host", ":1", "host:", "host:x", "host:1x", "host:65536", "host:-1", "::1:80"})
    EXPECT_THROW((void)Address::parse(bad), InputError) << bad;
  EXPECT_TRUE(Address::parse("127.0.0.1:0").loopback());
  EXPECT_TRUE(Address::parse("[::1]:0").loopback());
  EXPECT_FALSE(Address::parse("0.0.0.0:0").loopback());
}

}  // namespace
}  // namespace baton::link
