/// Looks on at a robot at the other end of a connection, beside whoever drives it. Nothing is sent but a hello, and a
/// bye: a robot that does not know of observers refuses, or is left before it has been started.
#pragma once

#include <deque>
#include <optional>
#include <string>

#include "baton/link/message.hpp"
#include "baton/model/robot_model.hpp"

namespace baton::link {

class Observer {
 public:
  struct Parameters {
    Address address;
    std::string token{};            ///< "": none
    Socket::Time connecting{3000};  ///< longest time for an answer to come while connecting
  };

  /// Connects. The model must outlive the object.
  /// @throws LinkError nobody there, refused, or a robot that does not know of observers
  /// @throws InputError it is another robot than `model`, with other joints, or in another world
  Observer(const RobotModel& model, const std::string& world, const Parameters& parameters);
  ~Observer();
  Observer(const Observer&) = delete;
  Observer& operator=(const Observer&) = delete;

  /// The next measurement; none has come: none. What comes is taken off the connection at once, so that the robot's end
  /// need not wait for who looks on.
  /// @param limit longest wait
  /// @throws LinkError the robot is gone, or breaks the protocol, after all that it has said before
  [[nodiscard]] std::optional<Reading> next(Socket::Time limit);
  /// What a simulator knows, as it was said with that measurement; null if nothing was.
  [[nodiscard]] const Truth* truth() const { return truth_ ? &*truth_ : nullptr; }

  [[nodiscard]] const Welcome& welcome() const { return welcome_; }

 private:
  void fetch(Socket::Time limit);

  const RobotModel* model_;
  std::string address_;
  Socket socket_;
  Stream stream_;
  Welcome welcome_;
  std::deque<Message> waiting_;  ///< come, and not looked at yet
  std::string gone_;             ///< why nothing comes any more; "": something may
  std::optional<Truth> truth_;
};

}  // namespace baton::link
