/// A run of the navigator in which everything goes wrong at random: the stick, the planner's answers, the robot. It is
/// a function of its seed, keeps all that the navigator was given, and judges every tick.
#pragma once

#include <gtest/gtest.h>

#include <algorithm>
#include <functional>
#include <optional>
#include <vector>

#include "baton/ik/stand.hpp"
#include "baton/navigate/navigator.hpp"
#include "baton/plan/strategy.hpp"
#include "baton/proving/stick.hpp"
#include "baton/record/recording.hpp"
#include "baton/robot/ideal_robot.hpp"
#include "baton/verify/verifier.hpp"
#include "tests/support/turned_imu.hpp"

namespace baton::test {

class FuzzedRun {
 public:
  /// What happened, so that a test can tell that it did.
  struct Tally {
    long ordinary = 0;  ///< motions committed that follow the stick, go home or retrace
    long stops = 0;     ///< that stop or halt
    long catches = 0;
    long late = 0;       ///< answers that were not taken over
    long refused = 0;    ///< answers that were made refusals
    long disturbed = 0;  ///< ticks with the DCM off
    long slips = 0;
    long lifts = 0;
    long falls = 0;
    long stood_up = 0;  ///< armed again after a fall

    Tally& operator+=(const Tally& o) {
      ordinary += o.ordinary, stops += o.stops, catches += o.catches, late += o.late, refused += o.refused;
      disturbed += o.disturbed, slips += o.slips, lifts += o.lifts, falls += o.falls, stood_up += o.stood_up;
      return *this;
    }
  };

  FuzzedRun(const RobotModel& robot, const World& world, std::uint64_t seed)
      : robot_(robot),
        world_(world),
        period_(robot.profile().tick.period),
        second_(std::lround(std::sqrt(robot.profile().stance.com_height / 0.26) / period_)),
        dice_(seed),
        arms_dice_(seed + 1'000'000),
        stick_(seed, period_),
        modes_{.gait = seed % 4 == 0 ? Gait::stop : Gait::flow},
        source_(seed % 2 == 0 ? StateSource::perfect : StateSource::sensors),
        home_(stand(robot, world.site("start"), robot.profile().stance.com_height)),
        navigator_(robot, world, home_, modes_.gait, source_),
        strategy_(robot, world, modes_),
        verifier_(robot, world),
        body_(robot, home_, period_) {}

  /// Called before and after each tick of the navigator.
  std::function<void(bool begins)> on_tick = [](bool) {};

  /// Everything at random.
  void drive(double seconds) {
    for (long k = std::lround(seconds * static_cast<double>(second_)); k > 0 && !testing::Test::HasFatalFailure(); --k)
      step(command_at_random(), true);
  }

  /// Nothing goes wrong any more, and the stick is let go of until the robot can be driven again.
  void calm_down() {
    trouble_ = Trouble::none;
    const auto waits = [this] {
      return navigator_.guard() != Guard::armed || navigator_.disturbed() || navigator_.thermometer().hot();
    };
    for (long k = 0; k < 20 * second_ && (k < second_ || waits()); ++k)
      step({}, false);
  }

  /// Nothing goes wrong, and this is held.
  void hold(const Command& command, double seconds) {
    trouble_ = Trouble::none;
    for (long k = std::lround(seconds * static_cast<double>(second_)); k > 0 && !testing::Test::HasFatalFailure(); --k)
      step(command, false);
  }

  /// Lives through the run again: the same requests must be made, and the same joint targets given, bit by bit.
  void replay() {
    Navigator again(robot_, world_, home_, modes_.gait, source_);
    Strategy strategy(robot_, world_, modes_);
    for (const Tick& tick : ticks_) {
      if (tick.arms) again.drive_arms(*tick.arms);
      ASSERT_EQ(checksum(again.tick(tick.measurement, tick.command)), tick.checksum) << "tick " << again.now();
      again.poll();
      for (const Event& event : tick.events) {
        const Answer& known = answers_[static_cast<std::size_t>(event.answer)];
        if (event.kind == PlanningEvent::answer) {
          again.answer(known);
          continue;
        }
        const std::optional<Request> request = again.request();
        ASSERT_TRUE(request) << "tick " << again.now() << ": nothing is asked";
        ASSERT_EQ(request->at, known.at);
        const auto* motion = std::get_if<PlannedMotion>(&known.outcome);
        if (motion == nullptr || event.answer % 4 != 0) continue;
        const Answer planned = strategy.plan(*request);
        ASSERT_TRUE(std::holds_alternative<PlannedMotion>(planned.outcome)) << "tick " << again.now();
        ASSERT_EQ(std::get<PlannedMotion>(planned.outcome).motion->end.q, motion->motion->end.q);
      }
    }
    EXPECT_EQ(again.committed(), navigator_.committed());
    EXPECT_EQ(again.slips(), navigator_.slips());
    EXPECT_EQ(again.history(), navigator_.history());
  }

