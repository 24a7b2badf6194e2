/// The page as a device: one page drives, the others watch.
#pragma once

#include <cstdint>
#include <mutex>
#include <optional>

#include "baton/input/device.hpp"

namespace baton {

/// Pages are known by numbers. Every function may be called from any thread.
class PageDevice final : public Device {
 public:
  using Page = std::uint64_t;

  struct Parameters {
    double silence = 0.25;  ///< a driver that said nothing for longer counts as centred [s, of the run]
    double disarm = 2.0;    ///< after this long it also has to be neutral once more [s, of the run]
  };

  PageDevice() = default;
  explicit PageDevice(const Parameters& parameters) : parameters_(parameters) {}

  /// Gives the driver's seat to a page if it is free. True if the page drives now.
  bool take(Page page);
  /// Frees the seat if this page has it.
  void release(Page page);
  [[nodiscard]] std::optional<Page> driver() const;

  /// What a page asks for; without the dead-man's hold it counts as centred. False if the page does not
  /// drive.
  bool give(Page page, const Command& command, bool deadman);

  /// The driver's newest command. Neutral, for the part chosen last, while there is no driver, until the
  /// driver was neutral once, and when nothing new has come for `silence`.
  [[nodiscard]] Command read(double t) override;

  [[nodiscard]] DeviceStatus status() const override;

 private:
  /// How far the driver has come.
  enum class Stage {
    absent,  ///< nobody drives
    taken,   ///< someone drives, but was not neutral yet
    armed,   ///< commands count
    silent,  ///< they would, but nothing came for a while
  };

  Parameters parameters_{};
  mutable std::mutex mutex_;
  Stage stage_ = Stage::absent;
  Page driver_ = 0;
  Command command_;
  bool fresh_ = false;     ///< a command came since the last read
  double heard_at_ = 0.0;  ///< run time of the read that found it [s]
};

}  // namespace baton
