/// The robots that tests run with: mighty, and the same biped 1.7 times larger with every name changed.
#pragma once

#include <gtest/gtest.h>

#include <random>
#include <string>
#include <vector>

#include "baton/model/robot_model.hpp"

namespace baton::test {

inline std::vector<std::string> robot_names() {
  return {"mighty", "scaled"};
}

/// Loaded once a process.
const RobotModel& robot(const std::string& name);

inline std::string name_of_param(const testing::TestParamInfo<std::string>& info) {
  return info.param;
}

}  // namespace baton::test
