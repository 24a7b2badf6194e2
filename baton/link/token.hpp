/// The secret that a driver must know.
#pragma once

#include <filesystem>
#include <optional>
#include <string>

namespace baton::link {

/// The token in the file of `--token`, without white space around it; "" without a file.
/// @throws InputError it cannot be read, is empty, or is not one line of ASCII
[[nodiscard]] std::string token_in(const std::optional<std::filesystem::path>& file);

}  // namespace baton::link
