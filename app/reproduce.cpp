#include "app/reproduce.hpp"

#include <fmt/format.h>

#include "app/commands.hpp"
#include "baton/model/error.hpp"

namespace baton::app {

int reproduce(const ReproduceOptions& options) {
  std::error_code error;
  std::filesystem::create_directories(options.out, error);
  if (error) throw InputError(fmt::format("--out {}: {}", options.out.string(), error.message()));
  if (!std::filesystem::is_directory(options.out))
    throw InputError(fmt::format("--out {}: not a folder", options.out.string()));
  return options.what == "fig8" ? reproduce_fig8(options.out) : reproduce_room(options.out);
}

}  // namespace baton::app
