#include "imulab/estimate/drive/unmodeled.hpp"

#include "imulab/coefficient.hpp"
#include "imulab/estimate/drive/coefficients.hpp"
#include "imulab/estimate/kernel/prior.hpp"
#include "imulab/estimate/kernel/recorded_states.hpp"
#include "imulab/units.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <set>
#include <utility>
#include <vector>

namespace imulab::drive {

using Eigen::Index;
using Eigen::VectorXd;

namespace {

const Effect& effect_named(std::string name) {
  name.erase(0, effect_prefix.size());
  return *find_effect(name.substr(0, name.rfind('.')));
}

/// Adds a default gravity because a drive needs no site: local gravity changes the center of the effects and the width of the play by 1e-3.
Session with_gravity(Session session) {
  if (!session.site.given_gravity && !session.site.latitude) session.site.given_gravity = unit::g;
  return session;
}

kernel::EffectSizes sizes_of(const Session& session) {
  kernel::EffectSizes out = kernel::effect_sizes(with_gravity(session));
  if (!session.imu.grade) out.grades = {{"mems"}};
  for (const char* name :
       {"accel.drift", "gyro.drift", "accel.offset_temperature", "gyro.offset_temperature", "accel.turn_on", "gyro.turn_on", "accel.rectification"})
    out.declared[name] = 0;
  return out;
}

/// Returns the play of the accelerometers, which depends on the sequence of forces.
std::vector<Vector3d> plays(const Recording& recording, double gravity) {
  PlayOperator play(gravity);
  std::vector<Vector3d> out;
  for (std::size_t i = 0; i < recording.size(); ++i) out.push_back(play(reading_at(recording.accel, i)));
  return out;
}

struct Terms {
  const Recording& recording;
  std::vector<CoefficientIndex> curvature;
  kernel::Effects effects;
  kernel::RecordedStates states;
  std::vector<Vector3d> play;
  Shared shared;

  void at(double time, const TimedIncrement& sample, Eigen::Ref<Eigen::Matrix<double, 6, Eigen::Dynamic>> changes) const {
    const auto after = std::ranges::lower_bound(recording.time_ns, std::llround(1e9 * (time - recording.interval_s / 2)));
    const auto row = static_cast<std::size_t>(std::min(after, recording.time_ns.end() - 1) - recording.time_ns.begin());
    EffectState state = states.at(row);
    state.full_force = shared.full_force, state.full_rate = shared.full_rate;
    state.rate = sample.increment.angle / sample.interval, state.force = sample.increment.velocity / sample.interval;
    state.play = play[row];
    changes.setZero();
    Index k = 0;
    for (const CoefficientIndex index : curvature) {
      const Coefficient& c = coefficient(index);
      const double reading = c.triad == Triad::gyro ? state.rate[c.row] : state.force[c.row];
      changes(c.triad == Triad::gyro ? c.row : 3 + c.row, k++) = c.term == Term::quadratic ? reading * reading : reading * reading * reading;
    }
    for (const EffectColumn& column : effects.columns()) {
      const OutputChange change = column.at(state);
      changes.col(k++) << change.rate, change.force;
    }
  }
};

}  // namespace

bool is_effect(const std::string& constant) { return constant.starts_with(effect_prefix); }
bool is_effect_of_unit(const std::string& constant) { return is_effect(constant) && effect_named(constant).each == Effect::Each::session; }
std::string shown_name(const std::string& constant) { return is_effect(constant) ? std::string(effect_named(constant).name) : constant; }

Shared shared_by(std::span<const Recording> recordings, const Session& session) {
  Shared out;
  for (const Recording& recording : recordings) {
    const kernel::RecordedStates states(recording, with_gravity(session), SensorModel{}, Scaling{});
    out.thermometer = out.thermometer && states.thermometer();
    out.full_force = std::max(out.full_force, states.at(0).full_force), out.full_rate = std::max(out.full_rate, states.at(0).full_rate);
  }
  return out;
}

aided::OutputTerms output_terms(const Recording& recording, const Session& session, const Shared& shared) {
  const kernel::PriorSizes sizes = optional_sizes(session.imu);
  auto terms = std::make_shared<Terms>(Terms{recording,
                                             {},
                                             {sizes_of(session), {.accel = true, .gyro = true, .thermometer = shared.thermometer}},
                                             kernel::RecordedStates(recording, with_gravity(session), SensorModel{}, Scaling{}),
                                             plays(recording, with_gravity(session).site.gravity()),
                                             shared});
  aided::OutputTerms out;
  std::vector<double> sigma;
  for (const CoefficientIndex index : select_each({"accel.quadratic", "accel.cubic", "gyro.quadratic", "gyro.cubic"}))
    if (const double prior = kernel::prior_sigma(sizes, coefficient(index), 1); prior > 0) {
      terms->curvature.push_back(index);
      out.names.emplace_back(coefficient(index).name), sigma.push_back(prior);
    }
  for (const kernel::EffectGroup& group : terms->effects.groups())
    for (Index k = 0; k < group.size; ++k)
      out.names.push_back(fmt::format("{}{}.{}", effect_prefix, group.effect->name, k)), sigma.push_back(group.sigma);
  out.sigma = Eigen::Map<const VectorXd>(sigma.data(), std::ssize(sigma));
  out.at = [terms](double time, const TimedIncrement& sample, auto changes) { terms->at(time, sample, changes); };
  return out;
}

kernel::Effects found_effects(const AidedNavigation& n, const Session& session) {
  kernel::EffectSizes sizes = sizes_of(session);
  std::vector<double> values;
  std::set<std::string_view> found;
  for (const AidedConstant& c : n.constants)
    if (is_effect(c.name)) values.push_back(c.value), found.insert(effect_named(c.name).name);
  for (const Effect& effect : effects())
    if (!found.contains(effect.name)) sizes.declared[std::string(effect.name)] = 0;
  kernel::Effects out(sizes, {.accel = true, .gyro = true, .thermometer = true});
  out.correct(Eigen::Map<const VectorXd>(values.data(), std::ssize(values)));
  return out;
}

}  // namespace imulab::drive
