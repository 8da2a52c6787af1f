// The aids of a simulated session: their records as files beside it.
#pragma once

#include "imulab/formats/text/json.hpp"
#include "imulab/session.hpp"
#include "imulab/simulate/simulate_aid.hpp"

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

namespace imulab {

/// Simulates the aids that have a record on a motion, and puts them into the session in place of the declared ones, each with its record and the name
/// of its file: gnss_1.csv, gnss_2.csv, wheels_1.csv. Returns them, in the order of the session's aids with a record.
std::vector<SimulatedAid> simulate_aids(Session& session, const std::vector<Aid>& declared, const motion::Trajectory& motion, std::uint64_t seed);

/// Writes the files; a comment in each says the lever arm and the delay that were drawn.
void write_aids(const std::filesystem::path& folder, const std::vector<SimulatedAid>& aids);

/// As the verbs' JSON has them: file, kind, rows.
std::vector<JsonValue> aids_json(const std::vector<SimulatedAid>& aids);
/// A line each, as the verbs print what they wrote: "  gnss_1.csv     3600 rows".
std::string aids_table(const std::vector<SimulatedAid>& aids);

}  // namespace imulab
