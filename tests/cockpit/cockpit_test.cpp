#include "baton/cockpit/cockpit.hpp"
#include "tests/support/temp.hpp"

#include <arpa/inet.h>
#include <civetweb.h>
#include <fmt/format.h>
#include <gtest/gtest.h>
#include <netinet/in.h>
#include <sys/socket.h>
#include <unistd.h>

#include <array>
#include <atomic>
#include <chrono>
#include <fstream>
#include <functional>
#include <limits>
#include <nlohmann/json.hpp>

#include "baton/model/error.hpp"
#include "baton/model/world.hpp"
#include "tests/support/browser.hpp"
#include "tests/support/robots.hpp"

namespace baton {
namespace {

using nlohmann::json;
using test::Browser;
using test::kPatience;

const mjModel& room_with_mighty() {
  static const ModelPtr model = [] {
    const std::string text = World::load("room").compose(test::robot("mighty"), 0.001);
    const SpecPtr spec(mj_parseXMLString(text.c_str(), nullptr, nullptr, 0));
    return compile_model(*spec, "room with mighty");
  }();
  return *model;
}

struct Response {
  int status = 0;
  std::string type;
  std::string body;
};

/// Sends a request as it is written, and reads the answer.
Response request(int port, const std::string& text) {
  std::array<char, 256> error{};
  mg_connection* connection = mg_connect_client("127.0.0.1", port, 0, error.data(), error.size());
  if (connection == nullptr) return {};
  mg_write(connection, text.data(), text.size());
  Response response;
  if (mg_get_response(connection, error.data(), error.size(), 20000) >= 0) {
    response.status = mg_get_response_info(connection)->status_code;
    const char* type = mg_get_header(connection, "Content-Type");
    response.type = type == nullptr ? "" : type;
    std::array<char, 4096> block{};
    for (int n = 0; (n = mg_read(connection, block.data(), block.size())) > 0;) {
      response.body.append(block.data(), static_cast<std::size_t>(n));
    }
  }
  mg_close_connection(connection);
  return response;
}

Response get(int port, const std::string& path, const std::string& headers = "Host: localhost\r\n") {
  return request(port, fmt::format("GET {} HTTP/1.1\r\n{}\r\n", path, headers));
}

const std::string kUpgrade =
    "Upgrade: websocket\r\nConnection: Upgrade\r\nSec-WebSocket-Version: 13\r\n"
    "Sec-WebSocket-Key: dGhlIHNhbXBsZSBub25jZQ==\r\n";

class CockpitTest : public testing::Test {
 protected:
  CockpitTest() {
    std::filesystem::create_directories(page_ / "assets");
    std::ofstream(page_ / "index.html") << "<p>page</p>";
    std::ofstream(page_ / "assets" / "main.js") << "1";
    std::ofstream(page_ / ".." / "secret.txt") << "secret";
  }
  ~CockpitTest() override { std::filesystem::remove_all(folder_); }

  /// Publishes moments until the page is told a state that fits.
  json state_of(Browser& browser, const std::function<bool(const json&)>& fits) {
    const auto give_up = std::chrono::steady_clock::now() + kPatience;
    while (std::chrono::steady_clock::now() < give_up) {
      frame_.t += 0.005;
      cockpit_.publish(frame_);
      json state = browser.next([](const json& m) { return m["type"] == "state"; });
      if (state.is_null() || fits(state)) return state;
    }
    return nullptr;
  }

  static Command forward() {
    Command command;
    command.axes[0] = 0.5;
    return command;
  }

