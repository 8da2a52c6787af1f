#include "imulab/formats/text/reading_meter.hpp"

#include <chrono>

namespace imulab {

namespace {

thread_local ReadingCounts* watched = nullptr;

}  // namespace

WatchedReading::WatchedReading(ReadingCounts& counts) : before_(watched) { watched = &counts; }
WatchedReading::~WatchedReading() { watched = before_; }

ReadingMeter::ReadingMeter(std::uint64_t all) : counts_(watched != nullptr && watched->all == 0 && all > 0 ? watched : nullptr) {
  if (counts_ == nullptr) return;
  counts_->begun_s = std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count();
  counts_->done = 0;
  counts_->all = all;
}

ReadingMeter::~ReadingMeter() {
  if (counts_ == nullptr) return;
  counts_->finished += counts_->done;
  counts_->all = 0;
}

}  // namespace imulab
