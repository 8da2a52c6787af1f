#include "imulab/estimate/hybrid/states.hpp"

#include "imulab/error.hpp"
#include "imulab/estimate/kernel/effects.hpp"
#include "imulab/estimate/kernel/input.hpp"
#include "imulab/estimate/kernel/prior.hpp"
#include "imulab/model/effects.hpp"
#include "imulab/model/forward_model.hpp"
#include "imulab/model/frame_axes.hpp"
#include "imulab/units.hpp"

#include <algorithm>
#include <limits>

namespace imulab::hybrid {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;
using in_place::Errors6;

namespace {

/// The inputs for a group's prior and presence.
struct Setting {
  const Terms& terms;
  const Place& place;
  const Noise& noise;
  bool slow() const { return noise.accel_slow.any() || noise.gyro_slow.any(); }
};

/// Errors of attitude and velocity after a block by the k-th state of a group.
struct Column {
  const in_place::BlockSums& sums;
  const States& states;
  const Place& place;
  Errors6 by_coefficient(Index constant) const { return sums.by_coefficient(coefficient(states.corrects(constant))); }
};

/// The properties of a group. Without a size, its states correct the coefficients of that name and use their prior and column.
struct Row {
  Group group;
  std::string_view name;
  Index size = 0;
  Linearity linearity = Linearity::corrected;
  bool (*present)(const Setting&) = [](const Setting&) { return true; };
  double (*prior)(const Setting&, Index k) = nullptr;   ///< one sigma of the k-th state
  Errors6 (*column)(const Column&, Index k) = nullptr;  ///< null: no state acts on a single block
};

template <Group group>
bool asked(const Setting& s) {
  return s.terms.optional.contains(group);
}
bool slow(const Setting& s) { return s.slow(); }
constexpr int processes = in_place::SlowNoise::processes;

constexpr std::array<Row, 15> table{
    {{Group::accel_offset, "accel.offset"},
     {Group::accel_matrix, "accel.matrix"},
     {Group::gyro_offset, "gyro.offset"},
     {Group::gyro_matrix, "gyro.matrix"},
     {.group = Group::gravity,
      .name = "gravity",
      .size = 1,
      .linearity = Linearity::whole,
      .prior = [](const Setting& s, Index) { return s.place.gravity_sigma / s.place.gravity; },
      .column = [](const Column& c, Index) { return c.sums.by_gravity(c.place.gravity); }},
     {.group = Group::start,
      .name = "attitude at the start",
      .size = 3,
      .linearity = Linearity::path,
      .prior = [](const Setting&, Index k) { return alignment_sigma()[k]; }},
     {.group = Group::latitude,
      .name = "latitude",
      .size = 1,
      .present = [](const Setting& s) { return s.place.latitude_sigma > 0; },
      .prior = [](const Setting& s, Index) { return s.place.latitude_sigma; },
      .column = [](const Column& c, Index) { return c.sums.by_latitude(c.place.latitude); }},
     {.group = Group::lever_arm, .name = "accel.lever_arm", .present = asked<Group::lever_arm>},
     {.group = Group::quadratic, .name = "accel.quadratic", .present = asked<Group::quadratic>},
     {.group = Group::g_sensitivity, .name = "gyro.g_sensitivity", .present = asked<Group::g_sensitivity>},
     {.group = Group::delay,
      .name = "delay of the accelerometers",
      .size = 1,
      .linearity = Linearity::whole,
      .present = asked<Group::delay>,
      .prior = [](const Setting& s, Index) { return s.terms.priors.delay; },
      .column = [](const Column& c, Index) { return c.sums.by_delay(); }},
     {.group = Group::smear,
      .name = "mean square of the delay",
      .size = 1,
      .linearity = Linearity::whole,
      .present = asked<Group::delay>,
      .prior = [](const Setting& s, Index) { return s.terms.priors.smear; },
      .column = [](const Column& c, Index) { return c.sums.by_smear(); }},
     {.group = Group::flicker,
      .name = "bias instability",
      .size = 6 * processes,
      .linearity = Linearity::path,
      .present = slow,
      .prior = [](const Setting& s, Index k) { return (k < 3 * processes ? s.noise.accel_slow : s.noise.gyro_slow).flicker; },
      .column = [](const Column& c, Index k) { return c.by_coefficient(c.states.offset(k / processes)); }},
     {.group = Group::mean,
      .name = "mean of the offsets",
      .size = 6,
      .linearity = Linearity::path,
      .present = slow,
      .prior = [](const Setting&, Index) { return 0.0; }},
     {.group = Group::rest_heading, .name = "heading in a rest", .size = 1, .linearity = Linearity::path, .prior = [](const Setting&, Index) {
        return 0.0;
      }}}};

/// Returns the coefficients row by row; for the accelerometer matrix only the lower triangle, because of the frame.
std::vector<CoefficientIndex> coefficients_of(const Row& row) {
  if (row.size > 0) return std::vector<CoefficientIndex>(static_cast<std::size_t>(row.size), CoefficientIndex(-1));
  std::vector<CoefficientIndex> indices = select_coefficients(row.name);
  std::erase_if(indices, zero_by_frame);
  return indices;
}

/// Returns the prior about the coarse solution, which is accurate to some percent and, with the effect of acceleration, to the Earth's rate.
double prior_of_coefficient(CoefficientIndex index, const Setting& s) {
  kernel::PriorSizes sizes = s.terms.priors.sizes;
  sizes.accel.offset = 0.02 * s.place.gravity, sizes.accel.scale = 0.05, sizes.accel.misalignment = 1e-2;
  sizes.gyro.offset = 3e-3, sizes.gyro.scale = 0.05, sizes.gyro.misalignment = 0.02;
  const bool fixed = !s.terms.wanted.empty() && !contains(s.terms.wanted, index);
  return fixed ? 0 : kernel::prior_sigma(sizes, coefficient(index), 1);
}

}  // namespace

Place place_of(const Site& site) {
  if (!site.latitude) throw Error("the site has no latitude; expected one: the gyros measure the Earth's rate");
  return {*site.latitude, site.gravity(), site.latitude_sigma.value_or(0), site.gravity_sigma()};
}

Place with_latitude_effect(Place place, const Session& session) {
  if (!session.site.latitude_sigma) place.latitude_sigma = kernel::effect_sizes(session).of(*find_effect("site.latitude"));
  return place;
}

bool on_turntable(const Session& session) {
  return std::any_of(session.rigs.begin(), session.rigs.end(), [](const RigDeclaration& rig) { return rig.kind == RigKind::turntable; });
}

Terms terms_of(const Session& session, const std::vector<CoefficientIndex>& wanted, const kernel::SeenOfUnit& seen, double interval_s) {
  // The delay is as declared, or half a sample but at least a millisecond; its mean square represents readings that mix neighboring samples.
  const double delay = session.imu.term_sigmas.delay.value_or(std::max(1e-3, 0.5 * interval_s));
  Terms out{{}, {}, {kernel::optional_priors(kernel::of_likeliest_grade(session.imu, seen)), delay, delay * interval_s}};
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

Linearity linearity(Group group) { return table[static_cast<std::size_t>(group)].linearity; }

Eigen::Vector3d alignment_sigma() { return {3 * unit::deg, 3 * unit::deg, 90 * unit::deg}; }

States::States(const Terms& terms, const Place& place, const Noise& noise) {
  const Setting setting{terms, place, noise};
  std::vector<double> sigma;
  for (const Row& row : table) {
    if (!row.present(setting)) continue;
    const std::vector<CoefficientIndex> indices = coefficients_of(row);
    places_[static_cast<std::size_t>(row.group)] = {std::ssize(sigma), std::ssize(indices)};
    for (Index k = 0; k < std::ssize(indices); ++k) {
      const CoefficientIndex index = indices[static_cast<std::size_t>(k)];
      corrects_.push_back(index);
      sigma.push_back(row.prior ? row.prior(setting, k) : prior_of_coefficient(index, setting));
    }
  }
  prior = Eigen::Map<const VectorXd>(sigma.data(), std::ssize(sigma));
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
  SensorModel error;  // each at the place of the coefficient that it corrects
  error.accel.matrix.setZero(), error.gyro.matrix.setZero();
  for (Index s = 0; s < states.constants(); ++s)
    if (const CoefficientIndex index = states.corrects(s); index >= 0) set_coefficient(error, index, x[s]);
  return without_error(model, error);
}

Eigen::Matrix<double, 6, Eigen::Dynamic> transition(const in_place::BlockSums& sums, const States& states, const Place& place) {
  Eigen::Matrix<double, 6, Eigen::Dynamic> t(6, states.size());
  t.leftCols(states.constants()).setZero();
  t.rightCols<6>() = sums.by_errors_before(place.latitude);
  const Column column{sums, states, place};
  for (const Row& row : table)
    for (Index k = 0, first = states.first(row.group); k < states.size(row.group); ++k) {
      if (row.size == 0) t.col(first + k) = column.by_coefficient(first + k);
      if (row.column) t.col(first + k) = row.column(column, k);
    }
  return t;
}

MatrixXd correction_jacobian(const SensorModel& model, const std::vector<CoefficientIndex>& indices, const States& states) {
  constexpr double step = 1e-6;  // the correction is at most quadratic: central differences are exact
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
