/// MCAP files by what was written into them, whatever happens to them. What other programs make of them is in
/// tests/python/test_recording.py.
#include <gmock/gmock.h>

#include <random>

#include "baton/mcap/cdr.hpp"
#include "baton/mcap/reader.hpp"
#include "baton/mcap/writer_thread.hpp"
#include "baton/model/error.hpp"
#include "tests/support/recording_edit.hpp"
#include "tests/support/scratch.hpp"

namespace baton::mcap {
namespace {

using test::Memory;
using test::Scratch;
using testing::HasSubstr;

struct Sent {
  std::uint16_t channel;
  std::uint32_t sequence;
  std::uint64_t time;
  std::string data;

  bool operator==(const Sent&) const = default;
};

/// A file of random messages.
struct Sample {
  std::string bytes;
  std::vector<Sent> sent;
  std::vector<std::size_t> ends;   ///< of the head and of each chunk with its indexes
  std::vector<std::size_t> until;  ///< messages that a file has which ends there

  explicit Sample(std::uint64_t seed, bool finished = true) {
    std::mt19937_64 random(seed);
    Writer writer(std::make_unique<Memory>(bytes), "ros2", "test");
    writer.add("m", Metadata{{"key", "value"}, {"", ""}});
    writer.add(Attachment{"a", "text/plain", std::string(random() % 3000, 'x')});
    const std::uint16_t schema = writer.add(Schema{"s", "jsonschema", "{}"});
    const std::uint16_t channels = 1 + random() % 5;
    for (int i = 0; i < channels; ++i)
      writer.add(Channel{schema, "/" + std::to_string(i), "json"});
    writer.flush();
    const auto mark = [&] {
      constexpr std::size_t kEnd = kRecordHead + 4 + kFooter + 8;
      ends.push_back(bytes.size() - kEnd);
      until.push_back(sent.size());
    };
    mark();
    Chunk chunk(100, 10);
    for (std::uint32_t tick = 0; tick < 60;) {
      for (const std::uint32_t until_tick = tick + 1 + random() % 20; tick < until_tick; ++tick) {
        std::string data(random() % 300, '\0');
        for (char& c : data)
          c = static_cast<char>(random());
        sent.push_back({static_cast<std::uint16_t>(1 + random() % channels), tick, tick * 5000000ULL, data});
        chunk.add(sent.back().channel, tick, tick * 5000000ULL, data);
      }
      writer.write(chunk);
      chunk.clear();
      mark();
    }
    if (finished) writer.finish();
  }
};

std::vector<Sent> received(Reader& reader) {
  std::vector<Sent> all;
  while (const auto message = reader.next())
    all.push_back({message->channel, message->sequence, message->log_time, std::string(message->data)});
  return all;
}

TEST(Mcap, WhatIsWrittenIsRead) {
  const Scratch scratch;
  for (std::uint64_t seed = 0; seed < 50; ++seed) {
    for (const bool finished : {true, false}) {
      const Sample sample(seed, finished);
      Reader reader(scratch.write("file.mcap", sample.bytes), "file");
      EXPECT_EQ(reader.finished(), finished);
      EXPECT_EQ(reader.profile(), "ros2");
      EXPECT_EQ(reader.metadata().at("m").at("key"), "value");
      EXPECT_EQ(reader.attachments().at("a").media_type, "text/plain");
      EXPECT_EQ(reader.schemas().begin()->second.text, "{}");
      EXPECT_EQ(received(reader), sample.sent);
      EXPECT_EQ(reader.left(), 0U);
    }
  }
}

TEST(Mcap, AFileThatEndsAnywhereHasAllChunksThatAreWhole) {
  const Scratch scratch;
  std::mt19937_64 random(1);
  long cut_within = 0;
  std::optional<Sample> made;
  for (int trial = 0; trial < 4000; ++trial) {
    if (trial % 200 == 0) made.emplace(trial / 200);
    const Sample& sample = *made;
    // At each end of a chunk, and anywhere.
    const auto place = static_cast<std::size_t>(trial % 200);
    const std::size_t size = place < sample.ends.size() ? sample.ends[place] : random() % sample.bytes.size();
    std::size_t whole = 0;
    for (std::size_t i = 0; i < sample.ends.size(); ++i) {
      if (sample.ends[i] <= size) whole = sample.until[i];
    }
    const std::string file = scratch.write("file.mcap", sample.bytes.substr(0, size));
    std::vector<Sent> got;
    try {
      Reader reader(file, "file");
      EXPECT_FALSE(reader.finished());
      got = received(reader);
      cut_within += reader.left() > 0 ? 1 : 0;
    } catch (const InputError& error) {
      EXPECT_THAT(error.what(), testing::AnyOf(HasSubstr("ends before its first message"), HasSubstr("not an MCAP")));
    }
    // A chunk may be whole although its indexes are not.
    ASSERT_GE(got.size(), whole) << trial;
    ASSERT_TRUE(std::equal(got.begin(), got.end(), sample.sent.begin())) << trial;
  }
  EXPECT_GT(cut_within, 1000);
}

TEST(Mcap, ADamagedFileIsReadUpToTheDamageOrRefused) {
  const Scratch scratch;
  std::mt19937_64 random(2);
  long refused = 0, read = 0;
  std::optional<Sample> made;
  for (int trial = 0; trial < 4000; ++trial) {
    if (trial % 200 == 0) made.emplace(trial / 200, trial % 400 == 0);
    std::string bytes = made->bytes;
    for (std::size_t changes = 1 + random() % 3; changes > 0; --changes)
      bytes[random() % bytes.size()] ^= static_cast<char>(1U << random() % 8);
    try {
      Reader reader(scratch.write("file.mcap", bytes), "file");
      for (const Sent& message : received(reader))
        EXPECT_LT(message.data.size(), 1U << 20U);
      ++read;
    } catch (const InputError& error) {
      ASSERT_THAT(error.what(), testing::AllOf(HasSubstr("file.mcap"), testing::Not(HasSubstr("\n"))));
      ++refused;
    }
  }
  EXPECT_GT(refused, 1000);
  EXPECT_GT(read, 1000);
}

TEST(Mcap, WhatIsNoSuchFileIsNamed) {
  const Scratch scratch;
  const auto complaint = [&](const std::string& text) -> std::string {
    try {
      const Reader reader(scratch.write("x.mcap", text), "recording");
    } catch (const InputError& error) {
      return error.what();
    }
    return "";
  };
  EXPECT_THAT(complaint("{\"baton_recording\":2}\n"),
              testing::AllOf(HasSubstr("is not an MCAP file"), HasSubstr("older")));
  EXPECT_THAT(complaint(""), HasSubstr("is not an MCAP file"));
  EXPECT_THAT(complaint(std::string(kMagic)), HasSubstr("ends before its first message"));
  EXPECT_THROW(Reader(scratch.path("none"), "recording"), InputError);
  EXPECT_THROW(Reader("/dev/zero", "recording"), InputError);
}

/// Takes bytes when it is let.
class Slow : public Output {
 public:
  Slow(std::atomic<bool>& open, std::string& bytes) : open_(&open), memory_(bytes) {}
  void write(std::string_view bytes, std::string_view end) override {
    open_->wait(false);
    memory_.write(bytes, end);
  }

