#include "imulab/navigation/budget/monte_carlo.hpp"

#include "imulab/coefficient.hpp"
#include "imulab/compensate.hpp"
#include "imulab/core/decomposition.hpp"
#include "imulab/core/random.hpp"
#include "imulab/core/rotation.hpp"
#include "imulab/eigen.hpp"
#include "imulab/error.hpp"
#include "imulab/grade.hpp"
#include "imulab/model/gauge.hpp"
#include "imulab/model/sensor_noise.hpp"
#include "imulab/navigation/budget/growth.hpp"
#include "imulab/navigation/budget/run_statistics.hpp"
#include "imulab/navigation/integration/local_earth.hpp"

#include <Eigen/Cholesky>
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <string>

namespace imulab {
namespace {

using namespace budget;
using Eigen::MatrixXd;
using Eigen::VectorXd;
using integration::earth_at;
using motion::NominalMotion;
using Columns = std::array<std::vector<double>, 6>;  // rate x y z, force x y z

/// Returns a factor A of a covariance A A^T, which may be singular.
MatrixXd factor(const MatrixXd& covariance) {
  if (covariance.size() == 0) return covariance;
  const SymmetricEigen eigen = symmetric_eigen(covariance);
  return eigen.vectors * eigen.values.cwiseMax(0.0).cwiseSqrt().asDiagonal();
}

MotionColumns spans(Columns& columns) {
  MotionColumns out;
  for (std::size_t axis = 0; axis < 3; ++axis) out.rate[axis] = columns[axis], out.force[axis] = columns[axis + 3];
  return out;
}

/// Data common to all runs.
struct Plan {
  const NominalMotion& motion;
  const ErrorSources& sources;
  const MonteCarloOptions& options;
  MatrixXd coefficient_factor;
  double interval = 0;
  std::size_t rest = 0;              // number of samples of the alignment, before the motion
  std::vector<std::size_t> outputs;  // sample numbers
  bool barometer = false;

