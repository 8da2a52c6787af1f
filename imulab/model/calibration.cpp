#include "imulab/calibration.hpp"

#include "imulab/error.hpp"
#include "imulab/units.hpp"

#include <Eigen/LU>
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

namespace imulab {

std::string_view to_string(BodyFrame frame) { return frame == BodyFrame::rig ? "rig" : "accelerometers"; }

std::string clock_text(const std::optional<ClockScale>& clock) {
  if (!clock) return "";
  const double gain = clock->gain / unit::ppm, sigma = clock->sigma / unit::ppm;
  const std::string known =
      std::abs(gain) > 5 * sigma ? fmt::format("which gains {:.3g} ppm (u = {:.2g} ppm)", gain, sigma) : fmt::format("u = {:.2g} ppm", sigma);
  return clock->seconds == "true" ? fmt::format("true seconds, by the recording's clock, {}", known)
                                  : fmt::format("the recording's own, {}, not part of the scales' u", known);
}

std::string verdict_text(const Quality& quality) {
  std::string text(to_string(quality.verdict));
  const std::vector<std::string> reasons = quality.findings.reasons();
  return reasons.empty() ? text : fmt::format("{}, because {}", text, fmt::join(reasons, "; "));
}

std::vector<std::string> unusable(const Calibration& calibration) {
  const std::vector<std::string>& undetermined = calibration.quality.unobservable;
  std::vector<std::string> names;
  for (const CoefficientIndex index : coefficient_indices()) {
    const Coefficient& c = coefficient(index);
    if (c.term != Term::offset && c.term != Term::matrix) continue;
    const TriadModel& triad = triad_model(calibration.model, c.triad);
    // Counts have no scale of their own that could replace one that was not estimated.
    const bool needed = triad.raw_unit == "count" && c.row == c.column && !calibration.estimated.empty();
    const bool estimated = standard_uncertainty(calibration, index).has_value();
    if (std::find(undetermined.begin(), undetermined.end(), c.name) != undetermined.end() || (needed && !estimated)) names.emplace_back(c.name);
  }
  return names;
}

namespace {

std::string size_problem(const Calibration& c) {
  const Eigen::Index n = std::ssize(c.estimated);
  if (c.covariance.rows() == n && c.covariance.cols() == n) return "";
  return fmt::format("the covariance is {} x {}; expected {} x {}, a row and a column a coefficient that was estimated", c.covariance.rows(),
                     c.covariance.cols(), n, n);
}

/// Returns a fault of the covariance or a part of it; rounding is judged relative to the whole covariance.
std::string covariance_problem(const Calibration& c, const Eigen::MatrixXd& p) {
  const auto name = [&](Eigen::Index i) { return coefficient(c.estimated[static_cast<std::size_t>(i)]).name; };
  for (Eigen::Index i = 0; i < p.rows(); ++i)
    if (!(p(i, i) >= 0 && std::isfinite(p(i, i)))) return fmt::format("the variance of {} is {:g}; expected 0 or more", name(i), p(i, i));
  for (Eigen::Index i = 0; i < p.rows(); ++i)
    for (Eigen::Index j = 0; j < i; ++j) {
      constexpr double rounding = 1e-9;  // far above the rounding of any program that computed the matrix
      const double scale = std::sqrt(c.covariance(i, i) * c.covariance(j, j));
      if (!(std::abs(p(i, j) - p(j, i)) <= rounding * scale)) return fmt::format("the covariance of {} and {} is not symmetric", name(i), name(j));
      if (!(std::abs(p(i, j)) <= (1 + rounding) * scale)) return fmt::format("{} and {} are correlated by more than 1", name(i), name(j));
    }
  return "";
}

std::string constant_problem(const Calibration& c) {
  const Eigen::MatrixXd& part = c.constant_covariance;
  if (part.size() == 0) return "";
  if (part.rows() != c.covariance.rows() || part.cols() != c.covariance.cols()) return "the constant part of the covariance is not of its size";
  constexpr double rounding = 1e-9;
  for (Eigen::Index i = 0; i < part.rows(); ++i)
    if (part(i, i) > (1 + rounding) * c.covariance(i, i))
      return fmt::format("the constant part of the variance of {} is larger than all of it",
                         coefficient(c.estimated[static_cast<std::size_t>(i)]).name);
  return covariance_problem(c, part);
}

}  // namespace

void validate(const Calibration& c) {
  std::vector<std::string> problems = problems_of(c.estimated);
  const bool known = problems.empty();
  if (std::string size = size_problem(c); !size.empty())
    problems.push_back(std::move(size));
  else if (std::string wrong = known ? covariance_problem(c, c.covariance) : ""; !wrong.empty())
    problems.push_back(std::move(wrong));
  else if (std::string of_part = known ? constant_problem(c) : ""; !of_part.empty())
    problems.push_back(std::move(of_part));
  const std::vector<std::string> of_model = problems_of(c.model);
  problems.insert(problems.end(), of_model.begin(), of_model.end());
  throw_problems("the calibration", problems);
}

std::optional<double> standard_uncertainty(const Calibration& calibration, CoefficientIndex index) {
  if (const std::string problem = size_problem(calibration); !problem.empty()) throw Error("the calibration: " + problem);
  coefficient(index);  // throws for an invalid index
  const auto& estimated = calibration.estimated;
  const auto found = std::find(estimated.begin(), estimated.end(), index);
  if (found == estimated.end()) return std::nullopt;
  const auto i = found - estimated.begin();
  return std::sqrt(calibration.covariance(i, i));
}

RawZero raw_zero(const Calibration& calibration, Triad triad) {
  validate(calibration);
  const TriadModel& model = triad_model(calibration.model, triad);
  const Matrix3d inverse = model.matrix.inverse();
  RawZero zero{-inverse * model.offset, Vector3d::Constant(std::numeric_limits<double>::quiet_NaN())};
  // dB = -A1^-1 (dA0 + dA1 B)
  Eigen::MatrixXd jacobian = Eigen::MatrixXd::Zero(3, static_cast<Eigen::Index>(calibration.estimated.size()));
  for (std::size_t i = 0; i < calibration.estimated.size(); ++i) {
    const Coefficient& c = coefficient(calibration.estimated[i]);
    if (c.triad != triad || (c.term != Term::offset && c.term != Term::matrix)) continue;
    jacobian.col(static_cast<Eigen::Index>(i)) = -inverse.col(c.row) * (c.term == Term::offset ? 1.0 : zero.value[c.column]);
  }
  const Eigen::MatrixXd covariance = jacobian * calibration.covariance * jacobian.transpose();
  for (int axis = 0; axis < 3; ++axis)
    if (standard_uncertainty(calibration, coefficient_index(triad, Term::offset, axis, axis)))
      zero.uncertainty[axis] = std::sqrt(covariance(axis, axis));
  return zero;
}

}  // namespace imulab
