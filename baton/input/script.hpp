/// A device that plays a file of commands (docs/input.md has the format): JSON Lines such as
/// `{"t": 1.25, "guide": "left_hand", "axes": [x, y, z, roll, pitch, yaw], "lift": [left, right]}`
/// or `{"t": 6, "retrace": true}`
#pragma once

#include <atomic>
#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#include "baton/input/device.hpp"

namespace baton {

/// Each command is held until the next. Axes and lifts are clamped; `null` stays a NaN, as a broken device
/// would give.
class Script : public Device {
 public:
  struct Entry {
    double t = 0.0;  ///< [s], from the start of the run
    Command command;
  };

  /// Reads a whole file.
  /// @throws InputError the file cannot be read or holds no command; a line is not a JSON object, lacks `t`,
  /// has an unknown key, one key twice, or a value that its key does not take; `t` is less than on the line
  /// before, or more than a day
  [[nodiscard]] static Script load(const std::filesystem::path& file);

  /// The same, and of a pipe too, which is read to its end unless `stop` becomes true before.
  /// @throws std::runtime_error stopped
  [[nodiscard]] static Script load(const std::filesystem::path& file, const std::atomic<bool>& stop);

  /// The same, of the text itself; `name` stands for the file in messages.
  [[nodiscard]] static Script parse(std::string_view text, std::string name);

  /// @throws InputError a time is not finite, negative, or less than the one before
  explicit Script(std::vector<Entry> entries, std::string name = "script");

  /// The last entry that is not later than `t`; neutral before the first. Armed at once.
  [[nodiscard]] Command read(double t) override;
  [[nodiscard]] DeviceStatus status() const override;

  /// Time of the last entry [s]; 0 if there is none.
  [[nodiscard]] double duration() const { return entries_.empty() ? 0.0 : entries_.back().t; }
  [[nodiscard]] const std::vector<Entry>& entries() const { return entries_; }

 private:
  std::vector<Entry> entries_;
  std::string name_;
};

/// A command as a line of a script that gives the very same command; infinities become large numbers, which count
/// alike.
[[nodiscard]] std::string script_line(double t, const Command& command);

}  // namespace baton
