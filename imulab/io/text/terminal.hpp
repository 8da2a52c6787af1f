// What only a terminal shows: progress of long work, and color.
#pragma once

#include <chrono>
#include <condition_variable>
#include <cstdint>
#include <mutex>
#include <string>
#include <thread>

namespace imulab {

enum class Color { red = 31, green = 32, yellow = 33 };

/// Whether standard output and standard error are terminals that show colors (the environment variable NO_COLOR is absent or empty).
bool output_has_color();
bool errors_have_color();
/// The text between the terminal's marks for bold and for the color.
std::string in_color(Color color, const std::string& text);

/// "LABEL: N %, S s left" on standard error, on one line that is removed at the end, from the first second on; nothing where that is no terminal. Any
/// thread may report.
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
  std::chrono::steady_clock::time_point begin_ = std::chrono::steady_clock::now();
  std::mutex mutex_;
};

/// "LABEL: N s" on standard error, on one line that is removed at the end, each second from the second one on, for work whose length is not known;
/// nothing where that is no terminal.
class Elapsed {
 public:
  explicit Elapsed(std::string label);
  Elapsed(const Elapsed&) = delete;
  Elapsed& operator=(const Elapsed&) = delete;
  ~Elapsed();

 private:
  std::mutex mutex_;
  std::condition_variable done_;
  bool finished_ = false, shown_ = false;
  std::thread thread_;
};

}  // namespace imulab
