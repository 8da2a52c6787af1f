// The user's declarations for a recording, which replace what the data show.
#pragma once

#include "imulab/inspection/inspection.hpp"
#include "imulab/inspection/names.hpp"
#include "imulab/inspection/time.hpp"

#include <cstddef>
#include <optional>
#include <string>

namespace imulab::inspection {

struct DeclaredColumns {
  std::optional<SignalTriad> gyro, accel;
};

/// A column as messages name it and as declarations take it: "gx", "column 3", or "Gyroscope.csv:x" where several files have an x.
std::string column_name(const SignalTable& table, std::size_t i);
/// The three columns as --set takes them: by number where a shell or a list would divide a name.
std::string declared_as(const SignalTable& table, const SignalTriad& triad);
/// Throws Error for a key that there is not.
void check_declarations(const Declarations& declared);
/// Three names or numbers, divided by commas or blanks. Throws Error for a column that is not there.
DeclaredColumns declared_columns(const SignalTable& table, const Declarations& declared);
/// The clock with what is declared of it. Throws Error for a column that is not there and for a unit that is none.
TimeGuess declared_time(const SignalTable& table, const Declarations& declared, TimeGuess guess);
/// The unit, output and axes of a triad, by its name.
void declare_unit(const Declarations& declared, const std::string& triad, UnitGuess& guess);
/// Body axes as "+x,+y,-z"; nothing where none are declared.
std::optional<std::array<BodyAxis, 3>> declared_axes(const Declarations& declared, const std::string& triad);

}  // namespace imulab::inspection
