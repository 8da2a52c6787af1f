#include "imulab/core/statistics.hpp"

#ifdef __wasm__  // whose long double has 128 bits, in software: slow and large
#define BOOST_MATH_PROMOTE_DOUBLE_POLICY false
#endif
#include <boost/math/distributions/binomial.hpp>
#include <boost/math/distributions/chi_squared.hpp>
#include <boost/math/distributions/fisher_f.hpp>
#include <boost/math/distributions/normal.hpp>
#include <boost/math/distributions/students_t.hpp>

#include <algorithm>
#include <cmath>
#include <limits>

namespace imulab {

namespace bm = boost::math;

namespace {

/// No residual that is a number is as large as what is none.
bool is_number(double square) { return square <= std::numeric_limits<double>::max(); }

}  // namespace

double quantile(std::vector<double> values, double p) {
  if (values.empty()) return std::numeric_limits<double>::quiet_NaN();
  const double position = p * static_cast<double>(values.size() - 1);
  const auto low = static_cast<std::size_t>(position);
  const auto at = values.begin() + static_cast<std::ptrdiff_t>(low);
  std::nth_element(values.begin(), at, values.end());
  const double a = *at;
  if (low + 1 == values.size()) return a;
  const double b = *std::min_element(at + 1, values.end());
  return a + (position - static_cast<double>(low)) * (b - a);
}

double median(std::vector<double> values) { return quantile(std::move(values), 0.5); }

double robust_sigma(const std::vector<double>& values) {
  const double center = median(values);
  std::vector<double> deviations;
  deviations.reserve(values.size());
  for (const double v : values) deviations.push_back(std::abs(v - center));
  return 1.4826 * median(std::move(deviations));
}

double mean_ratio(const std::vector<double>& squares, const std::vector<double>& variances, double additional) {
  double sum = 0;
  for (std::size_t i = 0; i < squares.size(); ++i) sum += squares[i] / (variances[i] + additional);
  return sum / static_cast<double>(squares.size());
}

double additional_variance(const std::vector<double>& squares, const std::vector<double>& variances) {
  if (!(mean_ratio(squares, variances) > 1)) return 0;
  double low = 0, high = 10 * *std::max_element(squares.begin(), squares.end());
  for (int i = 0; i < 60; ++i) {
    const double middle = 0.5 * (low + high);
    (mean_ratio(squares, variances, middle) > 1 ? low : high) = middle;
  }
  return 0.5 * (low + high);
}

double normal_quantile(double p) { return bm::quantile(bm::normal(), p); }
double student_quantile(double p, double dof) { return std::isinf(dof) ? normal_quantile(p) : bm::quantile(bm::students_t(dof), p); }
double chi_square_quantile(double p, double dof) { return bm::quantile(bm::chi_squared(dof), p); }
double chi_square_tail(double x, double dof) {
  if (!is_number(x)) return 0;
  // P(chi2 < x) < (e x / dof)^(dof / 2) < 1e-78: nothing beside 1. There Boost's gamma function overflows (1.74, with more than 3,500 degrees of
  // freedom; where a long double is a double, with more than 340).
  if (dof > 100 && x < 0.01 * dof) return 1;
  return bm::cdf(bm::complement(bm::chi_squared(dof), std::max(x, 0.0)));
}
double log_chi_square_tail(double x, double dof) {
  if (!is_number(x)) return -std::numeric_limits<double>::infinity();
  const double tail = chi_square_tail(x, dof);
  if (tail > 0) return std::log(tail);
  return -0.5 * x + (0.5 * dof - 1) * std::log(0.5 * x) - std::lgamma(0.5 * dof);  // the first term of the expansion far out
}
double f_tail(double f, double dof_1, double dof_2) {
  if (!is_number(f)) return 0;
  return bm::cdf(bm::complement(bm::fisher_f(dof_1, dof_2), std::max(f, 0.0)));
}
double binomial_quantile(double p, double trials, double probability) { return bm::quantile(bm::binomial(trials, probability), p); }

}  // namespace imulab
