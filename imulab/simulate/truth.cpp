// Draws an IMU.
#include "imulab/core/error.hpp"
#include "imulab/core/random.hpp"
#include "imulab/model/grade.hpp"
#include "imulab/recording/declared_noise.hpp"
#include "imulab/recording/validate.hpp"
#include "imulab/simulate/simulate.hpp"
#include "imulab/simulate/temperature.hpp"

#include <algorithm>
#include <cmath>

namespace imulab {

namespace {

using namespace simulate;

/// Each coefficient has a stream of its own draws: a new one does not shift another.
Vector3d drawn_vector(std::uint64_t seed, std::string_view purpose, double sigma) {
  const RandomStream draws(seed, purpose);
  Vector3d v;
  for (int i = 0; i < 3; ++i) v(i) = sigma * draws.normal(static_cast<std::uint64_t>(i));
  return v;
}

Matrix3d drawn_matrix(std::uint64_t seed, std::string_view purpose, double sigma_diagonal, double sigma_off_diagonal) {
  const RandomStream draws(seed, purpose);
  Matrix3d m;
  std::uint64_t draw = 0;
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j) m(i, j) = (i == j ? sigma_diagonal : sigma_off_diagonal) * draws.normal(draw++);
  return m;
}

/// Sizes uniform between two bounds, with either sign.
Matrix3d drawn_from(std::uint64_t seed, std::string_view purpose, const SizeRange& range) {
  const RandomStream draws(seed, purpose);
  Matrix3d m;
  std::uint64_t draw = 0;
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j) {
      const double u = 2 * draws.uniform(draw++) - 1;
      m(i, j) = std::copysign(range[0] + (range[1] - range[0]) * std::abs(u), u);
    }
  return m;
}

/// The errors of a triad besides its offset and scale factors.
void add_nonlinear(TriadModel& m, std::uint64_t seed, const std::string& triad, const SizeRange& misalignment, const SizeRange& quadratic,
                   const SizeRange& cubic, double drift, double curvature) {
  m.matrix = Matrix3d(m.matrix.diagonal().asDiagonal());
  Matrix3d cross = drawn_from(seed, "truth " + triad + " misalignment", misalignment);
  cross.diagonal().setZero();
  m.matrix += cross;
  m.quadratic = drawn_from(seed, "truth " + triad + " quadratic", quadratic).diagonal();
  m.cubic = drawn_from(seed, "truth " + triad + " cubic", cubic).diagonal();
  const double end = std::max(drawn_reference - drawn_temperatures[0], drawn_temperatures[1] - drawn_reference);
  m.thermal.col(1) = drawn_vector(seed, "truth " + triad + " drift", drift / end);
  m.thermal.col(2) = drawn_vector(seed, "truth " + triad + " curvature", curvature / (end * end));
  m.temperature = ThermalReading{"degC", drawn_reference, drawn_temperatures};
}

SensorModel drawn_model(const Grade& g, std::uint64_t seed) {
  SensorModel model;
  model.accel.offset = drawn_vector(seed, "truth accel.offset", g.accel_bias);
  model.gyro.offset = drawn_vector(seed, "truth gyro.offset", g.gyro_bias);
  const Matrix3d accel = drawn_matrix(seed, "truth accel.matrix", g.accel_scale, g.accel_misalignment);
  model.accel.matrix += accel.triangularView<Eigen::Lower>().toDenseMatrix();
  model.gyro.matrix += drawn_matrix(seed, "truth gyro.matrix", g.gyro_scale, g.gyro_misalignment);
  model.g_sensitivity = drawn_matrix(seed, "truth gyro.g_sensitivity", g.g_sensitivity, g.g_sensitivity);
  if (!g.ranges) return model;
  const NonlinearRanges& r = *g.ranges;
  add_nonlinear(model.accel, seed, "accel", r.accel_misalignment, r.accel_quadratic, r.accel_cubic, r.accel_drift, r.accel_curvature);
  add_nonlinear(model.gyro, seed, "gyro", r.gyro_misalignment, r.gyro_quadratic, r.gyro_cubic, r.gyro_drift, r.gyro_curvature);
  model.g_sensitivity = drawn_from(seed, "truth gyro.g_sensitivity size", r.g_sensitivity);
  return model;
}

/// A triad's thermal terms as functions of the recordings' readings. One in raw readings is assumed to be in these.
TriadModel as_recorded(const TriadModel& model, const Session& procedure, std::optional<ThermalSource> RecordingSource::*triad, bool drawn) {
  if (!model.temperature) return model;
  const ThermalSource* reading = nullptr;
  for (const RecordingSource& source : procedure.recordings) {
    const auto& here = source.*triad;
    if (!here) continue;
    if (reading && (here->unit != reading->unit || here->at_25_degC != reading->at_25_degC || here->per_K != reading->per_K))
      throw Error("thermal readings that differ between recordings; an IMU has one model; expected one unit and one relation to the temperature");
    reading = &*here;
  }
  const std::string& unit = model.temperature->unit;
  if (reading == nullptr || (!drawn && (unit == reading->unit || unit == "raw"))) return model;
  return with_readings(model, thermal_scale(unit), thermal_scale(*reading), reading->unit);
}

}  // namespace

Truth draw_truth(const Session& procedure, std::uint64_t seed, const std::optional<SensorModel>& given) {
  validate(procedure);
  const ImuDeclaration& imu = procedure.imu;
  const Grade* const spread = imu.grade ? &grade(*imu.grade) : nullptr;
  if (!given && !spread) throw Error("no IMU to simulate; expected its grade or its model");
  Truth truth;
  const NoiseModels noise = declared_noise(imu);
  truth.accel_noise = noise.accel, truth.gyro_noise = noise.gyro;
  // The grade's limits are in SI; a given IMU's raw readings need not be.
  if (given && !imu.accel_noise) truth.accel_noise.resolution = truth.accel_noise.range = 0;
  if (given && !imu.gyro_noise) truth.gyro_noise.resolution = truth.gyro_noise.range = 0;
  truth.model = given ? *given : drawn_model(*spread, seed);
  truth.model.accel = as_recorded(truth.model.accel, procedure, &RecordingSource::accel_temperature, !given);
  truth.model.gyro = as_recorded(truth.model.gyro, procedure, &RecordingSource::gyro_temperature, !given);
  if (!given && spread->ranges) truth.frame = "rig";
  truth.gravity = procedure.site.gravity() + procedure.site.gravity_sigma() * RandomStream(seed, "truth gravity").normal(0);
  if (const double sigma = procedure.site.latitude_sigma.value_or(0); procedure.site.latitude && sigma > 0)
    truth.latitude = *procedure.site.latitude + sigma * RandomStream(seed, "truth latitude").normal(0);
  return truth;
}

}  // namespace imulab
