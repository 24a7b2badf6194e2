#include "app/reproduce.hpp"

#include "app/commands.hpp"
#include "app/outputs.hpp"

namespace baton::app {

int reproduce(const ReproduceOptions& options) {
  make_folder(options.out, "--out");
  if (options.what == "fig8") return reproduce_fig8(options.out);
  return options.what == "room" ? reproduce_room(options.out) : reproduce_walks(options.out);
}

}  // namespace baton::app
