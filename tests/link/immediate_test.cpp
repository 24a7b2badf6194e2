/// The robot's end for a robot that moves by itself: targets are written as they come, and its servos can be set.
#include <gmock/gmock.h>

#include "baton/link/remote_robot.hpp"
#include "baton/link/robot_server.hpp"
#include "tests/support/robots.hpp"

namespace baton::link {
namespace {

using testing::HasSubstr;
using Clock = RobotServer::Clock;

/// Stands still, and keeps what it was told.
class StillRobot : public Robot {
 public:
  explicit StillRobot(Eigen::Index n) : n_(n) {}

  Measurement read() override {
    Measurement measured;
    measured.q = measured.dq = measured.torque = VecX::Zero(n_);
    return measured;
  }
  void write(const JointTarget& target) override { written.push_back(target); }
  void reset() override {}

  std::vector<JointTarget> written;

 private:
  Eigen::Index n_;
};

/// A driver that says what it is told, in the thread of the server.
struct Immediate : testing::Test {
  void say(Type type, const std::string& body = "") {
    driver.send(framed(type, body), Socket::Time(1000));
    serve();
  }
  void serve() {
    for (int i = 0; i < 5; ++i)
      server.serve(Socket::Time(5));
  }
  /// The last message of a type that came, if any.
  std::optional<Message> hear(Type type) {
    std::optional<Message> last;
    try {
      while (driver.receive(stream.bytes(), Socket::Time(20))) {
      }
    } catch (const LinkError&) {  // closed, after what it has said
    }
    while (std::optional<Message> message = stream.next()) {
      if (message->type == type) last = std::move(message);
    }
    return last;
  }
  Target target(std::uint64_t sequence, double angle) const {
    return {sequence, VecX::Constant(n, angle), VecX::Constant(n, 0.1), VecX::Zero(n)};
  }

  const RobotModel& model = test::robot("mighty");
  Eigen::Index n = model.nv() - 6;
  StillRobot robot{n};
  Clock::time_point now{};
  std::optional<std::string> no_servos;
  std::optional<Start> started;
  RobotServer server{model,
                     robot,
                     {.listen = {"127.0.0.1", 0},
                      .real_time = true,
                      .immediate = true,
                      .set_servos =
                          [this](const Start& start) {
                            started = start;
                            return no_servos;
                          },
                      .now = [this] { return now; }}};
  Socket driver = Socket::connect(server.address(), Socket::Time(1000));
  Stream stream;
};

TEST_F(Immediate, ATargetIsWrittenWhenItComesAndOnce) {
  say(Type::hello, encode(Hello{}));
  say(Type::start, encode(start_of(model)));
  ASSERT_TRUE(hear(Type::measurement));
  EXPECT_TRUE(robot.written.empty()) << "what it did before goes on until the first target";
  say(Type::target, encode(target(0, 0.01)));
  ASSERT_EQ(robot.written.size(), 1U);
  EXPECT_EQ(robot.written[0].q[0], 0.01);
  EXPECT_EQ(robot.written[0].dq[0], 0.1);
  now += std::chrono::milliseconds(12);  // two ticks
  serve();
  EXPECT_EQ(robot.written.size(), 1U);
  EXPECT_EQ(decode_reading(hear(Type::measurement)->body, n).sequence, 2U);
  say(Type::target, encode(target(2, 0.02)));
  ASSERT_EQ(robot.written.size(), 2U);
  say(Type::target, encode(target(2, 0.03)));
  EXPECT_EQ(robot.written.size(), 2U) << "a second answer to the same measurement is rejected";
}

TEST_F(Immediate, NothingIsWrittenWhileDamped) {
  say(Type::hello, encode(Hello{}));
  say(Type::start, encode(start_of(model)));
  server.damp("by a test");
  say(Type::target, encode(target(0, 0.01)));
  EXPECT_TRUE(robot.written.empty());
}

TEST_F(Immediate, TheServosAreSetAsTheDriverCountsOnThem) {
  say(Type::hello, encode(Hello{}));
  Start start = start_of(model);
  start.kp *= 0.5;  // not the profile's
  say(Type::start, encode(start));
  ASSERT_TRUE(started);
  EXPECT_EQ(started->kp, start.kp);
  EXPECT_TRUE(hear(Type::measurement));
}

TEST_F(Immediate, AndRefusedIfTheyCannotBe) {
  no_servos = "not these";
  say(Type::hello, encode(Hello{}));
  say(Type::start, encode(start_of(model)));
  const std::optional<Message> refusal = hear(Type::refusal);
  ASSERT_TRUE(refusal);
  EXPECT_EQ(decode_refusal(refusal->body).reason, "servos");
  EXPECT_EQ(decode_refusal(refusal->body).text, "not these");
}

}  // namespace
}  // namespace baton::link
