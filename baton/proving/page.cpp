#include "baton/proving/page.hpp"

namespace baton {

const Page& PageReader::read(const Operator::View& view) {
  const Navigator& robot = view.navigator;
  page_.t = view.t;
  page_.activity = activity(robot, view.truth != nullptr && view.truth->fallen);
  page_.contact = robot.sample().contact;
  page_.limited = robot.planned() != nullptr && robot.planned()->limit.has_value();
  const Refused* refused = find_event<Refused>(robot.events());
  if (refused != nullptr && !refused->again) ++page_.refusals;
  return page_;
}

}  // namespace baton
