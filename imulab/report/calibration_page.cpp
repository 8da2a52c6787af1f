#include "imulab/report/calibration_page.hpp"

#include "imulab/coefficient.hpp"
#include "imulab/earth.hpp"
#include "imulab/error.hpp"
#include "imulab/estimate/method.hpp"
#include "imulab/model/relative_uncertainty.hpp"
#include "imulab/navigation/aided/aid_motion.hpp"
#include "imulab/predict.hpp"
#include "imulab/procedure.hpp"
#include "imulab/recording/coverage.hpp"
#include "imulab/recording/rests_of_view.hpp"
#include "imulab/report/calibration_parts.hpp"
#include "imulab/report/html.hpp"
#include "imulab/report/page.hpp"
#include "imulab/results/calibration.hpp"
#include "imulab/results/live.hpp"

#include <fmt/format.h>

#include <algorithm>
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
  if (!q.unobservable.empty())
    out.push_back(fmt::format("Not determined, left at starting values: {}. Record motion that shows them.", fmt::join(q.unobservable, ", ")));
  std::vector<std::string_view> priors;
  for (const CoefficientIndex index : report.result.calibration.estimated)
    if (const Term term = coefficient(index).term; (term == Term::offset || term == Term::matrix) && !is_result(report.result.calibration, index))
      priors.push_back(coefficient(index).name);
  if (!priors.empty())
    out.push_back(fmt::format("Not determined, as uncertain as before the data: {}. Record motion that shows them, or use the others alone.",
                              fmt::join(priors, ", ")));
  for (const RequirementResult& r : q.requirements)
    if (!r.met && !(r.reached <= r.limit))
      out.push_back("Not reached: " + r.text + ". A longer recording with more rests and turns lowers it; imulab predict says by how much.");
  if (q.verdict == Verdict::doubtful) {
    out.emplace_back("Resolve each reason above, and calibrate again. Until then rely on the values no further than the reasons allow.");
    if (const std::string more = missing_directions(report); !more.empty()) out.push_back(more);
  }
  if (out.empty() && q.verdict == Verdict::good)  // and no requirement was missed
    out = {"Use it within the conditions below: imulab compensate applies it to recordings, imulab export to firmware.",
           "Repeat it after a power cycle and another day, and compare: one calibration does not show how stable the IMU is."};
  return out;
}

PageVerdict verdict_of(const CalibrationReport& report) {
  const Quality& q = report.result.calibration.quality;
  PageVerdict v;
  const bool bare = report.result.calibration.estimated.empty();
  const Conclusion conclusion = conclusion_of(report.result.calibration);
  v.word = conclusion.verdict == Verdict::none ? "no verdict" : to_string(conclusion.verdict);
  if (conclusion.verdict == Verdict::none || bare)
    v.meaning = bare ? "Values without uncertainties: there is nothing to judge." : "This file does not say how good the calibration is.";
  else
    take_conclusion(v, conclusion);
  if (conclusion.verdict == Verdict::good && !bare)
    v.meaning = "The residuals are as large as the stated uncertainties say, and nothing contradicts the calibration.";
  if (conclusion.verdict == Verdict::doubtful) v.meaning = "Something contradicts the stated uncertainties, or is missing:";
  v.because = q.findings.reasons();
  if (!bare) v.actions = actions(report);
  return v;
}

std::string requirements_section(const Quality& q) {
  Table t{.head = {"requirement", "worst coefficient", "reached", ""}, .rows = {}, .text_columns = true};
  for (const RequirementResult& r : q.requirements) {
    const UserUnit unit = user_unit(coefficient(coefficient_index(r.coefficient)), r.limit);
    t.rows.push_back({escaped(r.text), escaped(r.coefficient),
                      escaped(std::isfinite(r.reached) ? uncertainty_text(r.reached / unit.size) + " " + std::string(unit.name) : "not determined"),
                      (r.met ? "met" : "<strong>not met</strong>") + escaped(r.note.empty() ? "" : ": " + r.note)});
  }
  return t.rows.empty()
             ? ""
             : section(
                   "requirements", "Requirements",
                   "The larger of u and U/2 of each coefficient, of matrices relative to its scale. With fewer than 3 effective degrees of freedom "
                   "no requirement is met.",
                   table(t));
}

std::string subtitle_of(const Calibration& c) {
  std::string text = c.method.empty() ? "" : "method " + c.method;
  if (!c.serial.empty()) text = "serial number " + c.serial + " · " + text;
  if (!c.created.empty()) text += " · " + c.created;
  return text;
}

