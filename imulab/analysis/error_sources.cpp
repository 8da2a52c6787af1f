#include "imulab/analysis/error_sources.hpp"

#include "imulab/model/coefficient.hpp"

namespace imulab {

ErrorSources sources_of(const Grade& grade) {
  ErrorSources out;
  std::vector<double> sigma;
  const auto add = [&](const char* selector, double size) {
    if (size == 0) return;
    for (const int index : select_coefficients(selector)) {
      const Coefficient& c = coefficient_table()[static_cast<std::size_t>(index)];
      if (c.triad == Triad::accel && c.column > c.row) continue;  // the x accelerometer is the body's x axis, y lies in its x-y plane
      out.coefficients.push_back(index);
      sigma.push_back(size);
    }
  };
  add("gyro.offset", grade.gyro_bias);
  add("gyro.matrix.diagonal", grade.gyro_scale);
  add("gyro.matrix.off_diagonal", grade.gyro_misalignment);
  add("gyro.g_sensitivity", grade.g_sensitivity);
  add("accel.offset", grade.accel_bias);
  add("accel.matrix.diagonal", grade.accel_scale);
  add("accel.matrix.off_diagonal", grade.accel_misalignment);
  const Eigen::Map<const Eigen::VectorXd> all(sigma.data(), static_cast<Eigen::Index>(sigma.size()));
  out.fixed.setZero(all.size());
  out.covariance = all.cwiseAbs2().asDiagonal();
  out.gyro_noise = grade.gyro_noise;
  out.accel_noise = grade.accel_noise;
  return out;
}

ErrorSources sources_of(const Calibration& calibration) {
  ErrorSources out;
  out.model = calibration.model;
  std::vector<Eigen::Index> places;
  for (std::size_t k = 0; k < calibration.estimated.size(); ++k) {
    if (coefficient_table()[static_cast<std::size_t>(calibration.estimated[k])].term == Term::lever_arm) continue;
    out.coefficients.push_back(calibration.estimated[k]);
    places.push_back(static_cast<Eigen::Index>(k));
  }
  out.fixed.setZero(static_cast<Eigen::Index>(places.size()));
  out.covariance = calibration.covariance(places, places);
  return out;
}

}  // namespace imulab
