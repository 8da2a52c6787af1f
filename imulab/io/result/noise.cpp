#include "imulab/io/result/noise.hpp"

#include "imulab/core/units.hpp"
#include "imulab/io/result/fields.hpp"
#include "imulab/io/text/figures.hpp"

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

constexpr double hour = unit::hour;
const std::array<NoiseTerm, 5> noise_terms{
    {{"N", "white noise (random walk of angle, velocity)", &NoiseFit::N, "deg/sqrt(h)", "ug/sqrt(Hz)", "count/sqrt(Hz)", unit::deg_per_sqrt_h,
      unit::ug_per_sqrt_hz},
     {"B", "bias instability (flicker)", &NoiseFit::B, "deg/h", "ug", "count", unit::deg_per_h, unit::ug},
     {"K", "random walk of the bias", &NoiseFit::K, "deg/h/sqrt(h)", "ug/sqrt(h)", "count/sqrt(s)", unit::deg_per_h / 60, unit::ug / 60},
     {"Q", "quantization", &NoiseFit::Q, "arcsec", "um/s", "count s", unit::arcsec, 1e-6},
     {"R", "ramp", &NoiseFit::R, "deg/h/h", "ug/h", "count/s", unit::deg_per_h / hour, unit::ug / hour}}};

std::string term_row(const NoiseTerm& term, const NoiseAxis& axis) {
  const NoiseCoefficient& c = (*axis.fit).*term.member;
  const bool gyro = axis.unit == "rad/s", count = axis.unit == "count";
  const double size = count ? 1 : gyro ? term.gyro_size : term.accel_size;
  const std::string unit = count ? term.count_unit : gyro ? term.gyro_unit : term.accel_unit;
  if (!c.determined)
    return fmt::format("  {:<8} {}  {:>10}  {:<21} {}\n", axis.name, term.name, "-", "below " + text::number(c.upper / size, 2), unit);
  const double sigma = c.standard_uncertainty / size;
  return fmt::format("  {:<8} {}  {:>10}  {:<21} {}\n", axis.name, term.name, text::to_digits_of(sigma, c.value / size),
                     fmt::format("{} to {}", text::to_digits_of(sigma, c.lower / size), text::to_digits_of(sigma, c.upper / size)), unit);
}

JsonObject coefficient_fields(const NoiseCoefficient& c) {
  return {{{{{"value", c.value},
             {"standard_uncertainty", c.standard_uncertainty},
             {"lower", c.lower},
             {"upper", c.upper},
             {"determined", c.determined}}}}};
}

JsonFields axis_fields(const NoiseAxis& axis) {
  std::vector<double> tau, deviation, terms, noise_type, edf, lower, upper, lower_68, upper_68;
  for (const DeviationPoint& p : axis.deviation) {
    tau.push_back(p.tau), deviation.push_back(p.deviation), terms.push_back(static_cast<double>(p.terms));
    noise_type.push_back(p.noise_type), edf.push_back(p.edf);
    lower.push_back(p.lower_95), upper.push_back(p.upper_95), lower_68.push_back(p.lower_68), upper_68.push_back(p.upper_68);
  }
  JsonFields out{{{"name", axis.name},
                  {"unit", axis.unit},
                  {"tau", tau},
                  {"deviation", deviation},
                  {"terms", terms},
                  {"noise_type", noise_type},
                  {"edf", edf},
                  {"lower", lower},
                  {"upper", upper},
                  {"lower_68", lower_68},
                  {"upper_68", upper_68}}};
  if (!axis.fit) {
    out.fields.emplace_back("problem", axis.problem);
    return out;
  }
  JsonFields coefficients;
  for (const NoiseTerm& term : noise_terms) coefficients.fields.emplace_back(term.name, coefficient_fields((*axis.fit).*term.member));
  std::vector<JsonFields> misfits;
  for (const NoiseMisfit& m : axis.fit->misfits) misfits.push_back({{{"low_hz", m.low_hz}, {"high_hz", m.high_hz}, {"ratio", m.ratio}}});
  out.fields.emplace_back("coefficients", JsonObject{{coefficients}});
  out.fields.emplace_back("fit", JsonObject{{{{{"chi2_per_dof", axis.fit->chi2_per_dof},
                                               {"accepted", axis.fit->accepted},
                                               {"highest_hz", axis.fit->highest_hz},
                                               {"misfits", misfits}}}}});
  return out;
}

}  // namespace

const char* to_string(DeviationKind kind) {
  switch (kind) {
    case DeviationKind::allan:
      return "allan";
    case DeviationKind::modified_allan:
      return "modified-allan";
    case DeviationKind::hadamard:
      return "hadamard";
    case DeviationKind::overlapping_hadamard:
      return "overlapping-hadamard";
    case DeviationKind::total:
      return "total";
    default:
      return "overlapping-allan";
  }
}

std::string noise_text(const NoiseAnalysis& analysis) {
  std::string out = analysis.recording + "\n";
  for (const std::string& note : analysis.notes) out += text::wrapped("  ", note);
  out += "\n  axis     term     value  95 % interval         unit\n";
  for (const NoiseTerm& term : noise_terms)
    for (const NoiseAxis& axis : analysis.axes)
      if (axis.fit) out += term_row(term, axis);
  out += "\n";
  for (const NoiseTerm& term : noise_terms) out += fmt::format("  {}  {}\n", term.name, term.meaning);
  return out + text::wrapped("  ", "-  not determined by this log: zero is not excluded; the bound holds with 95 %");
}

std::string noise_json(const NoiseAnalysis& analysis) {
  std::vector<JsonFields> axes;
  for (const NoiseAxis& axis : analysis.axes) axes.push_back(axis_fields(axis));
  const JsonObject still{{{{{"begin_s", analysis.begin_s}, {"end_s", analysis.end_s}, {"samples", std::uint64_t{analysis.samples}}}}}};
  return fields_json({{{"format", std::string("imulab.noise/1")},
                       {"recording", analysis.recording},
                       {"interval_s", analysis.interval_s},
                       {"still", still},
                       {"deviation", std::string(to_string(analysis.kind))},
                       {"axes", axes},
                       {"notes", analysis.notes},
                       {"warnings", analysis.warnings}}});
}

}  // namespace imulab
