#include "app/reproduce.hpp"

#include "app/commands.hpp"
#include "app/outputs.hpp"

namespace baton::app {

int reproduce(const ReproduceOptions& options) {
  make_folder(options.out, "--out");
  return options.what == "fig8" ? reproduce_fig8(options.out) : reproduce_room(options.out);
}

}  // namespace baton::app
