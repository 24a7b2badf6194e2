#include "baton/cockpit/cockpit.hpp"

#include <civetweb.h>
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <chrono>
#include <condition_variable>
#include <future>
#include <map>
#include <mutex>
#include <nlohmann/json.hpp>
#include <optional>
#include <string_view>
#include <thread>

#include "baton/cockpit/page_device.hpp"
#include "baton/cockpit/page_files.hpp"
#include "baton/cockpit/protocol.hpp"
#include "baton/cockpit/same_origin.hpp"
#include "baton/cockpit/scene.hpp"
#include "baton/model/error.hpp"

namespace baton {
namespace {

/// A connection without a complete request holds a thread until it times out. Many threads and a short timeout keep
/// hundreds of such connections from locking pages out; the rest waits in the backlog.
constexpr int kHttpThreads = 256;                  ///< in addition to one per page
constexpr const char* kHttpTimeout = "1000";       ///< for a request, and for a blocked write [ms]
constexpr const char* kBacklog = "1024";           ///< connections waiting for a thread
constexpr const char* kWebSocketTimeout = "5000";  ///< silence before a ping [ms]

struct CivetwebLibrary {
  CivetwebLibrary() { mg_init_library(MG_FEATURES_WEBSOCKET); }
  ~CivetwebLibrary() { mg_exit_library(); }
  CivetwebLibrary(const CivetwebLibrary&) = delete;
  CivetwebLibrary& operator=(const CivetwebLibrary&) = delete;
};

struct StopServer {
  void operator()(mg_context* context) const { mg_stop(context); }
};

int respond(mg_connection* connection, int status, std::string_view type, std::string_view body) {
  const std::string head = fmt::format(
      "HTTP/1.1 {} {}\r\n"
      "Content-Type: {}\r\n"
      "Content-Length: {}\r\n"
      "Cache-Control: no-cache\r\n"
      "Connection: close\r\n"
      "Content-Security-Policy: default-src 'self'; img-src 'self' data: blob:; frame-ancestors 'none'\r\n"
      "Cross-Origin-Resource-Policy: same-origin\r\n"
      "X-Content-Type-Options: nosniff\r\n\r\n",
      status, mg_get_response_code_text(connection, status), type, body.size());
  mg_disable_connection_keep_alive(connection);  // otherwise it would wait for a slow request body
  mg_write(connection, head.data(), head.size());
  const bool head_only = std::string_view(mg_get_request_info(connection)->request_method) == "HEAD";
  if (!head_only) mg_write(connection, body.data(), body.size());
  return status;
}

int respond_text(mg_connection* connection, int status, std::string_view text) {
  return respond(connection, status, "text/plain; charset=utf-8", fmt::format("{}\n", text));
}

/// The single value of a header; none if missing. Sets `repeated` if it occurs more than once.
std::optional<std::string_view> header(const mg_request_info& request, const char* name, bool& repeated) {
  std::optional<std::string_view> value;
  for (int i = 0; i < request.num_headers; ++i) {
    if (mg_strcasecmp(request.http_headers[i].name, name) != 0) continue;
    repeated = repeated || value.has_value();
    value = request.http_headers[i].value;
  }
  return value;
}

bool may_be_answered(const mg_request_info& request) {
  bool repeated = false;
  const auto host = header(request, "Host", repeated);
  const auto origin = header(request, "Origin", repeated);
  const bool has_path = request.request_uri != nullptr && request.request_uri[0] == '/';
  return has_path && host && !repeated && is_same_origin(*host, origin);
}

}  // namespace

class Cockpit::Server {
 public:
  Server(const Parameters& parameters, const RobotModel& robot, const std::string& world, const mjModel& scene)
      : parameters_(parameters),
        robot_(robot),
        scene_(scene_document(robot, world, scene).dump(-1, ' ', false, nlohmann::json::error_handler_t::replace)),
        device_(parameters.clock) {
    if (parameters_.host == "localhost") parameters_.host = "127.0.0.1";
    if (parameters_.host != "127.0.0.1" && parameters_.host != "[::1]") {
      throw InputError(fmt::format("page: host '{}' is not this machine: give 127.0.0.1 or [::1]", parameters_.host));
    }
    if (parameters_.port < 0 || parameters_.port > 65535) {
      throw InputError(fmt::format("page: port {} is not in 0…65535", parameters_.port));
    }
    start();
  }