  Plan(const NominalMotion& m, const ErrorSources& s, const MonteCarloOptions& o)
      : motion(m), sources(s), options(o), coefficient_factor(factor(s.covariance)), interval(m.time[1] - m.time[0]) {
    if (s.start.aligned_over) rest = std::max<std::size_t>(1, static_cast<std::size_t>(std::llround(*s.start.aligned_over / interval)));
    barometer = o.strapdown.vertical == VerticalChannel::aided || o.strapdown.vertical == VerticalChannel::held;
    outputs = output_samples(m, o.output_interval);
  }
};

/// Returns the mean rate and force of each sample: the rest of the alignment, then the motion.
Columns true_motion(const Plan& plan) {
  Columns out;
  for (auto& column : out) column.reserve(plan.rest + plan.motion.increments.size());
  const auto add = [&](const Vector3d& rate, const Vector3d& force) {
    for (std::size_t axis = 0; axis < 3; ++axis) {
      out[axis].push_back(rate[static_cast<Eigen::Index>(axis)]);
      out[axis + 3].push_back(force[static_cast<Eigen::Index>(axis)]);
    }
  };
  const NavigationState& start = plan.motion.states.front();
  const LocalEarth earth = earth_at(start.latitude, start.height, plan.options.strapdown);
  const Eigen::Quaterniond q_bn = start.q_nb.conjugate();
  for (std::size_t i = 0; i < plan.rest; ++i) add(q_bn * earth.rate, -(q_bn * earth.gravity));
  for (std::size_t i = 0; i < plan.motion.increments.size(); ++i) {
    const double T = plan.motion.time[i + 1] - plan.motion.time[i];
    add(plan.motion.increments[i].angle / T, plan.motion.increments[i].velocity / T);
  }
  return out;
}

double drawn(const Spread& spread, const RandomStream& stream, std::uint64_t index) {
  return spread.fixed ? spread.value : spread.value * stream.normal(index);
}

SensorModel drawn_model(const Plan& plan, const std::string& run) {
  const RandomStream stream(plan.options.seed, "coefficients of " + run);
  VectorXd normal(plan.coefficient_factor.cols());
  stream.normals(0, {normal.data(), static_cast<std::size_t>(normal.size())});
  const VectorXd error = plan.sources.fixed + plan.coefficient_factor * normal;
  SensorModel model = plan.sources.model;
  for (std::size_t k = 0; k < plan.sources.coefficients.size(); ++k) {
    const CoefficientIndex index = plan.sources.coefficients[k];
    set_coefficient(model, index, coefficient_value(model, index) + error[static_cast<Eigen::Index>(k)]);
  }
  return model;
}

/// Converts the true motion to raw readings of the unit with noise, and compensates these with the erroneous model.
Columns compensated(const Plan& plan, const Columns& truth, const std::string& run) {
  Columns out = truth;
  for (std::size_t axis = 0; axis < 6; ++axis) {
    const AxisNoise noise(axis < 3 ? plan.sources.gyro_noise : plan.sources.accel_noise, plan.interval, plan.options.seed,
                          fmt::format("axis {} of {}", axis, run));
    if (noise.slow()) noise.add_slow(out[axis]);
    noise.add_fast(0, out[axis]);
  }
  // Thermal readings are constant, so the raw reading includes their drift.
  const ErrorSources& s = plan.sources;
  const auto at = [](TriadModel m, const Vector3d& tau) {
    const Vector3d drift = m.drift(tau);
    m = with_factor(m, m.matrix_factor(tau));
    m.remove_temperature();
    m.thermal.col(0) = drift;
    return m;
  };
  SensorModel true_model = s.model, assumed = drawn_model(plan, run);
  true_model.accel = at(s.model.accel, s.accel_tau), true_model.gyro = at(s.model.gyro, s.gyro_tau);
  assumed.accel = at(assumed.accel, s.accel_tau), assumed.gyro = at(assumed.gyro, s.gyro_tau);
  assumed.accel.thermal.col(0) -= true_model.accel.thermal.col(0), assumed.gyro.thermal.col(0) -= true_model.gyro.thermal.col(0);
  true_model.accel.thermal.setZero(), true_model.gyro.thermal.setZero();
  const MotionColumns columns = spans(out);
  decompensate(true_model, {}, {}, columns);
  RawColumns raw;
  for (std::size_t axis = 0; axis < 3; ++axis) raw.gyro[axis] = columns.rate[axis], raw.accel[axis] = columns.force[axis];
  compensate(assumed, raw, columns);
  return out;
}

NavigationState start_of(const Plan& plan, const Columns& seen, const std::string& run) {
  const StartErrors& s = plan.sources.start;
  const NavigationState& truth = plan.motion.states.front();
  const RandomStream stream(plan.options.seed, "start of " + run);
  ErrorState error = ErrorState::Zero();
  for (std::uint64_t k = 0; k < 3; ++k) {
    const auto i = static_cast<Eigen::Index>(k);
    error[ErrorIndex::position + i] = drawn(s.position[k], stream, k);
    error[ErrorIndex::velocity + i] = drawn(s.velocity[k], stream, 3 + k);
    if (!s.aligned_over || k == 2) error[ErrorIndex::attitude + i] = drawn(s.attitude[k], stream, 6 + k);
  }
  NavigationState start = with_error(truth, error);
  if (s.aligned_over) {  // gravity gives the level, the Earth's rate the heading unless that is given
    Eigen::Matrix<double, 6, 1> mean;
    for (std::size_t axis = 0; axis < 6; ++axis)
      mean[static_cast<Eigen::Index>(axis)] = Eigen::Map<const VectorXd>(seen[axis].data(), static_cast<Eigen::Index>(plan.rest)).mean();
    const LocalEarth earth = earth_at(truth.latitude, truth.height, plan.options.strapdown);
    NavigationState level = truth;
    const Vector3d east = Vector3d::UnitX(), seen_east = truth.q_nb.conjugate() * east;
    const bool given = s.heading_given();
    level.q_nb = Eigen::Quaterniond(
        rotation_from_directions(-earth.gravity, given ? east : earth.rate, mean.tail<3>(), given ? seen_east : Vector3d(mean.head<3>())));
    ErrorState heading = ErrorState::Zero();
    heading[ErrorIndex::attitude + 2] = error[ErrorIndex::attitude + 2];
    start.q_nb = given ? with_error(level, heading).q_nb : level.q_nb;
  }
  return start;
}

/// Returns the measured sample that leads to state i + 1.
Increment sample_of(const Plan& plan, const Columns& seen, std::size_t i) {
  const std::size_t k = plan.rest + i;
  const double T = plan.motion.time[i + 1] - plan.motion.time[i];
  return {T * Vector3d(seen[0][k], seen[1][k], seen[2][k]), T * Vector3d(seen[3][k], seen[4][k], seen[5][k])};
}

/// The barometer of a run: its bias, and a process from sample to sample.
class DrawnBarometer {
 public:
  DrawnBarometer(const BarometerErrors& errors, double interval, std::uint64_t seed, const std::string& run)
      : noisy_(errors.noise != 0),
        decay_(std::exp(-interval / errors.time_constant)),
        fresh_(errors.noise * std::sqrt(-std::expm1(-2 * interval / errors.time_constant))),
        stream_(seed, "barometer of " + run),
        bias_(drawn(errors.bias, RandomStream(seed, "barometer bias of " + run), 0)),
        slow_(errors.noise * stream_.normal(0)) {}