  [[nodiscard]] const Navigator& navigator() const { return navigator_; }
  [[nodiscard]] const Tally& tally() const { return tally_; }
  [[nodiscard]] bool rests_on_both_feet() const {
    const BySide<bool>& contact = navigator_.sample().contact;
    return navigator_.motion() == nullptr && contact.left && contact.right;
  }

 private:
  /// The stick at random; now and then a way back for a while, or a stop for a moment, whatever the stick does.
  Command command_at_random() {
    Command command = stick_.next();
    if (press_left_ == 0 && dice_.below(static_cast<int>(second_)) == 0) {
      press_ = dice_.percent(60) ? Recall::retrace : Recall::stop;
      press_left_ = press_ == Recall::stop ? dice_.between(1, 30) : dice_.between(1, static_cast<int>(second_));
    }
    if (press_left_ > 0 && --press_left_ > 0) command.recall = press_;
    return command;
  }

  enum class Trouble { none, pushed, slips, lifted, tipped };

  /// A request, or an answer that comes in.
  struct Event {
    PlanningEvent kind = PlanningEvent::ask;
    int answer = 0;  ///< its number
  };

  /// One tick as it was given.
  struct Tick {
    std::optional<ArmTargets> arms;  ///< before it
    Measurement measurement;
    Command command;
    std::vector<Event> events;  ///< after it
    std::string checksum;
  };

  /// An answer on its way.
  struct Sent {
    int answer = 0;
    long arrives = 0;  ///< tick
  };

  void step(const Command& command, bool at_random) {
    Tick& tick = ticks_.emplace_back();
    if (at_random) new_trouble();
    // Somebody stands it up.
    if (navigator_.guard() == Guard::fallen && dice_.percent(at_random ? 1 : 100) && !stood_)
      body_ = IdealRobot(robot_, home_, period_);
    stood_ = navigator_.guard() == Guard::fallen && !at_random;
    if (at_random && arms_dice_.percent(2)) {
      tick.arms = arms_at_random();
      navigator_.drive_arms(*tick.arms);
    }
    tick.measurement = body_.read();
    spoil(tick.measurement);
    tick.command = command;
    stopped_since_ask_ = stopped_since_ask_ || command.recall == Recall::stop;
    const Before before = now();
    on_tick(true);
    const JointTarget& target = navigator_.tick(tick.measurement, command);
    on_tick(false);
    tick.checksum = checksum(target);
    judge(before, tick, target);
    const bool soft = navigator_.guard() == Guard::fallen || navigator_.guard() == Guard::stood_up;
    if (!soft) body_.write(target);  // without torques somebody holds it
    navigator_.poll();
    deliver(tick);
    if (!at_random || !dice_.percent(20)) ask(tick, at_random);  // or the planner is busy
  }

  /// Some joints, one or more times of which some may be over, any angles; or they are let go of.
  ArmTargets arms_at_random() {
    ArmTargets targets;
    for (const std::string& joint : released_arms(robot_).joints) {
      if (arms_dice_.percent(60)) targets.joints.push_back(joint);
    }
    if (targets.joints.empty() || arms_dice_.percent(20)) return targets;
    double t = static_cast<double>(navigator_.now()) * period_ + 0.3 * arms_dice_.axis();
    for (int n = arms_dice_.between(1, 8); n > 0; --n)
      targets.t.push_back(t += 0.01 + 0.3 * arms_dice_.share());
    targets.q.resize(std::ssize(targets.t), std::ssize(targets.joints));
    const double size = arms_dice_.percent(70) ? 0.5 : 4.0;
    for (double& angle : targets.q.reshaped())
      angle = size * arms_dice_.axis();
    return targets;
  }

