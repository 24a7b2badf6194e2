#include <fmt/format.h>
#include <spdlog/spdlog.h>

#include <algorithm>
#include <chrono>
#include <memory>
#include <utility>

#include "app/app.hpp"
#include "app/commands.hpp"
#include "app/inputs.hpp"
#include "app/options.hpp"
#include "app/outputs.hpp"
#include "baton/link/engage.hpp"
#include "baton/link/observer.hpp"
#include "baton/model/error.hpp"
#include "baton/record/json.hpp"
#include "baton/shadow/shadow.hpp"

namespace baton::app {
namespace {

constexpr std::chrono::milliseconds kTurn{50};
constexpr std::chrono::seconds kSilent{3};  ///< after which it is said that nothing comes

/// What was measured, for a session whose targets go nowhere.
class Watched : public Robot {
 public:
  [[nodiscard]] Measurement read() override { return measured; }
  void write(const JointTarget& /*target*/) override {}

  Measurement measured;
};

/// Plans nothing.
class NoPlanning : public Planning {
 public:
  [[nodiscard]] bool idle() const override { return false; }
  void post(Request /*request*/) override {}
  [[nodiscard]] std::optional<Reply> poll(long /*tick*/) override { return std::nullopt; }
  void reset() override {}
};

/// The measurements, and what a navigator makes of them that rests, as a recording that can be replayed.
class ShadowRecording {
 public:
  ShadowRecording(const DriveOptions& o, const RobotModel& robot, const World& world, const Posture& start,
                  const link::Welcome& welcome)
      : session_(robot, world, watched_, start, {modes_of(o.modes), state_named(o.physics.state), &planning_}),
        recording_(recording_of(session_, *o.files.record, head(o, robot, start, welcome),
                                origins_of(o.robot, robot, world), !welcome.lock_step, {})) {
    session_.add(*recording_);
  }

  void take(const Measurement& measured, const Command& command) {
    watched_.measured = measured;
    session_.step(command);
  }
  /// @returns why it is not complete; "": it is
  std::string close() { return recording_->close(); }

 private:
  static nlohmann::json head(const DriveOptions& o, const RobotModel& robot, const Posture& start,
                             const link::Welcome& welcome) {
    nlohmann::json head =
        recording_head(o.robot, o.world, o.seed, modes_of(o.modes), state_named(o.physics.state), robot);
    head.update({{"on", welcome.on}, {"start", vector_json(start.q)}});
    return head;
  }

  Watched watched_;
  NoPlanning planning_;
  Session session_;
  std::unique_ptr<RecordingWriter> recording_;
};

void check_options(const DriveOptions& o) {
  if (!is_address(o.on)) throw InputError("--shadow needs --on tcp://HOST:PORT: the robot's end that it looks on at");
  check_physics(o.physics, o.on);
  if (o.gantry) throw InputError("--gantry with --shadow: leave it out, as nothing is driven");
  if (o.input == "page") throw InputError("--input page with --shadow: must be auto, joystick or script:FILE");
  for (const auto& [option, given] :
       {std::pair("--trace", o.files.trace.has_value()), std::pair("--save-model", o.files.save_model.has_value()),
        std::pair("--fast", o.fast), std::pair("--arms", o.arms.has_value()),
        std::pair("--answer-delay", o.answers.delay_ms > 0.0), std::pair("--answer-loss", o.answers.loss > 0.0)}) {
    if (given) throw InputError(fmt::format("{} with --shadow: leave it out, as nothing is driven", option));
  }
}

std::string line_of(const shadow::Tried& tried) {
  std::string part(to_string(tried.command.guide));
  std::replace(part.begin(), part.end(), '_', ' ');
  std::string line = fmt::format("{:.2f} s: {}: ", tried.t, part);
  switch (tried.outcome) {
    case shadow::Tried::Outcome::possible:
      return line + fmt::format("possible, in {:.2f} s", tried.duration);
    case shadow::Tried::Outcome::nothing:
      return line + "nothing to do";
    case shadow::Tried::Outcome::in_part:
      line += fmt::format("possible in part, in {:.2f} s: ", tried.duration);
      break;
    case shadow::Tried::Outcome::refused:
      line += "refused: ";
      break;
  }
  if (!tried.refusal) return line + tried.why;
  return line + fmt::format("{} {} ({:.4g}, limit {:.4g})", to_string(tried.refusal->reason), place(*tried.refusal),
                            tried.refusal->value, tried.refusal->limit);
}

/// Says what is new since the last call.
class Teller {
 public:
  void look(const shadow::Shadow& shadow) {
    for (; plans_ < shadow.tried().size(); ++plans_)
      spdlog::info("{}", line_of(shadow.tried()[plans_]));
    for (; judged_ < shadow.judged().size(); ++judged_) {
      const shadow::Judged& judged = shadow.judged()[judged_];
      spdlog::warn("{:.2f} s: the guard would have said {}", judged.t, to_string(judged.to));
    }
  }

