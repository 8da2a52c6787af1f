#include "imulab/export/noise_values.hpp"

#include "imulab/error.hpp"
#include "imulab/export/loss.hpp"
#include "imulab/export/targets.hpp"
#include "imulab/export/write.hpp"
#include "imulab/noise/bound.hpp"
#include "imulab/noise/data_sheet.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

namespace imulab::export_io {

namespace {

using NoiseAxes = std::array<std::optional<NoiseCoefficients>, 3>;

/// The meaning of "<=" in a comment.
const char* bound_meaning(const NoiseAxes& axes, bool from_data_sheet) {
  if (!from_data_sheet) return "; <=: not determined, the upper bound (95 %) is written";
  const bool assumed = std::ranges::any_of(axes, [](const auto& axis) { return axis && has_assumed_bounds(*axis); });
  return assumed ? "; <=: not in the data sheet, ASSUMED: the sheet has no bias instability"
                 : "; <=: not in the data sheet, bounded by what it states";
}

NoiseValue noise_value(const NoiseAxes& axes, NoiseCoefficient NoiseCoefficients::*which, const char* name, AxisChoice choice,
                       bool from_data_sheet = false) {
  NoiseValue out;
  double sum = 0;
  int counted = 0;
  std::array<std::string, 3> texts;
  for (std::size_t i = 0; i < 3; ++i) {
    out.axes[i] = std::numeric_limits<double>::quiet_NaN();
    texts[i] = "no noise";
    if (!axes[i]) continue;
    const NoiseCoefficient& c = (*axes[i]).*which;
    const double value = c.determined ? c.value : c.upper;
    if (!(std::isfinite(value) && value > 0))
      throw Error(
          fmt::format("noise: {} of axis {} has neither a value nor an upper bound above zero; expected a longer log at rest", name, "xyz"[i]));
    out.axes[i] = value;
    texts[i] = fmt::format("{}{:.4g}", c.determined && !c.bounded ? "" : "<= ", value);
    sum += value;
    ++counted;
    out.value = std::max(out.value, value);
  }
  if (counted == 0) throw Error(fmt::format("noise: {} has no axis with noise; expected a log of readings that change", name));
  if (choice == AxisChoice::mean) out.value = sum / counted;
  out.comment = fmt::format("x {}, y {}, z {}", texts[0], texts[1], texts[2]);
  if (out.comment.find("<=") != std::string::npos) out.comment += bound_meaning(axes, from_data_sheet);
  return out;
}

NoiseValue missing_value(bool gyro) {
  constexpr double none = std::numeric_limits<double>::quiet_NaN();
  return {.axes = {none, none, none}, .comment = gyro ? "the noise has no gyros" : "the noise has no accelerometers", .missing = true};
}

std::string term_values(const NoiseAxes& axes, NoiseCoefficient NoiseCoefficients::*which) {
  std::string text;
  bool any = false;
  for (std::size_t i = 0; i < 3; ++i) {
    const NoiseCoefficient* c = axes[i] ? &((*axes[i]).*which) : nullptr;
    any = any || (c != nullptr && c->determined);
    text += fmt::format("{}{} {}", i == 0 ? "" : ", ", "xyz"[i], c != nullptr && c->determined ? fmt::format("{:.4g}", c->value) : "not determined");
  }
  return any ? text : "";
}

std::string markov_values(const NoiseAxes& axes, const char* unit) {
  std::string text;
  for (std::size_t i = 0; i < 3; ++i) {
    if (!axes[i]) continue;
    for (const MarkovTerm& m : axes[i]->markov)
      if (m.sigma.determined && m.time.determined)
        text += fmt::format("{}{} {:.4g} {} with {:.4g} s", text.empty() ? "" : ", ", "xyz"[i], m.sigma.value, unit, m.time.value);
  }
  return text;
}

const char* choice_fact(AxisChoice choice) {
  return choice == AxisChoice::worst ? "One number stands for three axes: the worst." : "One number stands for three axes: their mean.";
}

std::optional<double> stream_rate(const ExportInput& input, double interval_s) {
  const double rate_hz = input.options.rate_hz ? *input.options.rate_hz : interval_s > 0 ? 1 / interval_s : 0;
  if (!(std::isfinite(rate_hz) && rate_hz > 0)) return std::nullopt;
  return input.options.rate_hz ? rate_hz : std::round(rate_hz * 1e6) / 1e6;  // 0.005 s is 200 Hz
}

/// Factors of motion are never used without being asked for; bounds contain the logs in motion.
std::string source_fact(const ImuNoise& n, bool bound) {
  const char* const in_motion = bound ? "" : " These are the values at rest: the factors of motion that noise.json also contains are NOT in them.";
  if (n.from_data_sheet)
    return "Noise: values of a DATA SHEET, not fitted to a log" + (n.recording.empty() ? "." : fmt::format(": \"{}\".", plain(n.recording))) +
           (n.has_moving ? in_motion : "");
  return n.recording.empty() ? "Noise: as given; no log is named to which it was fitted."
                             : fmt::format("Noise: fitted to a log at rest, \"{}\".{}", plain(n.recording), n.has_moving ? in_motion : "");
}

/// An axis whose readings do not change at rest has no noise.
NoiseAxes axes_at_rest(const Vector3d& densities, double factor) {
  NoiseAxes axes;
  for (std::size_t i = 0; i < 3; ++i)
    if (const double density = factor * densities[static_cast<Eigen::Index>(i)]; density > 0)
      axes[i].emplace().N = {density, NAN, density, density, true};
  return axes;
}

/// The random walk as it is written: nothing measured it.
NoiseValue assumed_value(const Vector3d& densities, const char* name, AxisChoice choice) {
  NoiseValue out = noise_value(axes_at_rest(densities, assumed_walk), &NoiseCoefficients::N, name, choice);
  out.comment = fmt::format("NOT MEASURED: assumed, {:g} /s times the white noise; {}", assumed_walk, out.comment);
  return out;
}

void inflate(NoiseValue& value, double factor) {
  value.value *= factor;
  for (double& axis : value.axes) axis *= factor;
  value.comment += fmt::format("; times {:g}", factor);
}

/// Multiplies by the factor of the options, if they have one; the last fact remains that of the axis.
void inflate(NoiseValues& values, const ExportOptions& options) {
  if (!options.inflate) return;
  for (NoiseValue* const value : {&values.accel_N, &values.accel_K, &values.gyro_N, &values.gyro_K}) inflate(*value, *options.inflate);
  values.facts.insert(values.facts.end() - 1,
                      fmt::format("The noise is MULTIPLIED by {:g}, as was asked: nothing measured this factor.", *options.inflate));
}

NoiseValues of_rests(const ExportInput& input, const RestNoise& rests) {
  NoiseValues out;
  const AxisChoice choice = input.options.axes;
  out.accel_N = noise_value(axes_at_rest(rests.accel, 1), &NoiseCoefficients::N, "accelerometers' N", choice);
  out.gyro_N = noise_value(axes_at_rest(rests.gyro, 1), &NoiseCoefficients::N, "gyros' N", choice);
  out.accel_K = assumed_value(rests.accel, "accelerometers' K", choice);
  out.gyro_K = assumed_value(rests.gyro, "gyros' K", choice);
  out.stream_rate_hz = stream_rate(input, rests.interval_s);
  out.facts.push_back(
      fmt::format("Noise: NO LOG OF IT WAS GIVEN. White noise is that of the calibration's {} rests, {:.0f} s in all.", rests.rests, rests.seconds));
  out.facts.emplace_back("Random walk and bias instability do not show in them, and are NOT MEASURED.");
  out.facts.emplace_back(choice_fact(choice));
  inflate(out, input.options);
  return out;
}

/// The consequences of a triad that the noise lacks, or of noise that is that of the calibration's rests. Empty where a log of both triads is given.
Sentences assumed_noise(const ExportInput& input, bool holds_random_walk) {
  if (const ImuNoise* n = input.noise; n != nullptr && (n->gyro_unit.empty() || n->accel_unit.empty()))
    return {fmt::format("the noise has no {0}: the file has no values of the {0}, and the program's own defaults count",
                        n->gyro_unit.empty() ? "gyros" : "accelerometers")};
  if (input.noise != nullptr || !input.calibration.rest_noise) return {};
  const std::string white =
      "no noise.json was given: the white noise is that of the calibration's rests, with the vibration of the place, if there was any; ";
  if (!holds_random_walk) return {white + "bias instability is not measured, and not in the file. `imulab noise` measures both from an hour at rest"};
  return {white +
          fmt::format("the random walk is not measured: {:g} /s times the white noise stands for it, so that a filter trusts a bias for {:.0f} s, "
                      "less than most units deserve. `imulab noise` measures both from hours at rest",
                      assumed_walk, std::sqrt(3.0) / assumed_walk)};
}

}  // namespace

Sentences warnings_of_walk(const ExportInput& input) { return assumed_noise(input, true); }
Sentences warnings_of_white(const ExportInput& input) { return assumed_noise(input, false); }

const std::array<NoiseTerm, 5>& noise_terms() {
  static constexpr std::array<NoiseTerm, 5> terms{
      NoiseTerm{"Q", &NoiseCoefficients::Q, "quantization", "m/s", "rad"},
      {"N", &NoiseCoefficients::N, "white noise", "m/s^2/sqrt(Hz)", "rad/s/sqrt(Hz)"},
      {"B", &NoiseCoefficients::B, "bias instability", "m/s^2", "rad/s"},
      {"K", &NoiseCoefficients::K, "random walk", "m/s^3/sqrt(Hz)", "rad/s^2/sqrt(Hz)"},
      {"R", &NoiseCoefficients::R, "ramp", "m/s^3", "rad/s^2"},
  };
  return terms;
}

std::vector<std::string> noise_left_out(const ExportInput& input, std::string_view held) {
  std::vector<std::string> out;
  if (input.noise == nullptr) return out;
  if (input.options.bound) held = "NBKR";  // a bound is above all terms that accumulate
  for (const bool accel : {true, false}) {
    const NoiseAxes& axes = accel ? input.noise->accel : input.noise->gyro;
    const char* const sensors = accel ? "accelerometers'" : "gyros'";
    for (const NoiseTerm& term : noise_terms()) {
      if (held.find(term.name) != std::string_view::npos) continue;
      const std::string values = term_values(axes, term.coefficient);
      if (!values.empty())
        out.push_back(fmt::format("noise: {} {}, {} [{}]: {}", sensors, term.name, term.what, accel ? term.accel_unit : term.gyro_unit, values));
    }
    if (input.options.bound) continue;
    const std::string processes = markov_values(axes, accel ? "m/s^2" : "rad/s");
    if (!processes.empty()) out.push_back(fmt::format("noise: {} Gauss-Markov processes: {}", sensors, processes));
  }
  return out;
}

namespace {

Sentences all_but_noise_left_out(const ExportInput& input, std::string_view held) {
  Sentences out = whole_calibration_left_out(input);
  const Sentences noise = noise_left_out(input, held);
  out.insert(out.end(), noise.begin(), noise.end());
  return out;
}

}  // namespace

Sentences left_out_of_noise_files(const ExportInput& input) { return all_but_noise_left_out(input, "NK"); }
Sentences left_out_of_ros(const ExportInput& input) { return all_but_noise_left_out(input, "N"); }
Sentences left_out_of_matlab(const ExportInput& input) { return all_but_noise_left_out(input, "NBK"); }

namespace {

/// The axes that have noise. Throws Error if one has no bound, or if the options do not suit bounds.
std::vector<NoiseCoefficients*> bounded_axes(ImuNoise& noise, const ExportOptions& options) {
  if (options.inflate) throw Error("--inflate: multiplies noise that is not a bound; expected it without --bound");
  if (options.axes == AxisChoice::mean) throw Error("--three-axes mean: a mean of bounds is none; expected --three-axes worst with --bound");
  std::vector<NoiseCoefficients*> out;
  for (auto* const triad : {&noise.gyro, &noise.accel})
    for (std::optional<NoiseCoefficients>& axis : *triad) {
      if (!axis) continue;
      if (!axis->bound) throw Error("noise: has no bound; expected a noise.json from `imulab noise LOG --bound -o noise.json`");
      out.push_back(&*axis);
    }
  return out;
}

/// Programs refuse a walk of zero. One that equals the white noise after ten horizons changes nothing.
void set_bound(NoiseCoefficients& axis, double N, double K) {
  const double walk = std::max(K, std::sqrt(3.0) * N / (10 * axis.bound->horizon_s));
  axis.N = {N, NAN, 0, N, true}, axis.K = {walk, NAN, 0, walk, true};
}

/// The tightest N and K above the spectra that the log permits.
ImuNoise with_bounds(ImuNoise noise, const ExportOptions& options) {
  for (NoiseCoefficients* const axis : bounded_axes(noise, options)) {
    const NoiseBound two = noise::tightest_bound(axis->bound->upper, noise.interval_s, {axis->bound->horizon_s, axis->bound->confidence}, 0);
    set_bound(*axis, two.N, two.K);
  }
  return noise;
}

/// The same of processes in place of walks; returns their time.
double bound_by_process(ImuNoise& noise, const ExportOptions& options, double usual_s) {
  const std::vector<NoiseCoefficients*> axes = bounded_axes(noise, options);
  std::vector<std::vector<UpperDensity>> upper;
  for (const NoiseCoefficients* const axis : axes) upper.push_back(axis->bound->upper);
  const auto common = noise::bounds_with_common_process(upper, noise.interval_s);
  if (!common) return usual_s;
  for (std::size_t i = 0; i < axes.size(); ++i) set_bound(*axes[i], common->N[i], common->sigma[i] * std::sqrt(2 / common->time));
  return common->time;
}

/// Facts of bounds, for the head of a file.
Sentences facts_of_bounds(const ImuNoise& noise) {
  const NoiseBound* any = nullptr;
  bool in_motion = false;
  for (const auto* const triad : {&noise.gyro, &noise.accel})
    for (const std::optional<NoiseCoefficients>& axis : *triad)
      if (axis) any = &*axis->bound, in_motion = in_motion || axis->bound->in_motion;
  if (any == nullptr) return {};
  return {fmt::format("N and K are BOUNDS: white noise and walk together are at no frequency below what the {} with {:g} %,",
                      in_motion ? "logs at rest and in motion permit" : "log permits", 100 * any->confidence),
          fmt::format("for filters that run up to {:g} s without aids. The bias at switch-on is not part of them.", any->horizon_s)};
}

}  // namespace

namespace {

void expect_noise_of_bound(const ExportInput& input) {
  if (input.options.bound && input.noise == nullptr) throw Error("--bound: expected --noise with a noise.json from `imulab noise LOG --bound`");
}

/// `n`: the log's, or its bounds.
NoiseValues values_of(const ExportInput& input, const ImuNoise& n) {
  const bool accel = !n.accel_unit.empty(), gyro = !n.gyro_unit.empty();
  if ((accel && n.accel_unit != "m/s^2") || (gyro && n.gyro_unit != "rad/s"))
    throw Error("noise: is in counts; expected m/s^2 and rad/s: a log in SI units");
  NoiseValues out;
  const AxisChoice choice = input.options.axes;
  out.accel_N = accel ? noise_value(n.accel, &NoiseCoefficients::N, "accelerometers' N", choice, n.from_data_sheet) : missing_value(false);
  out.accel_K = accel ? noise_value(n.accel, &NoiseCoefficients::K, "accelerometers' K", choice, n.from_data_sheet) : missing_value(false);
  out.gyro_N = gyro ? noise_value(n.gyro, &NoiseCoefficients::N, "gyros' N", choice, n.from_data_sheet) : missing_value(true);
  out.gyro_K = gyro ? noise_value(n.gyro, &NoiseCoefficients::K, "gyros' K", choice, n.from_data_sheet) : missing_value(true);
  out.stream_rate_hz = stream_rate(input, n.interval_s);
  out.facts.push_back(source_fact(n, input.options.bound));
  if (input.options.bound)
    for (std::string& fact : facts_of_bounds(n)) out.facts.push_back(std::move(fact));
  out.facts.emplace_back(choice_fact(choice));
  inflate(out, input.options);
  return out;
}

}  // namespace

NoiseValues noise_values(const ExportInput& input, const std::string& program) {
  expect_noise_of_bound(input);
  if (input.noise == nullptr && input.calibration.rest_noise) return of_rests(input, *input.calibration.rest_noise);
  if (input.noise == nullptr)
    throw Error(program +
                " needs the noise of the IMU, and this calibration has none of its rests; expected a noise.json, from `imulab noise "
                "-o noise.json`");
  return input.options.bound ? values_of(input, with_bounds(*input.noise, input.options)) : values_of(input, *input.noise);
}

ProcessValues noise_values_of_process(const ExportInput& input, const std::string& program, double usual_s) {
  expect_noise_of_bound(input);
  ProcessValues out{{}, usual_s};
  if (input.options.bound) {
    ImuNoise bounds = *input.noise;
    out.time_s = bound_by_process(bounds, input.options, usual_s);
    out.noise = values_of(input, bounds);
  } else {
    out.noise = noise_values(input, program);
  }
  out.noise.facts.pop_back();
  return out;
}

NoiseValues noise_values_by_axis(const ExportInput& input, const std::string& program) {
  NoiseValues out = noise_values(input, program);
  out.facts.pop_back();
  return out;
}

double NoiseValues::rate_hz() const {
  if (!stream_rate_hz)
    throw Error(
        "noise: has no sampling rate, and this target writes one; expected a rate: --stream-rate HZ, in Python rate_hz, or rate = 200 Hz among the "
        "values of "
        "the "
        "data sheet");
  return *stream_rate_hz;
}

NoiseValue bias_instability(const ExportInput& input, bool gyro) {
  if (input.noise == nullptr) return {.comment = "NOT MEASURED without a noise log"};
  const ImuNoise& n = *input.noise;
  if ((gyro ? n.gyro_unit : n.accel_unit).empty()) return missing_value(gyro);
  for (const auto& axis : gyro ? n.gyro : n.accel)
    if (const NoiseCoefficient* B = axis ? &axis->B : nullptr; B != nullptr && !B->determined && !(std::isfinite(B->upper) && B->upper > 0))
      return {.comment = "NOT MEASURED: the noise log has neither a value nor a bound"};
  NoiseValue out =
      noise_value(gyro ? n.gyro : n.accel, &NoiseCoefficients::B, gyro ? "gyros' B" : "accelerometers' B", input.options.axes, n.from_data_sheet);
  if (input.options.inflate) inflate(out, *input.options.inflate);
  return out;
}

std::array<double, 3> each_axis(const NoiseValue& value) {
  std::array<double, 3> out = value.axes;
  double largest = 0;
  for (const double axis : out)
    if (std::isfinite(axis)) largest = std::max(largest, axis);
  for (double& axis : out)
    if (!std::isfinite(axis)) axis = largest;
  return out;
}

std::string noise_head(const ExportInput& input, std::string_view program, Sentences facts, const NoiseValues& noise, std::string_view mark,
                       std::string_view held) {
  facts.insert(facts.end(), noise.facts.begin(), noise.facts.end());
  return in_comments(mark, comment_head(input, program, facts, all_but_noise_left_out(input, held)));
}

std::string triad_text(const NoiseValue& value, const std::string& text, std::string_view mark) {
  return value.missing ? fmt::format("{} NOT WRITTEN: {}\n", mark, value.comment) : text;
}

std::string noise_line(const std::string& key, const NoiseValue& value, const char* unit) {
  return triad_text(value, fmt::format("{}: {}  # {}; {}\n", key, exact_number(value.value), unit, value.comment), "# " + key);
}

std::string noise_line(const std::string& key, double number, const NoiseValue& densities, const char* unit, const char* density_unit) {
  return triad_text(densities, fmt::format("{}: {}  # {}; densities [{}]: {}\n", key, exact_number(number), unit, density_unit, densities.comment),
                    "# " + key);
}

}  // namespace imulab::export_io
