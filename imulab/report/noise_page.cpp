#include "imulab/report/noise_page.hpp"

#include "imulab/core/units.hpp"
#include "imulab/noise/spectrum.hpp"
#include "imulab/recording/overview.hpp"
#include "imulab/report/html.hpp"
#include "imulab/report/page.hpp"
#include "imulab/report/plot.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <span>

namespace imulab {
namespace report {
namespace {

struct Scale {
  double rate, density, walk, quantum, ramp;
  const char *rate_name, *density_name, *walk_name, *quantum_name, *ramp_name;
};

constexpr Scale gyro_scale{
    unit::deg_per_h, unit::deg_per_sqrt_h, unit::deg_per_h / 60, unit::arcsec, unit::deg_per_h / unit::hour, "deg/h", "deg/√h", "deg/h/√h", "arcsec",
    "deg/h/h"};
constexpr Scale accel_scale{unit::ug, unit::ug_per_sqrt_hz, unit::ug / 60, 1e-6, unit::ug / unit::hour, "µg", "µg/√Hz", "µg/√h", "µm/s", "µg/h"};
constexpr Scale count_scale{1, 1, 1, 1, 1, "count", "count/√Hz", "count/√s", "count s", "count/s"};

const Scale& scale_of(const NoiseAxis& axis) { return axis.unit == "count" ? count_scale : axis.unit == "rad/s" ? gyro_scale : accel_scale; }

Verdict noise_verdict(const NoiseAnalysis& analysis) {
  Verdict v{Tone::good, "the model holds", "On every axis the spectrum is that of the fitted terms.", {}, {}};
  std::string misfits, silent;
  for (const NoiseAxis& axis : analysis.axes) {
    if (!axis.fit) silent += (silent.empty() ? "" : ", ") + axis.name;
    if (axis.fit && !axis.fit->accepted()) misfits += (misfits.empty() ? "" : ", ") + axis.name;
  }
  if (!misfits.empty()) {
    v = {Tone::doubtful, "the model does not hold everywhere", "All intervals of these axes are widened, and may not hold: " + misfits + ".", {}, {}};
    v.actions = {"Look at the spectrum below: what stands out of the model has a cause (vibration, heating, a supply)."};
  }
  if (!silent.empty()) v = {Tone::doubtful, "no noise on " + silent, "Readings that never change say nothing.", {}, {}};
  v.because = analysis.warnings;
  return v;
}

/// The interval of a determined coefficient, or the bound of one that is not.
std::string interval_text(const NoiseCoefficient& c, double size) {
  if (!c.determined) return "below " + number_text(c.upper / size, 2);
  return fmt::format("{} to {}", rounded_to(c.lower / size, c.standard_uncertainty / size),
                     rounded_to(c.upper / size, c.standard_uncertainty / size));
}

std::string coefficients_section(const NoiseAnalysis& analysis) {
  Table t{.head = {"axis", "term", "value", "95 % interval", "unit"}, .rows = {}, .text_columns = false, .left = {1, 4}};
  const auto add = [&](const NoiseAxis& axis, const std::string& term, const NoiseCoefficient& c, double size, const std::string& unit) {
    t.rows.push_back({escaped(axis.name), escaped(term), c.determined ? rounded_to(c.value / size, c.standard_uncertainty / size) : "not determined",
                      interval_text(c, size), escaped(unit)});
  };
  for (const NoiseAxis& axis : analysis.axes) {
    if (!axis.fit) continue;
    const Scale& s = scale_of(axis);
    add(axis, "N white noise", axis.fit->N, s.density, s.density_name);
    add(axis, "B bias instability", axis.fit->B, s.rate, s.rate_name);
    add(axis, "K random walk", axis.fit->K, s.walk, s.walk_name);
    add(axis, "Q quantization", axis.fit->Q, s.quantum, s.quantum_name);
    add(axis, "R ramp", axis.fit->R, s.ramp, s.ramp_name);
    for (const MarkovTerm& term : axis.fit->markov) {
      add(axis, "Markov process", term.sigma, s.rate, s.rate_name);
      add(axis, "its correlation time", term.time, 1, "s");
    }
    for (const NoiseLine& line : axis.fit->lines)
      add(axis, fmt::format("line at {} Hz", number_text(line.hz, 5)), line.amplitude, s.rate, s.rate_name);
    if (axis.fit->low_pass) add(axis, fmt::format("low-pass, order {}", axis.fit->low_pass->order), axis.fit->low_pass->cutoff_hz, 1, "Hz");
  }
  return section("coefficients", "Coefficients", "A term whose interval holds zero is not determined by this log; its bound holds with 95 %.",
                 table(t));
}

std::string deviation_figure(const NoiseAxis& axis) {
  const Scale& s = scale_of(axis);
  std::vector<double> tau, sigma, low68, high68, low95, high95, shown;
  for (const DeviationPoint& p : axis.deviation) {
    tau.push_back(p.tau), sigma.push_back(p.deviation / s.rate);
    low68.push_back(p.lower_68 / s.rate), high68.push_back(p.upper_68 / s.rate);
    low95.push_back(p.lower_95 / s.rate), high95.push_back(std::min(p.upper_95, 5 * p.deviation) / s.rate);
  }
  shown = sigma;
  shown.insert(shown.end(), high95.begin(), high95.end());
  shown.insert(shown.end(), low95.begin(), low95.end());
  Plot plot(axis_over("averaging time [s]", tau, true), axis_over(s.rate_name, shown, true), "deviation of " + axis.name);
  plot.band(tau, low95, high95, color::sky);
  plot.band(tau, low68, high68, color::blue);
  std::vector<double> total;
  std::array<std::vector<double>, 6> terms;
  for (const double t : tau) {
    const AllanTerms at = allan_variance(*axis.fit, t);
    total.push_back(std::sqrt(at.sum()) / s.rate);
    const std::array<double, 6> one{at.N, at.B, at.K, at.Q, at.R, at.markov};
    for (std::size_t j = 0; j < one.size(); ++j) terms[j].push_back(one[j] > 0 ? std::sqrt(one[j]) / s.rate : NAN);
  }
  const double lowest = *std::min_element(low95.begin(), low95.end());  // a term far below the curve would run along the axis
  for (std::vector<double>& term : terms) {
    for (double& value : term)
      if (value < lowest) value = NAN;
    plot.line(tau, term, color::gray, 1);
  }
  plot.line(tau, total, color::vermilion);
  plot.dots(tau, sigma, color::ink);
  return figure(plot.svg(), axis.name);
}

std::string deviations_section(const NoiseAnalysis& analysis) {
  std::vector<std::string> figures;
  for (const NoiseAxis& axis : analysis.axes)
    if (axis.fit) figures.push_back(deviation_figure(axis));
  return section("deviation", "Deviation over averaging time",
                 "Dots: measured, with 68 and 95 % bounds. Red: sum of the fitted terms (gray), without filter and lines.",
                 key({{"95 %", color::sky}, {"68 %", color::blue}, {"terms", color::gray}, {"sum", color::vermilion}}) + beside(figures));
}

/// Short enough for some dozens of pieces, long enough to show lines.
std::size_t welch_length(std::size_t samples) { return std::bit_floor(std::clamp<std::size_t>(samples / 32, 64, 16384)); }

std::string spectrum_figure(const NoiseAxis& axis, std::span<const double> readings, double interval_s) {
  const WelchSpectrum welch = welch_spectrum(readings, interval_s, welch_length(readings.size()));
  const Scale& s = scale_of(axis);
  std::vector<double> hz, density, model, fine_hz, fine, shown;
  for (const SpectrumPoint& p : axis.fit->spectrum) {
    hz.push_back(p.hz), model.push_back(std::sqrt(p.model) / s.density);
    density.push_back(p.count >= 8 ? std::sqrt(p.density) / s.density : NAN);  // of fewer the scatter hides what there is to see
  }
  // The largest of every few: lines stay.
  constexpr std::size_t points = 400;
  const std::size_t step = welch.density.size() / points + 1;
  for (std::size_t k = 0; k < welch.density.size(); k += step) {
    const auto first = welch.density.begin() + static_cast<std::ptrdiff_t>(k),
               last = welch.density.begin() + static_cast<std::ptrdiff_t>(std::min(k + step, welch.density.size()));
    fine_hz.push_back(welch.spacing_hz * (static_cast<double>(k) + 0.5 * static_cast<double>(step) + 0.5));
    fine.push_back(std::sqrt(*std::max_element(first, last)) / s.density);
  }
  shown = model;
  shown.insert(shown.end(), fine.begin(), fine.end());
  Plot plot(axis_over("frequency [Hz]", hz, true), axis_over(s.density_name, shown, true), "spectrum of " + axis.name);
  plot.line(fine_hz, fine, color::sky, 1);
  plot.dots(hz, density, color::ink, true);
  plot.line(hz, model, color::vermilion);
  return figure(plot.svg(), axis.name);
}

std::string spectra_section(const NoiseAnalysis& analysis, const RecordingView& recording, const Range& still) {
  std::vector<std::string> figures;
  std::vector<double> buffer;
  for (std::size_t k = 0; k < analysis.axes.size(); ++k)
    if (analysis.axes[k].fit) figures.push_back(spectrum_figure(analysis.axes[k], recording.samples(k, still, buffer), analysis.interval_s));
  return section("spectrum", "Spectrum",
                 "Root of the two-sided density. Circles: what the coefficients are fitted to, without lines. Blue: Welch's, with lines, the largest "
                 "of neighboring ones.",
                 key({{"Welch", color::sky}, {"measured", color::ink}, {"model", color::vermilion}}) + beside(figures));
}

std::string signal_section(const NoiseAnalysis& analysis, const RecordingView& r, const Range& still) {
  constexpr std::size_t intervals = 1500;
  const Overview shown = overview(SensorModel{}, r, intervals);
  std::string charts;
  for (const bool gyro : {true, false}) {
    const bool counts = (gyro ? r.gyro_unit : r.accel_unit) == "count";
    TimeChart chart{.title = gyro ? "Angular rate" : "Specific force",
                    .y_label = counts ? "counts"
                               : gyro ? "deg/s"
                                      : "m/s²",
                    .start = shown.first_s,
                    .x = shown.time,
                    .names = {"x", "y", "z"},
                    .y = {}};
    for (const auto& column : gyro ? shown.rate : shown.force) {
      chart.y.push_back(column);
      for (double& value : chart.y.back()) value /= gyro && !counts ? unit::deg : 1;
    }
    chart.marks.push_back({r.time_s(still.begin), r.time_s(still.end - 1), Mark::rest});
    charts += time_chart(chart);
  }
  return section("signal", "Signal", "The shaded part was used, the rest was cut.", list(analysis.notes) + charts);
}

}  // namespace
}  // namespace report

std::string noise_page(const NoiseAnalysis& analysis, const RecordingView& recording, const Range& still) {
  using namespace report;
  Page page;
  page.kind = "Noise";
  page.title = analysis.recording;
  page.verdict = noise_verdict(analysis);
  page.figures.push_back({number_text(analysis.end_s - analysis.begin_s, 4) + " s", "at rest"});
  page.figures.push_back({number_text(1 / analysis.interval_s, 5) + " Hz", "rate"});
  for (const bool gyro : {true, false}) {
    const NoiseAxis* worst = nullptr;
    for (const NoiseAxis& axis : analysis.axes)
      if (axis.name.starts_with(gyro ? "gyro" : "accel") && axis.fit && (worst == nullptr || axis.fit->N.upper > worst->fit->N.upper)) worst = &axis;
    if (worst != nullptr)
      page.figures.push_back({number_text((worst->fit->N.determined ? worst->fit->N.value : worst->fit->N.upper) / scale_of(*worst).density) + " " +
                                  scale_of(*worst).density_name,
                              "N, worst " + worst->name});
  }
  page.body = deviations_section(analysis) + spectra_section(analysis, recording, still) + coefficients_section(analysis) +
              signal_section(analysis, recording, still);
  return page_text(page);
}

}  // namespace imulab
