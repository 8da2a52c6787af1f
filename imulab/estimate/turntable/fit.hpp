// A turntable fit: determines weights and linearization from the readings, detects a reversed axis, and leaves out wrong steps.
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

inline constexpr double unlikely = 1e-3;  ///< p-value below which a deviation is significant

/// The data to fit, and the declarations.
struct TableProblem {
  TableProblem(TableObservations seen, RigDeclaration rig, ImuDeclaration imu, Site site);
  TableObservations seen;
  RigDeclaration rig;
  ImuDeclaration imu;
  Site site;
  TableMotion motion;
  Eigen::MatrixXd accel_slow_noise, gyro_slow_noise;  ///< declared slow noise of each part's mean or integral on one axis, in the unit of the noise
};

/// A fit of a problem, which must outlive it. Each of its parts (holds, then turns) may be wrong.
struct Fit {
  const TableProblem* problem;
  EstimatorOptions options;
  Estimator estimator;
  Eigen::VectorXd readings;  ///< linearized readings
  SensorModel model;
  double chi2;
  bool converged;  ///< the last pass changed no coefficient by more than its uncertainty, so the next change would be a small part of it

  double log_probability() const;  ///< returns the log p-value of the residuals
  std::vector<kernel::Suspect> suspects() const;
  /// Returns true if the part may be left out. At most a fifth of the parts and a third of the turns may: more are another motion, not outliers.
  bool may_drop(std::size_t part) const;
  Fit without(std::size_t part) const;
};

/// Fits a problem. The first weights use the sensors' noise only; then the model propagates the table's errors to raw readings, and the motion is
/// linearized about the estimated table errors. Throws Unsupported if the readings do not follow the motion.
Fit fit(const TableProblem& problem, const EstimatorOptions& options);

/// Returns the fit with the most likely enlargement of noise and table errors, at most by the factor `most`.
Fit enlarged(const Fit& fit, double most = HUGE_VAL);

/// Describes which axis turns in the other direction if the readings contradict the steps; else empty.
std::string reversed_axis(const Fit& fit);

/// Leaves parts out if the others then agree (`worst` is empty). Otherwise noise or table are worse than declared, and all parts stay.
kernel::Cleaned<Fit> without_outliers(const Fit& fit, double level);

/// Returns the coefficients for `wanted` (CalibrationOptions::terms); empty: offsets, matrices and g-sensitivity. The forward model keeps a matrix
/// whole or diagonal, and other terms whole. Throws TermsError.
std::vector<CoefficientIndex> chosen_coefficients(const std::vector<CoefficientIndex>& wanted, std::string_view accel_unit,
                                                  std::string_view gyro_unit);

/// Returns the options with every optional term under its prior.
EstimatorOptions with_optional_terms(EstimatorOptions options, const ImuDeclaration& imu);

}  // namespace imulab::turntable
