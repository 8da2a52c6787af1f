#include "imulab/estimate/extrinsics/motion_fit.hpp"

#include "imulab/core/random.hpp"
#include "imulab/core/rotation.hpp"

#include <Eigen/Geometry>

#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>
#include <utility>

namespace imulab::extrinsics {
namespace {

using ThreeRows = BorderedBand::ThreeRows;

constexpr int per_knot = 6;
constexpr double knots_of_margin = 6;
/// One sigma of the rate [rad/s] and force [m/s^2] at a knot before the data: any motion, but bounded where no sample is.
constexpr double any_rate = 100, any_force = 1000;
constexpr double least_sigma = 1e-9;

double square(double x) { return x * x; }

/// The columns of 3 x 3 errors that a vector is multiplied with: d (M v) / d M, by rows.
void put_matrix(ThreeRows& jacobian, Eigen::Index first, const Vector3d& v) {
  for (int i = 0; i < 3; ++i) jacobian.block<1, 3>(i, first + 3 * i) = v.transpose();
}

}  // namespace

/// Means over a sample's interval, with their derivatives by the motion's knots.
struct MotionFit::Means {
  Eigen::Index first = 0;                            ///< knot
  Eigen::VectorXd value;                             ///< weights of the knots
  Eigen::Matrix<double, 3, Eigen::Dynamic> by_rate;  ///< d u / d rate at the knots
  Vector3d rate = Vector3d::Zero(), rate_slope = Vector3d::Zero();
  Vector3d u = Vector3d::Zero(), u_slope = Vector3d::Zero();  ///< force at the lever arm, in the first IMU's axes
  Matrix3d by_arm = Matrix3d::Zero();
};

MotionFit::MotionFit(std::vector<Stream> streams, std::vector<ImuState> states, std::vector<Prior> priors, std::vector<Span> spans, double tilt_sigma)
    : streams_(std::move(streams)), states_(std::move(states)), priors_(std::move(priors)), spans_(std::move(spans)), tilt_sigma_(tilt_sigma) {
  double shortest = HUGE_VAL, longest = 0;
  for (const Stream& s : streams_) shortest = std::min(shortest, s.interval), longest = std::max(longest, s.interval);
  knot_s_ = 1.5 * shortest;  // at knots of one interval, a motion that changes its sign with each of them would not be seen
  longest_ = 4 + static_cast<Eigen::Index>(std::ceil(1.2 * longest / knot_s_));
  Eigen::Index knots = 0;
  for (const Span& span : spans_) {
    first_knot_.push_back(knots);
    knots += static_cast<Eigen::Index>(span.length() / knot_s_ + 2 * knots_of_margin) + 4;
  }
  motion_ = Eigen::VectorXd::Zero(per_knot * knots);
  epoch_ = 0.5 * (spans_.front().begin + spans_.back().end);
  constants_ = mount_column(states_.size() - 1) + mount_columns;
  for (const ImuState& state : states_) start_offsets_.push_back(state.offset);
  sums_.resize(2 * states_.size()), weights_.resize(2 * states_.size());
  for (std::size_t k = 0; k < states_.size(); ++k) {
    const int own = k == 0 ? 0 : mount_column(k) - own_columns, mount = own + own_columns;
    columns_.emplace_back(18), columns_.emplace_back(9);
    std::vector<int>&of_gyros = columns_[2 * k], &of_accels = columns_[2 * k + 1];
    std::iota(of_gyros.begin(), of_gyros.end(), own + gyro_matrix);
    std::iota(of_accels.begin(), of_accels.end(), own + accel_matrix);
    for (int i = 0; i < 3; ++i) of_gyros.push_back(own + gyro_offset + i), of_accels.push_back(own + accel_offset + i);
    if (k == 0) continue;
    for (const int c : {+turn, turn + 1, turn + 2, +offset, +drift}) of_gyros.push_back(mount + c);
    for (int c = 0; c < mount_columns; ++c) of_accels.push_back(mount + c);
  }
}

MotionFit::Place MotionFit::place_at(double t, std::size_t span) const {
  const double from_begin = (t - spans_[span].begin) / knot_s_ + knots_of_margin;
  const Eigen::Index end = span + 1 < spans_.size() ? first_knot_[span + 1] : motion_.size() / per_knot;
  const double inside = std::clamp(from_begin, 0., static_cast<double>(end - first_knot_[span] - 4));
  Place p;
  p.knot = static_cast<Eigen::Index>(inside);
  const double u = inside - static_cast<double>(p.knot), v = 1 - u, h = knot_s_;
  p.knot += first_knot_[span];
  const std::array value{v * v * v / 6, (3 * u * u * u - 6 * u * u + 4) / 6, (3 * v * v * v - 6 * v * v + 4) / 6, u * u * u / 6};
  const std::array first{-v * v / 2, (3 * u * u - 4 * u) / 2, -(3 * v * v - 4 * v) / 2, u * u / 2};
  const std::array second{v, 3 * u - 2, 3 * v - 2, u};
  for (std::size_t i = 0; i < 4; ++i) p.value[i] = value[i], p.first[i] = first[i] / h, p.second[i] = second[i] / (h * h);
  return p;
}

MotionFit::Means MotionFit::means_over(const ImuState& state, const Sample& sample, std::size_t span, double delayed) const {
  const auto on_first_clock = [&](double t) { return t - state.offset - delayed - state.drift * (t - state.offset - epoch_); };
  const double begin = on_first_clock(sample.begin), length = on_first_clock(sample.end) - begin;
  const int parts = std::max(1, static_cast<int>(std::ceil(length / knot_s_ - 0.1)));
  Means m;
  m.first = place_at(begin, span).knot;
  m.value = Eigen::VectorXd::Zero(longest_);
  m.by_rate = Eigen::Matrix<double, 3, Eigen::Dynamic>::Zero(3, 3 * longest_);
  m.first = std::min(m.first, motion_.size() / per_knot - longest_);
  const Vector3d& r = state.lever_arm;
  const Matrix3d across = skew<double>(r);
  const double weight = 0.5 / parts;
  for (int k = 0; k < parts; ++k)
    for (const double gauss : {0.5 - 0.5 / std::sqrt(3.), 0.5 + 0.5 / std::sqrt(3.)}) {
      const Place p = place_at(begin + length * (k + gauss) / parts, span);
      Vector3d w = Vector3d::Zero(), w1 = w, w2 = w, f = w, f1 = w;
      for (int i = 0; i < 4; ++i) {
        const auto rate = motion_.segment<3>(per_knot * (p.knot + i)), force = motion_.segment<3>(per_knot * (p.knot + i) + 3);
        w += p.value[i] * rate, w1 += p.first[i] * rate, w2 += p.second[i] * rate, f += p.value[i] * force, f1 += p.first[i] * force;
      }
      const Matrix3d by_w = w.dot(r) * Matrix3d::Identity() + w * r.transpose() - 2 * r * w.transpose();  // of w x (w x r)
      const Matrix3d turning = skew<double>(w);
      m.rate += weight * w, m.rate_slope += weight * w1;
      m.u += weight * (f + w1.cross(r) + w.cross(w.cross(r)));
      m.u_slope += weight * (f1 + w2.cross(r) + by_w * w1);
      m.by_arm += weight * (skew<double>(w1) + turning * turning);
      for (int i = 0; i < 4; ++i) {
        const Eigen::Index place = std::min(p.knot + i - m.first, longest_ - 1);
        m.value[place] += weight * p.value[i];
        m.by_rate.middleCols<3>(3 * place) += weight * (p.value[i] * by_w - p.first[i] * across);
      }
    }
  return m;
}

template <class Use>
void MotionFit::for_each_reading(const Use& use) const {
  for (std::size_t k = 0; k < states_.size(); ++k) {
    const std::vector<Sample>& samples = streams_[k].samples;
    for (std::size_t s = 0; s < spans_.size(); ++s) {
      const double begin = spans_[s].begin + start_offsets_[k], end = spans_[s].end + start_offsets_[k];
      auto sample = std::lower_bound(samples.begin(), samples.end(), begin, [](const Sample& x, double t) { return x.begin < t; });
      for (; sample != samples.end() && sample->end <= end; ++sample)
        for (const Sensor sensor : {gyros, accels}) use(k, sensor, s, *sample);
    }
  }
}

MotionFit::Equation MotionFit::equation_of(std::size_t k, Sensor sensor, std::size_t span, const Sample& sample) const {
  const ImuState& state = states_[k];
  const bool gyro = sensor == gyros;
  const Means m = means_over(state, sample, span, gyro ? 0 : state.delay);
  const Matrix3d scale = Matrix3d::Identity() + state.matrix(gyro ? gyro_matrix : accel_matrix), to_output = scale * state.rotation;
  const Vector3d turned = state.rotation * (gyro ? m.rate : m.u), slope = to_output * (gyro ? m.rate_slope : m.u_slope);
  Equation e;
  e.first = per_knot * m.first;
  e.knots = ThreeRows::Zero(3, per_knot * longest_);
  for (Eigen::Index j = 0; j < longest_; ++j) {
    if (gyro) e.knots.middleCols<3>(per_knot * j) = m.value[j] * to_output;
    if (!gyro) e.knots.middleCols<3>(per_knot * j) = to_output * m.by_rate.middleCols<3>(3 * j);
    if (!gyro) e.knots.middleCols<3>(per_knot * j + 3) = m.value[j] * to_output;
  }
  e.constants = ThreeRows::Zero(3, std::ssize(columns_[2 * k + sensor]));
  put_matrix(e.constants, 0, turned);
  if (gyro) put_matrix(e.constants, 9, sample.force);
  Eigen::Index column = gyro ? 18 : 9;
  e.constants.middleCols<3>(column).setIdentity();
  e.residual = (gyro ? sample.rate : sample.force) - scale * turned - state.errors.segment<3>(gyro ? gyro_offset : accel_offset);
  if (gyro) e.residual -= state.matrix(g_sensitivity) * sample.force;
  if (k == 0) return e;
  column += 3;
  e.constants.middleCols<3>(column + turn) = -scale * skew<double>(turned);
  if (!gyro) e.constants.middleCols<3>(column + arm) = to_output * m.by_arm;
  column += gyro ? 3 : 6;
  e.constants.col(column) = -slope;
  e.constants.col(column + 1) = -slope * (sample.end - state.offset - epoch_);
  if (!gyro) e.constants.col(column + 2) = -slope;
  return e;
}

void MotionFit::add_priors(BorderedBand& equations, Eigen::VectorXd& border) const {
  for (std::size_t k = 0; k < states_.size(); ++k) {
    const auto first = static_cast<Eigen::Index>(k == 0 ? 0 : mount_column(k) - own_columns);
    equations.corner.block<own_columns, own_columns>(first, first) += priors_[k];
    border.segment<own_columns>(first) -= priors_[k] * states_[k].errors;
    if (k == 0) continue;
    const Eigen::Index mount = mount_column(k);
    const auto add = [&](Eigen::Index column, double sigma, double value) {
      equations.corner(mount + column, mount + column) += 1 / square(sigma);
      border[mount + column] -= value / square(sigma);
    };
    for (int i = 0; i < 3; ++i) add(turn + i, any_turn, 0), add(arm + i, any_arm, states_[k].lever_arm[i]);
    add(offset, any_offset, states_[k].offset - start_offsets_[k]);
    add(drift, any_drift, states_[k].drift), add(delay, any_delay, states_[k].delay);
  }
  for (Eigen::Index i = 0; i < equations.band.rows(); ++i)
    equations.band(i, equations.band.cols() - 1) += 1 / square(i % per_knot < 3 ? any_rate : any_force);
}

void MotionFit::add_to(Slope& slope, Eigen::Index first, const Eigen::VectorXd& by_knots) {
  if (slope.motion.empty()) slope.first = first;
  if (first < slope.first) {  // an IMU with longer intervals
    slope.motion.insert(slope.motion.begin(), static_cast<std::size_t>(slope.first - first), 0.);
    slope.first = first;
  }
  const auto end = static_cast<std::size_t>(first - slope.first + by_knots.size());
  if (slope.motion.size() < end) slope.motion.resize(end, 0.);
  for (Eigen::Index i = 0; i < by_knots.size(); ++i) slope.motion[static_cast<std::size_t>(first - slope.first + i)] += by_knots[i];
}

BorderedBand::Solution MotionFit::linearize(bool with_constants) {
  const Eigen::Index motion = motion_.size();
  BorderedBand& equations = equations_.emplace(motion, per_knot * longest_ - 1, constants_);
  Eigen::VectorXd by_motion = Eigen::VectorXd::Zero(motion), by_constants = Eigen::VectorXd::Zero(constants_);
  std::fill(sums_.begin(), sums_.end(), SensorSum{});
  for (std::size_t k = 0; k < states_.size(); ++k)
    weights_[2 * k] = 1 / square(states_[k].gyro_sigma), weights_[2 * k + 1] = 1 / square(states_[k].accel_sigma);
  const auto seconds = static_cast<std::size_t>(std::ceil(spans_.back().end - spans_.front().begin)) + 1;
  slopes_.assign(seconds, {Eigen::VectorXd::Zero(constants_), 0, {}});
  // A random sign a sample: the share of a sensor's data that the fit uses up is the trace of its projection, of which these estimate each sensor's.
  std::vector<Eigen::VectorXd> sign_by_motion(sums_.size(), Eigen::VectorXd::Zero(motion)),
      sign_by_constants(sums_.size(), Eigen::VectorXd::Zero(constants_));
  const RandomStream signs(1, "degrees of freedom of a motion");
  std::uint64_t drawn = 0;

  for_each_reading([&](std::size_t k, Sensor triad, std::size_t span, const Sample& sample) {
    const std::size_t sensor = 2 * k + triad;
    const Equation e = equation_of(k, triad, span, sample);
    const std::vector<int>& columns = columns_[sensor];
    const double weight = weights_[sensor];
    equations.add(e.first, e.knots, columns, e.constants, weight);
    const auto second =
        static_cast<std::size_t>(std::clamp(sample.end - states_[k].offset - spans_.front().begin, 0., static_cast<double>(seconds - 1)));
    const Eigen::VectorXd by_knots = weight * e.knots.transpose() * e.residual, slope = weight * e.constants.transpose() * e.residual;
    by_motion.segment(e.first, by_knots.size()) += by_knots;
    add_to(slopes_[second], e.first, by_knots);
    Vector3d sign;
    for (double& x : sign) x = signs.uniform(drawn++) < 0.5 ? -1 : 1;
    sign_by_motion[sensor].segment(e.first, by_knots.size()) += weight * e.knots.transpose() * sign;
    const Eigen::VectorXd sign_slope = weight * e.constants.transpose() * sign;
    for (std::size_t i = 0; i < columns.size(); ++i) {
      by_constants[columns[i]] += slope[static_cast<Eigen::Index>(i)];
      slopes_[second].constants[columns[i]] += slope[static_cast<Eigen::Index>(i)];
      sign_by_constants[sensor][columns[i]] += sign_slope[static_cast<Eigen::Index>(i)];
    }
  });

  add_priors(equations, by_constants);
  for (Eigen::Index i = 0; i < motion; ++i) by_motion[i] -= motion_[i] / square(i % per_knot < 3 ? any_rate : any_force);
  equations.factor(with_constants);
  const BorderedBand::Solution change = equations.solve(by_motion, by_constants);
  covariance_ = equations.border_covariance();
  for (std::size_t sensor = 0; sensor < sums_.size(); ++sensor)
    sums_[sensor].used = equations.squared_norm(sign_by_motion[sensor], sign_by_constants[sensor]) / weights_[sensor];
  return change;
}

double MotionFit::step(bool with_constants) {
  const BorderedBand::Solution change = linearize(with_constants);
  take_step(change, with_constants);
  for_each_reading([&](std::size_t k, Sensor triad, std::size_t span, const Sample& sample) {
    sums_[2 * k + triad].squares += equation_of(k, triad, span, sample).residual.squaredNorm(), sums_[2 * k + triad].samples += 3;
  });
  return with_constants ? (change.border.array() / covariance_.diagonal().array().sqrt()).abs().maxCoeff() : HUGE_VAL;
}

void MotionFit::take_step(const BorderedBand::Solution& change, bool with_constants) {
  motion_ += change.band;
  if (!with_constants) return;
  for (std::size_t k = 0; k < states_.size(); ++k) {
    ImuState& state = states_[k];
    const Eigen::Index own = k == 0 ? 0 : mount_column(k) - own_columns, mount = own + own_columns;
    state.errors += change.border.segment<own_columns>(own);
    if (k == 0) continue;
    state.rotation = orthonormalized(rotation_exp(change.border.segment<3>(mount + turn)) * state.rotation);
    state.lever_arm += change.border.segment<3>(mount + arm);
    state.offset += change.border[mount + offset], state.drift += change.border[mount + drift], state.delay += change.border[mount + delay];
  }
}

void MotionFit::move(const Eigen::VectorXd& constants) { take_step({Eigen::VectorXd::Zero(motion_.size()), constants}, true); }

double MotionFit::take_noise() {
  double most = 0;
  for (std::size_t sensor = 0; sensor < sums_.size(); ++sensor) {
    const SensorSum& sum = sums_[sensor];
    double& sigma = sensor % 2 == 0 ? states_[sensor / 2].gyro_sigma : states_[sensor / 2].accel_sigma;
    constexpr double least_left = 0.02, most_factor = 3;  // a sensor that the motion follows closely shows little of its noise
    const double left = sum.samples - sum.used;
    if (left < least_left * sum.samples) continue;
    const double found = std::clamp(std::sqrt(sum.squares / left), sigma / most_factor, sigma * most_factor);
    most = std::max(most, std::abs(found / sigma - 1));
    sigma = std::max(found, least_sigma);
  }
  return most;
}

Eigen::MatrixXd MotionFit::information_of_difference(Eigen::VectorXd other) {
  BorderedBand::Rows side = BorderedBand::Rows::Zero(motion_.size(), constants_);
  Eigen::MatrixXd corner = Eigen::MatrixXd::Zero(constants_, constants_);
  for_each_reading([&](std::size_t k, Sensor sensor, std::size_t span, const Sample& sample) {
    const Equation e = equation_of(k, sensor, span, sample);
    motion_.swap(other);
    const ThreeRows change = equation_of(k, sensor, span, sample).constants - e.constants;
    motion_.swap(other);
    const double weight = weights_[2 * k + sensor];
    const Eigen::MatrixXd cross = weight * e.knots.transpose() * change, own = weight * change.transpose() * change;
    const std::vector<int>& columns = columns_[2 * k + sensor];
    for (std::size_t j = 0; j < columns.size(); ++j) {
      side.col(columns[j]).segment(e.first, cross.rows()) += cross.col(static_cast<Eigen::Index>(j));
      for (std::size_t i = 0; i < columns.size(); ++i)
        corner(columns[i], columns[j]) += own(static_cast<Eigen::Index>(i), static_cast<Eigen::Index>(j));
    }
  });
  return equations_->reduced(corner, std::move(side));
}

Eigen::VectorXd MotionFit::noisy_motion() const {
  Eigen::VectorXd noise(motion_.size());
  RandomStream(1, "noise of a motion").normals(0, {noise.data(), static_cast<std::size_t>(noise.size())});
  return motion_ + equations_->backward(noise);
}

Eigen::VectorXd MotionFit::motion_without_tilts() const {
  Vector3d sum = Vector3d::Zero();
  Matrix3d squares = Matrix3d::Zero();
  double n = 0;
  for_each_reading([&](std::size_t k, Sensor sensor, std::size_t span, const Sample& sample) {
    if (k != 0 || sensor != gyros) return;
    const Vector3d rate = means_over(states_[0], sample, span, 0).rate;
    sum += rate, squares += rate * rate.transpose(), ++n;
  });
  const Vector3d mean = sum / n;
  const SymmetricEigen axes = symmetric_eigen(squares / n - mean * mean.transpose());
  constexpr double clear = 3;  // sigmas of a tilt
  Matrix3d small = Matrix3d::Zero();
  for (int i = 0; i < 2; ++i)
    if (axes.values[i] < square(clear * tilt_sigma_) * axes.values[2]) small += axes.vectors.col(i) * axes.vectors.col(i).transpose();
  Eigen::VectorXd out = motion_;
  for (Eigen::Index i = 0; i < out.size(); i += per_knot) out.segment<3>(i) -= small * (out.segment<3>(i) - mean);
  return out;
}

ConstantsCovariance MotionFit::covariance() {
  const BorderedBand::Solution change = linearize(true);
  BorderedBand none(0, 0, constants_);
  Eigen::VectorXd unused = Eigen::VectorXd::Zero(constants_);
  add_priors(none, unused);
  const Eigen::MatrixXd& prior = none.corner;
  // Noise of the motion, and turns about one axis that a gyro's misalignment tilts, look like a motion that shows more than there is. Of a direction
  // in which these make a tenth of the information, that is where the motion is known to a third, only the prior is left.
  constexpr double most_noise = 0.1;
  const Cholesky l(equations_->information());
  const auto whitened = [&](const Eigen::MatrixXd& information) {
    const Eigen::MatrixXd half = l.solve_lower(information);
    return Eigen::MatrixXd(l.solve_lower(Eigen::MatrixXd(half.transpose())));
  };
  const SymmetricEigen shares =
      symmetric_eigen(whitened(information_of_difference(noisy_motion()) + information_of_difference(motion_without_tilts())));
  const Eigen::VectorXd left = shares.values.unaryExpr([](double share) { return share > most_noise ? 0. : 1 - std::max(share, 0.); });
  const Eigen::VectorXd lost = left.unaryExpr([](double x) { return x > 0 ? 0. : 1.; });
  const Eigen::MatrixXd root = l.lower() * shares.vectors, of_prior = shares.vectors.transpose() * whitened(prior) * shares.vectors;
  const auto covariance_of = [&](const Eigen::MatrixXd& kept) { return Cholesky(Eigen::MatrixXd(root * kept * root.transpose())).inverse(); };
  ConstantsCovariance out;
  out.covariance = covariance_of(Eigen::MatrixXd(left.asDiagonal()) + lost.asDiagonal() * of_prior * lost.asDiagonal());
  const Eigen::VectorXd curvature = (1 - shares.values.array()).min(1).max(of_prior.diagonal().array());
  out.step = covariance_of(curvature.asDiagonal()) * (equations_->information() * change.border);

  Eigen::MatrixXd sum = Eigen::MatrixXd::Zero(constants_, constants_);
  double parts = 0;
  for (const Slope& slope : slopes_) {
    if (slope.motion.empty()) continue;
    const auto motion = Eigen::Map<const Eigen::VectorXd>(slope.motion.data(), std::ssize(slope.motion));
    const Eigen::VectorXd reduced = equations_->reduced(slope.first, motion, slope.constants);
    sum += reduced * reduced.transpose(), ++parts;
  }
  constexpr double chance = 3;  // sigmas by which as many parts scatter by chance
  const double bound = 1 + chance * std::sqrt(2 / std::max(parts, 1.));
  const Eigen::ArrayXd scatter = (out.covariance * sum * out.covariance).diagonal();
  const Eigen::ArrayXd expected = (out.covariance * (equations_->information() - prior) * out.covariance).diagonal();
  out.scatter = scatter / expected, out.seconds = static_cast<int>(parts);
  out.enlargement = (scatter > bound * expected).select(scatter / expected, 1.).sqrt();
  out.covariance = out.enlargement.asDiagonal() * out.covariance * out.enlargement.asDiagonal();
  out.change = (change.border.array() / out.covariance.diagonal().array().sqrt()).abs().maxCoeff();
  return out;
}

std::vector<BodyResidual> MotionFit::residuals() const {
  std::vector<BodyResidual> out;
  for (std::size_t k = 0; k < states_.size(); ++k)
    out.push_back({states_[k].gyro_sigma, states_[k].accel_sigma, static_cast<std::size_t>(sums_[2 * k].samples / 3)});
  return out;
}

BodyRates MotionFit::rates(std::size_t imu, Sensor wanted) const {
  BodyRates out;
  for_each_reading([&](std::size_t k, Sensor sensor, std::size_t span, const Sample& sample) {
    if (k != imu || sensor != wanted) return;
    const ImuState& state = states_[k];
    const Means m = means_over(state, sample, span, sensor == gyros ? 0 : state.delay);
    const Vector3d first = state.rotation * (sensor == gyros ? m.rate : m.u), read = sensor == gyros ? sample.rate : sample.force;
    const Vector3d residual = equation_of(k, sensor, span, sample).residual;
    out.time.push_back(0.5 * (sample.begin + sample.end) - state.offset);
    for (int i = 0; i < 3; ++i) {
      const auto axis = static_cast<std::size_t>(i);
      out.first[axis].push_back(first[i]), out.second[axis].push_back(read[i]), out.residual[axis].push_back(residual[i]);
    }
  });
  return out;
}

}  // namespace imulab::extrinsics
