#include "python/work.hpp"

#include <vector>

namespace imulab::python {
namespace {

std::mutex guard;
std::vector<std::thread> abandoned;

}  // namespace

void keep_until_exit(std::thread thread) {
  const std::lock_guard lock(guard);
  abandoned.push_back(std::move(thread));
}

void wait_for_abandoned() {
  const py::gil_scoped_release unlocked;
  const std::lock_guard lock(guard);
  for (std::thread& thread : abandoned) thread.join();
  abandoned.clear();
}

}  // namespace imulab::python
