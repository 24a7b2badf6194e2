/// The built page as files to be served.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <string_view>

namespace baton {

/// The file of a folder that a request names. The folder's own listing is compared with the request, so no
/// request can name a place outside.
[[nodiscard]] std::optional<std::filesystem::path> file_in(const std::filesystem::path& folder,
                                                           std::string_view request);

/// Content of a file; nothing if it cannot be read.
[[nodiscard]] std::optional<std::string> read_file(const std::filesystem::path& path);

/// Content-Type by the file's extension.
[[nodiscard]] std::string_view mime_type(const std::filesystem::path& file);

}  // namespace baton
