/// A robot with soles of other sizes.
#pragma once

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <fstream>
#include <regex>
#include <sstream>

#include "tests/support/robots.hpp"
#include "tests/support/temp.hpp"

namespace baton::test {

/// mighty with soles of these half-lengths and half-widths [m].
inline RobotModel with_soles(const RobotModel& mighty, double length, double width) {
  Profile profile = mighty.profile();
  std::ostringstream text;
  text << std::ifstream(profile.model).rdbuf();
  const std::regex sole(R"re((name="\S+_sole_col" class="sole" type="box" pos="[^"]*") size="\S+ \S+ )re");
  const std::string model = std::regex_replace(text.str(), sole, fmt::format("$1 size=\"{} {} ", length, width));
  EXPECT_NE(model, text.str());
  profile.model = temp_folder() + fmt::format("soles_{}_{}.xml", length, width);
  std::ofstream(profile.model) << model;
  return RobotModel(std::move(profile));
}

}  // namespace baton::test