  double error() const { return bias_ + slow_; }
  /// Returns the error at the state after sample i.
  double next(std::size_t i) {
    if (noisy_) slow_ = decay_ * slow_ + fresh_ * stream_.normal(i + 1);
    return error();
  }

 private:
  bool noisy_;
  double decay_, fresh_;
  RandomStream stream_;
  double bias_, slow_;
};

/// Returns errors at the outputs; the last one is the end.
BudgetRows flown(const Plan& plan, const Columns& truth, std::uint64_t number) {
  const std::string run = fmt::format("run {}", number);
  const Columns seen = compensated(plan, truth, run);
  DrawnBarometer barometer(plan.sources.barometer, plan.interval, plan.options.seed, run);
  BudgetRows out(budget_quantities, static_cast<Eigen::Index>(plan.outputs.size()));
  Strapdown strapdown(start_of(plan, seen, run), plan.options.strapdown);
  std::size_t next = 0;
  for (std::size_t i = 0; i < plan.motion.increments.size(); ++i) {
    const double T = plan.motion.time[i + 1] - plan.motion.time[i];
    const Increment sample = sample_of(plan, seen, i);
    if (plan.barometer) {
      strapdown.step(sample, T, plan.motion.states[i + 1].height + barometer.next(i));
    } else {
      strapdown.step(sample, T);
    }
    if (plan.outputs[next] != i + 1) continue;
    const ErrorState error = error_of(strapdown.state(), plan.motion.states[i + 1]);
    out.col(static_cast<Eigen::Index>(next++)) << error.segment<3>(ErrorIndex::position), error.segment<3>(ErrorIndex::velocity),
        error.segment<3>(ErrorIndex::attitude);
  }
  return out;
}

/// Runs begin ... begin + count - 1; the first `kept` are also stored individually.
struct RunBlock {
  std::uint64_t begin = 0, count = 0, kept = 0;
};

RunBlock run_block(std::uint64_t number, std::uint64_t size, std::uint64_t runs) {
  const std::uint64_t begin = number * size, count = std::min(size, runs - begin);
  return {begin, count, begin < most_kept_runs ? std::min(count, most_kept_runs - begin) : 0};
}

void expect_room(const Plan& plan, std::uint64_t runs) {
  constexpr double bins = 2000, bytes_a_bin = 24, most = 1 << 30;
  const double bytes = static_cast<double>(plan.outputs.size()) * (budget_quantities + 1) * std::min(bins, static_cast<double>(runs)) * bytes_a_bin;
  if (bytes > most)
    throw Error(
        fmt::format("Monte Carlo: the distributions of {} runs at {} outputs would keep {:.3g} GB: expected at most {:.3g} GB; take a longer "
                    "time between outputs",
                    runs, plan.outputs.size(), bytes / 1e9, most / 1e9));
}

}  // namespace

ErrorDistribution error_monte_carlo(const NominalMotion& motion, const ErrorSources& sources, const MonteCarloOptions& options,
                                    const std::function<void(std::uint64_t)>& progress, const Sharing* sharing) {
  const ErrorGrowth checks(motion, sources, {.strapdown = options.strapdown});
  if (options.runs == 0) throw Error("Monte Carlo: no runs; expected at least one");
  const Plan plan(motion, sources, options);
  expect_room(plan, options.runs);
  ErrorDistribution out;
  for (const std::size_t i : plan.outputs) out.time.push_back(motion.time[i]);
  out.runs = options.runs;
  const auto kept = static_cast<Eigen::Index>(std::min(options.runs, most_kept_runs));
  for (BudgetRows* rows : {&out.end, &out.peak}) rows->resize(budget_quantities, kept);
  const Columns truth = true_motion(plan);
  constexpr std::uint64_t most_blocks = 1 << 16;
  const std::uint64_t size = (options.runs + most_blocks - 1) / most_blocks;
  RunStatistics all(plan.outputs.size());
  SharedWork flights{.count = (options.runs + size - 1) / size, .work = {}, .take = {}};
  flights.work = [&](std::size_t b) {
    const RunBlock block = run_block(b, size, options.runs);
    RunStatistics statistics(plan.outputs.size());
    std::string bytes;
    for (std::uint64_t k = 0; k < block.count; ++k) {
      const BudgetRows errors = flown(plan, truth, block.begin + k);
      statistics.add(errors);
      if (k >= block.kept) continue;
      Eigen::Matrix<double, budget_quantities, 2> ends;
      ends << errors.rightCols<1>(), errors.cwiseAbs().rowwise().maxCoeff();
      bytes += bytes_of(ends.data(), static_cast<std::size_t>(ends.size()));
    }
    statistics.write(bytes);
    return bytes;
  };
  flights.take = [&](std::size_t b, const std::string& bytes) {
    const RunBlock block = run_block(b, size, options.runs);
    std::string_view left = bytes;
    for (std::uint64_t k = 0; k < block.kept; ++k) {
      Eigen::Matrix<double, budget_quantities, 2> ends;
      read_numbers(std::string(left.substr(0, sizeof ends)), ends.data(), static_cast<std::size_t>(ends.size()));
      left.remove_prefix(sizeof ends);
      const auto run = static_cast<Eigen::Index>(block.begin + k);
      out.end.col(run) = ends.col(0), out.peak.col(run) = ends.col(1);
    }
    RunStatistics statistics(plan.outputs.size());
    statistics.read(left);
    all.add(statistics);
  };
  if (progress) flights.progress = [&](std::size_t done) { progress(std::min<std::uint64_t>(options.runs, done * size)); };
  for_each(flights, sharing);
  const double duration = motion.time.back() - motion.time.front();
  all.summarize(out, duration);
  for (Eigen::Index k = 0; k < kept; ++k) out.drift.push_back(out.end.block<2, 1>(0, k).norm() / duration);
  return out;
}

std::vector<Increment> erring_increments(const NominalMotion& motion, const ErrorSources& sources, std::uint64_t seed) {
  ErrorSources moving = sources;
  moving.start.aligned_over.reset();  // the rest of an alignment is not part of the motion
  const MonteCarloOptions options{.seed = seed};
  const Plan plan(motion, moving, options);
  const Columns seen = compensated(plan, true_motion(plan), "run 0");
  std::vector<Increment> out;
  for (std::size_t i = 0; i < motion.increments.size(); ++i) out.push_back(sample_of(plan, seen, i));
  return out;
}

HeightRecord erring_heights(const NominalMotion& motion, const BarometerErrors& errors, std::uint64_t seed, std::size_t every) {
  DrawnBarometer barometer(errors, motion.time[1] - motion.time[0], seed, "run 0");
  HeightRecord out;
  const auto add = [&](std::size_t i, double error) {
    out.time.push_back(motion.time[i]);
    out.height.push_back(motion.states[i].height + error);
  };
  add(0, barometer.error());
  for (std::size_t i = 1; i < motion.states.size(); ++i) {
    const double error = barometer.next(i - 1);
    if (i % every == 0 || i + 1 == motion.states.size()) add(i, error);
  }
  return out;
}

}  // namespace imulab
