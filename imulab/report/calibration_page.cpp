#include "imulab/report/calibration_page.hpp"

#include "imulab/model/user_value.hpp"
#include "imulab/recording/coverage.hpp"
#include "imulab/report/calibration_parts.hpp"
#include "imulab/report/html.hpp"
#include "imulab/report/key_figures.hpp"
#include "imulab/results/live.hpp"
#include "imulab/results/reached.hpp"

#include <fmt/format.h>

#include <cmath>
#include <string_view>

namespace imulab {

namespace report {
namespace {

/// Where else to rest the IMU, if the rests leave a large part of the sphere open.
std::string missing_directions(const CalibrationReport& report) {
  constexpr double large = 0.9;  // rad: two rests along neighboring axes are 1.6 apart
  std::string text;
  for (const CoverageGap& gap : coverage_gaps(rest_directions(report), large))
    text += (text.empty() ? "" : "; ") + direction_text(gap.direction) + " up";
  return text.empty() ? text : "Add rests where none is near: " + text + ".";
}

std::vector<std::string> actions(const CalibrationReport& report) {
  const Quality& q = report.result.calibration.quality;
  std::vector<std::string> out;
  if (!q.converged) out.emplace_back("Do not use it: the fit did not converge. Check what the session declares, then calibrate again.");
  if (!q.unobservable.empty()) {
    std::string names;
    for (const std::string& name : q.unobservable) names += (names.empty() ? "" : ", ") + name;
    out.push_back("Not determined, left at starting values: " + names + ". Record motion that shows them.");
  }
  for (const RequirementResult& r : q.requirements)
    if (!r.met)
      out.push_back("Not reached: " + r.text + ". A longer recording with more rests and turns lowers it; imulab predict says by how much.");
  if (q.verdict == "doubtful") {
    out.emplace_back("Resolve each reason above, and calibrate again. Until then rely on the values no further than the reasons allow.");
    if (const std::string more = missing_directions(report); !more.empty()) out.push_back(more);
  }
  if (out.empty() && q.verdict == "good")
    out = {"Use it within the conditions below: imulab compensate applies it to recordings, imulab export to firmware.",
           "Repeat it after a power cycle and another day, and compare: one calibration does not show how stable the IMU is."};
  return out;
}

Verdict verdict_of(const CalibrationReport& report) {
  const Quality& q = report.result.calibration.quality;
  Verdict v;
  v.word = q.verdict.empty() ? "no verdict" : q.verdict;
  const bool bare = report.result.calibration.estimated.empty();
  v.tone = q.verdict == "good" && !bare ? Tone::good : q.verdict == "doubtful" ? Tone::doubtful : Tone::neutral;
  if (v.tone == Tone::good) v.meaning = "The residuals are as large as the stated uncertainties say, and nothing contradicts the calibration.";
  if (v.tone == Tone::doubtful) v.meaning = "Something contradicts the stated uncertainties, or is missing:";
  if (v.tone == Tone::neutral)
    v.meaning = bare ? "Values without uncertainties: there is nothing to judge." : "This file does not say how good the calibration is.";
  v.because = q.because;
  if (!bare) v.actions = actions(report);
  return v;
}

std::string requirements_section(const Quality& q) {
  Table t{.head = {"requirement", "worst coefficient", "reached", ""}, .rows = {}, .text_columns = true};
  for (const RequirementResult& r : q.requirements) {
    const UserUnit unit = user_unit(coefficient(coefficient_index(r.coefficient)), r.limit);
    t.rows.push_back({escaped(r.text), escaped(r.coefficient),
                      escaped(std::isfinite(r.reached) ? uncertainty_text(r.reached / unit.size) + " " + std::string(unit.name) : "not determined"),
                      r.met ? "met" : "<strong>not met</strong>"});
  }
  return t.rows.empty()
             ? ""
             : section("requirements", "Requirements", "One standard uncertainty of each coefficient, of matrices relative to its scale.", table(t));
}

std::string subtitle_of(const Calibration& c) {
  std::string text = c.method.empty() ? "" : "method " + c.method;
  if (!c.serial.empty()) text = "serial number " + c.serial + " · " + text;
  if (!c.created.empty()) text += " · " + c.created;
  return text;
}

std::string warnings_section(const Quality& q) { return q.warnings.empty() ? "" : section("warnings", "Warnings", "", list(q.warnings)); }

std::string missing_section(const std::vector<std::string>& missing) {
  return missing.empty() ? "" : section("missing", "Not on this page", "", list(missing, "missing-list"));
}

}  // namespace
}  // namespace report

std::string calibration_page(const CalibrationReport& r) {
  using namespace report;
  const Calibration& c = r.result.calibration;
  Page page;
  page.kind = "Calibration";
  page.title = c.imu.empty() ? "unnamed IMU" : c.imu;
  page.subtitle = subtitle_of(c);
  page.verdict = verdict_of(r);
  page.figures = key_figures([&](CoefficientIndex index) { return judged_uncertainty(c, index); });
  page.body = worst_axis_note(page.figures) + warnings_section(c.quality) + missing_section(r.missing) + requirements_section(c.quality) +
              before_and_after(r) + coefficients_section(c) + recordings_section(r) + residuals_section(c) + coverage_section(r) +
              uncertainty_section(c) + correlation_section(c) + convergence_section(r.result) + thermal_section(c) + nonlinearity_section(r) +
              tests_section(c) + identification_section(r) + not_covered_section(r) + traceability_section(r) + origin_section(r);
  return page_text(page);
}

}  // namespace imulab
