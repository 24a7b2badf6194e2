#include "baton/cockpit/page_files.hpp"

#include <array>
#include <fstream>
#include <iterator>
#include <utility>

namespace baton {

std::optional<std::filesystem::path> file_in(const std::filesystem::path& folder, std::string_view request) {
  std::error_code error;
  for (std::filesystem::recursive_directory_iterator it(folder, error), end; !error && it != end; it.increment(error)) {
    std::error_code ignored;
    const std::string name = "/" + it->path().lexically_relative(folder).generic_string();
    if (name == request && it->is_regular_file(ignored)) return it->path();
  }
  return std::nullopt;
}

std::optional<std::string> read_file(const std::filesystem::path& path) {
  std::ifstream file(path, std::ios::binary);
  if (!file) return std::nullopt;
  return std::string(std::istreambuf_iterator<char>(file), {});
}

std::string_view mime_type(const std::filesystem::path& file) {
  constexpr std::array<std::pair<std::string_view, std::string_view>, 9> types{{
      {".html", "text/html; charset=utf-8"},
      {".js", "text/javascript; charset=utf-8"},
      {".css", "text/css; charset=utf-8"},
      {".json", "application/json"},
      {".svg", "image/svg+xml"},
      {".png", "image/png"},
      {".ico", "image/x-icon"},
      {".woff2", "font/woff2"},
      {".txt", "text/plain; charset=utf-8"},
  }};
  for (const auto& [extension, type] : types) {
    if (file.extension() == extension) return type;
  }
  return "application/octet-stream";
}

}  // namespace baton
