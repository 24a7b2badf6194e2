#include "module.hpp"
#include "baton/model/mujoco.hpp"

NB_MODULE(_core, m) {
  using namespace baton::python;
  // At exit the interpreter need not free the objects of the user's modules; nanobind would call that a leak.
  nb::set_leak_warnings(false);
  nb::exception<baton::InputError>(m, "InputError", PyExc_ValueError);
  baton::share_mujoco();
  m.def("share_dir", &baton::share_dir, "Folder of robots/ and worlds/.");
  m.def("use_share_dir", &baton::use_share_dir, nb::arg("folder"),
        "Look for robots/ and worlds/ in this folder, unless $BATON_SHARE names another.");
  bind_robot(m);
  bind_signals(m);
  bind_events(m);
  bind_run(m);
}
