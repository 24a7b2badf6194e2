#include <fmt/format.h>

#include <algorithm>
#include <vector>

#include "app/app.hpp"
#include "app/commands.hpp"
#include "app/outputs.hpp"
#include "baton/model/error.hpp"
#include "baton/model/robot_model.hpp"
#include "baton/model/toml_reader.hpp"

namespace baton::app {

int robots() {
  std::vector<std::filesystem::path> profiles;
  std::error_code ignored;
  for (const auto& entry : std::filesystem::directory_iterator(share_dir() / "robots", ignored)) {
    if (std::filesystem::exists(entry.path() / "profile.toml", ignored))
      profiles.push_back(entry.path() / "profile.toml");
  }
  std::ranges::sort(profiles);
  for (const std::filesystem::path& file : profiles) {
    const toml::table profile = parse_toml(file, "profile");
    const auto model = file.parent_path() / profile["model"].value_or(std::string());
    fmt::print("{:10}  {}\n", file.parent_path().filename().string(),
               std::filesystem::exists(model, ignored) ? model.string() : "its model is not there: run `make robots`");
  }
  return kDone;
}

int profile(const std::string& robot) {
  const std::filesystem::path model = RobotModel::load(robot).profile().model;
  fmt::print("{}", whole_profile(robot, std::filesystem::absolute(model)));
  return kDone;
}

}  // namespace baton::app
