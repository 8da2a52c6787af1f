// A calibration by hand while its recording grows: the state so far, and what is missing. Shared by the command and the Python module.
#pragma once

#include "imulab/calibrate.hpp"
#include "imulab/recording.hpp"
#include "imulab/results/live.hpp"

#include <optional>
#include <string>
#include <vector>

namespace imulab {

/// The default requirements: a consumer's IMU reaches them in some twenty rests.
std::string usual_live_requirement(const std::string& accel_unit);

/// The limits of `text`, or the usual ones. Throws Error where they are no limits, Unsupported where gravity itself is less certain.
std::vector<Requirement> live_requirements(const std::optional<std::string>& text, const std::string& accel_unit, const Site& site);

class LiveProgress {
 public:
  /// `session` has the one recording, declared by `options`; its steps are ignored, since rests are found in the data.
  LiveProgress(Session session, RecordingOptions options, std::vector<Requirement> requirements, double rest_s);

  /// Takes new samples, up to the moment at which a new rest has become long enough; then the calibration is that of all samples so far. Returns
  /// the samples that it did not take; none if there was no such moment. Throws MemoryError where so many came that they leave no memory.
  std::optional<Range> add(const Recording& piece, Range samples);
  /// The calibration of all samples, at the end of the stream.
  void estimate();

  bool reached() const;
  const LiveView& view() const { return view_; }
  const std::optional<CalibrationResult>& result() const { return result_; }
  const Recording& recording() const { return recording_; }

 private:
  bool find_rest();
  std::optional<Eigen::Vector3d> up_at(const Range& rest) const;
  void describe(const std::vector<Range>& rests);

  Session session_;
  std::vector<Requirement> requirements_;
  RecordingOptions options_;
  Recording all_, recording_;  ///< as it arrived, and with the findings that need all of it
  std::vector<Range> rests_;
  std::optional<CalibrationResult> result_;
  LiveView view_;
  double looked_s_ = 0;        ///< when rests were last looked for
  std::size_t estimated_ = 0;  ///< samples of the last estimate at a rest
};

/// Why it is not done: the requirements that are not met, and the turn that helps most. Empty: it is done.
std::string shortcomings(const LiveProgress& progress);

}  // namespace imulab
