/// What the program does to files: none is left half written unnoticed, none is lost that was not to be replaced, and
/// none that is read blocks it.
#include <fcntl.h>
#include <gmock/gmock.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <csignal>
#include <thread>

#include "baton/model/error.hpp"
#include "baton/record/output_file.hpp"
#include "tests/input/virtual_joystick.hpp"
#include "tests/support/scratch.hpp"

namespace baton {
namespace {

namespace fs = std::filesystem;
using test::Outcome;
using test::run;
using testing::AllOf;
using testing::HasSubstr;

const std::string kHeldStick = R"({"t": 0, "guide": "trunk", "axes": [1, 0, 0, 0, 0, 0]})";

class Files : public testing::Test {
 protected:
  /// A name in the scratch folder for a device: where something is renamed over it, the device itself stays.
  std::string link(const std::string& name, const std::string& to) const {
    fs::create_symlink(to, scratch_.path(name));
    return scratch_.path(name);
  }
  std::string pipe(const std::string& name) const {
    EXPECT_EQ(mkfifo(scratch_.path(name).c_str(), 0600), 0);
    return scratch_.path(name);
  }
  [[nodiscard]] std::vector<std::string> names() const {
    std::vector<std::string> names;
    for (const auto& entry : fs::directory_iterator(fs::path(script_).parent_path()))
      names.push_back(entry.path().filename());
    std::sort(names.begin(), names.end());
    return names;
  }
  [[nodiscard]] std::vector<std::string> drive(const std::vector<std::string>& more) const {
    std::vector<std::string> args{"drive",  "--on",      "ideal", "--world", "flat",
                                  "--fast", "--seconds", "0.5",   "--input", "script:" + script_};
    args.insert(args.end(), more.begin(), more.end());
    return args;
  }

