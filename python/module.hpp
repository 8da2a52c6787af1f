// The parts of the module, one a source file, and what they share: long work beside the interpreter, answers, and options as keywords.
#pragma once

#include "imulab/calibrate.hpp"
#include "imulab/core/part_file.hpp"
#include "imulab/core/shared_work.hpp"
#include "imulab/error.hpp"
#include "imulab/parallel.hpp"
#include "imulab/recording.hpp"
#include "imulab/stop.hpp"
#include "imulab/tasks/calibrate.hpp"

#include "python/arrays.hpp"
#include <atomic>
#include <chrono>
#include <condition_variable>
#include <exception>
#include <functional>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <pybind11/pybind11.h>
#include <stop_token>
#include <string>
#include <thread>
#include <utility>
#include <vector>

namespace imulab::python {

/// Work that was interrupted and has not noticed yet; the interpreter waits for it at its end.
void keep_until_exit(std::thread thread);
void wait_for_abandoned();

/// Runs work(report) in a thread and returns its result; report(part) tells that a part from 0 to 1 is done, from any thread. Meanwhile the calling
/// thread answers signals and calls `progress` (a callable or None) with the part. An interrupt is raised at once, and the work is asked to stop,
/// which takes it about a second (stop.hpp): it must therefore own all that it uses.
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
    std::stop_source stop;
  };
  const auto state = std::make_shared<State>();
  std::thread thread([state, work = std::move(work)]() mutable {
    try {
      const WorkScope scope(state->stop.get_token());
      state->result.emplace(work([state](double part) {
        if (state->stop.stop_requested()) throw Stopped();
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
      state->stop.request_stop();
      keep_until_exit(std::move(thread));
      throw;
    }
  }
  thread.join();
  if (state->failure) std::rethrow_exception(state->failure);
  return std::move(*state->result);
}

/// A calibration, and what it was made from where that is known.
struct CalibrationObject {
  std::shared_ptr<const CalibrationResult> result;
  std::shared_ptr<const SessionRecordings> data;  ///< null for one from a file

  const Calibration& calibration() const { return result->calibration; }
};

/// The answer of a verb, and columns of it.
struct Outcome : Answer {
  std::map<std::string, py::array> arrays = {};
};

/// Sets a verb's options from keywords. Throws TypeError for a keyword that the verb does not have, one that is missing, and a value of another kind;
/// Error for one that is out of range.
void take_keywords(Verb& verb, const py::dict& given);

/// Words that name options of the command, with the keywords of Python: heading_sigma for --heading-sigma.
std::string in_keywords(const std::string& text);

template <class Options>
Options options_from(const py::dict& keywords) {
  Options o;
  Verb command("imulab", "");
  take_keywords(declare(command, o), keywords);
  if constexpr (requires { o.shared; }) o.shared.verb = nullptr;  // it ends here
  return o;
}

/// The part that a work with `--part` comes to, as the bytes of its file. One processor: there are as many such parts at once as an executor has
/// workers.
template <class Work>
py::bytes part_of(const Work& work) {
  return py::bytes(run(py::none(), [=](const auto&) -> std::string {
    const ThreadLimit one(1);
    try {
      work();
    } catch (const PartIsDone& done) {
      return done.part->bytes();
    }
    throw Error("there is nothing to divide; expected runs");
  }));
}

/// Parts in memory, for SharingOptions.
inline std::vector<PartReader::Source> parts_in_memory(const std::vector<std::string>& parts) {
  std::vector<PartReader::Source> out;
  for (const std::string& part : parts) out.push_back(PartReader::memory("part " + std::to_string(out.size() + 1), part));
  return out;
}

/// A triad's options from the keys that the Python side passes.
ReadingOptions reading_options(const py::dict& given, const std::string& triad);

void bind_recording(py::module_& module);
void bind_session(py::module_& module);
void bind_calibration(py::module_& module);
void bind_estimates(py::module_& module);
void bind_navigation(py::module_& module);
void bind_fleets(py::module_& module);
void bind_live(py::module_& module);

}  // namespace imulab::python
