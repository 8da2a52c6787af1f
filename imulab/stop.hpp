// Stops calibrations, predictions, plans and budgets from any thread, and reports their progress.
//
// Example:
//   std::stop_source source;                             // source.request_stop() from another thread
//   const WorkScope scope(source.get_token());
//   const TurnPath path = plan_path(session, {});        // throws Stopped within a second
//
// The work checks for a request at every fit iteration and before every call of a parallel loop. A scope applies to all work that its thread starts.
#pragma once

#include <cstddef>
#include <functional>
#include <stop_token>

namespace imulab {

/// While this object exists, work on its thread and in the parallel loops of that thread throws Stopped after the token receives a request. It also
/// reports the fraction done, which never decreases, from any of these threads. Scopes nest: all tokens apply, but only the innermost progress
/// function. The scope must end on the thread on which it began.
class WorkScope {
 public:
  explicit WorkScope(std::stop_token stop, std::function<void(double)> progress = {});
  ~WorkScope();
  WorkScope(const WorkScope&) = delete;
  WorkScope& operator=(const WorkScope&) = delete;

 private:
  friend void stop_point();
  friend void count_iteration(int usual);
  static bool stop_requested();
  static void count(int usual);

  struct State;
  State* state_;
};

/// Throws Stopped if an enclosing scope received a stop request. Takes a few nanoseconds.
void stop_point();

/// Stop point after an iteration of work whose number of iterations is unknown; `usual` is the typical number. The reported fraction approaches 1
/// with each iteration, but does not reach it.
void count_iteration(int usual = 8);

/// Runs work for a waiting thread in the scopes of that thread: for calls of parallel loops.
class ScopesOfThread {
 public:
  ScopesOfThread();  // stores the scopes of this thread
  void call(const std::function<void(std::size_t)>& work, std::size_t k) const;

 private:
  void* innermost_;
};

}  // namespace imulab
