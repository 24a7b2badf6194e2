#include "app/app.hpp"

#include <fmt/format.h>
#include <spdlog/sinks/stdout_color_sinks.h>
#include <spdlog/spdlog.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <array>
#include <cctype>
#include <cerrno>
#include <charconv>
#include <csignal>
#include <cstring>
#include <functional>
#include <limits>
#include <optional>

#include "app/commands.hpp"
#include "app/options.hpp"
#include "baton/input/json_reader.hpp"
#include "baton/model/error.hpp"

namespace baton::app {

std::atomic<bool> interrupted{false};

namespace {

void on_interrupt(int /*signal*/) {
  interrupted = true;
}

constexpr std::array<int, 3> kEnding{SIGINT, SIGTERM, SIGHUP};  ///< signals that end a run

/// Parses the whole text as a number.
template <typename Number>
std::optional<Number> number_in(std::string_view text) {
  if (text.starts_with('+')) text.remove_prefix(1);
  Number value{};
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error != std::errc() || end != text.data() + text.size()) return std::nullopt;
  return value;
}

/// Accepts only values that `fits` accepts; the error says what is expected.
template <typename Number>
CLI::Validator taking(const std::string& wanted, std::function<bool(Number)> fits) {
  const auto check = [wanted, fits](std::string& text) -> std::string {
    const std::optional<Number> value = number_in<Number>(text);
    if (!value || !fits(*value)) return fmt::format("{} is not {}", shortened(text, 40), wanted);
    text = fmt::format("{}", *value);  // CLI11 would read 010 as 8
    return "";
  };
  return {check, "", ""};
}

CLI::Validator whole(long least, long most) {
  const bool any = most == std::numeric_limits<long>::max();
  return taking<long>(any && least == std::numeric_limits<long>::min() ? "a whole number"
                      : any ? fmt::format("a whole number of at least {}", least)
                            : fmt::format("a whole number from {} to {}", least, most),
                      [least, most](long value) { return value >= least && value <= most; });
}

CLI::Validator number(double least, double most) {
  return taking<double>(fmt::format("a number from {} to {}", least, most),
                        [least, most](double value) { return value >= least && value <= most; });
}

CLI::Validator above_zero(double most) {
  return taking<double>(fmt::format("a number above 0, up to {}", most),
                        [most](double value) { return value > 0.0 && value <= most; });
}

constexpr double kLongestRun = 1e6;   ///< [s]
constexpr double kLongestSoak = 1e5;  ///< [h]
constexpr long kAnyWhole = std::numeric_limits<long>::max();

constexpr const char* kRobotHelp =
    "Robot: a folder of robots/, a profile's .toml file, or a model's .xml or .urdf file";

void add_modes(CLI::App& command, ModeOptions& modes) {
  command.add_option("--gait", modes.gait, "flow: replan while moving; stop: come to rest first")
      ->capture_default_str()
      ->check(CLI::IsMember({"stop", "flow"}));
  command.add_option("--duration", modes.duration, "How a segment's duration is chosen: paper or search")
      ->capture_default_str()
      ->check(CLI::IsMember({"paper", "search"}));
  command.add_option("--on-limit", modes.on_limit, "What to do with a goal that cannot be reached: discard or shrink")
      ->capture_default_str()
      ->check(CLI::IsMember({"discard", "shrink"}));
}

void add_plant(CLI::App& command, PhysicsOptions& physics) {
  command.add_option("--drive", physics.drive, "Drive of the servos; default: the profile's")
      ->check(CLI::IsMember({"torque", "pd", "stiff"}));
  command
      .add_option("--plant", physics.plant,
                  "Simulated robot: real (the default: with the profile's errors of sensors and actuators, drawn by "
                  "--seed) or model (exact)")
      ->check(CLI::IsMember({"model", "real"}));
  command.add_option("--scenario", physics.scenario,
                     "Disturbances on top of the plant, drawn by --seed (list: docs/balance.md)");
  command.add_option("--times", physics.times, "How many times as large the scenario's disturbances are")
      ->capture_default_str()
      ->transform(number(0.0, 100.0));
}

void add_physics(CLI::App& command, PhysicsOptions& physics) {
  command
      .add_option("--state", physics.state,
                  "Source of the state estimate: sensors (encoders, IMU, sole forces), torques (motor torques instead "
                  "of sole forces), perfect")
      ->capture_default_str()
      ->check(CLI::IsMember({"sensors", "torques", "perfect"}));
  add_plant(command, physics);
}

void add_answers(CLI::App& command, AnswerOptions& answers) {
  command
      .add_option("--answer-delay", answers.delay_ms, "Delay each planner answer by 0 to this many ms, drawn by --seed")
      ->capture_default_str()
      ->transform(number(0.0, 10000.0));
  command.add_option("--answer-loss", answers.loss, "Fraction of planner answers lost, drawn by --seed")
      ->capture_default_str()
      ->transform(number(0.0, 1.0));
}

void add_calibration(CLI::App& command, std::optional<std::filesystem::path>& file) {
  command.add_option("--calibration", file, "Constant errors of the sensors: a .toml file by baton calibrate");
}

void add_token(CLI::App& command, std::optional<std::filesystem::path>& file) {
  command.add_option("--token", file, "File that holds the token of the robot's end");
}

void add_robot(CLI::App& command, RobotOptions& o) {
  command.add_flag("--sim", o.sim, "The simulated robot");
  command.add_option(
      "--on", o.on,
      "tcp://HOST:PORT: a robot there that follows targets; keeps its balance and navigates it from here");
  command.add_option("--on-token", o.on_token, "File that holds the token of that robot");
  command.add_option("--robot", o.robot, "Robot")->capture_default_str();
  command.add_option("--world", o.world, "World in which it stands")->capture_default_str();
  add_plant(command, o.physics);
  command.add_option("--seed", o.seed, "Seed of plant and scenario")
      ->capture_default_str()
      ->transform(whole(std::numeric_limits<long>::min(), kAnyWhole));
  command.add_flag("--real-time", o.real_time, "Go on by the clock, as a real robot; else wait for each command");
  command.add_flag(
      "--targets", o.targets,
      "Be a robot that only follows targets for its joints; else it keeps its balance and plans by itself");
  command.add_flag("--gantry", o.gantry,
                   "It hangs, its feet in the air. With --on: it takes its stance there first. With --sim --targets: "
                   "its joints are at zero; type l (lower) or r (raise) and Enter");
  command.add_option("--record", o.record,
                     "Folder: record each run of its navigator there (001.mcap, ...), whatever becomes of the driver");
  command
      .add_option("--listen", o.listen, "Where it waits for a driver; an address that others can reach needs --token")
      ->capture_default_str();
  add_token(command, o.token);
}

void add_bridge_rcss(CLI::App& command, BridgeRcssOptions& o) {
  command.add_option("--server", o.server, "The simulator's port for agents: HOST:PORT")->capture_default_str();
  command.add_option("--robot", o.robot, "Robot, with the simulator's own model: rcss_k1, rcss_t1, or a profile")
      ->capture_default_str();
  command
      .add_option("--listen", o.listen, "Where it waits for a driver; an address that others can reach needs --token")
      ->capture_default_str();
  add_token(command, o.token);
}

void add_drive(CLI::App& command, DriveOptions& o) {
  command.add_option("--robot", o.robot, kRobotHelp)->capture_default_str();
  command.add_option("--world", o.world, "World: a name in worlds/, or an .xml file")->capture_default_str();
  command
      .add_option("--on", o.on,
                  "sim: physics; ideal: joints track their targets exactly; tcp://HOST:PORT: a robot's end there")
      ->capture_default_str()
      ->check(CLI::Validator(
          [](const std::string& on) -> std::string {
            if (on == "sim" || on == "ideal" || is_address(on)) return "";
            return fmt::format("{} is not sim, ideal or tcp://HOST:PORT", shortened(on, 40));
          },
          "", ""));
  add_token(command, o.token);
  command.add_option("--input", o.input, "auto, joystick, page or script:FILE")->capture_default_str();
  command.add_option("--arms", o.arms, "What drives the arms meanwhile: script:FILE (format: docs/input.md)");
  add_modes(command, o.modes);
  add_physics(command, o.physics);
  add_answers(command, o.answers);
  add_calibration(command, o.calibration);
  command.add_option("--seconds", o.seconds, "Simulated time, or the robot's own, after which the run ends")
      ->transform(above_zero(kLongestRun));
  command.add_option("--seed", o.seed, "Seed of plant, scenario and answer faults; written to the report")
      ->capture_default_str()
      ->transform(whole(std::numeric_limits<long>::min(), kAnyWhole));
  command.add_flag(
      "--shadow", o.shadow,
      "Beside whoever drives the robot at --on tcp://HOST:PORT: estimate, plan and report, and send nothing");
  command.add_flag("--gantry", o.gantry,
                   "The robot at --on tcp://HOST:PORT hangs, its feet in the air: it takes its stance there, and is "
                   "guided once it was lowered and stands");
  command.add_flag("--headless", o.headless, "No page");
  command.add_flag("--fast", o.fast, "Run as fast as possible, not in real time (needs --seconds; no page)");
  command.add_option("--port", o.port, "Port of the page; 0: any free port")
      ->capture_default_str()
      ->transform(whole(0, 65535));
  command.add_option("--trace", o.files.trace, "Write every tick to this .csv file");
  command.add_option("--save-model", o.files.save_model, "Write the simulated model to this .xml file");
  command.add_option("--report", o.files.report, "Write statistics of the run to this .json file");
  command.add_option("--record", o.files.record, "Record the run to this .mcap file, for baton replay and viewers");
}

void add_soak(CLI::App& command, SoakOptions& o) {
  command.add_option("--on", o.on, "sim or ideal")->capture_default_str()->check(CLI::IsMember({"sim", "ideal"}));
  add_modes(command, o.modes);
  add_physics(command, o.physics);
  add_answers(command, o.answers);
  add_calibration(command, o.calibration);
  command.add_option("--seeds", o.seeds, "Number of seeds of a scenario, from --seed on: one episode each")
      ->transform(whole(1, kAnyWhole));
  command.add_option("--segments", o.segments, "Run until this many segments were driven")
      ->transform(whole(1, kAnyWhole));
  command.add_option("--hours", o.hours, "Run for this many hours of simulated time")
      ->transform(above_zero(kLongestSoak));
  command.add_option("--seed", o.seed, "Seed of sticks, plants, scenarios and answer faults")
      ->capture_default_str()
      ->transform(whole(std::numeric_limits<long>::min(), kAnyWhole));
  command.add_option("--robot", o.robot, "Robot")->capture_default_str();
  command.add_option("--world", o.world, "World")->capture_default_str();
  command.add_option("--jobs", o.jobs, "Threads; the result does not depend on it")
      ->capture_default_str()
      ->transform(whole(1, 1024));
  command.add_option("--episode", o.episode, "Simulated seconds per episode; default: 120, or the scenario's")
      ->transform(number(0.1, 36000.0));
  command.add_flag("--arms", o.arms,
                   "Drive the arms at random, by targets known a second ahead, whatever the stick does");
  command.add_flag("--link", o.link,
                   "Drive a robot's end in real time, by a virtual clock, over a connection with faults: --seeds of "
                   "them, 10 s each unless --episode says otherwise");
  command.add_flag("--resume", o.resume, "Continue the run of the report");
  command.add_flag("--break", o.breaking,
                   "With --scenario: find how many times as large its disturbances may be until one of --seeds "
                   "episodes ends in a fall (default: 20 of 30 s)");
  command.add_option("--plot", o.plot, "With --break: draw the breaking points to this .svg file");
  command.add_option("--report", o.report, "Write the result to this .json file; required without --scenario");
}

void add_calibrate(CLI::App& command, CalibrateOptions& o) {
  command.add_option("--out", o.out, "Write the calibration to this .toml file")->required();
  command.add_option("--robot", o.robot, "Robot")->capture_default_str();
  command.add_option("--world", o.world, "World: its ground has to be level where the robot starts")
      ->capture_default_str();
  add_physics(command, o.physics);
  command.add_option("--seed", o.seed, "Seed of plant and scenario: the robot that drive and soak have with the same")
      ->capture_default_str()
      ->transform(whole(std::numeric_limits<long>::min(), kAnyWhole));
  command.add_option("--report", o.report, "Write what was found, and how wrong it is, to this .json file");
}

void add_check(CLI::App& command, CheckOptions& o) {
  command
      .add_option("model", o.model, "Model: an .xml (MJCF) or .urdf file, a profile's .toml file, or a robot's name")
      ->required();
  command.add_option("--profile", o.profile, "Use this profile with the model");
  command.add_option("--write-profile", o.write_profile, "Write a profile of the robot to this .toml file");
  command.add_option("--report", o.report, "Write all values and results to this .json file");
  command.add_option("--pictures", o.pictures, "Folder: write pictures of the robot and of each manoeuvre's end");
  command.add_option("--seed", o.seed, "Seed of the plant real and of the random stick")
      ->capture_default_str()
      ->transform(whole(std::numeric_limits<long>::min(), kAnyWhole));
}

/// @throws InputError a command lacks a required option
void complain_of_missing(const CLI::App& app) {
  for (const CLI::App* command : app.get_subcommands()) {
    for (const CLI::Option* option : command->get_options()) {
      if (!option->get_required() || option->count() > 0) continue;
      std::string name = option->get_name();
      for (char& c : name)
        c = option->get_positional() ? static_cast<char>(std::toupper(c)) : c;
      throw InputError(fmt::format("{}: {} is missing: {}", command->get_name(), name, option->get_description()));
    }
  }
}

int parse_and_run(std::vector<std::string> args) {
  CLI::App app{"baton: one stick guides a whole humanoid, and nothing done with the stick can make it fall"};
  app.set_version_flag("--version", "baton " + version());
  app.require_subcommand(0, 1);

  bool verbose = false;
  app.add_flag("-v,--verbose", verbose, "Log more");
  app.fallthrough();
  app.parse_complete_callback([&verbose] { spdlog::set_level(verbose ? spdlog::level::debug : spdlog::level::info); });

  // `baton` alone means `baton drive`.
  const auto first =
      std::find_if(args.begin(), args.end(), [](const auto& arg) { return arg != "-v" && arg != "--verbose"; });
  const bool names_command = first != args.end() && !first->starts_with("-");
  const bool asks_about_all = first != args.end() && (*first == "--help" || *first == "-h" || *first == "--version");
  if (!names_command && !asks_about_all) args.insert(args.begin(), "drive");

  DriveOptions drive_options;
  CLI::App* drive_command = app.add_subcommand("drive", "Drive the robot with a stick, the page or a script");
  add_drive(*drive_command, drive_options);

  CalibrateOptions calibrate_options;
  CLI::App* calibrate_command =
      app.add_subcommand("calibrate", "Find the constant errors of the sensors by shifting and stepping for a minute");
  add_calibrate(*calibrate_command, calibrate_options);

  CheckOptions check_options;
  CLI::App* check_command =
      app.add_subcommand("check", "Look at a robot's model, propose a profile, and try the robot out");
  add_check(*check_command, check_options);

  CLI::App* robots_command = app.add_subcommand("robots", "List the robots that --robot knows by name");
  CLI::App* profile_command = app.add_subcommand("profile", "Print a robot's profile with all that is derived");
  std::string profile_robot = "mighty";
  profile_command->add_option("robot", profile_robot, kRobotHelp)->capture_default_str();

  RobotOptions robot_options;
  CLI::App* robot_command = app.add_subcommand("robot", "Be the robot's end of a connection, for drive --on tcp://...");
  add_robot(*robot_command, robot_options);

  CLI::App* bridge_command = app.add_subcommand("bridge", "Be the robot's end for a robot that speaks otherwise");
  bridge_command->require_subcommand(0, 1);
  BridgeRcssOptions bridge_rcss_options;
  CLI::App* bridge_rcss_command = bridge_command->add_subcommand(
      "rcss", "A Booster robot in rcssservermj, the RoboCup 3D simulator on MuJoCo (docs/rcss.md)");
  add_bridge_rcss(*bridge_rcss_command, bridge_rcss_options);
  CLI::App* unitree_command =
      bridge_command->add_subcommand("unitree", "Unitree G1, low level, on DDS; its --help lists the options");
  unitree_command->set_help_flag();  // and all else is the bridge's own
  unitree_command->prefix_command();
  unitree_command->fallthrough(false);

  DampOptions damp_options;
  CLI::App* damp_command = app.add_subcommand("damp", "Let a robot's motors only brake, whoever drives it");
  damp_command->add_option("address", damp_options.address, "The robot's end: tcp://HOST:PORT")->required();
  add_token(*damp_command, damp_options.token);

  PlanOptions plan_options;
  CLI::App* plan_command = app.add_subcommand("plan", "Show what a script would do, segment by segment, as JSON");
  plan_command->add_option("script", plan_options.script, "Stick script (JSON Lines)")->required();
  plan_command->add_option("--robot", plan_options.robot, "Robot")->capture_default_str();
  plan_command->add_option("--world", plan_options.world, "World")->capture_default_str();

  plan_command->add_option("--seconds", plan_options.seconds, "How long the script's last line is held")
      ->capture_default_str()
      ->transform(number(0.0, 86400.0));
  add_modes(*plan_command, plan_options.modes);
  plan_command->add_option("--out", plan_options.out, "Folder: write each motion to a file, for baton verify");

  VerifyOptions verify_options;
  CLI::App* verify_command = app.add_subcommand("verify", "Verify a motion file again");
  verify_command->add_option("motion", verify_options.motion, "Motion file (JSON), written by baton plan --out")
      ->required();
  verify_command->add_option("--robot", verify_options.robot, "Robot; default: the file's");
  verify_command->add_option("--world", verify_options.world, "World; default: the file's");

  ReproduceOptions reproduce_options;
  CLI::App* reproduce_command = app.add_subcommand("reproduce", "Reproduce figures of the 2008 paper, or test walks");
  reproduce_command->add_option("what", reproduce_options.what, "fig8, room or walks")
      ->required()
      ->check(CLI::IsMember({"fig8", "room", "walks"}));
  reproduce_command->add_option("--out", reproduce_options.out, "Folder for the figures")->required();
  reproduce_command
      ->add_option("--plant", reproduce_options.plant, "Simulated robot of room and walks: real (the default) or model")
      ->check(CLI::IsMember({"model", "real"}));
  reproduce_command->add_option("--seed", reproduce_options.seed,
                                "Seed of the plant real, and of the operator in the room; default: 0");

  OperateOptions operate_options;
  CLI::App* operate_command = app.add_subcommand("operate", "Let a scripted operator do a task by the stick");
  operate_command->add_option("--task", operate_options.task, "room: down steps A, across, hand to door B")
      ->capture_default_str()
      ->check(CLI::IsMember({"room"}));
  operate_command->add_option("--robot", operate_options.robot, "Robot")->capture_default_str();
  operate_command->add_option("--on", operate_options.on, "sim or ideal")
      ->capture_default_str()
      ->check(CLI::IsMember({"sim", "ideal"}));
  operate_command->add_option("--seed", operate_options.seed, "Seed of the random start on the stage")
      ->capture_default_str()
      ->transform(whole(std::numeric_limits<long>::min(), kAnyWhole));
  operate_command->add_flag("--exact-start", operate_options.exact_start,
                            "Start at the world's start, not at a random pose");
  operate_command->add_flag("--foot-by-foot", operate_options.foot_by_foot,
                            "Guide the feet down the steps, as in the paper");
  operate_command
      ->add_option("--sight", operate_options.sight,
                   "Error of the operator's sight [mm], a standard deviation; yaws err by 0.4 degrees for each mm")
      ->capture_default_str()
      ->transform(number(0.1, 100.0));
  operate_command->add_option("--seconds", operate_options.seconds, "Simulated time after which the operator gives up")
      ->capture_default_str()
      ->transform(above_zero(kLongestRun));
  add_modes(*operate_command, operate_options.modes);
  add_physics(*operate_command, operate_options.physics);
  operate_command->add_option("--report", operate_options.report, "Write statistics of the run to this .json file");
  operate_command->add_option("--trace", operate_options.trace, "Write every tick to this .csv file");
  operate_command->add_option("--script", operate_options.script, "Write the operator's stick as a script");

  ReplayOptions replay_options;
  CLI::App* replay_command = app.add_subcommand("replay", "Replay a recorded run");
  replay_command->add_option("recording", replay_options.recording, "Recording, written by drive --record")->required();
  replay_command->add_flag("--verify", replay_options.verify,
                           "Compare the joint targets with the recorded ones, bit for bit");

  InfoOptions info_options;
  CLI::App* info_command = app.add_subcommand("info", "Show what is in a recording");
  info_command->add_option("recording", info_options.recording, "Recording, written by drive --record")->required();

  RecoverOptions recover_options;
  CLI::App* recover_command =
      app.add_subcommand("recover", "Finish a recording whose run was killed, for viewers that need its index");
  recover_command->add_option("recording", recover_options.recording, "Recording, written by drive --record")
      ->required();
  recover_command->add_option("--out", recover_options.out, "Write the finished recording to this file")->required();

  ExportOptions export_options;
  CLI::App* export_command = app.add_subcommand("export", "Write a recording as tables or plots");
  export_command->add_option("recording", export_options.recording, "Recording, written by drive --record")->required();
  export_command->add_option("--csv", export_options.csv, "Folder: write each channel, and the trace, to a .csv file");
  export_command->add_option("--plots", export_options.plots, "Folder: draw .svg plots");

  SoakOptions soak_options;
  CLI::App* soak_command = app.add_subcommand("soak", "Try to break it: random sticks, judged by independent means");
  add_soak(*soak_command, soak_options);

  try {
    std::reverse(args.begin(), args.end());
    app.parse(args);
  } catch (const CLI::RequiredError& error) {
    complain_of_missing(app);
    throw InputError(error.what());
  } catch (const CLI::ParseError& error) {
    if (error.get_exit_code() == 0) return app.exit(error) == 0 ? kDone : kFailed;
    throw InputError(error.what());
  }
  if (drive_command->parsed()) return drive(drive_options);
  if (calibrate_command->parsed()) return calibrate(calibrate_options);
  if (check_command->parsed()) return check(check_options);
  if (robots_command->parsed()) return robots();
  if (profile_command->parsed()) return profile(profile_robot);
  if (robot_command->parsed()) return robot(robot_options);
  if (bridge_rcss_command->parsed()) return bridge_rcss(bridge_rcss_options);
  if (damp_command->parsed()) return damp(damp_options);
  if (unitree_command->parsed()) return bridge({"unitree", unitree_command->remaining()});
  if (bridge_command->parsed()) throw InputError("bridge: must be followed by what it leads to: rcss or unitree");
  if (plan_command->parsed()) return plan(plan_options);
  if (verify_command->parsed()) return verify(verify_options);
  if (reproduce_command->parsed()) return reproduce(reproduce_options);
  if (operate_command->parsed()) return operate(operate_options);
  if (replay_command->parsed()) return replay(replay_options);
  if (info_command->parsed()) return show_info(info_options);
  if (recover_command->parsed()) return recover(recover_options);
  if (export_command->parsed()) return export_recording(export_options);
  if (soak_command->parsed()) {
    return soak_options.link               ? soak_link(soak_options)
           : soak_options.physics.scenario ? soak_scenarios(soak_options)
                                           : soak(soak_options);
  }
  return kDone;
}

}  // namespace