  ~Server() {
    {
      const std::scoped_lock lock(frame_mutex_);
      stopping_ = true;
    }
    frame_came_.notify_all();
    // Ends civetweb's threads and all pages. The listening thread wakes only every 2 s or on a connection.
    const auto stopped = std::async(std::launch::async, [this] { context_.reset(); });
    while (stopped.wait_for(std::chrono::milliseconds(10)) != std::future_status::ready)
      knock();
  }
  Server(const Server&) = delete;
  Server& operator=(const Server&) = delete;

  [[nodiscard]] int port() const { return port_; }
  [[nodiscard]] std::string url() const { return fmt::format("http://{}:{}/", parameters_.host, port_); }
  [[nodiscard]] PageDevice& device() { return device_; }
  [[nodiscard]] bool damp_asked() const { return damp_asked_; }
  [[nodiscard]] std::size_t pages();

  void publish(Frame frame) {
    auto newest = std::make_shared<const Frame>(std::move(frame));
    {
      const std::scoped_lock lock(frame_mutex_);
      frame_.swap(newest);
      ++frames_;
    }
    frame_came_.notify_all();
  }

 private:
  /// A page and its sending thread, so that a stalled page does not delay others.
  struct Page {
    PageDevice::Page number = 0;
    mg_connection* connection = nullptr;
    bool leaving = false;  ///< guarded by frame_mutex_, as is `errors`
    std::string errors;    ///< newest error in the page's messages
    std::thread sender;
  };

  [[nodiscard]] bool is_full() { return pages() >= static_cast<std::size_t>(parameters_.pages); }
  void start();
  void knock() const;
  int answer(mg_connection* connection);
  int answer_file(mg_connection* connection, std::string_view name);
  void enter(mg_connection* connection);
  bool hear(const mg_connection* connection, int bits, std::string_view text);
  void leave(const mg_connection* connection);
  void complain(Page& page, std::string_view text);
  void send_states(Page& page);

  static Server& of(void* self) { return *static_cast<Server*>(self); }

  Parameters parameters_;
  const RobotModel& robot_;
  const std::string scene_;
  PageDevice device_;
  std::string start_error_;  ///< civetweb's first message during start
  std::atomic<bool> listening_{false};
  std::atomic<bool> damp_asked_{false};

  std::mutex frame_mutex_;
  std::condition_variable frame_came_;
  std::shared_ptr<const Frame> frame_;
  std::uint64_t frames_ = 0;  ///< published so far
  bool stopping_ = false;

  std::mutex pages_mutex_;
  std::map<const mg_connection*, std::unique_ptr<Page>> pages_;
  PageDevice::Page last_number_ = 0;

