#include "imulab/estimate/hybrid/filter.hpp"

#include "imulab/core/decomposition.hpp"
#include "imulab/core/rotation.hpp"
#include "imulab/earth.hpp"
#include "imulab/eigen.hpp"
#include "imulab/navigation/in_place/navigator.hpp"
#include "imulab/stop.hpp"
#include "imulab/units.hpp"

#include <cmath>
#include <numbers>
#include <utility>

namespace imulab::hybrid {

using Eigen::Index;
using in_place::BlockSums;

namespace {

/// The innovation after a block in its own standard deviations; `used` is true if it was within limits.
struct Innovation {
  Vector3d whitened = Vector3d::Zero();
  bool used = false;
  Index at = 0;  // index among the innovations that depend on the effects
};

/// Observes the velocity after a block unless its innovation is beyond `outlier`.
Innovation observe_velocity(SquareRootEstimate& e, std::optional<Separation>& separation, const Vector3d& velocity, double sigma, double outlier) {
  const Index at = e.x.size() - 3;
  const Eigen::Matrix<double, 3, Eigen::Dynamic> rows = e.factor.bottomRows<3>();
  const Matrix3d s = rows * rows.transpose() + sigma * sigma * Matrix3d::Identity();
  const Matrix3d lower = s.llt().matrixL();
  const Vector3d innovation = lower.triangularView<Eigen::Lower>().solve(velocity - e.x.tail<3>());
  if (!(innovation.squaredNorm() <= outlier)) return {innovation, false};
  const Index place = separation ? separation->observe<3>(e, at, lower, innovation) : 0;
  for (Index i = 2; i >= 0; --i) e.observe(at + i, velocity[i], sigma);
  return {innovation, true, place};
}

/// Observes the heading of a unit at rest: an increment that its gyros measure about the vertical is their error. There is one observation per rest
/// because the error of the integral at a boundary correlates neighboring intervals.
class RestHeading {
 public:
  static constexpr int rows = 7;  ///< its state, and the errors of attitude and velocity
  using Rows = Eigen::Matrix<double, rows, Eigen::Dynamic>;

  RestHeading(const States& states, const Noise& noise)
      : state_(states.first(Group::rest_heading)), heading_(states.attitude() + 2), sigma_(std::numbers::sqrt2 * noise.angle) {}

  /// Adds block k, which turns the computed attitude from `before` to `after`.
  void over(const std::vector<Block>& blocks, std::size_t k, const Matrix3d& before, const Matrix3d& after) {
    const Block& block = blocks[k];
    at_rest_ = block.at_rest;
    begins_ = k == 0 || !blocks[k - 1].at_rest || block.lost;
    if (begins_) turned_ = 0, whole_ = true;
    turned_ += rotation_log(after * before.transpose()).z();
    whole_ = whole_ && at_rest_ && block.observed;
  }
  Rows transition(const Eigen::Matrix<double, 6, Eigen::Dynamic>& by_states) const {
    Rows out = with(by_states);
    if (at_rest_) out(0, heading_) -= 1;
    if (at_rest_ && !begins_) out(0, state_) = 1;
    return out;
  }
  /// Returns the block's rows, preceded by a copy of the heading's row.
  template <int Columns>
  Eigen::Matrix<double, rows, Columns> with(const Eigen::Matrix<double, 6, Columns>& of_block) const {
    Eigen::Matrix<double, rows, Columns> out(rows, of_block.cols());
    out.row(0) = (at_rest_ ? 1.0 : 0.0) * of_block.row(2);
    out.template bottomRows<6>() = of_block;
    return out;
  }
  /// Observes the heading after block k, the last block of a rest.
  void observe(std::size_t k, SquareRootEstimate& e, std::optional<Separation>& separation, double outlier) {
    if (!whole_) return;
    using One = Eigen::Matrix<double, 1, 1>;
    const double variance = e.factor.row(state_).squaredNorm() + sigma_ * sigma_;
    const One sigma(std::sqrt(variance)), innovation((-turned_ - e.x[state_]) / sigma[0]);
    const bool used = innovation.squaredNorm() <= outlier;
    seen.push_back({k, innovation[0], variance});
    at_.push_back(used && separation ? separation->observe<1>(e, state_, sigma, innovation) : -1);
    if (used) e.observe(state_, -turned_, sigma_);
  }
  /// Corrects the headings for the effects c.
  void correct(const Separation& separation, const Eigen::VectorXd& c) {
    for (std::size_t k = 0; k < seen.size(); ++k)
      if (at_[k] >= 0) seen[k].whitened = separation.innovation<1>(at_[k], c)[0];
  }

