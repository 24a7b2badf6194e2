/// The ways back by the program: what a script makes of them, and what plan, report and log say.
#include <gmock/gmock.h>

#include <cmath>
#include <utility>

#include "app/app.hpp"
#include "app/outputs.hpp"
#include "baton/ik/stand.hpp"
#include "baton/input/script.hpp"
#include "baton/run/simulation.hpp"
#include "tests/support/scratch.hpp"

namespace baton {
namespace {

using nlohmann::json;
using test::Outcome;
using test::run;
using test::Scratch;
using testing::HasSubstr;
using testing::Not;

const std::string kWalkForward = R"({"t": 0.2, "guide": "trunk", "axes": [1, 0, 0, 0, 0, 0]}
{"t": 2}
)";
/// Onto the other foot.
const std::string kThreeRefusals = R"({"t": 0.2, "guide": "left_foot", "axes": [0, -1, 0, 0, 0, 0]}
{"t": 0.6}
{"t": 0.8, "axes": [0, -0.9, 0, 0, 0, 0]}
{"t": 1.2}
{"t": 1.4, "axes": [0, -1, 0, 0, 0, 0]}
{"t": 1.8}
)";

/// The report of a script on the ideal robot, and what was logged.
std::pair<json, std::string> drive(const std::string& script, const std::string& seconds,
                                   const std::string& on_limit = "shrink", const std::string& gait = "stop") {
  const Scratch scratch;
  const Outcome outcome = run({"drive", "--on", "ideal", "--world", "flat", "--fast", "--seconds", seconds,
                               "--on-limit", on_limit, "--gait", gait, "--input",
                               "script:" + scratch.write("s.jsonl", script), "--report", scratch.path("r.json")});
  EXPECT_EQ(outcome.code, app::kDone) << outcome.err;
  return {scratch.json("r.json"), outcome.err};
}

json plan(const std::string& script) {
  const Scratch scratch;
  const Outcome outcome = run({"plan", scratch.write("s.jsonl", script), "--gait", "stop"});
  EXPECT_EQ(outcome.code, app::kDone) << outcome.err;
  return json::parse(outcome.out)["segments"];
}

double distance(const json& a, const json& b) {
  double sum = 0.0;
  for (std::size_t i = 0; i < 3; ++i)
    sum += std::pow(a[i].get<double>() - b[i].get<double>(), 2);
  return std::sqrt(sum);
}

int times(const std::string& words, const std::string& text) {
  int n = 0;
  for (auto at = text.find(words); at != std::string::npos; at = text.find(words, at + 1))
    ++n;
  return n;
}

TEST(Recall, RetraceGoesBackToTheStartAndIsRefusedThere) {
  const json start = drive(R"({"t": 0})", "0.1").first["final"];
  const json there = drive(kWalkForward, "4").first["final"];
  EXPECT_GT(distance(start["com"], there["com"]), 0.05);
  const auto [report, log] = drive(kWalkForward + R"({"t": 4, "retrace": true})", "12");
  for (const char* part : {"left_foot", "right_foot", "left_hand", "right_hand", "trunk"})
    EXPECT_LT(distance(start[part]["p"], report["final"][part]["p"]), 1e-3) << part;
  EXPECT_EQ(report["segments"]["refused"], json({{"no_history", 1}}));
  EXPECT_EQ(report["commands"]["given"], 1) << "a way back is no command of the stick";
  EXPECT_EQ(report["commands"]["moved"], 1);
}

TEST(Recall, AFlowingWalkIsRetracedWholeFromRestToRest) {
  const json start = drive(R"({"t": 0})", "0.1").first["final"];
  const auto [walk, ignored] = drive(kWalkForward, "4", "shrink", "flow");
  EXPECT_GT(distance(start["com"], walk["final"]["com"]), 0.1);
  EXPECT_GE(walk["segments"]["committed"], 4);
  // One way back, over all motions that flowed into each other.
  const std::string back = kWalkForward + R"({"t": 4, "retrace": true})" + "\n";
  const auto [report, log] = drive(back, "12", "shrink", "flow");
  for (const char* part : {"left_foot", "right_foot", "left_hand", "right_hand", "trunk"})
    EXPECT_LT(distance(start[part]["p"], report["final"][part]["p"]), 1e-3) << part;
  EXPECT_EQ(report["segments"]["committed"].get<int>(), walk["segments"]["committed"].get<int>() + 1);
  // In two presses, with a rest on the way.
  const std::string pressed = back + R"({"t": 4.1})" + "\n";
  const auto [part_way, ignored_too] = drive(pressed, "12", "shrink", "flow");
  EXPECT_GT(distance(part_way["final"]["com"], start["com"]), 0.02);
  EXPECT_LT(distance(part_way["final"]["com"], start["com"]), distance(walk["final"]["com"], start["com"]) - 0.02);
  const auto [twice, nor_that] = drive(pressed + R"({"t": 7, "retrace": true})", "12", "shrink", "flow");
  EXPECT_LT(distance(twice["final"]["com"], start["com"]), 1e-3);
}

