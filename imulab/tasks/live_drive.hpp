// A calibration from a drive while its recording and the files of its aids grow.
#pragma once

#include "imulab/calibrate.hpp"
#include "imulab/estimate/method.hpp"
#include "imulab/recording.hpp"
#include "imulab/results/live_drive.hpp"
#include "imulab/tasks/growing_recording.hpp"

#include <optional>
#include <string>
#include <vector>

namespace imulab {

class LiveDrive {
 public:
  /// `session` has the one recording, declared by `options`, and aids. Throws Error where it has none.
  LiveDrive(const Method& method, Session session, RecordingOptions options, std::vector<Requirement> requirements);

  /// Takes new samples up to the next estimate; returns those that it did not take; none if there was no estimate. Throws MemoryError where so many
  /// came that they leave no memory.
  std::optional<Range> add(const Recording& piece, Range samples);
  /// The calibration of all samples and of what the aids' files have by now.
  void estimate() { estimate(true); }

  /// All requirements are met; without requirements never.
  bool reached() const { return view_.done; }
  const LiveDriveView& view() const { return view_; }
  const std::optional<CalibrationResult>& result() const { return result_; }
  const Recording& recording() const { return recording_; }

 private:
  void estimate(bool last);
  std::vector<Aid> aids_now(bool last) const;

  const Method* method_;
  Session session_;
  std::vector<Requirement> requirements_;
  RecordingOptions options_;
  GrowingRecording all_{10};
  Recording recording_;  ///< with the findings that need all of it
  std::optional<CalibrationResult> result_;
  LiveDriveView view_;
};

/// Why it is not done, with the manoeuvre that helps most. Empty: it is.
std::string shortcomings(const LiveDrive& drive);

}  // namespace imulab
