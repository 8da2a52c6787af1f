// Simulated sessions and their Fisher information. The information is derived independently of the estimators: every attitude is an unknown of its
// own, and the readings' derivatives are differences of the predicted readings.
#include "imulab/coefficient.hpp"
#include "imulab/compensate.hpp"
#include "imulab/core/decomposition.hpp"
#include "imulab/core/random.hpp"
#include "imulab/core/rotation.hpp"
#include "imulab/earth.hpp"
#include "imulab/eigen.hpp"
#include "imulab/procedure.hpp"
#include "imulab/recording/rests_of_view.hpp"
#include "imulab/rests.hpp"
#include "imulab/units.hpp"

#include <fmt/core.h>

#include "tests/acceptance/acceptance.hpp"
#include "tests/calibration_input.hpp"
#include <cmath>
#include <functional>

namespace imulab::acceptance {

namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

std::vector<CoefficientIndex> indices_of(const std::vector<const char*>& selectors) {
  std::vector<CoefficientIndex> indices;
  for (const char* selector : selectors)
    for (const CoefficientIndex index : select_coefficients(selector)) {
      const Coefficient& c = coefficient(index);
      if (!(c.triad == Triad::accel && c.term == Term::matrix && c.column > c.row)) indices.push_back(index);  // zero by the frame
    }
  return indices;
}

/// A group of readings with independent noise of one standard deviation on the calibrated side, as a function of all unknowns.
struct Readings {
  std::function<VectorXd(const VectorXd&)> residual;  ///< already divided by its standard deviation
  std::vector<Index> unknowns;                        ///< on which it depends
};

/// J^T J over all unknowns by central differences.
MatrixXd information_of(const std::vector<Readings>& all, const VectorXd& at, const VectorXd& step) {
  MatrixXd information = MatrixXd::Zero(at.size(), at.size());
  for (const Readings& readings : all) {
    MatrixXd jacobian;
    for (std::size_t c = 0; c < readings.unknowns.size(); ++c) {
      const Index u = readings.unknowns[c];
      VectorXd plus = at, minus = at;
      plus[u] += step[u];
      minus[u] -= step[u];
      const VectorXd column = (readings.residual(plus) - readings.residual(minus)) / (2 * step[u]);
      if (c == 0) jacobian.resize(column.size(), static_cast<Index>(readings.unknowns.size()));
      jacobian.col(static_cast<Index>(c)) = column;
    }
    information(readings.unknowns, readings.unknowns) += jacobian.transpose() * jacobian;
  }
  return information;
}

/// The information on the first m unknowns, the others eliminated.
MatrixXd schur(const MatrixXd& information, Index m) {
  const Index k = information.rows() - m;
  const MatrixXd cross = information.topRightCorner(m, k);
  return information.topLeftCorner(m, m) - cross * solve_semidefinite(information.bottomRightCorner(k, k), Eigen::MatrixXd(cross.transpose()));
}

/// The session as the Fisher information sees it: unknowns are the coefficients, g, and three attitude errors for each rest.
struct Model {
  std::vector<CoefficientIndex> indices;
  const Truth* truth;
  double latitude;
  std::vector<Matrix3d> C_nb;
  bool with_gyro;

  SensorModel sensor(const VectorXd& x) const {
    SensorModel model = truth->model;
    for (std::size_t i = 0; i < indices.size(); ++i) set_coefficient(model, indices[i], x[static_cast<Index>(i)]);
    return model;
  }
  Index g_at() const { return static_cast<Index>(indices.size()); }
  Index attitude_at(std::size_t rest) const { return g_at() + 1 + 3 * static_cast<Index>(rest); }
  Matrix3d attitude(const VectorXd& x, std::size_t rest) const { return rotation_exp(x.segment<3>(attitude_at(rest))) * C_nb[rest]; }

  /// Means of a rest over n samples: compensated reading less the motion, over the noise of the mean.
  Readings rest(std::size_t k, const RawSample& raw, double accel_sigma, double gyro_sigma) const {
    std::vector<Index> unknowns;
    for (Index i = 0; i <= g_at(); ++i) unknowns.push_back(i);
    for (Index i = 0; i < 3; ++i) unknowns.push_back(attitude_at(k) + i);
    return {[=, this](const VectorXd& x) {
              const Motion motion = compensate(sensor(x), raw);
              const Matrix3d C_bn = attitude(x, k).transpose();
              VectorXd r(with_gyro ? 6 : 3);
              r.head<3>() = (motion.force - C_bn * Vector3d(0, 0, x[g_at()])) / accel_sigma;
              if (with_gyro) r.tail<3>() = (motion.rate - C_bn * earth_rate_enu(latitude)) / gyro_sigma;
              return r;
            },
            unknowns};
  }