  const test::Scratch scratch_;
  const std::string script_ = scratch_.write("walk.jsonl", kHeldStick);
};

using Outputs = Files;
using Inputs = Files;

// --- what is written -----------------------------------------------------------------------------------

TEST_F(Outputs, OnAFullDiskEveryOneIsNamedAndTheExitCodeIsOne) {
  const std::string full = link("full", "/dev/full");
  link("fig8.json", "/dev/full");
  link("segment_000.json", "/dev/full");
  const std::string here = fs::path(script_).parent_path();
  struct Case {
    std::vector<std::string> args;
    std::string option;
    std::string file;
  };
  for (const Case& c :
       {Case{drive({"--report", full}), "--report", full}, Case{drive({"--trace", full}), "--trace", full},
        Case{drive({"--save-model", full}), "--save-model", full},
        Case{{"operate", "--seconds", "0.5", "--on", "ideal", "--report", full}, "--report", full},
        Case{{"operate", "--seconds", "0.5", "--on", "ideal", "--trace", full}, "--trace", full},
        Case{{"operate", "--seconds", "0.5", "--on", "ideal", "--script", full}, "--script", full},
        Case{{"soak", "--segments", "1", "--episode", "1", "--report", full}, "--report", full},
        Case{{"soak", "--scenario", "nominal", "--seeds", "1", "--episode", "1", "--report", full}, "--report", full},
        Case{{"plan", script_, "--seconds", "0.1", "--out", here}, "--out", here + "/segment_000.json"},
        Case{{"reproduce", "fig8", "--out", here}, "--out", here + "/fig8.json"}}) {
    const Outcome outcome = run(c.args);
    EXPECT_EQ(outcome.code, app::kFailed) << testing::PrintToString(c.args);
    EXPECT_THAT(outcome.err, HasSubstr(c.option + " " + c.file + ": could not be written completely"));
    EXPECT_TRUE(fs::is_character_file(full));
  }
  const Outcome both = run(drive({"--report", full, "--trace", full, "--record", scratch_.path("run.mcap")}));
  EXPECT_THAT(both.err, AllOf(HasSubstr("--report"), HasSubstr("--trace"), testing::Not(HasSubstr("--record"))));
  EXPECT_EQ(run({"replay", scratch_.path("run.mcap"), "--verify"}).code, app::kDone) << "the others are whole";
}

TEST_F(Outputs, SoIsStandardOutput) {
  std::fflush(stdout);
  const int saved = dup(STDOUT_FILENO);
  const int full = open("/dev/full", O_WRONLY);
  dup2(full, STDOUT_FILENO);
  testing::internal::CaptureStderr();
  const int code = app::run({"plan", script_, "--seconds", "0"});
  const std::string said = testing::internal::GetCapturedStderr();
  dup2(saved, STDOUT_FILENO);
  close(saved);
  close(full);
  std::clearerr(stdout);
  EXPECT_EQ(code, app::kFailed);
  EXPECT_THAT(said, HasSubstr("standard output: "));
}

TEST_F(Outputs, AnOlderReportStaysUntilTheNewOneIsWhole) {
  const test::SdlJoysticks sdl;
  const std::string report = scratch_.write("r.json", "old");
  std::string then;
  const auto drive_by_stick = [&](const std::string& trace) {
    test::HeldAv8r stick([&](test::HeldAv8r& /*hands*/, int look) {
      if (look == 50) then = scratch_.read("r.json");
    });
    return run({"drive", "--on", "ideal", "--world", "flat", "--input", "joystick", "--fast", "--seconds", "0.5",
                "--report", report, "--trace", trace});
  };
  EXPECT_EQ(drive_by_stick("/nowhere/t.csv").code, app::kBadInput);
  EXPECT_EQ(scratch_.read("r.json"), "old");
  ASSERT_EQ(drive_by_stick(scratch_.path("t.csv")).code, app::kDone);
  EXPECT_EQ(then, "old");
  EXPECT_EQ(scratch_.json("r.json")["falls"], 0);
  EXPECT_THAT(names(), testing::ElementsAre("r.json", "t.csv", "walk.jsonl")) << "nothing is left beside it";
}

TEST_F(Outputs, TwoThatAreTheSameFileAreRefusedBeforeAnythingIsWritten) {
  const std::string old = scratch_.write("old", "old");
  const std::string linked = link("linked", "old");
  const std::string dangling = link("dangling", "new");
  const std::string fresh = scratch_.path("new");
  fs::create_directory(scratch_.path("folder"));
  const std::string detour = scratch_.path("folder/../new");
  const std::vector<std::string> before = names();
  struct Case {
    std::vector<std::string> args;
    std::string one;
    std::string other;
  };
  for (const Case& c : {Case{drive({"--trace", fresh, "--report", fresh}), "--trace", "--report"},
                        Case{drive({"--trace", fresh, "--report", detour}), "--trace", "--report"},
                        Case{drive({"--trace", old, "--record", linked}), "--trace", "--record"},
                        Case{drive({"--save-model", dangling, "--report", fresh}), "--save-model", "--report"},
                        Case{drive({"--record", dangling, "--save-model", detour}), "--record", "--save-model"},
                        Case{drive({"--trace", script_}), "--trace", "--input"},
                        Case{drive({"--report", link("script", script_)}), "--report", "--input"},
                        Case{{"operate", "--script", fresh, "--trace", fresh}, "--script", "--trace"},
                        Case{{"operate", "--report", fresh, "--trace", detour}, "--report", "--trace"}}) {
    const Outcome outcome = run(c.args);
    EXPECT_EQ(outcome.code, app::kBadInput) << testing::PrintToString(c.args);
    EXPECT_THAT(outcome.err, AllOf(HasSubstr(c.one), HasSubstr(c.other), HasSubstr("the same file")));
  }
  EXPECT_EQ(scratch_.read("old"), "old");
  EXPECT_EQ(scratch_.read("walk.jsonl"), kHeldStick);
  fs::remove(scratch_.path("script"));
  EXPECT_EQ(names(), before);
  EXPECT_EQ(run(drive({"--trace", "/dev/null", "--report", "/dev/null"})).code, app::kDone);
}

TEST_F(Outputs, WhatIsReadIsNotWrittenOver) {
  const std::string world = scratch_.write("w.xml", R"(<mujoco><worldbody><site name="start"/>
<geom name="ground" type="plane" size="5 5 1"/></worldbody></mujoco>)");
  const std::string text = scratch_.read("w.xml");
  for (const std::vector<std::string>& args :
       {std::vector<std::string>{"drive", "--fast", "--seconds", "0.1", "--world", world, "--save-model", world},
        {"soak", "--segments", "1", "--world", world, "--report", world}}) {
    EXPECT_THAT(run(args).err, AllOf(HasSubstr("--world"), HasSubstr("the same file")));
    EXPECT_EQ(scratch_.read("w.xml"), text);
  }
}

TEST_F(Outputs, APipeIsWrittenToAndStaysOne) {
  const std::string pipe = this->pipe("pipe");
  std::string got;
  std::thread reader;
  const auto listen = [&] {
    const int fd = open(pipe.c_str(), O_RDONLY | O_NONBLOCK);
    fcntl(fd, F_SETFL, 0);
    reader = std::thread([&got, fd] {
      std::array<char, 4096> piece{};
      ssize_t n = 0;
      // Nothing is there to read until the other end is opened.
      while ((n = read(fd, piece.data(), piece.size())) > 0 || got.empty())
        got.append(piece.data(), static_cast<std::size_t>(std::max<ssize_t>(n, 0)));
      close(fd);
    });
  };
  for (const std::string option : {"--report", "--save-model", "--trace"}) {
    got.clear();
    listen();
    EXPECT_EQ(run(drive({option, pipe})).code, app::kDone);
    reader.join();
    EXPECT_GT(got.size(), 100U) << option;
    EXPECT_TRUE(fs::is_fifo(pipe));
    const Outcome alone = run(drive({option, pipe}));
    EXPECT_EQ(alone.code, app::kBadInput) << "it waits for nobody";
    EXPECT_THAT(alone.err, AllOf(HasSubstr(option + " " + pipe), HasSubstr("no reader")));
  }
}

TEST_F(Outputs, AReportGoesThroughALinkAndKeepsItsRights) {
  const std::string target = scratch_.write("target", "old");
  fs::permissions(target, fs::perms::owner_read | fs::perms::owner_write);
  fs::create_directory(scratch_.path("links"));
  const std::string direct = link("direct", target);
  const std::string relative = link("links/relative", "../direct");
  for (const std::string& name : {direct, relative}) {
    write_whole(name, "--report", name);
    EXPECT_TRUE(fs::is_symlink(name));
    EXPECT_EQ(scratch_.read("target"), name);
    EXPECT_EQ(fs::status(target).permissions(), fs::perms::owner_read | fs::perms::owner_write);
  }
  write_whole(link("dangling", "new"), "--report", "text");
  EXPECT_TRUE(fs::is_symlink(scratch_.path("dangling")));
  EXPECT_EQ(scratch_.read("new"), "text");
  { const OutputFile given_up(target, "--report"); }
  EXPECT_EQ(scratch_.read("target"), relative);
  link("round", "round");
  for (const std::string& name : {scratch_.path("none/file"), scratch_.path("links"), scratch_.path("round"),
                                  scratch_.path("target/file"), std::string()}) {
    EXPECT_THROW(write_whole(name, "--report", "text"), InputError) << name;
  }
  EXPECT_THAT(names(), testing::ElementsAre("dangling", "direct", "links", "new", "round", "target", "walk.jsonl"));
}

// --- what is read --------------------------------------------------------------------------------------

TEST_F(Inputs, WhatIsNotAFileOfASensibleSizeIsRefused) {
  const std::string folder = fs::path(script_).parent_path();
  scratch_.write("huge.json", "");
  fs::resize_file(scratch_.path("huge.json"), 65U << 20U);
  for (const std::string what : {"/dev/zero", "/dev/urandom", "pipe", "folder", "huge.json"}) {
    // Robots and worlds are known by their endings.
    const auto named = [&](const std::string& name) {
      const std::string file = scratch_.path(name);
      fs::remove(file);
      if (what == "pipe") return pipe(name);
      return link(name, what == "folder" ? folder : what);
    };
    const std::string report = named("z.json");
    for (const std::vector<std::string>& args :
         {std::vector<std::string>{"verify", report},
          {"replay", report},
          {"soak", "--segments", "1", "--resume", "--report", report},
          {"drive", "--robot", named("z.toml"), "--fast", "--seconds", "1"},
          {"drive", "--world", named("z.xml"), "--fast", "--seconds", "1"},
          {"plan", report},
          {"drive", "--input", "script:" + report, "--fast", "--seconds", "1"}}) {
      const bool script = args[0] == "plan" || args[1] == "--input";
      if (what == "pipe" && script) continue;                    // that is waited for
      if (what == "huge.json" && args[0] == "replay") continue;  // a recording may be long
      const Outcome outcome = run(args);
      EXPECT_EQ(outcome.code, app::kBadInput) << what << testing::PrintToString(args);
      EXPECT_THAT(outcome.err, AllOf(HasSubstr(scratch_.path("z.")),
                                     testing::AnyOf(HasSubstr(": is a "), HasSubstr("must be at most 64"))));
      EXPECT_EQ(std::count(outcome.err.begin(), outcome.err.end(), '\n'), 1) << outcome.err;
    }
  }
}

TEST_F(Inputs, AScriptMayComeThroughAPipe) {
  const std::string pipe = this->pipe("pipe");
  const std::string expected = run({"plan", script_, "--seconds", "0.5"}).out;
  std::thread writer([&] {
    std::ofstream out(pipe);  // waits for the reader
    out << kHeldStick.substr(0, 20) << std::flush << kHeldStick.substr(20);
  });
  const Outcome outcome = run({"plan", pipe, "--seconds", "0.5"});
  writer.join();
  EXPECT_EQ(outcome.code, app::kDone) << outcome.err;
  EXPECT_EQ(outcome.out, expected);
}

class EndedBy : public Files, public testing::WithParamInterface<int> {};

INSTANTIATE_TEST_SUITE_P(Signals, EndedBy, testing::Values(SIGINT, SIGTERM, SIGHUP));

TEST_P(EndedBy, ASignalNobodyWritesToAPipe) {
  const std::string pipe = this->pipe("pipe");
  std::thread writer([&] {
    const int fd = open(pipe.c_str(), O_WRONLY);  // waits for the reader
    kill(getpid(), GetParam());
    while (access(scratch_.path("over").c_str(), F_OK) != 0)
      std::this_thread::yield();
    close(fd);
  });
  const Outcome outcome = run({"plan", pipe});
  scratch_.write("over", "");
  writer.join();
  EXPECT_EQ(outcome.code, app::kFailed);
  EXPECT_THAT(outcome.err, AllOf(HasSubstr(pipe), HasSubstr("interrupted")));
}

TEST_P(EndedBy, ASignalALongPlanShowsWhatItHas) {
  scratch_.write("day.jsonl", kHeldStick + "\n{\"t\": 86400}\n");
  std::thread stops([&] {
    while (access(scratch_.path("out/segment_002.json").c_str(), F_OK) != 0)
      std::this_thread::yield();
    kill(getpid(), GetParam());
  });
  const Outcome outcome = run({"plan", scratch_.path("day.jsonl"), "--out", scratch_.path("out")});
  stops.join();
  EXPECT_EQ(outcome.code, app::kFailed);
  EXPECT_THAT(outcome.err, HasSubstr("interrupted"));
  const std::size_t segments = nlohmann::json::parse(outcome.out)["segments"].size();
  EXPECT_GE(segments, 3U);
}

}  // namespace
}  // namespace baton
