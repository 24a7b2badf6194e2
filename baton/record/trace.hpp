/// A run as CSV, one row per tick (columns in docs/trace.md). Without truth, columns that only a simulator knows are
/// `nan`.
#pragma once

#include <filesystem>
#include <fstream>

#include "baton/record/output_file.hpp"
#include "baton/run/sink.hpp"

namespace baton {

class Trace : public Sink {
 public:
  /// Opens the file and writes the header.
  /// @throws InputError the file cannot be written
  Trace(const RobotModel& robot, const std::filesystem::path& file);

  void on_tick(const TickRecord& record) override;

  /// @throws std::runtime_error the file was not written completely
  void close() { close_stream(out_, file_, "--trace"); }

 private:
  const RobotModel* robot_;
  Kinematics kinematics_;
  std::filesystem::path file_;
  std::ofstream out_;
};

/// Measured ZMP: where the line of action of the total sole force meets the plane z = height [m]; not finite in the
/// air.
[[nodiscard]] Vec2 measured_zmp(const Truth& truth, double height);

}  // namespace baton
