// The readings that an exported header takes, and how they become those of the model.
#pragma once

#include "imulab/export/c_header.hpp"
#include "imulab/model/coefficient.hpp"

#include <array>
#include <string>

namespace imulab::firmware {

struct Input {
  RecordedAs as;
  Triad triad;
  double factor = 1;           ///< from a reading to the model's raw reading, but for the sign
  std::array<int, 3> column;   ///< the reading along each body axis
  std::array<double, 3> sign;  ///< and its sign
  std::string parameter;       ///< "accel_deg_per_s"
  std::string unit;            ///< for people: "g", "counts, 4096 to one g"
  bool counts = false;         ///< integers, as a converter gives them
  const char* triad_name() const { return triad == Triad::accel ? "accel" : "gyro"; }
  const char* sensors() const { return triad == Triad::accel ? "accelerometers" : "gyros"; }
};

/// Throws Error where the given or recorded readings do not fit the model.
Input input_of(const Calibration& calibration, const CHeaderOptions& options, Triad triad);

}  // namespace imulab::firmware
