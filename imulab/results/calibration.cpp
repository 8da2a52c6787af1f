#include "imulab/results/calibration.hpp"

#include "imulab/calibrate.hpp"
#include "imulab/calibration.hpp"
#include "imulab/coefficient.hpp"
#include "imulab/estimate/method.hpp"
#include "imulab/files.hpp"
#include "imulab/finding_code.hpp"
#include "imulab/formats/text/figures.hpp"
#include "imulab/formats/text/printable.hpp"
#include "imulab/model/relative_uncertainty.hpp"
#include "imulab/results/conclusion.hpp"
#include "imulab/rig/rig_errors.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

namespace imulab {
namespace {

using text::to_digits_of;
using text::two_digits;
using text::two_ends;
using text::wrapped;

std::string detail_rows(const Calibration& calibration) {
  std::string text = fmt::format("  {:<21} {:>13} {:>8} {:>11} {:>7} {}\n", "coefficient", "value (SI)", "u", "user unit", "u", "unit");
  for (const CoefficientIndex index : calibration.estimated) {
    const double value = coefficient_value(calibration.model, index), sigma = *standard_uncertainty(calibration, index);
    const UserValue user = user_value(calibration, index);
    text += fmt::format("  {} {:>8.2g} {:>11} {:>7} {}\n", two_ends(coefficient(index).name, fmt::format("{:.7g}", value), 35), sigma,
                        to_digits_of(user.uncertainty, user.value), two_digits(user.uncertainty), user.unit);
  }
  return text;
}

/// Cheng's table 1, in user units.
std::string correction_rows(const Calibration& calibration, const SensorModel& coarse) {
  std::string text = fmt::format("  {:<21} {:>13} {:>12} {:>13} {}\n", "coefficient", "coarse", "correction", "value", "unit");
  for (const CoefficientIndex index : calibration.estimated) {
    const UserValue before = user_value(calibration, index, coarse), after = user_value(calibration, index);
    const auto digits = [&](double value) { return to_digits_of(after.uncertainty, value); };
    text += fmt::format("  {} {:>12} {:>13} {}\n", two_ends(coefficient(index).name, digits(before.value), 35), digits(after.value - before.value),
                        digits(after.value), after.unit);
  }
  return text;
}

/// Optional terms that the data did not show: tested and not kept.
bool is_hidden(const Calibration& calibration, const Coefficient& c) {
  const std::vector<TermTest>& tests = calibration.quality.term_tests;
  const std::string name = fmt::format("{}.{}", to_string(c.triad), to_string(c.term));
  return std::any_of(tests.begin(), tests.end(), [&](const TermTest& test) { return test.term == name && !test.kept; });
}

std::string coefficient_rows(const Calibration& calibration) {
  std::string text = fmt::format("  {:<21} {:>14} {:>12}  {}\n", "coefficient", "value", "u", "unit");
  for (const CoefficientIndex index : calibration.estimated) {
    if (is_hidden(calibration, coefficient(index)) || !is_result(calibration, index)) continue;
    const UserValue user = user_value(calibration, index);
    text += fmt::format("  {} {:>12}  {}\n", two_ends(coefficient(index).name, to_digits_of(user.uncertainty, user.value), 36),
                        two_digits(user.uncertainty), user.unit);
  }
  return text;
}

/// What is known by its prior alone: optional terms, and others.
std::string hidden_text(const Calibration& calibration) {
  std::string names;
  for (const TermTest& test : calibration.quality.term_tests)
    if (!test.kept) names += (names.empty() ? "" : ", ") + test.term;
  std::string priors;
  for (const CoefficientIndex index : calibration.estimated)
    if (const Coefficient& c = coefficient(index); !is_hidden(calibration, c) && !is_result(calibration, index))
      priors += (priors.empty() ? "" : ", ") + std::string(c.name);
  return (names.empty() ? "" : wrapped("  ", "not significant; their priors are included in the uncertainties: " + names)) +
         (priors.empty() ? "" : wrapped("  ", "not determined, as uncertain as before the data: " + priors));
}

std::string effect_text(const EffectEstimate& effect) {
  const std::size_t k = clearest_axis(effect);
  return fmt::format("{} ({} {}, u = {})", effect.name, to_digits_of(effect.sigma[k], effect.values[k]), effect.unit, two_digits(effect.sigma[k]));
}

/// The effects that are significant, or the others.
std::string effects_text(const Quality& quality, bool significant) {
  std::string names;
  for (const EffectEstimate& effect : quality.effects)
    if (effect.significant == significant) names += (names.empty() ? "" : ", ") + effect_text(effect);
  if (names.empty()) return names;
  return wrapped("  ", (significant ? "significant effects besides the model, the clearest axis: "
                                    : "effects that are not significant, but included in the uncertainties: ") +
                           names);
}

std::string second_opinion_text(const Quality& quality) {
  if (!quality.second_opinion) return "";
  const SecondOpinion& other = *quality.second_opinion;
  return wrapped("  ",
                 fmt::format("second opinion, by the method {} on the same data: at most {:.1f} standard deviations of the difference apart ({})",
                             other.method, std::abs(other.sigmas), other.coefficient));
}

std::string term_test_text(const TermTest& test) {
  if (test.degrees_of_freedom == 0) return wrapped("  ", test.term + ": not observable; its prior is included in the uncertainties");
  std::string validation;
  if (test.cross_validation_with > 0)
    validation = fmt::format("; held-out points are missed by {:.3g} sigma with it, {:.3g} without", test.cross_validation_with,
                             test.cross_validation_without);
  return wrapped("  ", fmt::format("{}: {} (chi2 {:.4g} with {} degree{} of freedom, p = {:.2g}{})", test.term,
                                   test.kept ? "significant" : "not significant; its prior is included in the uncertainties", test.statistic,
                                   test.degrees_of_freedom, test.degrees_of_freedom == 1 ? "" : "s", test.p_value, validation));
}

std::string requirements_text(const Calibration& calibration) {
  std::string text;
  for (const RequirementResult& r : calibration.quality.requirements)
    text += wrapped(text.empty() ? "  required        " : "                  ", judged_text(r));
  return text;
}

std::string fit_text(const Calibration& calibration) {
  const Quality& quality = calibration.quality;
  if (quality.degrees_of_freedom == 0) return "  fit             no degree of freedom is left beside the effects\n";
  const bool rig = calibration.frame == BodyFrame::rig;
  std::string text =
      wrapped("  fit             ", fmt::format("chi2 per degree of freedom {:.3g} against {} ({} degrees of freedom)", quality.chi2_per_dof,
                                                rig ? "the noise and the declared rig errors" : "the noise alone", quality.degrees_of_freedom));
  if (quality.rotation_residual_deg)
    text += fmt::format("  check           rotations left out of the fit are predicted to {} deg RMS\n", two_digits(*quality.rotation_residual_deg));
  return text;
}

}  // namespace

std::string next_switch_on_text(const Calibration& calibration) {
  std::string worst;
  for (const char* triad : {"accel.offset", "gyro.offset"}) {
    const std::string text = worst_text(triad, [&](CoefficientIndex index) {
      const auto next = calibration.next_switch_on.find(std::string(coefficient(index).name));
      const double u = standard_uncertainty(calibration, index).value_or(NAN);
      return next == calibration.next_switch_on.end()
                 ? NAN
                 : std::hypot(judged_uncertainty(calibration, index), std::sqrt(next->second * next->second - u * u));
    });
    if (!text.empty()) worst += (worst.empty() ? "" : ", ") + std::string(triad) + " " + text;
  }
  return worst;
}

std::size_t clearest_axis(const EffectEstimate& effect) {
  std::size_t best = 0;
  for (std::size_t k = 1; k < effect.values.size(); ++k)
    if (std::abs(effect.values[k]) * effect.sigma[best] > std::abs(effect.values[best]) * effect.sigma[k]) best = k;
  return best;
}

bool is_assumption(const Finding& f) { return f.code == Code::effect_assumed || f.code == Code::latitude_assumed; }

std::string curves_csv(const CalibrationResult& result) {
  std::string text = "t";
  for (const ConvergenceCurve& curve : result.curves) text += fmt::format(",{0},{0}.sigma", curve.name);
  text += "\n";
  for (std::size_t i = 0; i < result.curve_time.size(); ++i) {
    text += fmt::format("{:.3f}", result.curve_time[i]);
    for (const ConvergenceCurve& curve : result.curves) text += fmt::format(",{:.9g},{:.4g}", curve.residual[i], curve.sigma[i]);
    text += "\n";
  }
  return text;
}

namespace {

/// For what a good calibration is not good.
std::string undetermined_text(const Calibration& calibration) {
  std::size_t linear = 0, results = 0;
  for (const CoefficientIndex index : calibration.estimated)
    if (const Term term = coefficient(index).term; term == Term::offset || term == Term::matrix) ++linear, results += is_result(calibration, index);
  return linear == results ? "" : fmt::format("; not determined: {} of {} biases, scale factors and misalignments", linear - results, linear);
}

}  // namespace

Conclusion conclusion_of(const Calibration& calibration) {
  const Quality& q = calibration.quality;
  std::string headline = "the file does not say how good the calibration is";
  if (q.verdict == Verdict::good) headline = "nothing contradicts the stated uncertainties" + undetermined_text(calibration);
  if (q.verdict == Verdict::doubtful) headline = fmt::format("{}", fmt::join(q.findings.reasons(), "; "));
  Conclusion out = conclude(q.verdict, std::move(headline), q.requirements);
  out.requirements.clear();
  return out;
}

std::string calibration_document(const Calibration& calibration) {
  return with_conclusion(calibration_text(calibration), conclusion_of(calibration), calibration.quality.findings.warnings(), ConclusionPlace::end);
}

std::string calibration_summary(const Calibration& calibration) {
  std::string text = wrapped("", conclusion_text(conclusion_of(calibration))) + "\n";
  text += reached_text([&](CoefficientIndex index) { return judged_uncertainty(calibration, index); });
  if (const std::string next = next_switch_on_text(calibration); !next.empty()) text += wrapped("  next switch-on  ", next);
  text += fit_text(calibration) + requirements_text(calibration);
  text += "\n" + wrapped("", fmt::format("{}{}method {}, frame: {}", excerpt(calibration.imu), calibration.imu.empty() ? "" : ", ",
                                         excerpt(calibration.method), to_string(calibration.frame)));
  if (calibration.clock) text += wrapped("", "seconds of the gyros: " + clock_text(calibration.clock));
  text += "\n" + coefficient_rows(calibration) + hidden_text(calibration) + effects_text(calibration.quality, true);
  for (const Finding& f : calibration.quality.findings)
    if (is_assumption(f)) text += wrapped("  ", f.text);
  return text;
}

std::string calibration_details(const Calibration& calibration, const SensorModel* coarse) {
  const Quality& quality = calibration.quality;
  std::string text = detail_rows(calibration) + "\n";
  if (coarse) text += correction_rows(calibration, *coarse) + "\n";
  for (const Finding& f : quality.findings)
    if (f.severity == Severity::note && !is_assumption(f)) text += wrapped("  ", f.text);
  for (const UncertaintySource& source : quality.sources) text += wrapped("  ", source.consequence);
  for (const TermTest& test : quality.term_tests) text += term_test_text(test);
  text += effects_text(quality, false) + second_opinion_text(quality);
  return text + fmt::format("  condition of the scaled normal equations {:.3g}\n", quality.condition);
}

double judged_uncertainty(const Calibration& calibration, CoefficientIndex index) {
  if (!is_result(calibration, index)) return NAN;
  const Coefficient& c = coefficient(index);
  const TriadModel& triad = triad_model(calibration.model, c.triad);
  if (c.term != Term::offset || triad.raw_unit != "count") return relative_uncertainty(calibration, index);
  return raw_zero(calibration, c.triad).uncertainty[c.row] * std::abs(triad.matrix(c.row, c.row));
}

std::string worst_text(std::string_view selector, const std::function<double(CoefficientIndex)>& sigma) {
  double worst = -1;
  UserUnit unit{};
  for (const CoefficientIndex index : select_coefficients(selector)) {
    const double own = sigma(index);
    if (!std::isfinite(own) || own <= worst) continue;
    worst = own;
    unit = user_unit(coefficient(index), own);
  }
  return worst < 0 ? "" : fmt::format("{} {}", text::two_digits(worst / unit.size), unit.name);
}

std::string_view name_of_off_diagonal(std::string_view triad, const std::function<double(CoefficientIndex)>& sigma) {
  return std::isfinite(sigma(coefficient_index(std::string(triad) + ".matrix.xy"))) ? "misalignment" : "nonorthogonality";
}

std::string worst_terms(std::string_view triad, const std::function<double(CoefficientIndex)>& sigma) {
  std::string line;
  const std::array<std::array<std::string_view, 2>, 3> kinds{
      {{"scale", "matrix.diagonal"}, {name_of_off_diagonal(triad, sigma), "matrix.off_diagonal"}, {"bias", "offset"}}};
  for (const auto& [what, term] : kinds)
    if (const std::string worst = worst_text(fmt::format("{}.{}", triad, term), sigma); !worst.empty())
      line += fmt::format("{}{} {}", line.empty() ? "" : ", ", what, worst);
  return line;
}

std::string worst_rows(const std::function<double(CoefficientIndex)>& sigma) {
  std::string lines;
  for (const auto& [name, triad] : {std::pair{"accelerometers", "accel"}, std::pair{"gyros", "gyro"}}) {
    const std::string line = worst_terms(triad, sigma);
    if (!line.empty()) lines += text::wrapped(fmt::format("  {:<15} ", name), line);
  }
  return lines;
}

std::string reached_text(const std::function<double(CoefficientIndex)>& sigma) {
  const std::string rows = worst_rows(sigma);
  return rows.empty() ? rows : rows + "                  (standard uncertainty of the worst axis)\n";
}

}  // namespace imulab
