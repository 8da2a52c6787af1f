#include "imulab/navigation/aided/aided_budget.hpp"

#include "imulab/coefficient.hpp"
#include "imulab/error.hpp"
#include "imulab/model/filter_flicker.hpp"
#include "imulab/navigation/aided/filter.hpp"
#include "imulab/navigation/aided/foreseen.hpp"
#include "imulab/navigation/aided/setup.hpp"
#include "imulab/navigation/aided/split_covariance.hpp"
#include "imulab/navigation/budget/growth.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <utility>

namespace imulab {
namespace aided {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;
using motion::NominalMotion;

class Parts {
 public:
  CovariancePart& named(const std::string& name) {
    const auto at = std::ranges::find(all, name, &CovariancePart::name);
    return at != all.end() ? *at : all.emplace_back(CovariancePart{name, {}, {}});
  }
  std::vector<CovariancePart> all;
};

struct SensorState {
  CoefficientIndex coefficient{};
  Index state;
};

std::vector<SensorState> sensor_states(const Problem& p) {
  std::vector<SensorState> out;
  for (int i = 0; i < 3; ++i) {
    out.push_back({coefficient_index(Triad::gyro, Term::offset, i, i), p.gyro_offset + i});
    out.push_back({coefficient_index(Triad::accel, Term::offset, i, i), p.accel_offset + i});
    for (int j = 0; j < 3 && p.gyro_matrix >= 0; ++j) {
      out.push_back({coefficient_index(Triad::gyro, Term::matrix, i, j), p.gyro_matrix + 3 * j + i});
      out.push_back({coefficient_index(Triad::accel, Term::matrix, i, j), p.accel_matrix + 3 * j + i});
      out.push_back({coefficient_index(Triad::gyro, Term::g_sensitivity, i, j), p.g_sensitivity + 3 * j + i});
    }
  }
  std::ranges::sort(out, {}, [](const SensorState& s) { return s.coefficient; });
  return out;
}

std::string name_of_part(const std::string& block) { return in_words(block.starts_with("accel.") ? "accelerometer" + block.substr(5) : block); }

void add_noise_parts(Parts& parts, const Problem& p, const ErrorSources& sources) {
  for (std::size_t k = 0; k < p.sources.size(); ++k) {
    const std::string& name = p.sources[k].name;
    const bool gyro = name.starts_with("gyro"), white = k == p.gyro_source || k == p.accel_source;
    if (gyro || name.starts_with("accel")) {
      const NoiseModel& n = gyro ? sources.gyro_noise : sources.accel_noise;
      const FilterFlicker f(n.B);
      const std::string triad = gyro ? "gyro " : "accelerometer ";
      const double other = white ? n.N : name.ends_with("drift") ? n.K : 0, slow = white ? f.white : name.ends_with("drift") ? f.walk : f.sigma;
      const double all = other * other + slow * slow;
      if (!(all > 0)) continue;
      parts.named(triad + "flicker").noises.emplace_back(k, slow * slow / all);
      parts.named(triad + (white ? "white noise" : "random walk")).noises.emplace_back(k, other * other / all);
    } else {
      const bool slow = std::ranges::find(p.blocks, name, &StateBlock::name) != p.blocks.end();
      parts.named(in_words(name) + (slow ? "" : " noise")).noises.emplace_back(k, 1);
    }
  }
}

std::vector<CovariancePart> parts_of(const Problem& p, const FilterStart& start, const ErrorSources& sources) {
  Parts parts;
  const auto add = [&](const std::string& name, Index state, double sigma) {
    if (sigma > 0) parts.named(name).states.emplace_back(state, sigma * sigma);
  };
  for (const SensorState& s : sensor_states(p)) {
    const Coefficient& c = coefficient(s.coefficient);
    const NoiseModel noise = c.term != Term::offset ? NoiseModel{} : c.triad == Triad::gyro ? sources.gyro_noise : sources.accel_noise;
    const double turn_on = noise.turn_on.value, flicker = FilterFlicker(noise.B).start;
    const std::string triad = c.triad == Triad::gyro ? "gyro " : "accelerometer ";
    add(budget::group_of(c), s.state, std::sqrt(std::max(0., std::pow(start.sigma[s.state], 2) - turn_on * turn_on - flicker * flicker)));
    add(triad + "turn-on", s.state, std::abs(turn_on));
    add(triad + "flicker", s.state, flicker);
  }
  const Eigen::VectorXd variance = start_variance(p, start);
  for (Index k = 0; k < 3; ++k) add(k < 2 ? "start attitude: level" : "start attitude: heading", At::attitude + k, start.sigma[k]);
  for (Index k = 0; k < 3; ++k) add("start velocity", At::velocity + k, start.sigma[At::velocity + k]);
  for (Index k = 0; k < 3; ++k) add("start position", At::position + k, start.sigma[At::position + k]);
  for (const StateBlock& b : p.blocks)
    for (Index k = 0; k < b.size && (b.first >= p.sensors_end || b.stationary()); ++k)
      add(name_of_part(b.name), b.first + k, std::sqrt(variance[b.first + k]));
  add_noise_parts(parts, p, sources);
  return parts.all;
}

/// The filter state for each quantity of a budget, and its sign: the state is what must be added to the computed value, except for the attitude.
constexpr std::array<Index, budget_quantities> state_of{6, 7, 8, 3, 4, 5, 0, 1, 2};
constexpr std::array<double, budget_quantities> sign_of{1, 1, 1, 1, 1, 1, -1, -1, -1};

SensorPriors priors_of(const ErrorSources& s) {
  SensorPriors out;
  MatrixXd covariance = s.covariance;
  covariance.diagonal() += s.fixed.cwiseAbs2();
  take_coefficients(s.model, s.coefficients, covariance, out);
  for (Index k = 0; k < 3; ++k) {
    out.gyro_offset[k] = std::hypot(out.gyro_offset[k], s.gyro_noise.turn_on.value);
    out.accel_offset[k] = std::hypot(out.accel_offset[k], s.accel_noise.turn_on.value);
  }
  take_noise(s.gyro_noise, s.accel_noise, out);
  return out;
}

/// Returns the attitude error at the start. The error of an alignment counts as independent of the sensors' errors.
Vector3d attitude_at_start(const NavigationState& start, const ErrorSources& s, const SensorPriors& priors) {
  const StartErrors& e = s.start;
  if (!e.aligned_over) return {e.attitude[0].value, e.attitude[1].value, e.attitude[2].value};
  Eigen::Matrix<double, 6, 1> variance;
  const double T = *e.aligned_over;
  variance << priors.gyro_offset.cwiseAbs2() + priors.gyro_noise.cwiseAbs2() / T,
      priors.accel_offset.cwiseAbs2() + priors.accel_noise.cwiseAbs2() / T;
  Vector3d out = (budget::alignment_effect(start, e, {}).cwiseAbs2() * variance).cwiseSqrt();
  if (e.heading_given()) out.z() = e.attitude[2].value;
  return out;
}

/// Returns the time of the loss, and adds this outage to the aids.
Outage choose_loss(std::vector<Aid>& aids, const NominalMotion& motion) {
  const double begin = motion.time.front(), end = motion.time.back();
  Outage longest;
  for (const Aid& aid : aids)
    for (const Outage& o : aid.outages) {
      const Outage inside{std::max(o.begin, begin), std::min(o.end, end)};
      if (has_record(aid.kind) && inside.end - inside.begin > longest.end - longest.begin) longest = inside;
    }
  if (longest.end > longest.begin) return longest;
  constexpr double usual = 600, part = 3;  // s; fraction of the motion
  longest = {end - std::min(usual, (end - begin) / part), end};
  const bool receiver = std::ranges::any_of(aids, [](const Aid& a) { return a.kind == AidKind::gnss; });
  if (std::ranges::none_of(aids, [](const Aid& a) { return has_record(a.kind); }))
    throw Error("aids without a record cannot be lost; expected one that measures, as a receiver");
  for (Aid& aid : aids)
    if (receiver ? aid.kind == AidKind::gnss : has_record(aid.kind)) aid.outages.push_back({longest.begin, end + 1});
  return longest;
}

/// Sets the errors of aids as declared: white, or mostly slow if a correlation time is given.
void set_sizes(Problem& p) {
  for (const Channel& c : p.channels) {
    if (!has_record(c.aid.kind) || c.slow < 0) continue;
    StateBlock& slow = *std::ranges::find(p.blocks, c.slow, &StateBlock::first);
    const double white = c.aid.correlation ? white_share : 1;
    slow.sigma = c.aid.kind == AidKind::gnss ? position_sigma(c.aid, 0).mean() : value_sigma(c.aid, 0);
    slow.prior.setConstant(slow.sigma);
    p.sources[*slow.noise].factor = 1 - white, p.sources[c.first_noise].factor = white;
  }
}

/// Returns the aids with this outage and withholds all their measurements from then on, including a fix at the end of the outage.
AidLoss withhold_lost(Problem& p, const Outage& loss) {
  AidLoss out{loss.begin, {}};
  for (std::size_t k = 0; k < p.channels.size(); ++k) {
    const Aid& aid = p.channels[k].aid;
    const auto covers = [&](const Outage& o) { return o.begin <= loss.begin && o.end > loss.begin; };
    if (!has_record(aid.kind) || std::ranges::none_of(aid.outages, covers)) continue;
    out.aids.push_back(p.channels[k].name);
    for (Observation& o : p.observations) o.withheld = o.withheld || (o.channel == k && o.stamp >= loss.begin);
  }
  return out;
}

/// Collects the outputs of a budget.
struct AidedOutputs {
  const std::vector<CovariancePart>& parts;
  const std::vector<SensorState>& sensors;
  const FilterStart& start;
  ErrorBudget out = {};
  std::vector<BudgetRows> rows = {};  // columns: parts, then sensors

