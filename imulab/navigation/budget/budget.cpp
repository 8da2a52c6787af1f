#include "imulab/navigation/budget/budget.hpp"

#include "imulab/coefficient.hpp"
#include "imulab/error.hpp"
#include "imulab/navigation/budget/growth.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace imulab {
namespace {

using namespace budget;
using Eigen::MatrixXd;
using Eigen::VectorXd;
using motion::NominalMotion;
using At = ErrorIndex;

constexpr const char* algorithm = "algorithm";  // error of the integration itself

/// Returns the rows position, velocity, attitude.
template <class Columns>
BudgetRows rows_of(const Columns& x) {
  BudgetRows out(budget_quantities, x.cols());
  out << x.template middleRows<3>(At::position), x.template middleRows<3>(At::velocity), x.template middleRows<3>(At::attitude);
  return out;
}

/// Sizes of all parameters: fixed errors, the covariance of random ones, and the group of each.
struct Parameters {
  VectorXd fixed;
  MatrixXd covariance;
  std::vector<std::string> group;
};

Parameters parameters_of(const ErrorSources& sources, const SourceColumns& columns) {
  Parameters p{VectorXd::Zero(columns.count), MatrixXd::Zero(columns.count, columns.count), {}};
  p.fixed.head(columns.coefficients) = sources.fixed;
  p.covariance.topLeftCorner(columns.coefficients, columns.coefficients) = sources.covariance;
  for (const CoefficientIndex index : sources.coefficients) p.group.push_back(group_of(coefficient(index)));
  const auto add = [&](const Spread& spread, const std::string& group) {
    const auto at = static_cast<Eigen::Index>(p.group.size());
    if (spread.fixed)
      p.fixed[at] = spread.value;
    else
      p.covariance(at, at) = spread.value * spread.value;
    p.group.push_back(group);
  };
  const auto add_triad = [&](const Spread& spread, const std::string& group) {
    for (int k = 0; k < 3; ++k) add(spread, group);
  };
  add_triad(sources.gyro_noise.turn_on, "gyro turn-on");
  add_triad(sources.accel_noise.turn_on, "accelerometer turn-on");
  add_triad(sources.gyro_noise.R, "gyro ramp");
  add_triad(sources.accel_noise.R, "accelerometer ramp");
  for (const Spread& s : sources.start.position) add(s, "start position");
  for (const Spread& s : sources.start.velocity) add(s, "start velocity");
  for (std::size_t k = 0; k < 3; ++k)
    add(sources.start.aligned_over && k < 2 ? Spread{} : sources.start.attitude[k], k < 2 ? "start attitude: level" : "start attitude: heading");
  add(sources.barometer.bias, "barometer");
  return p;
}

/// Returns the error of Strapdown itself for a perfect IMU, at the outputs (sample numbers).
BudgetRows algorithm_error(const NominalMotion& motion, const StrapdownOptions& options, const std::vector<std::size_t>& outputs) {
  BudgetRows out(budget_quantities, static_cast<Eigen::Index>(outputs.size()));
  Strapdown strapdown(motion.states.front(), options);
  std::size_t next = 0;
  for (std::size_t i = 0; i < motion.increments.size(); ++i) {
    strapdown.step(motion.increments[i], motion.time[i + 1] - motion.time[i], motion.states[i + 1].height);
    if (next < outputs.size() && outputs[next] == i + 1)
      out.col(static_cast<Eigen::Index>(next++)) = rows_of(error_of(strapdown.state(), motion.states[i + 1]));
  }
  return out;
}

Eigen::Index outputs(const ErrorBudget& budget) { return static_cast<Eigen::Index>(budget.time.size()); }

Contribution& added(std::vector<Contribution>& to, const ErrorBudget& budget, const std::string& name) {
  return to.emplace_back(
      Contribution{name, BudgetRows::Zero(budget_quantities, outputs(budget)), BudgetRows::Zero(budget_quantities, outputs(budget))});
}

Contribution& group(ErrorBudget& budget, const std::string& name) {
  const auto found = std::find_if(budget.groups.begin(), budget.groups.end(), [&](const Contribution& c) { return c.name == name; });
  return found != budget.groups.end() ? *found : added(budget.groups, budget, name);
}

void add_coefficients(ErrorBudget& budget, const std::vector<BudgetRows>& sensitivities, const Parameters& p, const ErrorSources& sources) {
  for (std::size_t k = 0; k < sources.coefficients.size(); ++k) {
    const auto column = static_cast<Eigen::Index>(k);
    const double sigma = std::sqrt(p.covariance(column, column));
    Contribution& c = added(budget.coefficients, budget, std::string(coefficient(sources.coefficients[k]).name));
    for (std::size_t i = 0; i < sensitivities.size(); ++i) {
      c.fixed.col(static_cast<Eigen::Index>(i)) = p.fixed[column] * sensitivities[i].col(column);
      c.sigma.col(static_cast<Eigen::Index>(i)) = sigma * sensitivities[i].col(column).cwiseAbs();
    }
  }
}

/// Adds each group with its own block of the covariance.
void add_groups(ErrorBudget& budget, const std::vector<BudgetRows>& sensitivities, const Parameters& p) {
  std::vector<std::string> names;
  for (const std::string& name : p.group)
    if (std::find(names.begin(), names.end(), name) == names.end()) names.push_back(name);
  for (const std::string& name : names) {
    std::vector<Eigen::Index> of;
    for (std::size_t k = 0; k < p.group.size(); ++k)
      if (p.group[k] == name) of.push_back(static_cast<Eigen::Index>(k));
    const VectorXd fixed = p.fixed(of);
    const MatrixXd covariance = p.covariance(of, of);
    if (fixed.isZero(0) && covariance.isZero(0)) continue;
    Contribution& c = group(budget, name);
    for (std::size_t i = 0; i < sensitivities.size(); ++i) {
      const auto at = static_cast<Eigen::Index>(i);
      const BudgetRows s = sensitivities[i](Eigen::all, of);
      c.fixed.col(at) = s * fixed;
      c.sigma.col(at) = (s * covariance).cwiseProduct(s).rowwise().sum().cwiseMax(0.0).cwiseSqrt();
    }
  }
}

/// Adds noise to the group of this name, which is created if necessary.
void add_noise(ErrorBudget& budget, const std::string& name, const std::vector<BudgetMatrix>& covariance) {
  Contribution& c = group(budget, name);
  for (std::size_t i = 0; i < covariance.size(); ++i) {
    auto sigma = c.sigma.col(static_cast<Eigen::Index>(i));
    sigma = (sigma.cwiseAbs2() + covariance[i].diagonal()).cwiseMax(0.0).cwiseSqrt();
    budget.covariance[i] += covariance[i];
  }
}

BudgetMatrix block_of(const ErrorMatrix& P) {
  const BudgetRows rows = rows_of(P);  // 9 x 10
  return rows_of(rows.transpose()).transpose();
}

}  // namespace

