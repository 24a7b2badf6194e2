/// A robot whose model file is another one by a few words.
#pragma once

#include <fstream>
#include <sstream>
#include <string>

#include "tests/support/robots.hpp"
#include "tests/support/temp.hpp"

namespace baton::test {

/// `robot` with the text of its model file changed.
/// @param name of the changed file, without its ending
/// @param change text → changed text
template <typename Change>
RobotModel with_changed_model(const RobotModel& robot, const std::string& name, Change change) {
  Profile profile = robot.profile();
  std::ostringstream text;
  text << std::ifstream(profile.model).rdbuf();
  const std::string changed = change(text.str());
  EXPECT_NE(changed, text.str());
  profile.model = temp_folder() + name + ".xml";
  std::ofstream(profile.model) << changed;
  return RobotModel(std::move(profile));
}

}  // namespace baton::test
