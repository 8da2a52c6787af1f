#include "imulab/earth/earth.hpp"

#include "imulab/core/units.hpp"

#include <GeographicLib/NormalGravity.hpp>
#include <cmath>

namespace imulab {

double normal_gravity(double latitude, double height) {
  double gamma_y, gamma_z;
  GeographicLib::NormalGravity::WGS84().Gravity(latitude / unit::deg, height, gamma_y, gamma_z);
  return std::hypot(gamma_y, gamma_z);
}

Eigen::Vector3d earth_rate_enu(double latitude) { return {0, earth_rate * std::cos(latitude), earth_rate * std::sin(latitude)}; }

}  // namespace imulab
