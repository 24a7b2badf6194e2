/// The file of a recording that is being written.
#pragma once

#include <sys/types.h>

#include <atomic>
#include <filesystem>
#include <string>
#include <thread>

#include "baton/mcap/writer.hpp"

namespace baton {

/// A regular file always ends with a valid end. A pipe or a device has it only when the recording is finished.
class RecordingFile : public mcap::Output {
 public:
  /// @throws InputError the file cannot be opened, or is a pipe without a reader
  RecordingFile(std::filesystem::path file, std::string what);
  ~RecordingFile() override;
  RecordingFile(const RecordingFile&) = delete;
  RecordingFile& operator=(const RecordingFile&) = delete;

  /// @throws std::runtime_error the disk is full, or the reader of a pipe is gone or does not read for 5 s. A regular
  /// file then is what it was before.
  void write(std::string_view bytes, std::string_view end) override;
  /// Begins to sync, on a thread of its own: writing goes on meanwhile.
  /// @throws std::runtime_error an earlier one has failed
  void sync() override;

 private:
  [[nodiscard]] bool write_at(std::string_view bytes, off_t offset) const;
  void write_on(std::string_view bytes) const;
  void sync_when_asked();

  std::filesystem::path file_;
  std::string what_;
  int fd_ = -1;
  bool regular_ = false;
  off_t offset_ = 0;
  std::string end_;  ///< what follows there
  std::string both_;
  std::atomic<unsigned> asked_{0};  ///< times that a sync was asked for
  std::atomic<bool> ending_{false};
  std::atomic<int> sync_error_{0};  ///< as in errno
  std::thread syncing_;             ///< from the first sync on
};

}  // namespace baton
