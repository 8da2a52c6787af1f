// Any bytes as a file of settings or a result: what is accepted is written again, and that reads back as the same text.
#include "imulab/calibration.hpp"
#include "imulab/error.hpp"
#include "imulab/exchange.hpp"
#include "imulab/files.hpp"
#include "imulab/formats/noise/data_sheet.hpp"
#include "imulab/formats/session/mission.hpp"
#include "imulab/report/aided_page.hpp"
#include "imulab/report/calibration_page.hpp"
#include "imulab/report/comparison_page.hpp"
#include "imulab/report/extrinsics_page.hpp"
#include "imulab/report/navigation_page.hpp"
#include "imulab/report/noise_page.hpp"
#include "imulab/report/prediction_page.hpp"
#include "imulab/report/recording_page.hpp"
#include "imulab/results/summary.hpp"

#include "fuzz/fuzzed_file.hpp"
#include "fuzz/targets.hpp"
#include <cmath>
#include <optional>
#include <string>
#include <type_traits>

namespace imulab::fuzz {

namespace {

/// The result of `read`; nothing where it refuses.
template <class Read>
auto unless_refused(const Read& read) -> std::optional<decltype(read())> {
  try {
    return read();
  } catch (const Error&) {
    return std::nullopt;
  }
}

void expect_readable(const Calibration& c) {
  const auto text = unless_refused([&] { return calibration_text(c); });  // a coefficient that is not finite is not written
  if (text && calibration_text(parse_calibration(*text, "written")) != *text) finding("a calibration reads back as another");
}

std::string page_of(const Calibration& c) {
  CalibrationReport report;
  report.result.calibration = c;
  return calibration_page(report);
}
std::string page_of(const ComparisonSummary& s) { return comparison_page(s); }
std::string page_of(const ResultComparison& c) { return result_comparison_page(c); }
std::string page_of(const PredictionSummary& s) { return prediction_page({.procedure = "fuzzed", .summary = s}); }
std::string page_of(const PlanSummary& s) { return plan_page(s); }
std::string page_of(const BudgetSummary& s) { return budget_page({.mission = "fuzzed", .summary = s}); }
std::string page_of(const AidedSummary& s) { return aided_page(s.session, s.navigation, {}, {}); }
std::string page_of(const NavigationSummary& s) { return navigation_page({.sessions = s}); }
std::string page_of(const NoiseAnalysis& noise) { return noise_page(noise); }
std::string page_of(const NoiseBatch& noise) { return noise_page(noise); }
std::string page_of(const Extrinsics& e) { return extrinsics_page(e, {}); }
std::string page_of(const CompensationSummary& s) { return compensation_page(s); }

}  // namespace

void session(std::string_view bytes) {
  const auto read = unless_refused([&] { return parse_session(bytes, "fuzzed"); });
  if (!read) return;
  const std::string text = session_text(*read);
  if (session_text(parse_session(text, "fuzzed")) != text) finding("a session reads back as another");
  const std::string procedure = procedure_text(*read);
  parse_session(procedure, "fuzzed");
}

void mission(std::string_view bytes) {
  const FuzzedFile file(bytes);
  unless_refused([&] {
    const MissionFile read = read_mission(file.path());
    if (read.errors) read_error_sources(*read.errors, file.path());
    return true;
  });
}

void calibration(std::string_view bytes) {
  if (const auto read = unless_refused([&] { return parse_calibration(bytes, "fuzzed"); })) expect_readable(*read);
}

void imported(std::string_view bytes) {
  if (const auto read = unless_refused([&] { return import_calibration_text(bytes, "fuzzed"); }))
    parse_calibration(calibration_text(read->calibration), "fuzzed");
}

void result(std::string_view bytes) {
  unless_refused([&] { return std::visit([](const auto& saved) { return page_of(saved); }, parse_result(bytes, "fuzzed")); });
}

void noise(std::string_view bytes) {
  unless_refused([&] { return parse_noise(bytes, "fuzzed"); });
  unless_refused([&] { return data_sheet_noise(parse_data_sheet(bytes)); });
  unless_refused([&] { return data_sheet_noise(parse_data_sheet_file(bytes, "fuzzed")); });
}

void requirement(std::string_view bytes) {
  const auto read = unless_refused([&] { return parse_requirements(bytes); });
  if (!read) return;
  for (const Requirement& r : *read) {
    if (!(r.limit > 0) || !std::isfinite(r.limit)) finding("a limit that is none");
    const std::vector<Requirement> again = parse_requirements(to_string(r));
    if (again.size() != 1 || again[0].coefficients != r.coefficients || std::abs(again[0].limit / r.limit - 1) > 1e-5)  // six digits are written
      finding("a requirement reads back as another");
  }
}

}  // namespace imulab::fuzz
