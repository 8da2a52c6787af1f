#include "imulab/estimate/turntable/prediction.hpp"

#include "imulab/error.hpp"
#include "imulab/estimate/kernel/input.hpp"
#include "imulab/estimate/kernel/site.hpp"
#include "imulab/estimate/turntable/fit.hpp"
#include "imulab/model/forward_model.hpp"
#include "imulab/rig/table_readings.hpp"
#include "imulab/session.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <array>
#include <cmath>

namespace imulab::turntable {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

namespace {

/// The kinds of error sources of a rig and a site, in the order of an error budget.
constexpr std::array<std::pair<ErrorSource::Kind, const char*>, 7> table_sources{{{ErrorSource::Kind::orthogonality, "orthogonality"},
                                                                                  {ErrorSource::Kind::angle, "angle"},
                                                                                  {ErrorSource::Kind::zero, "zero"},
                                                                                  {ErrorSource::Kind::timing, "timing"},
                                                                                  {ErrorSource::Kind::gravity, "gravity"},
                                                                                  {ErrorSource::Kind::latitude, "latitude"},
                                                                                  {ErrorSource::Kind::earth, "earth rate"}}};

/// Returns the holds that the sum of a turn extends into.
std::vector<std::size_t> rests_of_turns(const TableMotion& motion) {
  std::vector<std::size_t> out;
  for (std::size_t hold = 0; hold < motion.holds(); ++hold) {
    bool shared = false;
    for (std::size_t turn = motion.holds(); turn < motion.parts(); ++turn)
      shared = shared || (motion.begin(turn) < motion.end(hold) && motion.begin(hold) < motion.end(turn));
    if (shared) out.push_back(hold);
  }
  return out;
}

/// With effects, the latitude is one of them.
TableMotion motion_of(const Plan& plan) {
  return {plan.parts, plan.rig, plan.effects && !plan.classical ? kernel::beside_effects(plan.site) : plan.site};
}

Estimator estimator_of(const Plan& plan, const TableMotion& motion) {
  EstimatorOptions options;
  options.terms = plan.terms;
  options.optional = plan.optional;
  options.table_errors = !plan.classical;
  options.bias_while_turning = plan.classical;
  if (plan.classical) options.left_out = rests_of_turns(motion);
  if (plan.effects && !plan.classical) options.effects = table_effects(*plan.effects, motion, plan.parts, plan.site);
  const Matrix3d identity = Matrix3d::Identity();
  return {motion, {}, {raw_density(plan.accel_noise.N, identity), raw_density(plan.gyro_noise.N, identity)}, options};
}

/// Returns the variance of the coefficients due to a constant bias, with one column of `by_axis` per axis.
VectorXd of_turn_on(const Spread& turn_on, const Eigen::MatrixX3d& by_axis) {
  const VectorXd effect = turn_on.fixed ? VectorXd(by_axis.rowwise().sum().cwiseAbs2()) : VectorXd(by_axis.rowwise().squaredNorm());
  return effect * (turn_on.value * turn_on.value);
}

/// Returns the variances for optimal weights, which include the table's errors, and one gyro bias throughout. NaN: not determined by them.
VectorXd with_best_weights(Plan plan, const TableMotion& motion, const std::vector<CoefficientIndex>& coefficients) {
  plan.classical = false;
  const auto best = estimator_of(plan, motion).uncertainty({});
  VectorXd out = VectorXd::Constant(static_cast<Index>(coefficients.size()), std::nan(""));
  for (std::size_t i = 0; i < coefficients.size(); ++i) {
    const auto found = std::find(best.stated.begin(), best.stated.end(), coefficients[i]);
    if (found == best.stated.end()) continue;
    const auto row = found - best.stated.begin();
    const Coefficient& c = coefficient(coefficients[i]);
    const double bias = c.term != Term::offset ? 0 : (c.triad == Triad::accel ? plan.accel_noise : plan.gyro_noise).turn_on.value;
    out[static_cast<Index>(i)] = best.covariance(row, row) + bias * bias;
  }
  return out;
}

/// Adds the first-order variance by source. `stated`: variances of the estimator.
void add_sources(Prediction& out, const Plan& plan, const TableMotion& motion, const Estimator& estimator, const VectorXd& stated) {
  const MatrixXd sensitivity = estimator.sensitivity({}, out.coefficients);  // exact for the estimator
  const auto add = [&](std::string name, const VectorXd& variance) {
    if (variance.size() > 0 && variance.maxCoeff() == 0) return;
    out.sources.push_back(std::move(name));
    out.variance.conservativeResize(variance.size(), out.variance.cols() + 1);
    out.variance.rightCols<1>() = variance;
  };
  const MatrixXd by_source = sensitivity * estimator.readings_by_table() * motion.sigma().asDiagonal();
  for (const auto& [kind, name] : table_sources) {
    VectorXd variance = VectorXd::Zero(sensitivity.rows());
    for (std::size_t k = 0; k < motion.sources().size(); ++k)
      if (motion.sources()[k].kind == kind) variance += by_source.col(static_cast<Index>(k)).cwiseAbs2();
    add(name, variance);
  }
  const MatrixXd bias = by_bias(motion);
  const auto noise_of = [&](const MatrixXd& s) { return VectorXd((s * estimator.noise()).cwiseProduct(s).rowwise().sum()); };
  const VectorXd accel_rows = bias.leftCols<3>().rowwise().sum(), gyro_rows = VectorXd::Ones(motion.rows()) - accel_rows;
  add("gyro noise", noise_of(sensitivity * gyro_rows.asDiagonal()));
  add("accelerometer noise", noise_of(sensitivity * accel_rows.asDiagonal()));
  const MatrixXd by_turn_on = sensitivity * bias;
  add("gyro turn-on", of_turn_on(plan.gyro_noise.turn_on, by_turn_on.rightCols<3>()));
  add("accelerometer turn-on", of_turn_on(plan.accel_noise.turn_on, by_turn_on.leftCols<3>()));
  VectorXd of_terms = VectorXd::Zero(sensitivity.rows());
  for (const char* term : {"accel.quadratic", "accel.cubic", "gyro.quadratic", "gyro.cubic", "gyro.g_sensitivity"}) {
    const std::vector<CoefficientIndex> members = select_coefficients(term);
    if (!plan.optional || !contains(plan.terms, members.front())) continue;
    const VectorXd variance = estimator.by_prior({}, out.coefficients, members).rowwise().squaredNorm();
    of_terms += variance;
    add(term, variance);
    out.terms.push_back({term, members.front(), kernel::prior_sigma(*plan.optional, coefficient(members.front()), 1)});
  }
  const MatrixXd by_effect = sensitivity * estimator.readings_by_effects() * estimator.effects_sigma().asDiagonal();
  for (const kernel::EffectGroup& g : estimator.effect_groups())
    add(std::string(g.effect->name), by_effect.middleCols(g.first, g.size).rowwise().squaredNorm());
  // A requested but undetermined coefficient keeps its start, with an error as large as its prior. The covariance stated with classical weights does
  // not include the table.
  if (out.undetermined.empty()) return;
  const VectorXd rest = stated - by_source.rowwise().squaredNorm() - noise_of(sensitivity) - of_terms - by_effect.rowwise().squaredNorm();
  add(undetermined_source, plan.classical ? VectorXd::Zero(rest.size()) : VectorXd(rest.cwiseMax(0.0)));
}

/// Sums of the first, second and fourth powers of the coefficients' errors.
using Moments = Eigen::MatrixX3d;

}  // namespace

Plan plan_of(const Session& procedure, const std::vector<CoefficientIndex>& terms) {
  const RecordingSource source = kernel::only_source(procedure);
  Plan plan;
  plan.rig = turntable_of(procedure, source.file);
  plan.parts = table_plan(procedure, source.file);
  plan.site = procedure.site;
  for (const TablePart& hold : plan.parts.holds)
    if (const double samples = (hold.end - hold.begin) * source.rate_hz.value_or(INFINITY); samples < 2)
      throw Error(fmt::format("{}: {}: {:.2g} samples at {:g} Hz; expected two or more", procedure.file,
                              step_name(plan.parts.steps[hold.step], hold.step), samples, *source.rate_hz));
  const NoiseModels noise = errors_at(procedure.file, [&] { return declared_noise(procedure.imu); });
  plan.accel_noise = noise.accel;
  plan.gyro_noise = noise.gyro;
  if (!(noise.accel.N > 0) || !(noise.gyro.N > 0))
    throw Error(fmt::format("{}: the {} noise density is 0; expected one above 0, since the readings are weighted by their noise", procedure.file,
                            noise.accel.N > 0 ? "gyro" : "accelerometer"));
  plan.terms = chosen_coefficients(terms, "m/s^2", "rad/s");
  if (!terms.empty()) return plan;
  EstimatorOptions asked;
  asked.terms = plan.terms;
  const EstimatorOptions all = with_optional_terms(asked, procedure.imu);
  plan.terms = all.terms;
  plan.optional = all.optional;
  return plan;
}

Plan classical(Plan plan) {
  plan.classical = true;
  plan.terms = select_each({"accel.offset", "accel.matrix", "gyro.offset", "gyro.matrix"});
  plan.optional.reset();
  plan.effects.reset();
  return plan;
}

Prediction predict(const Plan& plan) {
  const TableMotion motion = motion_of(plan);
  const Estimator estimator = estimator_of(plan, motion);
  const auto uncertainty = estimator.uncertainty({});
  Prediction out;
  out.frame = BodyFrame::rig;
  out.coefficients = uncertainty.stated;
  out.undetermined = uncertainty.undetermined;
  out.considered = uncertainty.considered;
  add_sources(out, plan, motion, estimator, uncertainty.covariance.diagonal());
  const auto second = estimator.second_order({}, out.coefficients);
  out.bias = second.bias;
  out.second_order = second.covariance.diagonal().cwiseSqrt();
  out.sigma = (out.variance.rowwise().sum() + out.second_order.cwiseAbs2()).cwiseSqrt();
  out.degrees_of_freedom = VectorXd::Constant(out.sigma.size(), estimator.degrees_of_freedom());
  // The estimate is generalized least squares, which by default attains the bound.
  out.cramer_rao = plan.classical ? VectorXd(with_best_weights(plan, motion, out.coefficients).cwiseSqrt()) : out.first_order();
  return out;
}

MonteCarloResult monte_carlo(const Plan& plan, std::uint64_t runs, std::uint64_t seed, const std::function<void(std::uint64_t)>& progress,
                             const Sharing* sharing) {
  const TableMotion motion = motion_of(plan);
  const Estimator estimator = estimator_of(plan, motion);
  const ReadingsSampler sampler(motion, {plan.accel_noise.turn_on, plan.gyro_noise.turn_on}, estimator.noise(), seed,
                                plan.optional ? estimator.optional_sigma() : VectorXd(),
                                estimator.readings_by_effects() * estimator.effects_sigma().asDiagonal());
  const std::vector<CoefficientIndex> coefficients = estimator.uncertainty({}).stated;
  const Index n = std::ssize(coefficients);
  const auto values = [&](const VectorXd& columns) { return coefficient_values(backward(columns), coefficients); };
  const VectorXd bias = estimator.second_order({}, coefficients).bias;

  constexpr std::uint64_t least_block = 128, most_parts = 1 << 16;  // a checkpoint keeps 1 kB of each part
  const std::uint64_t block = least_block * std::max<std::uint64_t>(1, (runs + least_block * most_parts - 1) / (least_block * most_parts));
  SharedWork blocks{.count = static_cast<std::size_t>((runs + block - 1) / block), .work = {}, .take = {}};
  blocks.work = [&](std::size_t b) {
    const std::uint64_t begin = b * block, count = std::min(block, runs - begin);
    const MatrixXd found = estimator.solve(estimator.linearized(sampler.draw(begin, static_cast<Index>(count))));
    const MatrixXd drawn = sampler.drawn_columns(begin, static_cast<Index>(count));
    Moments sum = Moments::Zero(n, 3);
    for (Index run = 0; run < found.cols(); ++run) {
      const VectorXd error = values(found.col(run)) - values(drawn.col(run)) - bias, square = error.cwiseAbs2();
      sum.col(0) += error, sum.col(1) += square, sum.col(2) += square.cwiseAbs2();
    }
    return bytes_of(sum.data(), static_cast<std::size_t>(sum.size()));
  };
  Moments mean = Moments::Zero(n, 3);
  blocks.take = [&](std::size_t, const std::string& bytes) {  // in order, for bit-identical results with any number of threads
    Moments sum(n, 3);
    read_numbers(bytes, sum.data(), static_cast<std::size_t>(sum.size()));
    mean += sum;
  };
  if (progress) blocks.progress = [&](std::size_t done) { progress(std::min(runs, done * block)); };
  for_each(blocks, sharing);
  mean /= static_cast<double>(runs);
  return {coefficients, runs, mean.col(0), mean.col(1).cwiseSqrt(),
          (mean.col(2).cwiseQuotient(mean.col(1).cwiseAbs2()).array() - 1).cwiseMax(0.0).sqrt() / (2 * std::sqrt(static_cast<double>(runs)))};
}

}  // namespace imulab::turntable
