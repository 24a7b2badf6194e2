#include "baton/link/token.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "baton/model/error.hpp"
#include "baton/model/input_file.hpp"

namespace baton::link {
namespace {

constexpr std::size_t kLongestToken = 1000;

}  // namespace

std::string token_in(const std::optional<std::filesystem::path>& file) {
  if (!file) return "";
  const std::string text = read_input(*file, "token");
  constexpr const char* kSpace = " \t\r\n";
  const auto begin = text.find_first_not_of(kSpace);
  if (begin == std::string::npos) throw InputError(fmt::format("--token {}: is empty", file->string()));
  const std::string token = text.substr(begin, text.find_last_not_of(kSpace) + 1 - begin);
  if (token.size() > kLongestToken || std::ranges::any_of(token, [](char c) { return c < 0x20 || c > 0x7e; }))
    throw InputError(
        fmt::format("--token {}: must be one line of at most {} ASCII characters", file->string(), kLongestToken));
  return token;
}

}  // namespace baton::link