  const RobotModel& robot_ = test::robot("mighty");
  const std::filesystem::path folder_ =
      std::filesystem::path(test::temp_folder()) /
      fmt::format("baton_{}_{}", testing::UnitTest::GetInstance()->current_test_info()->name(), fmt::ptr(this));
  const std::filesystem::path page_ = folder_ / "page";
  std::atomic<double> now_ = 0.0;  ///< of the clock that counts the driver's silence [s]
  Cockpit cockpit_{Cockpit::Parameters{.port = 0, .page = page_, .clock = [this] { return now_.load(); }}, robot_,
                   "room", room_with_mighty()};
  int port_ = cockpit_.port();
  Frame frame_;
};

TEST_F(CockpitTest, ServesThePageAndNothingElse) {
  EXPECT_GT(port_, 0);
  EXPECT_EQ(cockpit_.url(), fmt::format("http://127.0.0.1:{}/", port_));
  const Response index = get(port_, "/");
  EXPECT_EQ(index.status, 200);
  EXPECT_EQ(index.type, "text/html; charset=utf-8");
  EXPECT_EQ(index.body, "<p>page</p>");
  EXPECT_EQ(get(port_, "/assets/main.js").type, "text/javascript; charset=utf-8");
  EXPECT_EQ(request(port_, "HEAD / HTTP/1.1\r\nHost: localhost\r\n\r\n").status, 200);
  for (const char* path : {"/../secret.txt", "/assets/../../secret.txt", "/%2e%2e/secret.txt", "//secret.txt",
                           "/..%2fsecret.txt", "/assets", "/nothing.js", "/ws", "/index.html/"}) {
    const Response response = get(port_, path);
    EXPECT_GE(response.status, 400) << path;
    EXPECT_EQ(response.body.find("secret"), std::string::npos) << path;
  }
  EXPECT_EQ(request(port_, "POST / HTTP/1.1\r\nHost: localhost\r\nContent-Length: 0\r\n\r\n").status, 405);
}

TEST_F(CockpitTest, SaysThatThePageIsNotBuilt) {
  std::filesystem::remove_all(page_);
  const Response index = get(port_, "/");
  EXPECT_EQ(index.status, 503);
  EXPECT_NE(index.body.find("make page"), std::string::npos);
}

TEST_F(CockpitTest, RefusesForeignHostsAndOrigins) {
  const std::string own = fmt::format("127.0.0.1:{}", port_);
  for (const std::string& host : {own, fmt::format("localhost:{}", port_), std::string("[::1]:1")}) {
    EXPECT_EQ(get(port_, "/", fmt::format("Host: {0}\r\nOrigin: http://{0}\r\n", host)).status, 200) << host;
  }
  const std::array<std::string, 10> foreign{
      "Host: evil.example\r\n",
      fmt::format("Host: evil.example:{}\r\n", port_),
      "Host: 127.0.0.1.evil.example\r\n",
      "Host: localhost:80x\r\n",
      "",
      fmt::format("Host: {}\r\nHost: evil.example\r\n", own),
      fmt::format("Host: {}\r\nOrigin: http://evil.example\r\n", own),
      fmt::format("Host: {}\r\nOrigin: null\r\n", own),
      fmt::format("Host: {}\r\nOrigin: http://127.0.0.1:1\r\n", own),
      fmt::format("Host: {0}\r\nOrigin: https://{0}\r\n", own),
  };
  for (const std::string& headers : foreign) {
    for (const char* path : {"/", "/model.json", "/ws"}) {
      EXPECT_EQ(get(port_, path, headers).status, 403) << path << " " << headers;
      EXPECT_EQ(get(port_, path, headers + kUpgrade).status, 403) << path << " " << headers;
    }
  }
  EXPECT_EQ(get(port_, "/ws", "Host: localhost\r\nOrigin: http://localhost\r\n" + kUpgrade).status, 101);
}

TEST_F(CockpitTest, DescribesTheScene) {
  const Response response = get(port_, "/model.json");
  ASSERT_EQ(response.status, 200);
  const json scene = json::parse(response.body);
  const mjModel& m = room_with_mighty();
  EXPECT_EQ(scene["robot"], "mighty");
  EXPECT_EQ(scene["world"], "room");
  ASSERT_EQ(scene["bodies"].size(), static_cast<std::size_t>(m.nbody));
  for (int b = 1; b < m.nbody; ++b)
    EXPECT_EQ(scene["bodies"][b]["name"], name_of(m, mjOBJ_BODY, b));
  ASSERT_EQ(scene["parts"].size(), 5u);
  EXPECT_EQ(scene["parts"][4]["name"], "trunk");
  EXPECT_EQ(scene["bodies"][scene["parts"][4]["body"].get<int>()]["name"], robot_.profile().parts.trunk);
  EXPECT_GT(scene["geoms"].size(), 20u);
  for (const json& geom : scene["geoms"]) {
    EXPECT_LE(geom["group"], 2) << geom;  // every body of mighty has visual geoms
    EXPECT_EQ(geom["quat"].size(), 4u);
  }
  const auto is_door = [](const json& site) { return site["name"] == "door_B"; };
  EXPECT_TRUE(std::any_of(scene["sites"].begin(), scene["sites"].end(), is_door));
}

TEST_F(CockpitTest, TellsAllPagesTheNewestState) {
  Browser first(port_);
  Browser second(port_);
  frame_.bodies.assign(3, Pose{{1.0, 2.0, 3.0}, rotation_z(M_PI)});
  frame_.balance.com = {0.1, std::numeric_limits<double>::quiet_NaN(), 0.26};
  frame_.segment.goal.emplace();
  frame_.segment.goal->kind = SegmentKind::step;
  frame_.segment.goal->swing = Side::right;
  frame_.segment.goal->sole.left.p.x() = 0.5;
  frame_.refusal = Refusal{Reason::joint_limit, Part::left_hand, 1.5, 1.4, "elb\xffow"};
  frame_.refusal->cause = Reason::zmp;
  frame_.refusals = 7;
  frame_.stuck = Stuck{Part::left_foot, 3, true, false};
  frame_.activity = Activity::retracing;
  frame_.segment.limit = Refusal{Reason::foot_region, Part::left_foot, 0.12, 0.11, "forward"};
  frame_.history = 12;
  frame_.command.recall = Recall::home;
  frame_.balance.support = robot_.sole(Side::left);
  for (Browser* page : {&first, &second}) {
    const json state = state_of(*page, [](const json& s) { return s["t"] > 0.0; });
    ASSERT_FALSE(state.is_null());
    EXPECT_EQ(state["bodies"][2], json({1.0, 2.0, 3.0, 0.0, 0.0, 0.0, 1.0}));
    EXPECT_TRUE(state["com"][1].is_null());
    EXPECT_EQ(state["goal"]["kind"], "step");
    EXPECT_EQ(state["goal"]["swing"], "right");
    EXPECT_NEAR(state["goal"]["soles"][0][0][0].get<double>(), 0.5 + robot_.sole(Side::left).vertices()[0].x(), 1e-4);
    EXPECT_EQ(state["refusal"]["reason"], "joint_limit");
    EXPECT_EQ(state["refusal"]["cause"], "zmp");
    EXPECT_EQ(state["refusals"], 7);
    EXPECT_EQ(state["stuck"], json({{"part", "left_foot"}, {"times", 3}, {"retrace", true}, {"home", false}}));
    EXPECT_EQ(state["state"], "retracing");
    EXPECT_EQ(state["limit"]["reason"], "foot_region");
    EXPECT_EQ(state["limit"]["where"], "forward");
    EXPECT_TRUE(state["limit"]["cause"].is_null());
    EXPECT_EQ(state["history"], 12);
    EXPECT_EQ(state["recall"], "home");
    EXPECT_EQ(state["support"].size(), 4u);
    EXPECT_EQ(state["role"], "watcher");
    EXPECT_EQ(state["taken"], false);
  }
}

TEST_F(CockpitTest, TellsWhatTheRobotDoesInAWord) {
  Browser page(port_);
  for (const auto& [activity, word] : {std::pair{Activity::rest, "rest"},
                                       {Activity::moving, "moving"},
                                       {Activity::stopping, "stopping"},
                                       {Activity::retracing, "retracing"},
                                       {Activity::fallen, "fallen"}}) {
    frame_.activity = activity;
    const double now = frame_.t;
    EXPECT_EQ(state_of(page, [now](const json& s) { return s["t"] > now; })["state"], word);
  }
}

TEST_F(CockpitTest, KnowsHowManyPagesAreOpen) {
  EXPECT_EQ(cockpit_.pages(), 0u);
  Browser first(port_);
  {
    Browser second(port_);
    first.settle();
    second.settle();
    EXPECT_EQ(cockpit_.pages(), 2u);
    first.say(R"({"type":"drive"})");
    EXPECT_FALSE(state_of(second, [](const json& s) { return s["taken"] == true; }).is_null());
    EXPECT_EQ(cockpit_.pages(), 2u) << "whether they drive or not";
  }
  EXPECT_FALSE(state_of(first, [this](const json&) { return cockpit_.pages() == 1; }).is_null());
  EXPECT_EQ(cockpit_.pages(), 1u);
}

TEST_F(CockpitTest, OnePageDrivesAndTheOthersWatch) {
  Browser first(port_);
  Browser second(port_);
  first.say(R"({"type":"drive"})");
  first.settle();
  EXPECT_EQ(second.error_after(R"({"type":"drive"})"), "another page drives; this one watches");
  EXPECT_EQ(state_of(first, [](const json& s) { return s["taken"] == true; })["role"], "driver");
  EXPECT_EQ(state_of(second, [](const json& s) { return s["taken"] == true; })["role"], "watcher");

  first.steer({});
  first.steer(forward());
  first.settle();
  second.steer({});
  second.settle();
  EXPECT_EQ(cockpit_.device().read(1.0), forward());

  first.close();  // frees the seat
  EXPECT_FALSE(state_of(second, [](const json& s) { return s["taken"] == false; }).is_null());
  EXPECT_EQ(cockpit_.device().read(1.0), Command{});
  second.say(R"({"type":"drive"})");
  EXPECT_FALSE(state_of(second, [](const json& s) { return s["role"] == "driver"; }).is_null());
  second.say(R"({"type":"release"})");
  EXPECT_FALSE(state_of(second, [](const json& s) { return s["taken"] == false; }).is_null());
}

TEST_F(CockpitTest, CommandsCountOnceTheDriverWasNeutral) {
  Device& device = cockpit_.device();
  EXPECT_FALSE(device.status().connected);
  Browser page(port_);
  page.say(R"({"type":"drive"})");
  page.steer(forward());
  page.settle();
  EXPECT_EQ(device.read(0.0), Command{});
  EXPECT_TRUE(device.status().connected);
  EXPECT_FALSE(device.status().armed);
  EXPECT_FALSE(device.status().hint.empty());

  page.steer({.guide = Part::left_hand});
  page.steer(forward());
  page.settle();
  EXPECT_EQ(device.read(0.1), forward());
  EXPECT_TRUE(device.status().armed);
  EXPECT_EQ(device.status().hint, "");

  page.steer(forward(), /*deadman=*/false);
  page.settle();
  EXPECT_EQ(device.read(0.2), Command{});
}

TEST_F(CockpitTest, TheWaysBackAreCommandsLikeOthers) {
  Device& device = cockpit_.device();
  Browser page(port_);
  page.say(R"({"type":"drive"})");
  const Command retrace{.recall = Recall::retrace};
  const Command home{.recall = Recall::home};
  page.steer(retrace);
  page.settle();
  EXPECT_EQ(device.read(0.0), Command{}) << "the driver was not neutral yet";
  page.steer({});
  page.steer(retrace);
  page.settle();
  EXPECT_EQ(device.read(0.1), retrace);
  page.steer(home);
  page.settle();
  EXPECT_EQ(device.read(0.2), home);
  now_ = now_ + 0.3;
  EXPECT_EQ(device.read(0.5), Command{}) << "the driver is silent";
  page.steer(home, /*deadman=*/false);
  page.settle();
  EXPECT_EQ(device.read(0.6), Command{});
  const json state = state_of(page, [](const json& s) { return s["t"] > 0.0; });
  EXPECT_EQ(state["recall"], "none");
  EXPECT_TRUE(state["limit"].is_null());
}

TEST_F(CockpitTest, ASilentDriverCountsAsCentredAndIsTold) {
  Device& device = cockpit_.device();
  Browser page(port_);
  Browser watcher(port_);
  page.say(R"({"type":"drive"})");
  Command reach = forward();
  reach.guide = Part::right_hand;
  page.steer({});
  page.steer(reach);
  page.settle();
  EXPECT_EQ(device.read(0.0), reach);
  now_ = now_ + 0.26;  // the connection stands, and nothing comes
  EXPECT_EQ(device.read(0.0), Command{.guide = Part::right_hand});
  const auto hint = [](const json& state) { return state["device"]["hint"].get<std::string>(); };
  const auto says = [&](const std::string& words) {
    return [&hint, words](const json& state) { return hint(state).find(words) != std::string::npos; };
  };
  EXPECT_FALSE(state_of(page, says("No signal")).is_null());

  page.steer(reach);
  page.settle();
  EXPECT_TRUE(device.read(0.0).neutral()) << "it was not at rest yet";
  // Another device may be obeyed meanwhile; the driver learns that its own is not.
  frame_.device = {.name = "stick", .connected = true, .armed = true, .hint = ""};
  EXPECT_FALSE(state_of(page, says("Release")).is_null());
  EXPECT_FALSE(state_of(watcher, [](const json& s) { return s["device"]["name"] == "stick"; }).is_null());
  page.steer({});
  page.steer(reach);
  page.settle();
  EXPECT_EQ(device.read(0.0), reach);
  EXPECT_FALSE(state_of(page, [](const json& s) { return s["device"]["name"] == "stick"; }).is_null());
}

TEST_F(CockpitTest, WhatIsNotANumberIsCentred) {
  Browser page(port_);
  page.say(R"({"type":"drive"})");
  page.steer({});
  page.say(
      R"({"type":"command","guide":"trunk","axes":[null,1e9,-7,0,0,0],"lift":[null,3],"deadman":true,"recall":"none"})");
  page.settle();
  const Command command = cockpit_.device().read(0.0);
  EXPECT_EQ(command.axes, (Vec6() << 0, 1, -1, 0, 0, 0).finished());
  EXPECT_EQ(command.lift.left, 0.0);
  EXPECT_EQ(command.lift.right, 1.0);
}

TEST_F(CockpitTest, AnyPageMayDampWhoeverDrives) {
  Browser driver(port_);
  driver.say(R"({"type":"drive"})");
  driver.steer({});
  Browser watcher(port_);
  EXPECT_FALSE(cockpit_.damp_asked());
  EXPECT_NE(watcher.error_after(R"({"type":"damp!"})"), "");
  EXPECT_FALSE(cockpit_.damp_asked());
  watcher.say(R"({"type":"damp"})");
  EXPECT_NE(watcher.error_after("{}"), "");  // it has been heard by then
  EXPECT_TRUE(cockpit_.damp_asked());
}

TEST_F(CockpitTest, ComplainsAboutMalformedMessages) {
  Browser page(port_);
  page.say(R"({"type":"drive"})");
  page.steer({});
  std::vector<std::string> malformed{
      "", "{", "[]", "7", "{}", "\xff\xfe", std::string(4000, '['), R"({"type":7})", R"({"type":"command"})"};
  const json good{{"type", "command"}, {"guide", "trunk"}, {"axes", {0, 0, 0, 0, 0, 0}},
                  {"lift", {0, 0}},    {"deadman", true},  {"recall", "none"}};
  const std::vector<std::pair<std::string, json>> changes{{"guide", "tail"},
                                                          {"axes", {0, 0, 0, 0, 0}},
                                                          {"axes", {0, 0, 0, 0, 0, "1"}},
                                                          {"lift", 0},
                                                          {"deadman", 1},
                                                          {"recall", "back"},
                                                          {"recall", ""},
                                                          {"recall", true},
                                                          {"recall", nullptr},
                                                          {"recall", 1},
                                                          {"recall", json::array({"home"})}};
  for (const auto& [key, value] : changes) {
    json message = good;
    message[key] = value;
    malformed.push_back(message.dump());
  }
  for (const auto& entry : good.items()) {
    json message = good;
    message.erase(entry.key());
    malformed.push_back(message.dump());
  }
  for (const std::string& text : malformed) {
    EXPECT_NE(page.error_after(text), "") << text;
  }
  EXPECT_NE(page.error_after("{}", MG_WEBSOCKET_OPCODE_BINARY), "");
  page.steer(forward());
  page.settle();
  EXPECT_EQ(cockpit_.device().read(0.0), forward());  // still there, still driving
  page.say(std::string(100'000, ' '));                // that much ends the connection, and frees the seat
  Browser watcher(port_);
  EXPECT_FALSE(state_of(watcher, [](const json& s) { return s["taken"] == false; }).is_null());
}

TEST_F(CockpitTest, LimitsTheNumberOfPages) {
  std::vector<std::unique_ptr<Browser>> pages;
  for (int i = 0; i < Cockpit::Parameters{}.pages; ++i) {
    pages.push_back(std::make_unique<Browser>(port_));
    pages.back()->settle();
  }
  EXPECT_EQ(get(port_, "/ws", "Host: localhost\r\n" + kUpgrade).status, 503);
  EXPECT_EQ(get(port_, "/").status, 200);
}

/// Connections that are opened and then say this much; they stand as long as the object does.
class HalfOpen {
 public:
  HalfOpen(int port, int count, const std::string& says) {
    sockaddr_in address{};
    address.sin_family = AF_INET;
    address.sin_port = htons(static_cast<std::uint16_t>(port));
    address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    for (int i = 0; i < count; ++i) {
      const int socket = ::socket(AF_INET, SOCK_STREAM, 0);
      EXPECT_EQ(::connect(socket, reinterpret_cast<const sockaddr*>(&address), sizeof(address)), 0);
      sockets_.push_back(socket);
    }
    say(says);
  }
  ~HalfOpen() {
    for (const int socket : sockets_)
      ::close(socket);
  }
  HalfOpen(const HalfOpen&) = delete;
  HalfOpen& operator=(const HalfOpen&) = delete;

  void say(const std::string& text) {
    for (const int socket : sockets_)
      ::send(socket, text.data(), text.size(), MSG_NOSIGNAL);
  }

 private:
  std::vector<int> sockets_;
};

TEST_F(CockpitTest, HalfOpenConnectionsDoNotKeepPagesOut) {
  // Each held a thread of sixteen for 5 s, so that a page waited for 30 s behind 100 of them.
  const HalfOpen silent(port_, 100, "");
  HalfOpen slow(port_, 100, "GET / HTTP/1.1\r\nHost: localhost\r\n");
  const HalfOpen bodies(port_, 100, "POST / HTTP/1.1\r\nHost: localhost\r\nContent-Length: 1000000000\r\n\r\nx");
  for (int i = 0; i < 3; ++i) {
    slow.say("X");
    EXPECT_EQ(get(port_, "/").status, 200);
  }
  Browser page(port_);
  page.say(R"({"type":"drive"})");
  EXPECT_EQ(state_of(page, [](const json& s) { return s["role"] == "driver"; })["role"], "driver");
}

TEST_F(CockpitTest, NamesThePortThatItCannotHave) {
  try {
    const Cockpit second({.port = port_}, robot_, "room", room_with_mighty());
    FAIL();
  } catch (const InputError& error) {
    EXPECT_EQ(error.what(), fmt::format("page: port {} is in use by another program: choose another one, or 0 for "
                                        "any free port",
                                        port_));
  }
  EXPECT_THROW(Cockpit({.port = 65536}, robot_, "room", room_with_mighty()), InputError);
  EXPECT_THROW(Cockpit({.port = -1}, robot_, "room", room_with_mighty()), InputError);
  EXPECT_THROW(Cockpit({.host = "0.0.0.0", .port = 0}, robot_, "room", room_with_mighty()), InputError);
  EXPECT_THROW(Cockpit({.host = "", .port = 0}, robot_, "room", room_with_mighty()), InputError);
}

}  // namespace
}  // namespace baton
