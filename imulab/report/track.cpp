#include "imulab/report/track.hpp"

#include "imulab/report/html.hpp"
#include "imulab/report/plot.hpp"
#include "imulab/report/start.hpp"
#include "imulab/units.hpp"

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

/// What is drawn of one quantity, in its unit.
struct DrawnQuantity {
  std::string name, unit;
  std::vector<double> low, mean, high;  // of the budget
  std::vector<double> sampled_low, sampled_high, errors;
};

DrawnQuantity drawn_quantity(const ErrorBands& b, int q) {
  const ErrorQuantity& quantity = error_quantities()[static_cast<std::size_t>(q)];
  DrawnQuantity out{.name = std::string(quantity.name), .unit = std::string(quantity.unit)};
  if (b.budget != nullptr)
    for (std::size_t i = 0; i < b.budget->time.size(); ++i) {
      const double sigma = std::sqrt(std::max(0.0, b.budget->covariance[i](q, q))) / quantity.size;
      out.mean.push_back(b.budget->mean(q, static_cast<Eigen::Index>(i)) / quantity.size);
      out.low.push_back(out.mean.back() - sigma), out.high.push_back(out.mean.back() + sigma);
    }
  if (b.errors.cols() > 0) out.errors = row_of(b.errors, q, quantity.size);
  if (b.monte_carlo != nullptr)
    out.sampled_low = row_of(b.monte_carlo->low, q, quantity.size), out.sampled_high = row_of(b.monte_carlo->high, q, quantity.size);
  return out;
}

/// All values that decide how large the picture is.
std::vector<double> shown_values(const ErrorBands& b, const DrawnQuantity& d) {
  std::vector<double> all{0};
  for (const std::vector<double>* part : std::initializer_list<const std::vector<double>*>{&d.errors, &d.sampled_low, &d.sampled_high})
    all.insert(all.end(), part->begin(), part->end());
  if (!b.rough || b.monte_carlo == nullptr)
    for (const std::vector<double>* part : {&d.low, &d.high}) all.insert(all.end(), part->begin(), part->end());
  return all;
}

double largest_size(const std::vector<double>& values) {
  double most = 0;
  for (const double v : values)
    if (std::isfinite(v)) most = std::max(most, std::abs(v));
  return most;
}

/// Thousands in a larger unit, where there is one.
void in_larger_unit(DrawnQuantity& d, std::vector<double>& shown) {
  const double most = largest_size(shown);
  const double size = d.unit == "m" ? length_unit(most).size : d.unit == "arcsec" && most >= unit::deg / unit::arcsec ? unit::deg / unit::arcsec : 1;
  if (size == 1) return;
  d.unit = d.unit == "m" ? "km" : "deg";
  for (std::vector<double>* part : {&d.low, &d.mean, &d.high, &d.sampled_low, &d.sampled_high, &d.errors, &shown})
    for (double& v : *part) v /= size;
}

/// A curve ends where it leaves the picture.
std::vector<double> within(std::vector<double> y, const Axis& axis) {
  for (double& v : y)
    if (v < axis.low || v > axis.high) v = NAN;
  return y;
}

/// Minutes from the start: of all that is drawn.
Axis time_axis(const ErrorBands& b) {
  const std::vector<double> time = minutes_of(b.budget != nullptr ? b.budget->time : b.error_time, b.start);
  const double first = std::min(0.0, time.front());
  return {"min", first, time.back() > first ? time.back() : first + 1};
}

std::string band_figure(const ErrorBands& b, const DrawnQuantity& d, const Axis& y) {
  Plot plot(time_axis(b), y, d.name, small_plot);
  if (b.budget != nullptr) plot.band(minutes_of(b.budget->time, b.start), d.low, d.high, color::sky);
  if (b.monte_carlo != nullptr)
    for (const auto* edge : {&d.sampled_low, &d.sampled_high}) plot.line(minutes_of(b.monte_carlo->time, b.start), *edge, color::green, 1);
  plot.rule(0, color::gray);
  if (d.errors.empty() && b.budget != nullptr) plot.line(minutes_of(b.budget->time, b.start), within(d.mean, y), color::blue);
  plot.line(minutes_of(b.error_time, b.start), d.errors, color::vermilion);
  return fmt::format("<figure>{}<figcaption>{}</figcaption></figure>\n", plot.svg(), d.name);
}

