#include "app/outputs.hpp"

#include <fmt/format.h>

#include <cmath>

#include "baton/model/error.hpp"

namespace baton::app {

std::optional<std::ofstream> open_output(const std::optional<std::filesystem::path>& file, const std::string& option) {
  if (!file) return std::nullopt;
  std::ofstream out(*file);
  if (!out) throw InputError(fmt::format("{} {}: cannot be written", option, file->string()));
  return out;
}

void make_folder(const std::filesystem::path& folder, const std::string& option) {
  std::error_code error;
  std::filesystem::create_directories(folder, error);
  if (error) throw InputError(fmt::format("{} {}: {}", option, folder.string(), error.message()));
  if (!std::filesystem::is_directory(folder)) {
    throw InputError(fmt::format("{} {}: not a folder", option, folder.string()));
  }
}

std::string script_line(double t, const Command& command) {
  const auto number = [](double value) -> std::string {
    if (std::isnan(value)) return "null";
    if (std::isinf(value)) return value > 0.0 ? "1e308" : "-1e308";
    return value == 0.0 && std::signbit(value) ? "-0.0" : fmt::format("{}", value);
  };
  std::string axes;
  for (const double axis : command.axes)
    axes += (axes.empty() ? "" : ", ") + number(axis);
  const char* recall = command.recall == Recall::retrace ? R"(, "retrace": true)"
                       : command.recall == Recall::home  ? R"(, "home": true)"
                       : command.recall == Recall::stop  ? R"(, "stop": true)"
                                                         : "";
  return fmt::format(R"({{"t": {}, "guide": "{}", "axes": [{}], "lift": [{}, {}]{}}})", number(t),
                     to_string(command.guide), axes, number(command.lift.left), number(command.lift.right), recall);
}

Outputs::Outputs(const RobotModel& robot, Session& session, const std::optional<std::filesystem::path>& report,
                 const std::optional<std::filesystem::path>& trace, const std::optional<std::filesystem::path>& model)
    : report_(robot), report_file_(open_output(report, "--report")) {
  if (auto file = open_output(model, "--save-model")) *file << session.model_text();
  if (trace) trace_.emplace(robot, *trace);
  session.on_tick = [this](const TickRecord& record) {
    report_.add(record);
    if (trace_) trace_->add(record);
    if (recording_) recording_->add(record, record.truth.fallen);
  };
  session.on_plan = [this](const PlanRecord& record) { report_.add(record); };
}

void Outputs::record(Session& session, const std::filesystem::path& file, const nlohmann::json& head) {
  recording_.emplace(file, head);
  session.on_event = [this](PlanningEvent event) { recording_->add(event); };
}

nlohmann::json Outputs::write(const std::string& world, const std::string& on, long seed, double wall,
                              const nlohmann::json& extra) {
  nlohmann::json summary = report_.json(world, on, seed, wall);
  summary.update(extra);
  bool written = true;
  if (report_file_) {
    *report_file_ << summary.dump(2) << '\n';
    written = report_file_->flush().good();
  }
  if (trace_) written = trace_->close() && written;
  if (recording_) written = recording_->close() && written;
  if (!written)
    throw std::runtime_error("the trace, the recording or the report could not be written whole: is the disk full?");
  return summary;
}

}  // namespace baton::app