namespace budget {

std::string group_of(const Coefficient& c) {
  const std::string triad = c.triad == Triad::gyro ? "gyro " : "accelerometer ";
  switch (c.term) {
    case Term::offset:
      return triad + "bias";
    case Term::matrix:
      return triad + (c.row == c.column ? "scale" : "misalignment");
    case Term::quadratic:
    case Term::cubic:
      return triad + "nonlinearity";
    case Term::thermal:
    case Term::matrix_thermal1:
    case Term::matrix_thermal2:
      return triad + "temperature";
    case Term::g_sensitivity:
      return "g-sensitivity";
    case Term::lever_arm:
      break;
  }
  return triad + "lever arms";
}

}  // namespace budget

std::vector<double> ErrorBudget::shares(int quantity, std::size_t at) const {
  if (quantity < 0 || quantity >= budget_quantities || at >= time.size())
    throw Error(fmt::format("quantity {} at output {}; expected one of {} at one of {}", quantity, at, budget_quantities, time.size()));
  const auto column = static_cast<Eigen::Index>(at);
  const double m = mean(quantity, column), variance = covariance[at](quantity, quantity), square = m * m + variance;
  std::vector<double> out;
  double rest = variance;
  for (const Contribution& c : groups) {
    const double own = c.sigma(quantity, column) * c.sigma(quantity, column);
    rest -= own;
    out.push_back(square > 0 ? (own + m * c.fixed(quantity, column)) / square : 0);
  }
  out.push_back(square > 0 ? rest / square : 0);
  return out;
}

