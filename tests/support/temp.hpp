/// A folder of this process's own, so that tests can run side by side; gone when the process ends.
#pragma once

#include <unistd.h>

#include <filesystem>
#include <string>

namespace baton::test {

/// Its path, with a slash at the end.
inline std::string temp_folder() {
  struct Folder {
    std::filesystem::path path = std::filesystem::temp_directory_path() / ("baton_test_" + std::to_string(getpid()));
    Folder() { std::filesystem::create_directories(path); }
    ~Folder() {
      std::error_code ignored;
      std::filesystem::remove_all(path, ignored);
    }
  };
  static const Folder folder;
  return folder.path.string() + "/";
}

}  // namespace baton::test
