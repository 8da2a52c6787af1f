// Calibrations for other programs, and from them: Kalibr, OpenVINS, VINS, ROS, PX4, ArduPilot, VectorNav, C for firmware, ...
// (docs/reference/export.md).
//
// Example:
//   const ExportTarget& kalibr = export_target("kalibr");
//   write_whole(kalibr.file, kalibr.text({calibration}));
//   for (const std::string& lost : kalibr.left_out({calibration})) std::puts(lost.c_str());
//   const Imported imported = import_calibration("kalibr_imu_chain.yaml");
//
// The text says of itself what it leaves out. Throws Error for a calibration that a target cannot hold, for noise that is missing, and for a file of
// no known format. Safe on any thread.
#pragma once

#include "imulab/calibration.hpp"
#include "imulab/noise.hpp"

#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace imulab {

/// Where a target has one number for three axes.
enum class AxisChoice { worst, mean };

struct ExportOptions {
  AxisChoice axes = AxisChoice::worst;
  bool variance_matched = false;     ///< vins: white noise that makes the covariance of its code right, instead of the standard deviation of a sample
  std::string imu_model = "kalibr";  ///< openvins: "kalibr" or "rpng"
  std::optional<double> rate_hz;     ///< of the stream; absent: that of the noise log
  int instance = 0;                  ///< px4, ardupilot: which of the autopilot's IMUs, from 0
  std::string prefix = "imulab";     ///< c-header: with which its names begin
  std::string topic{};               ///< kalibr, openvins: of the IMU; empty: that of the calibration's recording, else /imu0
};

struct ExportInput {
  const Calibration& calibration;
  const ImuNoise* noise = nullptr;  ///< null: not known
  ExportOptions options{};
};

/// A target. To add one: docs/reference/extending.md.
struct ExportTarget {
  /// Options that only some targets have, as bits.
  enum Takes : unsigned { noise = 1, variance_matched = 2, imu_model = 4, topic = 8, instance = 16 };

  std::string_view name;     ///< as `imulab export --to` names it
  std::string_view summary;  ///< for help: what it is for, in one line
  std::string_view file;     ///< its name where all targets are written
  /// The text of the file. Throws Error for a calibration that the target cannot hold, and where it needs noise and there is none.
  std::string (*text)(const ExportInput& input);
  /// The parts of this calibration that the text leaves out, and their size; empty: none.
  std::vector<std::string> (*left_out)(const ExportInput& input);
  /// Numbers that the target refuses or ignores; null: it takes all.
  std::vector<std::string> (*warnings)(const ExportInput& input) = nullptr;
  bool needs_noise = false;
  unsigned takes = 0;  ///< several `Takes`; `noise` with `axes` and `rate_hz`
};

const std::vector<ExportTarget>& export_targets();

/// Throws Error that lists the targets.
const ExportTarget& export_target(std::string_view name, const std::vector<ExportTarget>& targets = export_targets());

struct ImportOptions {
  std::optional<std::filesystem::path> gyro_file;  ///< for formats with one triad a file: the gyros', beside the accelerometers'
  int instance = 0;                                ///< of several IMUs in the file, from 0
  /// The readings' unit: "si", "count", or empty: as the file says, else SI, but counts where the scales are not near one.
  std::string raw;
};

struct Imported {
  std::string_view format;  ///< "Kalibr"
  /// Its uncertainties are not known, so `estimated` is empty. Body frame: that of the file, or the accelerometers' where the matrix allows it.
  Calibration calibration;
  std::vector<std::string> warnings;  ///< contents of the file that the calibration cannot hold, and facts that the file does not state
};

/// Throws Error with file and line (or field) for a file of no known format, and for one that is damaged.
Imported import_calibration(const std::filesystem::path& file, const ImportOptions& options = {});
/// Imports texts instead of files; `name` is the file's name in messages.
Imported import_calibration_text(std::string_view text, const std::string& name, const ImportOptions& options = {});

}  // namespace imulab