  void new_trouble() {
    if (ticks_left_ > 0 && --ticks_left_ > 0) return;
    if (trouble_ == Trouble::slips) slid_ += slide_;  // it stays where it has slid
    trouble_ = Trouble::none;
    if (!dice_.percent(1)) return;
    const auto ticks = [&](double lo, double hi) {
      return std::max(1L, std::lround((lo + (hi - lo) * 0.5 * (1.0 + dice_.axis())) * static_cast<double>(second_)));
    };
    const double height = robot_.profile().stance.com_height;
    direction_ = Vec3(dice_.axis(), dice_.axis(), 0.0);
    const int kind = dice_.below(100);
    if (kind < 55) {
      trouble_ = Trouble::pushed;
      ticks_left_ = ticks(0.02, 0.6);
      size_ = 0.1 * std::abs(dice_.axis()) * height;
    } else if (kind < 75) {
      trouble_ = Trouble::slips;
      ticks_left_ = ticks(0.02, 0.3);
      slide_ = 0.2 * height * direction_;
    } else if (kind < 88) {
      trouble_ = Trouble::lifted;
      ticks_left_ = ticks(0.05, 1.0);
    } else {
      trouble_ = Trouble::tipped;
      ticks_left_ = ticks(0.01, 0.5);
    }
  }

  /// What the trouble does to the measurement. With a perfect state the root is elsewhere or faster; by sensors, a push
  /// leans the robot over its ankles, and a slip twists a leg.
  void spoil(Measurement& m) {
    const bool perfect = source_ == StateSource::perfect;
    const bool soft = navigator_.guard() == Guard::fallen || navigator_.guard() == Guard::stood_up;
    if (perfect) m.root->pose.p += slid_ + (trouble_ == Trouble::slips ? slide_ : Vec3::Zero());
    if (!perfect && !soft)  // or the joints would go where they are measured
      lean_.apply(m, trouble_ == Trouble::pushed ? size_ / robot_.profile().stance.com_height : 0.0);
    switch (trouble_) {
      case Trouble::none:
        break;
      case Trouble::pushed:
        if (perfect) m.root->velocity += size_ * robot_.omega() * direction_;
        break;
      case Trouble::slips:
        if (!perfect && !soft) m.q[robot_.leg(Side::left).front()] += 0.3 * direction_.x();
        break;
      case Trouble::lifted:
        m.sole = {};
        break;
      case Trouble::tipped: {
        const Mat3 tip = rotation_exp(Vec3(0.0, 1.0, 0.0));
        test::turn_imu(m, tip);
        if (perfect) m.root->pose.R = tip * m.root->pose.R;
        break;
      }
    }
  }

  void ask(Tick& tick, bool at_random) {
    const std::optional<Request> request = navigator_.request();
    if (!request) return;
    EXPECT_EQ(navigator_.guard(), Guard::armed);
    stopped_since_ask_ = false;
    const auto number = static_cast<int>(answers_.size());
    tick.events.push_back({PlanningEvent::ask, number});
    Answer answer = strategy_.plan(*request);
    const int fate = at_random ? dice_.below(100) : 0;
    if (fate >= 92) {
      answer.outcome = Refusal{Reason::no_progress, Part::trunk, 0, 0, "made up"};
      ++tally_.refused;
    }
    answers_.push_back(std::move(answer));
    halts_.push_back(std::holds_alternative<HaltAt>(request->intents.front()));
    // In time, late, or never.
    if (fate < 85 || fate >= 92) sent_.push_back({number, navigator_.now() + (fate >= 60 ? dice_.below(60) : 0)});
    deliver(tick);
  }

  /// Also such as come after their time, and twice.
  void deliver(Tick& tick) {
    for (auto sent = sent_.begin(); sent != sent_.end();) {
      if (sent->arrives > navigator_.now()) {
        ++sent;
        continue;
      }
      tick.events.push_back({PlanningEvent::answer, sent->answer});
      navigator_.answer(answers_[static_cast<std::size_t>(sent->answer)]);
      sent = sent_.erase(sent);
    }
  }

