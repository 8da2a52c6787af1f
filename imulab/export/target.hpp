// All export targets, in one table.
#pragma once

#include "imulab/export/input.hpp"

#include <string>
#include <string_view>
#include <vector>

namespace imulab {

/// A target. To add one: a source file of this folder that writes it, and its row in export_targets().
struct ExportTarget {
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
};

const std::vector<ExportTarget>& export_targets();

/// Throws Error that lists the targets.
const ExportTarget& export_target(std::string_view name, const std::vector<ExportTarget>& targets = export_targets());

}  // namespace imulab
