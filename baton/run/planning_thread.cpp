#include "baton/run/planning_thread.hpp"

#include <pthread.h>
#include <sched.h>

#include <utility>

#include "baton/run/cpu_time.hpp"

namespace baton {
namespace {

/// In a process with real-time priority, planning keeps the lowest of these: ticks interrupt it, ordinary processes
/// do not. Otherwise it changes nothing.
void let_ticks_come_first() {
  int policy = 0;
  sched_param param{};
  if (pthread_getschedparam(pthread_self(), &policy, &param) != 0 || (policy != SCHED_FIFO && policy != SCHED_RR))
    return;
  param.sched_priority = sched_get_priority_min(policy);
  pthread_setschedparam(pthread_self(), policy, &param);
}

}  // namespace

PlanningThread::PlanningThread(const RobotModel& robot, const World& world, Modes modes)
    : strategy_(robot, world, modes), thread_([this] { run(); }) {}

PlanningThread::~PlanningThread() {
  // Let the answer under way finish, then end the thread.
  State expected = State::posted;
  while ((expected = state_.load()) == State::posted || !state_.compare_exchange_weak(expected, State::ending))
    state_.wait(State::posted);
  state_.notify_one();
  thread_.join();
}

void PlanningThread::post(Request request) {
  reply_.request = std::move(request);
  state_.store(State::posted, std::memory_order_release);
  state_.notify_one();
}

std::optional<Planning::Reply> PlanningThread::poll(long /*tick*/) {
  if (state_.load(std::memory_order_acquire) != State::answered) return std::nullopt;
  std::optional<Reply> answer = std::move(reply_);
  const std::exception_ptr error = std::exchange(error_, nullptr);
  state_.store(State::idle, std::memory_order_release);
  if (error) std::rethrow_exception(error);
  return answer;
}

void PlanningThread::reset() {
  state_.wait(State::posted);
  error_ = nullptr;
  state_.store(State::idle, std::memory_order_release);
}

void PlanningThread::run() {
  let_ticks_come_first();
  for (;;) {
    State state = state_.load(std::memory_order_acquire);
    while (state == State::idle || state == State::answered) {
      state_.wait(state);
      state = state_.load(std::memory_order_acquire);
    }
    if (state == State::ending) return;
    try {
      const double before = cpu_us();
      reply_.answer = strategy_.plan(reply_.request);
      reply_.plan_us = cpu_us() - before;
    } catch (...) {
      error_ = std::current_exception();
    }
    state_.store(State::answered, std::memory_order_release);
    state_.notify_all();
  }
}

}  // namespace baton
