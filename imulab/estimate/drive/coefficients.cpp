#include "imulab/estimate/drive/coefficients.hpp"

#include "imulab/coefficient.hpp"
#include "imulab/core/decomposition.hpp"
#include "imulab/estimate/drive/together.hpp"
#include "imulab/estimate/drive/unmodeled.hpp"
#include "imulab/estimate/kernel/slow_noise.hpp"
#include "imulab/model/frame_axes.hpp"

#include <Eigen/LU>

#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>

namespace imulab::drive {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

std::vector<CoefficientIndex> drive_coefficients() {
  std::vector<CoefficientIndex> out = select_each({"accel.offset", "accel.matrix", "gyro.offset", "gyro.matrix", "gyro.g_sensitivity"});
  std::erase_if(out, zero_by_frame);
  return out;
}

kernel::PriorSizes optional_sizes(const ImuDeclaration& imu) {
  ImuDeclaration of_grade = imu;
  of_grade.grade = imu.grade.value_or("mems");
  return kernel::optional_priors(of_grade);
}

aided::SensorPriors unit_priors(const ImuDeclaration& imu, const std::vector<CoefficientIndex>& chosen) {
  aided::SensorPriors out = aided::sensor_priors({}, imu);
  const Grade& g = grade(imu.grade.value_or("mems"));
  out.gyro_offset.setConstant(std::hypot(g.gyro_bias, g.gyro_noise.turn_on.value));
  out.accel_offset.setConstant(std::hypot(g.accel_bias, g.accel_noise.turn_on.value));
  out.g_sensitivity.setConstant(optional_sizes(imu).g_sensitivity);
  // A grade with ranges draws misalignments in the case frame, so those of the accelerometers also affect the gyros.
  if (g.ranges)
    out.gyro_matrix += (std::hypot(g.gyro_misalignment, g.accel_misalignment) - g.gyro_misalignment) * (Matrix3d::Ones() - Matrix3d::Identity());
  for (const CoefficientIndex index : coefficient_indices()) {
    if (contains(chosen, index)) continue;
    const Coefficient& c = coefficient(index);
    const bool accel = c.triad == Triad::accel;
    if (c.term == Term::offset) (accel ? out.accel_offset : out.gyro_offset)[c.row] = 0;
    if (c.term == Term::matrix) (accel ? out.accel_matrix : out.gyro_matrix)(c.row, c.column) = 0;
    if (c.term == Term::g_sensitivity) out.g_sensitivity(c.row, c.column) = 0;
  }
  return out;
}

namespace {

/// Converts a model with G and bg in place of C and W0 to C and W0.
SensorModel model_of(SensorModel constants) {
  constants.g_sensitivity = constants.g_sensitivity * constants.accel.matrix.inverse();
  constants.gyro.offset -= constants.g_sensitivity * constants.accel.offset;
  return constants;
}

/// Returns the index of a coefficient among the estimated ones, or -1.
Index place_of(const Calibration& c, Triad triad, Term term, int axis) {
  const auto at = std::ranges::find(c.estimated, coefficient_index(triad, term, axis, axis));
  return at == c.estimated.end() ? -1 : at - c.estimated.begin();
}

constexpr std::array triads{Triad::accel, Triad::gyro};

/// Returns true for an optional term or an effect that the unit has again in its next drive.
bool is_constant_of_unit(const AidedConstant& c) {
  if (is_effect(c.name)) return is_effect_of_unit(c.name);
  return of_unit(c) && is_optional(coefficient(coefficient_index(c.name)).term);
}

/// Returns P_xc S^-1 P_cx as Effects::constant_part does, for x = `by_constants` times the constants at `places`.
MatrixXd constant_part(const AidedNavigation& n, const MatrixXd& by_constants, const std::vector<Index>& places) {
  MatrixXd sum = MatrixXd::Zero(by_constants.rows(), by_constants.rows());
  for (std::size_t k = 0; k < n.constants.size(); ++k) {
    const AidedConstant& c = n.constants[k];
    if (!is_constant_of_unit(c) || !(c.prior > 0)) continue;
    const VectorXd by_prior = by_constants * n.constants_covariance(places, static_cast<Index>(k)) / c.prior;
    sum += by_prior * by_prior.transpose();
  }
  return sum;
}

}  // namespace

StatedUnit calibration_of(const AidedNavigation& n) {
  StatedUnit stated;
  Calibration& out = stated.calibration;
  out.method = "drive";
  out.frame = BodyFrame::accelerometers;
  out.model.accel.raw_unit = "m/s^2", out.model.gyro.raw_unit = "rad/s";
  std::vector<Index> places;
  SensorModel constants = out.model;
  for (std::size_t k = 0; k < n.constants.size(); ++k) {
    const AidedConstant& c = n.constants[k];
    if (!of_unit(c) || is_effect(c.name)) continue;
    const CoefficientIndex index = coefficient_index(c.name);
    set_coefficient(constants, index, coefficient_value(constants, index) + c.value);
    out.estimated.push_back(index), places.push_back(static_cast<Index>(k));
  }
  out.model = model_of(constants);
  // Central differences over one sigma are exact except for third derivatives.
  const Index coefficients = std::ssize(out.estimated);
  for (std::size_t k = 0; k < n.constants.size(); ++k)
    if (is_effect(n.constants[k].name)) places.push_back(static_cast<Index>(k));
  MatrixXd by_constants = MatrixXd::Identity(std::ssize(places), std::ssize(places));
  for (Index k = 0; k < coefficients; ++k) {
    const CoefficientIndex index = out.estimated[static_cast<std::size_t>(k)];
    const double value = coefficient_value(constants, index), step = n.constants[static_cast<std::size_t>(places[static_cast<std::size_t>(k)])].sigma;
    const auto at = [&](double moved) {
      SensorModel other = constants;
      set_coefficient(other, index, moved);
      return coefficient_values(model_of(other), out.estimated);
    };
    by_constants.col(k).head(coefficients) = (at(value + step) - at(value - step)) / (2 * step);
  }
  stated.joint = by_constants * n.constants_covariance(places, places) * by_constants.transpose();
  out.covariance = stated.joint.topLeftCorner(coefficients, coefficients);
  const MatrixXd constant = constant_part(n, by_constants, places).topLeftCorner(coefficients, coefficients);
  out.constant_covariance = limited_part(constant, out.covariance);
  return stated;
}

double wander(Triad triad, const Recording& recording, const ImuDeclaration& imu) {
  const NoiseModels noise = declared_terms(imu);
  constexpr double resolved = 100;  // s: time over which a drive determines an offset
  const double length = recording.time_s(recording.size() - 1) - recording.time_s(0), part = std::min(resolved, length);
  const MatrixXd variance =
      kernel::slow_noise({{(length - part) / 2, (length + part) / 2}}, triad == Triad::accel ? noise.accel : noise.gyro, recording.interval_s);
  return variance.size() > 0 ? variance(0, 0) : 0;
}

void add_to_offsets(Calibration& c, Triad triad, double variance) {
  for (int axis = 0; axis < 3; ++axis)
    if (const Index at = place_of(c, triad, Term::offset, axis); at >= 0) c.covariance(at, at) += variance;
}

void sort_by_table(Calibration& c) {
  std::vector<Index> order(c.estimated.size());
  std::iota(order.begin(), order.end(), Index{0});
  std::ranges::sort(order, {}, [&](Index k) { return c.estimated[static_cast<std::size_t>(k)]; });
  for (MatrixXd* const m : {&c.covariance, &c.constant_covariance}) *m = (*m)(order, order).eval();
  std::ranges::sort(c.estimated);
}

}  // namespace imulab::drive
