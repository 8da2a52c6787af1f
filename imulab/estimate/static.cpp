#include "imulab/estimate/static.hpp"

#include "imulab/core/units.hpp"
#include "imulab/earth/earth.hpp"
#include "imulab/estimate/coarse.hpp"
#include "imulab/estimate/common.hpp"
#include "imulab/estimate/static_problem.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>

namespace imulab {

namespace {

/// A gyro resolves Earth's rate if its rest means are good to a tenth of it.
constexpr double resolvable_part = 0.1;

std::vector<int> gyro_coefficients() {
  std::vector<int> indices = select_coefficients("gyro.offset");
  for (const int index : select_coefficients("gyro.matrix")) indices.push_back(index);
  return indices;
}

/// Cheng's linear gyro solution where the gyros resolve Earth's rate; else why not.
struct GyroStart {
  std::optional<CoarseGyro> coarse;
  std::string reason;
};

/// How far the rests' means may be off through the samples' noise [rad/s], with a matrix of scaled readings.
double mean_noise(const Start& start, const Matrix3d& matrix) {
  double worst = 0;
  for (const Rest& rest : start.rests)
    worst = std::max(worst, (matrix * start.noise.gyro.cwiseQuotient(start.scaling.gyro_scale)).norm() / std::sqrt(3.0 * static_cast<double>(rest.range.size())));
  return worst;
}

GyroStart start_gyro(const Start& start, const Recording& recording, const Site& site) {
  const auto not_resolved = [](double error) {
    return GyroStart{{}, fmt::format("they do not resolve Earth's rate: the rests' means miss it by {:.2g} deg/h, more than a tenth of it", error / unit::deg_per_h)};
  };
  if (!site.latitude) return {{}, "the site gives no latitude, and Earth's rate is the gyros' only reference at rest"};
  if (recording.gyro_unit != "count")
    if (const double noise = mean_noise(start, Matrix3d::Identity()); noise > resolvable_part * earth_rate) return not_resolved(noise);
  // The headings are found from the horizontal part, which is nothing at a pole.
  if (std::cos(*site.latitude) < resolvable_part) return {{}, "the latitude is too near a pole for the horizontal part of Earth's rate to be seen"};
  std::vector<Vector3d> readings, up;
  for (const Rest& rest : start.rests) {
    readings.push_back((rest.gyro - start.scaling.gyro_center).cwiseQuotient(start.scaling.gyro_scale));
    const TriadModel& accel = start.scaled_model.accel;
    up.push_back((accel.offset + accel.matrix * (rest.accel - start.scaling.accel_center).cwiseQuotient(start.scaling.accel_scale)).normalized());
  }
  GyroStart gyro{coarse_gyro_at_rest(readings, up, earth_rate * std::sin(*site.latitude)), {}};
  if (!gyro.coarse) {
    gyro.reason = "twelve or more rests in different directions away from the equator are needed for the gyros";
    return gyro;
  }
  if (recording.gyro_unit != "count" && !near_identity(gyro.coarse->matrix)) {
    gyro.coarse.reset();
    gyro.reason = "what they read at rest is not Earth's rate as gyros in rad/s see it: are the latitude (and its sign), the axes and the unit right?";
    return gyro;
  }
  double misfit = 0;  // mean square of what the solution misses of the size of Earth's rate
  for (const Vector3d& reading : readings) {
    const double miss = (gyro.coarse->offset + gyro.coarse->matrix * reading).norm() - earth_rate;
    misfit += miss * miss / static_cast<double>(readings.size());
  }
  const double error = std::max(mean_noise(start, gyro.coarse->matrix), std::sqrt(misfit));
  return error > resolvable_part * earth_rate ? not_resolved(error) : gyro;
}

}  // namespace

Calibration calibrate_static(const Recording& recording, const std::vector<Range>& ranges, const ImuDeclaration& imu, const Site& site,
                             const EstimateOptions& options) {
  Start start = start_from_rests(recording, ranges, imu, site.gravity());
  const GyroStart gyro = start_gyro(start, recording, site);
  std::vector<int> supplied = accel_coefficients();
  if (gyro.coarse) {
    start.scaled_model.gyro.offset = gyro.coarse->offset;
    start.scaled_model.gyro.matrix = gyro.coarse->matrix;
    if (recording.gyro_unit == "count") start.prior.mean.gyro = start.scaled_model.gyro;
    for (const int index : gyro_coefficients()) supplied.push_back(index);
    use_declared_gyro_noise(start, recording, imu);
  } else {
    // The scaled model must give back the starting value, one, when it returns to raw readings.
    SensorModel unit;
    unit.gyro.raw_unit = recording.gyro_unit;
    start.scaled_model.gyro = to_scaled(unit, start.scaling).gyro;
    start.notes.push_back("the gyros were not calibrated: " + gyro.reason);
  }
  const std::vector<int> indices = options.terms.empty() ? supplied : choose_terms(options.terms, supplied, "static");

  keep_start_of_others(start, indices, supplied);
  StaticProblem problem(start.rests, site.gravity(), gyro.coarse ? site.latitude : std::nullopt, start.noise, start.scaling, start.scaled_model, start.prior,
                        indices);
  const std::vector<std::string> dropped = drop_outliers(problem, options.outlier_level);
  const Fit fit = settle(problem);

  Calibration calibration = finish("static", start, fit, problem.scaled_model(), indices, imu, site);
  Quality& quality = calibration.quality;
  const Adjustment under_noise = adjust(problem.conditions({}), problem.prior_sigma());
  quality.degrees_of_freedom = static_cast<int>(std::lround(under_noise.degrees_of_freedom));
  quality.chi2_per_dof = under_noise.chi2 / std::max(1.0, under_noise.degrees_of_freedom);
  quality.notes.push_back(fmt::format("{} rests were used", problem.rests().size()));
  if (fit.spreads[0] > 0) quality.notes.push_back(spread_note("the rests' accelerometer means", fit.spreads[0] / unit::ug, "ug"));
  if (fit.spreads[1] > 0) quality.notes.push_back(spread_note("the rests' gyro means", fit.spreads[1] / unit::deg_per_h, "deg/h"));
  for (const std::string& name : dropped) quality.warnings.push_back("dropped as an outlier: " + name);
  conclude(calibration, common_doubts(calibration, fit, site, dropped.size(), start.rests.size()));
  return calibration;
}

}  // namespace imulab
