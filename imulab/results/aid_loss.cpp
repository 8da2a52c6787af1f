#include "imulab/results/aid_loss.hpp"

#include "imulab/formats/text/figures.hpp"
#include "imulab/results/budget.hpp"
#include "imulab/units.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <functional>

namespace imulab {
namespace {

double linear_between(const std::vector<double>& time, double at, const std::function<double(std::size_t)>& value) {
  const auto after = static_cast<std::size_t>(std::ranges::lower_bound(time, at) - time.begin());
  if (after == 0 || after == time.size()) return value(after == 0 ? 0 : after - 1);
  const double part = (at - time[after - 1]) / (time[after] - time[after - 1]);
  return (1 - part) * value(after - 1) + part * value(after);
}

/// Root mean square of some quantities.
double rms_at(const ErrorBudget& b, double at, std::initializer_list<Eigen::Index> quantities) {
  return linear_between(b.time, at, [&](std::size_t i) {
    double square = 0;
    for (const Eigen::Index q : quantities) square += std::pow(b.mean(q, static_cast<Eigen::Index>(i)), 2) + b.covariance[i](q, q);
    return std::sqrt(square);
  });
}

}  // namespace

std::vector<ErrorsAfterLoss> errors_after_loss(const ErrorBudget& b) {
  std::vector<ErrorsAfterLoss> out;
  if (!b.loss) return out;
  const double length = b.time.back() - b.loss->begin;
  std::vector<double> seconds;
  for (const double s : {0., 10., 60., 600.})
    if (s < length * (1 - 1e-6)) seconds.push_back(s);
  seconds.push_back(length);
  for (const double s : seconds) {
    const double at = b.loss->begin + s;
    ErrorsAfterLoss& e = out.emplace_back();
    e.seconds = s, e.horizontal = rms_at(b, at, {0, 1}), e.vertical = rms_at(b, at, {2}), e.velocity = rms_at(b, at, {3, 4});
    e.heading = rms_at(b, at, {8});
    for (const Contribution& c : b.groups)
      e.sources.emplace_back(c.name, linear_between(b.time, at, [&](std::size_t i) { return horizontal_rms(c, static_cast<Eigen::Index>(i)); }));
  }
  return out;
}

JsonValue after_loss_json(const ErrorBudget& b) {
  std::vector<JsonValue> out;
  for (const ErrorsAfterLoss& e : errors_after_loss(b)) {
    JsonFields sources;
    for (const auto& [name, size] : e.sources) sources.fields.emplace_back(name, size);
    out.emplace_back(JsonFields{{{"seconds", e.seconds},
                                 {"horizontal_m", e.horizontal},
                                 {"vertical_m", e.vertical},
                                 {"velocity_mps", e.velocity},
                                 {"heading_deg", e.heading / unit::deg},
                                 {"sources_m", std::move(sources)}}});
  }
  return out;
}

std::string lost_aids(const AidLoss& loss) {
  std::string text;
  for (const std::string& name : loss.aids) text += (text.empty() ? "" : ", ") + name;
  return text;
}

std::string after_loss_table(const ErrorBudget& b) {
  constexpr int name = 26, column = 9;
  const std::vector<ErrorsAfterLoss> all = errors_after_loss(b);
  const auto row = [&](const std::string& title, const auto& value) {
    std::string text = fmt::format("{:<{}}", title, name);
    for (const ErrorsAfterLoss& e : all) text += fmt::format(" {:>{}}", text::number(value(e)), column - 1);
    return text;
  };
  std::string out = "\n" + row("seconds after the loss", [](const auto& e) { return e.seconds; }) + "\n";
  out += row("horizontal, m", [](const auto& e) { return e.horizontal; }) + "\n";
  out += row("vertical, m", [](const auto& e) { return e.vertical; }) + "\n";
  out += row("horizontal velocity, m/s", [](const auto& e) { return e.velocity; }) + "\n";
  out += row("heading, deg", [](const auto& e) { return e.heading / unit::deg; }) + "\n";
  std::vector<std::size_t> order;
  const auto& end = all.back().sources;
  for (std::size_t k = 0; k < end.size(); ++k)
    if (std::ranges::any_of(all, [&](const ErrorsAfterLoss& e) { return e.sources[k].second > 0.02 * e.horizontal; })) order.push_back(k);
  std::ranges::stable_sort(order, [&](std::size_t x, std::size_t y) { return end[x].second > end[y].second; });
  const std::vector<double> shares = b.horizontal_shares(b.time.size() - 1);
  out += fmt::format("\n{:<{}}{:>{}}\n", "horizontal by source, m", name, "share", column * static_cast<int>(all.size() + 1));
  for (const std::size_t k : order)
    out += row(end[k].first, [&](const auto& e) { return e.sources[k].second; }) + fmt::format(" {:>6.1f} %\n", 100 * shares[k]);
  return out;
}

}  // namespace imulab
