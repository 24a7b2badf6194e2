/// What was executed, from rest to rest: the ways back.
#pragma once

#include <memory>
#include <vector>

#include "baton/navigate/retired.hpp"
#include "baton/plan/request.hpp"

namespace baton {

class History {
 public:
  History();

  [[nodiscard]] bool empty() const { return trails_.empty(); }
  /// Trails that can be retraced.
  [[nodiscard]] std::size_t size() const { return trails_.size(); }
  /// The newest trail; null if there is none.
  [[nodiscard]] std::shared_ptr<const Trail> newest() const { return empty() ? nullptr : trails_.back(); }

  // What a tick does: no memory is asked for, and what is replaced goes to `retired`.

  /// A motion that begins at rest has a trail of its own.
  void append(std::shared_ptr<const Trail> trail) { trails_.push_back(std::move(trail)); }
  /// A motion has replaced another on its way.
  void replace_newest(std::shared_ptr<const Trail> trail, Retired& retired);
  /// The newest trail is retraced, by the answer's motion; @returns it. After a part of the way back the rest remains.
  [[nodiscard]] std::shared_ptr<const Trail> retrace(const Answer& answer);

  // What `Navigator::poll` does.

  void clear() { trails_.clear(); }
  /// Keeps no more than there is room for.
  void forget();

 private:
  std::vector<std::shared_ptr<const Trail>> trails_;  ///< the newest last; null: that motion leads back to no rest
};

}  // namespace baton
