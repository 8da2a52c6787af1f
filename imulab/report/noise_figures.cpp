#include "imulab/report/noise_figures.hpp"

#include "imulab/noise/bound.hpp"
#include "imulab/noise/spectrum.hpp"
#include "imulab/report/html.hpp"
#include "imulab/report/plot.hpp"
#include "imulab/results/noise.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <numbers>
#include <optional>

namespace imulab::report {
namespace {

constexpr std::string_view page_ink = "var(--ink)";  // of the page: dark on light, or light on dark
constexpr PlotSize triad_plot{460, 330};

bool of_triad(const std::string& name, bool gyro) { return name.starts_with(gyro ? "gyro." : "accel."); }

std::vector<const NoiseAxis*> triad_axes(const NoiseAnalysis& analysis, bool gyro) {
  std::vector<const NoiseAxis*> out;
  for (const NoiseAxis& axis : analysis.axes)
    if (axis.fit && of_triad(axis.name, gyro)) out.push_back(&axis);
  return out;
}

std::string_view axis_color(const NoiseAxis& axis) { return color::series(static_cast<std::size_t>(axis.name.back() - 'x')); }

/// Place of a unit in the table of terms.
constexpr std::size_t density_term = 0, rate_term_place = 1;
const NoiseUnit& axis_unit(const NoiseAxis& axis, std::size_t term) { return noise_terms()[term].unit(axis.unit); }

/// A logarithmic axis as long as its values: whole decades would leave half of a chart empty.
Axis tight_axis(std::string label, const std::vector<double>& values) {
  const bool usable = !values.empty() && std::all_of(values.begin(), values.end(), [](double v) { return v > 0 && std::isfinite(v); });
  if (!usable) return axis_over(std::move(label), values, true);
  const auto [low, high] = std::minmax_element(values.begin(), values.end());
  return {std::move(label), *low / 1.3, *high * 1.3, true};
}

struct DeviationCurve {
  std::vector<double> tau, sigma, low, high;
};

DeviationCurve deviation_of(const NoiseAxis& axis) {
  DeviationCurve c;
  for (const DeviationPoint& p : axis.deviation) {
    const double size = axis_unit(axis, rate_term_place).size;
    c.tau.push_back(p.tau), c.sigma.push_back(p.deviation / size), c.low.push_back(p.lower_95 / size);
    c.high.push_back(std::min(p.upper_95, 5 * p.deviation) / size);  // the bound of one difference would be the whole chart
  }
  return c;
}

void append_to(std::vector<double>& to, const std::vector<double>& more) { to.insert(to.end(), more.begin(), more.end()); }

/// The axes of all charts of a triad's deviations.
std::pair<Axis, Axis> deviation_axes(const std::vector<const NoiseAxis*>& axes) {
  std::vector<double> tau, shown;
  for (const NoiseAxis* axis : axes) {
    const DeviationCurve c = deviation_of(*axis);
    append_to(tau, c.tau), append_to(shown, c.sigma), append_to(shown, c.low), append_to(shown, c.high);
  }
  return {tight_axis("averaging time [s]", tau),
          axis_over("Allan-type deviation [" + noise_unit_text(axis_unit(*axes.front(), rate_term_place).name) + "]", shown, true)};
}

/// A term's deviation a tau^p.
struct TermSlope {
  double a = 0, p = 0;
};

/// Where a slope is on the chart: from `first` to `last`; nothing where it is not.
std::optional<std::pair<double, double>> visible_part(const TermSlope& s, const Axis& x, const Axis& y) {
  if (s.p == 0) return s.a > y.low && s.a < y.high ? std::optional(std::pair(x.low, x.high)) : std::nullopt;
  const double at_low = std::pow(y.low / s.a, 1 / s.p), at_high = std::pow(y.high / s.a, 1 / s.p);
  const double first = std::max(x.low, std::min(at_low, at_high)), last = std::min(x.high, std::max(at_low, at_high));
  return first < last ? std::optional(std::pair(first, last)) : std::nullopt;
}

/// The slopes of N, B and K of a triad's worst axis, with their names under them, where the curve is not.
void mark_slopes(Plot& plot, const NoiseAnalysis& analysis, bool gyro, const Axis& x, const Axis& y) {
  const std::array<TermSlope, 3> unit{{{1, -0.5}, {std::sqrt(2 * std::numbers::ln2 / std::numbers::pi), 0}, {std::sqrt(1.0 / 3), 0.5}}};
  for (std::size_t j = 0; j < unit.size(); ++j) {
    const WorstTerm worst = worst_term(analysis, gyro, noise_terms()[j].member);
    const double value = worst.c->determined ? worst.c->value : worst.c->upper;
    const TermSlope s{unit[j].a * value / axis_unit(*worst.axis, rate_term_place).size, unit[j].p};
    const auto shown = s.a > 0 && std::isfinite(s.a) ? visible_part(s, x, y) : std::nullopt;
    if (!shown) continue;
    const auto at = [&](double tau) { return s.a * std::pow(tau, s.p); };
    const auto& [first, last] = *shown;
    plot.segment(first, at(first), last, at(last), page_ink, !worst.c->determined);
    const NoiseUnit& its = axis_unit(*worst.axis, j);
    const std::string text = fmt::format("{} {}{} {}", noise_terms()[j].name, worst.c->determined ? "" : "< ",
                                         number_text(value / its.size, worst.c->determined ? 3 : 2), noise_unit_text(its.name));
    const double part = std::log(first / x.low) / std::log(x.high / x.low), height = std::log(at(first) / y.low) / std::log(y.high / y.low);
    const double within = first * std::pow(last / first, 0.4);
    if (j == 0) plot.note(within, at(within), text, Anchor::end, -2, 16);
    if (j == 1) plot.note(first, at(first), text, Anchor::start, 6, height < 0.1 ? -6 : 15);
    if (j == 2) plot.note(first, at(first), text, part > 0.6 ? Anchor::end : Anchor::start, part > 0.6 ? -6 : 46, -5);
  }
}

std::string triad_deviation(const NoiseAnalysis& analysis, bool gyro) {
  const std::vector<const NoiseAxis*> axes = triad_axes(analysis, gyro);
  if (axes.empty()) return {};
  const auto [x, y] = deviation_axes(axes);
  Plot plot(x, y, gyro ? "deviations of the gyros" : "deviations of the accelerometers", triad_plot);
  for (const NoiseAxis* axis : axes) {
    const DeviationCurve c = deviation_of(*axis);
    plot.band(c.tau, c.low, c.high, axis_color(*axis));
  }
  mark_slopes(plot, analysis, gyro, x, y);
  for (const NoiseAxis* axis : axes) {
    const DeviationCurve c = deviation_of(*axis);
    plot.line(c.tau, c.sigma, axis_color(*axis), 2);
  }
  return figure(plot.svg(), gyro ? "gyros" : "accelerometers");
}

struct DensityCurve {
  std::vector<double> hz, measured, model;
};

/// Neighboring points as one until they have eight degrees of freedom or half an octave: fewer scatter so far that they hide the rest. The lowest
/// ones have but one each, and stay.
DensityCurve density_curve(const NoiseAxis& axis) {
  DensityCurve out;
  const double size = axis_unit(axis, density_term).size;
  const std::vector<SpectrumPoint>& all = axis.fit->spectrum;
  constexpr double enough = 8, half_octave = std::numbers::sqrt2;
  for (std::size_t k = 0; k < all.size();) {
    const double first = all[k].hz;
    double count = 0, power = 0, model = 0, hz = 0;
    do {  // at least one, whatever a file says
      const double weight = std::max(1.0, all[k].count);
      count += weight, power += weight * all[k].density, model += weight * all[k].model, hz += weight * all[k].hz;
      ++k;
    } while (k < all.size() && count < enough && all[k].hz < half_octave * first);
    out.hz.push_back(hz / count), out.measured.push_back(std::sqrt(power / count) / size), out.model.push_back(std::sqrt(model / count) / size);
  }
  return out;
}

std::pair<Axis, Axis> spectrum_axes(const std::vector<const NoiseAxis*>& axes, const std::vector<double>& more = {}) {
  std::vector<double> hz, shown = more;
  for (const NoiseAxis* axis : axes) {
    const DensityCurve d = density_curve(*axis);
    append_to(hz, d.hz), append_to(shown, d.measured), append_to(shown, d.model);
  }
  return {tight_axis("frequency [Hz]", hz),
          axis_over("root of the density [" + noise_unit_text(axis_unit(*axes.front(), density_term).name) + "]", shown, true)};
}

std::string triad_spectrum(const NoiseAnalysis& analysis, bool gyro) {
  const std::vector<const NoiseAxis*> axes = triad_axes(analysis, gyro);
  if (axes.empty() || axes.front()->fit->spectrum.empty()) return {};
  const auto [x, y] = spectrum_axes(axes);
  Plot plot(x, y, gyro ? "spectra of the gyros" : "spectra of the accelerometers", triad_plot);
  for (const NoiseAxis* axis : axes) {
    const DensityCurve d = density_curve(*axis);
    plot.dots(d.hz, d.measured, axis_color(*axis));
  }
  for (const NoiseAxis* axis : axes) {
    const DensityCurve d = density_curve(*axis);
    plot.line(d.hz, d.model, axis_color(*axis), 2);
  }
  return figure(plot.svg(), gyro ? "gyros" : "accelerometers");
}

std::string axis_deviation(const NoiseAxis& axis, const std::pair<Axis, Axis>& scales) {
  const DeviationCurve c = deviation_of(axis);
  const double size = axis_unit(axis, rate_term_place).size;
  Plot plot(scales.first, scales.second, "deviation of " + axis.name);
  plot.band(c.tau, c.low, c.high, axis_color(axis));
  std::vector<double> total;
  std::array<std::vector<double>, 6> terms;
  for (const double t : c.tau) {
    const AllanTerms at = allan_variance(*axis.fit, t);
    total.push_back(std::sqrt(at.sum()) / size);
    const std::array<double, 6> one{at.N, at.B, at.K, at.Q, at.R, at.markov};
    for (std::size_t j = 0; j < one.size(); ++j) {
      const double value = std::sqrt(one[j]) / size;
      terms[j].push_back(value > scales.second.low ? value : NAN);  // below, it would run along the axis
    }
  }
  for (const std::vector<double>& term : terms) plot.line(c.tau, term, color::gray, 1);
  plot.line(c.tau, total, page_ink);
  plot.dots(c.tau, c.sigma, axis_color(axis));
  return figure(plot.svg(), axis.name);
}

/// Welch's, the largest of every few: lines stay.
struct WelchCurve {
  std::vector<double> hz, density;
};
WelchCurve welch_of(const NoiseAxis& axis, std::span<const double> readings, double interval_s) {
  constexpr std::size_t points = 400;
  const std::size_t length = std::bit_floor(std::clamp<std::size_t>(readings.size() / 32, 64, 16384));  // some dozens of pieces that show lines
  const WelchSpectrum welch = welch_spectrum(readings, interval_s, length);
  WelchCurve out;
  const std::size_t step = welch.density.size() / points + 1;
  for (std::size_t k = 0; k < welch.density.size(); k += step) {
    const auto first = welch.density.begin() + static_cast<std::ptrdiff_t>(k),
               last = welch.density.begin() + static_cast<std::ptrdiff_t>(std::min(k + step, welch.density.size()));
    out.hz.push_back(welch.spacing_hz * (static_cast<double>(k) + 0.5 * static_cast<double>(step) + 0.5));
    out.density.push_back(std::sqrt(*std::max_element(first, last)) / axis_unit(axis, density_term).size);
  }
  return out;
}

std::string axis_spectrum(const NoiseAxis& axis, const std::vector<const NoiseAxis*>& triad, const WelchCurve& welch, double interval_s) {
  const auto [x, y] = spectrum_axes(triad, welch.density);
  Plot plot(x, y, "spectrum of " + axis.name);
  plot.line(welch.hz, welch.density, color::sky, 1);
  const DensityCurve d = density_curve(axis);
  plot.dots(d.hz, d.measured, axis_color(axis));
  plot.line(d.hz, d.model, page_ink);
  if (axis.fit->bound) {
    std::vector<double> hz, bound;
    for (const UpperDensity& u : axis.fit->bound->upper)
      if (u.hz >= x.low)
        hz.push_back(u.hz), bound.push_back(std::sqrt(noise::density(*axis.fit->bound, u.hz, interval_s)) / axis_unit(axis, density_term).size);
    plot.line(hz, bound, color::purple, 2);
  }
  return figure(plot.svg(), axis.name);
}

std::string axes_key() { return key({{"x", color::series(0)}, {"y", color::series(1)}, {"z", color::series(2)}}); }

}  // namespace

std::string noise_unit_text(std::string_view unit) {
  std::string out = readable_unit(unit);
  if (out.starts_with('u')) out.replace(0, 1, "µ");
  for (std::size_t at = 0; (at = out.find("sqrt(", at)) != std::string::npos;) {
    out.erase(out.find(')', at), 1);
    out.replace(at, 5, "√");
  }
  return out;
}

std::string noise_value_text(const NoiseCoefficient& c, double size, const std::string& unit) {
  return c.determined ? fmt::format("{} {}", number_text(c.value / size), noise_unit_text(unit))
                      : fmt::format("below {} {}", number_text(c.upper / size, 2), noise_unit_text(unit));
}

WorstTerm worst_term(const NoiseAnalysis& analysis, bool gyro, NoiseCoefficient NoiseCoefficients::*term) {
  WorstTerm worst;
  for (const NoiseAxis* axis : triad_axes(analysis, gyro)) {
    const NoiseCoefficient& c = (*axis->fit).*term;
    ++worst.axes, worst.determined += c.determined;
    const bool first = worst.c == nullptr, better_kind = !first && c.determined && !worst.c->determined;
    const bool larger = !first && c.determined == worst.c->determined && (c.determined ? c.value > worst.c->value : c.upper > worst.c->upper);
    if (first || better_kind || larger) worst.axis = axis, worst.c = &c;
  }
  return worst;
}

std::string deviation_charts(const NoiseAnalysis& analysis) {
  return axes_key() + beside({triad_deviation(analysis, true), triad_deviation(analysis, false)});
}

std::string spectrum_charts(const NoiseAnalysis& analysis) {
  const std::string gyros = triad_spectrum(analysis, true), accelerometers = triad_spectrum(analysis, false);
  return gyros.empty() && accelerometers.empty() ? "" : axes_key() + beside({gyros, accelerometers});
}

std::string axis_charts(const NoiseAnalysis& analysis, const AxisReadings& readings) {
  std::string out;
  for (std::size_t k = 0; k < analysis.axes.size(); ++k) {
    const NoiseAxis& axis = analysis.axes[k];
    if (!axis.fit) continue;
    const std::vector<const NoiseAxis*> triad = triad_axes(analysis, of_triad(axis.name, true));
    std::vector<std::string> figures{axis_deviation(axis, deviation_axes(triad))};
    if (!axis.fit->spectrum.empty())
      figures.push_back(axis_spectrum(axis, triad, readings ? welch_of(axis, readings(k), analysis.interval_s) : WelchCurve{}, analysis.interval_s));
    out += beside(figures);
  }
  if (out.empty()) return out;
  const bool bounded = std::ranges::any_of(analysis.axes, [](const NoiseAxis& axis) { return axis.fit && axis.fit->bound; });
  return key({{"fitted terms", color::gray}, {"their sum", page_ink}}) + (bounded ? key({{"bound for a filter", color::purple}}) : "") +
         (readings ? key({{"Welch's spectrum, with lines: the largest of neighboring densities", color::sky}}) : "") + out;
}

std::string batch_charts(const NoiseBatch& batch) {
  constexpr std::size_t colors = 6;  // more logs than that are one cloud
  std::vector<std::pair<std::string, std::string_view>> names;
  for (std::size_t k = 0; k < batch.logs.size(); ++k)
    names.emplace_back(shortened(batch.logs[k].recording, 40), color::series(batch.logs.size() <= colors ? k : 0));
  std::vector<std::string> figures;
  for (const BatchAxis& shared : batch.axes) {
    std::vector<const NoiseAxis*> triad;
    for (const NoiseAnalysis& log : batch.logs)
      for (const NoiseAxis* axis : triad_axes(log, of_triad(shared.name, true))) triad.push_back(axis);
    if (triad.empty()) continue;
    const auto [x, y] = deviation_axes(triad);
    Plot plot(x, y, "deviations of " + shared.name);
    for (std::size_t k = 0; k < batch.logs.size(); ++k)
      for (const NoiseAxis& axis : batch.logs[k].axes)
        if (axis.name == shared.name && axis.fit) {
          const DeviationCurve c = deviation_of(axis);
          plot.line(c.tau, c.sigma, names[k].second, 1.5);
        }
    figures.push_back(figure(plot.svg(), shared.name));
  }
  return (names.size() <= colors ? key(names) : "") + beside(figures);
}

}  // namespace imulab::report
