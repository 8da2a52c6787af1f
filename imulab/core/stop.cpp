#include "imulab/stop.hpp"

#include "imulab/error.hpp"

#include <mutex>
#include <utility>

namespace imulab {

struct WorkScope::State {
  std::stop_token stop;
  std::function<void(double)> progress;
  State* outer;
  std::mutex mutex{};  // of what follows: parallel loops report, too
  double iterations = 0, told = 0;

  void tell(int usual) {
    const std::lock_guard lock(mutex);
    ++iterations;
    const double done = iterations / (iterations + usual);
    if (done <= told) return;
    told = done;
    progress(done);
  }
};

namespace {

thread_local void* innermost_scope = nullptr;

}  // namespace

WorkScope::WorkScope(std::stop_token stop, std::function<void(double)> progress)
    : state_(new State{std::move(stop), std::move(progress), static_cast<State*>(innermost_scope)}) {
  innermost_scope = state_;
}

WorkScope::~WorkScope() {
  innermost_scope = state_->outer;
  delete state_;
}

bool WorkScope::stop_requested() {
  for (const State* scope = static_cast<const State*>(innermost_scope); scope != nullptr; scope = scope->outer)
    if (scope->stop.stop_requested()) return true;
  return false;
}

void WorkScope::count(int usual) {
  State* scope = static_cast<State*>(innermost_scope);
  while (scope != nullptr && !scope->progress) scope = scope->outer;
  if (scope != nullptr) scope->tell(usual);
}

void stop_point() {
  if (WorkScope::stop_requested()) throw Stopped();
}

void count_iteration(int usual) {
  stop_point();
  WorkScope::count(usual);
}

ScopesOfThread::ScopesOfThread() : innermost_(innermost_scope) {}

void ScopesOfThread::call(const std::function<void(std::size_t)>& work, std::size_t k) const {
  struct Restore {
    void* before;
    ~Restore() { innermost_scope = before; }
  } const restore{std::exchange(innermost_scope, innermost_)};
  stop_point();
  work(k);
}

}  // namespace imulab
