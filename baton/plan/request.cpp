#include "baton/plan/request.hpp"

namespace baton {

Intent intent_of(const Command& command) {
  switch (command.recall) {
    case Recall::retrace:
      return Retrace{};
    case Recall::home:
      return Home{};
    case Recall::stop:
      return Stop{};
    case Recall::none:
      break;
  }
  return Follow{};
}

}  // namespace baton
