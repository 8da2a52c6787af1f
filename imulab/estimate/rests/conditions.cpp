#include "imulab/estimate/rests/conditions.hpp"

#include "imulab/core/statistics.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

namespace imulab::rests {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

namespace {

/// Squared residuals of one kind divided by the redundancy of their rows, and their variances without the spread.
struct KindResiduals {
  std::vector<double> squares, variances;
  double degrees = 0;

  KindResiduals(const Conditions& conditions, const Adjustment& adjustment, Kind kind, double current_spread) {
    for (Index i = 0; i < conditions.value.size(); ++i) {
      const double variance = adjustment.variance[i], redundancy = adjustment.residual_variance[i] / variance;
      if (conditions.kind[static_cast<std::size_t>(i)] != kind || redundancy < 1e-3) continue;  // the fit follows such a row: it is uninformative
      squares.push_back(adjustment.residual[i] * adjustment.residual[i] / redundancy);
      variances.push_back(std::max(variance - current_spread * current_spread, 1e-12 * variance));
      degrees += redundancy;
    }
  }
  bool enough() const { return squares.size() >= 3 && degrees >= 1; }
};

/// Returns the parameters on which some rows depend.
std::vector<Index> columns_of(const Eigen::Ref<const MatrixXd>& rows) {
  std::vector<Index> columns;
  for (Index j = 0; j < rows.cols(); ++j)
    if ((rows.col(j).array() != 0).any()) columns.push_back(j);
  return columns;
}

/// Rows with coupled noise, and the parameters on which they depend. The coupling ends where motion is missing, and the next stretch has parameters
/// of its own. The rows of a stretch therefore depend on few of the parameters.
struct Stretch {
  Index first = 0, size = 0;
  std::vector<Index> columns;
};

/// Visits a stretch in pieces, given by first row and number of rows, to avoid copies of a matrix with the rests of a day.
template <class Each>
void for_each_piece(const Stretch& stretch, const Each& each) {
  constexpr Index rows = 1024;
  for (Index begin = 0; begin < stretch.size; begin += rows) each(stretch.first + begin, std::min(rows, stretch.size - begin));
}

std::vector<Stretch> stretches_of(const Conditions& conditions) {
  std::vector<Stretch> out;
  for (const CovarianceBlock& block : conditions.blocks) {
    if (out.empty() || block.coupling.size() == 0) out.push_back({block.first, 0, {}});
    out.back().size += block.size;
  }
  for (Stretch& s : out) s.columns = columns_of(conditions.jacobian.middleRows(s.first, s.size));
  return out;
}

}  // namespace

double Conditions::log_determinant() const {
  double out = 0;
  whitened(blocks, MatrixXd(value.size(), 0), &out);
  return out;
}

kernel::Information Conditions::information() const {
  MatrixXd joined(value.size(), jacobian.cols() + 1);
  joined << jacobian, value;
  const MatrixXd white = whitened(blocks, std::move(joined));
  kernel::Information all(jacobian.cols());
  for (const Stretch& s : stretches_of(*this)) {
    kernel::Information own;
    for_each_piece(s, [&](Index begin, Index size) {
      const auto rows = white.middleRows(begin, size);
      own += kernel::Information(rows(Eigen::all, s.columns), rows.col(jacobian.cols()));
    });
    all.N(s.columns, s.columns) += own.N;
    all.g(s.columns) += own.g;
    all.chi2 += own.chi2, all.rows += own.rows;
  }
  return all;
}

Adjustment adjust(const Conditions& conditions, kernel::Parameters parameters) {
  std::replace(parameters.role.begin(), parameters.role.end(), kernel::Role::considered, kernel::Role::fixed);
  Adjustment out{kernel::solve(conditions.information(), parameters, "the rests"), {}, variances(conditions.blocks), {}};
  out.residual = conditions.value + conditions.jacobian * out.solution.x;
  VectorXd fitted = VectorXd::Zero(conditions.value.size());
  for (const Stretch& s : stretches_of(conditions)) {
    const MatrixXd covariance = out.solution.covariance(s.columns, s.columns);
    for_each_piece(s, [&](Index begin, Index size) {
      const MatrixXd jacobian = conditions.jacobian.middleRows(begin, size)(Eigen::all, s.columns);
      fitted.segment(begin, size) = (jacobian * covariance).cwiseProduct(jacobian).rowwise().sum();
    });
  }
  out.residual_variance = (out.variance - fitted).cwiseMax(1e-9 * out.variance);  // rounding, if the fit follows a row
  return out;
}

double redundancy(const Conditions& conditions, const Adjustment& adjustment, Kind kind) {
  double sum = 0;
  for (Index i = 0; i < conditions.value.size(); ++i)
    if (conditions.kind[static_cast<std::size_t>(i)] == kind) sum += adjustment.residual_variance[i] / adjustment.variance[i];
  return sum;
}

bool spread_is_significant(const Conditions& conditions, const Adjustment& adjustment, Kind kind) {
  // With few rests, a spread as large as the sample noise is rarely significant, but uncertainties without it would be too small; with a spurious one
  // (p = 1/6) they are slightly too large. Deviations below a tenth do not matter. Verified on simulated sessions with and without drift.
  constexpr double level = 1.0 / 6, least_ratio = 1.2;
  const KindResiduals r(conditions, adjustment, kind, 0);
  if (!r.enough()) return false;
  const double ratio = mean_ratio(r.squares, r.variances);
  return ratio > least_ratio && chi_square_tail(ratio * r.degrees, r.degrees) < level;
}

double estimate_spread(const Conditions& conditions, const Adjustment& adjustment, Kind kind, double current) {
  const KindResiduals r(conditions, adjustment, kind, current);
  if (!r.enough()) return 0;
  // Deviations relative to a spread from n degrees of freedom follow Student's t with variance n / (n - 2).
  std::vector<double> squares = r.squares;
  for (double& square : squares) square *= r.degrees / std::max(1.0, r.degrees - 2);
  return std::sqrt(additional_variance(squares, r.variances));
}

kernel::Deviation deviation_of(const Conditions& conditions, const Adjustment& adjustment, const std::vector<Index>& rows) {
  const MatrixXd unfitted = part_of(conditions.blocks, rows);
  const std::vector<Index> columns = columns_of(conditions.jacobian(rows, Eigen::all));
  const MatrixXd jacobian = conditions.jacobian(rows, columns);
  return kernel::deviation(adjustment.residual(rows), unfitted - jacobian * adjustment.solution.covariance(columns, columns) * jacobian.transpose(),
                           unfitted);
}

}  // namespace imulab::rests
