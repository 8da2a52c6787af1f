#include "imulab/navigation/budget/specification.hpp"

#include "imulab/calibration.hpp"
#include "imulab/coefficient.hpp"
#include "imulab/error.hpp"
#include "imulab/grade.hpp"
#include "imulab/model/published_grades.hpp"

namespace imulab {

namespace {

/// Returns the specified size of a coefficient in the table.
Spread size_of(const Coefficient& c, const TriadErrors& t) {
  const Spread none;
  switch (c.term) {
    case Term::offset:
      return t.bias.value_or(none);
    case Term::matrix:
      if (c.row == c.column) return t.scale.value_or(none);
      if (t.nonorthogonality) return c.row > c.column ? *t.nonorthogonality : none;
      return t.misalignment.value_or(none);
    case Term::quadratic:
      return t.quadratic.value_or(none);
    case Term::g_sensitivity:
      return t.g_sensitivity.value_or(none);
    default:
      return none;
  }
}

void take(std::optional<Spread>& term, double sigma) {
  if (!term) term = Spread{sigma, false};
}

TriadErrors completed(TriadErrors t, double bias, double scale, const NoiseModel& noise) {
  take(t.bias, bias);
  take(t.scale, scale);
  if (!t.turn_on) t.turn_on = noise.turn_on;
  if (!t.R) t.R = noise.R;
  t.N = t.N.value_or(noise.N);
  t.B = t.B.value_or(noise.B);
  t.K = t.K.value_or(noise.K);
  t.Q = t.Q.value_or(noise.Q);
  return t;
}

/// Completes a specification: a system is of navigation grade except for its gyro bias.
ErrorSpecification completed(ErrorSpecification s) {
  if (!s.grade && !s.system) return s;
  const Grade& g = grade(s.grade.value_or("navigation"));
  const double gyro_bias = s.system ? airliner_system(*s.system).gyro_bias : g.gyro_bias;
  s.gyro = completed(s.gyro, gyro_bias, g.gyro_scale, g.gyro_noise);
  s.accel = completed(s.accel, g.accel_bias, g.accel_scale, g.accel_noise);
  if (!s.gyro.nonorthogonality) take(s.gyro.misalignment, g.gyro_misalignment);
  if (!s.accel.misalignment) take(s.accel.nonorthogonality, g.accel_misalignment);
  take(s.gyro.g_sensitivity, g.g_sensitivity);
  return s;
}

NoiseModel noise_of(const TriadErrors& t) {
  NoiseModel noise;
  noise.N = t.N.value_or(0);
  noise.B = t.B.value_or(0);
  noise.K = t.K.value_or(0);
  noise.Q = t.Q.value_or(0);
  noise.R = t.R.value_or(Spread{});
  noise.turn_on = t.turn_on.value_or(Spread{});
  return noise;
}

void check(const ErrorSpecification& s) {
  if (s.grade.has_value() + s.system.has_value() + s.calibration.has_value() > 1)
    throw Error("two of a grade, a system and a calibration; expected at most one");
  for (const auto& [name, t] : {std::pair{"gyro", &s.gyro}, std::pair{"accel", &s.accel}}) {
    if (t->misalignment && t->nonorthogonality) throw Error(std::string(name) + ": misalignment and nonorthogonality, expected one or the other");
    if (s.calibration && (t->bias || t->scale || t->misalignment || t->nonorthogonality || t->quadratic || t->g_sensitivity))
      throw Error(std::string(name) +
                  ": an error of a coefficient and a calibration, whose covariance already states it; expected noise and turn-on alone");
  }
  if (s.accel.g_sensitivity) throw Error("accel: a g-sensitivity; expected of gyros alone");
}

}  // namespace

ErrorSources error_sources(const ErrorSpecification& specification, const Calibration* calibration) {
  check(specification);
  const ErrorSpecification s = completed(specification);
  ErrorSources out = calibration ? error_sources(*calibration) : ErrorSources{};
  out.gyro_noise = noise_of(s.gyro);
  out.accel_noise = noise_of(s.accel);
  out.start = s.start;
  out.barometer = s.barometer;
  if (calibration) return out;
  std::vector<double> fixed, variance;
  for (const CoefficientIndex index : coefficient_indices()) {
    const Coefficient& c = coefficient(index);
    const Spread size = size_of(c, c.triad == Triad::gyro ? s.gyro : s.accel);
    if (size.value == 0) continue;
    out.coefficients.push_back(index);
    fixed.push_back(size.fixed ? size.value : 0);
    variance.push_back(size.fixed ? 0 : size.value * size.value);
  }
  const auto n = static_cast<Eigen::Index>(fixed.size());
  out.fixed = Eigen::Map<Eigen::VectorXd>(fixed.data(), n);
  out.covariance = Eigen::Map<Eigen::VectorXd>(variance.data(), n).asDiagonal();
  return out;
}

}  // namespace imulab
