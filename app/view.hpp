/// Publishes a session to the page.
#pragma once

#include <string>

#include "app/refusals.hpp"
#include "baton/cockpit/cockpit.hpp"
#include "baton/run/simulation.hpp"

namespace baton::app {

class View {
 public:
  /// @param damps whether the page has a key that damps the robot
  /// @throws InputError the port is in use
  View(const Simulation& simulation, int port, bool damps);

  [[nodiscard]] std::string url() const { return cockpit_.url(); }
  [[nodiscard]] Device& device() { return cockpit_.device(); }

  /// Number of open pages.
  [[nodiscard]] std::size_t pages() const { return cockpit_.pages(); }

  /// Whether a page has asked for the motors to only brake.
  [[nodiscard]] bool damp_asked() const { return cockpit_.damp_asked(); }

  /// Publishes the current state, at most 30 times per second of run time.
  /// @param notice what the operator has to know, if nothing about the robot itself is more urgent; "": nothing
  void show(const Simulation& simulation, const DeviceStatus& device, const Refusals& refusals,
            const std::string& notice = "");

 private:
  bool damps_;
  ModelPtr scene_;
  DataPtr data_;
  Cockpit cockpit_;
  double shown_ = -1.0;
  double steady_ = 0.0;    ///< last time without a push [s]
  long caught_ = 0;        ///< capture steps until then
  double slipped_ = -1e9;  ///< time of the last detected slip [s]
  double segment_start_ = 0.0;
};

/// What a robot with hot motors says; else empty.
[[nodiscard]] std::string heat_message(const Session& session);

/// What a robot says whose arms cannot follow what drives them; else empty.
[[nodiscard]] std::string arms_message(const Session& session);

}  // namespace baton::app
