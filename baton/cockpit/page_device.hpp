/// The web page as an input device: one page drives, the others watch.
#pragma once

#include <cstdint>
#include <functional>
#include <mutex>
#include <optional>
#include <utility>

#include "baton/input/arming.hpp"
#include "baton/input/device.hpp"

namespace baton {

/// Pages are identified by numbers. All functions are thread-safe.
///
/// A page can be gone while its connection lives: hidden, frozen, or behind a stalled network. So its messages serve as
/// a heartbeat, timed on arrival by a separate clock: run time stands still while a tick is late, and catches up
/// afterwards.
class PageDevice final : public Device {
 public:
  using Page = std::uint64_t;
  using Clock = std::function<double()>;  ///< monotonic [s]; called by any thread

  struct Parameters {
    double silence = 0.25;  ///< a driver silent for longer counts as gone [s, by the clock]
  };

  /// @throws InputError `silence` is not positive
  PageDevice(Clock clock, const Parameters& parameters);
  explicit PageDevice(Clock clock) : PageDevice(std::move(clock), Parameters{}) {}

  /// Gives the driver's seat to a page if it is free. Returns whether the page drives now.
  bool take(Page page);
  /// Frees the seat if this page holds it.
  void release(Page page);
  [[nodiscard]] std::optional<Page> driver() const;

  /// Takes a page's command; without the dead-man switch it counts as centred. Returns false if the page does not
  /// drive.
  bool give(Page page, const Command& command, bool deadman);

  /// The driver's newest command. Neutral, for the part chosen last, without a driver, and after a `silence` or a stop
  /// until the stick has been at rest once, so that what is still held moves nothing. A stop itself always counts.
  [[nodiscard]] Command read(double t) override;

  [[nodiscard]] DeviceStatus status() const override;

 private:
  [[nodiscard]] bool heard() const;
  [[nodiscard]] bool stops() const { return command_.recall == Recall::stop; }

  Clock clock_;
  Parameters parameters_;
  mutable std::mutex mutex_;
  std::optional<Page> driver_;
  Arming arming_;          ///< of the driver's stick; absent while silent
  double heard_at_ = 0.0;  ///< time of the driver's last message [s, by the clock]
  Command command_;        ///< newest
};

}  // namespace baton
