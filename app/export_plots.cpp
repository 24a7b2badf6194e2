#include "app/export_plots.hpp"

#include <cstdlib>

namespace baton::app {
namespace {

constexpr double kPoints = 2000.0;  ///< of a series

}  // namespace

ExportPlots::ExportPlots(const std::map<std::string, std::set<std::string>>& names, double duration)
    : names_(&names), step_(duration / kPoints) {
  const std::string position = "position_", effort = "effort_";
  if (const auto states = names.find("/joint_states"); states != names.end()) {
    for (const std::string& column : states->second) {
      if (column.starts_with(position)) {
        panel("joints", column.substr(position.size()), "[rad]");
        draw("joints", "/joint_states", column, "measured");
        draw("joints", "/joint_targets", column, "target");
      }
      if (column.starts_with(effort)) {
        panel("torques", column.substr(effort.size()), "[N·m]");
        draw("torques", "/joint_states", column, "");
      }
    }
  }
  for (const auto& [axis, i] : {std::pair<std::string, std::string>{"x", "0"}, {"y", "1"}}) {
    panel("balance", "COM and ZMP, " + axis, "[m]");
    draw("balance", "/baton/estimates", "com_" + i, "COM");
    draw("balance", "/baton/estimates", "zmp_plan_" + i, "ZMP, planned");
    draw("balance", "/baton/estimates", "zmp_" + i, "ZMP, commanded");
  }
  panel("balance", "COM, z", "[m]");
  draw("balance", "/baton/estimates", "com_2", "");
  panel("balance", "DCM, measured less planned", "[m]");
  draw("balance", "/baton/estimates", "dcm_error_0", "x");
  draw("balance", "/baton/estimates", "dcm_error_1", "y");
  panel("balance", "vertical force on the soles", "[N]");
  draw("balance", "/sole/left", "force_z", "left");
  draw("balance", "/sole/right", "force_z", "right");
  panel("balance", "heat of the hottest motor", "[permitted rise]");
  draw("balance", "/baton/estimates", "heat", "");
  panel("imu", "angular velocity", "[rad/s]");
  for (const std::string axis : {"x", "y", "z"})
    draw("imu", "/imu", "angular_velocity_" + axis, axis);
  panel("imu", "specific force", "[m/s²]");
  for (const std::string axis : {"x", "y", "z"})
    draw("imu", "/imu", "linear_acceleration_" + axis, axis);
  panel("stick", "axes", "");
  for (int i = 0; i < 6; ++i)
    draw("stick", "/joy", "axes_" + std::to_string(i),
         std::vector<std::string>{"x", "y", "z", "roll", "pitch", "yaw"}[static_cast<std::size_t>(i)]);
  panel("stick", "lift", "");
  draw("stick", "/joy", "axes_6", "left foot");
  draw("stick", "/joy", "axes_7", "right foot");
}

Panel& ExportPlots::panel(const std::string& file, const std::string& title, const std::string& y_label) {
  Panel& added = files_[file].emplace_back();
  added.title = title;
  added.x_label = "t [s]";
  added.y_label = y_label;
  return added;
}

void ExportPlots::draw(const std::string& file, const std::string& topic, const std::string& column,
                       const std::string& name) {
  const auto there = names_->find(topic);
  if (there == names_->end() || !there->second.contains(column)) return;
  std::vector<Panel>& panels = files_[file];
  places_[{topic, column}] = {file, panels.size() - 1, panels.back().series.size()};
  panels.back().series.push_back({.name = name, .points = {}, .colour = ""});
}

void ExportPlots::add(const std::string& topic, const std::string& column, double t, const std::string& value) {
  const auto place = places_.find({topic, column});
  if (place == places_.end()) return;
  Series& series = files_[place->second.file][place->second.panel].series[place->second.series];
  const double y = std::strtod(value.c_str(), nullptr);
  if (topic == "/joy" && !series.points.empty()) series.points.emplace_back(t, series.points.back().y());  // held
  if (topic != "/joy" && !series.points.empty() && t < series.points.back().x() + step_) return;
  series.points.emplace_back(t, y);
}

void ExportPlots::save(const std::filesystem::path& folder) const {
  for (const auto& [file, panels] : files_) {
    std::vector<Panel> drawn;
    for (const Panel& panel : panels) {
      if (!panel.series.empty()) drawn.push_back(panel);
    }
    if (!drawn.empty()) save_plot(folder / (file + ".svg"), drawn);
  }
}

}  // namespace baton::app
