/// What the robot's end answers, as whoever has connected takes it.
#pragma once

#include "baton/link/message.hpp"

namespace baton::link {

/// The next message.
/// @throws LinkError none in time; the robot is gone
[[nodiscard]] Message receive_from(Socket& socket, Stream& stream, Socket::Time limit);

/// @throws LinkError that nothing has come in that time
[[noreturn]] void silent_for(Socket::Time limit);

/// @throws LinkError that the robot has refused, and why
[[noreturn]] void complain(const Message& refusal);

/// @throws LinkError that a message has come in place of another
[[noreturn]] void complain_of(Type type, const char* wanted);

}  // namespace baton::link
