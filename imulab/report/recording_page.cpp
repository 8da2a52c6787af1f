#include "imulab/report/recording_page.hpp"

#include "imulab/recording/coverage.hpp"
#include "imulab/report/html.hpp"
#include "imulab/report/page.hpp"
#include "imulab/report/pictures.hpp"
#include "imulab/report/plot.hpp"
#include "imulab/units.hpp"

#include <fmt/format.h>

namespace imulab {
namespace report {
namespace {

PageVerdict inspection_verdict(const Inspection& inspection) {
  PageVerdict v;
  if (!inspection.problems().empty()) return {Tone::doubtful, "not usable", "The file has to be fixed first:", inspection.problems(), {}};
  if (!inspection.complete()) {
    v = {Tone::doubtful, "open", "The data do not answer everything that a session needs:", inspection.ambiguous(), {}};
    v.actions = {"Declare it: imulab inspect FILE --set KEY=VALUE"};
    return v;
  }
  v = {Tone::good, "understood", "The data say what every column is, and in which unit.", {}, {}};
  std::string methods;
  for (const MethodFinding& method : inspection.methods)
    if (method.supported) methods += (methods.empty() ? "" : " or ") + method.name;
  if (methods.empty()) {
    v.tone = Tone::neutral;
    v.because = {"They support no calibration from rests alone."};
  } else {
    v.actions = {"Calibrate with the method " + methods + "."};
  }
  return v;
}

TimeChart signal_chart(const Inspection& inspection, const Overview& overview, const Columns3& columns, const std::string& title,
                       const std::string& label, double unit) {
  TimeChart chart{.title = title, .y_label = label, .start = overview.first_s, .x = overview.time, .names = {"x", "y", "z"}, .y = {}};
  for (const auto& column : columns) {
    chart.y.push_back(column);
    for (double& value : chart.y.back()) value /= unit;
  }
  for (const auto& [rest_begin, rest_end] : inspection.rests_s)
    chart.marks.push_back({overview.first_s + rest_begin, overview.first_s + rest_end, Mark::rest});
  return chart;
}

std::string signals_section(const Inspection& inspection, const Overview& overview) {
  return section("signals", "Signals",
                 overview.samples_per_interval > 1
                     ? fmt::format("Rests are shaded. The charts show the least and the greatest of every {} samples.", overview.samples_per_interval)
                     : "Rests are shaded.",
                 time_chart(signal_chart(inspection, overview, overview.force, "Specific force", "m/s²", 1)) +
                     time_chart(signal_chart(inspection, overview, overview.rate, "Angular rate", "deg/s", unit::deg)));
}

std::string columns_section(const Inspection& inspection) {
  Table columns{.head = {"column", "is", "unit", "because"}, .rows = {}, .text_columns = true};
  for (const ColumnFinding& c : inspection.columns)
    columns.rows.push_back({escaped(shortened(c.name, 60)), escaped(c.role), escaped(readable_unit(c.unit)), escaped(shortened(c.evidence, 200))});
  return section("columns", "Columns", inspection.format, table(columns));
}

std::string directions_section(const Inspection& inspection) {
  if (!inspection.triads || inspection.triads->up.empty()) return "";
  std::vector<SphereMark> marks;
  for (const Vector3d& up : inspection.triads->up) marks.push_back({up, false});
  constexpr double far = 0.7;  // rad: a face between faces
  for (const CoverageGap& gap : coverage_gaps(inspection.triads->up, far)) marks.push_back({gap.direction, true});
  return section("directions", "Directions of gravity at the rests", "Crosses: where no rest is near.",
                 figure(sphere(marks, "directions that pointed up at the rests"), "What pointed up, in the accelerometers' axes."));
}

std::string methods_section(const Inspection& inspection) {
  Table methods{.head = {"method", "supported", "because"}, .rows = {}, .text_columns = true};
  for (const MethodFinding& m : inspection.methods) methods.rows.push_back({escaped(m.name), m.supported ? "yes" : "no", escaped(m.why)});
  return section("methods", "Methods", "What the data support.", table(methods));
}

}  // namespace
}  // namespace report

std::string inspection_page(const Inspection& inspection, const std::optional<Overview>& overview) {
  using namespace report;
  Page page;
  page.kind = "Inspection";
  page.title = name_of_file(inspection.file);
  page.subtitle = inspection.topic;
  page.verdict = inspection_verdict(inspection);
  page.figures.push_back({std::to_string(inspection.rows), "rows"});
  if (inspection.rate_hz) {
    page.figures.push_back({number_text(*inspection.rate_hz, 5) + " Hz", "rate"});
    page.figures.push_back({number_text(inspection.duration_s) + " s", "duration"});
  }
  if (inspection.triads) page.figures.push_back({std::to_string(inspection.triads->rests.size()), "rests"});
  page.body = section("evidence", "What was found", "Each guess with what speaks for it.", list(inspection.evidence(), "evidence"));
  if (overview) page.body += signals_section(inspection, *overview);
  page.body += columns_section(inspection) + directions_section(inspection) + methods_section(inspection);
  return page_text(page);
}

namespace report {
namespace {

PageVerdict compensation_verdict(const CompensationSummary& summary) {
  PageVerdict v{.tone = Tone::good,
                .word = "compensated",
                .meaning = "Every sample was corrected within the conditions of the calibration.",
                .because = {},
                .actions = {}};
  for (const CompensatedFile& e : summary.files) {
    const std::string& name = e.recording.empty() ? e.file : e.recording;
    if (e.saturated > 0) v.because.push_back(fmt::format("{}: {} of {} samples have a reading at a limit", name, e.saturated, e.samples));
    if (e.out_of_range > 0)
      v.because.push_back(fmt::format("{}: {} of {} samples are outside the calibrated temperatures", name, e.out_of_range, e.samples));
    if (e.replaced > 0) v.because.push_back(fmt::format("{}: {} of {} samples had an outlier, which was replaced", name, e.replaced, e.samples));
  }
  if (summary.quality.verdict == Verdict::doubtful) v.because.push_back("the calibration: " + verdict_text(summary.quality));
  if (v.because.empty()) return v;
  v.tone = Tone::doubtful;
  v.word = "compensated with reservations";
  v.meaning = "Some samples are less certain than the calibration states:";
  v.actions = {"The column flags of the output marks them."};
  return v;
}

TimeChart chart_of(const CompensatedFile& e, const std::string& title, const std::string& label, const Columns3& columns, double unit) {
  TimeChart c{
      .title = title, .y_label = label, .start = e.overview->first_s, .x = e.overview->time, .names = {"x", "y", "z"}, .y = {}, .group = e.recording};
  for (const auto& column : columns) {
    c.y.push_back(column);
    for (double& v : c.y.back()) v /= unit;
  }
  return c;
}

std::string compensated_section(const CompensatedFile& e) {
  if (!e.overview) return section("recording", e.file, fmt::format("{} samples.", e.samples), "");
  std::string content = time_chart(chart_of(e, "Angular rate", "deg/s", e.overview->rate, unit::deg)) +
                        time_chart(chart_of(e, "Specific force", "m/s²", e.overview->force, 1));
  if (!e.overview->temperature[0].empty()) content += time_chart(chart_of(e, "Thermal reading", "", e.overview->temperature, 1));
  return section("recording", e.recording,
                 fmt::format("{} samples at {} Hz, {} gaps. {}", e.samples, number_text(e.rate_hz, 5), e.gaps,
                             e.overview->samples_per_interval > 1
                                 ? fmt::format("The charts show the least and the greatest of every {} samples.", e.overview->samples_per_interval)
                                 : "The charts show every sample."),
                 content);
}

}  // namespace
}  // namespace report

std::string compensation_page(const CompensationSummary& r, const std::vector<std::string>& missing) {
  using namespace report;
  Page page;
  page.kind = "Compensated recordings";
  page.title = r.imu.empty() ? "unnamed IMU" : r.imu;
  page.subtitle = "with " + r.calibration_file;
  page.verdict = compensation_verdict(r);
  if (!missing.empty()) page.body += section("missing", "Not on this page", "", list(missing, "missing-list"));
  for (const CompensatedFile& e : r.files) page.body += compensated_section(e);
  return page_text(page);
}

}  // namespace imulab
