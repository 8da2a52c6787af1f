// A turntable fit: weights and linearization from the readings themselves, a reversed axis recognized, wrong steps left out.
#pragma once

#include "imulab/estimate/kernel/fit.hpp"
#include "imulab/estimate/turntable/estimator.hpp"
#include "imulab/rig/table_plan.hpp"
#include "imulab/session.hpp"

#include <cmath>
#include <string>
#include <string_view>
#include <vector>

namespace imulab::turntable {

inline constexpr double unlikely = 1e-3;  ///< probability below which a deviation is not chance

/// The data to fit, and the declarations.
struct TableProblem {
  TableProblem(TableObservations seen, RigDeclaration rig, ImuDeclaration imu, Site site);
  TableObservations seen;
  RigDeclaration rig;
  ImuDeclaration imu;
  Site site;
  TableMotion motion;
  Eigen::MatrixXd accel_slow_noise, gyro_slow_noise;  ///< declared: of each part's mean or integral on one axis, in the unit of the noise
};

/// A fit of a problem, which outlives it. Of its parts (holds, then turns) any may be wrong.
struct Fit {
  const TableProblem* problem;
  EstimatorOptions options;
  Estimator estimator;
  Eigen::VectorXd readings;  ///< linearized
  SensorModel model;
  double chi2;
  bool converged;  ///< the last pass moved no coefficient by more than its uncertainty: a next one would move it by a small part of that

  double log_probability() const;  ///< of chance leaving residuals as large
  std::vector<kernel::Suspect> suspects() const;
  /// A fifth of the parts and a third of the turns may go: more are not outliers but another motion.
  bool may_drop(std::size_t part) const;
  Fit without(std::size_t part) const;
};

/// Sensors' noise alone sets the first weights; then the table's errors are brought to raw readings with the model found, and the motion is linear
/// about the table errors found. Throws Unsupported where the readings do not follow the motion.
Fit fit(const TableProblem& problem, const EstimatorOptions& options);

/// With the noise and the table's errors as much larger than declared as is most likely, at most by the factor `most`.
Fit enlarged(const Fit& fit, double most = HUGE_VAL);

/// Where the readings contradict the steps: which axis turns the other way, in words. Empty if none.
std::string reversed_axis(const Fit& fit);

/// Leaves parts out if that makes the others agree, with an empty `worst`. If not, the noise or the table is worse than declared: all parts stay.
kernel::Cleaned<Fit> without_outliers(const Fit& fit, double level);

/// `wanted` as CalibrationOptions::terms; empty: offsets, matrices and g-sensitivity. The forward model keeps a matrix whole or diagonal, and the
/// other terms whole. Throws TermsError.
std::vector<CoefficientIndex> chosen_coefficients(const std::vector<CoefficientIndex>& wanted, std::string_view accel_unit,
                                                  std::string_view gyro_unit);

/// The options with every term that an IMU may have, under its prior.
EstimatorOptions with_optional_terms(EstimatorOptions options, const ImuDeclaration& imu);

}  // namespace imulab::turntable