  CivetwebLibrary library_;
  std::unique_ptr<mg_context, StopServer> context_;
  int port_ = 0;
};

void Cockpit::Server::start() {
  mg_callbacks callbacks{};
  callbacks.begin_request = [](mg_connection* connection) {
    return of(mg_get_user_context_data(connection)).answer(connection);
  };
  callbacks.log_message = [](const mg_connection* connection, const char* message) {
    Server& server = of(mg_get_user_context_data(connection));
    if (!server.listening_ && server.start_error_.empty()) server.start_error_ = message;
    return 1;
  };
  callbacks.log_access = [](const mg_connection* /*connection*/, const char* /*message*/) { return 1; };

  const std::string address = fmt::format("{}:{}", parameters_.host, parameters_.port);
  const std::string threads = std::to_string(parameters_.pages + kHttpThreads);
  std::array<const char*, 17> options{"listening_ports",
                                      address.c_str(),
                                      "num_threads",
                                      threads.c_str(),
                                      "listen_backlog",
                                      kBacklog,
                                      "tcp_nodelay",
                                      "1",
                                      "request_timeout_ms",
                                      kHttpTimeout,
                                      "websocket_timeout_ms",
                                      kWebSocketTimeout,
                                      "enable_websocket_ping_pong",
                                      "yes",
                                      "enable_auth_domain_check",
                                      "no",  // `answer` checks the host
                                      nullptr};
  context_.reset(mg_start(&callbacks, this, options.data()));
  if (!context_) {
    const bool in_use = start_error_.find("in use") != std::string::npos;
    const std::string why = in_use ? "is in use by another program" : fmt::format("cannot be opened: {}", start_error_);
    throw InputError(
        fmt::format("page: port {} {}: choose another one, or 0 for any free port", parameters_.port, why));
  }
  mg_server_port listening{};
  if (mg_get_server_ports(context_.get(), 1, &listening) == 1) port_ = listening.port;
  listening_ = true;

  mg_set_websocket_handler(
      context_.get(), "/ws", [](const mg_connection*, void* self) { return of(self).is_full() ? 1 : 0; },
      [](mg_connection* connection, void* self) { of(self).enter(connection); },
      [](mg_connection* connection, int bits, char* text, std::size_t size, void* self) {
        return of(self).hear(connection, bits, {text, size}) ? 1 : 0;
      },
      [](const mg_connection* connection, void* self) { of(self).leave(connection); }, this);
}

void Cockpit::Server::knock() const {
  const char* host = parameters_.host == "[::1]" ? "::1" : parameters_.host.c_str();
  std::array<char, 100> error{};
  mg_connection* visitor = mg_connect_client(host, port_, 0, error.data(), error.size());
  if (visitor != nullptr) mg_close_connection(visitor);
}

/// First handler of every request. 0 passes it on to the WebSocket handler.
int Cockpit::Server::answer(mg_connection* connection) {
  const mg_request_info& request = *mg_get_request_info(connection);
  if (!may_be_answered(request)) {
    return respond_text(connection, 403, "Refused: this server answers only its own page, on this machine.");
  }
  const std::string_view method = request.request_method;
  const std::string_view path = request.local_uri_raw == nullptr ? "" : request.local_uri_raw;
  if (path == "/ws" && mg_get_header(connection, "Sec-WebSocket-Key") != nullptr) {
    return is_full() ? respond_text(connection, 503, "Too many pages are open.") : 0;
  }
  if (method != "GET" && method != "HEAD") return respond_text(connection, 405, "Only GET and HEAD.");
  if (path == "/model.json") return respond(connection, 200, "application/json", scene_);
  return answer_file(connection, path == "/" ? "/index.html" : path);
}

int Cockpit::Server::answer_file(mg_connection* connection, std::string_view name) {
  const auto path = file_in(parameters_.page, name);
  const auto content = path ? read_file(*path) : std::nullopt;
  if (content) return respond(connection, 200, mime_type(*path), *content);
  if (name == "/index.html") {
    return respond_text(connection, 503, "The page is not built: run `make page`, then reload.");
  }
  return respond_text(connection, 404, "There is no such file.");
}

std::size_t Cockpit::Server::pages() {
  const std::scoped_lock lock(pages_mutex_);
  return pages_.size();
}

void Cockpit::Server::enter(mg_connection* connection) {
  auto page = std::make_unique<Page>();
  Page& entered = *page;
  entered.connection = connection;
  {
    const std::scoped_lock lock(pages_mutex_);
    entered.number = ++last_number_;
    pages_.emplace(connection, std::move(page));
  }
  entered.sender = std::thread([this, &entered] { send_states(entered); });
}

/// False closes the connection. Called on the page's own thread, like `enter` and `leave`.
bool Cockpit::Server::hear(const mg_connection* connection, int bits, std::string_view text) {
  constexpr int kFinal = 0x80;
  const int opcode = bits & 0x0F;
  if (opcode == MG_WEBSOCKET_OPCODE_CONNECTION_CLOSE) return false;
  if (opcode == MG_WEBSOCKET_OPCODE_PING || opcode == MG_WEBSOCKET_OPCODE_PONG) return true;
  Page* page = nullptr;
  {
    const std::scoped_lock lock(pages_mutex_);
    const auto found = pages_.find(connection);
    if (found == pages_.end()) return false;
    page = found->second.get();
  }
  if (opcode != MG_WEBSOCKET_OPCODE_TEXT || (bits & kFinal) == 0) {
    complain(*page, "a message must be one complete text");
    return true;
  }
  const PageMessage message = parse_page_message(text);
  if (std::holds_alternative<TakeSeat>(message)) {
    if (!device_.take(page->number)) complain(*page, "another page drives; this one watches");
  } else if (std::holds_alternative<LeaveSeat>(message)) {
    device_.release(page->number);
  } else if (std::holds_alternative<AskDamp>(message)) {
    damp_asked_ = true;
  } else if (const auto* steer = std::get_if<Steer>(&message)) {
    if (!device_.give(page->number, steer->command, steer->deadman)) complain(*page, "this page does not drive");
  } else {
    complain(*page, std::get<Malformed>(message).why);
  }
  return text.size() <= kLargestMessage;
}

void Cockpit::Server::leave(const mg_connection* connection) {
  std::unique_ptr<Page> page;
  {
    const std::scoped_lock lock(pages_mutex_);
    const auto found = pages_.find(connection);
    if (found == pages_.end()) return;
    page = std::move(found->second);
    pages_.erase(found);
  }
  device_.release(page->number);
  {
    const std::scoped_lock lock(frame_mutex_);
    page->leaving = true;
  }
  frame_came_.notify_all();
  page->sender.join();
}

void Cockpit::Server::complain(Page& page, std::string_view text) {
  {
    const std::scoped_lock lock(frame_mutex_);
    page.errors = text;
  }
  frame_came_.notify_all();
}

void Cockpit::Server::send_states(Page& page) {
  using Clock = std::chrono::steady_clock;
  const auto period = std::chrono::duration_cast<Clock::duration>(std::chrono::duration<double>(parameters_.period));
  const auto send = [&page](int opcode, std::string_view text) {
    return mg_websocket_write(page.connection, opcode, text.data(), text.size()) > 0;
  };
  std::uint64_t sent = 0;
  Clock::time_point next = Clock::now();
  bool open = true;
  while (open) {
    std::shared_ptr<const Frame> frame;
    std::string error;
    {
      std::unique_lock lock(frame_mutex_);
      const auto ended = [&] { return stopping_ || page.leaving; };
      frame_came_.wait(lock, [&] { return ended() || frames_ != sent || !page.errors.empty(); });
      if (frames_ != sent) frame_came_.wait_until(lock, next, [&] { return ended() || !page.errors.empty(); });
      if (ended()) break;
      error.swap(page.errors);
      if (frames_ != sent && Clock::now() >= next) {
        frame = frame_;
        sent = frames_;
      }
    }
    if (!error.empty()) open = send(MG_WEBSOCKET_OPCODE_TEXT, error_message(error));
    if (open && frame) {
      next = std::max(next + period, Clock::now());
      const std::optional<PageDevice::Page> driver = device_.driver();
      const Role role = driver == page.number ? Role::driver : Role::watcher;
      // Tell a driver about its own stick, even if another device is in command.
      const DeviceStatus own = device_.status();
      const DeviceStatus& device = role == Role::driver && !own.armed ? own : frame->device;
      open = send(MG_WEBSOCKET_OPCODE_TEXT, state_message(*frame, device, robot_, role, driver.has_value()));
    }
  }
  send(MG_WEBSOCKET_OPCODE_CONNECTION_CLOSE, {});
}

Cockpit::Cockpit(const Parameters& parameters, const RobotModel& robot, const std::string& world, const mjModel& scene)
    : server_(std::make_unique<Server>(parameters, robot, world, scene)) {}

Cockpit::~Cockpit() = default;

int Cockpit::port() const {
  return server_->port();
}
std::string Cockpit::url() const {
  return server_->url();
}
std::size_t Cockpit::pages() const {
  return server_->pages();
}
void Cockpit::publish(Frame frame) {
  server_->publish(std::move(frame));
}
bool Cockpit::damp_asked() const {
  return server_->damp_asked();
}
Device& Cockpit::device() {
  return server_->device();
}

}  // namespace baton
