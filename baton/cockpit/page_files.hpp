/// Static files of the built page.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <string_view>

namespace baton {

/// The file in a folder that a request names. The request is matched against the folder's listing, so it cannot reach
/// outside.
[[nodiscard]] std::optional<std::filesystem::path> file_in(const std::filesystem::path& folder,
                                                           std::string_view request);

/// Content of a file; none if unreadable.
[[nodiscard]] std::optional<std::string> read_file(const std::filesystem::path& path);

/// Content-Type by file extension.
[[nodiscard]] std::string_view mime_type(const std::filesystem::path& file);

}  // namespace baton
