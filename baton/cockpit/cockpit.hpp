/// HTTP and WebSocket server of the web page. Serves this machine and its own pages only. One page drives, the others
/// watch (docs/page.md).
#pragma once

#include <chrono>
#include <filesystem>
#include <functional>
#include <memory>
#include <string>

#include "baton/cockpit/frame.hpp"
#include "baton/model/robot_model.hpp"

namespace baton {

class Cockpit {
 public:
  struct Parameters {
    std::string host = "127.0.0.1";  ///< listening address: 127.0.0.1 (localhost) or [::1]
    int port = 8080;                 ///< 0: any free port
    std::filesystem::path page{};    ///< folder of the built page
    double period = 1.0 / 30.0;      ///< least time between two state messages to a page [s]
    int pages = 8;                   ///< most simultaneous pages
    /// Monotonic clock for the driver's heartbeat [s]; called by any thread.
    std::function<double()> clock = [] {
      return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count();
    };
  };

  /// Starts to listen. `scene` is the compiled model of robot and the world named `world`; it is not kept. `robot` must
  /// outlive this object.
  /// @throws InputError the host is not this machine; the port is out of range, in use or not permitted
  Cockpit(const Parameters& parameters, const RobotModel& robot, const std::string& world, const mjModel& scene);
  /// Closes all connections.
  ~Cockpit();
  Cockpit(const Cockpit&) = delete;
  Cockpit& operator=(const Cockpit&) = delete;

  [[nodiscard]] int port() const;
  /// Address of the page.
  [[nodiscard]] std::string url() const;

  /// Number of open pages.
  [[nodiscard]] std::size_t pages() const;

  /// Publishes the newest frame; replaces one not sent yet. Does not wait for pages. Call from one thread.
  void publish(Frame frame);

  /// Whether any page, driving or not, has asked for the motors to only brake.
  [[nodiscard]] bool damp_asked() const;

  /// The driver's stick; can be read by any thread.
  [[nodiscard]] Device& device();

 private:
  class Server;
  std::unique_ptr<Server> server_;
};

}  // namespace baton
