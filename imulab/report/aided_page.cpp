#include "imulab/report/aided_page.hpp"

#include "imulab/report/html.hpp"
#include "imulab/report/page.hpp"
#include "imulab/report/plot.hpp"
#include "imulab/report/track.hpp"
#include "imulab/results/aided.hpp"
#include "imulab/units.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

namespace imulab {
namespace report {
namespace {

/// Sigmas at about a thousand epochs.
std::string sigmas_section(const AidedNavigation& n) {
  if (n.covariance.size() < 2) return "";
  const std::size_t step = std::max<std::size_t>(1, n.covariance.size() / 1000);
  TimeChart place{
      .title = "Position, one sigma", .y_label = "m", .start = n.solution.time.front(), .x = {}, .names = {"east", "north", "up"}, .y = {}};
  place.y.resize(3), place.logarithmic = true, place.group = "aided";
  for (const OutageResult& o : n.outages) place.marks.push_back({o.begin, o.end, Mark::withheld});
  TimeChart attitude = place;
  attitude.title = "Attitude about east, north, up, one sigma", attitude.y_label = "deg";
  for (std::size_t i = 0; i < n.covariance.size(); i += step) {
    const AidedCovariance& c = n.covariance[i];
    place.x.push_back(c.time), attitude.x.push_back(c.time);
    for (Eigen::Index k = 0; k < 3; ++k) {
      place.y[static_cast<std::size_t>(k)].push_back(std::sqrt(std::max(0., c.value(6 + k, 6 + k))));
      attitude.y[static_cast<std::size_t>(k)].push_back(std::sqrt(std::max(0., c.value(k, k))) / unit::deg);
    }
  }
  return section("sigmas", "Uncertainty over time", "", time_chart(place) + time_chart(attitude));
}

/// East, north of the start over one grid, the withheld parts apart.
std::string track_section(const AidedNavigation& n) {
  if (n.track.size() < 2) return "";
  return section("track", "Track", "",
                 beside({track_figure(thinned_track(n.track, 3000), "The solution on a plain grid, east and north of the start.")}));
}

std::string innovations_section(const AidedNavigation& n) {
  if (n.innovations.empty()) return "";
  std::vector<double> time, size;
  const std::size_t step = std::max<std::size_t>(1, n.innovations.size() / 4000);
  for (std::size_t i = 0; i < n.innovations.size(); i += step) {
    time.push_back(n.innovations[i].time - n.solution.time.front());
    size.push_back(std::clamp(n.innovations[i].sigmas, -6., 6.));
  }
  Plot plot(axis_over("s", time), {"innovation over sigma", -6.5, 6.5}, "innovations over their sigmas", wide_plot);
  plot.dots(time, size, color::blue);
  for (const double sigma : {-2., 2.}) plot.rule(sigma, color::gray);
  return section("innovations", "Innovations", "",
                 figure(plot.svg(),
                        fmt::format("Measured less predicted, over the stated sigma: {:.2f} in the root mean square; {:.1f} % are suspects, which "
                                    "the estimate weighs less.",
                                    n.innovation_rms, 100 * n.suspects),
                        true));
}

std::string outages_section(const AidedNavigation& n) {
  if (n.outages.empty()) return "";
  Table t{
      .head = {"withheld, s", "predicted: largest error [m]", "its sigma", "RMS / sigma", "smoothed: largest error [m]", "its sigma", "RMS / sigma"},
      .rows = {}};
  const double zero = n.solution.time.front();
  const auto cells = [](const OutageErrors& e) { return std::vector{number_text(e.horizontal), number_text(e.sigma, 2), number_text(e.ratio, 2)}; };
  for (const OutageResult& o : n.outages) {
    std::vector<std::string> row{fmt::format("{:.2f} to {:.2f}", o.begin - zero, o.end - zero)};
    for (const OutageErrors& e : {o.predicted, o.smoothed})
      for (std::string& cell : cells(e)) row.push_back(std::move(cell));
    t.rows.push_back(std::move(row));
  }
  const OutageSummary p = outage_summary(n.outages, &OutageResult::predicted), s = outage_summary(n.outages, &OutageResult::smoothed);
  t.rows.push_back({"median; RMS", number_text(p.median), "", number_text(p.ratio, 2), number_text(s.median), "", number_text(s.ratio, 2)});
  return section(
      "outages", "Withheld times",
      fmt::format(
          "The aids were withheld there. The prediction uses the data before each time alone, the smoothed track also those after it. RMS: of "
          "all errors there over their sigmas. Times count from the start, {:.2f} s of the recording.",
          zero),
      table(t));
}

std::string with_sigma(double value, double sigma) { return fmt::format("{} (u = {})", rounded_to(value, sigma), uncertainty_text(sigma)); }

std::string aids_section(const AidedNavigation& n) {
  Table t{.head = {"aid", "lever arm right, forward, up [m]", "delay [s]", "drift [ppm]", "mounting pitch, yaw [deg]", "sigma / stated"},
          .rows = {},
          .text_columns = true};
  const auto joined = [](const std::vector<double>& value, const std::vector<double>& sigma, double size) {
    std::string text;
    for (std::size_t k = 0; k < value.size(); ++k) text += (k > 0 ? ", " : "") + with_sigma(value[k] / size, sigma[k] / size);
    return text;
  };
  for (const AidedAid& a : aided_aids(n))
    t.rows.push_back({escaped(a.name), joined(a.lever_arm, a.lever_arm_sigma, 1), a.delay ? with_sigma(*a.delay, *a.delay_sigma) : "",
                      a.drift ? number_text(*a.drift * 1e6) : "", joined(a.mounting, a.mounting_sigma, unit::deg), number_text(a.sigma_factor)});
  Table noise{.head = {"source of noise", "sigma / stated", "errors that last: times that", "values that the data resolve"}, .rows = {}};
  for (const AidedFactor& f : n.factors)
    noise.rows.push_back({escaped(f.name), number_text(std::sqrt(f.factor)), number_text(f.lasting, 2), number_text(f.resolved)});
  return section("aids", "Aids", "", table(t) + folded("All sources of noise", table(noise)));
}

std::string constants_section(const AidedNavigation& n) {
  Table t{.head = {"constant", "value", "u", "u before the data", "unit", "would show it"}, .rows = {}, .text_columns = true};
  for (const AidedConstant& c : n.constants) {
    const ConstantQuantity& quantity = quantity_of_constant(c.name);
    const UserUnit& unit = quantity.unit;
    t.rows.push_back({escaped(c.name), rounded_to(c.value / unit.size, c.sigma / unit.size), uncertainty_text(c.sigma / unit.size),
                      uncertainty_text(c.prior / unit.size), escaped(readable_unit(unit.name)),
                      c.undetermined() ? std::string(quantity.manoeuvre) : ""});
  }
  return section("constants", "Sensors and aids",
                 "Errors of the calibrated output, lever arms, delays and mounting. The last column is of constants that this motion did not show.",
                 table(t));
}

}  // namespace
}  // namespace report

std::string aided_page(const std::string& session, const AidedNavigation& n, const Conclusion& conclusion, const std::vector<std::string>& warnings) {
  using namespace report;
  Page page;
  page.kind = "Navigation", page.title = name_of_file(session);
  page.subtitle = n.causal ? "Aided solution, filtered" : "Aided solution, smoothed";
  take_conclusion(page.verdict, conclusion);
  page.verdict.because = n.findings.reasons();
  std::vector<std::string> others = warnings;  // than the reasons of the verdict, which are above
  const std::vector<std::string> shown = n.findings.of(Severity::doubt);
  std::erase_if(others, [&](const std::string& text) { return std::ranges::find(shown, text) != shown.end(); });
  if (!others.empty()) page.body += section("warnings", "Warnings", "", list(others));
  page.body += track_section(n) + sigmas_section(n) + outages_section(n) + innovations_section(n);
  page.body += aids_section(n) + constants_section(n);
  return page_text(page);
}

}  // namespace imulab
