/// What the page shows of a session.
#pragma once

#include <string>

#include "app/refusals.hpp"
#include "baton/cockpit/cockpit.hpp"
#include "baton/run/simulation.hpp"

namespace baton::app {

class View {
 public:
  /// @throws InputError the port is in use
  View(const Simulation& simulation, int port);

  [[nodiscard]] std::string url() const { return cockpit_.url(); }
  [[nodiscard]] Device& device() { return cockpit_.device(); }

  /// How many pages are open.
  [[nodiscard]] std::size_t pages() const { return cockpit_.pages(); }

  /// Shows the present moment, at most 30 times a second of the run.
  void show(const Simulation& simulation, const DeviceStatus& device, const Refusals& refusals);

 private:
  ModelPtr scene_;
  DataPtr data_;
  Cockpit cockpit_;
  double shown_ = -1.0;
  double steady_ = 0.0;    ///< when it was last not pushed off its way [s]
  long caught_ = 0;        ///< steps that were to catch it, until then
  double slipped_ = -1e9;  ///< when it was found to have slipped last [s]
  double segment_start_ = 0.0;
};

/// What the robot does, in a word.
[[nodiscard]] Activity activity(const Session& session);

}  // namespace baton::app
