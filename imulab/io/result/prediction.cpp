#include "imulab/io/result/prediction.hpp"

#include "imulab/estimate/hybrid/path_design.hpp"
#include "imulab/model/coefficient.hpp"
#include "imulab/model/user_unit.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>

namespace imulab {
namespace {

/// One unit for all coefficients of a term, by the largest of them.
UserUnit unit_of(CoefficientIndex index, const std::vector<CoefficientIndex>& coefficients, const Eigen::VectorXd& sigma) {
  const Coefficient& c = coefficient(index);
  double largest = 0;
  for (std::size_t k = 0; k < coefficients.size(); ++k)
    if (coefficient(coefficients[k]).triad == c.triad && coefficient(coefficients[k]).term == c.term)
      largest = std::max(largest, sigma[static_cast<Eigen::Index>(k)]);
  return user_unit(c, largest);
}

/// A source's name as the two lines of a narrow column's head.
std::array<std::string, 2> heading(const std::string& source) {
  if (source == "orthogonality") return {"", "orth."};
  if (source == "gravity") return {"", "g"};
  if (source == "latitude") return {"", "lat."};
  if (source == "earth rate") return {"Earth", "rate"};
  if (source == "gyro noise") return {"gyro", "noise"};
  if (source == "accelerometer noise") return {"acc.", "noise"};
  if (source == "gyro turn-on") return {"gyro", "turn-on"};
  if (source == "accelerometer turn-on") return {"acc.", "turn-on"};
  if (source == turntable::undetermined_source) return {"not", "determ."};
  return {"", source};
}

/// The sampled sigmas in sigmas of the closed form, less what the Monte Carlo does not draw.
Eigen::ArrayXd sampled_ratio(const turntable::Prediction& p, const turntable::MonteCarloResult& monte_carlo) {
  Eigen::ArrayXd variance = p.sigma.array().square();
  for (std::size_t k = 0; k < p.sources.size(); ++k)
    if (p.sources[k] == turntable::undetermined_source) variance -= p.variance.col(static_cast<Eigen::Index>(k)).array();
  return monte_carlo.sigma.array() / variance.sqrt();
}

std::size_t width_of(const std::string& source) {
  const auto head = heading(source);
  return std::max<std::size_t>({5, head[0].size(), head[1].size()});
}

std::string heading_lines(const turntable::Prediction& p, bool second, bool monte_carlo) {
  std::string text;
  for (const std::size_t line : {0u, 1u}) {
    text += fmt::format("{:<21} {:<7}", line == 0 ? "" : "coefficient", line == 0 ? "" : "unit");
    if (second) text += fmt::format(" {:>9} {:>9}", line == 0 ? "first" : "order", line == 0 ? "second" : "order");
    text += fmt::format(" {:>9}", line == 0 ? "closed" : "form");
    if (monte_carlo) text += fmt::format(" {:>9}", line == 0 ? "Monte" : "Carlo");
    text += "  |";
    for (const std::string& source : p.sources) text += fmt::format(" {:>{}}", heading(source)[line], width_of(source));
    text += "\n";
  }
  return text;
}

std::string monte_carlo_text(const turntable::Prediction& p, const turntable::MonteCarloResult& monte_carlo, bool undetermined) {
  const Eigen::ArrayXd off = (sampled_ratio(p, monte_carlo) - 1).abs();
  Eigen::Index worst;
  const double most = off.maxCoeff(&worst);
  return fmt::format("\nMonte Carlo: {} procedures{}. At most {:.1f} % from the closed form ({}), where one sigma of chance is {:.1f} %.\n",
                     monte_carlo.runs, undetermined ? ", without what is not determined" : "", 100 * most,
                     coefficient(p.coefficients[static_cast<std::size_t>(worst)]).name, 100 * monte_carlo.sampling_sigma[worst]);
}

/// The least that any of the requirements allows it; none: 0.
double limit_of(CoefficientIndex index, const std::vector<Requirement>& requirements) {
  double limit = 0;
  for (const Requirement& r : requirements)
    if (std::find(r.coefficients.begin(), r.coefficients.end(), index) != r.coefficients.end())
      limit = limit > 0 ? std::min(limit, r.limit) : r.limit;
  return limit;
}

}  // namespace

std::string prediction_table(const turntable::Prediction& p, const std::optional<turntable::MonteCarloResult>& monte_carlo) {
  if (p.coefficients.empty()) return {};
  const Eigen::VectorXd sigma = p.sigma, first = p.first_order();
  const bool second = (p.second_order.array() > 0.03 * first.array()).any();  // below, it changes nothing a person reads
  std::string text = "Standard uncertainty of every coefficient, and the share of each source in its variance (%)\n\n";
  text += heading_lines(p, second, monte_carlo.has_value());
  for (std::size_t i = 0; i < p.coefficients.size(); ++i) {
    const auto row = static_cast<Eigen::Index>(i);
    const UserUnit unit = unit_of(p.coefficients[i], p.coefficients, sigma);
    text += fmt::format("{:<21} {:<7}", coefficient(p.coefficients[i]).name, unit.name);
    if (second) text += fmt::format(" {:>9.4g} {:>9.2g}", first[row] / unit.size, p.second_order[row] / unit.size);
    text += fmt::format(" {:>9.4g}", sigma[row] / unit.size);
    if (monte_carlo) text += fmt::format(" {:>9.4g}", monte_carlo->sigma[row] / unit.size);
    text += "  |";
    for (std::size_t k = 0; k < p.sources.size(); ++k)
      text += fmt::format(" {:>{}.1f}", 100 * p.variance(row, static_cast<Eigen::Index>(k)) / (first[row] * first[row]), width_of(p.sources[k]));
    text += "\n";
  }
  if (second)
    text += "\nSecond order: sigma of the products of errors. The closed form contains it, the shares do not; calibrate subtracts its mean.\n";
  const bool undetermined = std::find(p.sources.begin(), p.sources.end(), turntable::undetermined_source) != p.sources.end();
  if (undetermined) text += "\nNot determ.: effect of coefficients that the procedure does not determine and that keep their starting values.\n";
  return monte_carlo ? text + monte_carlo_text(p, *monte_carlo, undetermined) : text;
}

std::string prediction_table(const Prediction& p, const std::vector<Requirement>& requirements) {
  std::string text = fmt::format("{:<21} {:<13} {:>9}{}\n", "coefficient", "unit", "sigma", requirements.empty() ? "" : "  required   ratio");
  for (std::size_t i = 0; i < p.coefficients.size(); ++i) {
    const UserUnit unit = unit_of(p.coefficients[i], p.coefficients, p.sigma);
    const double sigma = p.sigma[static_cast<Eigen::Index>(i)], limit = limit_of(p.coefficients[i], requirements);
    text += fmt::format("{:<21} {:<13} {:>9.4g}", coefficient(p.coefficients[i]).name, unit.name, sigma / unit.size);
    if (limit > 0) text += fmt::format("  {:>8.4g} {:>7.3f}", limit / unit.size, sigma / limit);
    text += std::find(p.considered.begin(), p.considered.end(), p.coefficients[i]) == p.considered.end() ? "\n" : "  its prior\n";
  }
  for (std::size_t i = 0; i < p.undetermined.size(); ++i) {
    const Coefficient& c = coefficient(p.undetermined[i]);
    const UserUnit unit = user_unit(c, 0);
    const std::string remaining = p.remaining.size() > 0 ? fmt::format("{:.4g}", p.remaining[static_cast<Eigen::Index>(i)] / unit.size) : "";
    text += fmt::format("{:<21} {:<13} {:>9}  not determined\n", c.name, unit.name, remaining);
  }
  if (!p.considered.empty()) text += "\nIts prior: the procedure says nothing of the term, which counts in the others with its prior.\n";
  for (const std::string& note : p.notes) text += fmt::format("\n{}\n", note);
  return text;
}

std::string turns_text(const hybrid::Advice& advice) {
  std::string text;
  for (const std::string& turn : advice.turns) text += (text.empty() ? "" : ", then ") + turn;
  return text + ", and rest";
}

std::string advice_text(const hybrid::Advice& advice) {
  std::string worst;
  for (const CoefficientIndex index : advice.coefficients) worst += fmt::format(" {}", coefficient(index).name);
  return fmt::format("Worst determined:{}\nWhat helps most after the procedure: {}\n", worst, turns_text(advice));
}

std::string shortfall_text(const Shortfall& s) {
  const auto name = coefficient(s.coefficient).name;
  if (!std::isfinite(s.sigma)) return fmt::format("{} is not determined", name);
  const UserUnit& unit = s.requirement.unit;
  return fmt::format("{} has {:.4g} {} where {:g} {} is required", name, s.sigma / unit.size, unit.name, s.requirement.limit / unit.size, unit.name);
}

std::string path_table(const hybrid::Path& path) {
  const std::vector<std::string> words = rig::in_words(path.turns);
  std::string text = fmt::format("rest {:g} s\n", path.first_rest);
  for (std::size_t k = 0; k < path.turns.size(); ++k)
    text += fmt::format("{:>3}  {:<6} {:>+5g} deg  rest {:>3g} s   {}\n", k + 1, to_string(path.turns[k].axis), path.turns[k].angle_deg,
                        path.turns[k].rest, words[k]);
  return text;
}

}  // namespace imulab
