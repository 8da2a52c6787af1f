// Simulated whole-unit sessions, and their Fisher information, derived independently of the estimator: raw means as a function of the coefficients
// and of every error of the machines, which are unknowns with a prior; derivatives by differences through the inverse of the sensor model.
#include "imulab/coefficient.hpp"
#include "imulab/compensate.hpp"
#include "imulab/core/decomposition.hpp"
#include "imulab/core/random.hpp"
#include "imulab/core/statistics.hpp"
#include "imulab/earth.hpp"
#include "imulab/rig/machine.hpp"
#include "imulab/units.hpp"

#include <fmt/core.h>

#include "tests/acceptance/acceptance.hpp"
#include "tests/acceptance/shared_runs.hpp"
#include "tests/whole_unit_session.hpp"
#include <algorithm>
#include <cmath>
#include <limits>

namespace imulab::acceptance {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

namespace {

using Vector6 = Eigen::Matrix<double, 6, 1>;
using Matrix6 = Eigen::Matrix<double, 6, 6>;

Vector6 raw_of(const SensorModel& model, const Vector6& motion, const Vector3d& accel_tau, const Vector3d& gyro_tau) {
  const RawSample raw = decompensate(model, {.rate = motion.tail<3>(), .force = motion.head<3>()}, gyro_tau, accel_tau);
  Vector6 out;
  out << raw.accel, raw.gyro;
  return out;
}

/// One step, and what was read and declared there.
struct Point {
  Step step;
  Vector3d accel_tau, gyro_tau;
  double samples;
  const RigDeclaration* rig;
  Index first;  ///< of the rig's errors among the common ones
  std::vector<RigErrorSource> sources;
};

Vector6 motion_at(const Point& p, const VectorXd& common, const Site& site) {
  const VectorXd own = common.segment(p.first, static_cast<Index>(p.sources.size()));
  const MachineErrors<double> errors = errors_at({p.sources, {own.begin(), own.end()}}, mount_of(p.step));
  const SteadyMotion<double> m = steady_motion<double>(p.step, errors, {site.gravity() + common[0], earth_rate_enu(*site.latitude)});
  Vector6 out;
  out << m.force, m.rate;
  return out;
}

std::vector<Point> points_of(const WholeUnitSession& s, VectorXd& sigma) {
  std::vector<Point> points;
  std::vector<double> sigmas{s.session.site.gravity_sigma()};
  for (std::size_t r = 0; r < s.recordings.size(); ++r) {
    const RigDeclaration* const rig = s.session.rig_of(s.session.recordings[r]);
    const std::vector<Step> steps = s.session.steps_of(s.session.recordings[r]);
    const auto sources = machine_error_sources(*rig, steps);
    const auto first = static_cast<Index>(sigmas.size());
    for (const RigErrorSource& e : sources) sigmas.push_back(e.sigma);
    const Recording& rec = s.recordings[r];
    std::size_t at = 0;
    for (const Step& step : steps) {
      const auto n = static_cast<std::size_t>(std::lround((step.end - step.start) / rec.interval_s));
      Point p{step, Vector3d::Zero(), Vector3d::Zero(), static_cast<double>(n), rig, first, sources};
      for (std::size_t axis = 0; axis < 3; ++axis)
        for (std::size_t k = at; k < at + n; ++k) {
          p.accel_tau[static_cast<Index>(axis)] += (rec.accel_temperature[axis][k] - s.truth.model.accel.temperature->reference) / p.samples;
          p.gyro_tau[static_cast<Index>(axis)] += (rec.gyro_temperature[axis][k] - s.truth.model.gyro.temperature->reference) / p.samples;
        }
      at += n;
      points.push_back(std::move(p));
    }
  }
  sigma = Eigen::Map<VectorXd>(sigmas.data(), static_cast<Index>(sigmas.size()));
  return points;
}

/// A change of this size moves the readings by about a hundredth of the full scale of 300 m/s^2 and 7 rad/s over 50 K.
double step_of(const Coefficient& c) {
  const double full = c.triad == Triad::accel ? 300 : 7;
  switch (c.term) {
    case Term::offset:
      return 1e-2 * full;
    case Term::matrix:
      return 1e-2;
    case Term::quadratic:
      return 1e-2 / full;
    case Term::cubic:
      return 1e-2 / (full * full);
    case Term::thermal:
      return 1e-2 * full / std::pow(50.0, c.column);
    case Term::g_sensitivity:
      return 1e-2 * 7 / 300;
    case Term::matrix_thermal1:
    case Term::matrix_thermal2:
    case Term::lever_arm:
      break;
  }
  return 1;
}

/// Covariance of a point's raw means: noise of force and rate, thermal readings, and what remains of horizontal vectors over part of a turn.
Matrix6 noise_of(const Point& p, const WholeUnitSession& s, const Vector6& motion) {
  const SensorModel& model = s.truth.model;
  const Site& site = s.session.site;
  Matrix6 by_motion;  // d raw / d (force, rate)
  for (Index k = 0; k < 6; ++k) {
    const double h = k < 3 ? 1e-3 : 1e-4;
    by_motion.col(k) = (raw_of(model, motion + h * Vector6::Unit(k), p.accel_tau, p.gyro_tau) -
                        raw_of(model, motion - h * Vector6::Unit(k), p.accel_tau, p.gyro_tau)) /
                       (2 * h);
  }
  const double rate_hz = 1 / s.recordings.front().interval_s;
  Vector6 white;
  white << Vector3d::Constant(s.truth.accel_noise.N * s.truth.accel_noise.N), Vector3d::Constant(s.truth.gyro_noise.N * s.truth.gyro_noise.N);
  Matrix6 in_motion = Matrix6((white * rate_hz / p.samples).asDiagonal());
  if (const double kept = horizontal_remainder(p.step); kept > 0) {
    const Vector3d up = mount_attitude(mount_of(p.step)).row(2);
    const Matrix3d across = Matrix3d::Identity() - up * up.transpose();
    const double earth = earth_rate_enu(*site.latitude).head<2>().norm();
    in_motion.topLeftCorner<3, 3>() += std::pow(kept * site.gravity() * p.rig->zero.value, 2) * 2 * across +
                                       std::pow(2 * kept * p.step.rate * p.step.radius[0] * earth, 2) * (up * up.transpose());
    in_motion.bottomRightCorner<3, 3>() += std::pow(kept * earth, 2) * across;
  }
  Matrix6 noise = by_motion * in_motion * by_motion.transpose();
  const RecordingSource& source = s.session.recordings.front();
  for (Index k = 0; k < 3; ++k) {
    const auto slope = [&](const Thermal& thermal, double tau) { return thermal(k, 1) + 2 * thermal(k, 2) * tau; };
    noise(k, k) += std::pow(slope(model.accel.thermal, p.accel_tau[k]) * source.accel_temperature->noise, 2) / p.samples;
    noise(3 + k, 3 + k) += std::pow(slope(model.gyro.thermal, p.gyro_tau[k]) * source.gyro_temperature->noise, 2) / p.samples;
  }
  return noise;
}

MatrixXd information_of(const WholeUnitSession& s, const std::vector<CoefficientIndex>& indices) {
  VectorXd sigma;
  const std::vector<Point> points = points_of(s, sigma);
  const auto m = static_cast<Index>(indices.size()), k = sigma.size();
  const VectorXd none = VectorXd::Zero(k);
  MatrixXd information = MatrixXd::Zero(m + k, m + k);
  for (const Point& p : points) {
    const Vector6 motion = motion_at(p, none, s.session.site);
    MatrixXd jacobian(6, m + k);
    for (Index c = 0; c < m; ++c) {
      const CoefficientIndex index = indices[static_cast<std::size_t>(c)];
      const double h = step_of(coefficient(index));
      const auto moved = [&](double by) {
        SensorModel model = s.truth.model;
        set_coefficient(model, index, coefficient_value(model, index) + by);
        return raw_of(model, motion, p.accel_tau, p.gyro_tau);
      };
      jacobian.col(c) = (moved(0.01 * h) - moved(-0.01 * h)) / (0.02 * h);
    }
    for (Index c = 0; c < k; ++c) {
      VectorXd up = none, down = none;
      up[c] = sigma[c], down[c] = -sigma[c];  // in units of each one's sigma
      jacobian.col(m + c) = 0.5 * (raw_of(s.truth.model, motion_at(p, up, s.session.site), p.accel_tau, p.gyro_tau) -
                                   raw_of(s.truth.model, motion_at(p, down, s.session.site), p.accel_tau, p.gyro_tau));
    }
    jacobian = Cholesky(noise_of(p, s, motion)).solve_lower(jacobian);
    information += jacobian.transpose() * jacobian;
  }
  const MatrixXd cross = information.topRightCorner(m, k);
  return information.topLeftCorner(m, m) -
         cross * solve_semidefinite(information.bottomRightCorner(k, k) + MatrixXd::Identity(k, k), MatrixXd(cross.transpose()));
}

Run run_of(std::uint64_t seed, double record) {
  DaiUnitOptions options;
  options.record = record;
  const WholeUnitSession s = whole_unit_session(seed, options, [](Session&) {});
  const Calibration c = whole_unit::calibrate(s.input(), full_whole_unit()).calibration;
  return {c.estimated, errors_of(c, s.truth.model), c.covariance, information_of(s, c.estimated)};
}

struct OutputRun {
  double squared = 0;  ///< of one compensated sample, under the covariance stated for it
  VectorXd joint, stepwise;
  std::vector<CoefficientIndex> indices;
  void fields(auto&& visit) { visit(squared, joint, stepwise, indices); }
};

}  // namespace

Run whole_unit_run(std::uint64_t seed) { return run_of(seed, 10); }
Run short_whole_unit_run(std::uint64_t seed) { return run_of(seed, 1); }

std::vector<Check> whole_unit_outputs(int runs) {
  const auto results = runs_of<OutputRun>("whole-unit outputs", runs, [](std::size_t i) {
    const std::uint64_t seed = i + 1;
    const WholeUnitSession s = whole_unit_session(seed, {}, [](Session&) {});
    const Calibration c = whole_unit::calibrate(s.input(), full_whole_unit()).calibration;
    const Calibration steps = whole_unit::calibrate(s.input(), full_whole_unit(true)).calibration;
    // Anywhere in the range: 30 g and 400 deg/s on every axis at once, 0 to 70 degC.
    const RandomStream draws(seed, "any motion");
    std::uint64_t n = 0;
    const auto within = [&](double limit) { return limit * (2 * draws.uniform(n++) - 1); };
    Vector6 motion;
    for (Index k = 0; k < 6; ++k) motion[k] = k < 3 ? within(30 * unit::g) : within(400 * unit::deg);
    const double temperature = 70 * draws.uniform(n++);
    const Vector3d tau = Vector3d::Constant(temperature - 25);
    const Vector6 readings = raw_of(s.truth.model, motion, tau, tau);
    const RawSample raw{.gyro = readings.tail<3>(), .accel = readings.head<3>(), .gyro_tau = tau, .accel_tau = tau};
    const Motion out = compensate(c.model, raw);
    Vector6 error;
    error << out.rate - motion.tail<3>(), out.force - motion.head<3>();
    return OutputRun{squared_norm_in(output_covariance(c, raw), error), errors_of(c, s.truth.model), errors_of(steps, s.truth.model), c.estimated};
  });
  const double n = runs, dof = 6 * n;
  double squared = 0;
  VectorXd joint = VectorXd::Zero(results[0].joint.size()), stepwise = joint;
  for (const OutputRun& r : results) squared += r.squared / dof, joint += r.joint.cwiseAbs2() / n, stepwise += r.stepwise.cwiseAbs2() / n;
  VectorXd gain = (stepwise.array() / joint.array()).sqrt();
  Index least, most;
  gain.minCoeff(&least), gain.maxCoeff(&most);
  const auto name = [&](Index k) { return std::string(coefficient(results[0].indices[static_cast<std::size_t>(k)]).name); };
  std::vector<double> sorted(gain.begin(), gain.end());
  const double any = std::numeric_limits<double>::infinity();
  // Where the steps use the same points with the same weights both agree up to chance: three sigma of a ratio of correlated RMS values.
  return {{"compensated output", squared, chi_square_quantile(0.0005, dof) / dof, chi_square_quantile(0.9995, dof) / dof},
          {"stepwise over joint, least: " + name(least), gain[least], 1 - 3 / std::sqrt(2 * n), any},
          {"stepwise over joint, median", median(sorted), 1, any},
          {"stepwise over joint, most: " + name(most), gain[most], 1, any}};
}

}  // namespace imulab::acceptance
