#include "imulab/report/track.hpp"

#include "imulab/core/units.hpp"
#include "imulab/report/html.hpp"
#include "imulab/report/plot.hpp"
#include "imulab/report/start.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <initializer_list>
#include <numbers>
#include <numeric>

namespace imulab::report {

namespace {

constexpr double mean_radius_km = 6371;  // close enough for a picture

/// Both axes with one length a kilometer.
void equalize(Axis& x, Axis& y, const PlotSize& size) {
  const double wanted = (x.high - x.low) * size.height / size.width, has = y.high - y.low;
  Axis& narrow = wanted > has ? y : x;
  const double more = wanted > has ? wanted - has : has * size.width / size.height - (x.high - x.low);
  narrow.low -= 0.5 * more, narrow.high += 0.5 * more;
}

/// From the start [s] on.
std::vector<double> minutes_of(const std::vector<double>& seconds, double start) {
  std::vector<double> out = seconds;
  for (double& t : out) t = (t - start) / 60;
  return out;
}

std::vector<double> row_of(const auto& rows, Eigen::Index row, double unit) {
  std::vector<double> out;
  for (Eigen::Index i = 0; i < rows.cols(); ++i) out.push_back(rows(row, i) / unit);
  return out;
}

std::string band_figure(const ErrorBands& b, int q) {
  const ErrorQuantity& quantity = error_quantities()[static_cast<std::size_t>(q)];
  std::vector<double> all{0}, time, low, high, mean;
  if (b.budget != nullptr) {
    time = minutes_of(b.budget->time, b.start);
    for (std::size_t i = 0; i < time.size(); ++i) {
      const double sigma = std::sqrt(std::max(0.0, b.budget->covariance[i](q, q))) / quantity.size;
      mean.push_back(b.budget->mean(q, static_cast<Eigen::Index>(i)) / quantity.size);
      low.push_back(mean.back() - sigma), high.push_back(mean.back() + sigma);
    }
  }
  const std::vector<double> errors = b.errors.cols() > 0 ? row_of(b.errors, q, quantity.size) : std::vector<double>{};
  std::vector<double> sampled_time, sampled_low, sampled_high;
  if (b.monte_carlo != nullptr) {
    sampled_time = minutes_of(b.monte_carlo->time, b.start);
    sampled_low = row_of(b.monte_carlo->low, q, quantity.size), sampled_high = row_of(b.monte_carlo->high, q, quantity.size);
  }
  for (const std::vector<double>* part : std::initializer_list<const std::vector<double>*>{&low, &high, &errors, &sampled_low, &sampled_high})
    all.insert(all.end(), part->begin(), part->end());
  const std::vector<double> error_time = minutes_of(b.error_time, b.start);
  const double first = !time.empty() ? time.front() : error_time.front(), last = !time.empty() ? time.back() : error_time.back();
  Plot plot({"", first, last > first ? last : first + 1}, axis_over("", all), std::string(quantity.name), small_plot);
  plot.band(time, low, high, color::sky);
  plot.line(sampled_time, sampled_low, color::gray, 1);
  plot.line(sampled_time, sampled_high, color::gray, 1);
  plot.rule(0, color::gray);
  if (errors.empty()) plot.line(time, mean, color::blue);
  plot.line(error_time, errors, color::vermilion);
  return fmt::format("<figure>{}<figcaption>{} [{}]</figcaption></figure>\n", plot.svg(), quantity.name, quantity.unit);
}

}  // namespace

std::vector<NavigationState> thinned_track(const std::vector<NavigationState>& states, std::size_t points) {
  const std::size_t step = std::max<std::size_t>(1, states.size() / points);
  std::vector<NavigationState> out;
  for (std::size_t i = 0; i < states.size(); i += step) out.push_back(states[i]);
  if (!states.empty() && (states.size() - 1) % step != 0) out.push_back(states.back());
  return out;
}

std::string track_figure(const std::vector<NavigationState>& track, std::string_view caption) {
  if (track.size() < 2) return {};
  std::vector<double> east, north;
  for (const NavigationState& s : track) {
    const double longitude = std::remainder(s.longitude - track.front().longitude, 2 * std::numbers::pi);
    east.push_back(mean_radius_km * std::cos(track.front().latitude) * longitude);
    north.push_back(mean_radius_km * (s.latitude - track.front().latitude));
  }
  constexpr PlotSize size{460, 360};
  Axis x = axis_over("east [km]", east), y = axis_over("north [km]", north);
  equalize(x, y, size);
  Plot plot(x, y, "track", size);
  plot.line(east, north, color::blue);
  plot.dots({east.front()}, {north.front()}, color::green);
  plot.dots({east.back()}, {north.back()}, color::vermilion);
  return figure(plot.svg() + key({{"start", color::green}, {"end", color::vermilion}}), caption);
}

const std::array<ErrorQuantity, budget_quantities>& error_quantities() {
  static constexpr std::array<ErrorQuantity, budget_quantities> all{{{"position east", "m", 1},
                                                                     {"position north", "m", 1},
                                                                     {"position up", "m", 1},
                                                                     {"velocity east", "m/s", 1},
                                                                     {"velocity north", "m/s", 1},
                                                                     {"velocity up", "m/s", 1},
                                                                     {"attitude about east", "arcsec", unit::arcsec},
                                                                     {"attitude about north", "arcsec", unit::arcsec},
                                                                     {"attitude about up", "arcsec", unit::arcsec}}};
  return all;
}

std::string error_bands(const ErrorBands& bands) {
  if ((bands.budget == nullptr || bands.budget->time.size() < 2) && bands.error_time.size() < 2) return {};
  std::string out;
  for (int q = 0; q < budget_quantities; ++q) out += band_figure(bands, q);
  std::vector<std::pair<std::string, std::string_view>> names;
  if (bands.budget != nullptr) names.emplace_back("one sigma", color::sky);
  if (bands.budget != nullptr && bands.error_time.empty()) names.emplace_back("mean", color::blue);
  if (bands.monte_carlo != nullptr) names.emplace_back("Monte Carlo, 5 % and 95 %", color::gray);
  if (!bands.error_time.empty()) names.emplace_back("error", color::vermilion);
  return "<div class=\"small three\">" + out + "</div>\n" + key(names) + paragraph("Horizontal axes: " + time_label(bands.start, "min") + ".");
}

Eigen::MatrixXd horizontal_shares(const ErrorBudget& b) {
  Eigen::MatrixXd out(static_cast<Eigen::Index>(b.time.size()), static_cast<Eigen::Index>(b.groups.size()) + 1);
  for (std::size_t i = 0; i < b.time.size(); ++i) {
    const std::vector<double> shares = b.horizontal_shares(i);
    out.row(static_cast<Eigen::Index>(i)) = Eigen::Map<const Eigen::RowVectorXd>(shares.data(), out.cols());
  }
  return out;
}

std::string shares_over_time(const ErrorBudget& b, double start) {
  if (b.time.size() < 2 || b.groups.empty()) return {};
  const Eigen::MatrixXd shares = horizontal_shares(b);
  std::vector<Eigen::Index> order(static_cast<std::size_t>(shares.cols()));
  std::iota(order.begin(), order.end(), 0);
  std::sort(order.begin(), order.end(),
            [&](Eigen::Index i, Eigen::Index j) { return shares.col(i).cwiseAbs().maxCoeff() > shares.col(j).cwiseAbs().maxCoeff(); });
  constexpr std::size_t most = 6;
  TimeChart chart{.title = "Shares of the mean square horizontal position error",
                  .y_label = "%",
                  .start = start,
                  .x = b.time,
                  .names = {},
                  .y = {},
                  .group = "shares",
                  .minutes = true};
  for (std::size_t k = 0; k < std::min(most, order.size()); ++k) {
    const auto g = static_cast<std::size_t>(order[k]);
    chart.names.push_back(g < b.groups.size() ? b.groups[g].name : "correlation between groups");
    const Eigen::VectorXd column = 100 * shares.col(order[k]);
    chart.y.emplace_back(column.begin(), column.end());
  }
  return time_chart(chart);
}

}  // namespace imulab::report
