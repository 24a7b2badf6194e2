/// Writes chunks on a thread of its own, so that whoever fills them never waits for compression or disk.
#pragma once

#include <atomic>
#include <functional>
#include <string>
#include <thread>
#include <vector>

#include "baton/mcap/writer.hpp"

namespace baton::mcap {

/// One thread fills chunks, another writes them: they pass them on through a ring of fixed size, without a lock.
class WriterThread {
 public:
  struct Parameters {
    std::size_t chunks = 128;                              ///< in the ring
    std::size_t bytes = 1U << 16U;                         ///< for which a chunk has memory from the beginning
    std::size_t messages = 256;                            ///< the same
    bool sync = true;                                      ///< sync the output whenever all chunks are written
    std::function<void(const std::string&)> on_failure{};  ///< called on the writing thread, at most once, with why
  };

  WriterThread(Writer writer, Parameters parameters);
  /// Finishes the file, if `close` was not called.
  ~WriterThread();
  WriterThread(const WriterThread&) = delete;
  WriterThread& operator=(const WriterThread&) = delete;

  /// The chunk to fill, empty at first, until `hand_over`. Null: all are waiting to be written. Returns at once.
  [[nodiscard]] Chunk* chunk();
  /// Waits until there is one.
  void wait();
  /// Has the chunk written. Requires a `chunk()`.
  void hand_over();
  /// Has all that was handed over written, and finishes the file.
  /// @returns why that failed; "": it did not
  std::string close();

  /// Whether something could not be written. Chunks are still taken then, but for nothing.
  [[nodiscard]] bool failed() const { return failed_.load(std::memory_order_acquire); }

 private:
  void run();
  /// Does something to the file, unless that failed before.
  void attempt(const std::function<void()>& action);

  Writer writer_;
  Parameters parameters_;
  std::vector<Chunk> ring_;
  std::atomic<std::size_t> handed_over_{0};  ///< chunks so far; `kEnding` is added to it at the end
  std::atomic<std::size_t> written_{0};      ///< chunks so far
  std::atomic<bool> failed_{false};
  std::string why_;  ///< of the writing thread, until that has ended
  std::thread thread_;
};

}  // namespace baton::mcap
