#include "imulab/analysis/turntable_prediction.hpp"

#include "imulab/core/error.hpp"
#include "imulab/core/random.hpp"
#include "imulab/estimate/forward_model.hpp"
#include "imulab/model/coefficient.hpp"
#include "imulab/model/grade.hpp"
#include "imulab/simulate/simulate.hpp"

#include <Eigen/Cholesky>
#include <Eigen/SparseCore>
#include <fmt/core.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <atomic>
#include <cmath>

namespace imulab {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

namespace {

/// The source kinds of a rig and a site, in the order a budget prints them.
constexpr std::array<std::pair<ErrorSource::Kind, const char*>, 7> table_sources{{{ErrorSource::Kind::orthogonality, "orthogonality"},
                                                                                  {ErrorSource::Kind::angle, "angle"},
                                                                                  {ErrorSource::Kind::zero, "zero"},
                                                                                  {ErrorSource::Kind::timing, "timing"},
                                                                                  {ErrorSource::Kind::gravity, "gravity"},
                                                                                  {ErrorSource::Kind::latitude, "latitude"},
                                                                                  {ErrorSource::Kind::earth, "earth rate"}}};

/// Holds that a turn's sum reaches into.
std::vector<std::size_t> rests_of_turns(const TableMotion& motion) {
  std::vector<std::size_t> out;
  for (std::size_t hold = 0; hold < motion.holds(); ++hold) {
    bool shared = false;
    for (std::size_t turn = motion.holds(); turn < motion.holds() + motion.turns(); ++turn)
      shared = shared || (motion.begin(turn) < motion.end(hold) && motion.begin(hold) < motion.end(turn));
    if (shared) out.push_back(hold);
  }
  return out;
}

TurntableEstimator estimator_of(const TurntablePlan& plan, const TableMotion& motion) {
  TurntableSettings settings;
  settings.terms = plan.terms;
  settings.table_errors = !plan.classical;
  settings.bias_while_turning = plan.classical;
  if (plan.classical) settings.left_out = rests_of_turns(motion);
  const Matrix3d identity = Matrix3d::Identity();
  return {motion, {}, {raw_density(plan.accel_noise.N, identity), raw_density(plan.gyro_noise.N, identity)}, settings};
}

/// What a constant bias of each axis (accelerometers, then gyros) does to the readings.
MatrixXd turn_on_readings(const TableMotion& motion) {
  MatrixXd out = MatrixXd::Zero(motion.rows(), 6);
  const auto holds = static_cast<Index>(motion.holds());
  for (Index k = 0; k < holds; ++k) out.middleRows<6>(6 * k).setIdentity();
  for (Index k = 0; k < static_cast<Index>(motion.turns()); ++k) {
    const auto part = static_cast<std::size_t>(holds + k);
    out.block<3, 3>(6 * holds + 3 * k, 3) = (motion.end(part) - motion.begin(part)) * Matrix3d::Identity();
  }
  return out;
}

/// 1 for readings of the accelerometers.
VectorXd of_accelerometers(const TableMotion& motion) {
  VectorXd out = VectorXd::Zero(motion.rows());
  for (std::size_t k = 0; k < motion.holds(); ++k) out.segment<3>(static_cast<Index>(6 * k)).setOnes();
  return out;
}

void expect_noise(double density, const std::string& file, const char* triad) {
  if (density > 0) return;
  throw Error(fmt::format("{}: [imu] {}_noise_density: a density above 0 was expected: the readings are weighted by their noise", file, triad));
}

/// Variance of the coefficients from what a constant bias does to them, one column an axis.
VectorXd of_turn_on(const Spread& turn_on, const Eigen::MatrixX3d& by_axis) {
  const VectorXd effect = turn_on.fixed ? VectorXd(by_axis.rowwise().sum().cwiseAbs2()) : VectorXd(by_axis.rowwise().squaredNorm());
  return effect * (turn_on.value * turn_on.value);
}

/// Variances of the best weights: with the table's errors in them, and one bias of a gyro throughout. NaN: not determined by them.
VectorXd with_best_weights(TurntablePlan plan, const TableMotion& motion, const std::vector<int>& coefficients) {
  plan.classical = false;
  const auto best = estimator_of(plan, motion).uncertainty({});
  VectorXd out = VectorXd::Constant(static_cast<Index>(coefficients.size()), std::nan(""));
  for (std::size_t i = 0; i < coefficients.size(); ++i) {
    const auto found = std::find(best.determined.begin(), best.determined.end(), coefficients[i]);
    if (found == best.determined.end()) continue;
    const auto row = found - best.determined.begin();
    const Coefficient& c = coefficient_table()[static_cast<std::size_t>(coefficients[i])];
    const double bias = c.term != Term::offset ? 0 : (c.triad == Triad::accel ? plan.accel_noise : plan.gyro_noise).turn_on.value;
    out[static_cast<Index>(i)] = best.covariance(row, row) + bias * bias;
  }
  return out;
}

}  // namespace

TurntablePlan turntable_plan(const Session& procedure) {
  if (procedure.recordings.size() > 1) throw Error(procedure.file + ": [[recording]]: a procedure with one recording was expected");
  const std::string recording = procedure.recordings.empty() ? "" : procedure.recordings.front().file;
  TurntablePlan plan;
  plan.rig = turntable_of(procedure, recording);
  plan.observations = planned_observations(procedure, recording);
  if (!procedure.recordings.empty() && procedure.recordings.front().rate_hz)
    for (const HoldObservation& hold : plan.observations.holds)
      if (const double samples = (hold.end - hold.begin) * *procedure.recordings.front().rate_hz; samples < 2)
        throw Error(fmt::format("{}: {}: at rate_hz = {:g} it has {:.2g} samples; two at least were expected", procedure.file,
                                describe_step(plan.observations.steps, hold.step), *procedure.recordings.front().rate_hz, samples));
  plan.site = procedure.site;
  const Truth unit = [&] {  // an ideal one; its noise is as a simulation has it
    try {
      return draw_truth(procedure, 1, SensorModel{});
    } catch (const Error& e) {
      throw Error(fmt::format("{}: {}", procedure.file, e.what()));
    }
  }();
  plan.accel_noise = unit.accel_noise;
  plan.gyro_noise = unit.gyro_noise;
  expect_noise(plan.accel_noise.N, procedure.file, "accel");
  expect_noise(plan.gyro_noise.N, procedure.file, "gyro");
  for (const char* selector : {"accel.offset", "accel.matrix", "gyro.offset", "gyro.matrix"})
    for (const int index : select_coefficients(selector)) plan.terms.push_back(index);
  if (procedure.imu.grade && grade(*procedure.imu.grade).g_sensitivity > 0)
    for (const int index : select_coefficients("gyro.g_sensitivity")) plan.terms.push_back(index);
  return plan;
}

TurntablePrediction predict(const TurntablePlan& plan) {
  const TableMotion motion(plan.observations, plan.rig, plan.site);
  const TurntableEstimator estimator = estimator_of(plan, motion);
  const auto uncertainty = estimator.uncertainty({});
  TurntablePrediction out{.coefficients = uncertainty.determined,
                          .undetermined = uncertainty.undetermined,
                          .sources = {},
                          .variance = {},
                          .second_order = {},
                          .bias = {},
                          .cramer_rao = {}};
  const auto n = static_cast<Index>(out.coefficients.size());
  const MatrixXd sensitivity = estimator.sensitivity({}, out.coefficients);  // exact, of the estimator
  const auto add = [&](std::string name, const VectorXd& variance) {
    if (variance.size() > 0 && variance.maxCoeff() == 0) return;
    out.sources.push_back(std::move(name));
    out.variance.conservativeResize(n, out.variance.cols() + 1);
    out.variance.rightCols<1>() = variance;
  };
  const MatrixXd by_source = sensitivity * estimator.table_jacobian() * motion.sigma().asDiagonal();
  for (const auto& [kind, name] : table_sources) {
    VectorXd variance = VectorXd::Zero(n);
    for (std::size_t k = 0; k < motion.sources().size(); ++k)
      if (motion.sources()[k].kind == kind) variance += by_source.col(static_cast<Index>(k)).cwiseAbs2();
    add(name, variance);
  }
  const VectorXd accel_rows = of_accelerometers(motion), gyro_rows = VectorXd::Ones(motion.rows()) - accel_rows;
  const auto noise_of = [&](const VectorXd& rows) {
    const MatrixXd s = sensitivity * rows.asDiagonal();
    return VectorXd((s * estimator.noise()).cwiseProduct(s).rowwise().sum());
  };
  add("gyro noise", noise_of(gyro_rows));
  add("accelerometer noise", noise_of(accel_rows));
  const MatrixXd by_bias = sensitivity * turn_on_readings(motion);
  add("gyro turn-on", of_turn_on(plan.gyro_noise.turn_on, by_bias.rightCols<3>()));
  add("accelerometer turn-on", of_turn_on(plan.accel_noise.turn_on, by_bias.leftCols<3>()));
  // What is asked for but not determined stays at its start, and may be off by its prior.
  const VectorXd stated = uncertainty.covariance.diagonal();
  if (!out.undetermined.empty()) {
    VectorXd rest = stated - by_source.rowwise().squaredNorm() - noise_of(VectorXd::Ones(motion.rows()));
    if (plan.classical) rest.setZero();  // whose stated covariance knows nothing of the table
    add(undetermined_source, rest.cwiseMax(0.0));
  }
  const auto second = estimator.second_order({}, out.coefficients);
  out.bias = second.bias;
  out.second_order = second.covariance.diagonal().cwiseSqrt();
  // The estimate is generalized least squares: by default it reaches the bound.
  out.cramer_rao = plan.classical ? VectorXd(with_best_weights(plan, motion, out.coefficients).cwiseSqrt()) : out.first_order();
  return out;
}

MonteCarloResult monte_carlo(const TurntablePlan& plan, std::uint64_t runs, std::uint64_t seed, const std::function<void(std::uint64_t)>& progress) {
  const TableMotion motion(plan.observations, plan.rig, plan.site);
  const TurntableEstimator estimator = estimator_of(plan, motion);
  const std::vector<int> coefficients = estimator.uncertainty({}).determined;
  const auto n = static_cast<Index>(coefficients.size());
  const VectorXd bias = estimator.second_order({}, coefficients).bias, nominal = motion.nominal(), sigma = motion.sigma();
  VectorXd truth(n);
  for (Index i = 0; i < n; ++i) truth[i] = coefficient_value({}, coefficients[static_cast<std::size_t>(i)]);
  const MatrixXd turn_on = turn_on_readings(motion);
  const Eigen::LLT<MatrixXd> cholesky(estimator.noise());
  const Eigen::SparseMatrix<double> noise_factor = MatrixXd(cholesky.matrixL()).sparseView();
  const RandomStream table(seed, "predict: table errors"), noise(seed, "predict: noise"), bias_draws(seed, "predict: turn-on");

  constexpr std::uint64_t block = 128;
  const auto blocks = (runs + block - 1) / block;
  struct Moments {
    VectorXd first, second, fourth;
  };
  std::vector<Moments> moments(blocks);
  std::atomic<std::uint64_t> done = 0;
  tbb::parallel_for(std::uint64_t{0}, blocks, [&](std::uint64_t b) {
    const std::uint64_t begin = b * block, count = std::min(block, runs - begin);
    const auto columns = static_cast<Index>(count);
    const auto drawn = [&](const RandomStream& draws, Index rows) {
      MatrixXd out(rows, columns);
      draws.normals(begin * static_cast<std::uint64_t>(rows), {out.data(), static_cast<std::size_t>(out.size())});
      return out;
    };
    const MatrixXd errors = (sigma.asDiagonal() * drawn(table, sigma.size())).colwise() + nominal;
    MatrixXd biases = drawn(bias_draws, 6);
    for (Index axis = 0; axis < 6; ++axis) {
      const Spread& spread = (axis < 3 ? plan.accel_noise : plan.gyro_noise).turn_on;
      if (spread.fixed) biases.row(axis).setOnes();
      biases.row(axis) *= spread.value;
    }
    MatrixXd seen = noise_factor * drawn(noise, motion.rows());
    seen.noalias() += turn_on * biases;
    for (Index run = 0; run < columns; ++run) seen.col(run) += readings(motion, {}, motion.truth(errors.col(run)));
    const MatrixXd found = estimator.solve(estimator.linearised(seen));
    Moments m{VectorXd::Zero(n), VectorXd::Zero(n), VectorXd::Zero(n)};
    VectorXd error(n);
    for (Index run = 0; run < columns; ++run) {
      const SensorModel model = backward(found.col(run));
      for (Index i = 0; i < n; ++i) error[i] = coefficient_value(model, coefficients[static_cast<std::size_t>(i)]);
      error -= truth + bias;
      m.first += error;
      m.second += error.cwiseAbs2();
      m.fourth += error.cwiseAbs2().cwiseAbs2();
    }
    moments[b] = std::move(m);
    if (progress) progress(done += count);
  });
  Moments sum{VectorXd::Zero(n), VectorXd::Zero(n), VectorXd::Zero(n)};
  for (const Moments& m : moments) {  // in order: the same bits on any number of threads
    sum.first += m.first;
    sum.second += m.second;
    sum.fourth += m.fourth;
  }
  const auto count = static_cast<double>(runs);
  const VectorXd square = sum.second / count;
  return {coefficients, runs, sum.first / count, square.cwiseSqrt(),
          ((sum.fourth / count).cwiseQuotient(square.cwiseAbs2()).array() - 1).cwiseMax(0.0).sqrt() / (2 * std::sqrt(count))};
}

}  // namespace imulab
