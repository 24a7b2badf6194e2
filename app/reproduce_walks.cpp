#include <fmt/format.h>
#include <spdlog/spdlog.h>

#include <algorithm>
#include <map>
#include <nlohmann/json.hpp>

#include "app/app.hpp"
#include "app/commands.hpp"
#include "app/outputs.hpp"
#include "app/reproduce.hpp"
#include "baton/input/script.hpp"
#include "baton/proving/dice.hpp"
#include "baton/record/plot.hpp"
#include "baton/record/report.hpp"
#include "baton/run/simulation.hpp"

namespace baton::app {
namespace {

using Json = nlohmann::json;

constexpr double kBefore = 1.0;          ///< initial rest [s]
constexpr double kWalkTime = 55.0;       ///< time the stick is held [s]
constexpr double kComeToRest = 4.0;      ///< time to come to rest [s]
constexpr double kReplanInterval = 0.7;  ///< interval between changes of the command [s]
constexpr double kMostTilt = 10.0;       ///< limit on the trunk's tilt [deg]
constexpr double kMostEndError = 0.03;   ///< limit on the end position error [m]

/// A command held for some time: forward, left, turn.
struct Leg {
  double seconds;
  Vec3 stick;
};

struct Walk {
  std::string name;
  std::string world;
  std::vector<Leg> legs;  ///< repeated
};

/// Random changes of direction: anywhere, or roughly ahead, and then back.
std::vector<Leg> replanned(Dice& dice, bool on_steps) {
  std::vector<Leg> legs;
  for (double t = 0.0; t < kWalkTime; t += kReplanInterval) {
    const double ahead = on_steps ? (t < 0.3 * kWalkTime ? 1.0 : -1.0) : dice.axis();
    legs.push_back({kReplanInterval, {ahead, 0.5 * dice.axis(), 0.3 * dice.axis()}});
  }
  return legs;
}

std::vector<Walk> walks() {
  Dice dice(1);
  return {
      {"forward", "flat", {{kWalkTime, {1, 0, 0}}}},
      {"backward", "flat", {{kWalkTime, {-1, 0, 0}}}},
      {"left", "flat", {{kWalkTime, {0, 1, 0}}}},
      {"right", "flat", {{kWalkTime, {0, -1, 0}}}},
      {"turn left", "flat", {{kWalkTime, {0, 0, 1}}}},
      {"turn right", "flat", {{kWalkTime, {0, 0, -1}}}},
      {"curve", "flat", {{kWalkTime, {1, 0, 0.3}}}},
      {"diagonal", "flat", {{kWalkTime, {0.7, -0.7, 0}}}},
      {"there and back", "flat", {{0.5 * kWalkTime, {1, 0, 0}}, {0.5 * kWalkTime, {-1, 0, 0}}}},
      {"down the steps", "room", {{5.0, {1, 0, 0}}, {kWalkTime, {0, 0, 1}}}},
      {"down and up", "room", {{12.0, {1, 0, 0}}, {15.0, {-1, 0, 0}}}},
      {"replanned", "flat", replanned(dice, false)},
      {"replanned steps", "room", replanned(dice, true)},
  };
}

Script script_of(const Walk& walk) {
  std::vector<Script::Entry> entries{{0.0, Command{}}};
  double t = kBefore;
  for (std::size_t i = 0; t < kBefore + kWalkTime - 1e-9; ++i) {
    const Leg& leg = walk.legs[i % walk.legs.size()];
    Command command;
    command.axes << leg.stick.x(), leg.stick.y(), 0.0, 0.0, 0.0, leg.stick.z();
    entries.push_back({t, command});
    t += leg.seconds;
  }
  entries.push_back({kBefore + kWalkTime, Command{}});
  return Script(std::move(entries), walk.name);
}

/// Result of a walk.
struct Outcome {
  Json report;
  std::vector<Vec2> path;  ///< COM path, world frame
  std::vector<Vec2> led;   ///< path its motions would have led to without slip
  double off = 0.0;        ///< distance between both at the end [m]
  double turned = 0.0;     ///< difference of trunk headings at the end [rad]
};

Outcome walk_on(const RobotModel& robot, const World& world, const SimulatedRobot::Parameters& physics, long seed,
                Script script) {
  Simulation simulation(robot, world, Simulation::On::sim, {.physics = physics});
  Session& session = simulation.session();
  Report report(robot);
  Kinematics kinematics(robot);
  Outcome outcome;
  Hooks hooks;
  hooks.tick = [&](const TickRecord& record) {
    const Navigator& navigator = record.navigator;
    if (navigator.motion() == nullptr) return;  // at rest the accumulated slip is dropped
    kinematics.set(navigator.sample().q);
    const Pose led{navigator.slip_free_frame() * kinematics.com(),
                   navigator.slip_free_frame().R * kinematics.trunk().R};
    kinematics.set(record.truth->q);
    outcome.path.push_back(kinematics.com().head<2>());
    outcome.led.push_back(led.p.head<2>());
    outcome.off = (outcome.path.back() - outcome.led.back()).norm();
    outcome.turned = std::abs(wrap_angle(yaw_of(kinematics.trunk().R) - yaw_of(led.R)));
  };
  session.add(report);
  session.add(hooks);
  while (session.t() < kBefore + kWalkTime + kComeToRest && !session.fallen() && !interrupted)
    session.step(script);
  outcome.report = report.json(world.name(), "sim", seed, 0.0);
  return outcome;
}

std::string file_name(std::string name) {
  std::replace(name.begin(), name.end(), ' ', '_');
  return name;
}

}  // namespace

int reproduce_walks(const RobotModel& robot, const SimulatedRobot::Parameters& physics, long seed,
                    const std::filesystem::path& out) {
  Json table = Json::array();
  std::map<std::string, Panel> maps;
  bool fell = false;
  bool good = true;
  fmt::print("{:15}  {:>8}  {:>7}  {:>5}  {:>15}  {:>8}\n", "walk", "segments", "way [m]", "tilt", "off at the end",
             "estimate");
  for (const Walk& walk : walks()) {
    const World world = World::load(walk.world);
    const Script script = script_of(walk);
    std::string lines;
    for (const Script::Entry& entry : script.entries())
      lines += script_line(entry.t, entry.command) + '\n';
    write_whole(out / (file_name(walk.name) + ".jsonl"), "--out", lines);
    const Outcome walked = walk_on(robot, world, physics, seed, script);
    if (interrupted) break;
    const double tilt = walked.report["tilt_deg_max"].get<double>();
    const Json& tracking = walked.report["tracking"];
    const Json& segments = walked.report["segments"];
    const bool falls = walked.report["falls"] != 0;
    fell = fell || falls;
    good = good && !falls && segments["slips"] == 0 && tilt <= kMostTilt && walked.off <= kMostEndError;
    table.push_back({{"walk", walk.name},
                     {"world", walk.world},
                     {"falls", falls ? 1 : 0},
                     {"segments", segments["committed"]},
                     {"slips", segments["slips"]},
                     {"way_m", tracking["way_m"]},
                     {"tilt_deg_max", tilt},
                     {"off_m", walked.off},
                     {"off_rad", walked.turned},
                     {"estimate_max_m", tracking["estimate_max_m"]}});
    fmt::print("{:15}  {:8}  {:7.2f}  {:4.2f}\u00b0  {:5.1f} mm, {:4.2f}\u00b0  {:5.1f} mm{}\n", walk.name,
               table.back()["segments"].get<long>(), tracking["way_m"].get<double>(), tilt, 1e3 * walked.off,
               walked.turned * 180.0 / M_PI, 1e3 * tracking["estimate_max_m"].get<double>(), falls ? ", fell" : "");
    std::fflush(stdout);
    Panel& map = maps[walk.world];
    map.title = fmt::format("Ways of the COM, {}: walked, and where the motions lead (dashed)", walk.world);
    map.x_label = "x [m]";
    map.y_label = "y [m]";
    map.equal = true;
    map.height = 420.0;
    const std::string colour = palette::kSeries[map.series.size() / 2 % palette::kSeries.size()];
    map.series.push_back({walk.name, walked.path, Stroke::solid, colour, 1.6});
    map.series.push_back({"", walked.led, Stroke::dashed, palette::kBlack, 0.8});
  }
  if (interrupted) {
    spdlog::warn("interrupted: no figures");
    return kFailed;
  }
  std::vector<Panel> panels;
  for (auto& [name, map] : maps)
    panels.push_back(std::move(map));
  if (!panels.empty()) save_plot(out / "walks.svg", panels, 900.0);
  write_whole(out / "walks.json", "--out", table.dump(2) + '\n');
  fmt::print("walks.json, walks.svg and the scripts in {}\n", out.string());
  if (fell) return kFallen;
  return good ? kDone : kFailed;
}

}  // namespace baton::app
