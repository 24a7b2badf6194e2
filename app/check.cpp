#include <fmt/format.h>
#include <fmt/ranges.h>

#include <chrono>
#include <nlohmann/json.hpp>
#include <sstream>

#include "app/app.hpp"
#include "app/commands.hpp"
#include "app/outputs.hpp"
#include "baton/model/derive.hpp"
#include "baton/model/error.hpp"
#include "baton/model/toml_reader.hpp"
#include "baton/model/urdf.hpp"
#include "baton/proving/tryout.hpp"
#include "baton/record/output_file.hpp"
#include "baton/record/picture.hpp"
#include "baton/robot/robot_in_world.hpp"

namespace baton::app {
namespace {

using Json = nlohmann::json;
namespace fs = std::filesystem;

constexpr int kWidth = 640;
constexpr int kHeight = 640;

/// The contents of the profile file, with the model that is asked for, or those of one that only names the model.
/// @throws InputError the profile is none, or --profile goes with something else than a model file
toml::table given_profile(const CheckOptions& o, const fs::path& file) {
  if (file.extension() != ".toml") return toml::table{{"model", file.filename().string()}};
  toml::table table = parse_toml(file, "profile");
  if (o.profile) {
    const std::string kind = fs::path(o.model).extension();
    if (kind != ".xml" && kind != ".urdf") {
      throw InputError(fmt::format("--profile goes with a model file (.xml, .urdf), not with '{}'", o.model));
    }
    table.insert_or_assign("model", fs::absolute(o.model).string());
  }
  return table;
}

std::string shown_value(const toml::node& node) {
  if (const toml::array* array = node.as_array(); array != nullptr && array->size() > 4) {
    return fmt::format("{} entries", array->size());
  }
  if (const std::optional<double> number = node.value<double>()) return fmt::format("{:.6g}", *number);
  if (const toml::array* array = node.as_array()) {
    std::vector<std::string> entries;
    for (const toml::node& entry : *array)
      entries.push_back(shown_value(entry));
    return fmt::format("[{}]", fmt::join(entries, ", "));
  }
  if (const std::optional<std::string> text = node.value<std::string>()) return *text;
  std::ostringstream text;
  if (const toml::table* table = node.as_table()) text << toml::toml_formatter(*table, toml::format_flags::none);
  return text.str();
}

/// Calls `use` with key, value and source of each value, in the order of the table. A table that was derived as a whole
/// is shown as one.
template <typename Use>
void for_each_value(const CompleteProfile& profile, const toml::table& table, const std::string& prefix, Use use) {
  for (const auto& [name, node] : table) {
    const std::string key = prefix + std::string(name.str());
    const auto source = profile.sources.find(key);
    const toml::table* inner = node.as_table();
    if (inner != nullptr && source == profile.sources.end()) {
      for_each_value(profile, *inner, key + ".", use);
    } else {
      use(key, node, source == profile.sources.end() ? std::string("the profile") : source->second);
    }
  }
}

/// What was given, and the derived values that a reader wants to see: parts, the arms' home, the drive; all others
/// follow from the model again.
std::string short_profile(const toml::table& given, const CompleteProfile& profile, const fs::path& model,
                          const fs::path& file) {
  const fs::path relative = fs::absolute(model).lexically_relative(fs::absolute(file).parent_path());
  std::ostringstream text;
  text << "# What this file leaves out is derived from the model: `baton check` shows it, and any key can be added.\n";
  for (const std::string& warning : profile.warnings)
    text << "# " << warning << '\n';
  toml::table shown = given;
  shown.insert_or_assign("name", profile.table["name"].value_or(std::string("robot")));
  shown.insert_or_assign("model", relative.empty() ? fs::absolute(model).string() : relative.string());
  for (const char* key : {"parts", "home_deg", "rigid"}) {
    if (const toml::node* node = profile.table.get(key)) shown.insert_or_assign(key, *node);
  }
  if (!shown.contains("drive")) shown.insert("drive", toml::table{});
  shown["drive"].as_table()->insert("kind", profile.table["drive"]["kind"].value_or(std::string("pd")));
  text << shown << '\n';
  return text.str();
}

void save_picture(const RobotModel& robot, const Simulation& simulation, const VecX& q, double azimuth,
                  const fs::path& file) {
  const ModelPtr drawn = compile_text(simulation.model_text(), "scene");
  const DataPtr scene(mj_makeData(drawn.get()));
  RobotInWorld::find(robot, *drawn, "scene").write(q, *scene);
  mj_forward(drawn.get(), scene.get());
  Picture picture(*drawn, kWidth, kHeight);
  const double h = robot.profile().stance.com_height;
  picture.render(*scene, FreeCamera{Vec3(q[0], q[1], q[2] - 0.1 * h), 4.2 * h, azimuth, -12.0});
  picture.save(file);
}

/// Tries the robot out; appends to the report.
/// @return the problems
std::vector<std::string> try_out(const RobotModel& robot, const CheckOptions& o, Json& trials, bool& fell) {
  const World world = World::load("flat");
  std::vector<std::string> problems;
  for (const auto& [on, name] :
       {std::pair(Simulation::On::ideal, "planned"), std::pair(Simulation::On::sim, "in physics")}) {
    Tryout tryout(robot, world, on, static_cast<std::uint64_t>(o.seed));
    for (const Manoeuvre& manoeuvre : manoeuvres(robot)) {
      if (interrupted) return problems;
      const Attempt attempt = tryout.run(manoeuvre);
      Json entry = attempt.json();
      entry["on"] = on == Simulation::On::ideal ? "ideal" : "sim";
      trials.push_back(entry);
      fmt::print("{:10}  {:16}  {:>3} of {:<3} moved  {:6.2f} m  COM {:5.1f} mm  {}\n", name, manoeuvre.name,
                 attempt.moved, attempt.given, attempt.travel, 1e3 * attempt.com_rms,
                 attempt.done() ? "done" : attempt.problem);
      std::fflush(stdout);
      fell = fell || !attempt.fall.empty();
      if (!attempt.done()) problems.push_back(fmt::format("{}, {}: {}", manoeuvre.name, name, attempt.problem));
      if (!o.pictures || on != Simulation::On::sim) continue;
      std::string file = manoeuvre.name;
      std::ranges::replace(file, ' ', '_');
      save_picture(robot, tryout.simulation(), attempt.q, 150.0, *o.pictures / (file + ".png"));
      if (manoeuvre.name == "stand") {
        save_picture(robot, tryout.simulation(), attempt.q, 180.0, *o.pictures / "front.png");
        save_picture(robot, tryout.simulation(), attempt.q, 90.0, *o.pictures / "side.png");
      }
    }
  }
  return problems;
}

}  // namespace

int check(const CheckOptions& o) {
  const auto start = std::chrono::steady_clock::now();
  if (o.pictures) make_folder(*o.pictures, "--pictures");
  check_distinct({{"--write-profile", o.write_profile}, {"--report", o.report}},
                 {{"MODEL", profile_file(o.model)}, {"--profile", o.profile}});
  const fs::path file = o.profile ? *o.profile : profile_file(o.model);
  const fs::path folder = fs::absolute(file).parent_path();
  const toml::table given = given_profile(o, file);
  static_cast<void>(Profile::complete_with(of_no_robot(given), folder, file.string()));
  const fs::path model = folder / given["model"].value_or(std::string());
  check_distinct({{"--write-profile", o.write_profile}, {"--report", o.report}}, {{"its model", model}});
  std::optional<OutputFile> profile_output;
  std::optional<OutputFile> report_output;
  if (o.write_profile) profile_output.emplace(*o.write_profile, "--write-profile");
  if (o.report) report_output.emplace(*o.report, "--report");
  if (is_urdf(model)) {
    static_cast<void>(parse_urdf(model));
  } else {
    static_cast<void>(parse_model(model));
  }
  Json report = {{"check", 1},
                 {"model", model.string()},
                 {"values", Json::object()},
                 {"warnings", Json::array()},
                 {"problems", Json::array()},
                 {"trials", Json::array()}};
  std::string verdict;
  int code = kFailed;
  std::vector<std::string> problems;
  try {
    const CompleteProfile profile = complete(given, folder, file.string());
    for_each_value(profile, profile.table, "",
                   [&](const std::string& key, const toml::node& node, const std::string& from) {
                     const std::string value = shown_value(node);
                     report["values"][key] = {{"value", value}, {"from", from}};
                     const bool block = value.find('\n') != std::string::npos;
                     fmt::print("{:26}  {:<24}  {}\n", key, block ? "a table" : value, from);
                   });
    for (const std::string& warning : profile.warnings)
      fmt::print("note: {}\n", warning);
    report["warnings"] = profile.warnings;
    const RobotModel robot(Profile::complete_with(profile, folder, file.string()));
    report["robot"] = robot.profile().name;
    report["mass_kg"] = robot.mass();
    report["joints"] = robot.joints().size();
    fmt::print("{}: {:.2f} kg, {} joints, COM at {:.3f} m\n", robot.profile().name, robot.mass(), robot.joints().size(),
               robot.profile().stance.com_height);
    if (profile_output) profile_output->write(short_profile(given, profile, model, *o.write_profile));
    bool fell = false;
    problems = try_out(robot, o, report["trials"], fell);
    if (interrupted) {
      verdict = "interrupted";
    } else if (fell) {
      verdict = "cannot";
    } else {
      verdict = problems.empty() ? "drives" : "drives with warnings";
      code = problems.empty() ? kDone : kFailed;
    }
  } catch (const InputError& error) {
    verdict = "cannot";
    problems = {error.what()};
  }
  report["verdict"] = verdict;
  report["problems"] = problems;
  report["wall_s"] = seconds_since(start);
  if (report_output) report_output->write(report.dump(2) + '\n');
  fmt::print("{}{}{}\n", verdict, problems.empty() ? "" : ": ", fmt::join(problems, "; "));
  return code;
}

}  // namespace baton::app
