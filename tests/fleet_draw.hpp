// Fleets drawn with what is known of them: for tests of the store and of its statistics.
#pragma once

#include "imulab/calibration.hpp"
#include "imulab/core/random.hpp"
#include "imulab/units.hpp"

#include <cmath>
#include <cstdint>
#include <string>

namespace imulab {

/// One calibration of a drawn unit: accelerometer and gyro offsets and matrices that spread by 2 mg, 1000 ppm and 0.3 deg/s over the fleet, each with
/// an uncertainty of `uncertainty` of that spread and correlated errors.
inline Calibration drawn_calibration(std::uint64_t seed, std::uint64_t unit, std::uint64_t turn = 0, double uncertainty = 0.3) {
  Calibration c;
  c.imu = "unit " + std::to_string(unit);
  c.serial = std::to_string(1000 + unit);
  c.method = "drawn";
  c.created = "2026-01-01T00:00:00Z";
  c.software = "imulab";
  c.quality.verdict = Verdict::good;
  c.quality.chi2_per_dof = 1;
  c.estimated = select_each({"accel.offset", "accel.matrix", "gyro.offset", "gyro.matrix"});
  std::erase_if(c.estimated, [](CoefficientIndex i) {
    const Coefficient& k = coefficient(i);
    return k.triad == Triad::accel && k.term == Term::matrix && k.column > k.row;  // zero in the accelerometers' frame
  });
  const auto n = static_cast<Eigen::Index>(c.estimated.size());
  Eigen::VectorXd spread(n);
  for (Eigen::Index i = 0; i < n; ++i) {
    const Coefficient& k = coefficient(c.estimated[static_cast<std::size_t>(i)]);
    spread[i] = k.term == Term::matrix ? 1e-3 : k.triad == Triad::accel ? 2e-3 * unit::g : 0.3 * unit::deg;
  }
  constexpr double common = 0.5;  // correlation of the errors of measurement
  const Eigen::VectorXd u = uncertainty * spread;
  c.covariance = u * u.transpose() * common;
  c.covariance.diagonal() = u.array().square();
  const RandomStream truth(seed, 2 * unit), error(seed, 2 * (unit + (turn + 1) * 1'000'000) + 1);
  for (Eigen::Index i = 0; i < n; ++i) {
    const auto k = static_cast<std::uint64_t>(i);
    const CoefficientIndex index = c.estimated[static_cast<std::size_t>(i)];
    const double measured = u[i] * (std::sqrt(common) * error.normal(1000) + std::sqrt(1 - common) * error.normal(k));
    set_coefficient(c.model, index, coefficient_value(c.model, index) + spread[i] * truth.normal(k) + measured);
  }
  return c;
}

}  // namespace imulab
