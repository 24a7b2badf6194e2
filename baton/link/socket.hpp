/// TCP sockets with time limits.
#pragma once

#include <chrono>
#include <optional>
#include <stdexcept>
#include <string>
#include <string_view>

namespace baton {

/// The other end is gone, silent, or says what it must not. The message is one line.
class LinkError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

/// Where a robot listens.
struct Address {
  std::string host;
  int port = 0;

  /// @param text "HOST:PORT", "[IPv6]:PORT", or either after "tcp://"
  /// @throws InputError something else
  [[nodiscard]] static Address parse(const std::string& text);
  /// "tcp://HOST:PORT"
  [[nodiscard]] std::string text() const;
  /// Whether only this machine can reach it.
  [[nodiscard]] bool loopback() const;
};

/// Movable, closed when destroyed. Never blocks for longer than the time given.
class Socket {
 public:
  using Time = std::chrono::milliseconds;

  Socket() = default;
  Socket(const Socket&) = delete;
  Socket& operator=(const Socket&) = delete;
  Socket(Socket&& other) noexcept;
  Socket& operator=(Socket&& other) noexcept;
  ~Socket();

  /// @throws LinkError nobody answers there
  [[nodiscard]] static Socket connect(const Address& address, Time limit);
  /// @throws InputError the address cannot be listened on
  [[nodiscard]] static Socket listen(const Address& address);

  /// The next one who has connected, if any.
  [[nodiscard]] std::optional<Socket> accept();
  /// Port of this end.
  [[nodiscard]] int port() const;
  [[nodiscard]] int descriptor() const { return descriptor_; }

  /// Sends all of it.
  /// @throws LinkError the other end is gone, or does not take it in time
  void send(std::string_view bytes, Time limit);
  /// Sends what is taken at once.
  /// @returns how much that is [bytes]
  /// @throws LinkError the other end is gone
  std::size_t send_some(std::string_view bytes);
  /// Sends no more: once the other end has taken all, it finds the connection closed.
  void finish();
  /// Appends what has arrived; waits if nothing has.
  /// @returns whether anything has
  /// @throws LinkError the other end is gone
  bool receive(std::string& bytes, Time limit);

 private:
  explicit Socket(int descriptor) : descriptor_(descriptor) {}

  int descriptor_ = -1;  ///< −1: none
};

}  // namespace baton
