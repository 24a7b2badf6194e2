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

  // Called in a tick: these allocate nothing, and what is replaced goes to `retired`.

  /// Begins a trail, for a motion that begins at rest.
  void append(std::shared_ptr<const Trail> trail) { trails_.push_back(std::move(trail)); }
  /// A motion has replaced another while it was under way.
  void replace_newest(std::shared_ptr<const Trail> trail, Retired& retired);
  /// Takes the newest trail, which the answer's motion retraces. After a partial retrace the remaining trail is kept.
  [[nodiscard]] std::shared_ptr<const Trail> retrace(const Answer& answer);

  // Called by `Navigator::poll`.

  void clear() { trails_.clear(); }
  /// Drops the oldest trails that there is no room for.
  void forget();

 private:
  std::vector<std::shared_ptr<const Trail>> trails_;  ///< the newest last; null: nothing to retrace
};

}  // namespace baton
