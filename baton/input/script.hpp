/// A device that plays commands from a file (format in docs/input.md): JSON Lines such as
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

/// Each command is held until the next. Axes and lifts are clamped; `null` becomes NaN, as from a broken device.
class Script : public Device {
 public:
  struct Entry {
    double t = 0.0;  ///< [s], from the start of the run
    Command command;
  };

  /// Reads a whole file.
  /// @throws InputError the file cannot be read or holds no command; a line is not a JSON object, lacks `t`, has an
  /// unknown or repeated key or an invalid value; `t` decreases or exceeds one day
  [[nodiscard]] static Script load(const std::filesystem::path& file);

  /// The same, also from a pipe, which is read to its end unless `stop` becomes true.
  /// @throws std::runtime_error stopped
  [[nodiscard]] static Script load(const std::filesystem::path& file, const std::atomic<bool>& stop);

  /// The same from text; messages use `name` in place of the file.
  [[nodiscard]] static Script parse(std::string_view text, std::string name);

  /// @throws InputError a time is not finite, negative, or less than the one before
  explicit Script(std::vector<Entry> entries, std::string name = "script");

  /// The last entry not later than `t`; neutral before the first. Always armed.
  [[nodiscard]] Command read(double t) override;
  [[nodiscard]] DeviceStatus status() const override;

  /// Time of the last entry [s]; 0 if there is none.
  [[nodiscard]] double duration() const { return entries_.empty() ? 0.0 : entries_.back().t; }
  [[nodiscard]] const std::vector<Entry>& entries() const { return entries_; }

 private:
  std::vector<Entry> entries_;
  std::string name_;
};

/// A script line that reproduces the command exactly; infinities become large numbers, which have the same effect.
[[nodiscard]] std::string script_line(double t, const Command& command);

}  // namespace baton
