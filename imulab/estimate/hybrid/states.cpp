#include "imulab/estimate/hybrid/states.hpp"

#include "imulab/core/error.hpp"
#include "imulab/core/units.hpp"
#include "imulab/estimate/kernel/input.hpp"
#include "imulab/estimate/kernel/optional_terms.hpp"
#include "imulab/estimate/kernel/prior.hpp"
#include "imulab/model/forward_model.hpp"
#include "imulab/model/frame.hpp"

#include <algorithm>
#include <limits>

namespace imulab::hybrid {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

namespace {

struct Row {
  Group group;
  std::string_view name;
  Index size = 0;  ///< 0: the states correct the coefficients of that name
};
constexpr std::array<Row, 14> table{{{Group::accel_offset, "accel.offset"},
                                     {Group::accel_matrix, "accel.matrix"},
                                     {Group::gyro_offset, "gyro.offset"},
                                     {Group::gyro_matrix, "gyro.matrix"},
                                     {Group::gravity, "gravity", 1},
                                     {Group::start, "attitude at the start", 3},
                                     {Group::latitude, "latitude", 1},
                                     {Group::lever_arm, "accel.lever_arm"},
                                     {Group::quadratic, "accel.quadratic"},
                                     {Group::g_sensitivity, "gyro.g_sensitivity"},
                                     {Group::delay, "delay of the accelerometers", 1},
                                     {Group::smear, "mean square of the delay", 1},
                                     {Group::flicker, "bias instability", 6 * in_place::SlowNoise::processes},
                                     {Group::mean, "mean of the offsets", 6}}};

/// Row by row; of the accelerometers' matrix the lower triangle, by the frame.
std::vector<CoefficientIndex> coefficients_of(const Row& row) {
  if (row.size > 0) return std::vector<CoefficientIndex>(static_cast<std::size_t>(row.size), CoefficientIndex(-1));
  std::vector<CoefficientIndex> indices = select_coefficients(row.name);
  std::erase_if(indices, zero_by_frame);
  return indices;
}

/// About the coarse solution, which is good to some percent, and to the Earth's rate with the effect of acceleration.
double prior_sigma(CoefficientIndex index, const Place& place, const OptionalPriors& priors) {
  kernel::PriorSizes sizes = priors.sizes;
  sizes.accel.offset = 0.02 * place.gravity, sizes.accel.scale = 0.05, sizes.accel.misalignment = 1e-2;
  sizes.gyro.offset = 3e-3, sizes.gyro.scale = 0.05, sizes.gyro.misalignment = 0.02;
  return kernel::prior_sigma(sizes, coefficient(index), 1);
}

double prior_sigma(Group group, Index i, const Place& place, const OptionalPriors& priors, const Noise& noise) {
  if (group == Group::mean) return 0;
  if (group == Group::smear) return priors.smear;
  if (group == Group::flicker) return (i < 3 * in_place::SlowNoise::processes ? noise.accel_slow : noise.gyro_slow).flicker;
  if (group == Group::gravity) return place.gravity_sigma / place.gravity;
  if (group == Group::start) return alignment_sigma()[i];
  return group == Group::latitude ? place.latitude_sigma : priors.delay;
}

}  // namespace

Place place_of(const Site& site) {
  if (!site.latitude) throw Error("the site has no latitude; expected one: the gyros measure the Earth's rate");
  return {*site.latitude, site.gravity(), site.latitude_sigma.value_or(0), site.gravity_sigma()};
}

bool on_turntable(const Session& session) {
  return std::any_of(session.rigs.begin(), session.rigs.end(), [](const RigDeclaration& rig) { return rig.kind == RigKind::turntable; });
}

Terms terms_of(const Session& session, const std::vector<CoefficientIndex>& wanted, const Vector3d& accel_offset, const Vector3d& gyro_offset,
               double interval_s) {
  // Declared, or half a sample, at least a millisecond; its mean square is of readings that mix neighboring samples.
  const double delay = session.imu.term_sigmas.delay.value_or(std::max(1e-3, 0.5 * interval_s));
  Terms out{{}, {}, {kernel::optional_priors(session.imu, accel_offset, gyro_offset), delay, delay * interval_s}};
  if (!wanted.empty()) {
    out.wanted = kernel::chosen_coefficients(wanted, all_coefficients(), "hybrid");
    out.optional = optional_groups(out.wanted);
    return out;
  }
  out.optional = {Group::quadratic, Group::g_sensitivity};
  if (on_turntable(session)) out.optional.insert({Group::lever_arm, Group::delay});
  return out;
}

std::string_view name(Group group) { return table[static_cast<std::size_t>(group)].name; }

Eigen::Vector3d alignment_sigma() { return {3 * unit::deg, 3 * unit::deg, 90 * unit::deg}; }

States::States(const Terms& terms, const Place& place, const Noise& noise) {
  const bool slow = noise.accel_slow.any() || noise.gyro_slow.any();
  const auto present = [&](Group group) {
    if (group == Group::latitude) return place.latitude_sigma > 0;
    if (group == Group::smear) return terms.optional.contains(Group::delay);
    return group < Group::latitude || (group >= Group::flicker ? slow : terms.optional.contains(group));
  };
  std::vector<double> sigma;
  for (const Row& row : table) {
    if (!present(row.group)) continue;
    const std::vector<CoefficientIndex> corrected = coefficients_of(row);
    places_[static_cast<std::size_t>(row.group)] = {static_cast<Index>(sigma.size()), static_cast<Index>(corrected.size())};
    for (std::size_t i = 0; i < corrected.size(); ++i) {
      const bool held = corrected[i] >= 0 && !terms.wanted.empty() && !contains(terms.wanted, corrected[i]);
      corrects_.push_back(corrected[i]);
      sigma.push_back(held                ? 0
                      : corrected[i] >= 0 ? prior_sigma(corrected[i], place, terms.priors)
                                          : prior_sigma(row.group, static_cast<Index>(i), place, terms.priors, noise));
    }
  }
  prior = Eigen::Map<const VectorXd>(sigma.data(), static_cast<Index>(sigma.size()));
}

Groups States::groups() const {
  Groups out;
  for (const Row& row : table)
    if (has(row.group)) out.insert(row.group);
  return out;
}

in_place::OptionalSums States::sums() const { return {has(Group::g_sensitivity), has(Group::quadratic), has(Group::lever_arm), has(Group::delay)}; }

Index States::offset(Index axis) const { return first(axis < 3 ? Group::accel_offset : Group::gyro_offset) + axis % 3; }

std::vector<Index> States::corrections() const {
  std::vector<Index> out;
  for (Index s = 0; s < constants(); ++s)
    if (corrects(s) >= 0 && prior[s] > 0) out.push_back(s);
  return out;
}

kernel::Parameters States::parameters(const VectorXd& total) const {
  kernel::Parameters p(constants());
  p.offset = -total;
  p.sigma = prior;
  return p;
}

VectorXd States::needed() const {
  VectorXd needed = VectorXd::Constant(constants(), std::numeric_limits<double>::infinity());
  for (const Index s : corrections()) needed[s] = (is_optional(coefficient(corrects(s)).term) ? 0.9 : 0.5) * prior[s];
  return needed;
}

std::vector<CoefficientIndex> all_coefficients() {
  std::vector<CoefficientIndex> out;
  for (const Row& row : table)
    if (row.size == 0)
      for (const CoefficientIndex index : coefficients_of(row)) out.push_back(index);
  return out;
}

Groups optional_groups(const std::vector<CoefficientIndex>& coefficients) {
  Groups out;
  for (const Row& row : table)
    for (const CoefficientIndex index : coefficients_of(row))
      if (row.group > Group::latitude && contains(coefficients, index)) out.insert(row.group);
  return out;
}

SensorModel with_mean_offsets(const SensorModel& model, const VectorXd& x, const States& states) {
  VectorXd error = VectorXd::Zero(states.constants());
  for (Index axis = 0; axis < states.size(Group::mean); ++axis)
    if (const Index s = states.offset(axis); states.prior[s] > 0) error[s] = x[states.first(Group::mean) + axis];
  return corrected(model, error, states);
}

SensorModel corrected(const SensorModel& model, const VectorXd& x, const States& states) {
  SensorModel error;  // each at the place of the coefficient it corrects
  error.accel.matrix.setZero(), error.gyro.matrix.setZero();
  for (Index s = 0; s < states.constants(); ++s)
    if (const CoefficientIndex index = states.corrects(s); index >= 0) set_coefficient(error, index, x[s]);
  return without_error(model, error);
}

Eigen::Matrix<double, 6, Eigen::Dynamic> transition(const in_place::BlockSums& sums, const States& states, const Place& place) {
  Eigen::Matrix<double, 6, Eigen::Dynamic> t(6, states.size());
  t.leftCols(states.constants()).setZero();
  t.rightCols<6>() = sums.by_errors_before(place.latitude);
  for (Index k = 0; k < states.constants(); ++k)
    if (states.corrects(k) >= 0) t.col(k) = sums.by_coefficient(coefficient(states.corrects(k)));
  for (Index k = 0; k < states.size(Group::flicker); ++k)
    t.col(states.first(Group::flicker) + k) = t.col(states.offset(k / in_place::SlowNoise::processes));
  t.col(states.first(Group::gravity)) = sums.by_gravity(place.gravity);
  if (states.has(Group::latitude)) t.col(states.first(Group::latitude)) = sums.by_latitude(place.latitude);
  if (states.has(Group::delay)) t.col(states.first(Group::delay)) = sums.by_delay(), t.col(states.first(Group::smear)) = sums.by_smear();
  return t;
}

MatrixXd correction_jacobian(const SensorModel& model, const std::vector<CoefficientIndex>& indices, const States& states) {
  constexpr double step = 1e-6;  // the correction is quadratic at most: central differences are exact
  MatrixXd jacobian(static_cast<Index>(indices.size()), states.constants());
  for (Index s = 0; s < states.constants(); ++s) {
    const VectorXd x = step * VectorXd::Unit(states.constants(), s);
    const SensorModel plus = corrected(model, x, states), minus = corrected(model, -x, states);
    for (std::size_t i = 0; i < indices.size(); ++i)
      jacobian(static_cast<Index>(i), s) = (coefficient_value(plus, indices[i]) - coefficient_value(minus, indices[i])) / (2 * step);
  }
  for (Index axis = 0; axis < states.size(Group::mean); ++axis)
    jacobian.col(states.first(Group::mean) + axis).swap(jacobian.col(states.offset(axis)));
  return jacobian;
}

}  // namespace imulab::hybrid
