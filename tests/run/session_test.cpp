// A run can be begun anew, follows whoever gives the commands, and needs no truth.
#include "baton/run/session.hpp"

#include <gmock/gmock.h>

#include <array>
#include <bit>
#include <thread>

#include "baton/ik/stand.hpp"
#include "baton/proving/answer_faults.hpp"
#include "baton/proving/stick.hpp"
#include "baton/record/recording.hpp"
#include "baton/record/report.hpp"
#include "baton/record/trace.hpp"
#include "baton/robot/ideal_robot.hpp"
#include "baton/run/planning_thread.hpp"
#include "baton/run/simulation.hpp"
#include "tests/support/robots.hpp"
#include "tests/support/scratch.hpp"

namespace baton {
namespace {

using On = Simulation::On;
using testing::ElementsAre;

/// Everything that happened, bit by bit.
class Diary : public Sink {
 public:
  void on_tick(const TickRecord& record) override {
    std::string line = std::to_string(record.t) + ' ' + checksum(record.target);
    for (const double x : record.truth->q)
      line += ' ' + std::to_string(std::bit_cast<std::uint64_t>(x));
    for (const double x : record.measurement.q)
      line += ' ' + std::to_string(std::bit_cast<std::uint64_t>(x));
    lines.push_back(line);
  }
  void on_plan(const PlanRecord& record) override {
    lines.push_back("answer for " + std::to_string(record.answer.at) + " at " + std::to_string(record.t));
  }
  void on_planning(PlanningEvent event) override { lines.emplace_back(event == PlanningEvent::ask ? "ask" : "offer"); }

  std::vector<std::string> lines;
};

struct Case {
  On on;
  Plant plant;
  AnswerFaults faults;
};

std::vector<Case> cases() {
  Plant noisy;
  noisy.sensors.encoder_noise = 1e-3;
  noisy.sensors.force_noise = 0.05;
  noisy.actuators.delay = 0.003;
  noisy.tilt = Vec3(0.02, 0.01, 0.0);
  noisy.seed = 3;
  Plant pushed;  // it falls
  pushed.pushes = {{0.5, 0.05, Vec3(0.0, 8.0, 0.0)}};
  return {{On::ideal, {}, {}},
          {On::ideal, {}, {0.3, 0.3}},
          {On::sim, {}, {}},
          {On::sim, noisy, {0.06, 0.1}},
          {On::sim, pushed, {0.2, 0.0}}};
}

TEST(Session, AfterAResetItRunsAsNew) {
  const RobotModel& model = test::robot("mighty");
  const World world = World::load("flat");
  const double period = model.profile().tick.period;
  int outstanding = 0;
  int fallen = 0;
  for (const Case& c : cases()) {
    DirectPlanning direct(model, world, {});
    FaultyPlanning planning(direct, c.faults, period, 5);
    Simulation::Parameters parameters;
    parameters.physics.plant = c.plant;
    parameters.session.planning = &planning;
    Simulation simulation(model, world, c.on, parameters);
    Session& session = simulation.session();
    const auto run = [&](double seconds) {
      Diary diary;
      session.add(diary);
      Stick stick(11, period);
      while (session.t() < seconds)
        session.step(stick);
      return diary.lines;
    };
    const std::vector<std::string> as_new = run(3.0);
    for (const double until : {3.0, 1.234, 0.777}) {
      fallen += session.fallen() ? 1 : 0;
      outstanding += planning.idle() ? 0 : 1;
      session.reset();  // the diary of the run before is gone
      EXPECT_EQ(session.t(), 0.0);
      EXPECT_TRUE(session.resting() && !session.fallen() && planning.idle());
      std::vector<std::string> again = run(until);
      ASSERT_GT(again.size(), 100U);
      again.resize(std::min(again.size(), as_new.size()));
      const auto end = as_new.begin() + static_cast<std::ptrdiff_t>(again.size());
      EXPECT_TRUE(std::equal(as_new.begin(), end, again.begin()));
    }
  }
  EXPECT_GE(fallen, 1);
  EXPECT_GE(outstanding, 1);
}

/// An ideal robot of which is known no more than of a real one.
class Hidden : public Robot {
 public:
  explicit Hidden(Robot& robot) : robot_(&robot) {}
  [[nodiscard]] Measurement read() override { return robot_->read(); }
  void write(const JointTarget& target) override { robot_->write(target); }

