#include "imulab/estimate/kernel/fit.hpp"

#include "imulab/core/decomposition.hpp"
#include "imulab/core/statistics.hpp"

namespace imulab::kernel {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

double Deviation::log_probability(double residual_degrees) const {
  if (degrees_of_freedom == 0) return 0;
  if (std::isinf(residual_degrees)) return log_chi_square_tail(chi2, degrees_of_freedom);
  return std::log(std::max(f_tail(chi2 / degrees_of_freedom, degrees_of_freedom, residual_degrees), 1e-300));
}

double Deviation::evidence() const {
  const double degrees = degrees_of_freedom;
  return chi2 > degrees && degrees > 0 ? 0.5 * (chi2 - degrees - degrees * std::log(chi2 / degrees)) : 0;
}

Deviation deviation(const VectorXd& residual, const MatrixXd& covariance, const MatrixXd& unfitted) {
  Deviation out;
  if (residual.size() == 0) return out;
  const Cholesky unit(unfitted);
  const SymmetricEigen spectrum = symmetric_eigen(unit.solve_lower(MatrixXd(unit.solve_lower(covariance).transpose())));
  const VectorXd along = spectrum.vectors.transpose() * unit.solve_lower(residual);
  for (Index i = 0; i < along.size(); ++i) {
    if (spectrum.values[i] < 1e-6) continue;
    out.chi2 += along[i] * along[i] / spectrum.values[i];
    ++out.degrees_of_freedom;
  }
  return out;
}

}  // namespace imulab::kernel
