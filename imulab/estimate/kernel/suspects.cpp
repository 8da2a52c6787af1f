#include "imulab/estimate/kernel/suspects.hpp"

#include "imulab/core/statistics.hpp"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>

namespace imulab::kernel {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

double Deviation::log_probability() const { return degrees_of_freedom == 0 ? 0 : log_chi_square_tail(chi2, degrees_of_freedom); }

Deviation deviation(const VectorXd& residual, const MatrixXd& covariance, const MatrixXd& unfitted) {
  Deviation out;
  const Eigen::LLT<MatrixXd> unit(unfitted);
  const MatrixXd left = unit.matrixL().solve(covariance);
  const Eigen::SelfAdjointEigenSolver<MatrixXd> spectrum(MatrixXd(unit.matrixL().solve(left.transpose())));
  const VectorXd along = spectrum.eigenvectors().transpose() * unit.matrixL().solve(residual);
  for (Index i = 0; i < along.size(); ++i) {
    if (spectrum.eigenvalues()[i] < 1e-6) continue;
    out.chi2 += along[i] * along[i] / spectrum.eigenvalues()[i];
    ++out.degrees_of_freedom;
  }
  return out;
}

}  // namespace imulab::kernel
