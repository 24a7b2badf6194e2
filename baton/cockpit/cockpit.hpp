/// The web page's server: HTTP and WebSocket on this machine alone, read by pages that this server itself
/// gave out. One page drives, the others watch (docs/page.md).
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
    std::string host = "127.0.0.1";  ///< address to listen at: 127.0.0.1 (localhost) or [::1]
    int port = 8080;                 ///< 0: any that is free
    std::filesystem::path page{};    ///< folder of the built page
    double period = 1.0 / 30.0;      ///< least time between two states for one page [s]
    int pages = 8;                   ///< most pages at a time
    /// By which the driver's silence is counted [s]; never goes back, and any thread calls it.
    std::function<double()> clock = [] {
      return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count();
    };
  };

  /// Listens from now on. `scene` is the world named `world` composed with the robot, as compiled; it is read
  /// here and not kept. The robot must outlive the cockpit.
  /// @throws InputError the host is not this machine; the port is out of range, in use, or may not be opened
  Cockpit(const Parameters& parameters, const RobotModel& robot, const std::string& world, const mjModel& scene);
  /// Closes all connections.
  ~Cockpit();
  Cockpit(const Cockpit&) = delete;
  Cockpit& operator=(const Cockpit&) = delete;

  [[nodiscard]] int port() const;
  /// Address of the page.
  [[nodiscard]] std::string url() const;

  /// How many pages are open.
  [[nodiscard]] std::size_t pages() const;

  /// Hands over the newest moment; the one before is dropped if it was not sent yet. Does not wait for any
  /// page. Called by one thread.
  void publish(Frame frame);

  /// The driver's stick; any thread may read it.
  [[nodiscard]] Device& device();

 private:
  class Server;
  std::unique_ptr<Server> server_;
};

}  // namespace baton