/// Quantities that compare, east and north, on one axis.
std::string band_figures(const ErrorBands& b, const std::vector<int>& quantities) {
  std::vector<DrawnQuantity> all;
  std::vector<double> shown;
  for (const int q : quantities) {
    all.push_back(drawn_quantity(b, q));
    const std::vector<double> values = shown_values(b, all.back());
    shown.insert(shown.end(), values.begin(), values.end());
  }
  const std::vector<double> in_si_sizes = shown;
  std::string out;
  for (DrawnQuantity& d : all) {
    shown = in_si_sizes;
    in_larger_unit(d, shown);
    out += band_figure(b, d, axis_over(d.unit, shown));
  }
  return out;
}

/// Root of the mean square horizontal error.
std::vector<double> horizontal_rms(const ErrorBudget& b) {
  std::vector<double> out;
  for (std::size_t i = 0; i < b.time.size(); ++i)
    out.push_back(std::sqrt(b.mean.col(static_cast<Eigen::Index>(i)).head<2>().squaredNorm() + std::max(0.0, b.covariance[i](0, 0)) +
                            std::max(0.0, b.covariance[i](1, 1))));
  return out;
}

bool anything(const ErrorBands& b) { return (b.budget != nullptr && b.budget->time.size() > 1) || b.error_time.size() > 1; }

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

LengthUnit length_unit(double largest) { return largest >= 1e4 ? LengthUnit{"km", 1000} : LengthUnit{"m", 1}; }

std::string length_text(double length) {
  const LengthUnit u = length_unit(std::abs(length));
  return fmt::format("{} {}", number_text(length / u.size), u.name);
}

std::string horizontal_picture(const ErrorBands& b) {
  if (!anything(b)) return {};
  DrawnQuantity d{.name = "horizontal error", .unit = "m"};
  if (b.budget != nullptr) d.mean = horizontal_rms(*b.budget);
  std::vector<double> median;
  if (b.monte_carlo != nullptr) {
    d.sampled_low = row_of(b.monte_carlo->low, budget_quantities, 1), d.sampled_high = row_of(b.monte_carlo->high, budget_quantities, 1);
    median = row_of(b.monte_carlo->median, budget_quantities, 1);
  }
  for (Eigen::Index i = 0; i < b.errors.cols(); ++i) d.errors.push_back(b.errors.col(i).head<2>().norm());
  std::vector<double> shown = shown_values(b, d);
  if (!b.rough || b.monte_carlo == nullptr) shown.insert(shown.end(), d.mean.begin(), d.mean.end());
  const double size = length_unit(largest_size(shown)).size;
  in_larger_unit(d, shown);
  for (double& v : median) v /= size;
  Axis x = time_axis(b), y = axis_over(fmt::format("horizontal error [{}]", d.unit), shown);
  x.label = time_label(b.start, "min"), y.low = 0;
  Plot plot(x, y, "horizontal position error over time", {960, 330, 180});
  const auto curve = [&](const std::vector<double>& time, const std::vector<double>& values, const std::string& name, std::string_view ink) {
    if (values.empty()) return;
    const std::vector<double> drawn = within(values, y);
    plot.line(minutes_of(time, b.start), drawn, ink, 2);
    plot.name_at_end(std::min(values.back(), y.high), name, ink);
  };
  if (b.monte_carlo != nullptr) {
    plot.band(minutes_of(b.monte_carlo->time, b.start), d.sampled_low, d.sampled_high, color::green);
    plot.name_at_end(d.sampled_high.back(), "95 % of the runs", color::green);
    curve(b.monte_carlo->time, median, "half of the runs", color::green);
  }
  if (b.budget != nullptr)
    curve(b.budget->time, d.mean, b.rough ? "linear, rough" : b.errors.cols() > 0 ? "expected, RMS" : "linear, RMS", color::blue);
  curve(b.error_time, d.errors, "error", color::vermilion);
  return plot.svg();
}

std::string error_bands(const ErrorBands& bands) {
  if (!anything(bands)) return {};
  std::string out;
  for (const int first : {0, 3, 6}) out += band_figures(bands, {first, first + 1}) + band_figures(bands, {first + 2});
  std::vector<std::pair<std::string, std::string_view>> names;
  if (bands.budget != nullptr) names.emplace_back(bands.rough ? "one sigma, linear, rough" : "one sigma", color::sky);
  if (bands.budget != nullptr && bands.error_time.empty()) names.emplace_back("mean", color::blue);
  if (bands.monte_carlo != nullptr) names.emplace_back("Monte Carlo, 5 % and 95 %", color::green);
  if (!bands.error_time.empty()) names.emplace_back("error", color::vermilion);
  return key(names) + "<div class=\"small three\">" + out + "</div>\n" +
         paragraph("East and north have one scale. Horizontal axes: " + time_label(bands.start, "min") + ".");
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
