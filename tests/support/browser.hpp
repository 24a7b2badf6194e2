/// A page as the page's server sees it: a WebSocket.
#pragma once

#include <civetweb.h>
#include <gtest/gtest.h>

#include <array>
#include <chrono>
#include <condition_variable>
#include <deque>
#include <functional>
#include <mutex>
#include <nlohmann/json.hpp>
#include <string>

#include "baton/guide/command.hpp"

namespace baton::test {

using nlohmann::json;

inline constexpr std::chrono::seconds kPatience{20};

class Browser {
 public:
  explicit Browser(int port) {
    std::array<char, 256> error{};
    connection_ = mg_connect_websocket_client("127.0.0.1", port, 0, error.data(), error.size(), "/ws", nullptr,
                                              on_message, on_close, this);
    EXPECT_NE(connection_, nullptr) << error.data();
  }
  ~Browser() { close(); }
  Browser(const Browser&) = delete;
  Browser& operator=(const Browser&) = delete;

  /// Whether a server listens at the port.
  static bool answers(int port) {
    std::array<char, 256> error{};
    mg_connection* visitor = mg_connect_client("127.0.0.1", port, 0, error.data(), error.size());
    if (visitor != nullptr) mg_close_connection(visitor);
    return visitor != nullptr;
  }

  void close() {
    if (connection_ == nullptr) return;
    say("", MG_WEBSOCKET_OPCODE_CONNECTION_CLOSE);
    mg_close_connection(connection_);
    connection_ = nullptr;
  }

  void say(const std::string& text, int opcode = MG_WEBSOCKET_OPCODE_TEXT) {
    mg_websocket_client_write(connection_, opcode, text.data(), text.size());
  }

  /// The next message that fits, of the server or that the connection is `closed`; null when none comes.
  json next(const std::function<bool(const json&)>& fits) {
    std::unique_lock lock(mutex_);
    json found;
    came_.wait_for(lock, kPatience, [&] {
      for (; !messages_.empty() && found.is_null(); messages_.pop_front()) {
        if (fits(messages_.front())) found = messages_.front();
      }
      return !found.is_null();
    });
    return found;
  }

  /// The server's complaint about a message.
  std::string error_after(const std::string& text, int opcode = MG_WEBSOCKET_OPCODE_TEXT) {
    say(text, opcode);
    const json message = next([](const json& m) { return m["type"] == "error"; });
    return message.is_null() ? "" : message["text"].get<std::string>();
  }

  /// Returns when the server has taken in all that was said before.
  void settle() {
    say(R"({"type":"?"})");
    const auto answer = [](const json& m) { return m["type"] == "error" && m["text"] == "unknown type of message"; };
    EXPECT_FALSE(next(answer).is_null());
  }

  void steer(const Command& command, bool deadman = true) {
    say(json{{"type", "command"},
             {"guide", to_string(command.guide)},
             {"axes", std::vector<double>(command.axes.begin(), command.axes.end())},
             {"lift", {command.lift.left, command.lift.right}},
             {"deadman", deadman},
             {"recall", command.recall == Recall::none      ? "none"
                        : command.recall == Recall::retrace ? "retrace"
                                                            : "home"}}
            .dump());
  }

 private:
  static int on_message(mg_connection* /*connection*/, int bits, char* text, std::size_t size, void* self) {
    auto& browser = *static_cast<Browser*>(self);
    if ((bits & 0x0F) != MG_WEBSOCKET_OPCODE_TEXT) return 1;
    const std::scoped_lock lock(browser.mutex_);
    browser.messages_.push_back(json::parse(text, text + size));
    browser.came_.notify_all();
    return 1;
  }

  static void on_close(const mg_connection* /*connection*/, void* self) {
    auto& browser = *static_cast<Browser*>(self);
    const std::scoped_lock lock(browser.mutex_);
    browser.messages_.push_back({{"type", "closed"}});
    browser.came_.notify_all();
  }

  std::mutex mutex_;
  std::condition_variable came_;
  std::deque<json> messages_;
  mg_connection* connection_ = nullptr;
};

}  // namespace baton::test
