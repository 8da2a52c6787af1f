// What a calibration's page and its certificate state alike, as text: conditions, tests, the model, and where the scales come from.
#pragma once

#include "imulab/report/calibration_page.hpp"

#include <array>
#include <string>
#include <string_view>
#include <vector>

namespace imulab::report {

// Of the site and the rigs; empty where nothing is known.
std::string gravity_text(const Site& site);  ///< "9.806200 m/s² (u = 1e-05 m/s²), declared"
std::string latitude_text(const Site& site);
std::string rigs_text(const Session& session);

std::string temperature_text(const TriadModel& model);
std::string frame_text(const Calibration& calibration);
/// The largest rate and force of the recordings; empty without them.
std::string ranges_text(const CalibrationReport& report);
/// The tests by their usual names.
std::string test_text(const Calibration& calibration, const CalibrationReport& report);
/// Counts the positions, and says how long each was held.
std::string positions_text(const Quality& quality);

/// Empty for a calibration of a log without a session: its name is that of the log's file.
std::string declared_name(const Calibration& calibration);
/// The range of the item's own thermal readings; empty without any.
std::string thermal_readings(const Calibration& calibration);

bool has_estimated(const Calibration& calibration, Term term, Triad triad);
/// HTML.
std::string model_equation(const Calibration& calibration);
/// One that imulab made: of others it is not known what they come from.
bool calibrated_here(const Calibration& calibration);

/// The first and the last day of the measurement, YYYY-MM-DD; empty where neither session nor stamps say it.
std::array<std::string, 2> measured_days(const Calibration& calibration);
/// The day on which the item was measured, as the session declares it, or the days of the stamps.
std::string measured_text(const Calibration& calibration);

/// A quantity of the calibration: what its scale comes from.
struct Origin {
  std::string_view quantity, name;
  std::string from;
  std::string_view unused;  ///< why a declared reference does not make it traceable; empty: it does
};
std::vector<Origin> origins_of(const CalibrationReport& report);

/// The origin's own reason why the reference does not count, or that its certificate is dated after the measurement; empty: it counts.
std::string why_unused(const Origin& origin, const Reference& reference, const Calibration& calibration);
/// HTML: number, date and statement of a reference's certificate, and why it is not used.
std::string certificate_text(const Reference& reference, std::string_view unused);
/// It claims no more than the session declares: nobody has checked it. `with`, `without`: names of quantities; `any`: there are references.
std::string traceability_text(const std::string& with, const std::string& without, bool any);

}  // namespace imulab::report
