#include "imulab/error.hpp"
#include "imulab/grade.hpp"
#include "imulab/noise.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <sstream>
#include <utility>

namespace imulab {

NoiseModelTerms parse_noise_terms(std::string_view text) {
  NoiseModelTerms out;
  bool white = false;
  std::string rest(text);
  std::replace(rest.begin(), rest.end(), ',', ' ');
  std::istringstream names(rest);
  for (std::string name; names >> name;) {
    bool* const term = name == "N" ? &white : name == "Q" ? &out.Q : name == "B" ? &out.B : name == "K" ? &out.K : nullptr;
    const bool process = name == fmt::format("M{}", out.processes + 1) && out.processes < 2;
    if (process) ++out.processes;
    if (term != nullptr ? std::exchange(*term, true) : !process)
      throw Error(fmt::format("\"{}\" in \"{}\"; expected each of N, Q, B, K once, and for processes M1, or M1, M2: \"N, B, K\"", name, text));
  }
  if (!white) throw Error(fmt::format("\"{}\" has no white noise; expected N and other terms: \"N, B, K\"", text));
  return out;
}

std::string to_string(const NoiseModelTerms& terms) {
  std::string out = "N";
  for (const auto& [has, name] :
       {std::pair(terms.Q, ", Q"), {terms.B, ", B"}, {terms.K, ", K"}, {terms.processes > 0, ", M1"}, {terms.processes > 1, ", M2"}})
    if (has) out += name;
  return out;
}

AllanTerms allan_variance(const NoiseCoefficients& noise, double tau_s) {
  const auto square = [](const NoiseCoefficient& c) { return c.determined ? c.value * c.value : 0; };
  AllanTerms out;
  out.Q = 3 * square(noise.Q) / (tau_s * tau_s);
  out.N = square(noise.N) / tau_s;
  out.B = 2 * std::numbers::ln2 / std::numbers::pi * square(noise.B);
  out.K = square(noise.K) * tau_s / 3;
  out.R = square(noise.R) * tau_s * tau_s / 2;
  for (const MarkovTerm& term : noise.markov) {
    // 2 sigma^2 t / tau (1 - t / (2 tau) (3 - 4 exp(-x) + exp(-2 x))), x = tau / t; as a series if rounding would dominate.
    const double x = tau_s / term.time.value;
    const double bracket = x > 1e-3 ? 1 - (3 - 4 * std::exp(-x) + std::exp(-2 * x)) / (2 * x) : x * x / 3;
    out.markov += 2 * square(term.sigma) / x * bracket;
  }
  return out;
}

namespace {

using Axes = std::array<std::optional<NoiseCoefficients>, 3>;

double root_mean_square(const Axes& axes, NoiseCoefficient NoiseCoefficients::*term) {
  double sum = 0, count = 0;
  for (const auto& axis : axes)
    if (axis && ((*axis).*term).determined) sum += std::pow(((*axis).*term).value, 2), ++count;
  return count > 0 ? std::sqrt(sum / count) : 0;
}

NoiseModel sizes_of(const Axes& axes, const std::string& unit, const std::string& triad) {
  if (unit == "count") throw Error(triad + " are in counts; expected a log in physical units (counts_per_unit in its session)");
  NoiseModel out;
  out.N = root_mean_square(axes, &NoiseCoefficients::N);
  if (out.N == 0) throw Error("N of the " + triad + " is not determined; expected a longer log");
  out.Q = root_mean_square(axes, &NoiseCoefficients::Q);
  out.B = root_mean_square(axes, &NoiseCoefficients::B);
  out.K = root_mean_square(axes, &NoiseCoefficients::K);
  out.R = {root_mean_square(axes, &NoiseCoefficients::R)};
  return out;
}

}  // namespace

bool has_bounds(const ImuNoise& noise) {
  const auto bounded = [](const auto& axis) { return !axis || axis->bound; };
  return std::ranges::all_of(noise.gyro, bounded) && std::ranges::all_of(noise.accel, bounded);
}

NoiseModels noise_sizes(const ImuNoise& noise) {
  return {.gyro = sizes_of(noise.gyro, noise.gyro_unit, "gyros"), .accel = sizes_of(noise.accel, noise.accel_unit, "accelerometers")};
}

}  // namespace imulab