  /// What events tell of, as the last tick left it.
  struct Seen {
    long committed = 0;
    bool executing = false;
    Guard guard = Guard::armed;
    bool disturbed = false;
    long slips = 0;
    long dropped = 0;
  };
  Seen seen_;

  struct Before {
    long committed;
    Guard guard;
    bool rests;
    VecX q;  ///< planned joint angles of the tick before
  };
  [[nodiscard]] Before now() const {
    const bool began = navigator_.now() >= 0;
    return {navigator_.committed(), navigator_.guard(), navigator_.motion() == nullptr,
            began ? VecX(navigator_.sample().q.tail(robot_.nv() - 6)) : VecX()};
  }

  /// Events tell of every change from tick to tick, and of nothing else.
  void judge_events() {
    const std::span<const baton::Event> events = navigator_.events();
    const long k = navigator_.now();
    const Seen now{navigator_.committed(), navigator_.motion() != nullptr,
                   navigator_.guard(),     navigator_.disturbed(),
                   navigator_.slips(),     navigator_.dropped()};
    const auto* committed = find_event<Committed>(events);
    const bool ended = find_event<Ended>(events) != nullptr;
    ASSERT_EQ(committed != nullptr, now.committed != seen_.committed) << k;
    if (committed != nullptr) {
      ASSERT_EQ(committed->segment, now.committed - 1) << k;
    }
    ASSERT_TRUE(seen_.executing || !ended) << k;
    ASSERT_EQ(now.executing, committed != nullptr || (seen_.executing && !ended)) << k;
    const auto* guard = find_event<GuardChanged>(events);
    ASSERT_EQ(guard != nullptr, now.guard != seen_.guard) << k;
    if (guard != nullptr) {
      ASSERT_TRUE(guard->from == seen_.guard && guard->to == now.guard) << k;
    }
    const auto* disturbed = find_event<DisturbedChanged>(events);
    ASSERT_EQ(disturbed != nullptr, now.disturbed != seen_.disturbed) << k;
    if (disturbed != nullptr) {
      ASSERT_EQ(disturbed->disturbed, now.disturbed) << k;
    }
    ASSERT_EQ(find_event<Slipped>(events) != nullptr, now.slips != seen_.slips) << k;
    ASSERT_EQ(find_event<AnswerLate>(events) != nullptr, now.dropped != seen_.dropped) << k;
    if (find_event<Refused>(events) != nullptr) {
      ASSERT_NE(navigator_.refusal(), nullptr) << k;
    }
    seen_ = now;
  }

