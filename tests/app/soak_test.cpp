#include <fmt/format.h>
#include <gmock/gmock.h>

#include <cmath>
#include <set>

#include "app/episode.hpp"
#include "baton/ik/stand.hpp"
#include "baton/input/script.hpp"
#include "tests/support/robots.hpp"
#include "tests/support/scratch.hpp"

namespace baton::app {
namespace {

using test::Outcome;
using test::run;
using test::Scratch;
using testing::HasSubstr;

constexpr double kPeriod = 0.005;

Course course(Session::On on, std::uint64_t seed, double seconds, Modes modes = {}) {
  Course course;
  course.on = on;
  course.seed = seed;
  course.seconds = seconds;
  course.modes = modes;
  return course;
}

bool same(const Command& a, const Command& b) {
  return sanitised(a) == sanitised(b) && std::signbit(a.axes[0]) == std::signbit(b.axes[0]);
}

TEST(Stick, TheSameSeedGivesTheSameStick) {
  Stick a(7, kPeriod);
  Stick b(7, kPeriod);
  Stick c(8, kPeriod);
  int differs = 0;
  for (int k = 0; k < 20000; ++k) {
    const Command command = a.next();
    ASSERT_TRUE(same(command, b.next()));
    differs += same(command, c.next()) ? 0 : 1;
  }
  EXPECT_GT(differs, 10000);
  EXPECT_NE(mixed_seed(1, 2), mixed_seed(2, 1));
  // As on every computer.
  EXPECT_EQ(mixed_seed(1, 2), 13608149317741381227ULL);
}

TEST(Stick, IsDeflectedMostOfTheTimeAndKnowsEveryStyle) {
  std::set<Stick::Style> styles;
  std::set<Part> parts;
  int not_a_number = 0;
  int denormal = 0;
  int out_of_range = 0;
  int both_levers = 0;
  int switches = 0;
  double pinned = 0.0;
  int centred = 0;
  for (std::uint64_t seed = 0; seed < 40; ++seed) {
    Stick stick(seed, kPeriod);
    int deflected = 0;
    Command last;
    double still = 0.0;
    constexpr int kTicks = 24000;
    for (int k = 0; k < kTicks; ++k) {
      const Command command = stick.next();
      styles.insert(stick.style());
      parts.insert(command.guide);
      deflected += Stick::deflected(command) ? 1 : 0;
      for (const double axis : command.axes) {
        not_a_number += std::isnan(axis) ? 1 : 0;
        denormal += axis != 0.0 && std::abs(axis) < 1e-300 ? 1 : 0;
        out_of_range += std::abs(axis) > 1.0 ? 1 : 0;
      }
      both_levers += command.lift.left > 0.1 && command.lift.right > 0.1 ? 1 : 0;
      switches += command.guide == last.guide ? 0 : 1;
      still = same(command, last) ? still + kPeriod : 0.0;
      pinned = std::max(pinned, still);
      last = command;
    }
    EXPECT_GE(deflected, 7 * kTicks / 10) << seed;
    centred += kTicks - deflected;
  }
  EXPECT_EQ(styles.size(), Stick::kNames.size());
  EXPECT_EQ(parts.size(), kParts.size());
  EXPECT_GT(not_a_number, 1000);
  EXPECT_GT(denormal, 1000);
  EXPECT_GT(out_of_range, 1000);
  EXPECT_GT(both_levers, 10000);
  EXPECT_GT(switches, 20000);
  EXPECT_GT(pinned, 100.0);
  EXPECT_GT(centred, 10000);
}

TEST(Stick, AsAScriptItIsTheSame) {
  for (std::uint64_t seed = 0; seed < 10; ++seed) {
    constexpr long kTicks = 4000;
    const auto read = [stick = Stick(seed, kPeriod)]() mutable { return stick.next(); };
    Script script = Script::parse(stick_script(read, kPeriod, kTicks), "stick");
    Stick stick(seed, kPeriod);
    for (long k = 0; k < kTicks; ++k) {
      const Command command = stick.next();
      ASSERT_TRUE(same(command, script.read(static_cast<double>(k) * kPeriod))) << seed << " " << k;
    }
    EXPECT_TRUE(script.read(kTicks * kPeriod) == Command{});
  }
}

TEST(FailureRate, IsTheExactBound) {
  EXPECT_NEAR(failure_rate_95(0, 1), 0.95, 1e-12);
  EXPECT_NEAR(failure_rate_95(0, 59), 0.0495, 1e-4);
  EXPECT_NEAR(failure_rate_95(0, 1000000), 2.99573e-6, 1e-10);
  EXPECT_NEAR(failure_rate_95(1, 100), 0.0465598, 1e-6);
  EXPECT_NEAR(failure_rate_95(5, 50), 0.1988330, 1e-6);
  EXPECT_NEAR(failure_rate_95(10, 1000000), 1.6962160e-5, 1e-10);
  EXPECT_EQ(failure_rate_95(0, 0), 1.0);
  EXPECT_EQ(failure_rate_95(3, 3), 1.0);
}

/// A report without what depends on the clock on the wall.
nlohmann::json timeless(nlohmann::json report) {
  EXPECT_TRUE(report.contains("wall"));
  report.erase("wall");
  return report;
}

/// A trace that ended at the episode's last tick, in the same configuration.
void expect_same_end(const std::vector<std::vector<std::string>>& rows, const EpisodeResult& episode) {
  ASSERT_EQ(static_cast<long>(rows.size()) - 1, episode.ticks);
  const auto first = std::find(rows.front().begin(), rows.front().end(), "qpos_0") - rows.front().begin();
  for (Eigen::Index i = 0; i < episode.q.size(); ++i)
    EXPECT_NEAR(std::stod(rows.back()[static_cast<std::size_t>(first + i)]), episode.q[i], 1e-9) << i;
}

TEST(Soak, TheResultDoesNotDependOnJobsOrPauses) {
  const Scratch scratch;
  const auto soak = [&](const std::string& file, const std::string& segments, std::vector<std::string> more = {}) {
    std::vector<std::string> args{"soak", "--on",      "ideal", "--segments", segments,          "--seed",
                                  "3",    "--episode", "6",     "--report",   scratch.path(file)};
    args.insert(args.end(), more.begin(), more.end());
    return run(args);
  };
  const Outcome one = soak("one.json", "60");
  ASSERT_EQ(one.code, kDone) << one.out << one.err;
  EXPECT_THAT(one.out, HasSubstr("0 violations in "));
  ASSERT_EQ(soak("two.json", "60", {"--jobs", "2"}).code, kDone);
  const nlohmann::json all = timeless(scratch.json("one.json"));
  EXPECT_EQ(all, timeless(scratch.json("two.json")));
  EXPECT_GE(all["segments"].get<int>(), 60);
  EXPECT_GE(all["deflected_share"].get<double>(), 0.7);
  EXPECT_EQ(all["failures"], 0);
  const nlohmann::json& back = all["retrace"];
  EXPECT_GE(back["tried"].get<int>(), 5);
  EXPECT_EQ(back["arrived"], back["tried"]);
  EXPECT_EQ(back["refused"], 0);
  EXPECT_LT(back["worst_m"].get<double>(), 1e-6);
  EXPECT_LT(back["worst_rad"].get<double>(), 1e-6);
  EXPECT_THAT(one.out, HasSubstr(fmt::format("{0} of {0} motions retraced", back["tried"].get<int>())));
  EXPECT_NEAR(all["failure_rate_95"].get<double>(), failure_rate_95(0, all["segments"].get<long>()), 1e-15);

  ASSERT_EQ(soak("parts.json", "5").code, kDone);
  EXPECT_LT(scratch.json("parts.json")["episodes"], all["episodes"]);
  ASSERT_EQ(soak("parts.json", "60", {"--resume"}).code, kDone);
  EXPECT_EQ(all, timeless(scratch.json("parts.json")));

  const Outcome other = soak("parts.json", "60", {"--resume", "--world", "room"});
  EXPECT_EQ(other.code, kBadInput);
  EXPECT_THAT(other.err, HasSubstr("world is \"flat\" there and \"room\" here"));
}

TEST(Soak, AFallIsReportedWithAScriptThatReplaysIt) {
  // A gale that the planner does not know of.
  const Scratch scratch;
  std::ifstream in(share_dir() / "worlds" / "flat.xml");
  std::string world{std::istreambuf_iterator<char>(in), {}};
  const auto at = world.find("<option ");
  ASSERT_NE(at, std::string::npos);
  world.insert(at + 8, "density=\"100\" wind=\"8 0 0\" ");
  const std::string file = scratch.write("gale.xml", world);
  const Outcome outcome = run({"soak", "--on", "sim", "--world", file, "--segments", "1", "--seed", "5", "--episode",
                               "30", "--report", scratch.path("r.json")});
  EXPECT_EQ(outcome.code, kFailed);
  const nlohmann::json report = scratch.json("r.json");
  ASSERT_EQ(report["first_failures"].size(), 1U);
  EXPECT_EQ(report["violations"]["fall"], 1);
  const std::string script = scratch.path("r.json.5-0.jsonl");
  const double t = report["simulated_s"];
  EXPECT_THAT(
      outcome.out,
      HasSubstr("baton drive --robot mighty --world " + file +
                " --on sim --state sensors --duration paper --gait flow --on-limit shrink --input script:" + script));
  EXPECT_THAT(outcome.out, HasSubstr(fmt::format("--seconds {:.3f}", t)));

  EXPECT_EQ(run({"drive", "--world", file, "--on", "sim", "--input", "script:" + script, "--fast", "--seconds",
                 fmt::format("{:.3f}", t), "--trace", scratch.path("t.csv")})
                .code,
            kFallen);
  const World gale(file);
  const std::atomic<bool> stop{false};
  const EpisodeResult again = Episodes(test::robot("mighty"), gale, course(Session::On::sim, 5, 30.0)).run(0, stop);
  expect_same_end(scratch.table("t.csv"), again);
}

TEST(Soak, ReplaysToTheSameTickOnIdeal) {
  const Scratch scratch;
  const World world = World::load("flat");
  const std::atomic<bool> stop{false};
  const Episodes episodes(test::robot("mighty"), world, course(Session::On::ideal, 11, 20.0));
  const EpisodeResult result = episodes.run(4, stop);
  EXPECT_GE(result.tally.segments, 3);
  EXPECT_GE(result.tally.retrace.tried, 1);
  EXPECT_LT(result.tally.ticks, result.ticks) << "the way back is not driven by the stick";
  ASSERT_EQ(run({"drive", "--world", "flat", "--on", "ideal", "--input",
                 "script:" + scratch.write("s.jsonl", episodes.script(4, result)), "--fast", "--seconds",
                 fmt::format("{:.3f}", static_cast<double>(result.ticks) * kPeriod), "--trace", scratch.path("t.csv")})
                .code,
            kDone);
  expect_same_end(scratch.table("t.csv"), result);
}

/// A short episode with little room, at a kind of place where something was found before, or would be.
struct Situation {
  const char* name;
  std::uint64_t seed;
  long episode;
  const char* robot = "mighty";
  Session::On on = Session::On::ideal;
  Modes modes = {};
};

class SoakInClutter : public testing::TestWithParam<Situation> {};

INSTANTIATE_TEST_SUITE_P(Situations, SoakInClutter,
                         testing::Values(Situation{"TallAndLeaning", 1, 54}, Situation{"AFootUpOverUnevenGround", 1, 9},
                                         Situation{"AHandAtAnObstacle", 1, 47}, Situation{"ASwingAtAnEdge", 1, 173},
                                         Situation{"TheShortestDurationOrNothing",
                                                   1,
                                                   24,
                                                   "mighty",
                                                   Session::On::ideal,
                                                   {DurationRule::search, OnLimit::discard}},
                                         Situation{"ALargerRobot", 1, 6, "scaled"},
                                         Situation{"AFootThatSlippedAtAnEdge", 1, 27, "mighty", Session::On::sim}),
                         [](const auto& tested) { return std::string(tested.param.name); });

TEST_P(SoakInClutter, NothingGoesWrong) {
  const Situation& s = GetParam();
  const World clutter(std::string(BATON_SOURCE_DIR) + "/tests/worlds/clutter.xml");
  const Episodes episodes(test::robot(s.robot), clutter,
                          course(s.on, s.seed, s.on == Session::On::sim ? 8.0 : 10.0, s.modes));
  const std::atomic<bool> stop{false};
  const Tally tally = episodes.run(s.episode, stop).tally;
  for (const Tally::Failure& failure : tally.listed) {
    ADD_FAILURE() << failure.kind << " at " << failure.t << " s: " << failure.value << ", limit " << failure.limit
                  << " " << failure.where;
  }
  EXPECT_EQ(tally.failures, 0);
  EXPECT_GE(tally.segments, 5);
  EXPECT_GE(tally.retrace.tried, 1);
  if (s.on == Session::On::ideal) {
    EXPECT_EQ(tally.retrace.arrived, tally.retrace.tried);
  }
}

TEST(Soak, AWayBackThatIsRefusedIsAFailure) {
  // The ground ends under the heels: the robot goes forward from there, and no foot may be put down there again.
  const Scratch scratch;
  const std::string file = scratch.write("edge.xml", R"(<mujoco model="edge"><worldbody><site name="start"/>
<geom name="ground" type="box" pos="4.98 0 -1" size="5 5 1"/></worldbody></mujoco>)");
  const Outcome outcome = run({"soak", "--world", file, "--segments", "8", "--seed", "1", "--episode", "3", "--report",
                               scratch.path("r.json")});
  EXPECT_EQ(outcome.code, kFailed);
  const nlohmann::json report = scratch.json("r.json");
  EXPECT_GE(report["retrace"]["refused"].get<int>(), 1);
  EXPECT_EQ(report["violations"]["retrace"], report["retrace"]["refused"]);
  for (const auto& failure : report["first_failures"]) {
    if (failure["kind"] == "retrace") {
      EXPECT_EQ(failure["where"], "ground");
    }
  }
}

TEST(Soak, KnowsWhenNothingGoesAnyMore) {
  const RobotModel& robot = test::robot("mighty");
  const World world = World::load("flat");
  Strategy planning(robot, world, {DurationRule::paper, OnLimit::discard});
  Request request;
  GuideContext& context = request.start.context;
  context.from = stand(robot, world.site("start"), robot.profile().stance.com_height);
  context.foothold = context.from.sole;
  request.start.posture = context.from;
  EXPECT_FALSE(stuck(planning, request));
  const int elbow = robot.arm(Side::left).back();
  context.from.q[7 + elbow] = robot.joints()[static_cast<std::size_t>(elbow)].position.hi + 0.1;
  request.start.posture = context.from;
  EXPECT_TRUE(stuck(planning, request));
}

TEST(Soak, BadInputIsOneClearLine) {
  const Scratch scratch;
  const std::string report = scratch.path("r.json");
  struct Case {
    std::vector<std::string> args;
    std::string says;
  };
  const std::vector<Case> cases{
      {{"--report", report}, "--segments or --hours"},
      {{"--report", report, "--segments", "5", "--hours", "1"}, "--segments or --hours"},
      {{"--report", report, "--segments", "-5"}, "--segments"},
      {{"--report", report, "--segments", "5", "--jobs", "0"}, "--jobs"},
      {{"--segments", "5"}, "--report"},
      {{"--segments", "5", "--report", "/nowhere/r.json"}, "/nowhere/r.json"},
      {{"--segments", "5", "--report", report, "--world", "nowhere"}, "nowhere"},
      {{"--segments", "5", "--resume", "--report", scratch.write("not.json", "{]")}, "not the report of a soak"},
  };
  for (const Case& c : cases) {
    std::vector<std::string> args{"soak"};
    args.insert(args.end(), c.args.begin(), c.args.end());
    const Outcome outcome = run(args);
    EXPECT_EQ(outcome.code, kBadInput) << c.says;
    EXPECT_THAT(outcome.err, HasSubstr(c.says));
    EXPECT_EQ(std::count(outcome.err.begin(), outcome.err.end(), '\n'), 1) << outcome.err;
  }
}

}  // namespace
}  // namespace baton::app
