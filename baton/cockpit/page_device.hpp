/// The page as a device: one page drives, the others watch.
#pragma once

#include <cstdint>
#include <functional>
#include <mutex>
#include <optional>
#include <utility>

#include "baton/input/arming.hpp"
#include "baton/input/device.hpp"

namespace baton {

/// Pages are known by numbers. Every function may be called from any thread.
///
/// A page may be gone although its connection is not: hidden, frozen, behind a network that stalls. So its messages are
/// its heartbeat, counted when they come in, by a clock of their own: the time of the run stands still while a tick is
/// late, and hurries afterwards.
class PageDevice final : public Device {
 public:
  using Page = std::uint64_t;
  using Clock = std::function<double()>;  ///< [s], never goes back; any thread calls it

  struct Parameters {
    double silence = 0.25;  ///< a driver that said nothing for longer counts as gone [s, by the clock]
  };

  /// @throws InputError `silence` is not positive
  PageDevice(Clock clock, const Parameters& parameters);
  explicit PageDevice(Clock clock) : PageDevice(std::move(clock), Parameters{}) {}

  /// Gives the driver's seat to a page if it is free. True if the page drives now.
  bool take(Page page);
  /// Frees the seat if this page has it.
  void release(Page page);
  [[nodiscard]] std::optional<Page> driver() const;

  /// What a page asks for; without the dead-man's hold it counts as centred. False if the page does not
  /// drive.
  bool give(Page page, const Command& command, bool deadman);

  /// The driver's newest command. Neutral, for the part chosen last, while there is no driver, when nothing
  /// has come from it for `silence`, and from then on until it was at rest once; also after a stop, so that what is
  /// still held then moves nothing. A stop itself counts at any time.
  [[nodiscard]] Command read(double t) override;

  [[nodiscard]] DeviceStatus status() const override;

 private:
  [[nodiscard]] bool heard() const;
  [[nodiscard]] bool stops() const { return command_.recall == Recall::stop; }

  Clock clock_;
  Parameters parameters_;
  mutable std::mutex mutex_;
  std::optional<Page> driver_;
  Arming arming_;          ///< of the driver; absent while it is silent
  double heard_at_ = 0.0;  ///< when the driver last said something [s, by the clock]
  Command command_;        ///< its newest
};

}  // namespace baton
