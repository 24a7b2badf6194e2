/// What a tick has replaced and `Navigator::poll` frees: a tick gives no memory back.
#pragma once

#include <array>
#include <cstddef>
#include <memory>
#include <utility>

namespace baton {

class Retired {
 public:
  /// Keeps a handle until `clear`. Without room, as when nobody clears, the oldest is freed at once.
  void keep(std::shared_ptr<const void> handle) {
    if (!handle) return;
    handles_[next_].swap(handle);
    next_ = (next_ + 1) % handles_.size();
  }
  void clear() {
    handles_.fill(nullptr);
    next_ = 0;
  }

 private:
  std::array<std::shared_ptr<const void>, 16> handles_;
  std::size_t next_ = 0;
};

}  // namespace baton
