/// What a profile leaves out, derived from the model (docs/robots.md says how each value comes about).
///
/// Lengths scale with the COM height h, ZMP margins with the sole's half-width w, times with 1/ω = √(h/g); the factors
/// are those of mighty, with which they were tuned. Parts are found without looking at names (`find_parts`).
#pragma once

#include <toml++/toml.h>

#include <filesystem>
#include <map>
#include <string>
#include <vector>

namespace baton {

/// A profile with all of its keys.
struct CompleteProfile {
  toml::table table;
  std::map<std::string, std::string> sources;  ///< key → where a value comes from that the file does not give
  std::vector<std::string> warnings;           ///< what the model lacks and was assumed, a line each
};

/// Adds values of no particular robot, so that what is given can be validated before a model is looked at.
[[nodiscard]] CompleteProfile of_no_robot(const toml::table& given);

/// Adds what is missing to the contents of a profile. Values of the file stay, and what depends on them follows them.
/// @param given contents of a profile, as validated with `of_no_robot`; needs `model`, relative to `folder`
/// @param file name of the profile, for messages
/// @throws InputError no model, or one in which the parts of a humanoid are not found; the message lists all findings
[[nodiscard]] CompleteProfile complete(const toml::table& given, const std::filesystem::path& folder,
                                       const std::string& file);

}  // namespace baton