 private:
  std::size_t plans_ = 0;
  std::size_t judged_ = 0;
};

}  // namespace

int drive_in_shadow(const DriveOptions& o) {
  check_options(o);
  const RobotModel robot = robot_in(o.physics, o.robot);
  const World world = World::load(o.world);
  Inputs inputs(o.input, false);
  const std::optional<Calibration> calibration = calibration_in(o.calibration, robot, o.on);
  std::vector<NamedFile> read = files_read(o.robot, robot, world);
  read.push_back({"--input", inputs.script()});
  read.push_back({"--calibration", o.calibration});
  read.push_back({"--token", o.token});
  check_distinct({{"--report", o.files.report}, {"--record", o.files.record}}, read);
  std::optional<OutputFile> report;
  if (o.files.report) report.emplace(*o.files.report, "--report");
  const StateSource source = state_named(o.physics.state);
  shadow::Shadow shadow(robot, world, {modes_of(o.modes), source});
  link::Observer observer(robot, world.name(), {.address = Address::parse(o.on), .token = token_in(o.token)});
  spdlog::info("looks on at the robot '{}' at {}, and sends nothing", observer.welcome().robot, o.on);

  std::unique_ptr<ShadowRecording> recording;
  Teller teller;
  std::string broken;
  bool told = false;
  auto heard = std::chrono::steady_clock::now();
  try {
    while (!interrupted && (!o.seconds || shadow.seconds() < *o.seconds)) {
      std::optional<link::Reading> reading = observer.next(kTurn);
      if (!reading) {
        if (std::chrono::steady_clock::now() - heard > kSilent && !std::exchange(told, true))
          spdlog::warn("nothing is measured: a robot in lock-step stands still in time while nobody drives it");
        continue;
      }
      heard = std::chrono::steady_clock::now();
      told = false;
      if (const auto what = link::lacks(reading->measurement, source); what && !shadow.start())
        throw InputError(fmt::format("the robot at {}: {}", o.on, *what));
      if (calibration) reading->measurement = without_errors(reading->measurement, *calibration);
      const Command command = inputs.read(shadow.seconds());
      shadow.tick(*reading, observer.truth(), command);
      teller.look(shadow);
      if (!o.files.record || !shadow.start()) continue;
      if (!recording)
        recording = std::make_unique<ShadowRecording>(o, robot, world, *shadow.start(), observer.welcome());
      recording->take(reading->measurement, command);
    }
  } catch (const LinkError& error) {
    broken = error.what();
  }

  fmt::print("{} in {}, in the shadow of its driver: {}", robot.profile().name, world.name(), shadow.summary());
  std::fflush(stdout);
  nlohmann::json json = shadow.json();
  json.update({{"robot", robot.profile().name},
               {"world", world.name()},
               {"on", observer.welcome().on},
               {"address", o.on},
               {"state", o.physics.state},
               {"broken", broken}});
  if (recording) {
    const std::string incomplete = recording->close();
    json["recording"] = {{"complete", incomplete.empty()}, {"why", incomplete}};
  }
  if (report) report->write(json.dump(2) + '\n');
  if (broken.empty()) return kDone;
  spdlog::error("{}", broken);
  return kFailed;
}

}  // namespace baton::app
