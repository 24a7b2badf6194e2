/// Values of options, and what is missing: each complaint is one short line that names the option, the value and what
/// is right.
#include <gmock/gmock.h>

#include <netinet/in.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>

#include "tests/support/scratch.hpp"

namespace baton {
namespace {

using test::Outcome;
using test::run;
using testing::AllOf;
using testing::HasSubstr;
using testing::Not;

std::string complaint(const std::vector<std::string>& args) {
  const Outcome outcome = run(args);
  EXPECT_EQ(outcome.code, app::kBadInput) << testing::PrintToString(args);
  EXPECT_EQ(std::count(outcome.err.begin(), outcome.err.end(), '\n'), 1) << outcome.err;
  EXPECT_LT(outcome.err.size(), 160U) << outcome.err;
  return outcome.err;
}

TEST(Options, ANumberThatIsNoneOrOutOfItsRangeIsNamedWithTheRange) {
  const std::vector<std::string> nowhere{"nan", "inf", "-inf", "1e999", "abc", "1x", "0x", "1 2", "1e308", "-1"};
  const std::string soak = "soak";
  const std::string drive = "drive";
  for (const auto& [command, option, range] :
       {std::array<std::string, 3>{drive, "--seconds", "a number above 0, up to 1000000"},
        {"operate", "--seconds", "a number above 0, up to 1000000"},
        {"operate", "--sight", "a number from 0.1 to 100"},
        {"plan", "--seconds", "a number from 0 to 86400"},
        {drive, "--times", "a number from 0 to 100"},
        {soak, "--times", "a number from 0 to 100"},
        {soak, "--hours", "a number above 0, up to 100000"},
        {soak, "--episode", "a number from 0.1 to 36000"},
        {drive, "--port", "a whole number from 0 to 65535"},
        {soak, "--jobs", "a whole number from 1 to 1024"},
        {soak, "--segments", "a whole number of at least 1"},
        {soak, "--seeds", "a whole number of at least 1"}}) {
    for (const std::string& value : nowhere) {
      EXPECT_THAT(complaint({command, option + "=" + value}),
                  AllOf(HasSubstr(option + ": " + value), HasSubstr("is not " + range)));
    }
  }
  for (const std::string value : {"65536", "80.5", "1e3", "99999999999999999999"})
    EXPECT_THAT(complaint({drive, "--port", value}), HasSubstr("--port: " + value + " is not a whole number"));
  EXPECT_THAT(complaint({drive, "--seed", "x"}), HasSubstr("--seed: x is not a whole number"));
  EXPECT_THAT(complaint({drive, "--seconds", std::string(5000, '9')}), HasSubstr("--seconds"));
}

TEST(Options, ANumberIsTakenAsItIsWritten) {
  const test::Scratch scratch;
  for (const auto& [given, seed] : {std::pair<std::string, long>{"010", 10}, {"+7", 7}, {"-3", -3}}) {
    const Outcome outcome = run({"drive", "--on", "ideal", "--world", "flat", "--fast", "--seconds", "0.01",
                                 "--seed=" + given, "--report", scratch.path("r.json")});
    ASSERT_EQ(outcome.code, app::kDone) << outcome.err;
    EXPECT_EQ(scratch.json("r.json")["seed"], seed);
  }
}

TEST(Options, WhatIsMissingIsNamed) {
  EXPECT_THAT(complaint({"reproduce"}), HasSubstr("reproduce: WHAT is missing: fig8, room or walks"));
  EXPECT_THAT(complaint({"reproduce", "fig8"}), HasSubstr("reproduce: --out is missing"));
  EXPECT_THAT(complaint({"plan"}), HasSubstr("plan: SCRIPT is missing: Stick script"));
  EXPECT_THAT(complaint({"verify"}), HasSubstr("verify: MOTION is missing"));
  EXPECT_THAT(complaint({"replay", "--verify"}), HasSubstr("replay: RECORDING is missing"));
  EXPECT_THAT(complaint({"reproduce", "fig9", "--out", "x"}), AllOf(HasSubstr("fig9"), HasSubstr("walks")));
}

TEST(Options, APortInUseIsNamedWithWhatToDo) {
  const int taken = socket(AF_INET, SOCK_STREAM, 0);
  sockaddr_in address{};
  address.sin_family = AF_INET;
  address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  socklen_t size = sizeof address;
  ASSERT_EQ(bind(taken, reinterpret_cast<sockaddr*>(&address), size), 0);
  ASSERT_EQ(listen(taken, 1), 0);
  ASSERT_EQ(getsockname(taken, reinterpret_cast<sockaddr*>(&address), &size), 0);
  const std::string port = std::to_string(ntohs(address.sin_port));
  EXPECT_THAT(complaint({"drive", "--on", "ideal", "--world", "flat", "--seconds", "0.1", "--port", port}),
              AllOf(HasSubstr("--port " + port), HasSubstr("in use"), HasSubstr("0 for any")));
  close(taken);
}

}  // namespace
}  // namespace baton
