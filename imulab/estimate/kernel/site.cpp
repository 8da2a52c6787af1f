#include "imulab/estimate/kernel/site.hpp"

#include "imulab/earth.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace imulab::kernel {

SiteChanges::SiteChanges(const Site& site) {
  if (!site.latitude) return;
  constexpr double step = 1e-4;  // rad
  const double latitude = *site.latitude;
  by_latitude_.rate = earth_rate * Vector3d(0, -std::sin(latitude), std::cos(latitude));
  if (!site.given_gravity) {
    const auto gravity = [&](double at) { return normal_gravity(at, site.height.value_or(0)); };
    by_latitude_.force.z() = (gravity(latitude + step) - gravity(latitude - step)) / (2 * step);
  }
  by_heading_.rate = earth_rate_enu(latitude).cross(Vector3d::UnitZ());  // derivative of R(up, heading)^T w
}

void SiteChanges::fill(EffectState& state, const Matrix3d& C_bn) const {
  state.by_latitude = {C_bn * by_latitude_.force, C_bn * by_latitude_.rate};
  state.by_heading = {C_bn * by_heading_.force, C_bn * by_heading_.rate};
  state.horizontal = {C_bn.col(1), C_bn.col(0)};
}

Site farther_north(Site site, double angle) {
  constexpr double most = std::numbers::pi / 2 - 1e-3;  // next to a pole, where north is still defined
  if (site.latitude) site.latitude = std::clamp(*site.latitude + angle, std::min(-most, *site.latitude), std::max(most, *site.latitude));
  return site;
}

Site beside_effects(Site site) {
  site.latitude_sigma.reset();
  site.given_gravity_sigma = site.gravity_sigma();
  return site;
}

}  // namespace imulab::kernel
