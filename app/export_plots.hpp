/// Plots of a recording: joints, torques, balance, IMU, stick.
#pragma once

#include <filesystem>
#include <map>
#include <set>
#include <string>
#include <vector>

#include "baton/record/plot.hpp"

namespace baton::app {

class ExportPlots {
 public:
  /// @param names of the columns of each topic
  /// @param duration [s]
  ExportPlots(const std::map<std::string, std::set<std::string>>& names, double duration);

  /// Adds a value; ignored unless it is plotted. Of many values in a row a few are kept.
  void add(const std::string& topic, const std::string& column, double t, const std::string& value);

  /// @throws InputError, std::runtime_error as `save_plot`
  void save(const std::filesystem::path& folder) const;

 private:
  /// Where a column is drawn.
  struct Place {
    std::string file;
    std::size_t panel = 0;
    std::size_t series = 0;
  };

  Panel& panel(const std::string& file, const std::string& title, const std::string& y_label);
  /// Draws a column in the panel that was added last to the file, if the recording has it.
  void draw(const std::string& file, const std::string& topic, const std::string& column, const std::string& name);

  const std::map<std::string, std::set<std::string>>* names_;
  double step_;  ///< from point to point [s]
  std::map<std::string, std::vector<Panel>> files_;
  std::map<std::pair<std::string, std::string>, Place> places_;
};

}  // namespace baton::app