/// In physics, where soles sink and slide on every step: a stick held for some time, a rest, and the way back.
class RecallInPhysics : public testing::Test {
 protected:
  explicit RecallInPhysics(const std::string& world = "flat") : world_(World::load(world)) {}

  void lead(int axis, double seconds) {
    Command ahead;
    ahead.axes[axis] = 1.0;
    while (session_.t() < seconds)
      session_.step(ahead);
    while (!session_.resting())
      session_.step({});
  }
  /// As far as it leads.
  void go_back() {
    Command back;
    back.recall = Recall::retrace;
    while (navigator_.history() > 0 || navigator_.motion() != nullptr) {
      session_.step(back);
      if (std::exchange(motions_, navigator_.committed()) != navigator_.committed()) {
        verified_ = navigator_.anchor();
        ++ways_;
      }
      const Vec3& com = navigator_.sample().com;
      farthest_ = std::max(farthest_, (navigator_.anchor() * com - verified_ * com).norm());
      ASSERT_FALSE(navigator_.disturbed()) << session_.t();
      ASSERT_TRUE(!navigator_.refusal() || navigator_.refusal()->reason == Reason::no_history);
    }
  }
  [[nodiscard]] Vec2 place() const { return session_.truth()->q.head<2>(); }

  const RobotModel robot_ = RobotModel::load("mighty");
  const World world_;
  Simulation simulation_{robot_, world_, Simulation::On::sim};
  Session& session_ = simulation_.session();
  const Navigator& navigator_ = session_.navigator();
  long motions_ = 0;
  int ways_ = 0;           ///< motions back, with halts
  Pose verified_;          ///< where the planning frame was when a motion back was verified
  double farthest_ = 0.0;  ///< that it has been from there [m]
};

class RecallByEdges : public RecallInPhysics {
 protected:
  RecallByEdges() : RecallInPhysics("room") {}
};

TEST_F(RecallInPhysics, ALongWalkIsRetraced) {  // refused once: the frame had gone up by what soles sink on each step
  lead(0, 15.0);
  EXPECT_GT(place().x(), 1.0);
  EXPECT_LT(std::abs(navigator_.anchor().p.z()), 5e-4);
  go_back();
  EXPECT_LT(place().norm(), 0.05);
}

TEST_F(RecallInPhysics, AWayBackIsAsSteadyAsTheWay) {
  // Soles slid on its steps, once, until the legs could not make up for it.
  lead(5, 60.0);
  go_back();
  EXPECT_LT(place().norm(), 0.05);
}

TEST_F(RecallByEdges, TheWayBackIsVerifiedAgainBeforeSolesSlideOffTheirMargin) {
  // Soles slid by up to 10 mm, once, and steps back were put over edges.
  lead(5, 40.0);
  go_back();
  EXPECT_GT(ways_, 1);
  EXPECT_LT(farthest_, robot_.profile().margin.edge);
  EXPECT_LT(place().norm(), 0.05);
}

TEST_F(RecallInPhysics, FarFromTheOriginATurnIsNoSlip) {
  // In 30 m of walking 120 slips were told of, once, and ways back lost.
  VecX q = session_.truth()->q;
  q[0] += 30.0;
  Simulation far_simulation(robot_, world_, Simulation::On::sim, {.start = posture_of(robot_, q)});
  Session& far = far_simulation.session();
  Command ahead;
  ahead.axes << 1, 0, 0, 0, 0, 0.3;
  while (far.t() < 15.0)
    far.step(ahead);
  EXPECT_FALSE(far.fallen());
  EXPECT_GT(far.navigator().committed(), 30);
  EXPECT_EQ(far.navigator().slips(), 0);
}

