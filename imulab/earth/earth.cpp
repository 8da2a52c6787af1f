#include "imulab/earth.hpp"

#include "imulab/error.hpp"

#include <fmt/core.h>

#include <cmath>
#include <numbers>

namespace imulab {
namespace {

constexpr double a = 6378137, f = 1 / 298.257223563, gm = 3.986004418e14;  // WGS-84: m, 1, m^3/s^2
constexpr double b = a * (1 - f), e2 = f * (2 - f), linear2 = a * a * e2;  // linear2: square of the linear eccentricity E

/// q / x^3 and q' / x^2 of Heiskanen and Moritz (1967) sec 2-7 as series in y = x^2, x = E / u:
///   q = sum (-1)^(k+1) 2k x^(2k+1) / ((2k+1)(2k+3)), q' = sum (-1)^(k+1) 6 x^(2k) / ((2k+1)(2k+3)), k = 1, 2, ...
/// (their forms in atan x lose eight digits). y < 0.0068 near the ellipsoid: six terms leave 1e-13 of the first, which is 0.02 m/s^2 of gravity.
struct Q {
  double q, derivative;
};
constexpr Q q_of(double y) {
  return {2. / 15 - y * (4. / 35 - y * (6. / 63 - y * (8. / 99 - y * (10. / 143 - y * (12. / 195))))),
          6. / 15 - y * (6. / 35 - y * (6. / 63 - y * (6. / 99 - y * (6. / 143 - y * (6. / 195)))))};
}
constexpr double q0_over_e3 = q_of(linear2 / (b * b)).q / (b * b * b);  // q0 / E^3
constexpr double omega2 = earth_rate * earth_rate;
constexpr double harmonic = omega2 * a * a / q0_over_e3;  // omega^2 a^2 E^3 / q0

}  // namespace

double normal_gravity(double latitude, double height) {
  if (!(std::abs(latitude) <= 0.5 * std::numbers::pi)) throw Error(fmt::format("a latitude of {:g} rad; expected -pi/2 to pi/2", latitude));
  return local_earth(latitude, height).gravity.norm();
}

Eigen::Vector3d earth_rate_enu(double latitude) { return {0, earth_rate * std::cos(latitude), earth_rate * std::sin(latitude)}; }

LocalEarth local_earth(double latitude, double height) {
  const double s = std::sin(latitude), c = std::cos(latitude);
  const double squeeze = 1 / (1 - e2 * s * s), rn = a * std::sqrt(squeeze);
  const double r = (rn + height) * c, z = (rn * (1 - e2) + height) * s;  // cylindrical coordinates

  // Ellipsoidal coordinates: r = v cos(beta), z = u sin(beta), v^2 = u^2 + E^2.
  const double r2 = r * r, z2 = z * z, t = r2 + z2 - linear2;
  const double u2 = (t + std::sqrt(t * t + 4 * linear2 * z2)) / 2, v2 = u2 + linear2;
  const double u = std::sqrt(u2), inverse_u = 1 / u, inverse_u2 = inverse_u * inverse_u, inverse_v2 = 1 / v2;
  const double sin2 = z2 * inverse_u2, cos2 = r2 * inverse_v2;  // of beta

  // Gravity along u and beta (Heiskanen and Moritz eqs 2-66, 2-67), times w; the latter without its factor v sin(beta) cos(beta).
  const Q q = q_of(linear2 * inverse_u2);
  const double along_u = -inverse_v2 * (gm + harmonic * inverse_u2 * q.derivative * (sin2 / 2 - 1. / 6)) + omega2 * u * cos2;
  const double along_beta = harmonic * inverse_u2 * inverse_u * inverse_v2 * q.q - omega2;
  const double inverse_w2 = v2 / (u2 + linear2 * sin2);
  const double gamma_r = r * inverse_w2 * (along_u * u * inverse_v2 - sin2 * along_beta);
  const double gamma_z = z * inverse_w2 * (along_u * inverse_u + cos2 * along_beta);

  LocalEarth out;
  out.sin_latitude = s;
  out.cos_latitude = c;
  out.meridian_radius = rn * (1 - e2) * squeeze + height;
  out.transverse_radius = rn + height;
  out.rate = {0, earth_rate * c, earth_rate * s};
  out.gravity = {0, c * gamma_z - s * gamma_r, c * gamma_r + s * gamma_z};
  return out;
}

}  // namespace imulab