  void add(double time, const SplitCovariance& split) {
    out.time.push_back(time);
    BudgetMatrix P;
    for (int a = 0; a < budget_quantities; ++a)
      for (int b = 0; b < budget_quantities; ++b) {
        const auto i = static_cast<std::size_t>(a), j = static_cast<std::size_t>(b);
        P(a, b) = sign_of[i] * sign_of[j] * split.total()(state_of[i], state_of[j]);
      }
    out.covariance.push_back(P);
    rows.emplace_back(budget_quantities, static_cast<Index>(parts.size() + sensors.size()));
    for (int q = 0; q < budget_quantities; ++q) {
      const Index state = state_of[static_cast<std::size_t>(q)];
      for (std::size_t k = 0; k < parts.size(); ++k) rows.back()(q, static_cast<Index>(k)) = std::sqrt(split.variance(parts[k], state));
      for (std::size_t k = 0; k < sensors.size(); ++k)
        rows.back()(q, static_cast<Index>(parts.size() + k)) = std::abs(split.by_start()(state, sensors[k].state)) * start.sigma[sensors[k].state];
    }
  }

  ErrorBudget finish() {
    const auto add_one = [&](std::vector<Contribution>& to, std::string name, Index column) {
      Contribution c{std::move(name), BudgetRows::Zero(budget_quantities, std::ssize(rows)), BudgetRows(budget_quantities, std::ssize(rows))};
      for (std::size_t i = 0; i < rows.size(); ++i) c.sigma.col(static_cast<Index>(i)) = rows[i].col(column);
      if (!c.sigma.isZero(0)) to.push_back(std::move(c));
    };
    for (std::size_t k = 0; k < parts.size(); ++k) add_one(out.groups, parts[k].name, static_cast<Index>(k));
    for (std::size_t k = 0; k < sensors.size(); ++k)
      add_one(out.coefficients, std::string(coefficient(sensors[k].coefficient).name), static_cast<Index>(parts.size() + k));
    out.mean = BudgetRows::Zero(budget_quantities, std::ssize(rows));
    return std::move(out);
  }
};

FilterStart start_of(const Problem& p, const NominalMotion& motion, const ErrorSources& sources, const SensorPriors& priors) {
  const Prior prior = prior_of(p);
  FilterStart out{.mean = {motion.states.front(), prior.mean}, .sigma = prior.sigma, .sample = 0};
  for (const StateBlock& b : p.blocks) out.sigma.segment(b.first, b.size) = b.prior;  // states without an error are exact
  out.sigma.segment<3>(At::attitude) = attitude_at_start(motion.states.front(), sources, priors).cwiseAbs();
  for (Index k = 0; k < 3; ++k) {
    out.sigma[At::velocity + k] = std::abs(sources.start.velocity[static_cast<std::size_t>(k)].value);
    out.sigma[At::position + k] = std::abs(sources.start.position[static_cast<std::size_t>(k)].value);
  }
  return out;
}

}  // namespace
}  // namespace aided

