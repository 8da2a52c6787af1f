// Work that can be stopped, and says how far it is: calibrations, predictions, plans and budgets, from any thread.
//
// Example:
//   std::stop_source source;                             // source.request_stop() from another thread
//   const WorkScope scope(source.get_token());
//   const TurnPath path = plan_path(session, {});        // throws Stopped within a second
//
// The work inside asks at every iteration of a fit and before every call of a parallel loop, so the scope holds for all that its thread begins.
#pragma once

#include <cstddef>
#include <functional>
#include <stop_token>

namespace imulab {

/// While it exists, work of this thread, and of the threads that its parallel loops use, throws Stopped once the token is asked to stop, and reports
/// the fraction done, which never falls, from any of these threads. Scopes nest: the tokens of all count, the progress of the innermost that has one.
/// It has to end on the thread on which it began.
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

/// Throws Stopped where a scope around the call was asked to stop. A few nanoseconds.
void stop_point();

/// A stop point after an iteration of work whose number of iterations is not known in advance, `usual` of them. The fraction that is reported comes
/// closer to 1 with each, and never reaches it.
void count_iteration(int usual = 8);

/// Calls `work` in the scopes of another thread, which wait for it: for the calls of parallel loops.
class ScopesOfThread {
 public:
  ScopesOfThread();  // those of this thread
  void call(const std::function<void(std::size_t)>& work, std::size_t k) const;

 private:
  void* innermost_;
};

}  // namespace imulab
