// Progress of long work on a terminal.
#pragma once

#include <cstdint>
#include <mutex>
#include <string>

namespace imulab {

/// "LABEL: N of TOTAL" on standard error, on one line that is removed at the end; nothing where that is no terminal. Any thread may report.
class Progress {
 public:
  Progress(std::string label, std::uint64_t total);
  Progress(const Progress&) = delete;
  Progress& operator=(const Progress&) = delete;
  ~Progress();
  void report(std::uint64_t done);

 private:
  std::string label_;
  std::uint64_t total_, shown_ = 0;
  bool terminal_;
  std::mutex mutex_;
};

}  // namespace imulab
