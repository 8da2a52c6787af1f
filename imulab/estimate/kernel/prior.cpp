#include "imulab/estimate/kernel/prior.hpp"

#include "imulab/core/decomposition.hpp"
#include "imulab/core/statistics.hpp"
#include "imulab/grade.hpp"
#include "imulab/model/effects.hpp"
#include "imulab/units.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <map>

namespace imulab::kernel {

namespace {

/// By the offsets. The least are those of a navigation-grade IMU; MEMS sensors with 30 mg and 1 deg/s get 300 ug/g^2, 2 ppm/(deg/s) and 0.1 deg/s/g.
/// A firmware may have set the gyros' offsets to zero: their terms are no smaller than those of IMUs with such accelerometers.
TermSizes sizes_of_offsets(double accel, double gyro) {
  using namespace unit;
  const double a = accel / g, w = gyro / deg;  // g, deg/s
  const TermSizes& alike = grade(grade_of_offset(accel)).terms;
  return {.accel_quadratic = std::max(30 * ug, 0.01 * a * g) / (g * g),
          .accel_cubic = std::max(10 * ug, 0.003 * a * g) / (g * g * g),
          .gyro_quadratic = std::max(alike.gyro_quadratic, std::max(1e-3, 2 * w) * ppm / deg),
          .gyro_cubic = std::max(alike.gyro_cubic, std::max(1e-3, 2 * w) * 1e-9 / (deg * deg)),
          .g_sensitivity = std::max(alike.g_sensitivity, std::max(0.01 * deg_per_h, 0.1 * gyro) / g)};
}

/// The size that the prior of an optional term is proportional to; null for other terms.
double* size_of(PriorSizes& sizes, const Coefficient& c) {
  TriadPrior& triad = c.triad == Triad::accel ? sizes.accel : sizes.gyro;
  switch (c.term) {
    case Term::quadratic:
      return &triad.quadratic;
    case Term::cubic:
      return &triad.cubic;
    case Term::g_sensitivity:
      return &sizes.g_sensitivity;
    case Term::lever_arm:
      return &sizes.lever_arm;
    default:
      return nullptr;
  }
}

/// Not inlined: valgrind takes a choice between two optional values at once for a read of values never written.
[[gnu::noinline]] double stated(const std::optional<double>& declared, double usual) { return declared.value_or(usual); }

double rms(const Vector3d& v) { return v.norm() / std::sqrt(3.0); }

}  // namespace

PriorSizes optional_priors(const ImuDeclaration& imu, const Vector3d& accel_offset, const Vector3d& gyro_offset) {
  const TermSizes usual = imu.grade ? grade(*imu.grade).terms : sizes_of_offsets(rms(accel_offset), rms(gyro_offset));
  const TermSigmas& declared = imu.term_sigmas;
  constexpr double lever_arm = 0.05;  // m: of a unit that a hand holds
  PriorSizes sizes;
  sizes.accel.quadratic = stated(declared.accel_quadratic, usual.accel_quadratic);
  sizes.accel.cubic = stated(declared.accel_cubic, usual.accel_cubic);
  sizes.gyro.quadratic = stated(declared.gyro_quadratic, usual.gyro_quadratic);
  sizes.gyro.cubic = stated(declared.gyro_cubic, usual.gyro_cubic);
  sizes.g_sensitivity = stated(declared.g_sensitivity, usual.g_sensitivity);
  sizes.lever_arm = stated(declared.lever_arm, lever_arm);
  return sizes;
}

std::optional<TurnOn> declared_turn_on(const ImuDeclaration& imu, std::size_t recordings) {
  const NoiseModels noise = declared_terms(imu);
  const auto sigma = [&](const char* effect, const Spread& turn_on) {
    const auto at = imu.effect_sigmas.find(effect);
    const double one = at != imu.effect_sigmas.end() ? at->second : turn_on.fixed ? 0 : turn_on.value;
    return one / std::sqrt(static_cast<double>(recordings));
  };
  const TurnOn out{.accel = sigma("accel.turn_on", noise.accel.turn_on), .gyro = sigma("gyro.turn_on", noise.gyro.turn_on)};
  return out == TurnOn{} ? std::nullopt : std::optional(out);
}

double widening(const Eigen::VectorXd& value, const Eigen::VectorXd& prior_sigma, const Eigen::MatrixXd& covariance) {
  // In units of the prior: where it is true, of covariance I, an estimate of covariance P has itself the covariance I - P.
  const Eigen::VectorXd unit = prior_sigma.cwiseInverse(), in_sigmas = unit.cwiseProduct(value);
  const SymmetricEigen posterior = symmetric_eigen(unit.asDiagonal() * covariance * unit.asDiagonal());
  const Eigen::VectorXd along = posterior.vectors.transpose() * in_sigmas;
  double chi2 = 0, n = 0;
  for (Eigen::Index i = 0; i < along.size(); ++i)
    if (const double learned = 1 - posterior.values[i]; learned > 1e-9) chi2 += along[i] * along[i] / learned, n += 1;
  return n > 0 && chi2 > chi_square_quantile(0.999, n) ? 2 * std::sqrt(chi2 / n) : 1;
}

double evidence_of_wider(const Eigen::VectorXd& value, const Eigen::VectorXd& prior_sigma, const Eigen::MatrixXd& covariance, double factor) {
  // In units of the prior, along the eigenvectors of P with eigenvalues p, the data alone say V = 1/p - 1 and s = x/p.
  const Eigen::VectorXd unit = prior_sigma.cwiseInverse(), in_sigmas = unit.cwiseProduct(value);
  const SymmetricEigen posterior = symmetric_eigen(unit.asDiagonal() * covariance * unit.asDiagonal());
  const Eigen::VectorXd along = posterior.vectors.transpose() * in_sigmas;
  const double wide = factor * factor;
  double sum = 0;
  for (Eigen::Index i = 0; i < along.size(); ++i) {
    const double p = std::clamp(posterior.values[i], 1e-12, 1.0), V = 1 / p - 1, s = along[i] / p;
    sum += 0.5 * (s * s * (wide / (1 + wide * V) - 1 / (1 + V)) - std::log1p(wide * V) + std::log1p(V));
  }
  return sum;
}

void widen_prior(PriorSizes& sizes, const Coefficient& c, double factor) {
  if (double* const size = size_of(sizes, c)) *size *= factor;
}

std::vector<std::string> widen_priors(PriorSizes& sizes, const std::vector<CoefficientIndex>& indices, const Eigen::VectorXd& value,
                                      const Eigen::VectorXd& prior_sigma, const Eigen::MatrixXd& covariance) {
  struct Group {
    std::string name;
    std::vector<Eigen::Index> members;
  };
  std::map<double*, Group> groups;
  for (std::size_t i = 0; i < indices.size(); ++i) {
    const Coefficient& c = coefficient(indices[i]);
    double* const size = size_of(sizes, c);
    const auto at = static_cast<Eigen::Index>(i);
    if (!size || !(*size > 0) || !std::isfinite(value[at] / prior_sigma[at])) continue;
    Group& group = groups[size];
    group.name = fmt::format("{}.{}", to_string(c.triad), to_string(c.term));
    group.members.push_back(at);
  }
  std::vector<std::string> widened;
  for (const auto& [size, group] : groups)
    if (const double by = widening(value(group.members), prior_sigma(group.members), covariance(group.members, group.members)); by > 1) {
      *size *= by;
      widened.push_back(group.name);
    }
  return widened;
}

}  // namespace imulab::kernel