 private:
  std::atomic<bool>* open_;
  Memory memory_;
};

TEST(WriterThread, ASlowOutputTakesNoTimeAndNoMemoryOfTheOneWhoFills) {
  std::string bytes;
  std::atomic<bool> open{false};
  Writer writer(std::make_unique<Slow>(open, bytes), "", "test");
  const std::uint16_t channel = writer.add(Channel{0, "/", "json"});
  int failures = 0;
  WriterThread thread(std::move(writer), {.chunks = 4, .on_failure = [&](const std::string&) { ++failures; }});
  std::uint32_t taken = 0;
  const auto fill = [&](std::uint32_t tick) {
    Chunk* chunk = thread.chunk();
    if (chunk == nullptr) return false;
    EXPECT_TRUE(chunk->empty());
    chunk->add(channel, tick, tick, "{}");
    thread.hand_over();
    ++taken;
    return true;
  };
  for (std::uint32_t tick = 0; tick < 100; ++tick)
    EXPECT_EQ(fill(tick), tick < 4);
  open = true;
  open.notify_all();
  for (std::uint32_t tick = 100; tick < 200; ++tick) {
    thread.wait();
    EXPECT_TRUE(fill(tick));
  }
  EXPECT_EQ(thread.close(), "");
  EXPECT_EQ(failures, 0);
  const Scratch scratch;
  Reader reader(scratch.write("file.mcap", bytes), "file");
  EXPECT_TRUE(reader.finished());
  EXPECT_EQ(received(reader).size(), taken);
}

/// Is full after some bytes.
class Full : public Output {
 public:
  Full(std::size_t room, std::string& bytes) : room_(room), memory_(bytes) {}
  void write(std::string_view bytes, std::string_view end) override {
    if (bytes.size() > room_) throw std::runtime_error("no room");
    room_ -= bytes.size();
    memory_.write(bytes, end);
  }

