#include "imulab/navigation/budget/coefficient_effects.hpp"

#include "imulab/core/error.hpp"
#include "imulab/model/coefficient.hpp"

namespace imulab::budget {
namespace {

/// Directions of an effect, by columns: an output axis, and what an accelerometer's or a raw reading's axis does through the model.
enum Direction { axis = 0, leak = 3, accel_reading = 6, accel_reading_leak = 9, gyro_reading = 12, direction_count = 15 };
/// Scalars of a sample: one, powers 1 to 3 of the raw readings V, the force, powers 1 and 2 of the thermal readings.
enum Scalar { one = 0, accel_power = 1, gyro_power = 10, force_component = 19, accel_thermal = 22, gyro_thermal = 28, scalar_count = 34 };

bool ideal(const TriadModel& m) {
  return m.offset.isZero(0) && m.matrix.isIdentity(0) && m.quadratic.isZero(0) && m.cubic.isZero(0) && m.thermal.isZero(0);
}

Matrix3d slope(const TriadModel& m, const Vector3d& v) {
  return m.matrix + Matrix3d((2 * m.quadratic.cwiseProduct(v) + 3 * m.cubic.cwiseProduct(v.cwiseAbs2())).asDiagonal());
}

Vector3d without_drift(const Vector3d& reading, const TriadModel& m, const Vector3d& tau) {
  return reading - m.thermal.col(0) - (m.thermal.col(1) + m.thermal.col(2).cwiseProduct(tau)).cwiseProduct(tau);
}

int scalar_of(const Coefficient& c) {
  const int power = c.triad == Triad::accel ? accel_power : gyro_power;
  switch (c.term) {
    case Term::offset:
      return one;
    case Term::matrix:
      return power + c.column;
    case Term::quadratic:
      return power + 3 + c.row;
    case Term::cubic:
      return power + 6 + c.row;
    case Term::thermal:
      return (c.triad == Triad::accel ? accel_thermal : gyro_thermal) + 3 * (c.column - 1) + c.row;
    case Term::g_sensitivity:
      return force_component + c.column;
    case Term::lever_arm:
      break;
  }
  throw Error(std::string(c.name) + ": the compensation of single samples has no lever arms: their errors cannot be followed");
}

}  // namespace

CoefficientEffects::CoefficientEffects(const SensorModel& model, const std::vector<CoefficientIndex>& coefficients, const Vector3d& accel_tau,
                                       const Vector3d& gyro_tau)
    : model_(model), plain_(ideal(model.accel) && ideal(model.gyro) && model.g_sensitivity.isZero(0)), accel_tau_(accel_tau), gyro_tau_(gyro_tau) {
  const bool leaks = !model.g_sensitivity.isZero(0);
  const auto n = static_cast<Eigen::Index>(coefficients.size());
  for (Eigen::Index k = 0; k < n; ++k) {
    const Coefficient& c = coefficient(coefficients[static_cast<std::size_t>(k)]);
    const bool thermal = c.term == Term::thermal;
    const int scalar = scalar_of(c);
    if (c.triad == Triad::gyro) rate_effects_.push_back({k, scalar, (thermal ? gyro_reading : axis) + c.row});
    if (c.triad == Triad::accel) force_effects_.push_back({k, scalar, (thermal ? accel_reading : axis) + c.row});
    if (c.triad == Triad::accel && leaks) rate_effects_.push_back({k, scalar, (thermal ? accel_reading_leak : leak) + c.row});
  }
  rate_.setZero(3, n);
  force_.setZero(3, n);
}

void CoefficientEffects::clear() {
  rate_.setZero();
  force_.setZero();
}

void CoefficientEffects::add(const Matrix3d& C_nb, const Motion& motion, double interval) {
  Eigen::Matrix<double, 3, direction_count> direction;
  Eigen::Matrix<double, scalar_count, 1> scalar;
  direction.middleCols<3>(axis) = C_nb;
  const RawSample raw = plain_ ? RawSample{motion.force, motion.rate} : decompensate(model_, motion, accel_tau_, gyro_tau_);
  const Vector3d a = without_drift(raw.accel, model_.accel, accel_tau_), w = without_drift(raw.gyro, model_.gyro, gyro_tau_);
  if (!plain_) {
    direction.middleCols<3>(leak) = C_nb * model_.g_sensitivity;
    direction.middleCols<3>(accel_reading) = -C_nb * slope(model_.accel, a);
    direction.middleCols<3>(accel_reading_leak) = -direction.middleCols<3>(leak) * slope(model_.accel, a);
    direction.middleCols<3>(gyro_reading) = -C_nb * slope(model_.gyro, w);
  } else {
    direction.middleCols<3>(accel_reading) = direction.middleCols<3>(gyro_reading) = -C_nb;
  }
  scalar[one] = 1;
  scalar.segment<9>(accel_power) << a, a.cwiseAbs2(), a.cwiseAbs2().cwiseProduct(a);
  scalar.segment<9>(gyro_power) << w, w.cwiseAbs2(), w.cwiseAbs2().cwiseProduct(w);
  scalar.segment<3>(force_component) = motion.force;
  scalar.segment<6>(accel_thermal) << accel_tau_, accel_tau_.cwiseAbs2();
  scalar.segment<6>(gyro_thermal) << gyro_tau_, gyro_tau_.cwiseAbs2();
  scalar *= interval;
  for (const Effect& e : rate_effects_) rate_.col(e.coefficient) += scalar[e.scalar] * direction.col(e.direction);
  for (const Effect& e : force_effects_) force_.col(e.coefficient) += scalar[e.scalar] * direction.col(e.direction);
}

}  // namespace imulab::budget
