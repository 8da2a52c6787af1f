// Which procedure? The standard procedures, and what each reaches with the rig that one has and the grade of the unit, as `predict` foresees it
// (docs/start/choose.md).
#pragma once

#include "imulab/predict.hpp"
#include "imulab/session.hpp"

#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace imulab {

/// A procedure that `imulab procedure NAME` writes.
struct StandardProcedure {
  std::string_view name, needs, gives;
  Session (*make)();
};
std::span<const StandardProcedure> standard_procedures();

/// Seconds from the first step to the last, of all recordings one after the other.
double duration_of(const Session& procedure);

/// A line each: what it needs, how long it takes, the grade of its unit, what it gives.
std::string standard_procedures_text();

/// What moves the unit, and by which words it is asked for.
inline constexpr std::string_view rigs_that_one_has[] = {"hands", "one-axis", "two-axis", "three-axis", "chamber", "centrifuge"};
inline constexpr std::string_view sensors_that_one_has[] = {"mems", "fog", "rlg"};

/// The procedure for a rig and a kind of sensors.
struct ProcedureChoice {
  std::string_view rig, sensors;
  std::string command;      ///< that writes it: "imulab procedure handheld --grade tactical"
  std::string_view method;  ///< that calibrates it
  Session procedure;
};

/// Of all rigs and sensors, or of those named; a row each, the least equipment first.
std::vector<ProcedureChoice> procedure_choices(std::string_view rig = "", std::string_view sensors = "");

/// Without Monte Carlo, as `imulab predict --runs 0`.
Prediction predict(const ProcedureChoice& choice, const std::vector<Requirement>& requirements = {});

/// A row of the table in docs/start/choose.md.
std::string procedure_row(const ProcedureChoice& choice, const Prediction& prediction);

/// What it reaches, and which requirements it misses, for a terminal.
std::string procedure_text(const ProcedureChoice& choice, const Prediction& prediction, bool judged);

}  // namespace imulab
