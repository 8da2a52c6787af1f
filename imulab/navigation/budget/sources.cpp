#include "imulab/navigation/budget/sources.hpp"

#include "imulab/model/coefficient.hpp"

namespace imulab {

ErrorSources error_sources(const Calibration& calibration) {
  ErrorSources out;
  out.model = calibration.model;
  std::vector<Eigen::Index> places;
  for (std::size_t k = 0; k < calibration.estimated.size(); ++k) {
    if (coefficient(calibration.estimated[k]).term == Term::lever_arm) continue;
    out.coefficients.push_back(calibration.estimated[k]);
    places.push_back(static_cast<Eigen::Index>(k));
  }
  out.fixed.setZero(static_cast<Eigen::Index>(places.size()));
  out.covariance = calibration.covariance(places, places);
  return out;
}

}  // namespace imulab
