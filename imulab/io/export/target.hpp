// What a calibration can be exported to, in one table.
#pragma once

#include "imulab/model/calibration.hpp"

#include <string>
#include <string_view>
#include <vector>

namespace imulab {

/// A target. To add one: a source file of this folder that writes it, and its row in export_targets().
struct ExportTarget {
  std::string_view name;     ///< as `imulab export --to` names it
  std::string_view summary;  ///< for help: what it is for, in one line
  /// The text of the file. Throws Error for a calibration that the target cannot hold.
  std::string (*text)(const Calibration& calibration);
  /// What of this calibration the text leaves out, and the consequence; empty: nothing.
  std::vector<std::string> (*left_out)(const Calibration& calibration);
};

const std::vector<ExportTarget>& export_targets();

/// Throws Error that lists the targets.
const ExportTarget& export_target(std::string_view name, const std::vector<ExportTarget>& targets = export_targets());

}  // namespace imulab
