#include "imulab/results/prediction.hpp"

#include "imulab/coefficient.hpp"
#include "imulab/estimate/prediction.hpp"
#include "imulab/formats/text/figures.hpp"
#include "imulab/formats/text/terminal.hpp"
#include "imulab/model/effects.hpp"
#include "imulab/plan.hpp"
#include "imulab/results/calibration.hpp"
#include "imulab/results/shares.hpp"
#include "imulab/rig/pose_on_table.hpp"
#include "imulab/rig/rig_errors.hpp"
#include "imulab/units.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <string>
#include <utility>

namespace imulab {

double sigma_of(CoefficientIndex index, const std::vector<CoefficientIndex>& coefficients, const Eigen::VectorXd& sigma) {
  const auto at = std::find(coefficients.begin(), coefficients.end(), index) - coefficients.begin();
  return at < sigma.size() ? sigma[at] : std::numeric_limits<double>::quiet_NaN();
}

UserUnit unit_of(CoefficientIndex index, const std::vector<CoefficientIndex>& coefficients, const Eigen::VectorXd& sigma) {
  const Coefficient& c = coefficient(index);
  double largest = 0;
  for (std::size_t k = 0; k < coefficients.size(); ++k)
    if (coefficient(coefficients[k]).triad == c.triad && coefficient(coefficients[k]).term == c.term)
      largest = std::max(largest, sigma[static_cast<Eigen::Index>(k)]);
  return user_unit(c, largest, TriadModel{});
}

namespace {

/// The sampled sigmas in sigmas of the closed form, less what the Monte Carlo does not draw.
Eigen::ArrayXd sampled_ratio(const Prediction& p, const MonteCarloResult& monte_carlo) {
  Eigen::ArrayXd variance = p.sigma.array().square();
  for (std::size_t k = 0; k < p.sources.size(); ++k)
    if (p.sources[k] == undetermined_source) variance -= p.variance.col(static_cast<Eigen::Index>(k)).array();
  return monte_carlo.sigma.array() / variance.sqrt();
}

/// A source in one line of a narrow column: "gyro noise", "orth.", "acc. asym.".
std::string short_name(const std::string& source) {
  constexpr std::size_t column = 10;
  const auto [first, second] = column_head(source);
  if (first.empty()) return source.size() <= column ? source : second;
  return first + " " + second;
}

/// In two columns; a long name takes room from the unit's.
std::string name_and_unit(CoefficientIndex index, const UserUnit& unit) {
  return fmt::format("{:<35}", fmt::format("{:<21} {}", coefficient(index).name, unit.name));
}

/// `named`: where each row's largest source is looked up; null: not named.
std::string share_rows(const Prediction& p, const Shares& shares, const Shares* named = nullptr) {
  std::string text;
  const auto width = [&](std::size_t k) { return named == nullptr ? 5 : std::max<std::size_t>(3, column_head(shares.sources[k])[1].size()); };
  for (const std::size_t line : {0u, 1u}) {
    std::string head = fmt::format("{:<21} {:<13} {:>7}", line == 0 ? "" : "coefficient", line == 0 ? "" : "unit", line == 0 ? "" : "sigma");
    for (std::size_t k = 0; k < shares.sources.size(); ++k) head += fmt::format(" {:>{}}", column_head(shares.sources[k])[line], width(k));
    if (named != nullptr && line == 1) head += " largest";
    head.erase(head.find_last_not_of(' ') + 1);
    if (!head.empty()) text += head + "\n";
  }
  for (std::size_t i = 0; i < p.coefficients.size(); ++i) {
    const auto row = static_cast<Eigen::Index>(i);
    const UserUnit unit = unit_of(p.coefficients[i], p.coefficients, p.sigma);
    text += fmt::format("{} {:>7}", name_and_unit(p.coefficients[i], unit), text::two_digits(p.sigma[row] / unit.size));
    for (std::size_t k = 0; k < shares.sources.size(); ++k)
      text += fmt::format(" {:>{}.0f}", shares.percent(row, static_cast<Eigen::Index>(k)), width(k));
    text += named != nullptr ? " " + short_name(largest_source(*named, row)) + "\n" : "\n";
  }
  return text;
}

/// The worst of each group, and where it was asked for, of an IMU of half and of twice the effects.
std::string summary_rows(const Prediction& p) {
  const auto of = [&](const Eigen::VectorXd& sigma) { return [&](CoefficientIndex index) { return sigma_of(index, p.coefficients, sigma); }; };
  std::string text = reached_text(of(p.sigma));
  const auto add = [&](const char* size, const Eigen::VectorXd& sigma) {
    if (sigma.size() > 0) text += fmt::format("\nIf the IMU's effects are {} as large as expected\n", size) + worst_rows(of(sigma));
  };
  add("half", p.sigma_of_half), add("twice", p.sigma_of_twice);
  return text;
}

/// Optional terms and the priors of their sizes.
std::string term_rows(const Prediction& p) {
  std::string text;
  for (const TermSource& term : p.terms) {
    const Coefficient& c = coefficient(term.first);
    const UserUnit unit = user_unit(c, term.prior, TriadModel{});
    const bool unseen = std::find(p.considered.begin(), p.considered.end(), term.first) != p.considered.end();
    text += fmt::format("  {:<18} prior {} {}{}\n", term.name, text::two_digits(term.prior / unit.size), unit.name,
                        unseen ? "; the procedure does not show it" : "");
  }
  return text.empty() ? "" : "\nTerms that the IMU may have, one sigma before the data:\n" + text;
}

/// First and second order, closed form and Monte Carlo, with all digits.
std::string sigma_rows(const Prediction& p) {
  const Eigen::VectorXd first = p.first_order();
  std::string text = fmt::format("\n{:<21} {:<13} {:>10} {:>12} {:>12}", "coefficient", "unit", "1st order", "2nd order", "closed form");
  text += p.monte_carlo ? fmt::format(" {:>11}\n", "Monte Carlo") : "\n";
  for (std::size_t i = 0; i < p.coefficients.size(); ++i) {
    const auto row = static_cast<Eigen::Index>(i);
    const UserUnit unit = unit_of(p.coefficients[i], p.coefficients, p.sigma);
    text += fmt::format("{} {:>10.4g} {:>12.2g} {:>12.4g}", name_and_unit(p.coefficients[i], unit), first[row] / unit.size,
                        p.second_order[row] / unit.size, p.sigma[row] / unit.size);
    text += p.monte_carlo ? fmt::format(" {:>11.4g}\n", p.monte_carlo->sigma[row] / unit.size) : "\n";
  }
  return text;
}

std::string monte_carlo_text(const Prediction& p, const MonteCarloResult& monte_carlo, bool undetermined) {
  const Eigen::ArrayXd off = (sampled_ratio(p, monte_carlo) - 1).abs();
  Eigen::Index worst;
  const double most = off.maxCoeff(&worst);
  return "\n" +
         text::wrapped("",
                       fmt::format("Monte Carlo: {} procedures{}. At most {:.1f} % from the closed form ({}), where one sigma of chance is {:.1f} %.",
                                   monte_carlo.runs, undetermined ? ", without what is not determined" : "", 100 * most,
                                   coefficient(p.coefficients[static_cast<std::size_t>(worst)]).name, 100 * monte_carlo.sampling_sigma[worst]));
}

/// The least that any of the requirements allows it; none: 0.
double limit_of(CoefficientIndex index, const std::vector<Requirement>& requirements) {
  double limit = 0;
  for (const Requirement& r : requirements)
    if (std::find(r.coefficients.begin(), r.coefficients.end(), index) != r.coefficients.end())
      limit = limit > 0 ? std::min(limit, r.limit) : r.limit;
  return limit;
}

std::string table_of_shares(const Prediction& p, bool details) {
  if (p.coefficients.empty()) return {};
  std::string text = summary_rows(p);
  const Shares each = all_shares(p);
  text += "\nStandard uncertainty of every coefficient, shares of its variance in percent,\nand the source with the largest share\n\n" +
          share_rows(p, by_group(each), &each);
  if (details)
    for (const Shares& part : in_columns(each)) text += "\n" + share_rows(p, part);
  if (details) text += sigma_rows(p);
  text += "\n" + text::wrapped("  ", fmt::format("{}. --verbose shows each source.", groups_text(p.sources))) + term_rows(p);
  if (std::any_of(p.sources.begin(), p.sources.end(), [](const std::string& source) { return find_effect(source) != nullptr; }))
    text += "\n" + text::wrapped("",
                                 "eff.: what an IMU and its mount may do besides the sensor model, as large as is expected of the grade or "
                                 "declared (docs/theory/effects.md).");
  if ((p.second_order.array() > 0.03 * p.first_order().array()).any())  // below, it changes nothing a person reads
    text +=
        "\n" + text::wrapped("", "The uncertainty contains products of errors (second order), the shares do not; calibrate subtracts their mean.");
  const bool undetermined = std::find(p.sources.begin(), p.sources.end(), undetermined_source) != p.sources.end();
  if (undetermined)
    text += "\n" + text::wrapped("", "not det.: effect of coefficients that the procedure does not determine and that keep their starting values");
  return p.monte_carlo ? text + monte_carlo_text(p, *p.monte_carlo, undetermined) : text;
}

}  // namespace

std::string prediction_table(const Prediction& p, const std::vector<Requirement>& requirements, bool details) {
  if (!p.sources.empty()) return table_of_shares(p, details);
  std::string text = summary_rows(p);
  text += fmt::format("\n{:<21} {:<13} {:>9}{}\n", "coefficient", "unit", "sigma", requirements.empty() ? "" : "  required   ratio");
  for (std::size_t i = 0; i < p.coefficients.size(); ++i) {
    const UserUnit unit = unit_of(p.coefficients[i], p.coefficients, p.sigma);
    const StatedSigma stated = predicted(p, p.coefficients[i]);
    const double sigma = stated.sigma, limit = limit_of(p.coefficients[i], requirements);
    text += fmt::format("{} {:>9}", name_and_unit(p.coefficients[i], unit), text::two_digits(sigma / unit.size));
    if (limit > 0) text += fmt::format("  {:>8.4g} {:>7.3f}", limit / unit.size, stated.compared() / limit);
    text += std::find(p.considered.begin(), p.considered.end(), p.coefficients[i]) == p.considered.end() ? "\n" : "  its prior\n";
  }
  for (std::size_t i = 0; i < p.undetermined.size(); ++i) {
    const UserUnit unit = user_unit(coefficient(p.undetermined[i]), 0, TriadModel{});
    const std::string remaining = p.remaining.size() > 0 ? fmt::format("{:.4g}", p.remaining[static_cast<Eigen::Index>(i)] / unit.size) : "";
    text += fmt::format("{} {:>9}  not determined\n", name_and_unit(p.undetermined[i], unit), remaining);
  }
  if (!p.considered.empty())
    text += "\n" + text::wrapped("", "Its prior: the procedure does not show the term; its prior enters the other uncertainties.");
  for (const std::string& note : p.notes) text += "\n" + text::wrapped("", note);
  return text;
}

std::string turns_text(const Advice& advice) {
  std::string text;
  for (const std::string& turn : advice.turns) text += (text.empty() ? "" : ", then ") + turn;
  return text + ", and rest";
}

std::string advice_text(const Advice& advice) {
  std::string worst;
  for (const CoefficientIndex index : advice.coefficients) worst += fmt::format(" {}", coefficient(index).name);
  return text::wrapped("", "Worst determined:" + worst) + text::wrapped("", "What helps most after the procedure: " + turns_text(advice));
}

std::string shortfall_text(const Shortfall& s) {
  const auto name = coefficient(s.coefficient).name;
  if (!std::isfinite(s.sigma)) return fmt::format("{} is not determined", name);
  if (s.sigma <= s.requirement.limit) return fmt::format("{} has fewer than 3 degrees of freedom", name);
  const UserUnit& unit = s.requirement.unit;
  return fmt::format("{} has {:.4g} {} where {:g} {} is required", name, s.sigma / unit.size, unit.name, s.requirement.limit / unit.size, unit.name);
}

std::string prior_text(const PriorEffect& prior) {
  std::string text = fmt::format("with what {:.0f} units of {} say of it", prior.units, prior.fleet);
  if (std::isfinite(prior.duration_without)) text += "; without: " + text::minutes(prior.duration_without);
  return text;
}

std::string path_table(const TurnPath& path) {
  const std::vector<std::string> words = in_words(path.turns);
  std::string table = fmt::format("rest {:g} s\n", path.first_rest);
  for (std::size_t k = 0; k < path.turns.size(); ++k)
    table += text::wrapped(
        fmt::format("{:>3}  {:<6} {:>+5g} deg  rest {:>3g} s   ", k + 1, to_string(path.turns[k].axis), path.turns[k].angle_deg, path.turns[k].rest),
        words[k]);
  return table;
}

namespace {

/// Three digits, the last rounded down: still within a limit.
std::string rounded_down(double x) {
  if (x <= 0) return "0";
  const double step = std::pow(10, std::floor(std::log10(x)) - 2), rounded = step * std::floor(x / step + 1e-9);
  return x >= 100 && x < 1e7 ? fmt::format("{:.0f}", rounded) : fmt::format("{:.3g}", rounded);
}

/// With the source that has the largest share.
std::string requirement_text(const Shortfall& s) {
  const UserUnit& unit = s.requirement.unit;
  const std::string required = fmt::format("{} <= {:g} {}", s.requirement.selector, s.requirement.limit / unit.size, unit.name);
  const auto name = coefficient(s.coefficient).name;
  if (!std::isfinite(s.sigma)) return fmt::format("{}: the procedure does not determine {}", required, name);
  if (s.sigma <= s.requirement.limit) return fmt::format("{}: {}", required, shortfall_text(s));
  return fmt::format("{}: {} has {} {}, most of it from {}", required, name, text::number(s.sigma / unit.size), unit.name, s.source);
}

std::string table_text(const ErrorSizes& s) {
  const std::array<std::pair<const char*, double>, 3> parts{{{"angle", s.angle}, {"orthogonality", s.orthogonality}, {"zero", s.zero}}};
  std::string text;
  for (std::size_t k = 0; k < parts.size(); ++k) {
    if (parts[k].second == 0) continue;
    const bool shared = k + 1 < parts.size() && parts[k + 1].second == parts[k].second;
    text += parts[k].first + (shared ? std::string(", ") : fmt::format(" {} arcsec, ", rounded_down(parts[k].second / unit::arcsec)));
  }
  return text.substr(0, text.size() - 2);
}

std::string noise_text(const ErrorSizes& s) {
  std::string text = fmt::format("noise {} deg/sqrt(h) and {} ug/sqrt(Hz)", rounded_down(s.gyro_noise / unit::deg_per_sqrt_h),
                                 rounded_down(s.accel_noise / unit::ug_per_sqrt_hz));
  if (s.gyro_turn_on > 0 || s.accel_turn_on > 0)
    text += fmt::format(", turn-on {} deg/h and {} ug", rounded_down(s.gyro_turn_on / unit::deg_per_h), rounded_down(s.accel_turn_on / unit::ug));
  return text;
}

std::string setting_text(Knob knob, const ErrorSizes& s) {
  std::string timing = fmt::format("timing {} ms", rounded_down(1e3 * s.timing));
  if (knob == Knob::table) return table_text(s);
  if (knob == Knob::timing) return timing;
  if (knob == Knob::imu) return noise_text(s);
  return table_text(s) + "; " + timing + "; " + noise_text(s);
}

std::string title(Knob knob) {
  if (knob == Knob::table) return "coarsest table";
  if (knob == Knob::timing) return "longest timing error of a turn";
  if (knob == Knob::imu) return "noisiest unit";
  return "table, timing and unit together, all times one factor";
}

std::string answer(const char* first, Knob knob, const Tolerance& t) {
  if (t.factor)
    return text::wrapped(
        first, fmt::format("{}{} x declared: {}", t.unlimited ? "any, tried up to " : "", rounded_down(*t.factor), setting_text(knob, t.sizes)));
  std::string text = std::string(first) + "none: not even ";
  if (knob == Knob::table) text += "a perfect table";
  if (knob == Knob::timing) text += "perfect timing";
  if (knob == Knob::imu) text += "a hundredth of the noise";
  if (knob == Knob::all) text += "a hundredth of all";
  text += "\n";
  for (const Shortfall& s : t.shortfalls) text += text::wrapped("      ", requirement_text(s));
  return text;
}

}  // namespace

std::string tolerance_table(const Tolerances& tolerances, const std::vector<Shortfall>& missed) {
  std::string text = fmt::format("As declared, {}\n", missed.empty() ? "every requirement is met." : "these requirements are not met:");
  for (const Shortfall& s : missed) text += text::wrapped("  ", requirement_text(s));
  text += "\nWhat meets every requirement:\n";
  for (const Tolerances::Answer& a : tolerances.answers) {
    text += fmt::format("  {}\n", title(a.knob));
    if (a.knob == Knob::timing && !tolerances.has_turns) {
      text += "    the procedure has no turns\n";
      continue;
    }
    if (a.alone) text += answer("    all else perfect      ", a.knob, *a.alone);
    text += answer(a.alone ? "    all else as declared  " : "    ", a.knob, a.declared);
  }
  text += text::wrapped("", "Perfect: a millionth of the table's and the timing's errors, a hundredth of the noise, g and latitude exact.");
  const ErrorSizes& s = tolerances.declared;
  if ((s.angle == 0 && s.orthogonality == 0 && s.zero == 0) || s.timing == 0)
    text += "Where no error is declared, factors are those of 1 arcsec and 1 ms.\n";
  return text;
}

}  // namespace imulab
