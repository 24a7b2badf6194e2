#include "baton/link/answer.hpp"

#include <fmt/format.h>

namespace baton::link {

Message receive_from(Socket& socket, Stream& stream, Socket::Time limit) {
  const auto until = std::chrono::steady_clock::now() + limit;
  while (true) {
    if (std::optional<Message> message = stream.next()) return *std::move(message);
    const auto left = std::chrono::ceil<Socket::Time>(until - std::chrono::steady_clock::now());
    if (left.count() <= 0 || !socket.receive(stream.bytes(), left)) silent_for(limit);
  }
}

void silent_for(Socket::Time limit) {
  throw LinkError(fmt::format("nothing from the robot for {} ms", limit.count()));
}

void complain(const Message& refusal) {
  const Refusal why = decode_refusal(refusal.body);
  throw LinkError(fmt::format("refused ({}): {}", why.reason, why.text));
}

void complain_of(Type type, const char* wanted) {
  throw LinkError(fmt::format("a message of type {} in place of {}", static_cast<int>(type), wanted));
}

}  // namespace baton::link