TEST(Recall, WhoIsPushedOffARestOnTheWayBackGoesBackNoMore) {  // the step that caught it was once added to another way
  const RobotModel robot = RobotModel::load("mighty");
  const World world = World::load("flat");
  const auto stick = [](double t) {
    Command command;
    if (t < 3.0) command.axes[0] = 1.0;
    if (t > 4.0 && t < 5.0) command.recall = Recall::retrace;
    return command;
  };
  double halts = 0.0;
  const auto halting = [](const Navigator& navigator, bool before) {  // a motion back, let go of, has been replaced
    return before && navigator.motion() != nullptr && !navigator.motion()->retraces;
  };
  const auto walk = [&](const Plant& plant) {
    SimulatedRobot::Parameters parameters;
    parameters.plant = plant;
    Simulation simulation(robot, world, Simulation::On::sim, {.physics = parameters});
    Session& session = simulation.session();
    const Navigator& navigator = session.navigator();
    bool goes_back = false;
    bool halted = false;
    int caught_then = 0;
    while (session.t() < 7.0 && !session.fallen()) {
      const long caught = navigator.caught();
      session.step(stick(session.t()));
      if (!halted && halting(navigator, goes_back) && navigator.caught() == caught) {
        halted = true;
        if (halts == 0.0) halts = session.t();
      }
      if (halted && navigator.motion() == nullptr) halted = false;
      if (halted && navigator.caught() > caught) {
        ++caught_then;
        session.step({});
        EXPECT_EQ(navigator.history(), 0u);
        halted = false;
      }
      goes_back = navigator.motion() != nullptr && navigator.motion()->retraces;
    }
    Command back;
    back.recall = Recall::retrace;
    while (session.t() < 9.0 && !session.fallen())
      session.step(back);
    EXPECT_FALSE(session.fallen()) << session.truth()->fall;
    return caught_then;
  };
  EXPECT_EQ(walk({}), 0);
  ASSERT_GT(halts, 5.0);
  int caught = 0;
  for (double t = halts - 0.06; t < halts + 0.2; t += 0.01) {
    Plant plant;
    plant.pushes = {{t, 0.05, Vec3(1.5, 0, 0)}};
    caught += walk(plant);
  }
  EXPECT_GT(caught, 2);
}

TEST(Recall, RetraceGoesAsFarAsItCanWhereAFootholdIsLost) {
  // Down the room's steps and on to the wall: the estimate is off by more than the edges' margins when it is back
  // there, on some plants.
  const Scratch scratch;
  const std::string script = scratch.write("s.jsonl", R"({"t": 0.1, "guide": "trunk", "axes": [1, 0, 0, 0, 0, 0]}
{"t": 11.1}
{"t": 14, "retrace": true}
)");
  int lost = 0;
  int far = 0;
  for (const char* seed : {"2", "3", "4", "6"}) {
    const auto after = [&](const char* seconds) {
      const Outcome outcome = run({"drive", "--world", "room", "--plant", "real", "--seed", seed, "--fast", "--seconds",
                                   seconds, "--input", "script:" + script, "--report", scratch.path("r.json")});
      EXPECT_EQ(outcome.code, app::kDone) << outcome.out << outcome.err;
      return scratch.json("r.json");
    };
    const auto x = [](const json& report) { return report["final"]["com"][0].get<double>(); };
    const json out = after("14");
    const double there = x(out);
    EXPECT_GT(there, 0.5) << "beyond the steps";
    const json back = after("34");
    far += there - x(back) > 0.4 ? 1 : 0;
    if (x(back) < 0.05) continue;  // all the way
    ++lost;
    const auto reasons = [](const json& report) {
      int count = 0;
      for (const char* kind : {"shrunk", "refused"}) {
        for (const json& times : report["segments"][kind])
          count += times.get<int>();
      }
      return count;
    };
    EXPECT_GT(reasons(back), reasons(out)) << seed << ": it says why no farther";
  }
  EXPECT_GE(far, 2);
  EXPECT_GE(lost, 1);
}

TEST(Recall, RetraceEndsWhenItIsLetGo) {
  const double there = drive(kWalkForward, "4").first["final"]["com"][0];
  const double back =
      drive(kWalkForward + R"({"t": 4, "retrace": true})" + "\n" + R"({"t": 4.1})", "12").first["final"]["com"][0];
  EXPECT_LT(back, there - 0.005);
  EXPECT_GT(back, 0.02) << "one motion back, not all of them";
}

TEST(Recall, HomeStepsToTheStanceThatItBeganIn) {
  const std::string apart = R"({"t": 0.2, "guide": "left_foot", "axes": [1, 0.5, 0, 0, 0, 0]}
{"t": 0.4, "guide": "left_hand"}
{"t": 1.5, "axes": [1, 0, 1, 0, 0, 0]}
{"t": 2}
)";
  const json start = drive(R"({"t": 0})", "0.1").first["final"];
  const json there = drive(apart, "4").first["final"];
  const auto [report, log] = drive(apart + R"({"t": 4, "home": true})", "12");
  const json& final = report["final"];
  const auto across = [](const json& of, int i) {
    return of["left_foot"]["p"][i].get<double>() - of["right_foot"]["p"][i].get<double>();
  };
  EXPECT_GT(std::abs(across(there, 0)), 0.01);
  EXPECT_NEAR(across(final, 0), 0.0, 1e-3);
  EXPECT_NEAR(across(final, 1), across(start, 1), 1e-3);
  EXPECT_NEAR(final["com"][2], start["com"][2], 1e-3);
  EXPECT_EQ(report["segments"]["refused"], json::object());
}