ErrorBudget aided_budget(const motion::NominalMotion& motion, const ErrorSources& sources, const std::vector<Aid>& given,
                         const AidedBudgetOptions& options) {
  using namespace aided;
  budget::check(motion);
  std::vector<Aid> aids = given;
  const Outage loss = choose_loss(aids, motion);
  Session session;
  session.site.latitude = motion.states.front().latitude, session.site.height = motion.states.front().height;
  const SensorPriors priors = priors_of(sources);
  const bool matrices = !priors.gyro_matrix.isZero(0) || !priors.accel_matrix.isZero(0) || !priors.g_sensitivity.isZero(0);
  const Recording readings = ideal_readings(motion);
  Problem p = make_problem(readings, priors, aids, session, {.matrices = matrices, .gyro_delay_sigma = 0, .outages = {}});
  set_sizes(p);
  const AidLoss lost = withhold_lost(p, loss);
  const FilterStart start = start_of(p, motion, sources, priors);
  AboutTrajectory truth{.at = [&](std::size_t samples) { return motion.states[samples]; }, .x = start.mean.x, .weights = {}};
  truth.weights.assign(p.observations.size(), Eigen::VectorXd::Ones(6));  // without data there are no suspects
  SplitCovariance split(p, start);
  const std::vector<CovariancePart> parts = parts_of(p, start, sources);
  const std::vector<SensorState> sensors = sensor_states(p);
  AidedOutputs outputs{.parts = parts, .sensors = sensors, .start = start};
  budget::Outputs before(motion.time.front(), options.output_interval), after(loss.begin - 1, 1);
  const auto end = static_cast<std::size_t>(std::ranges::upper_bound(p.time, loss.end + p.interval / 2) - p.time.begin());
  filter(p, start, {.about = &truth, .end = end, .keep = false, .each = [&](const Transition* step, const Matrix9&, const Node& node) {
                      if (step != nullptr) split.step(*step);
                      split.update(node);
                      const double time = p.time_after(node.samples);
                      const bool absent = time > loss.begin - p.interval / 2;
                      if (step != nullptr && ((absent ? after.due(time + p.interval / 2) : before.due(time)) || node.samples == end))
                        outputs.add(time, split);
                    }});
  ErrorBudget out = outputs.finish();
  out.loss = lost;
  return out;
}

std::string beyond_aided_budget(const ErrorSources& s) {
  std::vector<std::string> names;
  const auto add = [&](const std::string& name) {
    if (std::ranges::find(names, name) == names.end()) names.push_back(name);
  };
  for (std::size_t k = 0; k < s.coefficients.size(); ++k) {
    const Coefficient& c = coefficient(s.coefficients[k]);
    const auto i = static_cast<Eigen::Index>(k);
    const bool any = s.fixed[i] != 0 || s.covariance(i, i) > 0;
    if (any && c.term != Term::offset && c.term != Term::matrix && c.term != Term::g_sensitivity) add(budget::group_of(c));
  }
  for (const auto& [triad, noise] : {std::pair{"gyro", &s.gyro_noise}, {"accelerometer", &s.accel_noise}}) {
    if (noise->Q != 0) add(fmt::format("{} quantization", triad));
    if (noise->R.value != 0) add(fmt::format("{} ramp", triad));
  }
  std::string text;
  for (const std::string& name : names) text += (text.empty() ? "" : ", ") + name;
  return text;
}

}  // namespace imulab
