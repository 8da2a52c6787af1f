#include "imulab/report/imus_page.hpp"

#include "imulab/coefficient.hpp"
#include "imulab/report/html.hpp"
#include "imulab/report/page.hpp"

#include <fmt/format.h>

#include <algorithm>

namespace imulab {

namespace report {
namespace {

PageVerdict verdict_of_all(const std::vector<NamedCalibration>& imus, const std::vector<std::string>& missing) {
  PageVerdict v{.tone = Tone::good, .word = "good", .meaning = "Nothing contradicts the uncertainties of any IMU.", .because = {}, .actions = {}};
  for (const std::string& name : missing) v.because.push_back(name + ": could not be calibrated");
  for (const NamedCalibration& imu : imus)
    if (imu.calibration.quality.verdict != Verdict::good) v.because.push_back(imu.name + ": " + verdict_text(imu.calibration.quality));
  if (v.because.empty()) return v;
  v.tone = Tone::doubtful, v.word = "doubtful";
  v.meaning = fmt::format("{} of {} IMUs have no good calibration.", v.because.size(), imus.size() + missing.size());
  return v;
}

/// "-0.12 ± 0.03 mg"
std::string value_of(const Calibration& c, CoefficientIndex index) {
  if (!standard_uncertainty(c, index)) return "";
  const UserValue v = user_value(c, index);
  const double expanded = expanded_uncertainty(c, index).coverage_factor * v.uncertainty;
  return escaped(fmt::format("{} ± {} {}", rounded_to(v.value, expanded), uncertainty_text(expanded), readable_unit(v.unit)));
}

}  // namespace
}  // namespace report

std::string imus_page(const std::string& log, const std::vector<NamedCalibration>& imus, const std::vector<std::string>& missing) {
  using namespace report;
  Page page;
  page.kind = "Calibration";
  page.title = fmt::format("{} IMUs of {}", imus.size() + missing.size(), name_of_file(log));
  page.verdict = verdict_of_all(imus, missing);
  Table coefficients;
  coefficients.head = {"coefficient"};
  for (const NamedCalibration& imu : imus) coefficients.head.push_back(escaped(imu.name));
  for (const CoefficientIndex index : coefficient_indices()) {
    std::vector<std::string> row{std::string(coefficient(index).name)};
    for (const NamedCalibration& imu : imus) row.push_back(value_of(imu.calibration, index));
    if (std::any_of(row.begin() + 1, row.end(), [](const std::string& value) { return !value.empty(); })) coefficients.rows.push_back(std::move(row));
  }
  page.body =
      section("coefficients", "Coefficients", "With expanded uncertainties: 95 % of such intervals contain the true value.", table(coefficients));
  return page_text(page);
}

}  // namespace imulab
