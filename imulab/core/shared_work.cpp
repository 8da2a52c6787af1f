#include "imulab/core/shared_work.hpp"

#include "imulab/core/checkpoint_file.hpp"
#include "imulab/core/parallel.hpp"
#include "imulab/core/part_file.hpp"
#include "imulab/error.hpp"
#include "imulab/parallel.hpp"
#include "imulab/version.hpp"

#include <fmt/format.h>

#include <atomic>
#include <cstring>
#include <map>
#include <mutex>
#include <optional>
#include <sstream>

namespace imulab {

namespace {

/// Results of some blocks on their way to `take`, in order.
class InOrder {
 public:
  InOrder(BlockRange range, std::function<void(std::size_t, const std::string&)> take)
      : range_(range), next_(range.begin), have_(range.size()), take_(std::move(take)) {}

  void add(std::size_t block, std::string result) {
    const std::lock_guard lock(one_);
    if (block < range_.begin || block >= range_.end || have_[block - range_.begin]) return;
    have_[block - range_.begin] = true;
    waiting_.emplace(block, std::move(result));
    for (auto next = waiting_.find(next_); next != waiting_.end(); next = waiting_.find(next_)) {
      next_ = range_.end;  // if `take` throws, no other thread's block is taken after it
      take_(next->first, next->second);
      next_ = next->first + 1;
      waiting_.erase(next);
    }
  }
  bool has(std::size_t block) {
    const std::lock_guard lock(one_);
    return have_[block - range_.begin];
  }

 private:
  BlockRange range_;
  std::size_t next_;
  std::mutex one_;
  std::vector<bool> have_;
  std::function<void(std::size_t, const std::string&)> take_;
  std::map<std::size_t, std::string> waiting_;
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

/// Does the blocks of a range, but for those that the checkpoint has.
void do_blocks(const SharedWork& work, BlockRange range, const Sharing* sharing, std::function<void(std::size_t, const std::string&)> take) {
  InOrder results(range, std::move(take));
  std::optional<CheckpointFile> kept;
  if (sharing != nullptr && !sharing->checkpoint.empty())
    kept.emplace(sharing->part ? sharing->checkpoint / sharing->part->name() : sharing->checkpoint, sharing->identity,
                 [&](std::size_t block, std::string result) { results.add(block, std::move(result)); });
  by_turns(range.size(), [&](std::size_t k) {
    const std::size_t block = range.begin + k;
    if (results.has(block)) return;
    std::string result = work.work(block);
    if (kept) kept->append(block, result);
    results.add(block, std::move(result));
  });
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

std::string differing_field(const std::string& identity, const std::string& other) {
  std::istringstream one(identity), two(other);
  for (std::string line, there; std::getline(one, line);)
    if (!std::getline(two, there) || line != there) return line.substr(0, line.find('='));
  return "identity";
}

void for_each(const SharedWork& work, const Sharing* sharing) {
  const auto take = [&](std::size_t block, const std::string& result) {
    work.take(block, result);
    if (work.progress) work.progress(block + 1);
  };
  if (sharing != nullptr && sharing->joined && sharing->joined->has_more()) return sharing->joined->read(sharing->identity, work.count, take);
  if (sharing == nullptr || !sharing->part) return do_blocks(work, {0, work.count}, sharing, take);
  PartWriter& part = *sharing->part;
  const BlockRange range = part.begin_work(sharing->identity, work.count);
  do_blocks(work, range, sharing, [&](std::size_t block, const std::string& result) {
    part.add(result);
    if (work.progress) work.progress(work.count * (block + 1 - range.begin) / range.size());
  });
  part.end_work();
  throw PartIsDone{sharing->part};
}

std::string bytes_of(const double* numbers, std::size_t count) { return {reinterpret_cast<const char*>(numbers), count * sizeof(double)}; }

void read_numbers(const std::string& bytes, double* numbers, std::size_t count) {
  if (bytes.size() != count * sizeof(double))
    throw Error(
        fmt::format("a result that was kept has {} bytes; expected {}: another version of imulab wrote it", bytes.size(), count * sizeof(double)));
  if (count > 0) std::memcpy(numbers, bytes.data(), bytes.size());
}

}  // namespace imulab