std::string warnings_section(const Quality& q) {
  const std::vector<std::string> warnings = q.findings.warnings();
  return warnings.empty() ? "" : section("warnings", "Warnings", "", list(warnings));
}

std::string next_switch_on_note(const Calibration& c) {
  const std::string next = next_switch_on_text(c);
  return next.empty() ? next
                      : paragraph("Offsets at the next switch-on, standard uncertainty: " + readable_unit(next) + ", as the recordings differ.");
}

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
  page.body = worst_axis_note(page.figures) + next_switch_on_note(c) + before_and_after(r) + requirements_section(c.quality) +
              warnings_section(c.quality) + missing_section(r.missing) + coefficients_section(c) + recordings_section(r) + residuals_section(c) +
              coverage_section(r) + uncertainty_section(c) + correlation_section(c) + convergence_section(r.result) + thermal_section(r) +
              nonlinearity_section(r) + tests_section(c) + effects_section(c) + identification_section(r) + not_covered_section(r) +
              traceability_section(r) + origin_section(r);
  return page_text(page);
}

namespace {

/// Points of all charts of one quantity: two for each of these intervals.
constexpr std::size_t all_intervals = 1500, least_intervals = 50;

std::vector<Range> ranges_of(const Calibration& calibration, const Session& session, const Recording& recording, bool only_one) {
  const std::vector<PartResidual>& rests = calibration.quality.rests;
  const auto is_of_it = [&](const PartResidual& rest) { return only_one || rest.recording == recording.name; };
  if (std::ranges::none_of(rests, is_of_it)) return aided::rests_in_place(recording, session);
  std::vector<Range> ranges;
  const double first = recording.time_s(0) - recording.interval_s, last = recording.time_s(recording.size() - 1) + recording.interval_s;
  for (const PartResidual& rest : rests)  // of a file that anybody may have written
    if (is_of_it(rest) && first <= rest.begin_s && rest.begin_s < rest.end_s && rest.end_s <= last)
      ranges.push_back(recording.samples_in(rest.begin_s, rest.end_s));
  return ranges;
}

double largest(const Columns3& columns) {
  double most = 0;
  for (const auto& column : columns)
    for (const double v : column) most = std::max(most, std::abs(v));
  return most;
}

}  // namespace

RecordingEvidence evidence_of(const Calibration& calibration, const Session& session, const Recording& recording, std::size_t recordings) {
  RecordingEvidence e;
  e.file = recording.name;
  e.samples = recording.size();
  e.saturated = recording.saturated.size();
  e.gaps = recording.gaps.size();
  if (recording.size() == 0) return e;
  e.rate_hz = 1 / recording.interval_s;
  e.duration_s = recording.time_s(recording.size() - 1) - recording.time_s(0) + recording.interval_s;
  e.overview = overview(calibration.model, recording, std::max(least_intervals, all_intervals / std::max<std::size_t>(1, recordings)));
  e.largest_rate = largest(e.overview.rate);
  e.largest_force = largest(e.overview.force);
  const RigDeclaration* rig = session.rig_of(session.source_of(recording.name));
  if (rig != nullptr && rig->kind != RigKind::none && rig->kind != RigKind::turntable) {
    e.without_rests = std::string(to_string(rig->kind)) + " recordings have no rests in free directions";
    return e;
  }
  try {
    const SensorModel before = uncalibrated(calibration.model);
    e.rests = gravity_at_rests(recording, ranges_of(calibration, session, recording, recordings == 1), before, calibration.model);
    e.turns = turn_errors(recording, e.rests, before, calibration.model);
    const Site& site = session.site;
    const auto determined = [&](Triad triad) { return contains(calibration.estimated, coefficient_index(triad, Term::offset, 0, 0)); };
    if (calibration.model.accel.varies() || calibration.model.gyro.varies())
      e.sweep = rests_over_temperature(recording, e.rests, calibration.model,
                                       {determined(Triad::accel) && (site.latitude || site.given_gravity) ? site.gravity() : NAN,
                                        determined(Triad::gyro) && site.latitude ? earth_rate_enu(*site.latitude).z() : NAN});
  } catch (const Error& error) {
    e.without_rests = error.what();
  }
  if (e.rests.empty() && e.without_rests.empty()) e.without_rests = "none were found";
  return e;
}

}  // namespace imulab
