// Around the least squares of whole-unit calibration: what a parameter is worth, which are determined, which orders the data show.
#pragma once

#include "imulab/estimate/whole_unit_problem.hpp"
#include "imulab/model/calibration.hpp"

#include <vector>

namespace imulab {

/// How a coefficient takes part in a fit.
enum class Part {
  estimated,  ///< by the data alone
  weak,       ///< the data leave it open: it keeps its starting value, and what it may be (its prior) counts in the others' uncertainty
  absent,     ///< held at its starting value, which is taken as exact
};

/// What weak coefficients do in a fit. Offsets are always free within their prior: else other terms would have to explain them.
enum class Weak {
  held,  ///< at their starting values: the estimate. (Left to a prior, a scale that nothing excites would shrink to rid its row of noise.)
  free,  ///< within their priors: what is determined, and how well
};

/// A fit to convergence, and the sum of squares where it stands.
struct WholeUnitFit {
  SquareSum sum;
  Solution solution;
  bool converged = false;
};

/// Prior sigma of a coefficient: offsets and scales 20 % of the full range, misalignments 5 %, second and third orders three to a hundred times what
/// Dai's table 2 has (3e-4 /g and 6e-5 /g^2; 7.5e-4 /(deg/s) and 1e-7 /(deg/s)^2), g-sensitivity 1e-3 (rad/s)/(m/s^2), thermal drift over the
/// readings' range (of at least 10 K) 0.15 g and 15 deg/s.
class WholeUnitPrior {
 public:
  WholeUnitPrior(const WholeUnitProblem& problem, const SensorModel& start);
  const SensorModel& mean() const { return mean_; }
  double sigma(int index) const;
  /// Below this the data determine it: offsets and scales to 1 % of the range, others to half of their prior.
  double needed(int index) const;

 private:
  SensorModel mean_;
  Vector3d scale_[2];
  double full_scale_[2], thermal_range_[2];
  bool thermal_excited_[2];
};

Knowledge knowledge(const WholeUnitProblem& problem, const WholeUnitPrior& prior, const std::vector<Part>& parts, Weak weak);

/// Gauss-Newton until the correction is below a hundredth of its standard deviation everywhere.
WholeUnitFit converge(WholeUnitProblem& problem, const WholeUnitPrior& prior, const std::vector<Part>& parts, Weak weak = Weak::held);

/// Covariance where the fit stands, with what weak coefficients may be.
Eigen::MatrixXd covariance(const WholeUnitFit& fit, const WholeUnitProblem& problem, const WholeUnitPrior& prior, const std::vector<Part>& parts);

/// Which of `parts` the data determine: those estimated whose standard deviation under all priors is too large become weak.
std::vector<Part> determined(const WholeUnitProblem& problem, const WholeUnitPrior& prior, std::vector<Part> parts);

/// Choice among orders: a group of coefficients goes if it is not significant (1 %) and points left out (ten parts) are not predicted worse without
/// it by more than chance would have it. The least significant goes first. Groups of what is estimated: cubic, quadratic, second-order thermal,
/// g-sensitivity, by triad.
std::vector<TermTest> choose_orders(const WholeUnitProblem& problem, const WholeUnitPrior& prior, std::vector<Part>& parts);

/// Drops points one by one while chance explains them with less than `level` shared among all; returns their names. Where that is more than one in
/// fifty, it is not the points that are wrong, and all stay.
std::vector<std::string> drop_outliers(WholeUnitProblem& problem, const WholeUnitPrior& prior, const std::vector<Part>& parts, double level);

}  // namespace imulab
