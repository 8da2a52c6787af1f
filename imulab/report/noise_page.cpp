#include "imulab/report/noise_page.hpp"

#include "imulab/noise/data_sheet.hpp"
#include "imulab/recording/overview.hpp"
#include "imulab/report/html.hpp"
#include "imulab/report/noise_figures.hpp"
#include "imulab/report/noise_moving.hpp"
#include "imulab/report/page.hpp"
#include "imulab/report/plot.hpp"
#include "imulab/results/noise.hpp"
#include "imulab/units.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace imulab {
namespace report {
namespace {

void add_name(std::string& names, const std::string& name) { names += (names.empty() ? "" : ", ") + name; }

PageVerdict noise_verdict(const NoiseAnalysis& analysis) {
  PageVerdict v{Tone::good, noise_headline(analysis), "On every axis the spectrum is that of the fitted terms.", analysis.warnings, {}};
  std::string misfits, silent;
  for (const NoiseAxis& axis : analysis.axes) {
    if (!axis.fit) add_name(silent, axis.name);
    if (axis.fit && !axis.fit->accepted()) add_name(misfits, axis.name);
  }
  if (!misfits.empty()) {
    v.tone = Tone::doubtful;
    v.meaning = "The model does not hold everywhere. All intervals of these axes are widened, and may not hold: " + misfits + ".";
    v.actions = {"Look at the spectrum below: what stands out of the model has a cause (vibration, heating, a supply)."};
  }
  if (!silent.empty()) v.tone = Tone::doubtful, v.meaning = "Readings that never change say nothing: " + silent + ".";
  return v;
}

std::string sheet_section(const NoiseAnalysis& analysis) {
  Table t{.head = {"axis", "term", "value", "SI", "standing"}, .rows = {}, .left = {1, 4}};
  for (const auto& [axis, term, value, si, standing] : sheet_rows(analysis))
    t.rows.push_back({escaped(axis), term, escaped(noise_unit_text(value)), escaped(noise_unit_text(si)), standing});
  return section("coefficients", "Coefficients", fmt::format("{}.", sheet_legend), table(t)) +
         section("given", "The data sheet as given", "", list(analysis.notes));
}

std::string comparison_section(const NoiseAnalysis& analysis) {
  if (analysis.sheet.empty()) return "";
  Table t{.head = {"axis and term", "data sheet", "log", "95 % interval", "unit", "ratio", "data sheet is"}, .rows = {}, .left = {4, 6}};
  for (const auto& row : comparison_rows(analysis)) {
    std::vector<std::string> cells(row.begin(), row.end());
    cells[4] = escaped(noise_unit_text(cells[4]));
    t.rows.push_back(std::move(cells));
  }
  return section("datasheet", "Against the data sheet", "Inside or possible: within the log's 95 % interval, or below its bound.", table(t));
}

/// Empty without bounds.
std::string bound_section(const std::vector<std::array<std::string, 5>>& rows, const std::vector<std::string>& legend) {
  if (rows.empty()) return "";
  Table t{.head = {"axis", "N", "processes", "K", "cost"}, .rows = {}, .left = {2}};
  for (const auto& row : rows) t.rows.emplace_back(row.begin(), row.end());
  std::vector<std::string> readable;
  for (const std::string& line : legend) readable.push_back(noise_unit_text(line));
  return section("bound", "Bound for a filter", "", table(t) + list(readable));
}

/// A data sheet: nothing was measured or judged.
std::string data_sheet_page(const NoiseAnalysis& analysis) {
  Page page;
  page.kind = "Noise";
  page.title = analysis.recording.empty() ? "Data sheet" : analysis.recording;
  page.subtitle = "values of a data sheet";
  page.verdict = {
      .tone = Tone::neutral, .word = noise_headline(analysis), .meaning = "No log was analyzed.", .because = analysis.warnings, .actions = {}};
  page.body = moving_section(analysis) + sheet_section(analysis);
  return page_text(page);
}

/// N, B and K of each triad's worst axis.
std::vector<KeyFigure> noise_cards(const NoiseAnalysis& analysis) {
  std::vector<KeyFigure> out;
  for (const bool gyro : {true, false})
    for (std::size_t j = 0; j < 3; ++j) {
      const NoiseTermText& term = noise_terms()[j];
      const WorstTerm worst = worst_term(analysis, gyro, term.member);
      if (worst.axis == nullptr) continue;
      const NoiseUnit& unit = term.unit(worst.axis->unit);
      const std::string letter(1, worst.axis->name.back());
      const std::string which = worst.determined == 0 ? ", not determined"
                                : worst.determined == worst.axes
                                    ? ", worst axis: " + letter
                                    : fmt::format(", {} ({} of {} axes determine it)", letter, worst.determined, worst.axes);
      out.push_back({noise_value_text(*worst.c, unit.size, unit.name), fmt::format("{} {}{}", gyro ? "gyro" : "accelerometer", term.name, which)});
    }
  return out;
}

/// The interval of a determined coefficient, or the bound of one that is not.
std::string noise_interval_text(const NoiseCoefficient& c, double size) {
  if (!c.determined) return c.upper == 0 ? "not in the model" : "below " + number_text(c.upper / size, 2);
  return fmt::format("{} to {}", rounded_to(c.lower / size, c.standard_uncertainty / size),
                     rounded_to(c.upper / size, c.standard_uncertainty / size));
}

/// Value, interval and unit, then value or bound in SI, where that is another unit.
std::vector<std::string> noise_cells(const NoiseCoefficient& c, const NoiseUnit& unit) {
  return {c.determined ? rounded_to(c.value / unit.size, c.standard_uncertainty / unit.size) : "not determined", noise_interval_text(c, unit.size),
          escaped(noise_unit_text(unit.name)),
          unit.si.empty() ? ""
          : c.determined  ? number_text(c.value, 4)
                          : "below " + number_text(c.upper, 2),
          escaped(noise_unit_text(unit.si))};
}

void add_row(Table& t, const std::string& axis, const std::string& term, const NoiseCoefficient& c, const NoiseUnit& unit) {
  std::vector<std::string> row{escaped(axis), escaped(term)};
  for (std::string& cell : noise_cells(c, unit)) row.push_back(std::move(cell));
  t.rows.push_back(std::move(row));
}

std::string term_name(const NoiseTermText& term) {
  const std::string meaning(term.meaning);
  return fmt::format("{} {}", term.name, meaning.substr(0, meaning.find(" (")));
}

/// Terms in the order of the terminal's table: one term of all axes, then the next; the terms that only some axes have last.
std::string coefficients_section(const NoiseAnalysis& analysis) {
  Table t{.head = {"axis", "term", "value", "95 % interval", "unit", "SI", ""}, .rows = {}, .left = {1, 4, 6}};
  for (const NoiseTermText& term : noise_terms())
    for (const NoiseAxis& axis : analysis.axes)
      if (axis.fit) add_row(t, axis.name, term_name(term), (*axis.fit).*term.member, term.unit(axis.unit));
  for (const NoiseAxis& axis : analysis.axes) {
    if (!axis.fit) continue;
    const NoiseUnit& of_rate = noise_terms()[1].unit(axis.unit);
    const NoiseUnit seconds{1, "s", ""}, hertz{1, "Hz", ""};
    if (const auto& joint = axis.fit->joint)
      add_row(t, axis.name, fmt::format("B and K together at {} s", number_text(joint->tau_s, 3)), joint->deviation, of_rate);
    for (const MarkovTerm& term : axis.fit->markov) {
      add_row(t, axis.name, "Markov process", term.sigma, of_rate);
      add_row(t, axis.name, "its correlation time", term.time, seconds);
    }
    for (const NoiseLine& line : axis.fit->lines)
      add_row(t, axis.name, fmt::format("line at {} Hz", number_text(line.hz, 5)), line.amplitude, of_rate);
    if (axis.fit->low_pass) add_row(t, axis.name, fmt::format("low-pass, order {}", axis.fit->low_pass->order), axis.fit->low_pass->cutoff_hz, hertz);
  }
  return section("coefficients", "Coefficients",
                 "A term whose interval holds zero is not determined by this log; its bound holds with 95 %. SI: the value, or its bound.", table(t));
}

std::string deviations_section(const NoiseAnalysis& analysis) {
  return section("deviation", "Deviation over averaging time",
                 "Colored: measured, with 95 % bounds. Lines named N, B, K: these terms of the worst axis alone, of slope −1/2, 0 and +1/2; dashed "
                 "where the log gives only a bound.",
                 deviation_charts(analysis));
}

std::string spectra_section(const NoiseAnalysis& analysis) {
  const std::string charts = spectrum_charts(analysis);
  return charts.empty() ? ""
                        : section("spectrum", "Spectrum",
                                  "Root of the two-sided density, down to the lowest frequency of the log. Dots: what the coefficients are fitted "
                                  "to, without lines; at the left single densities, which scatter. Lines: the model.",
                                  charts);
}

std::string each_axis_section(const NoiseAnalysis& analysis, const AxisReadings& readings) {
  const std::string charts = axis_charts(analysis, readings);
  return charts.empty() ? "" : section("axes", "Axis by axis", "", folded("Deviation with each fitted term, and spectrum, of every axis", charts));
}

std::string signal_section(const NoiseAnalysis& analysis, const RecordingView& r, const Range& still) {
  constexpr std::size_t intervals = 1500;
  const Overview shown = overview(SensorModel{}, r, intervals);
  std::string charts;
  for (const bool gyro : {true, false}) {
    const auto& columns = gyro ? shown.rate : shown.force;
    if (std::none_of(analysis.axes.begin(), analysis.axes.end(),
                     [&](const NoiseAxis& axis) { return axis.name.starts_with(gyro ? "gyro" : "accel"); }))
      continue;
    const bool counts = (gyro ? r.gyro_unit : r.accel_unit) == "count";
    TimeChart chart{.title = gyro ? "Angular rate" : "Specific force",
                    .y_label = counts ? "counts"
                               : gyro ? "deg/s"
                                      : "m/s²",
                    .start = shown.first_s,
                    .x = shown.time,
                    .names = {"x", "y", "z"},
                    .y = {}};
    for (const auto& column : columns) {
      chart.y.push_back(column);
      for (double& value : chart.y.back()) value /= gyro && !counts ? unit::deg : 1;
    }
    chart.marks.push_back({r.time_s(still.begin), r.time_s(still.end - 1), Mark::rest});
    charts += time_chart(chart);
  }
  return section("signal", "Signal", "The shaded part was used, the rest was cut.", list(analysis.notes) + charts);
}

Page noise_page_of(const NoiseAnalysis& analysis) {
  Page page;
  page.kind = "Noise";
  page.title = name_of_file(analysis.recording);
  page.subtitle = fmt::format("{} s at rest at {} Hz", number_text(analysis.end_s - analysis.begin_s, 4), number_text(1 / analysis.interval_s, 5));
  page.verdict = noise_verdict(analysis);
  page.figures = noise_cards(analysis);
  return page;
}

Table batch_table(const NoiseBatch& batch) {
  Table t{.head = {"axis", "term", "mean", "95 % interval", "unit", "SI", "", "spread", "worst", "log"}, .rows = {}, .left = {1, 4, 6, 9}};
  for (const NoiseTermText& term : noise_terms())
    for (const BatchAxis& axis : batch.axes) {
      const BatchCoefficient& c = axis.coefficients[term.batch_place];
      const NoiseUnit& unit = term.unit(axis.unit);
      add_row(t, axis.name, term_name(term), c.mean, unit);
      t.rows.back().push_back(std::isnan(c.spread) ? "" : number_text(c.spread / unit.size, 2));
      t.rows.back().push_back(number_text(c.worst / unit.size, 2));
      t.rows.back().push_back(c.worst_log < batch.logs.size() ? escaped(shortened(batch.logs[c.worst_log].recording, 40)) : "");
    }
  return t;
}

}  // namespace
}  // namespace report

