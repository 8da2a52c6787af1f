// The progress of reading a file: readers advance it, and progress displays read it.
#pragma once

#include <atomic>
#include <cstdint>

namespace imulab {

struct ReadingCounts {
  std::atomic<std::uint64_t> all{0}, done{0};  ///< of the file that is being read, in bytes, rows or messages; all is 0 between files
  std::atomic<std::uint64_t> finished{0};      ///< of the files that were read
  std::atomic<double> begun_s{0};              ///< of the steady clock
};

/// From here to its end, what this thread begins to read is counted there.
class WatchedReading {
 public:
  explicit WatchedReading(ReadingCounts& counts);
  ~WatchedReading();
  WatchedReading(const WatchedReading&) = delete;
  WatchedReading& operator=(const WatchedReading&) = delete;

 private:
  ReadingCounts* before_;
};

/// One file, or one pass over it. Where nobody looks, and within another one of the same thread, it counts nothing.
class ReadingMeter {
 public:
  explicit ReadingMeter(std::uint64_t all);
  ~ReadingMeter();
  ReadingMeter(const ReadingMeter&) = delete;
  ReadingMeter& operator=(const ReadingMeter&) = delete;
  /// From any thread.
  void add(std::uint64_t more) const {
    if (counts_ != nullptr) counts_->done.fetch_add(more, std::memory_order_relaxed);
  }

 private:
  ReadingCounts* counts_;
};

}  // namespace imulab
