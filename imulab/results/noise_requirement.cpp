#include "imulab/results/noise_requirement.hpp"

#include "imulab/core/stated_limit.hpp"
#include "imulab/error.hpp"
#include "imulab/formats/text/figures.hpp"
#include "imulab/noise/data_sheet.hpp"
#include "imulab/results/noise.hpp"
#include "imulab/units.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <utility>

namespace imulab {
namespace {

/// Units of a term beside its customary one and that of SI.
struct FurtherUnits {
  std::vector<StatedUnit> gyro, accel;
};

/// In the order of noise_terms.
const std::array<FurtherUnits, 5>& further_units() {
  using namespace unit;
  static const std::array<FurtherUnits, 5> all{
      {{{{"deg/s/sqrt(Hz)", deg}, {"deg/h/sqrt(Hz)", deg_per_h}}, {{"mg/sqrt(Hz)", 1e3 * ug_per_sqrt_hz}, {"m/s/sqrt(h)", 1 / std::sqrt(hour)}}},
       {{{"deg/s", deg}}, {{"mg", 1e3 * ug}}},
       {{{"deg/s/sqrt(s)", deg}}, {}},
       {},
       {}}};
  return all;
}

std::vector<StatedUnit> units_of(std::size_t term, bool gyro, bool counts) {
  const NoiseTermText& of = noise_terms()[term];
  if (counts) return {{of.count.name, of.count.size}};
  const NoiseUnit& customary = gyro ? of.gyro : of.accel;
  std::vector<StatedUnit> out{{customary.name, customary.size}};
  const std::vector<StatedUnit>& further = gyro ? further_units()[term].gyro : further_units()[term].accel;
  out.insert(out.end(), further.begin(), further.end());
  out.push_back({customary.si, 1});
  return out;
}

/// All that may be limited: of a triad, and of an axis of it.
struct NoiseFigures {
  std::vector<StatedFigure> stated;
  std::vector<std::pair<std::string, const NoiseTermText*>> of;  ///< the begin of the axes' names, and the term
};

NoiseFigures noise_figures(bool gyro_counts, bool accel_counts) {
  NoiseFigures out;
  for (const char* axis : {".", ".x", ".y", ".z"})
    for (std::size_t k = 0; k < noise_terms().size(); ++k)
      for (const bool gyro : {true, false}) {
        const NoiseTermText& term = noise_terms()[k];
        const std::string axes = std::string(gyro ? "gyro" : "accel") + axis;
        out.stated.push_back({axes.ends_with('.') ? axes + term.name : axes + "." + term.name, units_of(k, gyro, gyro ? gyro_counts : accel_counts)});
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

/// find_figure, which also names the key that a usual name such as gyro.ARW means.
FoundFigure find_noise_figure(const StatedLimit& limit, const std::vector<StatedFigure>& figures) {
  std::string meant = meant_noise_key(limit.name);
  if (meant.ends_with(".stability")) meant.replace(meant.find('.'), std::string::npos, ".B");
  if (!meant.empty()) throw Error(fmt::format("{}: no figure of this result; did you mean {}?", limit.name, meant));
  return find_figure(limit, figures);
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
  const FoundFigure found = find_noise_figure(limit, figures.stated);
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
  for (const StatedLimit& limit : noise_limits(text)) expect_no_noise_time(limit), find_noise_figure(limit, figures.stated);
}

}  // namespace imulab
