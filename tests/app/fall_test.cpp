/// A fall before the eyes of a page: the program stays until the page is left, and has written everything by then.
#include <gmock/gmock.h>
#include <netinet/in.h>
#include <sys/socket.h>
#include <unistd.h>

#include <atomic>
#include <csignal>
#include <thread>

#include "app/app.hpp"
#include "tests/support/browser.hpp"
#include "tests/support/scratch.hpp"

namespace baton {
namespace {

using nlohmann::json;
using test::Browser;
using test::Outcome;
using test::Scratch;
using testing::HasSubstr;

int free_port() {
  sockaddr_in address{};
  address.sin_family = AF_INET;
  address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  socklen_t size = sizeof(address);
  const int socket = ::socket(AF_INET, SOCK_STREAM, 0);
  ::bind(socket, reinterpret_cast<sockaddr*>(&address), size);
  ::getsockname(socket, reinterpret_cast<sockaddr*>(&address), &size);
  ::close(socket);
  return ntohs(address.sin_port);
}

class FallTest : public testing::Test {
 protected:
  /// A push that nothing can catch, after two seconds.
  Outcome fall(int port) {
    return test::run({"drive", "--world", "flat", "--scenario", "push", "--times", "8", "--input",
                      "script:" + scratch_.write("s.jsonl", R"({"t": 0})"), "--seconds", "60", "--port",
                      std::to_string(port), "--report", scratch_.path("r.json"), "--trace", scratch_.path("t.csv")});
  }

  /// Falls while a page looks on, which does that when it has seen the fall.
  Outcome fall_before(const std::function<void(Browser&)>& then) {
    const int port = free_port();
    std::atomic<bool> over{false};
    std::thread looks_on([&] {
      while (!over && !Browser::answers(port))
        std::this_thread::yield();
      if (over) return;
      Browser page(port);
      const auto lies = [](const json& m) { return m["type"] == "state" && m["state"] == "fallen"; };
      const json first = page.next(lies);
      ASSERT_FALSE(first.is_null());
      EXPECT_THAT(first["message"].get<std::string>(), HasSubstr("The robot fell: the trunk tilts"));
      for (int i = 0; i < 30; ++i)
        EXPECT_FALSE(page.next(lies).is_null()) << "it stays, and goes on telling";
      EXPECT_FALSE(over);
      report_ = scratch_.json("r.json");
      rows_ = scratch_.table("t.csv").size();
      then(page);
    });
    const Outcome outcome = fall(port);
    over = true;
    looks_on.join();
    return outcome;
  }

  const Scratch scratch_;
  json report_;  ///< as it was while the page saw the fall
  std::size_t rows_ = 0;
};

TEST_F(FallTest, ThePageShowsItUntilItIsLeft) {
  const Outcome outcome = fall_before([](Browser& page) { page.close(); });
  EXPECT_EQ(outcome.code, app::kFallen);
  EXPECT_EQ(report_["falls"], 1);
  EXPECT_EQ(report_, scratch_.json("r.json")) << "all was written when the waiting began";
  EXPECT_EQ(rows_, scratch_.table("t.csv").size());
  EXPECT_EQ(scratch_.table("t.csv").back()[3], "fallen");
  EXPECT_THAT(outcome.out, HasSubstr("fallen: the trunk tilts"));
}

TEST_F(FallTest, ASignalEndsTheWaiting) {
  for (const int signal : {SIGINT, SIGTERM}) {
    const Outcome outcome = fall_before([signal](Browser& page) {
      std::raise(signal);
      const auto closed = [](const json& m) { return m["type"] == "closed"; };
      EXPECT_FALSE(page.next(closed).is_null());
    });
    EXPECT_EQ(outcome.code, app::kFallen);
    EXPECT_EQ(report_["falls"], 1);
  }
}

TEST_F(FallTest, WithNoPageItEndsAtOnce) {
  const Outcome outcome = fall(0);
  EXPECT_EQ(outcome.code, app::kFallen);
  EXPECT_EQ(scratch_.json("r.json")["falls"], 1);
}

}  // namespace
}  // namespace baton