std::string version() {
  return BATON_VERSION;
}

int run(const std::vector<std::string>& args) {
  // Standard output is for results; the log goes to standard error.
  if (!spdlog::get("baton")) spdlog::set_default_logger(spdlog::stderr_color_mt("baton"));
  spdlog::set_pattern("%^%l%$: %v");
  interrupted = false;
  std::array<void (*)(int), kEnding.size()> before{};
  for (std::size_t i = 0; i < kEnding.size(); ++i) {
    before[i] = std::signal(kEnding[i], on_interrupt);
    if (kEnding[i] == SIGHUP && before[i] == SIG_IGN) std::signal(SIGHUP, SIG_IGN);  // keep nohup's setting
  }
  int code = kFailed;
  try {
    code = parse_and_run(args);
  } catch (const InputError& error) {
    fmt::print(stderr, "baton: {}\n", error.what());
    code = kBadInput;
  } catch (const std::exception& error) {
    fmt::print(stderr, "baton: {}{}\n", std::ferror(stdout) != 0 ? "standard output: " : "", error.what());
  }
  if (std::fflush(stdout) != 0) {
    fmt::print(stderr, "baton: standard output: could not be written completely: {}\n", std::strerror(errno));
    if (code == kDone) code = kFailed;
  }
  for (std::size_t i = 0; i < kEnding.size(); ++i)
    std::signal(kEnding[i], before[i]);
  return code;
}

}  // namespace baton::app