  std::vector<SeenHeading> seen;

 private:
  Index state_, heading_;
  double sigma_;
  bool at_rest_ = false, begins_ = false, whole_ = false;
  double turned_ = 0;      // rad, in the rest so far
  std::vector<Index> at_;  // indices of these among the rows that depend on the effects; -1: none
};

/// The innovations of a correct filter are white (Mehra 1970). An unmodeled effect persists, which correlates consecutive innovations.
class Whiteness {
 public:
  void add(const Vector3d& innovation) {
    if (before_) products_ += innovation.dot(*before_), pairs_ += 1;
    squares_ += innovation.squaredNorm(), count_ += 1;
    before_ = innovation;
  }
  void interrupt() { before_.reset(); }
  Serial serial() const {
    if (!(squares_ > 0 && pairs_ > 0)) return {};
    return {products_ / pairs_ / (squares_ / count_), 1 / std::sqrt(3 * pairs_)};
  }

 private:
  std::optional<Vector3d> before_;
  double products_ = 0, pairs_ = 0, squares_ = 0, count_ = 0;
};

/// Levels the solution by the velocity gained in a rest, and corrects the state by the opposite amount. The error equations require small angles;
/// accumulated gyro noise (0.02 rad in a day at 0.25 deg/sqrt(h)) would bias the vertical force by half of its square.
void level(in_place::Navigator& navigator, SquareRootEstimate& e, const States& states, const BlockSums& rest, double gravity) {
  const Vector3d tilt = Vector3d(rest.velocity.y(), -rest.velocity.x(), 0) / (gravity * rest.duration);
  navigator.C_nb = rotation_exp(tilt) * navigator.C_nb;
  e.x.segment<3>(states.attitude()) -= tilt;
}

RestRate rest_rate(in_place::Navigator& navigator, const Range& samples, double time) {
  Vector3d sum = Vector3d::Zero();
  for (std::size_t i = samples.begin; i < samples.end; ++i) sum += navigator.readings.rate(i);
  const auto n = static_cast<double>(samples.size());
  return {time, n, navigator.C_nb * sum / n};
}

/// Sets a new attitude with standard deviation `sigma`; the first one is also the attitude at the start.
void begin(SquareRootEstimate& e, const States& states, const Vector3d& sigma, bool first) {
  e.x.tail<6>().setZero();
  e.factor.bottomRows<6>().setZero();
  const Index column = first ? states.first(Group::start) : states.attitude();
  for (Index i = 0; i < 3; ++i) e.factor(states.attitude() + i, column + i) = sigma[i];
}

/// Adds the slow noise of the offsets over a block that is the fraction `part` of the recording.
void drift(SquareRootEstimate& e, std::optional<Separation>& separation, const States& states, const Noise& noise, double duration, double part) {
  if (!states.has(Group::mean)) return;
  constexpr Index processes = in_place::SlowNoise::processes;
  for (Index axis = 0; axis < 6; ++axis) {
    const in_place::SlowNoise& slow = axis < 3 ? noise.accel_slow : noise.gyro_slow;
    const Index offset = states.offset(axis), mean = states.first(Group::mean) + axis;
    const auto add_to_mean = [&](Index s) {
      e.x[mean] += part * e.x[s];
      e.factor.row(mean) += part * e.factor.row(s);
      if (separation) separation->U.row(mean) += part * separation->U.row(s);
    };
    if (slow.walk > 0) e.add_variance(offset, duration * slow.walk * slow.walk);
    add_to_mean(offset);
    for (Index k = 0; k < processes && slow.flicker > 0; ++k) {
      const Index s = states.first(Group::flicker) + processes * axis + k;
      const double kept = std::exp(-duration / slow.time[static_cast<std::size_t>(k)]);
      e.x[s] *= kept;
      e.factor.row(s) *= kept;
      if (separation) separation->U.row(s) *= kept;
      e.add_variance(s, (1 - kept * kept) * slow.flicker * slow.flicker);
      add_to_mean(s);
    }
  }
}

/// Returns the rest from block k, after an interruption of the measured motion, up to the next motion, even one that is not measured.
Range rest_from(const std::vector<Block>& blocks, std::size_t k) {
  Range rest = blocks[k].samples;
  for (++k; k < blocks.size() && blocks[k].at_rest && !blocks[k].lost; ++k) rest.end = blocks[k].samples.end;
  return rest;
}

/// Aligns at a rest after a motion from sample `from` on that was not measured completely. Gravity gives the level. The Earth's rate gives the
/// heading if one rest resolves it; otherwise the measured part of the motion does, with the mean rate across a gap. That heading may be wrong by
/// tens of degrees, which the equations tolerate; a heading from noise would be arbitrary and change in each pass.
void align_anew(in_place::Navigator& navigator, std::size_t from, const Range& rest, const Data& data) {
  constexpr double good = 10 * unit::deg;
  const Recording& recording = data.recording;
  CompensatedReadings& readings = navigator.readings;
  const double seconds = recording.interval_s * static_cast<double>(rest.size());
  if (data.noise.gyro.maxCoeff() < good * earth_rate * std::cos(data.place.latitude) * std::sqrt(seconds)) return navigator.align(rest);
  Matrix3d C_nb = navigator.C_nb;
  for (std::size_t i = from; i < rest.begin; ++i) {
    const bool gap = i > 0 && recording.follows_gap(i);
    const Vector3d before = readings.rate(gap ? i - 1 : i);
    const double seconds_more = gap ? recording.time_s(i) - recording.time_s(i - 1) : recording.interval_s;
    C_nb = C_nb * rotation_exp(0.5 * seconds_more * (before + readings.rate(i)));
  }
  Vector3d force = Vector3d::Zero();
  for (std::size_t i = rest.begin; i < rest.end; ++i) force += readings.force(i);
  navigator.C_nb = shortest_rotation((C_nb * force).normalized(), Vector3d::UnitZ()) * C_nb;
}

/// Adds the effects estimated from the innovations.
void add_effects(Pass& out, Separation& separation, std::vector<Innovation>& innovations) {
  out.effects = separation.estimate();
  const auto& [information, c, C] = out.effects;
  out.x += separation.U * c;
  out.across = separation.U * C;
  out.covariance += out.across * separation.U.transpose();
  for (Innovation& innovation : innovations)
    if (innovation.used) innovation.whitened = separation.innovation<3>(innovation.at, c);
}

/// The constants of the effects, in addition to the states.
struct Beside {
  Beside(const Data& d, const Linearization& about, bool estimated, const States& states)
      : data(d), known(about.effects), effect_states(d.recording, d.unmodeled, d.noise, about.place.gravity) {
    if (estimated && data.unmodeled.size() > 0) separation.emplace(parameters_of(data.unmodeled.effects), states.size());
  }
  bool any() const { return known.size() > 0 || separation; }