std::string noise_page(const NoiseAnalysis& analysis, const RecordingView& recording, const Range& still, const Conclusion& conclusion) {
  using namespace report;
  Page page = noise_page_of(analysis);
  if (!conclusion.requirements.empty()) take_conclusion(page.verdict, conclusion);
  std::vector<double> buffer;
  const AxisReadings readings = [&](std::size_t axis) { return recording.samples(axis, still, buffer); };
  page.body = moving_section(analysis) + deviations_section(analysis) + spectra_section(analysis) + coefficients_section(analysis) +
              bound_section(bound_rows(analysis), bound_legend(analysis)) + comparison_section(analysis) + each_axis_section(analysis, readings) +
              signal_section(analysis, recording, still);
  return page_text(page);
}

std::string noise_page(const NoiseAnalysis& analysis, const Conclusion& conclusion) {
  using namespace report;
  if (analysis.from_data_sheet()) return data_sheet_page(analysis);
  Page page = noise_page_of(analysis);
  if (!conclusion.requirements.empty()) take_conclusion(page.verdict, conclusion);
  std::vector<std::string> missing{"Signal, and Welch's spectrum with its lines: noise.json keeps no readings; imulab noise --report draws them."};
  if (spectrum_charts(analysis).empty()) missing.emplace_back("Spectrum: the file has none.");
  page.body = section("missing", "Not on this page", "", list(missing, "missing-list")) + moving_section(analysis) + deviations_section(analysis) +
              spectra_section(analysis) + coefficients_section(analysis) + bound_section(bound_rows(analysis), bound_legend(analysis)) +
              comparison_section(analysis) + each_axis_section(analysis, {});
  if (!analysis.notes.empty()) page.body += section("signal", "Signal", "What was used, and what was cut.", list(analysis.notes));
  return page_text(page);
}

