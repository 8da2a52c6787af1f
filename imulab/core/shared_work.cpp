#include "imulab/core/shared_work.hpp"

#include "imulab/core/build.hpp"
#include "imulab/core/checkpoint_folder.hpp"
#include "imulab/core/error.hpp"
#include "imulab/core/parallel.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <cstdlib>
#include <cstring>
#include <map>
#include <mutex>
#include <optional>
#include <thread>

namespace imulab {

namespace {

/// Results on their way to `take`, in the order of the parts.
class InOrder {
 public:
  explicit InOrder(const SharedWork& work) : work_(work), have_(work.count) {}

  void add(std::size_t part, std::string result) {
    const std::lock_guard lock(one_);
    if (part >= have_.size() || have_[part]) return;
    have_[part] = true;
    waiting_.emplace(part, std::move(result));
    for (auto next = waiting_.find(taken_); next != waiting_.end(); next = waiting_.find(taken_)) {
      work_.take(taken_, next->second);
      waiting_.erase(next);
      ++taken_;
      if (work_.progress) work_.progress(taken_);
    }
  }
  bool has(std::size_t part) {
    const std::lock_guard lock(one_);
    return have_[part];
  }
  bool complete() {
    const std::lock_guard lock(one_);
    return taken_ == have_.size();
  }

 private:
  const SharedWork& work_;
  std::mutex one_;
  std::vector<bool> have_;
  std::map<std::size_t, std::string> waiting_;
  std::size_t taken_ = 0;
};

/// Calls `one` for 0 ... count - 1, the next one whenever a thread is free. Parallel loops inside do not begin another one in the middle.
void by_turns(std::size_t count, const std::function<void(std::size_t)>& one) {
  std::atomic<std::size_t> next = 0;
  std::atomic<bool> failed = false;
  parallel_for(parallel_threads(), [&](std::size_t) {
    try {
      for (std::size_t k = next++; k < count && !failed; k = next++) isolate_parallel([&] { one(k); });
    } catch (...) {
      failed = true;
      throw;
    }
  });
}

void share(const SharedWork& work, const Checkpoint& checkpoint) {
  InOrder results(work);
  const auto add = [&](std::size_t part, std::string result) { results.add(part, std::move(result)); };
  for (const auto& other : checkpoint.merged) CheckpointFolder::read(other, checkpoint.identity, add);
  CheckpointFolder folder(checkpoint.folder, checkpoint.identity);
  folder.read_new(add);
  constexpr std::size_t most_claims = 10000;  // files of a folder
  const std::size_t size = std::max<std::size_t>(1, (work.count + most_claims - 1) / most_claims), chunks = (work.count + size - 1) / size;
  // First what nobody has begun; then what somebody has begun and not finished, again and again until it is there.
  for (int round = 0; !results.complete(); ++round) {
    std::atomic<bool> idle = true;
    by_turns(chunks, [&](std::size_t chunk) {
      const std::size_t begin = chunk * size, end = std::min(work.count, begin + size);
      std::size_t part = begin;
      while (part < end && results.has(part)) ++part;
      if (part == end || !folder.claim(chunk, round)) return;
      idle = false;
      for (; part < end; ++part) {
        if (results.has(part)) continue;
        std::string result = work.work(part);
        folder.append(part, result);
        results.add(part, std::move(result));
      }
      folder.read_new(add);
    });
    folder.read_new(add);
    if (idle && !results.complete()) std::this_thread::sleep_for(std::chrono::milliseconds(50));
  }
}

}  // namespace

std::string work_identity(std::string_view work, const std::vector<IdentityField>& fields) {
  std::string text = fmt::format("work={}\nversion={}", work, build().version);
  for (const auto& [name, value] : fields) {
    text += fmt::format("\n{}=", name);
    for (const char c : value) {
      if (c == '\n' || c == '\\') text += '\\';
      text += c == '\n' ? 'n' : c;
    }
  }
  return text;
}

void for_each(const SharedWork& work, const Checkpoint* checkpoint) {
  if (checkpoint != nullptr) return share(work, *checkpoint);
  InOrder results(work);
  by_turns(work.count, [&](std::size_t part) { results.add(part, work.work(part)); });
}

bool leads_processes() {
  for (const char* name : {"OMPI_COMM_WORLD_RANK", "PMIX_RANK", "PMI_RANK", "SLURM_PROCID"})
    if (const char* rank = std::getenv(name)) return std::atoi(rank) == 0;
  return true;
}

bool in_job_array() { return std::getenv("SLURM_ARRAY_JOB_ID") != nullptr || std::getenv("SLURM_ARRAY_TASK_ID") != nullptr; }

std::string bytes_of(const double* numbers, std::size_t count) { return {reinterpret_cast<const char*>(numbers), count * sizeof(double)}; }

void read_numbers(const std::string& bytes, double* numbers, std::size_t count) {
  if (bytes.size() != count * sizeof(double))
    throw Error(fmt::format("a result in the checkpoint has {} bytes; expected {}: another version of imulab wrote it", bytes.size(),
                            count * sizeof(double)));
  if (count > 0) std::memcpy(numbers, bytes.data(), bytes.size());
}

}  // namespace imulab
