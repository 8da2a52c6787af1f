// Exports calibrations to other programs and imports theirs: Kalibr, OpenVINS, VINS, ROS, PX4, ArduPilot, VectorNav, C for firmware, ...
// (docs/reference/export.md).
//
// Example:
//   const ExportTarget& kalibr = export_target("kalibr");
//   write_whole(kalibr.file, kalibr.text({calibration}));
//   for (const std::string& lost : kalibr.left_out({calibration})) std::puts(lost.c_str());
//   const Imported imported = import_calibration("kalibr_imu_chain.yaml");
//
// The exported text lists what it leaves out. Throws Error if a target cannot represent the calibration, noise is missing, or a file has an unknown
// format. Safe on any thread.
#pragma once

#include "imulab/calibration.hpp"
#include "imulab/noise.hpp"

#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace imulab {

/// The value that represents three axes if a target has only one number.
enum class AxisChoice { worst, mean };

struct ExportOptions {
  AxisChoice axes = AxisChoice::worst;
  /// vins: exports the white noise that makes the covariance in its code correct, not the standard deviation of a sample.
  bool variance_matched = false;
  bool bound = false;                ///< exports N and K of the noise's bound
  std::optional<double> inflate{};   ///< factor of noise that is not a bound
  std::string imu_model = "kalibr";  ///< openvins: "kalibr" or "rpng"
  std::optional<double> rate_hz;     ///< sampling rate [Hz] of the data stream; absent: rate of the noise log
  int instance = 0;                  ///< px4, ardupilot: index of the autopilot's IMU, from 0
  std::string prefix = "imulab";     ///< c-header: prefix of all names
  std::string topic{};               ///< kalibr, openvins: IMU topic; empty: the topic of the calibration's recording, else /imu0
};

struct ExportInput {
  const Calibration& calibration;
  const ImuNoise* noise = nullptr;  ///< null: unknown
  ExportOptions options{};
};

/// An export target. docs/reference/extending.md explains how to add one.
struct ExportTarget {
  /// Options that only some targets use, as bits.
  enum Takes : unsigned { noise = 1, variance_matched = 2, imu_model = 4, topic = 8, instance = 16, bound = 32 };

  std::string_view name;     ///< name in `imulab export --to`
  std::string_view summary;  ///< purpose in one line, for help
  std::string_view file;     ///< file name if all targets are written
  /// Returns the text of the file. Throws Error if the target cannot represent the calibration or lacks the noise it needs.
  std::string (*text)(const ExportInput& input);
  /// Lists the parts of the calibration that the text leaves out, and their size; empty if it is complete.
  std::vector<std::string> (*left_out)(const ExportInput& input);
  /// Lists numbers that the target refuses or ignores; null if it accepts all.
  std::vector<std::string> (*warnings)(const ExportInput& input) = nullptr;
  bool needs_noise = false;
  unsigned takes = 0;  ///< combination of `Takes`; `noise` includes `axes` and `rate_hz`; `bound`: requires noise with bounds
};

const std::vector<ExportTarget>& export_targets();  ///< returns all targets

/// Returns the target with this `name`. Throws an Error that lists the `targets` if it is unknown.
const ExportTarget& export_target(std::string_view name, const std::vector<ExportTarget>& targets = export_targets());

struct ImportOptions {
  std::optional<std::filesystem::path> gyro_file;  ///< for formats with one triad per file: the gyro file, in addition to the accelerometer file
  int instance = 0;                                ///< index of the IMU in the file, from 0
  /// Unit of the readings: "si", "count", or empty: as in the file, else SI, or counts if the scale factors are far from one.
  std::string raw;
};

struct Imported {
  std::string_view format;  ///< "Kalibr"
  /// `estimated` is empty because uncertainties are unknown. The body frame is the file's, or the accelerometers' if the matrix allows it.
  Calibration calibration;
  std::vector<std::string> warnings;  ///< parts of the file that the calibration cannot represent, and information that the file lacks
};

/// Imports a calibration file. Throws Error with file and line (or field) if the format is unknown or the file is damaged.
Imported import_calibration(const std::filesystem::path& file, const ImportOptions& options = {});
/// Imports a text instead of a file; `name` is the file name in messages.
Imported import_calibration_text(std::string_view text, const std::string& name, const ImportOptions& options = {});

}  // namespace imulab
