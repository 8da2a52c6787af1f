// Long work beside the interpreter: without its lock, with its signals and a progress callback.
#pragma once

#include <atomic>
#include <chrono>
#include <condition_variable>
#include <exception>
#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <pybind11/pybind11.h>
#include <thread>
#include <utility>

namespace imulab::python {

namespace py = pybind11;

/// Thrown into work that nobody waits for any more, where it tells its progress.
struct Abandoned {};

/// Work that was interrupted and has not noticed yet; the interpreter waits for it at its end.
void keep_until_exit(std::thread thread);
void wait_for_abandoned();

/// Runs work(report) in a thread and returns its result; report(part) tells that a part from 0 to 1 is done, from any thread. Meanwhile the calling
/// thread answers signals and calls `progress` (a callable or None) with the part. An interrupt is raised at once: the work must therefore own all
/// that it uses.
template <class Work>
auto run(const py::object& progress, Work work) {
  using Result = decltype(work(std::function<void(double)>{}));
  struct State {
    std::mutex mutex;
    std::condition_variable changed;
    bool done = false;
    std::optional<Result> result;
    std::exception_ptr failure;
    std::atomic<double> part = 0;
    std::atomic<bool> abandoned = false;
  };
  const auto state = std::make_shared<State>();
  std::thread thread([state, work = std::move(work)]() mutable {
    try {
      state->result.emplace(work([state](double part) {
        if (state->abandoned) throw Abandoned{};
        state->part = part;
      }));
    } catch (...) {
      state->failure = std::current_exception();
    }
    const std::lock_guard lock(state->mutex);
    state->done = true;
    state->changed.notify_one();
  });
  double told = 0;
  for (bool done = false; !done;) {
    {
      const py::gil_scoped_release unlocked;
      std::unique_lock lock(state->mutex);
      done = state->changed.wait_for(lock, std::chrono::milliseconds(50), [&] { return state->done; });
    }
    const double part = done && !state->failure ? 1 : state->part.load();
    try {
      if (PyErr_CheckSignals() != 0) throw py::error_already_set();
      if (!progress.is_none() && part > told) progress(told = part);
    } catch (...) {
      state->abandoned = true;
      keep_until_exit(std::move(thread));
      throw;
    }
  }
  thread.join();
  if (state->failure) std::rethrow_exception(state->failure);
  return std::move(*state->result);
}

}  // namespace imulab::python