  /// Predicts after block k.
  void predict(SquareRootEstimate& e, const RestHeading& heading, const RestHeading::Rows& by_states, std::size_t k, const BlockSums& sums) {
    if (!any()) return;
    const RestHeading::Rows by_c = heading.with(effect_states.columns(data.blocks[k], sums));
    if (known.size() > 0) e.x.tail<RestHeading::rows>() += by_c * known;
    if (separation) separation->predict(by_states, by_c);
  }

  const Data& data;
  const Eigen::VectorXd& known;
  EffectStates effect_states;
  std::optional<Separation> separation;
};

CurvePoint curve_point(double time, const SquareRootEstimate& e, std::optional<Separation>& separation) {
  CurvePoint out{time, e.x, e.factor.rowwise().norm()};
  if (!separation) return out;
  const Separation::Estimate effects = separation->estimate();
  out.x += separation->U * effects.value;
  out.sigma = (out.sigma.cwiseAbs2() + (separation->U * effects.covariance).cwiseProduct(separation->U).rowwise().sum()).cwiseSqrt();
  return out;
}

void add_innovations(Pass& out, const std::vector<Innovation>& innovations) {
  Whiteness whiteness;
  for (const Innovation& innovation : innovations) {
    out.chi2.push_back(innovation.whitened.squaredNorm());
    if (innovation.used)
      whiteness.add(innovation.whitened);
    else
      whiteness.interrupt();
  }
  out.serial = whiteness.serial();
}

}  // namespace

Pass filter_pass(const Data& data, const Linearization& about, const States& states, const kernel::Parameters& known, const PassOptions& options) {
  const std::vector<Block>& blocks = data.blocks;
  const Noise& noise = data.noise;
  Beside beside(data, about, options.effects, states);
  in_place::OptionalSums wanted = states.sums();
  wanted.parts = beside.any();
  in_place::Navigator navigator(data.recording, about.model, about.delay, about.place.latitude, about.place.gravity, wanted);
  std::optional<Separation>& separation = beside.separation;
  SquareRootEstimate e(states.size());
  e.x.head(states.constants()) = known.offset;
  e.factor.diagonal().head(states.constants()) = known.sigma;
  Pass out;
  std::vector<Innovation> innovations;
  RestHeading heading(states, noise);
  Vector3d velocity = Vector3d::Zero();  // computed velocity
  double next_point = -std::numeric_limits<double>::infinity();
  bool used_before = true;  // a knock at the end of a rejected block extends into the next block
  double whole = 0;         // [s], duration of all blocks
  for (const Block& block : blocks) whole += data.recording.interval_s * static_cast<double>(block.samples.size());
  const double start_time = data.recording.time_s(blocks.front().samples.end - 1);
  std::size_t first = 0;  // sample since which the motion was measured without interruption

  for (std::size_t k = 0; k < blocks.size(); ++k) {
    stop_point();
    const Block& block = blocks[k];
    if (k == 0 || block.lost) {
      if (k > 0) {
        align_anew(navigator, blocks[k - 1].samples.end, rest_from(blocks, k), data);
      } else {
        navigator.align(rest_from(blocks, k));
        out.start = navigator.C_nb = about.start.value_or(navigator.C_nb);
      }
      first = block.samples.begin;
      velocity.setZero();
      begin(e, states, k == 0 ? Vector3d(known.sigma.segment<3>(states.first(Group::start))) : alignment_sigma(), k == 0);
      if (separation) separation->begin();
    }
    const Matrix3d before = navigator.C_nb;
    const BlockSums sums = navigator.over(block, first);
    velocity += sums.velocity;
    // X' = F X + G W with the state X of Cheng 2014 eq 19, integrated over the block: F from eqs 22 and 23, G W as a covariance.
    heading.over(blocks, k, before, navigator.C_nb);
    const RestHeading::Rows by_states = heading.transition(transition(sums, states, about.place));
    const in_place::Matrix6 root = sums.covariance(noise, 0.5 * (before + navigator.C_nb)).llt().matrixL();
    e.predict(by_states, heading.with(root));
    beside.predict(e, heading, by_states, k, sums);
    drift(e, separation, states, noise, sums.duration, sums.duration / whole);
    // Z = H X + v, H = [I 0] (sec 2.3): the computed velocity of a unit in one place, minus the lever arms' part, is the velocity error.
    Innovation innovation;
    if (block.observed) innovation = observe_velocity(e, separation, velocity, noise.velocity, options.outlier);
    innovations.push_back(innovation);
    if (innovation.used) {  // the known velocity error corrects the solution
      velocity -= e.x.tail<3>();
      e.x.tail<3>().setZero();
    }
    if (k + 1 == blocks.size() || !blocks[k + 1].at_rest || blocks[k + 1].lost) heading.observe(k, e, separation, options.outlier);
    if (innovation.used && used_before && block.at_rest) level(navigator, e, states, sums, about.place.gravity);
    used_before = innovation.used;
    const double time = data.recording.time_s(block.samples.end - 1);
    if (separation) out.states.push_back(beside.effect_states.last());
    if (options.rates && block.at_rest) out.rates.push_back(rest_rate(navigator, block.samples, time - start_time));
    if (options.curve_interval > 0 && (time >= next_point || k + 1 == blocks.size())) {
      out.curve.push_back(curve_point(time, e, separation));
      next_point = time + options.curve_interval;
    }
  }
  out.x = e.x;
  out.covariance = e.factor * e.factor.transpose();
  if (separation) {
    add_effects(out, *separation, innovations);
    heading.correct(*separation, out.effects.value);
  }
  add_innovations(out, innovations);
  out.headings = std::move(heading.seen);
  return out;
}

}  // namespace imulab::hybrid
