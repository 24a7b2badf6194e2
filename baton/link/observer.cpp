#include "baton/link/observer.hpp"

#include <fmt/format.h>

#include "baton/link/answer.hpp"
#include "baton/link/remote_robot.hpp"

namespace baton::link {
namespace {

constexpr Socket::Time kTelling{2000};
constexpr Socket::Time kLeaving{200};
constexpr std::size_t kMostWaiting = 100'000;  ///< messages; who is so far behind is left by the robot's end

}  // namespace

Observer::Observer(const RobotModel& model, const std::string& world, const Parameters& parameters)
    : model_(&model),
      address_(parameters.address.text()),
      socket_(Socket::connect(parameters.address, parameters.connecting)) {
  try {
    socket_.send(framed(Type::hello, encode(Hello{kVersion, parameters.token, Role::observe})), kTelling);
    const Message answer = receive_from(socket_, stream_, parameters.connecting);
    if (answer.type == Type::refusal) complain(answer);
    if (answer.type != Type::welcome) complain_of(answer.type, "a welcome");
    welcome_ = decode_welcome(answer.body);
    if (welcome_.role != Role::observe) {
      socket_.send(framed(Type::bye), kLeaving);
      throw LinkError("this robot does not know of observers: left as it is");
    }
    check_robot(model, world, welcome_, parameters.address);
  } catch (const LinkError& error) {
    throw LinkError(fmt::format("{}: {}", address_, error.what()));
  }
}

Observer::~Observer() {
  try {
    socket_.send(framed(Type::bye), kLeaving);
  } catch (const LinkError&) {  // it is gone already
  }
}

std::optional<Reading> Observer::next(Socket::Time limit) {
  try {
    fetch(limit);
    while (!waiting_.empty()) {
      const Message message = std::move(waiting_.front());
      waiting_.pop_front();
      switch (message.type) {
        case Type::truth:
          truth_ = decode_truth(message.body, model_->nv() - 6);
          break;
        case Type::measurement:
          return decode_reading(message.body, model_->nv() - 6);
        case Type::refusal:
          complain(message);
        case Type::bye:
          throw LinkError("the robot has ended the connection");
        default:
          complain_of(message.type, "a measurement");
      }
    }
  } catch (const LinkError& error) {
    throw LinkError(fmt::format("{}: {}", address_, error.what()));
  }
  return std::nullopt;
}

void Observer::fetch(Socket::Time limit) {
  if (!gone_.empty() && waiting_.empty()) throw LinkError(gone_);
  try {
    while (gone_.empty() && waiting_.size() < kMostWaiting &&
           socket_.receive(stream_.bytes(), waiting_.empty() ? limit : Socket::Time(0))) {
      while (std::optional<Message> message = stream_.next())
        waiting_.push_back(*std::move(message));
    }
  } catch (const LinkError& error) {
    gone_ = error.what();
  }
}

}  // namespace baton::link
