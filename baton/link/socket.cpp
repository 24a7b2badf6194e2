#include "baton/link/socket.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <netdb.h>
#include <netinet/in.h>
#include <netinet/tcp.h>
#include <poll.h>
#include <sys/socket.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <charconv>
#include <cstring>
#include <memory>
#include <utility>

#include "baton/model/error.hpp"

namespace baton {
namespace {

constexpr std::string_view kScheme = "tcp://";
constexpr int kWaiting = 64;   ///< connections that wait to be accepted
constexpr int kSilence = 5;    ///< after which the other end is asked whether it is still there [s]
constexpr int kQuestions = 3;  ///< so many times, a second apart

using Addresses = std::unique_ptr<addrinfo, decltype(&freeaddrinfo)>;

/// @throws LinkError no such host
Addresses resolve(const Address& address, int flags) {
  addrinfo hints{};
  hints.ai_family = AF_UNSPEC;
  hints.ai_socktype = SOCK_STREAM;
  hints.ai_flags = flags;
  addrinfo* found = nullptr;
  const int error = getaddrinfo(address.host.c_str(), std::to_string(address.port).c_str(), &hints, &found);
  if (error != 0) throw LinkError(fmt::format("{}: {}", address.text(), gai_strerror(error)));
  return {found, &freeaddrinfo};
}

void set(int descriptor, int level, int option, int value) {
  static_cast<void>(setsockopt(descriptor, level, option, &value, sizeof value));
}

/// Does not block, sends at once, and notices that the other end's machine is gone.
void prepare(int descriptor) {
  static_cast<void>(fcntl(descriptor, F_SETFL, fcntl(descriptor, F_GETFL, 0) | O_NONBLOCK));
  set(descriptor, IPPROTO_TCP, TCP_NODELAY, 1);
  set(descriptor, SOL_SOCKET, SO_KEEPALIVE, 1);
  set(descriptor, IPPROTO_TCP, TCP_KEEPIDLE, kSilence);
  set(descriptor, IPPROTO_TCP, TCP_KEEPINTVL, 1);
  set(descriptor, IPPROTO_TCP, TCP_KEEPCNT, kQuestions);
  set(descriptor, IPPROTO_TCP, TCP_USER_TIMEOUT, 1000 * (kSilence + kQuestions));  // while something is on its way
}

/// Waits until a descriptor is ready.
bool ready(int descriptor, short events, Socket::Time limit) {
  const auto until = std::chrono::steady_clock::now() + limit;
  while (true) {
    pollfd one{descriptor, events, 0};
    const auto left = std::chrono::ceil<Socket::Time>(until - std::chrono::steady_clock::now());
    const int count = poll(&one, 1, static_cast<int>(std::max<Socket::Time::rep>(left.count(), 0)));
    if (count > 0) return true;
    if (count == 0) return false;
    if (errno != EINTR) throw LinkError(fmt::format("poll: {}", std::strerror(errno)));
  }
}

}  // namespace

Address Address::parse(const std::string& text) {
  std::string_view rest = text;
  if (rest.starts_with(kScheme)) rest.remove_prefix(kScheme.size());
  const auto colon = rest.rfind(':');
  Address address;
  if (colon != std::string_view::npos) {
    std::string_view host = rest.substr(0, colon);
    const std::string_view port = rest.substr(colon + 1);
    const bool bracketed = host.starts_with('[') && host.ends_with(']');
    if (bracketed) host = host.substr(1, host.size() - 2);
    const auto [end, error] = std::from_chars(port.data(), port.data() + port.size(), address.port);
    const bool whole = error == std::errc() && end == port.data() + port.size();
    address.host = host;
    if (whole && !host.empty() && address.port >= 0 && address.port <= 65535 &&
        (bracketed || host.find(':') == std::string_view::npos)) {
      return address;
    }
  }
  throw InputError(fmt::format("'{}' is no address: must be HOST:PORT, as in 127.0.0.1:7447", text));
}

std::string Address::text() const {
  const bool brackets = host.find(':') != std::string::npos;
  return fmt::format("{}{}{}{}:{}", kScheme, brackets ? "[" : "", host, brackets ? "]" : "", port);
}

bool Address::loopback() const {
  const Addresses all = resolve(*this, 0);
  for (const addrinfo* one = all.get(); one != nullptr; one = one->ai_next) {
    bool own = false;
    if (one->ai_family == AF_INET) {
      sockaddr_in v4{};
      std::memcpy(&v4, one->ai_addr, sizeof v4);
      own = (ntohl(v4.sin_addr.s_addr) >> 24U) == 127;
    } else if (one->ai_family == AF_INET6) {
      sockaddr_in6 v6{};
      std::memcpy(&v6, one->ai_addr, sizeof v6);
      own = IN6_IS_ADDR_LOOPBACK(&v6.sin6_addr);
    }
    if (!own) return false;
  }
  return true;
}

Socket::Socket(Socket&& other) noexcept : descriptor_(std::exchange(other.descriptor_, -1)) {}

Socket& Socket::operator=(Socket&& other) noexcept {
  std::swap(descriptor_, other.descriptor_);
  return *this;
}

Socket::~Socket() {
  if (descriptor_ >= 0) ::close(descriptor_);
}

Socket Socket::connect(const Address& address, Time limit) {
  const Addresses all = resolve(address, 0);
  std::string why = "no address";
  for (const addrinfo* one = all.get(); one != nullptr; one = one->ai_next) {
    Socket socket(::socket(one->ai_family, one->ai_socktype | SOCK_CLOEXEC, one->ai_protocol));
    if (socket.descriptor_ < 0) continue;
    prepare(socket.descriptor_);
    int error = ::connect(socket.descriptor_, one->ai_addr, one->ai_addrlen) == 0 ? 0 : errno;
    if (error == EINPROGRESS) {
      socklen_t size = sizeof error;
      if (!ready(socket.descriptor_, POLLOUT, limit)) {
        error = ETIMEDOUT;
      } else {
        getsockopt(socket.descriptor_, SOL_SOCKET, SO_ERROR, &error, &size);
      }
    }
    if (error == 0) return socket;
    why = std::strerror(error);
  }
  throw LinkError(fmt::format("{}: {}", address.text(), why));
}

Socket Socket::listen(const Address& address) {
  std::string why = "no address";
  try {
    const Addresses all = resolve(address, AI_PASSIVE);
    for (const addrinfo* one = all.get(); one != nullptr; one = one->ai_next) {
      Socket socket(::socket(one->ai_family, one->ai_socktype | SOCK_CLOEXEC, one->ai_protocol));
      if (socket.descriptor_ < 0) continue;
      set(socket.descriptor_, SOL_SOCKET, SO_REUSEADDR, 1);
      prepare(socket.descriptor_);
      if (::bind(socket.descriptor_, one->ai_addr, one->ai_addrlen) == 0 &&
          ::listen(socket.descriptor_, kWaiting) == 0) {
        return socket;
      }
      why = std::strerror(errno);
    }
  } catch (const LinkError& error) {
    throw InputError(fmt::format("cannot listen on {}", error.what()));
  }
  throw InputError(fmt::format("cannot listen on {}: {}", address.text(), why));
}

std::optional<Socket> Socket::accept() {
  const int descriptor = ::accept4(descriptor_, nullptr, nullptr, SOCK_CLOEXEC);
  if (descriptor < 0) return std::nullopt;
  prepare(descriptor);
  return Socket(descriptor);
}

int Socket::port() const {
  sockaddr_storage own{};
  socklen_t size = sizeof own;
  getsockname(descriptor_, reinterpret_cast<sockaddr*>(&own), &size);
  std::array<char, NI_MAXSERV> port{};
  getnameinfo(reinterpret_cast<sockaddr*>(&own), size, nullptr, 0, port.data(), port.size(), NI_NUMERICSERV);
  return std::stoi(port.data());
}

void Socket::send(std::string_view bytes, Time limit) {
  const auto until = std::chrono::steady_clock::now() + limit;
  while (true) {
    bytes.remove_prefix(send_some(bytes));
    if (bytes.empty()) return;
    if (!ready(descriptor_, POLLOUT, std::chrono::ceil<Time>(until - std::chrono::steady_clock::now())))
      throw LinkError(fmt::format("the other end takes nothing for {} ms", limit.count()));
  }
}

std::size_t Socket::send_some(std::string_view bytes) {
  while (true) {
    const ssize_t sent = ::send(descriptor_, bytes.data(), bytes.size(), MSG_NOSIGNAL);
    if (sent >= 0) return static_cast<std::size_t>(sent);
    if (errno == EAGAIN || errno == EWOULDBLOCK) return 0;
    if (errno != EINTR) throw LinkError(fmt::format("the other end is gone: {}", std::strerror(errno)));
  }
}

void Socket::finish() {
  ::shutdown(descriptor_, SHUT_WR);
}

bool Socket::receive(std::string& bytes, Time limit) {
  std::array<char, 16384> some{};
  bool any = false;
  while (true) {
    const ssize_t got = ::recv(descriptor_, some.data(), some.size(), 0);
    if (got > 0) {
      bytes.append(some.data(), static_cast<std::size_t>(got));
      return true;
    }
    if (got == 0) throw LinkError("the other end has closed the connection");
    if (errno == EINTR) continue;
    if (errno != EAGAIN && errno != EWOULDBLOCK)
      throw LinkError(fmt::format("the other end is gone: {}", std::strerror(errno)));
    if (any || !ready(descriptor_, POLLIN, limit)) return false;
    any = true;
  }
}

}  // namespace baton
