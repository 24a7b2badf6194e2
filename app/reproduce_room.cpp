#include <fmt/format.h>
#include <spdlog/spdlog.h>

#include <algorithm>
#include <chrono>
#include <nlohmann/json.hpp>

#include "app/app.hpp"
#include "app/commands.hpp"
#include "app/door_task.hpp"
#include "app/outputs.hpp"
#include "app/reproduce.hpp"
#include "baton/input/script.hpp"
#include "baton/model/contact.hpp"
#include "baton/proving/room_operator.hpp"
#include "baton/record/picture.hpp"
#include "baton/record/plot.hpp"
#include "baton/run/session.hpp"

namespace baton::app {
namespace {

constexpr std::size_t kSnapshots = 8;
constexpr double kPatience = 110.0;  ///< after which the door counts as not reached [s]
constexpr double kAtDoor = 2.0;      ///< time the run continues after the door was reached, the stick centred [s]

/// Data of a run for the figures, in the world frame.
struct Loci {
  std::vector<double> t;
  std::vector<Vec3> com;
  BySide<std::vector<Vec3>> sole;
  BySide<std::vector<Vec3>> hand;
  std::vector<Vec3> com_goals;
  std::vector<std::vector<Vec2>> footholds;  ///< outlines
};

std::vector<Vec2> seen_from(const std::vector<Vec3>& points, int across, int up) {
  std::vector<Vec2> flat;
  for (const Vec3& p : points)
    flat.emplace_back(p[across], p[up]);
  return flat;
}

std::vector<Vec2> over_time(const std::vector<double>& t, const std::vector<Vec3>& points, int axis) {
  std::vector<Vec2> flat;
  for (std::size_t i = 0; i < t.size(); ++i)
    flat.emplace_back(t[i], points[i][axis]);
  return flat;
}

void draw_map(const Loci& loci, const World& world, const std::filesystem::path& file) {
  Panel map;
  map.title = "Subgoals and loci, from above";
  map.x_label = "x [m]";
  map.y_label = "y [m]";
  map.equal = true;
  const double far = 1.0;
  for (const GroundFace& face : world.faces()) {
    if (face.outline.vertices().front().norm() > far) continue;
    map.areas.push_back({"steps", face.outline.vertices(), palette::kOrange, 0.2, true});
  }
  for (const auto& outline : loci.footholds)
    map.areas.push_back({"footholds", outline, palette::kGrey, 0.25, true});
  map.series.push_back({"COM", seen_from(loci.com, 0, 1), Stroke::solid, palette::kBlack, 1.6});
  map.series.push_back({"left foot", seen_from(loci.sole.left, 0, 1), Stroke::solid, palette::kBlue, 1.2});
  map.series.push_back({"right foot", seen_from(loci.sole.right, 0, 1), Stroke::solid, palette::kVermilion, 1.2});
  map.series.push_back({"left hand", seen_from(loci.hand.left, 0, 1), Stroke::solid, palette::kGreen, 1.2});
  map.series.push_back({"right hand", seen_from(loci.hand.right, 0, 1), Stroke::solid, palette::kPurple, 1.2});
  map.series.push_back({"COM subgoals", seen_from(loci.com_goals, 0, 1), Stroke::points, palette::kBlack, 2.5});
  map.series.push_back({"door B", {world.site("door_B").p.head<2>()}, Stroke::points, palette::kGreen, 5.0});
  map.height = 520.0;
  save_plot(file, std::vector<Panel>{map}, 980.0);
}

void draw_histories(const Loci& loci, const std::filesystem::path& file) {
  std::vector<Panel> panels;
  const std::array<const char*, 3> axes{"x [m]", "y [m]", "z [m]"};
  for (int axis = 0; axis < 3; ++axis) {
    Panel panel;
    panel.x_label = axis == 2 ? "t [s]" : "";
    panel.y_label = axes[static_cast<std::size_t>(axis)];
    panel.series.push_back({"COM", over_time(loci.t, loci.com, axis), Stroke::solid, palette::kBlack, 1.6});
    panel.series.push_back({"left foot", over_time(loci.t, loci.sole.left, axis), Stroke::solid, palette::kBlue, 1.2});
    panel.series.push_back(
        {"right foot", over_time(loci.t, loci.sole.right, axis), Stroke::solid, palette::kVermilion, 1.2});
    panel.series.push_back({"left hand", over_time(loci.t, loci.hand.left, axis), Stroke::solid, palette::kGreen, 1.2});
    panels.push_back(std::move(panel));
  }
  panels.front().title = "Loci over time";
  save_plot(file, panels, 900.0);
}

/// Pictures at equal intervals, from the first to the last.
std::vector<Image> snapshots(const Simulation& simulation, const std::vector<VecX>& postures) {
  const ModelPtr drawn = compile_text(simulation.model_text(), "scene");  // the simulator's model lacks visual geoms
  Picture picture(*drawn, 640, 480);
  const DataPtr scene(mj_makeData(drawn.get()));
  std::vector<Image> images;
  for (std::size_t k = 0; k < kSnapshots; ++k) {
    const VecX& q = postures[k * (postures.size() - 1) / (kSnapshots - 1)];
    mju_copy(scene->qpos, q.data(), drawn->nq);
    mj_forward(drawn.get(), scene.get());
    images.push_back(picture.render(*scene, "overview"));
  }
  return images;
}

}  // namespace

int reproduce_room(const RobotModel& robot, const SimulatedRobot::Parameters& physics, long seed,
                   const std::filesystem::path& out) {
  const World world = World::load("room");
  Simulation simulation(robot, world, Simulation::On::sim, {.physics = physics});
  Session& session = simulation.session();
  Outputs outputs(simulation, out / "room_report.json", out / "room.csv", out / "room.xml");
  RoomOperator person(robot, world, static_cast<std::uint64_t>(seed) + 1);
  std::string script;
  Command last;
  SimulatedRobot& body = *simulation.simulated();

  Kinematics kinematics(robot);
  Loci loci;
  std::vector<VecX> postures;  ///< of the simulator, as often as the loci
  long segment = -1;
  DoorTask task(robot, world);
  double reached_at = -1.0;
  std::string_view doing;
  const auto wall = std::chrono::steady_clock::now();
  long tick = 0;
  const auto over = [&] {
    return session.t() >= kPatience || (reached_at >= 0.0 && session.t() >= reached_at + kAtDoor);
  };
  while (!over() && !session.fallen() && !interrupted) {
    const Command command = reached_at < 0.0 ? person.decide(session.view()) : Command{.guide = last.guide};
    if (script.empty() || !(command == last)) script += script_line(session.t(), command) + '\n';
    last = command;
    session.step(command);
    kinematics.set(simulation.truth().q);
    task.look(kinematics);
    if (task.reached() && reached_at < 0.0) reached_at = session.t();
    if (person.doing() != doing) {
      doing = person.doing();
      spdlog::info("{:5.1f} s: the operator {}, the hand is {:.0f} mm from the door", session.t(), doing,
                   1e3 * task.error());
    }
    if (tick++ % 10 == 0) {
      loci.t.push_back(session.t());
      loci.com.push_back(kinematics.com());
      for (const Side side : kSides) {
        loci.sole[side].push_back(kinematics.sole(side).p);
        loci.hand[side].push_back(kinematics.hand(side).p);
      }
      postures.emplace_back(Eigen::Map<const VecX>(body.data().qpos, body.model().nq));
    }
    const Navigator& nav = session.navigator();
    if (nav.segment() != segment && nav.motion() != nullptr) {
      const Posture& end = nav.motion()->end;
      loci.com_goals.push_back(nav.anchor() * end.com);
      for (const Side side : kSides) {
        if (end.contact[side])
          loci.footholds.push_back(sole_outline(robot, side, nav.anchor() * end.sole[side]).vertices());
      }
    }
    segment = nav.segment();
  }
  const bool reached = reached_at >= 0.0 && !session.fallen();
  write_whole(out / "room.jsonl", "--out", script);
  outputs.write(world.name(), "sim", seed, seconds_since(wall));
  if (interrupted) {
    spdlog::warn("interrupted: no figures");
    return kFailed;
  }
  const nlohmann::json summary = {{"falls", session.fallen() ? 1 : 0},
                                  {"duration_s", reached ? reached_at : session.t()},
                                  {"reached", reached},
                                  {"hand_error_m", task.error()}};
  write_whole(out / "room.json", "--out", summary.dump(2) + '\n');
  draw_map(loci, world, out / "fig10.svg");
  draw_histories(loci, out / "fig11.svg");
  save_png(out / "fig12.png", montage(snapshots(simulation, postures), 4));
  fmt::print(
      "{} {:.2f} s: room.json, fig10.svg, fig11.svg, fig12.png, room.csv, room.xml, room_report.json, room.jsonl in "
      "{}\n",
      reached ? "the hand was held at the door after" : "the door was not reached in",
      summary["duration_s"].get<double>(), out.string());
  if (session.fallen()) return kFallen;
  return reached ? kDone : kFailed;
}

}  // namespace baton::app