  /// The rotation between two rests: integrated readings against the attitudes, over the noise of the integral.
  Readings rotation(std::size_t k, const Recording& exact, Range range, double angle_sigma) const {
    std::vector<Index> unknowns;
    for (Index i = 0; i < g_at(); ++i) unknowns.push_back(i);
    for (Index i = 0; i < 6; ++i) unknowns.push_back(attitude_at(k) + i);
    const auto integrated = [&exact, range](const SensorModel& model) {
      Matrix3d C = Matrix3d::Identity();
      for (std::size_t i = range.begin; i < range.end; ++i) {
        RawSample raw;
        for (int j = 0; j < 3; ++j) {
          raw.accel[j] = exact.accel[static_cast<std::size_t>(j)][i];
          raw.gyro[j] = exact.gyro[static_cast<std::size_t>(j)][i];
        }
        C = C * rotation_exp(compensate(model, raw).rate * exact.interval_s);
      }
      return C;
    };
    const double duration = static_cast<double>(range.size()) * exact.interval_s;
    const Matrix3d earth = rotation_exp(earth_rate_enu(latitude) * duration);  // rotation of n meanwhile
    const Matrix3d nominal = attitude(VectorXd::Zero(attitude_at(C_nb.size())), k).transpose() * earth * C_nb[k + 1];
    const Matrix3d start = integrated(truth->model);
    return {[=, this](const VectorXd& x) {
              const Matrix3d by_gyro = integrated(sensor(x)) * start.transpose();  // relative to the truth: the integrator's own error cancels
              const Matrix3d by_attitude = attitude(x, k).transpose() * earth * attitude(x, k + 1) * nominal.transpose();
              return VectorXd(rotation_log(by_gyro * by_attitude.transpose()) / angle_sigma);
            },
            unknowns};
  }
};

struct Scenario {
  Session session;
  std::vector<CoefficientIndex> indices;
  bool rotations;
  std::string_view method;
};

MatrixXd fisher_information(const Scenario& scenario, const Truth& truth, const Recording& exact) {
  Model model{scenario.indices, &truth, *scenario.session.site.latitude, {}, true};
  std::vector<Range> spans;
  const double dt = exact.interval_s;
  for (const Step& step : scenario.session.steps) {
    spans.push_back({static_cast<std::size_t>(std::lround(step.start / dt)), static_cast<std::size_t>(std::lround(step.end / dt))});
    const Matrix3d C_nb = rotation_about(Vector3d::UnitZ(), step.angles[0]) * rotation_about(Vector3d::UnitY(), step.angles[1]) *
                          rotation_about(Vector3d::UnitX(), step.angles[2]);
    model.C_nb.push_back(C_nb);
  }
  const Index unknowns = model.attitude_at(spans.size());
  VectorXd at = VectorXd::Zero(unknowns), step = VectorXd::Constant(unknowns, 1e-5);
  for (std::size_t i = 0; i < scenario.indices.size(); ++i) at[static_cast<Index>(i)] = coefficient_value(truth.model, scenario.indices[i]);
  at[model.g_at()] = truth.gravity;
  std::vector<Readings> all;
  for (std::size_t k = 0; k < spans.size(); ++k) {
    const double duration = static_cast<double>(spans[k].size()) * dt;
    const Matrix3d C_bn = model.C_nb[k].transpose();
    const RawSample raw = decompensate(truth.model, {.rate = C_bn * earth_rate_enu(model.latitude), .force = C_bn * Vector3d(0, 0, truth.gravity)});
    all.push_back(model.rest(k, raw, truth.accel_noise.N / std::sqrt(duration), truth.gyro_noise.N / std::sqrt(duration)));
    if (!scenario.rotations || k + 1 == spans.size()) continue;
    const Range way{spans[k].end, spans[k + 1].begin};
    all.push_back(model.rotation(k, exact, way, truth.gyro_noise.N * std::sqrt(static_cast<double>(way.size()) * dt)));
  }
  MatrixXd information = information_of(all, at, step);
  const double sigma_g = scenario.session.site.gravity_sigma();
  information(model.g_at(), model.g_at()) += 1 / (sigma_g * sigma_g);
  return schur(information, static_cast<Index>(scenario.indices.size()));
}

Run run(const Scenario& scenario, std::uint64_t seed) {
  const Truth truth = draw_truth(scenario.session, seed);
  const RecordingSource& source = scenario.session.recordings.front();
  const Recording recording = simulate_recording(scenario.session, source, truth, seed);
  Session given = scenario.session;
  given.steps.clear();
  CalibrationOptions options;
  options.terms = scenario.indices;
  options.effects = false;  // none are simulated: the estimates are compared with the bound of the model alone
  const Calibration c = calibrated(scenario.method, recording, rests_of(recording, given).ranges, {}, given.site, options);
  if (c.estimated.size() != scenario.indices.size())
    throw std::runtime_error(fmt::format("seed {}: {} coefficients were found undetermined", seed, c.quality.unobservable.size()));

  Truth quiet = truth;
  quiet.accel_noise.N = quiet.gyro_noise.N = 0;
  Run result{c.estimated, VectorXd(c.estimated.size()), c.covariance,
             fisher_information(scenario, truth, scenario.rotations ? simulate_recording(scenario.session, source, quiet, seed) : recording)};
  for (std::size_t i = 0; i < c.estimated.size(); ++i)
    result.error[static_cast<Index>(i)] = coefficient_value(c.model, c.estimated[i]) - coefficient_value(truth.model, c.estimated[i]);
  return result;
}

}  // namespace

Run handheld_run(std::uint64_t seed) {
  HandHeldOptions options;
  options.poses = 30;
  options.rest = 6;
  Scenario scenario{hand_held_procedure(options, seed),
                    indices_of({"accel.offset", "accel.matrix", "gyro.offset", "gyro.matrix", "gyro.g_sensitivity"}), true, "handheld"};
  return run(scenario, seed);
}

/// Navigation grade: its gyros resolve Earth's rate in a minute.
Run static_run(std::uint64_t seed) {
  HandHeldOptions options;
  options.poses = 24;
  options.first_rest = options.rest = 60;
  options.move = 4;
  options.grade = "navigation";
  Scenario scenario{hand_held_procedure(options, seed), indices_of({"accel.offset", "accel.matrix", "gyro.offset", "gyro.matrix"}), false, "static"};
  return run(scenario, seed);
}

}  // namespace imulab::acceptance
