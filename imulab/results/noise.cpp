#include "imulab/results/noise.hpp"

#include "imulab/core/units.hpp"
#include "imulab/formats/text/figures.hpp"

#include <fmt/format.h>

#include <array>
#include <cmath>

namespace imulab {

namespace {

struct NoiseTerm {
  const char* name;
  const char* meaning;
  NoiseCoefficient NoiseFit::*member;
  const char *gyro_unit, *accel_unit, *count_unit;
  double gyro_size, accel_size;
};

const std::array<NoiseTerm, 5> noise_terms{
    {{"N", "white noise (random walk of angle, velocity)", &NoiseFit::N, "deg/sqrt(h)", "ug/sqrt(Hz)", "count/sqrt(Hz)", unit::deg_per_sqrt_h,
      unit::ug_per_sqrt_hz},
     {"B", "bias instability (flicker)", &NoiseFit::B, "deg/h", "ug", "count", unit::deg_per_h, unit::ug},
     {"K", "random walk of the bias", &NoiseFit::K, "deg/h/sqrt(h)", "ug/sqrt(h)", "count/sqrt(s)", unit::deg_per_h / 60, unit::ug / 60},
     {"Q", "quantization", &NoiseFit::Q, "arcsec", "um/s", "count s", unit::arcsec, 1e-6},
     {"R", "ramp", &NoiseFit::R, "deg/h/h", "ug/h", "count/s", unit::deg_per_h / unit::hour, unit::ug / unit::hour}}};

struct SizedUnit {
  double size;
  std::string name;
};

SizedUnit unit_of(const NoiseTerm& term, const std::string& of_axis) {
  if (of_axis == "count") return {1, term.count_unit};
  return of_axis == "rad/s" ? SizedUnit{term.gyro_size, term.gyro_unit} : SizedUnit{term.accel_size, term.accel_unit};
}

/// "12.3  95 % interval 11.9 to 12.7", or a bound, in columns.
std::string value_columns(const NoiseCoefficient& c, double size) {
  if (!c.determined) return fmt::format("{:>10}  {:<21}", "-", "below " + text::number(c.upper / size, 2));
  const double sigma = c.standard_uncertainty / size;
  return fmt::format("{:>10}  {:<21}", text::to_digits_of(sigma, c.value / size),
                     fmt::format("{} to {}", text::to_digits_of(sigma, c.lower / size), text::to_digits_of(sigma, c.upper / size)));
}

std::string term_row(const NoiseTerm& term, const NoiseAxis& axis) {
  const SizedUnit unit = unit_of(term, axis.unit);
  return fmt::format("  {:<8} {}  {} {}\n", axis.name, term.name, value_columns((*axis.fit).*term.member, unit.size), unit.name);
}

/// Where the terms' rows are in BatchAxis::coefficients.
constexpr std::size_t batch_place[] = {1, 2, 3, 0, 4};

/// Sigmas and amplitudes have the unit of B.
constexpr std::size_t rate_term = 1;

/// Rows of processes, filter, lines and steps of an axis.
std::string other_rows(const NoiseAxis& axis) {
  const SizedUnit rate = unit_of(noise_terms[rate_term], axis.unit);
  std::string out;
  const auto row = [&](const char* name, const NoiseCoefficient& c, double size, const std::string& unit) {
    out += fmt::format("  {:<8} {:<14} {} {}\n", axis.name, name, value_columns(c, size), unit);
  };
  for (const MarkovTerm& term : axis.fit->markov) {
    row("Markov sigma", term.sigma, rate.size, rate.name);
    row("       time", term.time, 1, "s");
  }
  for (const NoiseLine& line : axis.fit->lines) row(fmt::format("at {} Hz", text::number(line.hz, 5)).c_str(), line.amplitude, rate.size, rate.name);
  if (axis.fit->low_pass) row(fmt::format("low-pass, {}.", axis.fit->low_pass->order).c_str(), axis.fit->low_pass->cutoff_hz, 1, "Hz");
  if (axis.fit->resolution > 0)
    out += fmt::format("  {:<8} {:<14} {:>10}  {:<21} {}\n", axis.name, "readings' step", text::number(axis.fit->resolution / rate.size, 3), "",
                       rate.name);
  return out;
}

}  // namespace

std::string noise_text(const NoiseAnalysis& analysis) {
  std::string out = analysis.recording + "\n";
  for (const std::string& note : analysis.notes) out += text::wrapped("  ", note);
  out += "\n  axis     term     value  95 % interval         unit\n";
  for (const NoiseTerm& term : noise_terms)
    for (const NoiseAxis& axis : analysis.axes)
      if (axis.fit) out += term_row(term, axis);
  std::string others;
  for (const NoiseAxis& axis : analysis.axes)
    if (axis.fit) others += other_rows(axis);
  if (!others.empty()) out += "\n" + others;
  out += "\n";
  for (const NoiseTerm& term : noise_terms) out += fmt::format("  {}  {}\n", term.name, term.meaning);
  return out + text::wrapped("  ", "-  not determined by this log: zero is not excluded; the bound holds with 95 %");
}

std::string noise_text(const NoiseBatch& batch) {
  std::string out = fmt::format("{} logs\n", batch.logs.size());
  for (const NoiseAnalysis& log : batch.logs) out += fmt::format("  {}: {:.6g} s at rest\n", log.recording, log.end_s - log.begin_s);
  out += "\n  axis     term      mean  95 % interval         spread   worst    unit\n";
  for (std::size_t j = 0; j < noise_terms.size(); ++j)
    for (const BatchAxis& axis : batch.axes) {
      const BatchCoefficient& c = axis.coefficients[batch_place[j]];
      const SizedUnit unit = unit_of(noise_terms[j], axis.unit);
      out += fmt::format("  {:<8} {}  {} {:<8} {:<8} {}\n", axis.name, noise_terms[j].name, value_columns(c.mean, unit.size),
                         std::isnan(c.spread) ? "-" : text::number(c.spread / unit.size, 2), text::number(c.worst / unit.size, 2), unit.name);
    }
  out += "\n" + text::wrapped("  ", "mean: of the logs that determine the term; -: no log does, and the largest bound holds");
  return out + text::wrapped("  ", "spread: from log to log, beyond what the uncertainties explain; worst: the largest value or bound");
}

}  // namespace imulab
