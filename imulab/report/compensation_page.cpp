#include "imulab/report/compensation_page.hpp"

#include "imulab/core/units.hpp"
#include "imulab/report/html.hpp"
#include "imulab/report/page.hpp"
#include "imulab/report/time_chart.hpp"

#include <fmt/format.h>

namespace imulab {

namespace report {
namespace {

Verdict compensation_verdict(const CompensationSummary& summary) {
  Verdict v{.tone = Tone::good,
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
  if (!summary.quality.verdict.empty() && summary.quality.verdict != "good") v.because.push_back("the calibration: " + verdict_text(summary.quality));
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
