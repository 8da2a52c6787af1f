// The common form of all targets: numbers, matrices, the comment at the head of a file.
#pragma once

#include "imulab/exchange.hpp"

#include <string>
#include <string_view>
#include <vector>

namespace imulab::export_io {

/// The shortest text that reads back to the same double, always with a point: YAML 1.1 takes "1e-05" for a text, "1.0e-05" for a number.
std::string exact_number(double value);
/// The shortest text of a float likewise, for programs that keep their parameters in single precision. Throws Error for a number that a float cannot
/// hold.
std::string float_text(double value);

/// "[a, b, c]", and three such rows on lines of their own after "KEY:", as YAML.
std::string row_text(const Vector3d& row);
std::string matrix_text(std::string_view indent, std::string_view key, const Matrix3d& m);

/// The IMU's topic as YAML, quoted where it has to be: the chosen one, that of the calibration's recording, or "/imu0".
std::string topic_text(const ExportInput& input);

/// Text from a calibration for a comment: one line of printable ASCII, at most 120 characters, so that no name ends a comment or opens a line.
std::string plain(std::string_view text);

/// The beginning of a comment: `Calibration of "unit", method handheld, 2026-11-20T12:00:00Z, ` with what the calibration says; `clean` makes its
/// texts harmless.
std::string calibration_of_text(const Calibration& calibration, std::string (*clean)(std::string_view) = plain);

/// The coefficients that the data did not determine: they have starting values.
std::vector<std::string> not_determined(const Calibration& calibration);

/// Lines "# ...": whose calibration for which program, then `facts` (signs, what the file holds), what the data did not determine, and what is lost.
std::string comment_head(const ExportInput& input, std::string_view program, const std::vector<std::string>& facts,
                         const std::vector<std::string>& lost);
/// Such a head with another mark than # at the begin of each line.
std::string in_comments(std::string_view mark, std::string_view head);

}  // namespace imulab::export_io