 private:
  std::size_t room_;
  Memory memory_;
};

TEST(WriterThread, AFullOutputIsToldOnceAndChunksAreStillTaken) {
  const Scratch scratch;
  for (const std::size_t room : {0, 10, 200, 1000, 5000, 20000}) {
    std::string bytes;
    Writer writer(std::make_unique<Full>(room, bytes), "", "test");
    const std::uint16_t channel = writer.add(Channel{0, "/", "json"});
    std::vector<std::string> failures;
    WriterThread thread(std::move(writer),
                        {.chunks = 4, .on_failure = [&](const std::string& why) { failures.push_back(why); }});
    std::mt19937_64 random(3);
    for (std::uint32_t tick = 0; tick < 200; ++tick) {
      thread.wait();
      thread.chunk()->add(channel, tick, tick, std::to_string(random()) + std::to_string(random()));
      thread.hand_over();
    }
    EXPECT_EQ(thread.close(), "no room");
    EXPECT_TRUE(thread.failed());
    EXPECT_EQ(failures, std::vector<std::string>{"no room"});
    if (room < 1000) continue;
    Reader reader(scratch.write("file.mcap", bytes), "file");
    EXPECT_FALSE(reader.finished());
    EXPECT_GT(received(reader).size(), room / 300);
    EXPECT_EQ(reader.left(), 0U);
  }
}

TEST(Cdr, NumbersAreAlignedToTheirSize) {
  std::string bytes;
  const std::array<float, 3> floats{1.0F, 2.0F, 3.0F};
  CdrWriter(bytes).number<std::uint8_t>(7).number<double>(1.5).text("abc").sequence<float>(floats).number<double>(2.5);
  EXPECT_EQ(bytes.size(), kCdrHead.size() + 8 + 8 + 8 + 16 + 8);
  CdrReader reader(bytes);
  EXPECT_EQ(reader.number<std::uint8_t>(), 7);
  EXPECT_EQ(reader.number<double>(), 1.5);
  EXPECT_EQ(reader.text(), "abc");
  EXPECT_EQ(reader.sequence<std::vector<float>>(), std::vector<float>(floats.begin(), floats.end()));
  EXPECT_EQ(reader.number<double>(), 2.5);
  EXPECT_THROW(static_cast<void>(reader.number<std::uint8_t>()), Malformed);
  for (std::size_t size = 0; size < bytes.size(); ++size) {
    EXPECT_THROW(
        {
          CdrReader cut(std::string_view(bytes).substr(0, size));
          static_cast<void>(cut.number<std::uint8_t>());
          static_cast<void>(cut.number<double>());
          static_cast<void>(cut.text());
          static_cast<void>(cut.sequence<std::vector<float>>());
          static_cast<void>(cut.number<double>());
        },
        Malformed);
  }
}

}  // namespace
}  // namespace baton::mcap
