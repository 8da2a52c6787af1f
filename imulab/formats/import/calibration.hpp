// Reads calibrations of other programs; the content of a file tells its format.
#pragma once

#include "imulab/model/calibration.hpp"

#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace imulab {

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
