/// The program's commands, each with its options. All throw InputError for bad input.
#pragma once

#include <atomic>
#include <filesystem>
#include <optional>
#include <string>

namespace baton::app {

/// Set by SIGINT (Ctrl-C), SIGTERM and SIGHUP: come to rest, write what was asked for, end.
extern std::atomic<bool> interrupted;

struct ModeOptions {
  std::string duration = "paper";
  std::string gait = "flow";
  std::string on_limit = "shrink";
};

/// What physics is like, beside the world.
struct PhysicsOptions {
  std::string state = "sensors";
  std::optional<std::string> drive;     ///< instead of the profile's
  std::optional<std::string> scenario;  ///< a plant that is not the model
  double times = 1.0;                   ///< factor on how far it is from it
};

/// What goes wrong with the planner's answers.
struct AnswerOptions {
  double delay_ms = 0.0;  ///< each comes late, by at most this [ms]
  double loss = 0.0;      ///< share of them that never comes
};

/// What `drive` writes.
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
  ModeOptions modes;
  PhysicsOptions physics;
  AnswerOptions answers;
  std::optional<double> seconds;
  long seed = 0;
  bool headless = false;
  bool fast = false;
  int port = 8080;
  FileOptions files;
};

struct PlanOptions {
  std::string robot = "mighty";
  std::string world = "flat";
  std::filesystem::path script;
  double seconds = 1.0;  ///< how long the last line is held
  ModeOptions modes;
  std::optional<std::filesystem::path> out;  ///< folder for one file a motion
};

struct VerifyOptions {
  std::filesystem::path motion;
  std::optional<std::string> robot;  ///< instead of the file's
  std::optional<std::string> world;  ///< instead of the file's
};

struct ReproduceOptions {
  std::string what;
  std::filesystem::path out;
};

struct OperateOptions {
  std::string task = "room";
  std::string robot = "mighty";
  std::string on = "sim";
  long seed = 0;
  bool exact_start = false;   ///< from the world's start, not from a random one
  bool foot_by_foot = false;  ///< down the steps, in any gait
  double seconds = 240.0;     ///< the operator gives up then
  ModeOptions modes;
  PhysicsOptions physics;
  std::optional<std::filesystem::path> report;
  std::optional<std::filesystem::path> trace;
  std::optional<std::filesystem::path> script;  ///< writes the stick as a script
};

struct SoakOptions {
  std::string robot = "mighty";
  std::string world = "flat";
  std::string on = "ideal";
  ModeOptions modes;
  PhysicsOptions physics;
  AnswerOptions answers;
  std::optional<long> segments;
  std::optional<double> hours;  ///< simulated
  long seed = 0;
  int jobs = 1;
  std::optional<long> seeds;      ///< of a scenario
  std::optional<double> episode;  ///< simulated time from one fresh start to the next [s]
  bool resume = false;
  std::optional<std::filesystem::path> report;  ///< needed but with a scenario
};

struct ReplayOptions {
  std::filesystem::path recording;
  bool verify = false;
};

int drive(const DriveOptions& options);
int replay(const ReplayOptions& options);
int plan(const PlanOptions& options);
int verify(const VerifyOptions& options);
int reproduce(const ReproduceOptions& options);
int operate(const OperateOptions& options);
int soak(const SoakOptions& options);
int soak_scenarios(const SoakOptions& options);

}  // namespace baton::app
