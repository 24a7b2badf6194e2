/// A run as CSV, one row per tick (columns in docs/trace.md). Without truth, columns that only a simulator knows are
/// `nan`.
#pragma once

#include <filesystem>
#include <fstream>
#include <string>

#include "baton/record/output_file.hpp"
#include "baton/run/sink.hpp"

namespace baton {

class Trace : public Sink {
 public:
  /// Opens the file and writes the header.
  /// @param what prefix of every message: the option that names the file
  /// @throws InputError the file cannot be written
  Trace(const RobotModel& robot, const std::filesystem::path& file, std::string what = "--trace");

  void on_tick(const TickRecord& record) override;

  /// @throws std::runtime_error the file was not written completely
  void close() { close_stream(out_, file_, what_); }

 private:
  const RobotModel* robot_;
  Kinematics kinematics_;
  std::filesystem::path file_;
  std::string what_;
  std::ofstream out_;
};

/// Measured ZMP: where the line of action of the total sole force meets the plane z = height [m]; not finite in the
/// air.
[[nodiscard]] Vec2 measured_zmp(const Truth& truth, double height);

}  // namespace baton
