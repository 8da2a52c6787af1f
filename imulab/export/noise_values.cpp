#include "imulab/export/noise_values.hpp"

#include "imulab/core/error.hpp"
#include "imulab/export/write.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

namespace imulab::export_io {

namespace {

using NoiseAxes = std::array<std::optional<NoiseCoefficients>, 3>;

NoiseValue noise_value(const NoiseAxes& axes, NoiseCoefficient NoiseCoefficients::*which, const char* name, AxisChoice choice) {
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
    texts[i] = fmt::format("{}{:.4g}", c.determined ? "" : "<= ", value);
    sum += value;
    ++counted;
    out.value = std::max(out.value, value);
  }
  if (counted == 0) throw Error(fmt::format("noise: {} has no axis with noise; expected a log of readings that change", name));
  if (choice == AxisChoice::mean) out.value = sum / counted;
  out.comment = fmt::format("x {}, y {}, z {}", texts[0], texts[1], texts[2]);
  if (out.comment.find("<=") != std::string::npos) out.comment += "; <=: not determined, the upper bound (95 %) is written";
  return out;
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

}  // namespace

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

std::vector<std::string> noise_left_out(const ExportInput& input, bool holds_random_walk) {
  std::vector<std::string> out;
  if (input.noise == nullptr) return out;
  for (const bool accel : {true, false}) {
    const NoiseAxes& axes = accel ? input.noise->accel : input.noise->gyro;
    const char* const sensors = accel ? "accelerometers'" : "gyros'";
    for (const NoiseTerm& term : noise_terms()) {
      if (term.coefficient == &NoiseCoefficients::N || (holds_random_walk && term.coefficient == &NoiseCoefficients::K)) continue;
      const std::string values = term_values(axes, term.coefficient);
      if (!values.empty())
        out.push_back(fmt::format("noise: {} {}, {} [{}]: {}", sensors, term.name, term.what, accel ? term.accel_unit : term.gyro_unit, values));
    }
    const std::string processes = markov_values(axes, accel ? "m/s^2" : "rad/s");
    if (!processes.empty()) out.push_back(fmt::format("noise: {} Gauss-Markov processes: {}", sensors, processes));
  }
  return out;
}

NoiseValues noise_values(const ExportInput& input, const std::string& program) {
  if (input.noise == nullptr) throw Error(program + " needs the noise of the IMU; expected --noise noise.json, from `imulab noise -o noise.json`");
  const ImuNoise& n = *input.noise;
  if (n.accel_unit != "m/s^2" || n.gyro_unit != "rad/s") throw Error("noise: is in counts; expected m/s^2 and rad/s: a log in SI units");
  NoiseValues out;
  const AxisChoice choice = input.options.axes;
  out.accel_N = noise_value(n.accel, &NoiseCoefficients::N, "accelerometers' N", choice);
  out.accel_K = noise_value(n.accel, &NoiseCoefficients::K, "accelerometers' K", choice);
  out.gyro_N = noise_value(n.gyro, &NoiseCoefficients::N, "gyros' N", choice);
  out.gyro_K = noise_value(n.gyro, &NoiseCoefficients::K, "gyros' K", choice);
  out.rate_hz = input.options.rate_hz ? *input.options.rate_hz : n.interval_s > 0 ? 1 / n.interval_s : 0;
  if (!(std::isfinite(out.rate_hz) && out.rate_hz > 0)) throw Error("noise: has no sample interval; expected --rate HZ");
  if (!input.options.rate_hz) out.rate_hz = std::round(out.rate_hz * 1e6) / 1e6;  // 0.005 s is 200 Hz
  out.facts.push_back(fmt::format("Noise: fitted to a log at rest, \"{}\".", plain(n.recording)));
  out.facts.emplace_back(choice == AxisChoice::worst ? "One number stands for three axes: the worst."
                                                     : "One number stands for three axes: their mean.");
  return out;
}

std::string noise_line(const std::string& key, const NoiseValue& value, const char* unit) {
  return fmt::format("{}: {}  # {}; {}\n", key, exact_number(value.value), unit, value.comment);
}

}  // namespace imulab::export_io
