#include "baton/record/output_file.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <stdexcept>
#include <utility>

#include "baton/model/error.hpp"

namespace baton {
namespace {

constexpr int kLinks = 40;  ///< symbolic links followed, as in the kernel

std::string failure(const std::filesystem::path& file, const std::string& what, int error) {
  return fmt::format("{} {}: cannot be written: {}", what, file.string(),
                     error == ENXIO ? "it has no reader" : std::strerror(error));
}

/// Opens an existing file without blocking or truncating.
int open_existing(const std::filesystem::path& file) {
  return open(file.c_str(), O_WRONLY | O_NONBLOCK | O_CLOEXEC);
}

bool same(const struct stat& a, const struct stat& b) {
  return a.st_dev == b.st_dev && a.st_ino == b.st_ino;
}

}  // namespace

std::filesystem::path link_target(const std::filesystem::path& file) {
  std::filesystem::path target = file;
  std::error_code ignored;
  for (int i = 0; i < kLinks && std::filesystem::is_symlink(target, ignored); ++i)
    target = target.parent_path() / std::filesystem::read_symlink(target, ignored);
  return target;
}

OutputFile::OutputFile(std::filesystem::path file, std::string what) : file_(std::move(file)), what_(std::move(what)) {
  const auto refuse = [this] { throw InputError(failure(file_, what_, errno)); };
  struct stat old {};
  const bool exists = stat(file_.c_str(), &old) == 0;
  if (file_.empty() || (!exists && errno != ENOENT)) refuse();
  if (exists) {
    for (const int standard : {STDOUT_FILENO, STDERR_FILENO}) {  // `/dev/stdout`, whatever it is connected to
      struct stat other {};
      if (fstat(standard, &other) == 0 && same(old, other)) {
        fd_ = fcntl(standard, F_DUPFD_CLOEXEC, 0);
        return;
      }
    }
    fd_ = open_existing(file_);
    if (fd_ < 0) refuse();
    if (!S_ISREG(old.st_mode)) {
      fcntl(fd_, F_SETFL, 0);  // back to blocking writes
      return;
    }
    close(std::exchange(fd_, -1));
  }
  target_ = link_target(file_);
  for (int i = 0; fd_ < 0; ++i) {
    fresh_ = target_;
    fresh_ += fmt::format(".{}.tmp", i);
    fd_ = open(fresh_.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, 0666);
    if (fd_ < 0 && errno != EEXIST) refuse();
  }
  if (exists) {
    fchmod(fd_, old.st_mode & 07777U);
    [[maybe_unused]] const int kept = fchown(fd_, old.st_uid, old.st_gid);  // may fail; the file then belongs to us
  }
}

OutputFile::~OutputFile() {
  if (fd_ >= 0) close(fd_);
  if (!fresh_.empty()) unlink(fresh_.c_str());
}

void OutputFile::write(std::string_view text) {
  const auto fail = [this] { throw std::runtime_error(not_whole(file_, what_, errno)); };
  while (!text.empty()) {
    const ssize_t n = ::write(fd_, text.data(), text.size());
    if (n < 0 && errno != EINTR) fail();
    if (n > 0) text.remove_prefix(static_cast<std::size_t>(n));
  }
  if (close(std::exchange(fd_, -1)) != 0) fail();
  if (fresh_.empty()) return;
  if (std::rename(fresh_.c_str(), target_.c_str()) != 0) fail();
  fresh_.clear();
}

void write_whole(const std::filesystem::path& file, const std::string& what, std::string_view text) {
  OutputFile(file, what).write(text);
}

std::string not_whole(const std::filesystem::path& file, const std::string& what, int error) {
  return fmt::format("{} {}: could not be written completely: {}", what, file.string(),
                     error == 0 ? "is the disk full?" : std::strerror(error));
}

int open_descriptor(const std::filesystem::path& file, const std::string& what) {
  const int fd = open(file.c_str(), O_WRONLY | O_CREAT | O_TRUNC | O_NONBLOCK | O_CLOEXEC, 0666);
  if (fd < 0) throw InputError(failure(file, what, errno));
  return fd;
}

std::ofstream open_stream(const std::filesystem::path& file, const std::string& what) {
  const int there = open_existing(file);  // opening a pipe without a reader would block for ever
  const int error = errno;
  std::ofstream stream;
  if (there >= 0 || error == ENOENT) stream.open(file);
  if (there >= 0) close(there);
  if (!stream.is_open()) throw InputError(failure(file, what, there < 0 && error != ENOENT ? error : errno));
  return stream;
}

void close_stream(std::ofstream& stream, const std::filesystem::path& file, const std::string& what) {
  errno = 0;
  stream.close();
  if (stream.fail()) throw std::runtime_error(not_whole(file, what, errno));
}

}  // namespace baton
