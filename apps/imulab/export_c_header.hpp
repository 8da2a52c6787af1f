// What `imulab export --to c-header` takes beside the calibration.
#pragma once

#include "apps/imulab/command.hpp"
#include "imulab/export/c_header.hpp"

#include <optional>
#include <string>
#include <vector>

namespace imulab::command {

struct CHeaderArguments {
  std::optional<std::string> accel_unit, gyro_unit;
  std::optional<double> accel_counts_per_unit, gyro_counts_per_unit, accel_range, gyro_range;
  bool body_axes = false, fixed_point = false, q15 = false;
  std::optional<std::string> prefix;

  bool given() const;
};

void add_c_header_options(Verb& verb, CHeaderArguments& arguments);

/// With what the calibration says of its recording where the arguments are silent. Throws Error where they are unusable.
CHeaderOptions c_header_options(const CHeaderArguments& arguments, const Calibration& calibration);

/// What is taken of readings that neither the options nor the calibration describe, and are not counts.
std::vector<std::string> assumed_readings(const CHeaderOptions& options, const Calibration& calibration);

}  // namespace imulab::command