std::string noise_page(const NoiseBatch& batch, const Conclusion& conclusion) {
  using namespace report;
  Page page;
  page.kind = "Noise";
  page.title = fmt::format("{} logs", batch.logs.size());
  page.verdict = {.tone = Tone::good,
                  .word = noise_headline(batch),
                  .meaning = "The mean of the logs that determine a term, with the larger of the uncertainty that they state and that they show.",
                  .because = {},
                  .actions = {}};
  if (!conclusion.requirements.empty()) take_conclusion(page.verdict, conclusion);
  for (const NoiseAnalysis& log : batch.logs) {
    const PageVerdict one = noise_verdict(log);
    if (one.tone == Tone::good) continue;
    page.verdict.tone = Tone::doubtful;
    page.verdict.because.push_back(shortened(log.recording, 60) + ": " + one.meaning);
  }
  Table logs{.head = {"log", "at rest [s]", "rate [Hz]"}, .rows = {}};
  for (const NoiseAnalysis& log : batch.logs)
    logs.rows.push_back({escaped(shortened(log.recording, 80)), number_text(log.end_s - log.begin_s, 5), number_text(1 / log.interval_s, 5)});
  page.body = section("deviation", "Deviation over averaging time", "Each log; the charts of a triad have one scale.", batch_charts(batch)) +
              section("coefficients", "Coefficients",
                      "Mean: of the logs that determine the term; where none does, the largest bound. Spread: from log to log, beyond what the "
                      "uncertainties explain. Worst: the largest value or bound, and its log.",
                      report::table(batch_table(batch))) +
              bound_section(bound_rows(batch), bound_legend(batch)) + section("logs", "Logs", "", report::table(logs));
  return page_text(page);
}

}  // namespace imulab
