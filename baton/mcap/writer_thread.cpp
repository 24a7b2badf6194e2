#include "baton/mcap/writer_thread.hpp"

#include <pthread.h>

#include <csignal>
#include <exception>
#include <utility>

namespace baton::mcap {
namespace {

constexpr std::size_t kEnding = std::size_t{1} << (8 * sizeof(std::size_t) - 1);

/// Lets writing fail with an error where it would end the process: a file that may not grow any further, a pipe whose
/// reader is gone. Interrupts are for other threads.
void block_signals() {
  sigset_t all;
  sigfillset(&all);
  pthread_sigmask(SIG_BLOCK, &all, nullptr);
}

}  // namespace

WriterThread::WriterThread(Writer writer, Parameters parameters)
    : writer_(std::move(writer)), parameters_(std::move(parameters)) {
  ring_.assign(parameters_.chunks, Chunk(0, 0));
  for (Chunk& chunk : ring_)
    chunk = Chunk(parameters_.bytes, parameters_.messages);
  thread_ = std::thread([this] { run(); });
}

WriterThread::~WriterThread() {
  close();
}

Chunk* WriterThread::chunk() {
  const std::size_t next = handed_over_.load(std::memory_order_relaxed);
  return next - written_.load(std::memory_order_acquire) < ring_.size() ? &ring_[next % ring_.size()] : nullptr;
}

void WriterThread::wait() {
  const std::size_t next = handed_over_.load(std::memory_order_relaxed);
  for (std::size_t written = 0; next - (written = written_.load(std::memory_order_acquire)) >= ring_.size();)
    written_.wait(written, std::memory_order_acquire);
}

void WriterThread::hand_over() {
  handed_over_.fetch_add(1, std::memory_order_release);
  handed_over_.notify_one();
}

std::string WriterThread::close() {
  if (thread_.joinable()) {
    handed_over_.fetch_add(kEnding, std::memory_order_release);
    handed_over_.notify_one();
    thread_.join();
  }
  return why_;
}

void WriterThread::attempt(const std::function<void()>& action) {
  if (failed()) return;
  try {
    action();
  } catch (const std::exception& error) {
    why_ = error.what();
    failed_.store(true, std::memory_order_release);
    if (parameters_.on_failure) parameters_.on_failure(why_);
  }
}

void WriterThread::run() {
  block_signals();
  attempt([this] { writer_.flush(); });
  for (std::size_t written = 0;;) {
    const std::size_t until = handed_over_.load(std::memory_order_acquire);
    if ((until & ~kEnding) == written) {
      if (parameters_.sync && written > 0) attempt([this] { writer_.sync(); });
      if ((until & kEnding) != 0) break;
      handed_over_.wait(until, std::memory_order_acquire);
      continue;
    }
    Chunk& chunk = ring_[written % ring_.size()];
    if (!chunk.empty()) attempt([&] { writer_.write(chunk); });
    chunk.clear();
    written_.store(++written, std::memory_order_release);
    written_.notify_one();
  }
  attempt([this] {
    writer_.finish();
    writer_.sync();
  });
}

}  // namespace baton::mcap
