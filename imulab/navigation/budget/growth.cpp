#include "imulab/navigation/budget/growth.hpp"

#include "imulab/coefficient.hpp"
#include "imulab/core/decomposition.hpp"
#include "imulab/error.hpp"
#include "imulab/navigation/integration/local_earth.hpp"

#include <algorithm>
#include <cmath>
#include <functional>
#include <utility>

namespace imulab::budget {

using motion::NominalMotion;

namespace {

using At = ErrorIndex;

/// Returns true if a covariance is positive up to rounding, in units of each coefficient's sigma.
bool positive(const Eigen::MatrixXd& covariance) {
  if (covariance.rows() == 0) return true;
  const Eigen::VectorXd scale = covariance.diagonal().unaryExpr([](double v) { return v > 0 ? 1 / std::sqrt(v) : 1; });
  const Eigen::MatrixXd scaled = scale.asDiagonal() * covariance * scale.asDiagonal();
  return (scaled - scaled.transpose()).cwiseAbs().maxCoeff() < 1e-9 && symmetric_eigenvalues(scaled).minCoeff() > -1e-9;
}

void check_sources(const NavigationState& start, const ErrorSources& sources, const BudgetOptions& options) {
  const auto n = static_cast<Eigen::Index>(sources.coefficients.size());
  if (!(options.block > 0)) throw Error("error budget: expected a block of positive duration");
  if (sources.fixed.size() != n || sources.covariance.rows() != n || sources.covariance.cols() != n)
    throw Error("errors along a motion: expected a fixed error of each coefficient and their covariance");
  if (!sources.fixed.allFinite() || !sources.covariance.allFinite() || (n > 0 && sources.covariance.diagonal().minCoeff() < 0))
    throw Error("errors along a motion: expected finite errors of the coefficients and variances not below zero");
  if (!positive(sources.covariance)) throw Error("errors along a motion: expected a symmetric, positive semidefinite covariance");
  if (!(sources.barometer.time_constant > 0)) throw Error("barometer: expected a positive time constant of its noise");
  if (sources.start.aligned_over && !(*sources.start.aligned_over > 0)) throw Error("alignment: expected a positive time");
  Strapdown(start, options.strapdown);  // checks that this start can be integrated
}

/// Returns this motion after a check that it has samples.
const NominalMotion& checked(const NominalMotion& motion) {
  check(motion);
  return motion;
}

std::vector<NoiseSource> noise_sources(const ErrorSources& sources, double interval) {
  std::vector<NoiseSource> out;
  const auto add = [&](NoiseSource::Acts acts, std::string name, double size, const NoiseProcesses& processes) {
    if (size != 0) out.push_back({acts, std::move(name), NoiseGrowth(processes, acts == NoiseSource::Acts::barometer ? 1 : 3)});
  };
  using Acts = NoiseSource::Acts;
  for (const bool gyro : {true, false}) {
    const NoiseModel& m = gyro ? sources.gyro_noise : sources.accel_noise;
    const std::string triad = gyro ? "gyro " : "accelerometer ";
    add(gyro ? Acts::gyro_white : Acts::accel_white, triad + "white noise", m.N, white_noise(m.N));
    add(gyro ? Acts::gyro : Acts::accel, triad + "flicker", m.B, flicker_noise(m.B, interval));
    add(gyro ? Acts::gyro : Acts::accel, triad + "random walk", m.K, random_walk(m.K));
    add(gyro ? Acts::gyro_white : Acts::accel_white, triad + "quantization", m.Q, white_noise(0));
    if (m.Q != 0) out.back().quantization = m.Q;
  }
  const BarometerErrors& b = sources.barometer;
  add(Acts::barometer, "barometer", b.noise, markov_noise(b.noise, b.time_constant));
  return out;
}

Matrix3d middle_attitude(const NavigationState& from, const NavigationState& to) {
  const double same_way = from.q_nb.dot(to.q_nb) < 0 ? -1 : 1;
  return Eigen::Quaterniond(Eigen::Vector4d(from.q_nb.coeffs() + same_way * to.q_nb.coeffs())).normalized().toRotationMatrix();
}

/// Returns the effect of a noise. White noise is equal in all axes, so the rotation within an interval does not matter.
ErrorColumns effect(NoiseSource::Acts acts, const ErrorColumns& by_rate, const ErrorColumns& by_force, const Matrix3d& turned, double length,
                    const ErrorState& by_barometer) {
  using Acts = NoiseSource::Acts;
  if (acts == Acts::gyro_white) return length * by_rate;
  if (acts == Acts::accel_white) return length * by_force;
  if (acts == Acts::gyro) return by_rate * turned;
  if (acts == Acts::accel) return by_force * turned;
  return length * by_barometer;
}

/// The vertical channel has no vertical velocity, or the height of the barometer.
bool fixed(const StrapdownOptions& options) { return options.vertical == VerticalChannel::fixed; }
bool held(const StrapdownOptions& options) { return options.vertical == VerticalChannel::held; }

}  // namespace

void check(const NominalMotion& motion) {
  if (motion.increments.empty() || motion.states.size() != motion.increments.size() + 1 || motion.time.size() != motion.states.size())
    throw Error("errors along a motion: no samples; expected at least one");
  if (std::adjacent_find(motion.time.begin(), motion.time.end(), std::greater_equal<>()) != motion.time.end())
    throw Error("errors along a motion: expected ascending times");
}

Outputs::Outputs(double begin, double interval) : begin_(begin), interval_(interval), next_(interval) {
  if (!(interval > 0)) throw Error("errors along a motion: expected a positive time between outputs");
}

bool Outputs::due(double time) {
  const double t = (time - begin_) * (1 + 1e-12);  // rounding must not delay an output to the next sample
  if (t < next_) return false;
  next_ = interval_ * (std::floor(t / interval_) + 1);
  return true;
}

ErrorGrowth::ErrorGrowth(double begin, double interval, const NavigationState& start_state, const ErrorSources& sources, const BudgetOptions& options)
    : begin_(begin),
      start_(start_state),
      block_{{begin}, {start_state}, {}},
      longest_block_(options.block),
      outputs_(begin, options.output_interval),
      options_(options.strapdown),
      effects_(sources.model, sources.coefficients, sources.accel_tau, sources.gyro_tau),
      columns_{static_cast<Eigen::Index>(sources.coefficients.size())},
      sensitivity_(ErrorColumns::Zero(At::count, columns_.count)) {
  check_sources(start_, sources, options);
  noises_ = noise_sources(sources, interval);
  start();
  if (sources.start.aligned_over) align(sources.start);
  for (NoiseSource& n : noises_)
    if (n.quantization != 0) quantize(n, sources.start);
}

ErrorGrowth::ErrorGrowth(const NominalMotion& motion, const ErrorSources& sources, const BudgetOptions& options)
    : ErrorGrowth(checked(motion).time[0], motion.time[1] - motion.time[0], motion.states[0], sources, options) {}

bool ErrorGrowth::add(double time, const NavigationState& state, const Increment& sample) {
  if (!(time > block_.time.back())) throw Error("errors along a motion: expected ascending times");
  if (!block_.increments.empty() && time > (block_.time.front() + longest_block_) * (1 + 1e-12)) end_block();
  block_.time.push_back(time);
  block_.states.push_back(state);
  block_.increments.push_back(sample);
  any_ = true;
  if (!outputs_.due(time)) return false;
  end_block();
  return true;
}

bool ErrorGrowth::finish() {
  if (!any_) throw Error("errors along a motion: no samples; expected at least one");
  if (block_.increments.empty()) return false;
  end_block();
  return true;
}

/// Ends a block; the next one begins at its last sample.
void ErrorGrowth::end_block() {
  const std::size_t count = block_.increments.size();
  const double begin = block_.time.front(), end = block_.time.back(), length = end - begin, middle = (end + begin) / 2;
  Vector3d pushed = Vector3d::Zero();
  Matrix3d turned = Matrix3d::Zero();  // integral of C_nb
  effects_.clear();
  for (std::size_t i = 0; i < count; ++i) {
    const double T = block_.time[i + 1] - block_.time[i];
    const Matrix3d C_nb = middle_attitude(block_.states[i], block_.states[i + 1]);
    const Increment& sample = block_.increments[i];
    pushed += C_nb * sample.velocity;
    turned += T * C_nb;
    effects_.add(C_nb, {.rate = sample.angle / T, .force = sample.velocity / T}, T);
  }
  const ErrorDynamics d = error_dynamics(block_.states[count / 2], pushed / length, options_);
  const ErrorMatrix half = error_transition(d.F, length / 2), whole = half * half;
  // The sensors' terms of Xu's eqs 1 and 2, -C_nb dw and C_nb df, act at the middle of the block.
  const ErrorColumns by_rate = -half.middleCols<3>(At::attitude);
  ErrorColumns by_force = half.middleCols<3>(At::velocity);
  if (fixed(options_)) by_force.col(2).setZero();

  sensitivity_ = (whole * sensitivity_).eval();
  sensitivity_.leftCols(columns_.coefficients) += by_rate * effects_.rate() + by_force * effects_.force();
  add_unit(by_rate * turned, by_force * turned, aligned_ + middle - begin_);
  sensitivity_.col(columns_.barometer) += length * (half * d.b);
  for (NoiseSource& n : noises_) n.growth.step(whole, effect(n.acts, by_rate, by_force, turned, length, half * d.b), length);

  block_.time.erase(block_.time.begin(), block_.time.end() - 1);
  block_.states.erase(block_.states.begin(), block_.states.end() - 1);
  block_.increments.clear();
}

void ErrorGrowth::start() {
  // The columns have the order position, velocity, attitude.
  for (const auto& [column, row] : {std::pair{0, At::position}, {3, At::velocity}, {6, At::attitude}})
    sensitivity_.block<3, 3>(row, columns_.start + column).setIdentity();
  if (fixed(options_)) sensitivity_(At::velocity + 2, columns_.start + 5) = 0;  // no vertical velocity at the start
  if (held(options_)) sensitivity_(At::up, columns_.start + 2) = 0;             // the first barometer height replaces it
}

/// Rotates the start by the mean sensor errors over the alignment.
void ErrorGrowth::align(const StartErrors& errors) {
  const double duration = *errors.aligned_over;
  const NavigationState& s = start_;
  const Eigen::Matrix<double, 3, 6> tilt = alignment_effect(s, errors, options_);
  const Matrix3d C_nb = s.q_nb.toRotationMatrix();
  const LocalEarth earth = integration::earth_at(s.latitude, s.height, options_);
  ErrorColumns by_rate = ErrorColumns::Zero(At::count, 3), by_force = by_rate;
  by_rate.middleRows<3>(At::attitude) = tilt.leftCols<3>();
  by_force.middleRows<3>(At::attitude) = tilt.rightCols<3>();
  effects_.clear();
  effects_.add(C_nb, {.rate = C_nb.transpose() * earth.rate, .force = -C_nb.transpose() * earth.gravity}, 1);
  sensitivity_.leftCols(columns_.coefficients) += by_rate * effects_.rate() + by_force * effects_.force();
  add_unit(by_rate * C_nb, by_force * C_nb, duration / 2);
  for (NoiseSource& n : noises_)
    n.growth.step(ErrorMatrix::Identity(), effect(n.acts, by_rate / duration, by_force / duration, duration * C_nb, duration, ErrorState::Zero()),
                  duration);
  aligned_ = duration;
}

/// The integral of a triad's output has an independent error n_k of size Q at each reading k: over the motion n_k - n_0, and in the mean of an
/// earlier alignment (n_0 - n_-m) / duration. The effect of the n_k in between does not accumulate and is neglected.
void ErrorGrowth::quantize(NoiseSource& noise, const StartErrors& errors) {
  const bool gyro = noise.acts == NoiseSource::Acts::gyro_white;
  ErrorColumns by_first = ErrorColumns::Zero(At::count, 3), by_alignment = by_first;
  by_first.middleRows<3>(gyro ? At::attitude : At::velocity) = (gyro ? 1 : -1) * Matrix3d::Identity();
  if (errors.aligned_over)
    by_alignment.middleRows<3>(At::attitude) = alignment_effect(start_, errors, options_).middleCols<3>(gyro ? 0 : 3) / *errors.aligned_over;
  if (fixed(options_)) by_first.row(At::velocity + 2).setZero();
  by_first += by_alignment;
  noise.growth.add(noise.quantization * noise.quantization * (by_first * by_first.transpose() + by_alignment * by_alignment.transpose()));
}

void ErrorGrowth::add_unit(const ErrorColumns& gyro, const ErrorColumns& accel, double time) {
  sensitivity_.middleCols<3>(columns_.gyro_unit) += gyro;
  sensitivity_.middleCols<3>(columns_.accel_unit) += accel;
  sensitivity_.middleCols<3>(columns_.gyro_ramp) += time * gyro;
  sensitivity_.middleCols<3>(columns_.accel_ramp) += time * accel;
}

ErrorColumns ErrorGrowth::sensitivities() const {
  ErrorColumns out = sensitivity_;
  if (held(options_)) out(At::up, columns_.barometer) = 1;
  return out;
}

ErrorMatrix ErrorGrowth::noise_covariance(std::size_t i) const {
  const NoiseSource& n = noises_[i];
  ErrorMatrix out = n.growth.covariance();
  if (held(options_) && n.acts == NoiseSource::Acts::barometer) {
    out.row(At::up) = n.growth.with_noise(0).transpose();
    out.col(At::up) = n.growth.with_noise(0);
    out(At::up, At::up) = n.growth.noise_variance();
  }
  const int integral = n.acts == NoiseSource::Acts::gyro_white ? At::attitude : At::velocity;
  for (int k = 0; k < 3; ++k)  // adds the noise of the last reading
    if (integral + k != At::velocity + 2 || !fixed(options_)) out(integral + k, integral + k) += n.quantization * n.quantization;
  return out;
}

std::vector<std::size_t> output_samples(const NominalMotion& motion, double interval) {
  Outputs outputs(motion.time.front(), interval);
  std::vector<std::size_t> out;
  for (std::size_t i = 1; i < motion.time.size(); ++i)
    if (outputs.due(motion.time[i]) || i + 1 == motion.time.size()) out.push_back(i);
  return out;
}

Eigen::Matrix<double, 3, 6> alignment_effect(const NavigationState& start, const StartErrors& errors, const StrapdownOptions& options) {
  const LocalEarth earth = local_earth(start.latitude, start.height);
  const double g = options.gravity.value_or(earth.gravity.norm()), horizontal = earth.rate.y();
  Eigen::Matrix<double, 3, 6> out = Eigen::Matrix<double, 3, 6>::Zero();
  out(1, 3) = 1 / g;   // phi_N = df_E / g
  out(0, 4) = -1 / g;  // phi_E = -df_N / g
  if (errors.heading_given()) return out;
  out.row(2) = earth.sin_latitude / earth.cos_latitude * out.row(1);
  out(2, 0) = -1 / horizontal;  // phi_U = phi_N tan L - dw_E / (w_ie cos L)
  return out;
}

ErrorColumns error_sensitivities(const NominalMotion& motion, const ErrorSources& sources, const BudgetOptions& options) {
  ErrorGrowth growth(motion, sources, options);
  for (std::size_t i = 0; i < motion.increments.size(); ++i) growth.add(motion.time[i + 1], motion.states[i + 1], motion.increments[i]);
  growth.finish();
  return growth.sensitivities();
}

}  // namespace imulab::budget
