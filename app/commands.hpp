/// The program's commands and their options. All commands throw InputError on bad input.
#pragma once

#include <atomic>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

namespace baton::app {

/// Set by SIGINT (Ctrl-C), SIGTERM and SIGHUP: come to rest, write the requested files, exit.
extern std::atomic<bool> interrupted;

struct ModeOptions {
  std::string duration = "paper";
  std::string gait = "flow";
  std::string on_limit = "shrink";
};

/// Physics and state estimation.
struct PhysicsOptions {
  std::string state = "sensors";
  std::optional<std::string> drive;     ///< overrides the profile's
  std::optional<std::string> plant;     ///< real or model; none: real in physics
  std::optional<std::string> scenario;  ///< what is added to the plant
  double times = 1.0;                   ///< scales that
};

struct CalibrateOptions {
  std::string robot = "mighty";
  std::string world = "flat";
  PhysicsOptions physics;
  long seed = 0;
  std::filesystem::path out;
  std::optional<std::filesystem::path> report;
};

struct CheckOptions {
  std::string model;                                   ///< MJCF or URDF file, profile, or name of a robot
  std::optional<std::filesystem::path> profile;        ///< profile to use with it
  std::optional<std::filesystem::path> write_profile;  ///< profile to write
  std::optional<std::filesystem::path> report;         ///< .json file to write
  std::optional<std::filesystem::path> pictures;       ///< folder of pictures to write
  long seed = 0;                                       ///< of the plant, and of the random stick
};

/// Fault injection into the planner's answers.
struct AnswerOptions {
  double delay_ms = 0.0;  ///< largest delay [ms]
  double loss = 0.0;      ///< fraction lost
};

/// Output files of `drive`.
struct FileOptions {
  std::optional<std::filesystem::path> trace;
  std::optional<std::filesystem::path> save_model;
  std::optional<std::filesystem::path> record;
  std::optional<std::filesystem::path> report;
};

struct DriveOptions {
  std::string robot = "mighty";
  std::string world = "room";
  std::string on = "sim";
  std::string input = "auto";
  std::optional<std::string> arms;  ///< what drives them: script:FILE
  ModeOptions modes;
  PhysicsOptions physics;
  AnswerOptions answers;
  std::optional<double> seconds;
  long seed = 0;
  bool gantry = false;  ///< the robot hangs, its feet in the air, when the run begins
  bool shadow = false;  ///< beside another controller: sends nothing
  bool headless = false;
  bool fast = false;
  int port = 8080;
  std::optional<std::filesystem::path> calibration;
  std::optional<std::filesystem::path> token;  ///< file that holds what the robot's end wants to know
  FileOptions files;
};

struct RobotOptions {
  bool sim = false;
  std::optional<std::string> on;  ///< address of a robot that follows targets
  std::string robot = "mighty";
  std::string world = "room";
  PhysicsOptions physics;
  long seed = 0;
  bool real_time = false;  ///< goes on by the clock; else waits for each command or target
  bool targets = false;    ///< follows targets for the joints, without a navigator of its own
  bool gantry = false;     ///< hangs, its feet in the air
  std::string listen = "127.0.0.1:7447";
  std::optional<std::filesystem::path> token;     ///< file that holds what drivers must know
  std::optional<std::filesystem::path> on_token;  ///< file that holds what the robot at `on` wants to know
  std::optional<std::filesystem::path> record;    ///< folder for a recording of each run
};

/// `baton bridge rcss`.
struct BridgeRcssOptions {
  std::string server = "127.0.0.1:60000";
  std::string robot = "rcss_k1";
  std::string listen = "127.0.0.1:7447";
  std::optional<std::filesystem::path> token;  ///< file that holds what drivers must know
};

struct DampOptions {
  std::string address;
  std::optional<std::filesystem::path> token;
};

struct BridgeOptions {
  std::string to;                    ///< unitree
  std::vector<std::string> options;  ///< of that bridge
};

struct PlanOptions {
  std::string robot = "mighty";
  std::string world = "flat";
  std::filesystem::path script;
  double seconds = 1.0;  ///< how long the last line is held [s]
  ModeOptions modes;
  std::optional<std::filesystem::path> out;  ///< folder for one file per motion
};

struct VerifyOptions {
  std::filesystem::path motion;
  std::optional<std::string> robot;  ///< overrides the file's
  std::optional<std::string> world;  ///< overrides the file's
};

struct ReproduceOptions {
  std::string what;
  std::filesystem::path out;
  std::optional<std::string> plant;  ///< real or model; none: real in physics
  std::optional<long> seed;          ///< none: 0
};

struct OperateOptions {
  std::string task = "room";
  std::string robot = "mighty";
  std::string on = "sim";
  long seed = 0;
  bool exact_start = false;   ///< start at the world's start, not at a random pose
  bool foot_by_foot = false;  ///< go down the steps foot by foot
  double sight = 5.0;         ///< error of the operator's sight [mm]
  double seconds = 240.0;     ///< time limit [s]
  ModeOptions modes;
  PhysicsOptions physics;
  std::optional<std::filesystem::path> report;
  std::optional<std::filesystem::path> trace;
  std::optional<std::filesystem::path> script;  ///< script of the stick to write
};

struct SoakOptions {
  std::string robot = "mighty";
  std::string world = "flat";
  std::string on = "ideal";
  ModeOptions modes;
  PhysicsOptions physics;
  AnswerOptions answers;
  std::optional<std::filesystem::path> calibration;
  std::optional<long> segments;
  std::optional<double> hours;  ///< simulated time [h]
  long seed = 0;
  int jobs = 1;
  std::optional<long> seeds;      ///< number of seeds of a scenario
  std::optional<double> episode;  ///< simulated time per episode [s]
  bool resume = false;
  bool arms = false;                            ///< drive the arms at random
  bool link = false;                            ///< of a robot's end over a connection with faults
  bool breaking = false;                        ///< look for the breaking points of scenarios
  std::optional<std::filesystem::path> plot;    ///< of breaking points
  std::optional<std::filesystem::path> report;  ///< required unless there is a scenario
};

struct ReplayOptions {
  std::filesystem::path recording;
  bool verify = false;
};

struct InfoOptions {
  std::filesystem::path recording;
};

struct RecoverOptions {
  std::filesystem::path recording;
  std::filesystem::path out;
};

struct ExportOptions {
  std::filesystem::path recording;
  std::optional<std::filesystem::path> csv;    ///< folder for tables
  std::optional<std::filesystem::path> plots;  ///< folder for plots
};

/// Becomes the bridge's own program; returns only by throwing.
int bridge(const BridgeOptions& options);
int calibrate(const CalibrateOptions& options);
int bridge_rcss(const BridgeRcssOptions& options);
int check(const CheckOptions& options);
int robots();

/// Prints a robot's profile with all that is derived.
/// @param robot as given to `--robot`
/// @throws InputError it is no robot
int profile(const std::string& robot);
int damp(const DampOptions& options);
int drive(const DriveOptions& options);
int drive_in_shadow(const DriveOptions& options);
int export_recording(const ExportOptions& options);
int recover(const RecoverOptions& options);
int replay(const ReplayOptions& options);
int show_info(const InfoOptions& options);
int robot(const RobotOptions& options);
int plan(const PlanOptions& options);
int verify(const VerifyOptions& options);
int reproduce(const ReproduceOptions& options);
int operate(const OperateOptions& options);
int soak(const SoakOptions& options);
int soak_scenarios(const SoakOptions& options);
int soak_link(const SoakOptions& options);

}  // namespace baton::app
