#include "imulab/results/noise.hpp"

#include "imulab/formats/text/figures.hpp"
#include "imulab/formats/text/printable.hpp"
#include "imulab/noise/data_sheet.hpp"
#include "imulab/results/noise_moving.hpp"
#include "imulab/units.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>
#include <vector>

namespace imulab {

namespace {

/// A term of an axis, as the headline counts it.
struct HeadlineAxis {
  std::string letter;
  std::array<const NoiseCoefficient*, 3> terms;  // N, B, K
};

std::string joined(const std::vector<std::string>& words) {
  std::string out;
  for (std::size_t k = 0; k < words.size(); ++k) out += (k == 0 ? "" : k + 1 == words.size() ? " and " : ", ") + words[k];
  return out;
}

/// "gyro u(N) 0.2 %, u(B) of x 5 %, K only bounded"
std::string triad_headline(const char* triad, const std::vector<HeadlineAxis>& axes) {
  std::string known;
  std::vector<std::string> bounded;
  for (std::size_t j = 0; j < 3; ++j) {
    std::vector<std::string> letters;
    double worst = 0;
    for (const HeadlineAxis& axis : axes)
      if (const NoiseCoefficient& c = *axis.terms[j]; c.determined) {
        letters.push_back(axis.letter);
        worst = std::max(worst, 100 * c.standard_uncertainty / c.value);
      }
    const std::string name = noise_terms()[j].name;
    if (letters.empty()) {
      bounded.push_back(name);
      continue;
    }
    known += fmt::format("{}u({}){} {} %", known.empty() ? "" : ", ", name, letters.size() < axes.size() ? " of " + joined(letters) : "",
                         text::number(worst, worst < 1 ? 1 : 2));
  }
  std::string out = fmt::format("{} {}", triad, known);
  if (!bounded.empty()) out += fmt::format("{}{} only bounded", known.empty() ? "" : ", ", joined(bounded));
  return out;
}

/// `terms_of` an axis: N, B, K; empty where it has no noise.
template <class Axes, class Terms>
std::string headline_of(const Axes& axes, const Terms& terms_of) {
  std::string out;
  std::vector<std::string> silent;
  for (const auto& [triad, name] : {std::pair{"gyro", "gyro"}, {"accel", "accelerometer"}}) {
    std::vector<HeadlineAxis> of_triad;
    for (const auto& axis : axes) {
      if (!axis.name.starts_with(triad)) continue;
      if (const auto terms = terms_of(axis))
        of_triad.push_back({axis.name.substr(axis.name.rfind('.') + 1), *terms});
      else
        silent.push_back(axis.name);
    }
    if (!of_triad.empty()) out += (out.empty() ? "" : "; ") + triad_headline(name, of_triad);
  }
  if (out.empty()) return "no noise on any axis";
  return silent.empty() ? out : out + "; no noise on " + joined(silent);
}

/// "12.3  95 % interval 11.9 to 12.7", or a bound, in columns.
std::string value_columns(const NoiseCoefficient& c, double size) {
  if (!c.determined) return fmt::format("{:>10}  {:<21}", "-", c.upper == 0 ? "not in the model" : "below " + text::number(c.upper / size, 2));
  const double sigma = c.standard_uncertainty / size;
  return fmt::format("{:>10}  {:<21}", text::to_digits_of(sigma, c.value / size),
                     fmt::format("{} to {}", text::to_digits_of(sigma, c.lower / size), text::to_digits_of(sigma, c.upper / size)));
}

std::string term_row(const NoiseTermText& term, const NoiseAxis& axis) {
  const NoiseUnit& unit = term.unit(axis.unit);
  return fmt::format("  {:<8} {}  {} {}\n", axis.name, term.name, value_columns((*axis.fit).*term.member, unit.size), unit.name);
}

/// Sigmas and amplitudes have the unit of B.
constexpr std::size_t rate_term = 1;
/// Number of terms that a data sheet has: N, B, K.
constexpr std::size_t sheet_terms = 3;

/// Rows of processes, filter, lines and steps of an axis.
std::string other_rows(const NoiseAxis& axis) {
  const NoiseUnit& rate = noise_terms()[rate_term].unit(axis.unit);
  std::string out;
  const auto row = [&](const char* name, const NoiseCoefficient& c, double size, const std::string& unit) {
    out += fmt::format("  {:<8} {:<14} {} {}\n", axis.name, name, value_columns(c, size), unit);
  };
  if (const auto& joint = axis.fit->joint) row(fmt::format("B, K, {} s", text::number(joint->tau_s)).c_str(), joint->deviation, rate.size, rate.name);
  for (const MarkovTerm& term : axis.fit->markov) {
    row("Markov sigma", term.sigma, rate.size, rate.name);
    row("       time", term.time, 1, "s");
  }
  for (const NoiseLine& line : axis.fit->lines) row(fmt::format("at {} Hz", text::number(line.hz, 5)).c_str(), line.amplitude, rate.size, rate.name);
  if (axis.fit->low_pass) row(fmt::format("low-pass, {}.", axis.fit->low_pass->order).c_str(), axis.fit->low_pass->cutoff_hz, 1, "Hz");
  if (axis.fit->resolution > 0)
    out += fmt::format("  {:<8} {:<14} {:>10}  {:<21} {}\n", axis.name, "readings' step", text::number(axis.fit->resolution / rate.size, 3), "",
                       rate.name);
  return out;
}

/// "gyro N 0.228 deg/sqrt(h)" of the worst axis, and the same of the accelerometers.
std::string sheet_headline(const NoiseAnalysis& analysis) {
  std::string out;
  for (const auto& [triad, name] : {std::pair{"gyro.", "gyro"}, {"accel.", "accelerometer"}}) {
    const NoiseAxis* worst = nullptr;
    for (const NoiseAxis& axis : analysis.axes)
      if (axis.name.starts_with(triad) && (worst == nullptr || axis.fit->N.value > worst->fit->N.value)) worst = &axis;
    if (worst == nullptr) continue;
    const NoiseUnit& unit = noise_terms()[0].unit(worst->unit);
    out += fmt::format("{}{} N {} {}", out.empty() ? "" : ", ", name, text::number(worst->fit->N.value / unit.size), unit.name);
  }
  return out;
}

std::string sheet_text(const NoiseAnalysis& analysis) {
  std::string out = text::wrapped("", noise_headline(analysis)) + "\n" + (analysis.moving ? moving_text(analysis) + "\n" : "") +
                    (analysis.recording.empty() ? "data sheet" : one_line(analysis.recording)) + "\n";
  for (const std::string& note : analysis.notes) out += "  " + one_line(note) + "\n";
  out += fmt::format("\n  {:<8} {:<4} {:<24} {:<30} {}\n", "axis", "term", "value", "SI", "standing");
  for (const auto& [axis, term, value, si, standing] : sheet_rows(analysis))
    out += fmt::format("  {:<8} {:<4} {:<24} {:<30} {}\n", axis, term, value, si, standing);
  return out + "\n" + text::wrapped("  ", std::string(sheet_legend));
}

const NoiseBound* bound_of(const NoiseAxis& axis) { return axis.fit && axis.fit->bound ? &*axis.fit->bound : nullptr; }
const NoiseBound* bound_of(const BatchAxis& axis) { return axis.bound ? &*axis.bound : nullptr; }

template <class Axis>
std::vector<std::array<std::string, 5>> bound_rows_of(const std::vector<Axis>& axes) {
  std::vector<std::array<std::string, 5>> out;
  for (const Axis& axis : axes) {
    const NoiseBound* const bound = bound_of(axis);
    if (bound == nullptr) continue;
    const auto in_unit = [&](std::size_t term, double value) { return text::number(value / noise_terms()[term].unit(axis.unit).size); };
    std::vector<std::string> processes, costs;
    for (const BoundProcess& p : bound->markov) processes.push_back(fmt::format("{} in {} s", in_unit(rate_term, p.sigma), text::number(p.time)));
    for (const BoundCoast& c : bound->coast) costs.push_back(text::number(c.ratio));
    out.push_back({axis.name, in_unit(0, bound->N), fmt::format("{}", fmt::join(processes, ", ")), in_unit(2, bound->K),
                   fmt::format("{}", fmt::join(costs, ", "))});
  }
  return out;
}

template <class Axis>
std::vector<std::string> bound_legend_of(const std::vector<Axis>& axes) {
  const auto has_bound = [](const Axis& axis) { return bound_of(axis) != nullptr; };
  const auto first = std::ranges::find_if(axes, has_bound);
  if (first == axes.end()) return {};
  const NoiseBound& bound = *bound_of(*first);
  std::vector<std::string> units, coasts;
  for (const auto& [triad, name] : {std::pair{"gyro", "gyros"}, {"accel", "accelerometers"}})
    for (const Axis& axis : axes)
      if (axis.name.starts_with(triad) && has_bound(axis)) {
        const auto unit = [&](std::size_t term) { return noise_terms()[term].unit(axis.unit).name; };
        units.push_back(fmt::format("{} in {}, {}, {}", name, unit(0), unit(rate_term), unit(2)));
        break;
      }
  for (const BoundCoast& c : bound.coast) coasts.push_back(text::number(c.time_s));
  const bool in_motion = std::ranges::any_of(axes, [&](const Axis& axis) { return has_bound(axis) && bound_of(axis)->in_motion; });
  return {fmt::format("bound: noise of a filter for coasts up to {} s, at no frequency below what the {} with {} %", text::number(bound.horizon_s),
                      in_motion ? "logs at rest and in motion permit" : "log permits", text::number(100 * bound.confidence)),
          fmt::format("N, standard deviation and time of the processes, K: {}", fmt::join(units, "; ")),
          fmt::format("cost: Allan deviation of the bound over that of the fit at {} s, both without Q, which does not accumulate",
                      fmt::join(coasts, ", "))};
}

/// Empty without bounds.
std::string bound_text(const std::vector<std::array<std::string, 5>>& rows, const std::vector<std::string>& legend) {
  if (rows.empty()) return "";
  constexpr const char* row = "  {:<8} {:<9} {:<34} {:<8} {}\n";
  std::string out = "\n" + fmt::format(row, "bound", "N", "processes", "K", "cost");
  for (const auto& [axis, N, processes, K, cost] : rows) out += fmt::format(row, axis, N, processes.empty() ? "-" : processes, K, cost);
  out += "\n";
  for (const std::string& line : legend) out += text::wrapped("  ", line);
  return out;
}

/// Empty where the log was compared with no data sheet.
std::string comparison_text(const NoiseAnalysis& analysis) {
  if (analysis.sheet.empty()) return "";
  constexpr const char* row = "  {:<17} {:>7} {:>7}  {:<16} {:<11} {:>5} {}\n";
  std::string out = "\n" + fmt::format(row, "against the sheet", "sheet", "log", "95 % interval", "unit", "ratio", "sheet is");
  for (const auto& [name, sheet, log, interval, unit, ratio, judgment] : comparison_rows(analysis))
    out += fmt::format(row, name, sheet, log, interval, unit, ratio, judgment);
  return out;
}

}  // namespace

const std::array<NoiseTermText, 5>& noise_terms() {
  static const std::array<NoiseTermText, 5> all{
      {{"N",
        "white noise (random walk of angle, velocity)",
        &NoiseCoefficients::N,
        1,
        {unit::deg_per_sqrt_h, "deg/sqrt(h)", "rad/s/sqrt(Hz)"},
        {unit::ug_per_sqrt_hz, "ug/sqrt(Hz)", "m/s^2/sqrt(Hz)"},
        {1, "count/sqrt(Hz)", ""}},
       {"B",
        "bias instability (flicker)",
        &NoiseCoefficients::B,
        2,
        {unit::deg_per_h, "deg/h", "rad/s"},
        {unit::ug, "ug", "m/s^2"},
        {1, "count", ""}},
       {"K",
        "random walk of the bias",
        &NoiseCoefficients::K,
        3,
        {unit::deg_per_h / 60, "deg/h/sqrt(h)", "rad/s/sqrt(s)"},
        {unit::ug / 60, "ug/sqrt(h)", "m/s^2/sqrt(s)"},
        {1, "count/sqrt(s)", ""}},
       {"Q", "quantization", &NoiseCoefficients::Q, 0, {unit::arcsec, "arcsec", "rad"}, {1e-6, "um/s", "m/s"}, {1, "count s", ""}},
       {"R",
        "ramp",
        &NoiseCoefficients::R,
        4,
        {unit::deg_per_h / unit::hour, "deg/h/h", "rad/s^2"},
        {unit::ug / unit::hour, "ug/h", "m/s^3"},
        {1, "count/s", ""}}}};
  return all;
}

std::string noise_headline(const NoiseAnalysis& analysis) {
  if (analysis.moving) return moving_headline(analysis);
  if (analysis.from_data_sheet()) return "values of a data sheet, not fitted to a log: " + sheet_headline(analysis);
  return headline_of(analysis.axes, [](const NoiseAxis& axis) -> std::optional<std::array<const NoiseCoefficient*, 3>> {
    if (!axis.fit) return std::nullopt;
    return std::array{&axis.fit->N, &axis.fit->B, &axis.fit->K};
  });
}

std::vector<std::array<std::string, 5>> sheet_rows(const NoiseAnalysis& analysis) {
  std::vector<std::array<std::string, 5>> out;
  for (std::size_t i = 0; i + 2 < analysis.axes.size(); i += 3)  // triads, each x, y, z
    for (std::size_t k = 0; k < sheet_terms; ++k) {
      const NoiseTermText& term = noise_terms()[k];
      const auto coefficient = [&](std::size_t axis) -> const NoiseCoefficient& { return (*analysis.axes[i + axis].fit).*term.member; };
      const auto size = [](const NoiseCoefficient& c) { return c.determined ? c.value : c.upper; };
      const bool equal = size(coefficient(0)) == size(coefficient(1)) && size(coefficient(0)) == size(coefficient(2));
      for (std::size_t axis = 0; axis < (equal ? 1 : 3); ++axis) {
        const NoiseCoefficient& c = coefficient(axis);
        const std::string& name = analysis.axes[i + axis].name;
        const NoiseUnit& unit = term.unit(analysis.axes[i + axis].unit);
        const std::string at_most = c.bounded ? "<= " : "";
        out.push_back({equal ? name.substr(0, name.find('.')) : name, term.name,
                       fmt::format("{}{} {}", at_most, text::number(size(c) / unit.size), unit.name),
                       fmt::format("{}{} {}", at_most, text::number(size(c), 4), unit.si), sheet_standing(*analysis.axes[i + axis].fit, c)});
      }
    }
  return out;
}

std::vector<std::array<std::string, 7>> comparison_rows(const NoiseAnalysis& analysis) {
  std::vector<std::array<std::string, 7>> out;
  for (const SheetComparison& c : analysis.sheet) {
    const char last = c.name.back();  // of N, B, K or stability, which has the unit of B
    const NoiseTermText& term = noise_terms()[last == 'N' ? 0 : last == 'K' ? 2 : rate_term];
    const NoiseUnit& unit = c.name.starts_with("gyro") ? term.gyro : term.accel;
    const bool known = std::isfinite(c.value);
    const auto shown = [&](double value) { return text::number(value / unit.size); };
    out.push_back({c.name, shown(c.sheet), known ? shown(c.value) : "-", known ? shown(c.lower) + " to " + shown(c.upper) : "below " + shown(c.upper),
                   unit.name, known ? text::number(c.ratio(), 3) : "-",
                   c.contained()       ? (known ? "inside" : "possible")
                   : c.sheet > c.upper ? "above"
                                       : "below"});
  }
  return out;
}

std::string noise_headline(const NoiseBatch& batch) {
  return headline_of(batch.axes, [](const BatchAxis& axis) {
    return std::optional(std::array{&axis.coefficients[1].mean, &axis.coefficients[2].mean, &axis.coefficients[3].mean});
  });
}

std::vector<std::array<std::string, 5>> bound_rows(const NoiseAnalysis& analysis) { return bound_rows_of(analysis.axes); }
std::vector<std::array<std::string, 5>> bound_rows(const NoiseBatch& batch) { return bound_rows_of(batch.axes); }
std::vector<std::string> bound_legend(const NoiseAnalysis& analysis) { return bound_legend_of(analysis.axes); }
std::vector<std::string> bound_legend(const NoiseBatch& batch) { return bound_legend_of(batch.axes); }

std::string noise_text(const NoiseAnalysis& analysis) {
  if (analysis.from_data_sheet()) return sheet_text(analysis);
  std::string out = (analysis.moving ? moving_text(analysis) + "\nat rest: " : "") + one_line(analysis.recording) + "\n";
  for (const std::string& note : analysis.notes) out += text::wrapped("  ", note);
  out += "\n  axis     term     value  95 % interval         unit\n";
  for (const NoiseTermText& term : noise_terms())
    for (const NoiseAxis& axis : analysis.axes)
      if (axis.fit) out += term_row(term, axis);
  std::string others;
  for (const NoiseAxis& axis : analysis.axes)
    if (axis.fit) others += other_rows(axis);
  if (!others.empty()) out += "\n" + others;
  out += "\n";
  for (const NoiseTermText& term : noise_terms()) out += fmt::format("  {}  {}\n", term.name, term.meaning);
  return out + text::wrapped("  ", "-  not determined by this log: zero is not excluded; the bound holds with 95 %") +
         bound_text(bound_rows(analysis), bound_legend(analysis)) + comparison_text(analysis);
}

std::string noise_text(const NoiseBatch& batch) {
  std::string out = fmt::format("{} logs\n", batch.logs.size());
  for (const NoiseAnalysis& log : batch.logs) out += fmt::format("  {}: {:.6g} s at rest\n", one_line(log.recording), log.end_s - log.begin_s);
  out += "\n  axis     term      mean  95 % interval         spread   worst    unit\n";
  for (const NoiseTermText& term : noise_terms())
    for (const BatchAxis& axis : batch.axes) {
      const BatchCoefficient& c = axis.coefficients[term.batch_place];
      const NoiseUnit& unit = term.unit(axis.unit);
      out += fmt::format("  {:<8} {}  {} {:<8} {:<8} {}\n", axis.name, term.name, value_columns(c.mean, unit.size),
                         std::isnan(c.spread) ? "-" : text::number(c.spread / unit.size, 2), text::number(c.worst / unit.size, 2), unit.name);
    }
  out += "\n" + text::wrapped("  ", "mean: of the logs that determine the term; -: no log does, and the largest bound holds");
  return out + text::wrapped("  ", "spread: from log to log, beyond what the uncertainties explain; worst: the largest value or bound") +
         bound_text(bound_rows(batch), bound_legend(batch));
}

}  // namespace imulab
