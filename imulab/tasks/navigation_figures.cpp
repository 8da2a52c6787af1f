#include "imulab/tasks/navigation_figures.hpp"

#include "imulab/error.hpp"
#include "imulab/navigate.hpp"
#include "imulab/navigation/navigation_error.hpp"
#include "imulab/units.hpp"

#include <Eigen/Eigenvalues>
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <numbers>
#include <utility>

namespace imulab {
namespace {

const std::vector<StatedUnit> stated_lengths{{"m", 1}, {"km", 1000}, {"nmi", unit::nmi}, {"ft", 0.3048}};
const std::vector<StatedUnit> stated_rates{{"nmi/h", unit::nmi_per_h}, {"km/h", 1000 / unit::hour}, {"m/h", 1 / unit::hour}};
const std::vector<StatedUnit> stated_speeds{{"m/s", 1}, {"km/h", 1000 / unit::hour}, {"kn", unit::nmi_per_h}};
const std::vector<StatedUnit> stated_angles{{"deg", unit::deg}, {"arcmin", unit::deg / 60}, {"arcsec", unit::arcsec}, {"mrad", 1e-3}};

constexpr const char* budget_example = "CEP <= 1 nmi/h";
constexpr const char* navigation_example = "horizontal <= 100 m at 300 s";

/// Linear in time, which counts from `begin`; the whole motion's end where no time is named.
template <class Value>
double value_at(const std::vector<double>& time, double begin, const StatedLimit& limit, const Value& value) {
  if (!limit.at_s) return value(time.size() - 1);
  const double wanted = begin + *limit.at_s, tolerance = 1e-6 * (time.back() - begin);
  if (wanted > time.back() + tolerance) throw Error(fmt::format("{}: there are errors until {:g} s", to_string(limit), time.back() - begin));
  const auto after = std::lower_bound(time.begin(), time.end(), std::min(wanted, time.back()));
  const auto i = static_cast<std::size_t>(after - time.begin());
  if (i == 0) return value(0);
  const double part = (std::min(wanted, time.back()) - time[i - 1]) / (time[i] - time[i - 1]);
  return (1 - part) * value(i - 1) + part * value(i);
}

void expect_no_time(const StatedLimit& limit) {
  if (limit.at_s) throw Error(to_string(limit) + ": a rate is of the whole motion; expected no time, or a distance");
}

std::vector<StatedLimit> limits_of(std::string_view text, const char* example) { return parse_limits(text, figure_form, example); }

// ---- error budgets

constexpr double half_of_errors = 0.5, most_of_errors = 0.95;
constexpr double z95 = 1.96;  // standard deviations on either side of 95 % of a normal distribution

/// Ends of an interval, in parts of the value.
struct Range95 {
  double low = 1, high = 1;
};

/// Horizontal errors at one output: their root mean square, or the radius that holds a part of them.
struct MissionErrors {
  const ErrorBudget& budget;
  const ErrorDistribution* sampled;

