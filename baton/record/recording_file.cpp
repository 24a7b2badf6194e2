#include "baton/record/recording_file.hpp"

#include <poll.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <stdexcept>
#include <utility>

#include "baton/record/output_file.hpp"

namespace baton {
namespace {

constexpr int kPatience = 5000;  ///< for the reader of a pipe [ms]

}  // namespace

RecordingFile::RecordingFile(std::filesystem::path file, std::string what)
    : file_(std::move(file)), what_(std::move(what)), fd_(open_descriptor(file_, what_)) {
  struct stat status {};
  regular_ = fstat(fd_, &status) == 0 && S_ISREG(status.st_mode);
}

RecordingFile::~RecordingFile() {
  if (syncing_.joinable()) {
    ending_ = true;
    ++asked_;
    asked_.notify_one();
    syncing_.join();  // after a last sync
  }
  close(fd_);
}

bool RecordingFile::write_at(std::string_view bytes, off_t offset) const {
  while (!bytes.empty()) {
    const ssize_t n = pwrite(fd_, bytes.data(), bytes.size(), offset);
    if (n < 0 && errno != EINTR) return false;
    if (n <= 0) continue;
    bytes.remove_prefix(static_cast<std::size_t>(n));
    offset += n;
  }
  return true;
}

void RecordingFile::write_on(std::string_view bytes) const {
  while (!bytes.empty()) {
    const ssize_t n = ::write(fd_, bytes.data(), bytes.size());
    if (n > 0) bytes.remove_prefix(static_cast<std::size_t>(n));
    if (n >= 0 || errno == EINTR) continue;
    if (errno != EAGAIN) throw std::runtime_error(not_whole(file_, what_, errno));
    pollfd writable{fd_, POLLOUT, 0};
    if (poll(&writable, 1, kPatience) == 0) throw std::runtime_error(not_whole(file_, what_, ETIMEDOUT));
  }
}

void RecordingFile::write(std::string_view bytes, std::string_view end) {
  if (!regular_) {
    write_on(bytes);
    return;
  }
  both_.assign(bytes).append(end);
  if (!write_at(both_, offset_)) {
    const int error = errno;
    // The old end had room there. Best effort: readers of ours do without.
    [[maybe_unused]] const bool cut = ftruncate(fd_, offset_) == 0 && write_at(end_, offset_);
    throw std::runtime_error(not_whole(file_, what_, error));
  }
  offset_ += static_cast<off_t>(bytes.size());
  end_ = end;
}

void RecordingFile::sync() {
  if (!regular_) return;
  if (const int error = sync_error_) throw std::runtime_error(not_whole(file_, what_, error));
  if (!syncing_.joinable()) syncing_ = std::thread([this] { sync_when_asked(); });
  ++asked_;
  asked_.notify_one();
}

void RecordingFile::sync_when_asked() {
  for (unsigned done = 0;;) {
    asked_.wait(done);
    done = asked_;
    const bool last = ending_;
    if (fdatasync(fd_) != 0 && errno != EINVAL && errno != ENOTSUP && errno != EINTR) sync_error_ = errno;
    if (last) return;
  }
}

}  // namespace baton
