/// Targets for arms from a file (format in docs/input.md): JSON Lines such as
/// `{"t": 1.0, "joints": ["left_elbow"], "at": [2.0, 2.5], "q": [[0.3], [0.6]]}`: known from `t` on, the joint is to be
/// at 0.3 rad at 2 s, and at 0.6 rad at 2.5 s. Without `at` and `q` the joints are let go of.
#pragma once

#include <filesystem>
#include <string_view>
#include <vector>

#include "baton/guide/arm_trajectory.hpp"

namespace baton {

class ArmScript {
 public:
  struct Entry {
    double t = 0.0;  ///< from the start of the run [s]
    ArmTargets targets;
  };

  /// @throws InputError the file cannot be read or holds no targets; a line is not as above, or no such robot has the
  /// joints; `t` decreases
  [[nodiscard]] static ArmScript load(const std::filesystem::path& file, const RobotModel& robot);
  /// The same from text; messages use `name` in place of the file.
  [[nodiscard]] static ArmScript parse(std::string_view text, const std::string& name, const RobotModel& robot);

  /// The next targets that are known at `t`; null: none that were not returned before.
  [[nodiscard]] const ArmTargets* next(double t);

 private:
  explicit ArmScript(std::vector<Entry> entries) : entries_(std::move(entries)) {}

  std::vector<Entry> entries_;
  std::size_t next_ = 0;
};

}  // namespace baton
