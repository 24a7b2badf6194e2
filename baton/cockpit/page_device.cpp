#include "baton/cockpit/page_device.hpp"

#include <fmt/format.h>

#include <utility>

#include "baton/model/error.hpp"

namespace baton {

PageDevice::PageDevice(Clock clock, const Parameters& parameters) : clock_(std::move(clock)), parameters_(parameters) {
  if (!(parameters.silence > 0.0)) {
    throw InputError(fmt::format("page: silence = {}: must be more than 0 s", parameters.silence));
  }
}

bool PageDevice::take(Page page) {
  const std::scoped_lock lock(mutex_);
  if (driver_) return *driver_ == page;
  driver_ = page;
  heard_at_ = clock_();
  arming_.update(true, false);
  return true;
}

void PageDevice::release(Page page) {
  const std::scoped_lock lock(mutex_);
  if (driver_ != page) return;
  driver_.reset();
  command_ = {.guide = command_.guide};
  arming_.update(false, false);
}

std::optional<PageDevice::Page> PageDevice::driver() const {
  const std::scoped_lock lock(mutex_);
  return driver_;
}

bool PageDevice::give(Page page, const Command& command, bool deadman) {
  const Command wanted = deadman ? sanitised(command) : Command{.guide = command.guide};
  const std::scoped_lock lock(mutex_);
  if (driver_ != page) return false;
  // A silence counts even if nobody called `read` meanwhile.
  if (!heard() || (stops() && wanted.recall != Recall::stop)) arming_.update(false, false);
  heard_at_ = clock_();
  arming_.update(true, controls_released(wanted));
  command_ = wanted;
  return true;
}

Command PageDevice::read(double /*t*/) {
  const std::scoped_lock lock(mutex_);
  if (!heard()) arming_.update(false, false);
  return arming_.armed() || (heard() && stops()) ? command_ : Command{.guide = command_.guide};
}

DeviceStatus PageDevice::status() const {
  const std::scoped_lock lock(mutex_);
  DeviceStatus status;
  status.name = "page";
  status.connected = heard();
  status.armed = status.connected && (arming_.armed() || stops());
  if (!driver_) {
    status.hint = "Nobody drives: open the page and take the stick.";
  } else if (!status.connected) {
    status.hint = "No signal from the driving page: the stick counts as centred.";
  } else if (!status.armed) {
    status.hint = "Release all keys, sliders and sticks once.";
  }
  return status;
}

/// Whether there is a driver and it is not silent.
bool PageDevice::heard() const {
  return driver_ && clock_() - heard_at_ <= parameters_.silence;
}

}  // namespace baton
