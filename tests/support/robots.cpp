#include "tests/support/robots.hpp"

#include <filesystem>
#include <map>
#include <memory>

namespace baton::test {

const RobotModel& robot(const std::string& name) {
  static std::map<std::string, std::unique_ptr<RobotModel>> loaded;
  auto& robot = loaded[name];
  if (!robot) {
    const std::filesystem::path file =
        name == "scaled" ? std::filesystem::path(BATON_SCALED_ROBOT) / "profile.toml" : std::filesystem::path(name);
    robot = std::make_unique<RobotModel>(RobotModel::load(file.string()));
  }
  return *robot;
}

}  // namespace baton::test
