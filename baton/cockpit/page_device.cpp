#include "baton/cockpit/page_device.hpp"

namespace baton {

bool PageDevice::take(Page page) {
  const std::scoped_lock lock(mutex_);
  if (stage_ != Stage::absent) return driver_ == page;
  stage_ = Stage::taken;
  driver_ = page;
  fresh_ = true;
  return true;
}

void PageDevice::release(Page page) {
  const std::scoped_lock lock(mutex_);
  if (stage_ == Stage::absent || driver_ != page) return;
  stage_ = Stage::absent;
  command_ = {.guide = command_.guide};
}

std::optional<PageDevice::Page> PageDevice::driver() const {
  const std::scoped_lock lock(mutex_);
  if (stage_ == Stage::absent) return std::nullopt;
  return driver_;
}

bool PageDevice::give(Page page, const Command& command, bool deadman) {
  const Command wanted = deadman ? sanitised(command) : Command{.guide = command.guide};
  const std::scoped_lock lock(mutex_);
  if (stage_ == Stage::absent || driver_ != page) return false;
  if (stage_ == Stage::silent || (stage_ == Stage::taken && wanted.neutral())) stage_ = Stage::armed;
  command_ = wanted;
  fresh_ = true;
  return true;
}

Command PageDevice::read(double t) {
  const std::scoped_lock lock(mutex_);
  if (fresh_ || t < heard_at_) heard_at_ = t;
  fresh_ = false;
  const double silence = t - heard_at_;
  if (stage_ == Stage::armed && silence > parameters_.silence) stage_ = Stage::silent;
  if (stage_ == Stage::silent && silence > parameters_.disarm) stage_ = Stage::taken;
  return stage_ == Stage::armed ? command_ : Command{.guide = command_.guide};
}

DeviceStatus PageDevice::status() const {
  const std::scoped_lock lock(mutex_);
  DeviceStatus status;
  status.name = "page";
  status.connected = stage_ != Stage::absent;
  status.armed = stage_ == Stage::armed;
  switch (stage_) {
    case Stage::absent:
      status.hint = "Nobody drives: open the page and take the stick.";
      break;
    case Stage::taken:
      status.hint = "Let go of all keys and sticks once.";
      break;
    case Stage::silent:
      status.hint = "The driver's page is silent.";
      break;
    case Stage::armed:
      break;
  }
  return status;
}

}  // namespace baton
