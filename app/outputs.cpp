#include "app/outputs.hpp"

#include <fmt/format.h>
#include <mujoco/mujoco.h>
#include <spdlog/spdlog.h>

#include <sstream>
#include <utility>

#include "app/app.hpp"
#include "baton/model/derive.hpp"
#include "baton/model/error.hpp"
#include "baton/model/input_file.hpp"
#include "baton/model/toml_reader.hpp"

namespace baton::app {
namespace {

bool same_file(const std::filesystem::path& a, const std::filesystem::path& b) {
  std::error_code missing;
  if (std::filesystem::is_character_file(a, missing)) return false;  // /dev/null can be shared
  if (std::filesystem::equivalent(a, b, missing)) return true;
  const auto name = [](const std::filesystem::path& file) {
    std::error_code ignored;
    return std::filesystem::weakly_canonical(std::filesystem::absolute(link_target(file), ignored), ignored);
  };
  return name(a) == name(b);
}

}  // namespace

void check_distinct(const std::vector<NamedFile>& outputs, const std::vector<NamedFile>& inputs) {
  const auto check = [](const NamedFile& a, const NamedFile& b) {
    if (a.file && b.file && same_file(*a.file, *b.file)) {
      throw InputError(fmt::format("{} {} and {} {}: the same file: must be two", a.option, a.file->string(), b.option,
                                   b.file->string()));
    }
  };
  for (std::size_t i = 0; i < outputs.size(); ++i) {
    for (std::size_t k = i + 1; k < outputs.size(); ++k)
      check(outputs[i], outputs[k]);
    for (const NamedFile& input : inputs)
      check(outputs[i], input);
  }
}

std::vector<NamedFile> files_read(const std::string& robot, const RobotModel& model, const World& world) {
  return {{"--world", world.file()}, {"--robot", profile_file(robot)}, {"the model", model.profile().model}};
}

void make_folder(const std::filesystem::path& folder, const std::string& option) {
  std::error_code error;
  std::filesystem::create_directories(folder, error);
  if (error) throw InputError(fmt::format("{} {}: {}", option, folder.string(), error.message()));
  if (!std::filesystem::is_directory(folder)) {
    throw InputError(fmt::format("{} {}: not a folder", option, folder.string()));
  }
}

double seconds_since(std::chrono::steady_clock::time_point start) {
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
}

Outputs::Outputs(Simulation& simulation, const std::optional<std::filesystem::path>& report,
                 const std::optional<std::filesystem::path>& trace, const std::optional<std::filesystem::path>& model)
    : report_(simulation.session().model()) {
  Session& session = simulation.session();
  if (report) report_file_.emplace(*report, "--report");
  if (model) write_whole(*model, "--save-model", simulation.model_text());
  session.add(report_);
  if (trace) session.add(trace_.emplace(session.model(), *trace));
}

std::string whole_profile(const std::string& robot, const std::optional<std::filesystem::path>& model) {
  const std::filesystem::path file = profile_file(robot);
  const bool given = file.extension() == ".toml";
  const toml::table table = given ? parse_toml(file, "profile") : toml::table{{"model", file.filename().string()}};
  toml::table whole = complete(table, file.parent_path(), file.string()).table;
  if (model) whole.insert_or_assign("model", model->string());
  std::ostringstream text;
  text << whole << '\n';
  return text.str();
}

Origins origins_of(const std::string& robot, const RobotModel& model, const World& world) {
  std::string profile = whole_profile(robot);
  return {{{"baton", version()},
           {"mujoco", mj_versionString()},
           {"model_sum", checksum(read_input(model.profile().model, "model"))},
           {"world_sum", checksum(read_input(world.file(), "world"))},
           {"profile_sum", checksum(profile)}},
          std::move(profile)};
}

nlohmann::json recording_head(const std::string& robot, const std::string& world, long seed, Modes modes,
                              StateSource state, const RobotModel& model) {
  return {{"robot", robot},
          {"world", world},
          {"seed", seed},
          {"duration", to_string(modes.duration)},
          {"gait", to_string(modes.gait)},
          {"on_limit", to_string(modes.on_limit)},
          {"state", to_string(state)},
          {"drive", to_string(model.profile().drive)}};
}

std::unique_ptr<RecordingWriter> recording_of(const Session& session, const std::filesystem::path& file,
                                              nlohmann::json head, const Origins& origins, bool live,
                                              const std::vector<Push>& pushes) {
  head.update(origins.sums);
  return std::make_unique<RecordingWriter>(
      session.model(), file, head,
      RecordingWriter::Parameters{.live = live,
                                  .pushes = pushes,
                                  .attachments = {{"profile.toml", "application/toml", origins.profile}},
                                  .warn = [](const std::string& why) { spdlog::warn("{}; the run goes on", why); }});
}

void Outputs::record(Session& session, const std::filesystem::path& file, nlohmann::json head, bool live,
                     const std::vector<Push>& pushes) {
  const Origins origins = origins_of(head.at("robot"), session.model(), session.world());
  recording_ = recording_of(session, file, std::move(head), origins, live, pushes);
  session.add(*recording_);
}

nlohmann::json Outputs::write(const std::string& world, const std::string& on, long seed, double wall,
                              const nlohmann::json& extra) {
  nlohmann::json summary = report_.json(world, on, seed, wall);
  summary.update(extra);
  if (recording_) {  // it does not decide how the run ends
    const std::string incomplete = recording_->close();
    summary["recording"] = {{"complete", incomplete.empty()}, {"why", incomplete}};
  }
  std::string failed;
  const auto attempt = [&failed](const auto& done) {
    try {
      done();
    } catch (const std::runtime_error& error) {
      failed += (failed.empty() ? "" : "; ") + std::string(error.what());
    }
  };
  if (report_file_) attempt([&] { report_file_->write(summary.dump(2) + '\n'); });
  if (trace_) attempt([&] { trace_->close(); });
  if (!failed.empty()) throw std::runtime_error(failed);
  return summary;
}

}  // namespace baton::app