  const std::vector<double>& time() const { return sampled != nullptr ? sampled->time : budget.time; }
  double rms(const std::vector<Eigen::Index>& rows, std::size_t at) const {
    const auto i = static_cast<Eigen::Index>(at);
    double square = 0;
    for (const Eigen::Index q : rows)
      square += sampled != nullptr ? std::pow(sampled->mean(q, i), 2) + std::pow(sampled->sigma(q, i), 2)
                                   : std::pow(budget.mean(q, i), 2) + budget.covariance[at](q, q);
    return std::sqrt(square);
  }
  double radius(double part, std::size_t at) const {
    const auto i = static_cast<Eigen::Index>(at);
    if (sampled != nullptr) return part == half_of_errors ? sampled->median(budget_quantities, i) : sampled->high(budget_quantities, i);
    return radius_of(part, budget.mean.col(i).head<2>(), budget.covariance[at].topLeftCorner<2, 2>());
  }
  /// What of a root mean square of the runs the 95 % interval of all possible runs begins and ends at.
  Range95 sampled_rms(const std::vector<Eigen::Index>& rows) const {
    const auto n = static_cast<double>(sampled->end.cols());
    Eigen::ArrayXd square = Eigen::ArrayXd::Zero(sampled->end.cols());
    for (const Eigen::Index q : rows) square += sampled->end.row(q).transpose().array().square();
    const double mean = square.mean(), sigma = std::sqrt((square - mean).square().sum() / (n * std::max(1.0, n - 1)));
    const double relative = n > 1 && mean > 0 ? z95 * sigma / (2 * mean) : std::numeric_limits<double>::infinity();
    return {1 - std::min(1.0, relative), 1 + relative};
  }
  /// The same of a radius, by the order of the runs' errors.
  Range95 sampled_radius(double part) const {
    std::vector<double> errors;
    for (Eigen::Index i = 0; i < sampled->end.cols(); ++i) errors.push_back(sampled->end.col(i).head<2>().norm());
    std::sort(errors.begin(), errors.end());
    const auto n = static_cast<double>(errors.size());
    const double reach = z95 * std::sqrt(n * part * (1 - part));
    const auto low = static_cast<std::size_t>(std::max(0.0, std::floor(n * part - reach) - 1)),
               high = static_cast<std::size_t>(std::ceil(n * part + reach));
    const double quantile = errors[std::min(errors.size() - 1, static_cast<std::size_t>(n * part))];
    return {errors[low] / quantile, high < errors.size() ? errors[high] / quantile : std::numeric_limits<double>::infinity()};
  }
  /// A mission begins at 0 s, before the first output; with aids the figures count from their loss.
  double begin() const { return budget.loss ? budget.loss->begin : 0; }
  double duration() const { return time().back() - begin(); }
};

struct BudgetFigure {
  StatedFigure figure;
  bool rate;  ///< over the whole motion
  std::function<double(const MissionErrors&, std::size_t at)> value;
  std::function<Range95(const MissionErrors&)> sampling;  ///< at the end, of a Monte Carlo: at other times it is about the same
};

const std::vector<BudgetFigure>& budget_figures() {
  const auto rms = [](std::vector<Eigen::Index> rows) {
    return [rows = std::move(rows)](const MissionErrors& e, std::size_t at) { return e.rms(rows, at); };
  };
  const auto radius = [](double part) { return [part](const MissionErrors& e, std::size_t at) { return e.radius(part, at); }; };
  const auto of_rms = [](std::vector<Eigen::Index> rows) { return [rows = std::move(rows)](const MissionErrors& e) { return e.sampled_rms(rows); }; };
  const auto of_radius = [](double part) { return [part](const MissionErrors& e) { return e.sampled_radius(part); }; };
  const auto over_time = [](const std::function<double(const MissionErrors&, std::size_t)>& error) {
    return [error](const MissionErrors& e, std::size_t at) { return error(e, at) / e.duration(); };
  };
  const auto cep = radius(half_of_errors), most = radius(most_of_errors);
  const auto of_cep = of_radius(half_of_errors), of_most = of_radius(most_of_errors);
  static const std::vector<BudgetFigure> all{{{"CEP", stated_lengths}, false, cep, of_cep},
                                             {{"CEP", stated_rates}, true, over_time(cep), of_cep},
                                             {{"RMS", stated_lengths}, false, rms({0, 1}), of_rms({0, 1})},
                                             {{"RMS", stated_rates}, true, over_time(rms({0, 1})), of_rms({0, 1})},
                                             {{"95 %", stated_lengths}, false, most, of_most},
                                             {{"95 %", stated_rates}, true, over_time(most), of_most},
                                             {{"vertical", stated_lengths}, false, rms({2}), of_rms({2})},
                                             {{"velocity", stated_speeds}, false, rms({3, 4}), of_rms({3, 4})},
                                             {{"heading", stated_angles}, false, rms({8}), of_rms({8})}};
  return all;
}

template <class Figures>
std::vector<StatedFigure> stated_figures(const Figures& figures) {
  std::vector<StatedFigure> out;
  for (const auto& row : figures) out.push_back(row.figure);
  return out;
}

// ---- navigations

struct NavigationFigure {
  StatedFigure figure;
  bool rate;
  std::function<double(const NavigationError&)> value;            ///< of one session
  std::function<double(const std::vector<double>&)> of_all = {};  ///< of several; absent: the worst of them counts
};

const std::vector<NavigationFigure>& navigation_figures() {
  const auto horizontal = [](const NavigationError& e) { return e.horizontal(); };
  const auto rms = [](const std::vector<double>& values) { return rate_summary(values).rms; };
  const auto cep = [](const std::vector<double>& values) { return rate_summary(values).cep; };
  static const std::vector<NavigationFigure> all{
      {{"horizontal", stated_lengths}, false, horizontal},
      {{"horizontal", stated_rates}, true, horizontal},
      {{"vertical", stated_lengths}, false, [](const NavigationError& e) { return std::abs(e.position.z()); }},
      {{"velocity", stated_speeds}, false, [](const NavigationError& e) { return e.velocity.head<2>().norm(); }},
      {{"heading", stated_angles}, false, [](const NavigationError& e) { return std::abs(e.attitude.z()); }},
      {{"CEP", stated_lengths}, false, horizontal, cep},
      {{"CEP", stated_rates}, true, horizontal, cep},
      {{"RMS", stated_lengths}, false, horizontal, rms},
      {{"RMS", stated_rates}, true, horizontal, rms}};
  return all;
}

/// As many runs as there were leave an interval: its upper end has to be within the limit.
void judge_sampled(const Range95& range, const StatedLimit& limit, RequirementResult& result) {
  const double low = range.low * result.reached, high = range.high * result.reached, size = result.limit / limit.number;
  result.met = high <= result.limit;
  if (result.met || low > result.limit) return;
  result.note += std::isfinite(high)
                     ? fmt::format(": undecided, with 95 % in {:.3g} to {:.3g} {}; more runs decide", low / size, high / size, limit.unit)
                     : std::string(": undecided, too few for its 95 % interval; more runs decide");
}

/// How long a figure stays within a limit after the loss of the aids [s]; absent: all of the time.
std::optional<double> within_limit(const MissionErrors& errors, const BudgetFigure& figure, double limit) {
  double before = 0, value_before = 0;
  for (std::size_t i = 0; i < errors.time().size(); ++i) {
    const double seconds = errors.time()[i] - errors.begin();
    if (seconds < 0) continue;
    const double value = figure.value(errors, i);
    if (value > limit) return value_before < limit && seconds > 0 ? before + (seconds - before) * (limit - value_before) / (value - value_before) : 0;
    before = seconds, value_before = value;
  }
  return std::nullopt;
}

std::string within_text(const std::optional<double>& seconds, double all) {
  return seconds ? fmt::format("within the limit for {:.3g} s after the loss", *seconds) : fmt::format("within the limit for all of {:.4g} s", all);
}

double value_of(const NavigatedSession& session, const NavigationFigure& figure, const StatedLimit& limit) {
  if (figure.rate) return session.errors->rate;
  const std::vector<NavigationError>& history = session.errors->history;
  std::vector<double> time;  // the truth's, which may begin later than the solution
  for (const NavigationError& e : history) time.push_back(e.time);
  const double begin = session.navigated.solution.time.front();
  if (limit.at_s && begin + *limit.at_s < time.front()) throw Error(to_string(limit) + ": the truth begins later");
  return value_at(time, begin, limit, [&](std::size_t i) { return figure.value(history[i]); });
}

}  // namespace

double radius_of(double part, const Eigen::Vector2d& mean, const Eigen::Matrix2d& covariance) {
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix2d> eigen(covariance);
  const Eigen::Vector2d center = eigen.eigenvectors().transpose() * mean;
  const double size = mean.norm() + std::sqrt(covariance.trace());
  if (!(size > 0)) return 0;
  const Eigen::Vector2d sigma = eigen.eigenvalues().cwiseMax(1e-12 * size * size).cwiseSqrt();
  const auto below = [&](double x, Eigen::Index k) { return 0.5 * std::erfc((center[k] - x) / (sigma[k] * std::numbers::sqrt2)); };
  // Across the direction of the larger sigma, where its density is: strips, each with the chord in its middle.
  const auto inside = [&](double radius) {
    constexpr int strips = 800;
    constexpr double far = 9;  // sigmas
    const double first = std::max(-radius, center[1] - far * sigma[1]), last = std::min(radius, center[1] + far * sigma[1]);
    double sum = 0;
    for (int i = 0; i < strips && first < last; ++i) {
      const double width = (last - first) / strips, from = first + i * width, middle = from + 0.5 * width;
      const double chord = std::sqrt(std::max(0.0, radius * radius - middle * middle));
      sum += (below(from + width, 1) - below(from, 1)) * (below(chord, 0) - below(-chord, 0));
    }
    return sum;
  };
  double low = 0, high = size;
  while (inside(high) < part) high *= 2;
  for (int round = 0; round < 60; ++round) {
    const double middle = 0.5 * (low + high);
    if (inside(middle) < part)
      low = middle;
    else
      high = middle;
  }
  return high;
}

std::vector<RequirementResult> assess(const ErrorBudget& budget, const std::optional<ErrorDistribution>& monte_carlo, std::string_view limits) {
  const MissionErrors errors{budget, monte_carlo ? &*monte_carlo : nullptr};
  const std::string by = monte_carlo   ? fmt::format("of {} Monte Carlo runs", monte_carlo->runs)
                         : budget.loss ? ""
                                       : "by the linear propagation, without a Monte Carlo";
  std::vector<RequirementResult> out;
  for (const StatedLimit& limit : limits_of(limits, budget_example)) {
    const FoundFigure found = find_figure(limit, stated_figures(budget_figures()));
    const BudgetFigure& figure = budget_figures()[found.index];
    if (figure.rate) expect_no_time(limit);
    const double reached = value_at(errors.time(), errors.begin(), limit, [&](std::size_t i) { return figure.value(errors, i); });
    RequirementResult result{to_string(limit), figure.figure.name, found.limit, reached, reached <= found.limit, by};
    if (monte_carlo) judge_sampled(figure.sampling(errors), limit, result);
    if (budget.loss) result.note = within_text(within_limit(errors, figure, found.limit), errors.duration());
    out.push_back(std::move(result));
  }
  return out;
}

std::vector<RequirementResult> assess(const std::vector<NavigatedSession>& sessions, std::string_view limits) {
  for (const NavigatedSession& s : sessions)
    if (!s.errors) throw Error(s.session + ": has no truth; expected [truth] in the session, or a file of it: without one errors are not known");
  std::vector<RequirementResult> out;
  for (const StatedLimit& limit : limits_of(limits, navigation_example)) {
    const FoundFigure found = find_figure(limit, stated_figures(navigation_figures()));
    const NavigationFigure& figure = navigation_figures()[found.index];
    if (figure.rate) expect_no_time(limit);
    std::vector<double> values;
    for (const NavigatedSession& s : sessions) values.push_back(errors_at(s.session, [&] { return value_of(s, figure, limit); }));
    const auto worst = std::max_element(values.begin(), values.end());
    const bool several = sessions.size() > 1;
    const double reached = figure.of_all ? figure.of_all(values) : *worst;
    std::string note;
    if (several)
      note = figure.of_all ? fmt::format("of {} sessions", values.size())
                           : "the worst is " + sessions[static_cast<std::size_t>(worst - values.begin())].session;
    out.push_back({to_string(limit), figure.figure.name, found.limit, reached, reached <= found.limit, note});
  }
  return out;
}

std::vector<LossCurve> loss_curves(const ErrorBudget& budget, const std::vector<RequirementResult>& requirements) {
  std::vector<LossCurve> out;
  if (!budget.loss) return out;
  const MissionErrors errors{budget, nullptr};
  const auto add = [&](const BudgetFigure& figure, const std::string& name, std::optional<double> limit) {
    LossCurve& curve = out.emplace_back(LossCurve{name, {}, {}, limit, limit ? within_limit(errors, figure, *limit) : std::nullopt});
    for (std::size_t i = 0; i < budget.time.size(); ++i)
      if (budget.time[i] >= budget.loss->begin)
        curve.seconds.push_back(budget.time[i] - budget.loss->begin), curve.meters.push_back(figure.value(errors, i));
  };
  for (const RequirementResult& r : requirements)
    for (const StatedLimit& limit : limits_of(r.text, budget_example)) {
      const FoundFigure found = find_figure(limit, stated_figures(budget_figures()));
      const BudgetFigure& figure = budget_figures()[found.index];
      if (!figure.rate && figure.figure.units.front().name == "m") add(figure, r.text, found.limit);
    }
  if (out.empty()) add(*std::ranges::find(budget_figures(), "RMS", [](const BudgetFigure& f) { return f.figure.name; }), "RMS", std::nullopt);
  return out;
}

void expect_budget_limits(std::string_view text) {
  for (const StatedLimit& limit : limits_of(text, budget_example))
    if (budget_figures()[find_figure(limit, stated_figures(budget_figures())).index].rate) expect_no_time(limit);
}

void expect_navigation_limits(std::string_view text) {
  for (const StatedLimit& limit : limits_of(text, navigation_example))
    if (navigation_figures()[find_figure(limit, stated_figures(navigation_figures())).index].rate) expect_no_time(limit);
}

}  // namespace imulab
