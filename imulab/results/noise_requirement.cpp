#include "imulab/results/noise_requirement.hpp"

#include "imulab/core/error.hpp"
#include "imulab/core/stated_limit.hpp"
#include "imulab/core/units.hpp"
#include "imulab/formats/text/figures.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <utility>

namespace imulab {
namespace {

struct LimitedTerm {
  const char* name;
  NoiseCoefficient NoiseFit::*member;
  std::vector<StatedUnit> gyro, accel, counts;
};

const std::array<LimitedTerm, 5>& limited_terms() {
  using namespace unit;
  const double root_hour = std::sqrt(hour);
  static const std::array<LimitedTerm, 5> all{
      {{"N",
        &NoiseFit::N,
        {{"deg/sqrt(h)", deg_per_sqrt_h}, {"deg/s/sqrt(Hz)", deg}, {"deg/h/sqrt(Hz)", deg_per_h}, {"rad/s/sqrt(Hz)", 1}},
        {{"ug/sqrt(Hz)", ug_per_sqrt_hz}, {"mg/sqrt(Hz)", 1e3 * ug_per_sqrt_hz}, {"m/s/sqrt(h)", 1 / root_hour}, {"m/s^2/sqrt(Hz)", 1}},
        {{"count/sqrt(Hz)", 1}}},
       {"B", &NoiseFit::B, {{"deg/h", deg_per_h}, {"deg/s", deg}, {"rad/s", 1}}, {{"ug", ug}, {"mg", 1e3 * ug}, {"m/s^2", 1}}, {{"count", 1}}},
       {"K",
        &NoiseFit::K,
        {{"deg/h/sqrt(h)", deg_per_h / root_hour}, {"deg/s/sqrt(s)", deg}, {"rad/s/sqrt(s)", 1}},
        {{"ug/sqrt(h)", ug / root_hour}, {"m/s^2/sqrt(s)", 1}},
        {{"count/sqrt(s)", 1}}},
       {"Q", &NoiseFit::Q, {{"arcsec", arcsec}, {"rad", 1}}, {{"um/s", 1e-6}, {"m/s", 1}}, {{"count s", 1}}},
       {"R", &NoiseFit::R, {{"deg/h/h", deg_per_h / hour}, {"rad/s/s", 1}}, {{"ug/h", ug / hour}, {"m/s^2/s", 1}}, {{"count/s", 1}}}}};
  return all;
}

const std::vector<StatedUnit>& units_of(const LimitedTerm& term, bool gyro, bool counts) {
  return counts ? term.counts : gyro ? term.gyro : term.accel;
}

/// All that may be limited: of a triad, and of an axis of it.
struct NoiseFigures {
  std::vector<StatedFigure> stated;
  std::vector<std::pair<std::string, const LimitedTerm*>> of;  ///< the begin of the axes' names, and the term
};

NoiseFigures noise_figures(bool gyro_counts, bool accel_counts) {
  NoiseFigures out;
  for (const char* axis : {".", ".x", ".y", ".z"})
    for (const LimitedTerm& term : limited_terms())
      for (const bool gyro : {true, false}) {
        const std::string axes = std::string(gyro ? "gyro" : "accel") + axis;
        out.stated.push_back(
            {axes.ends_with('.') ? axes + term.name : axes + "." + term.name, units_of(term, gyro, gyro ? gyro_counts : accel_counts)});
        out.of.emplace_back(axes, &term);
      }
  return out;
}

NoiseFigures figures_of(const std::vector<NoiseAnalysis>& logs) {
  bool gyro_counts = false, accel_counts = false;
  for (const NoiseAnalysis& log : logs)
    for (const NoiseAxis& axis : log.axes)
      if (axis.unit == "count") (axis.name.starts_with("gyro") ? gyro_counts : accel_counts) = true;
  return noise_figures(gyro_counts, accel_counts);
}

std::vector<StatedLimit> noise_limits(std::string_view text) { return parse_limits(text, "TERM <= NUMBER UNIT", "gyro.N <= 0.1 deg/sqrt(h)"); }

void expect_no_noise_time(const StatedLimit& limit) {
  if (limit.at_s) throw Error(to_string(limit) + ": a coefficient has no time; expected the number and its unit alone");
}

/// The largest size that the log admits.
double largest_size(const NoiseCoefficient& c) { return std::max(std::abs(c.lower), std::abs(c.upper)); }

/// How the term of an axis was judged; empty: its whole interval is on one side.
std::string how_judged(const NoiseCoefficient& c, double limit, double size, const std::string& unit) {
  if (!c.determined) return "not determined: its 95 % bound counts";
  const double value = std::abs(c.value);
  if (largest_size(c) <= limit) return "the upper end of the 95 % interval";
  if (std::abs(c.lower) > limit && value > limit) return "the upper end of the 95 % interval";
  return fmt::format("undecided: {} {} with 95 % in {} to {}; a longer log decides", text::number(value / size), unit, text::number(c.lower / size),
                     text::number(c.upper / size));
}

RequirementResult assessed(const std::vector<NoiseAnalysis>& logs, const StatedLimit& limit, const NoiseFigures& figures) {
  expect_no_noise_time(limit);
  const FoundFigure found = find_figure(limit, figures.stated);
  const auto& [axes, term] = figures.of[found.index];
  RequirementResult out{to_string(limit), figures.stated[found.index].name, found.limit, -1, false};
  for (const NoiseAnalysis& log : logs)
    for (const NoiseAxis& axis : log.axes) {
      if (!axis.name.starts_with(axes) && !axis.name.starts_with(axes + ".")) continue;
      const double reached = axis.fit ? largest_size((*axis.fit).*(term->member)) : std::numeric_limits<double>::infinity();
      if (reached <= out.reached) continue;
      out.reached = reached;
      out.coefficient = axis.name + "." + term->name;
      out.note = axis.fit ? how_judged((*axis.fit).*(term->member), found.limit, found.limit / limit.number, limit.unit) : "";
      if (logs.size() > 1) out.note += (out.note.empty() ? "" : "; ") + log.recording;
    }
  if (out.reached < 0) throw Error(limit.name + ": the log has no such axis");
  out.met = out.reached <= out.limit;
  return out;
}

}  // namespace

std::vector<RequirementResult> assess(const std::vector<NoiseAnalysis>& logs, std::string_view limits) {
  const NoiseFigures figures = figures_of(logs);
  std::vector<RequirementResult> out;
  for (const StatedLimit& limit : noise_limits(limits)) out.push_back(assessed(logs, limit, figures));
  return out;
}

void expect_noise_limits(std::string_view text) {
  NoiseFigures figures = noise_figures(false, false), counts = noise_figures(true, true);
  for (std::size_t i = 0; i < figures.stated.size(); ++i)
    for (const StatedUnit& unit : counts.stated[i].units) figures.stated[i].units.push_back(unit);
  for (const StatedLimit& limit : noise_limits(text)) expect_no_noise_time(limit), find_figure(limit, figures.stated);
}

}  // namespace imulab