std::vector<double> ErrorBudget::horizontal_shares(std::size_t at) const {
  if (at >= time.size()) throw Error(fmt::format("output {}; expected one of {}", at, time.size()));
  std::vector<double> out(groups.size() + 1, 0);
  double all = 0;
  for (const int q : {0, 1}) {
    const double square = std::pow(mean(q, static_cast<Eigen::Index>(at)), 2) + covariance[at](q, q);
    if (!(square > 0)) continue;
    const std::vector<double> own = shares(q, at);
    for (std::size_t k = 0; k < out.size(); ++k) out[k] += square * own[k];
    all += square;
  }
  for (double& share : out) share = all > 0 ? share / all : 0;
  return out;
}

/// The sensitivities and covariances at the outputs.
struct GrowingBudget::Rows {
  ErrorGrowth growth;
  ErrorSources sources;
  VerticalChannel vertical;
  std::vector<double> time = {};
  std::vector<BudgetRows> sensitivities = {};
  std::vector<std::vector<BudgetMatrix>> noises = {};  // for each source
  void add();
};

void GrowingBudget::Rows::add() {
  time.push_back(growth.time());
  sensitivities.push_back(rows_of(growth.sensitivities()));
  for (std::size_t i = 0; i < growth.noises(); ++i) noises[i].push_back(block_of(growth.noise_covariance(i)));
}

GrowingBudget::GrowingBudget(double begin, double interval, const NavigationState& start, const ErrorSources& sources, const BudgetOptions& options)
    : rows_(new Rows{{begin, interval, start, sources, options}, sources, options.strapdown.vertical}) {
  rows_->noises.resize(rows_->growth.noises());
}

GrowingBudget::~GrowingBudget() = default;

void GrowingBudget::add(double time, const NavigationState& state, const Increment& sample) {
  if (rows_->growth.add(time, state, sample)) rows_->add();
}

ErrorBudget GrowingBudget::finish() {
  if (rows_->growth.finish()) rows_->add();
  const Parameters p = parameters_of(rows_->sources, rows_->growth.columns());
  ErrorBudget out;
  out.vertical = rows_->vertical;
  out.time = rows_->time;
  for (const BudgetRows& s : rows_->sensitivities) out.covariance.emplace_back(s * p.covariance * s.transpose());
  add_coefficients(out, rows_->sensitivities, p, rows_->sources);
  add_groups(out, rows_->sensitivities, p);
  for (std::size_t i = 0; i < rows_->noises.size(); ++i) add_noise(out, rows_->growth.noise_name(i), rows_->noises[i]);
  group(out, algorithm);
  out.mean = BudgetRows::Zero(budget_quantities, outputs(out));
  for (const Contribution& c : out.groups) out.mean += c.fixed;
  return out;
}

ErrorBudget error_budget(const NominalMotion& motion, const ErrorSources& sources, const BudgetOptions& options) {
  check(motion);
  GrowingBudget budget(motion.time[0], motion.time[1] - motion.time[0], motion.states[0], sources, options);
  for (std::size_t i = 0; i < motion.increments.size(); ++i) budget.add(motion.time[i + 1], motion.states[i + 1], motion.increments[i]);
  ErrorBudget out = budget.finish();
  if (!options.algorithm) return out;
  Contribution& own = group(out, algorithm);
  own.fixed = algorithm_error(motion, options.strapdown, output_samples(motion, options.output_interval));
  out.mean += own.fixed;
  return out;
}

ErrorSources error_sources(const Calibration& calibration) {
  standard_uncertainty(calibration, coefficient_indices().front());  // checks the size of the covariance
  ErrorSources out;
  out.model = calibration.model;
  std::vector<Eigen::Index> places;
  for (std::size_t k = 0; k < calibration.estimated.size(); ++k) {
    if (coefficient(calibration.estimated[k]).term == Term::lever_arm) continue;
    out.coefficients.push_back(calibration.estimated[k]);
    places.push_back(static_cast<Eigen::Index>(k));
  }
  out.fixed.setZero(static_cast<Eigen::Index>(places.size()));
  out.covariance = calibration.covariance(places, places);
  return out;
}

}  // namespace imulab
