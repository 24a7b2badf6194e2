/// Plans what a robot at the other end of a connection plans by itself: the same requests at the same ticks. The
/// answers are handed over when its own were, however long planning takes here.
#pragma once

#include <memory>

#include "baton/link/remote_robot.hpp"
#include "baton/run/planning.hpp"

namespace baton::link {

class EchoedPlanning : public Planning {
 public:
  /// @param robot one that navigates by itself; must outlive this object
  /// @param planner with the modes of `robot`
  EchoedPlanning(const RemoteRobot& robot, std::unique_ptr<Planning> planner)
      : robot_(&robot), planner_(std::move(planner)) {}

  /// Whether the robot has made a request in this tick.
  [[nodiscard]] bool idle() const override { return next_is(PlanningEvent::ask); }
  void post(Request request) override;
  /// Waits for an answer that the robot has had.
  /// @throws LinkError the robot has asked, or been answered, what was not asked here
  [[nodiscard]] std::optional<Reply> poll(long tick) override;
  void reset() override;

 private:
  /// Whether this is what the robot did next in this tick.
  [[nodiscard]] bool next_is(PlanningEvent event) const { return next_ < events_.size() && events_[next_] == event; }

  const RemoteRobot* robot_;
  std::unique_ptr<Planning> planner_;
  long tick_ = -1;
  std::vector<PlanningEvent> events_;  ///< the robot's, in this tick
  std::size_t next_ = 0;               ///< of them
};

}  // namespace baton::link
