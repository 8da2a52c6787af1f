// The verb export on values: its options, and the file of one target with what it loses.
#pragma once

#include "imulab/exchange.hpp"
#include "imulab/tasks/verb.hpp"

#include <functional>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace imulab {

/// Options of c-header. Where they are silent, the calibration's description of its recording holds.
struct CHeaderArguments {
  std::optional<std::string> accel_unit, gyro_unit, prefix;
  std::optional<double> accel_counts_per_unit, gyro_counts_per_unit, accel_range, gyro_range;
  bool body_axes = false, fixed_point = false, q15 = false;
};

struct ExportVerbOptions {
  /// An option that only some targets have; its row has to stay.
  struct OfTargets {
    const VerbOption* option;
    std::vector<std::string_view> targets;
    const std::string& name() const { return option->flags.back(); }
  };

  std::string calibration, target, output = "-", noise, three_axes = "worst";
  bool allow_undetermined = false, force = false, json = false;
  ExportOptions choices;
  CHeaderArguments c_header;
  std::vector<OfTargets> of_targets;

  bool is_of_all() const { return target == "all"; }
  /// With the axes as they are named.
  ExportOptions options() const;
  bool given(std::string_view name) const;
};
/// The verb `export`, which sets these.
Verb& declare(Verb& command, ExportVerbOptions& o);

/// Throws Error for options that the target does not have.
void expect_options_of_target(const ExportVerbOptions& o);

struct ExportedText {
  std::string text;
  std::vector<std::string> left_out;  ///< the parts of the calibration that it does not hold, and their size
  std::vector<std::string> warnings;  ///< numbers that the target refuses or ignores
  std::vector<std::string> assumed;   ///< facts about readings that neither the options nor the calibration state
};

/// `sha256`: of the calibration's file, for the head of c-header. Throws Error for what the target cannot hold, and for unusable options.
ExportedText exported_text(const ExportTarget& target, const ExportInput& input, const ExportVerbOptions& o, const std::string& sha256 = "");

}  // namespace imulab