 private:
  Robot* robot_;
};

class SessionTest : public testing::Test {
 protected:
  const RobotModel& model_ = test::robot("mighty");
  const World world_ = World::load("flat");
  const Posture start_ = stand(model_, world_.site("start"), model_.profile().stance.com_height);
  IdealRobot ideal_{model_, start_, model_.profile().tick.period};
};

TEST_F(SessionTest, ARobotWithoutTruthIsDrivenTheSame) {
  const test::Scratch scratch;
  Hidden hidden(ideal_);
  Session session(model_, world_, hidden, start_);
  Report report(model_);
  Trace trace(model_, scratch.path("hidden.csv"));
  RecordingWriter recording(model_, scratch.path("hidden.mcap"), nlohmann::json::object(), {});
  for (Sink* sink : std::initializer_list<Sink*>{&report, &trace, &recording})
    session.add(*sink);

  Simulation simulation(model_, world_, On::ideal);
  Report seen(model_);
  Trace table(model_, scratch.path("seen.csv"));
  simulation.session().add(seen);
  simulation.session().add(table);

  Command forward;
  forward.axes[0] = 1.0;
  while (session.t() < 3.0) {
    session.step(forward);
    simulation.session().step(forward);
    EXPECT_EQ(session.truth(), nullptr);
  }
  EXPECT_FALSE(session.fallen());
  EXPECT_EQ(ideal_.truth()->q, simulation.truth().q);
  trace.close();
  table.close();
  EXPECT_EQ(recording.close(), "");

  // What is known is the same; the rest is left out.
  const auto rows = scratch.table("hidden.csv");
  const auto all = scratch.table("seen.csv");
  ASSERT_EQ(rows.size(), all.size());
  int known = 0;
  for (std::size_t i = 0; i < rows.front().size(); ++i) {
    const std::string& name = rows.front()[i];
    const bool truth = name.starts_with("qpos") || name.starts_with("qvel") || name.starts_with("touch") ||
                       name.starts_with("force") || name == "com_x" || name == "com_y" || name == "com_z" ||
                       name == "zmp_x" || name == "zmp_y";
    known += truth ? 0 : 1;
    for (std::size_t k = 1; k < rows.size(); ++k)
      ASSERT_EQ(rows[k][i], truth ? "nan" : all[k][i]) << name << ' ' << k;
  }
  EXPECT_GT(known, 30);

  const nlohmann::json a = report.json("flat", "ideal", 0, 0.0);
  const nlohmann::json b = seen.json("flat", "ideal", 0, 0.0);
  for (const auto& [key, value] : b.items()) {
    if (key == "falls" || key == "travel_m" || key == "tracking" || key == "com_height_m" || key == "tilt_deg_max" ||
        key == "final") {
      EXPECT_TRUE(a[key].is_null()) << key;
    } else if (!key.ends_with("_us") && key != "commands" && key != "zmp_margin_m") {
      EXPECT_EQ(a[key], value) << key;
    }
  }
  EXPECT_EQ(a["commands"]["given"], b["commands"]["given"]);
  EXPECT_TRUE(a["commands"]["moved"].is_null() && a["zmp_margin_m"]["measured_min"].is_null());
  EXPECT_EQ(a["zmp_margin_m"]["planned_min"], b["zmp_margin_m"]["planned_min"]);
  EXPECT_GE(a["segments"]["committed"].get<int>(), 2);
}

TEST_F(SessionTest, ARobotThatCannotBePutBackSaysSo) {
  Hidden hidden(ideal_);
  Session session(model_, world_, hidden, start_);
  for (int k = 0; k < 20; ++k)
    session.step({});
  EXPECT_THROW(session.reset(), std::logic_error);
  EXPECT_EQ(session.navigator().now(), 19) << "nothing has changed";
}

TEST_F(SessionTest, SinksAreCalledInTheirOrder) {
  std::vector<int> calls;
  std::array<Hooks, 3> hooks;
  Session session(model_, world_, ideal_, start_);
  for (const int i : {0, 1, 2}) {
    hooks[static_cast<std::size_t>(i)].tick = [&calls, i](const TickRecord&) { calls.push_back(i); };
    session.add(hooks[static_cast<std::size_t>(i)]);
  }
  session.step({});
  EXPECT_THAT(calls, ElementsAre(0, 1, 2));
}

TEST_F(SessionTest, AnOperatorSeesTheRunAndIsAskedOnceATick) {
  class Person : public Operator {
   public:
    [[nodiscard]] Command decide(const View& view) override {
      EXPECT_NEAR(view.t, 0.005 * static_cast<double>(asked), 1e-12);
      EXPECT_NE(view.truth, nullptr);
      EXPECT_EQ(view.navigator.now(), asked - 1);
      ++asked;
      Command command;
      command.axes[0] = 1.0;
      return command;
    }
    long asked = 0;
  } person;
  Session session(model_, world_, ideal_, start_);
  for (int k = 0; k < 200; ++k)
    session.step(person);
  EXPECT_EQ(person.asked, 200);
  EXPECT_GE(session.navigator().committed(), 1);
}

/// Planning on a thread that is waited for.
class Awaited : public Planning {
 public:
  explicit Awaited(Planning& planning) : planning_(&planning) {}
  [[nodiscard]] bool idle() const override { return planning_->idle(); }
  void post(Request request) override { planning_->post(std::move(request)); }
  [[nodiscard]] std::optional<Reply> poll(long tick) override {
    std::optional<Reply> reply;
    while (!idle() && !(reply = planning_->poll(tick)))
      std::this_thread::yield();
    return reply;
  }
  void reset() override { planning_->reset(); }

 private:
  Planning* planning_;
};

TEST_F(SessionTest, WherePlanningHappensMakesNoDifference) {
  PlanningThread thread(model_, world_, {});
  Awaited awaited(thread);
  Simulation here(model_, world_, On::ideal);
  Simulation there(model_, world_, On::ideal, {.session = {.planning = &awaited}});
  Stick stick(3, model_.profile().tick.period);
  while (here.session().t() < 3.0) {
    const Command command = stick.next();
    here.session().step(command);
    there.session().step(command);
    ASSERT_EQ(here.truth().q, there.truth().q);
  }
  EXPECT_GE(here.session().navigator().committed(), 2);
}

}  // namespace
}  // namespace baton
