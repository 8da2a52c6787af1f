// The noise of a data sheet as people type it: "gyro.N = 0.0038 deg/s/sqrt(Hz), accel.N <= 0.14 mg/√Hz", or a TOML file with the same keys in
// [noise].
#pragma once

#include "imulab/noise/data_sheet.hpp"

#include <string>
#include <string_view>

namespace imulab {

/// Parses entries KEY = NUMBER UNIT, separated by commas, semicolons or lines. Keys: gyro.N, gyro.x.N (SheetQuantity), `rate`, `kind`, `name`. A word
/// "typical" or "maximum" after a unit, or <= in place of =, declares that value alone. Throws Error that names the keys or units that are possible.
DataSheet parse_data_sheet(std::string_view text);

/// The same of a file's table [noise]. Throws Error with file, line and key.
DataSheet parse_data_sheet_file(std::string_view toml, const std::string& file);

/// Parses a text that has a "=", or reads the file that it names.
DataSheet read_data_sheet(const std::string& text_or_file);

}  // namespace imulab
