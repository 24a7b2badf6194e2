// Whatever comes over a connection is messages or malformed, and a message that was read is the same when it is sent
// on.
#include "baton/link/message.hpp"
#include "tests/fuzz/fuzz.hpp"

namespace {

using baton::LinkError;
using namespace baton::link;

constexpr Eigen::Index kJoints = 2;

/// What is read of a message, sent on.
std::string again(const Message& message) {
  switch (message.type) {
    case Type::hello:
      return encode(decode_hello(message.body));
    case Type::welcome:
      return encode(decode_welcome(message.body));
    case Type::refusal:
      return encode(decode_refusal(message.body));
    case Type::start:
      return encode(decode_start(message.body, kJoints));
    case Type::truth:
      return encode(decode_truth(message.body, kJoints));
    case Type::measurement:
      return encode(decode_reading(message.body, kJoints));
    case Type::target:
      return encode(decode_target(message.body, kJoints));
    case Type::rejected:
    case Type::damp:
    case Type::fault:
      return encode_text(decode_text(message.body));
    case Type::command:
      return encode(decode_stick(message.body));
    case Type::tick:
      return encode(decode_tick(message.body, kJoints));
    case Type::arms:
      return encode(decode_arms(message.body));
    case Type::bye:
      return message.body;
  }
  baton::fuzz::require(false, "the type is one of those");
  return "";
}

}  // namespace

int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using baton::fuzz::require;
  Stream stream;
  stream.bytes() = baton::fuzz::text_of(data, size);
  try {
    while (const std::optional<Message> message = stream.next()) {
      require(message->body.size() <= kLongest, "no body is longer than the longest");
      try {
        const std::string once = again(*message);
        require(again({message->type, once}) == once, "what was read reads back");
      } catch (const LinkError& error) {
        require(*error.what() != '\0', "what is malformed is told why");
      }
    }
  } catch (const LinkError& error) {
    require(*error.what() != '\0', "what is no message is told why");
  }
  return 0;
}