  void judge(const Before& before, const Tick& tick, const JointTarget& target) {
    const Guard guard = navigator_.guard();
    const long k = navigator_.now();
    tally_.disturbed += navigator_.disturbed() ? 1 : 0;
    tally_.slips = navigator_.slips();
    ASSERT_TRUE(target.q.allFinite() && target.tau.allFinite()) << k;
    judge_events();

    // The guard.
    if (guard != before.guard) {
      tally_.lifts += guard == Guard::lifted ? 1 : 0;
      tally_.falls += guard == Guard::fallen && before.guard != Guard::stood_up ? 1 : 0;
      if (guard == Guard::armed) {
        // What arms a robot again is a stick that is let go of; after a fall, in `poll` of the tick before.
        ASSERT_EQ(before.guard, Guard::lifted) << k;
        ASSERT_TRUE(tick.command.neutral()) << k;
      }
    }
    if (was_stood_up_ && guard == Guard::armed && before.guard == Guard::armed) {
      ++tally_.stood_up;
      ASSERT_TRUE(ticks_[ticks_.size() - 2].command.neutral()) << k;
    }
    was_stood_up_ = guard == Guard::stood_up;

    // A verified motion that ends at rest, or hold, or soft.
    const Motion* motion = navigator_.motion();
    if (guard == Guard::fallen || guard == Guard::stood_up) {
      ASSERT_EQ(motion, nullptr) << k;
      ASSERT_TRUE(target.tau.isZero(0.0) && target.dq.isZero(0.0)) << k;
      ASSERT_EQ(target.q, tick.measurement.q) << k;
      return;
    }
    ASSERT_EQ(target.q.size(), robot_.nv() - 6) << k;
    if (motion == nullptr) {
      ASSERT_TRUE(target.dq.isZero(0.0)) << k;
      ASSERT_EQ(target.q, navigator_.sample().q.tail(robot_.nv() - 6)) << k;
      ASSERT_EQ(navigator_.committed(), before.committed) << k;
    } else {
      ASSERT_TRUE(motion->samples.back().dq.isZero(0.0)) << k;
      ASSERT_EQ(motion->samples.back().q, motion->end.q) << k;
      ASSERT_FALSE(navigator_.planned()->motion.certificate().margins.empty()) << k;
    }
    // What is planned never jumps.
    if (before.guard == guard && before.q.size() > 0) {
      const VecX moved = (navigator_.sample().q.tail(robot_.nv() - 6) - before.q) / period_;
      for (std::size_t j = 0; j < robot_.joints().size(); ++j) {
        const Joint& joint = robot_.joints()[j];
        ASSERT_LE(std::abs(moved[static_cast<Eigen::Index>(j)]), joint.speed * (1.0 + 1e-6)) << k << ' ' << joint.name;
      }
    }
    if (navigator_.committed() == before.committed) return;
    ASSERT_EQ(navigator_.committed(), before.committed + 1) << k;
    ASSERT_EQ(guard, Guard::armed) << k;
    const auto answer =
        std::find_if(answers_.rbegin(), answers_.rend(), [&](const Answer& result) { return result.at == k; });
    ASSERT_NE(answer, answers_.rend()) << k << ": nothing was planned for this tick";
    const auto number = static_cast<std::size_t>(std::distance(answer, answers_.rend())) - 1;
    const bool stops = answer->command.recall == Recall::stop || halts_[number];
    const Purpose purpose = navigator_.purpose();
    ASSERT_EQ(purpose == Purpose::capture, answer->capture() != nullptr) << k;
    ASSERT_EQ(purpose == Purpose::stop, stops && answer->capture() == nullptr) << k;
    const Profile& profile = robot_.profile();
    Limits limits = answer->capture() != nullptr ? Limits::push_recovery(profile) : Limits::normal(profile);
    limits.com_offset = answer->context.com_offset;
    ASSERT_TRUE(std::holds_alternative<VerifiedMotion>(verifier_.verify(*motion, navigator_.anchor(), limits))) << k;
    ++(answer->capture() != nullptr ? tally_.catches : stops ? tally_.stops : tally_.ordinary);
    if (stops || answer->capture() != nullptr) return;
    ASSERT_FALSE(stopped_since_ask_) << k << ": a stop was pressed since this was asked for";
    ASSERT_LE(navigator_.dcm_error().norm(), 0.02 * robot_.profile().stance.com_height) << k;
    ASSERT_FALSE(navigator_.disturbed()) << k;
  }

  const RobotModel& robot_;
  const World& world_;
  double period_;
  long second_;  ///< ticks of a second, for a robot as large as mighty
  Dice dice_;
  Dice arms_dice_;
  Stick stick_;
  Modes modes_;
  StateSource source_;
  Posture home_;
  Navigator navigator_;
  Strategy strategy_;
  Verifier verifier_;
  IdealRobot body_;
  std::vector<Tick> ticks_;
  std::vector<Answer> answers_;
  std::vector<bool> halts_;  ///< of each answer: it comes to rest on a way back
  std::vector<Sent> sent_;
  Trouble trouble_ = Trouble::none;
  long ticks_left_ = 0;
  test::Lean lean_{robot_};
  Vec3 direction_ = Vec3::Zero();
  double size_ = 0.0;          ///< of a push: how far the DCM is off [m]
  Vec3 slide_ = Vec3::Zero();  ///< of a slip [m]
  Vec3 slid_ = Vec3::Zero();   ///< of those before [m]
  bool was_stood_up_ = false;
  bool stood_ = false;
  Recall press_ = Recall::none;
  int press_left_ = 0;  ///< ticks for which it is held
  bool stopped_since_ask_ = false;
  Tally tally_;
};

}  // namespace baton::test
