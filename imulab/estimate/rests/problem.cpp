#include "imulab/estimate/rests/problem.hpp"

#include "imulab/earth.hpp"
#include "imulab/error.hpp"
#include "imulab/estimate/kernel/input.hpp"
#include "imulab/estimate/kernel/prior.hpp"
#include "imulab/model/frame_axes.hpp"
#include "imulab/units.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <utility>

namespace imulab::rests {

using Eigen::Index;
using Eigen::VectorXd;

namespace {

Matrix3d mean_covariance(const TriadModel& model, const Vector3d& sample_sigma, const Vector3d& rounding, std::size_t samples, double spread) {
  const Vector3d variance = sample_sigma.cwiseAbs2() / static_cast<double>(samples) + rounding.cwiseAbs2();
  return model.matrix * variance.asDiagonal() * model.matrix.transpose() + spread * spread * Matrix3d::Identity();
}

/// Keeps scales away from zero, where the noise would vanish and the iteration would stay.
TriadModel with_half_the_scale_at_least(TriadModel model, const TriadModel& prior) {
  for (int k = 0; k < 3; ++k) {
    const double norm = model.matrix.row(k).norm(), least = 0.5 * prior.matrix.row(k).norm();
    if (norm > 0 && norm < least) model.matrix.row(k) *= least / norm;
  }
  return model;
}

SampleNoise scaled(const SampleNoise& raw, const Scaling& scaling) {
  return {raw.accel.cwiseQuotient(scaling.accel_scale), raw.gyro.cwiseQuotient(scaling.gyro_scale)};
}

/// Returns the factor that multiplies a coefficient in the sensor model.
double input_of(const Coefficient& c, const Vector3d& reading, const Vector3d& force) {
  if (c.term == Term::g_sensitivity) return force[c.column];
  if (c.term == Term::matrix) return reading[c.column];
  return c.term == Term::offset ? 1 : std::pow(reading[c.row], c.term == Term::quadratic ? 2 : 3);
}

bool bends_far_from_zero(const Coefficient& c, const Scaling& scaling) {
  if (c.term != Term::quadratic && c.term != Term::cubic) return false;
  const bool accel = c.triad == Triad::accel;
  const Vector3d zero = (accel ? scaling.accel_center : scaling.gyro_center).cwiseQuotient(accel ? scaling.accel_scale : scaling.gyro_scale);
  return zero.cwiseAbs().maxCoeff() > 1;  // in half ranges
}

}  // namespace

std::vector<CoefficientIndex> static_coefficients(bool with_gyros) {
  std::vector<CoefficientIndex> out = select_each({"accel.offset", "accel.matrix", "accel.quadratic", "accel.cubic"});
  std::erase_if(out, zero_by_frame);
  if (!with_gyros) return out;
  // The Earth's rate is far too small for nonlinearity.
  for (const CoefficientIndex index : select_each({"gyro.offset", "gyro.matrix", "gyro.g_sensitivity"})) out.push_back(index);
  return out;
}

std::vector<CoefficientIndex> handheld_coefficients() {
  std::vector<CoefficientIndex> out = static_coefficients(true);
  for (const CoefficientIndex index : select_each({"gyro.quadratic", "gyro.cubic"})) out.push_back(index);
  return out;
}

namespace {

/// Returns north, a unit vector in body axes, from gyros at rest if they resolve the Earth's rate.
std::optional<Vector3d> north_of(const Vector3d& rate, const Vector3d& up, double latitude) {
  const Vector3d across = rate - up.dot(rate) * up;
  const double horizontal = earth_rate * std::cos(latitude);
  if (!(std::abs(across.norm() - horizontal) < 0.5 * horizontal)) return std::nullopt;
  return across.normalized();
}

/// Returns true if the gyros find north in most rests.
bool find_north(const coarse::RestStart& start, const Site& site) {
  return site.latitude && 2 * std::ranges::count_if(start.rests, [&](const RestMeans& rest) {
                            const Vector3d force = output(start.model.accel, start.accel(rest));
                            const Vector3d rate = output(start.model.gyro, start.gyro(rest)) + start.model.g_sensitivity * force;
                            return north_of(rate, force.normalized(), *site.latitude).has_value();
                          }) > std::ssize(start.rests);
}

/// Returns the effects of the setting. Gyros that are not calibrated have no effects.
kernel::Effects expected_effects(const coarse::RestStart& start, const Recording& recording, const Session& session, bool with_effects, bool gyros) {
  kernel::EffectSizes sizes = kernel::effect_sizes(session, coarse::seen_of(start, recording, session.site.gravity()));
  if (!with_effects) return kernel::Effects(sizes, {});
  const EffectSetting setting{.accel = true,
                              .gyro = gyros,
                              .thermometer = start.recorded->thermometer(),
                              .latitude = session.site.latitude.has_value(),
                              .heading = gyros && find_north(start, session.site),
                              .sweep = start.recorded->sweep().has_value(),
                              .recordings = start.recorded->recordings()};
  if (setting.sweep)
    for (const std::string triad : {"accel", "gyro"}) {  // the first orders are parts of the thermal terms
      for (const auto& [part, whole] : {std::pair{".offset_temperature", ".thermal"}, {".scale_temperature", ".matrix_thermal"}}) {
        double& first_order = sizes.declared.try_emplace(triad + part, 0).first->second;
        if (first_order > 0) sizes.declared.try_emplace(triad + whole, first_order);
        first_order = 0;
      }
      // Sizes of other effects say little of this one, and in one attitude it looks like a bias.
      const std::string matrix = triad + ".matrix_thermal";
      sizes.declared.try_emplace(matrix, sizes.of(*find_effect(matrix)));
    }
  return kernel::Effects(sizes, setting);
}

}  // namespace

std::vector<EffectState> rest_states(const Recording& recording, const coarse::RestStart& start, const kernel::RecordedStates& recorded) {
  std::vector<EffectState> states(start.rests.size());
  PlayOperator play(recorded.at(0).gravity);
  const Vector3d noise = start.noise.accel.cwiseQuotient(start.scaling.accel_scale);
  std::size_t sample = 0;
  for (std::size_t k = 0; k < states.size(); ++k) {
    const RestMeans& rest = start.rests[k];
    EffectState& state = states[k];
    state = recorded.over(rest.range);
    Vector3d square = Vector3d::Zero();
    const Vector3d mean = linear_output(start.model.accel, start.accel(rest));
    const bool continues = continues_rest(recording, start.rests, k);
    for (; sample < rest.range.end; ++sample) {
      const Vector3d force = linear_output(start.model.accel, start.scaling.accel(reading_at(recording.accel, sample)));
      const Vector3d now = continues ? states[k - 1].play : play(force);
      if (sample < rest.range.begin) continue;
      state.play += now / static_cast<double>(rest.range.size());
      square += (force - mean).cwiseAbs2() / static_cast<double>(rest.range.size());
    }
    state.shaking = square - start.model.accel.matrix.cwiseAbs2() * noise.cwiseAbs2();
  }
  return states;
}

std::vector<CoefficientIndex> choose_coefficients(coarse::RestStart& start, const Session& session, const Recording& recording, bool with_effects,
                                                  const std::vector<CoefficientIndex>& wanted, const std::vector<CoefficientIndex>& supplied,
                                                  std::string_view method) {
  const std::vector<CoefficientIndex> chosen = kernel::chosen_coefficients(wanted, supplied, method);
  const auto of_gyros = [](CoefficientIndex index) { return coefficient(index).triad == Triad::gyro; };
  if (with_effects) {
    start.recorded.emplace(recording, session, start.model, start.scaling);
    start.states = rest_states(recording, start, *start.recorded);
  }
  start.effects = expected_effects(start, recording, session, with_effects, std::any_of(chosen.begin(), chosen.end(), of_gyros));
  start.named = !wanted.empty();
  for (const CoefficientIndex index : supplied) {
    if (contains(chosen, index)) continue;
    const Coefficient& c = coefficient(index);
    const bool counts = triad_model(start.prior, c.triad).raw_unit == "count";
    if (counts && (c.term == Term::offset || is_scale(c)))
      throw TermsError(fmt::format("{} is not among the terms to estimate: readings in counts have no bias and scale factor to start from", c.name));
    set_coefficient(start.model, index, coefficient_value(start.prior, index));
  }
  return chosen;
}

RestProblem::RestProblem(const coarse::RestStart& start, const Site& site, std::vector<CoefficientIndex> indices)
    : first_s_(start.first_s),
      gravity_(site.gravity()),
      relative_gravity_sigma_(site.gravity_sigma() / gravity_),
      latitude_(site.latitude),
      scaling_(start.scaling),
      noise_{scaled(start.means.sample, scaling_), scaled(start.means.rounding, scaling_), scaled(start.means.step, scaling_)},
      model_(start.model),
      prior_(start.prior),
      effects_(start.effects),
      indices_(std::move(indices)),
      roles_(indices_.size(), kernel::Role::estimated) {
  for (std::size_t k = 0; k < start.rests.size(); ++k)
    rests_.push_back({start.rests[k], start.states.empty() ? EffectState{.gravity = gravity_} : start.states[k]});
  if (start.recorded) sweep_ = start.recorded->sweep();
  for (std::size_t i = 0; i < indices_.size(); ++i) {
    unstated_.push_back(!start.named && bends_far_from_zero(coefficient(indices_[i]), scaling_));
    if (unstated_.back()) roles_[i] = kernel::Role::considered;
  }
}

double RestProblem::prior_sigma(const Coefficient& c) const {
  kernel::PriorSizes sizes = effects_.terms();
  sizes.accel.offset = 0.2 * gravity_, sizes.gyro.offset = 1.0;
  for (kernel::TriadPrior* triad : {&sizes.accel, &sizes.gyro}) triad->scale = 0.2, triad->misalignment = 1e-2;
  const auto row = triad_model(prior_, c.triad).matrix.row(c.row);
  if (std::abs(row[c.row]) <= 0.9 * row.norm()) sizes.accel.misalignment = sizes.gyro.misalignment = 0.2;
  return kernel::prior_sigma(sizes, c, row.norm());
}

kernel::Parameters RestProblem::parameters(Index nuisances) const {
  kernel::Parameters out(std::ssize(indices_) + nuisances + effects_.size());
  for (std::size_t i = 0; i < indices_.size(); ++i) {
    out.role[i] = roles_[i];
    out.offset[static_cast<Index>(i)] = coefficient_value(prior_, indices_[i]) - coefficient_value(model_, indices_[i]);
    out.sigma[static_cast<Index>(i)] = prior_sigma(coefficient(indices_[i]));
  }
  effects_.add_to(out);
  return out;
}

std::vector<Index> RestProblem::unseen_terms(const kernel::Parameters& parameters, const Eigen::MatrixXd& covariance) const {
  constexpr double nothing = 0.9;  // fraction of the prior sigma: the data have less than a quarter of the prior's information
  std::vector<Index> unseen;
  for (const Index i : parameters.with(kernel::Role::estimated))
    if (i < std::ssize(indices_) && is_optional(coefficient(indices_[static_cast<std::size_t>(i)]).term) &&
        !(std::sqrt(covariance(i, i)) <= nothing * parameters.sigma[i]))
      unseen.push_back(i);
  return unseen;
}

std::vector<Index> RestProblem::runaway_gyro_matrix(const kernel::Parameters& parameters, const Eigen::MatrixXd& covariance) const {
  constexpr double away = 2;  // in prior sigmas
  std::vector<Index> matrix;
  bool runaway = false;
  for (const Index i : parameters.with(kernel::Role::estimated)) {
    if (i >= std::ssize(indices_)) continue;
    const Coefficient& c = coefficient(indices_[static_cast<std::size_t>(i)]);
    if (c.triad != Triad::gyro || (c.term != Term::matrix && c.term != Term::quadratic && c.term != Term::cubic)) continue;
    matrix.push_back(i);
    if (!is_scale(c)) continue;
    const CoefficientIndex index = indices_[static_cast<std::size_t>(i)];
    const bool known = std::sqrt(covariance(i, i)) < kernel::needed_sigma(c, parameters.sigma[i]);
    runaway = runaway || (!known && std::abs(coefficient_value(model_, index) - coefficient_value(prior_, index)) > away * parameters.sigma[i]);
  }
  return runaway ? matrix : std::vector<Index>{};
}

VectorXd RestProblem::longest_step(Index nuisances) const {
  VectorXd longest = VectorXd::Constant(std::ssize(indices_) + nuisances + effects_.size(), kernel::no_prior);
  for (std::size_t i = 0; i < indices_.size(); ++i)
    if (const Coefficient& c = coefficient(indices_[i]); !is_optional(c.term)) longest[static_cast<Index>(i)] = prior_sigma(c);
  return longest;
}

void RestProblem::hold(const std::vector<Index>& unseen) {
  for (const Index i : unseen) roles_[static_cast<std::size_t>(i)] = kernel::Role::considered;
}

void RestProblem::release() {
  for (std::size_t i = 0; i < roles_.size(); ++i) roles_[i] = unstated_[i] ? kernel::Role::considered : kernel::Role::estimated;
}

void RestProblem::correct(const VectorXd& correction) {
  for (std::size_t i = 0; i < indices_.size(); ++i)
    set_coefficient(model_, indices_[i], coefficient_value(model_, indices_[i]) + correction[static_cast<Index>(i)]);
  effects_.correct(correction);
}

EffectState RestProblem::state_at(const Rest& rest) const {
  EffectState state = rest.observed;
  state.force = imulab::output(model_.accel, scaling_.accel(rest.accel));
  state.rate = imulab::output(model_.gyro, scaling_.gyro(rest.gyro));
  if (latitude_) {
    const Vector3d up = state.force.normalized();
    state.by_latitude.rate = earth_rate * std::cos(*latitude_) * up;
    if (const std::optional<Vector3d> north = north_of(state.rate + model_.g_sensitivity * state.force, up, *latitude_)) {
      state.by_latitude.rate -= earth_rate * std::sin(*latitude_) * *north;
      state.horizontal = {*north, north->cross(up)};
    }
  }
  return state;
}

Vector3d RestProblem::force_at(const Rest& rest) const {
  const EffectState state = state_at(rest);
  return state.force - effects_.output(state).force;
}

Vector3d RestProblem::rate_at(const Rest& rest) const {
  const EffectState state = state_at(rest);
  return state.rate + model_.g_sensitivity * force_at(rest) - effects_.output(state).rate;
}

Matrix3d RestProblem::force_covariance(const Rest& rest, double spread) const {
  return mean_covariance(model_.accel, noise_.sample.accel, noise_.rounding.accel, rest.range.size(), spread);
}

Matrix3d RestProblem::rate_covariance(const Rest& rest, double spread) const {
  return mean_covariance(with_half_the_scale_at_least(model_.gyro, prior_.gyro), noise_.sample.gyro, noise_.rounding.gyro, rest.range.size(), spread);
}

void RestProblem::add_derivatives(Conditions& c, Index row, Triad triad, const Rest& rest, const Eigen::MatrixXd& by_output) const {
  const Vector3d reading = triad == Triad::accel ? scaling_.accel(rest.accel) : scaling_.gyro(rest.gyro), force = force_at(rest);
  for (std::size_t i = 0; i < indices_.size(); ++i) {
    const Coefficient& term = coefficient(indices_[i]);
    if (term.triad != triad) continue;
    c.jacobian.col(static_cast<Index>(i)).segment(row, by_output.rows()) += input_of(term, reading, force) * by_output.col(term.row);
  }
  effects_.add_derivatives(c.jacobian, row, triad, by_output, state_at(rest));
}

std::vector<SuspectRows> RestProblem::suspects(const Conditions& conditions) const {
  std::vector<SuspectRows> all;
  for (std::size_t k = 0; k < rests_.size(); ++k) {
    SuspectRows& suspect =
        all.emplace_back(SuspectRows{fmt::format("the rest at {:.1f} s", rests_[k].mid_s - first_s_), {}, rests_[k].begin_s, rests_[k].end_s});
    const CovarianceBlock& block = conditions.blocks[k];
    for (Index row = block.first; row < block.first + block.size; ++row) suspect.rows.push_back(row);
  }
  return all;
}

}  // namespace imulab::rests
