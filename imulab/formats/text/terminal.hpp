// Output for terminals alone: progress of long work, and color.
#pragma once

#include "imulab/formats/text/reading_meter.hpp"

#include <condition_variable>
#include <mutex>
#include <optional>
#include <string>
#include <thread>

namespace imulab {

enum class Color { red = 31, green = 32, yellow = 33 };

/// True if standard output, or standard error, is a terminal that shows colors (the environment variable NO_COLOR is absent or empty).
bool output_has_color();
bool errors_have_color();
/// The text between the terminal's marks for bold and for the color.
std::string in_color(Color color, const std::string& text);

/// Long work on a terminal: "LABEL: N %, S s left" where parts of it are reported; "reading: N %, S s left" while this thread reads a file; else
/// "LABEL: S s"; on a line of standard error that comes after the first second and is removed at the end. Nothing where that is no terminal. Any
/// thread may report.
class Progress {
 public:
  explicit Progress(std::string label, double total = 1);
  Progress(const Progress&) = delete;
  Progress& operator=(const Progress&) = delete;
  ~Progress();
  void report(double done);

 private:
  void watch();
  std::string line(double elapsed_s) const;
  void draw(double elapsed_s) const;

  std::string label_;
  double total_, done_ = 0;
  bool finished_ = false;
  std::optional<double> begin_s_;  ///< where there are no threads
  double drawn_s_ = 0;
  ReadingCounts reading_;
  WatchedReading watched_{reading_};
  std::mutex mutex_;
  std::condition_variable wake_;
  std::thread thread_;
};

}  // namespace imulab