TEST(Recall, StopComesToRestSoonerThanLettingGo) {
  const auto resting_from = [](const std::string& stop) {
    const Scratch scratch;
    const std::string script =
        scratch.write("s.jsonl", kWalkForward + R"({"t": 3, "axes": [1, 0, 0, 0, 0, 0]})" + "\n" + stop);
    const Outcome outcome = run({"drive", "--on", "ideal", "--world", "flat", "--fast", "--seconds", "5", "--input",
                                 "script:" + script, "--trace", scratch.path("t.csv")});
    EXPECT_EQ(outcome.code, app::kDone) << outcome.err;
    const auto table = scratch.table("t.csv");
    EXPECT_EQ(table.front()[3], "phase");
    double rest = 0.0;
    for (std::size_t k = 1; k < table.size(); ++k) {
      if (table[k][3] != "hold") rest = std::stod(table[k][0]);
    }
    return rest;
  };
  const double let_go = resting_from(R"({"t": 4.1})");
  const double stopped = resting_from(R"({"t": 4.1, "axes": [1, 0, 0, 0, 0, 0], "stop": true})");
  EXPECT_GT(stopped, 4.1);
  EXPECT_LT(stopped, let_go - 0.1);
}

TEST(Recall, ThreeRefusalsInARowAreSaidOnceUntilAMotionIsMade) {
  const std::string said = "left foot: refused 3 times in a row; another part may move";
  const auto [report, log] = drive(kThreeRefusals, "2", "discard");
  ASSERT_EQ(report["segments"]["committed"], 0) << "the commands are to be refused";
  EXPECT_EQ(times(said, log), 1) << log;
  EXPECT_THAT(log, HasSubstr("home"));
  EXPECT_THAT(log, Not(HasSubstr("retrace"))) << "there is nothing to retrace";

  const std::string more = kThreeRefusals + R"({"t": 2, "axes": [0, -0.8, 0, 0, 0, 0]}
{"t": 2.4, "guide": "trunk"}
{"t": 3, "axes": [1, 0, 0, 0, 0, 0]}
{"t": 3.2, "guide": "left_foot"}
)";
  EXPECT_EQ(times(said, drive(more, "6", "discard").second), 1);
  std::string again = more;
  for (const char* t : {"7", "8", "9"})
    again += std::string(R"({"t": )") + t + R"(, "axes": [0, -1, 0, 0, 0, 0]})" + "\n" + R"({"t": )" + t + ".5}\n";
  const std::string both = drive(again, "10", "discard").second;
  EXPECT_EQ(times(said, both), 2) << both;
  EXPECT_EQ(times("retrace", both), 1) << "by then there is something to retrace";
}

TEST(Recall, ThePlanTellsWhatWasShrunkAndWhatRetraces) {
  const std::string outward = R"({"t": 0.2, "guide": "left_foot", "axes": [0, 1, 0, 0, 0, 0]}
{"t": 6, "retrace": true}
)";
  int shrunk = 0;
  int back = 0;
  std::map<std::string, int> reasons;
  for (const json& segment : plan(outward)) {
    if (segment.contains("refused")) continue;
    back += segment["retraces"].get<bool>() ? 1 : 0;
    if (segment["limit"].is_null()) continue;
    ++shrunk;
    ++reasons[segment["limit"]["reason"].get<std::string>()];
    EXPECT_FALSE(segment["retraces"].get<bool>());
    for (const char* key : {"reason", "part", "value", "limit", "where"})
      EXPECT_TRUE(segment["limit"].contains(key)) << key;
    EXPECT_EQ(segment["limit"]["part"], "left_foot");
  }
  EXPECT_GE(shrunk, 1) << "the last step outward is only a part of what was asked";
  EXPECT_GE(back, 1);
  const json counted = drive(outward, "7").first["segments"]["shrunk"];
  EXPECT_EQ(counted, json(reasons)) << "the report counts the same";
}

TEST(Recall, AScriptThatIsWrittenIsReadTheSame) {
  std::string text;
  for (const Recall recall : {Recall::none, Recall::retrace, Recall::home}) {
    Command command;
    command.recall = recall;
    text += script_line(static_cast<double>(recall), command) + "\n";
  }
  Script script = Script::parse(text, "written");
  for (const Recall recall : {Recall::none, Recall::retrace, Recall::home})
    EXPECT_EQ(script.read(static_cast<double>(recall)).recall, recall);
}

}  // namespace
}  // namespace baton
