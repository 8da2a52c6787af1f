// The noise of a bound for a Kalman filter of one's own, at the rate of the readings: each axis has the states of its biases, b' = F b + w, and a
// reading has the white noise of its own. F, Q and the start covariance are diagonal.
#include "imulab/error.hpp"
#include "imulab/export/noise_values.hpp"
#include "imulab/export/targets.hpp"
#include "imulab/export/write.hpp"

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include <cmath>
#include <sstream>
#include <utility>

namespace imulab::export_io {

namespace {

using FilterJson = nlohmann::ordered_json;

/// A bias state: over one interval b' = F b + w with the variance Q of w, and the variance P0 at the start.
struct FilterState {
  int axis = 0;       // gyro x, y, z, then accelerometers
  double time_s = 0;  // of a process; 0: walk
  double F = 1, Q = 0, P0 = 0;
};

struct FilterNoise {
  double rate_hz = 0;
  std::vector<FilterState> states;
  std::array<double, 6> R{};  // variance of the white noise of a reading; negative: unknown
  Sentences facts;
};

void add_axis(FilterNoise& out, int axis, const NoiseBound& bound) {
  const double T = 1 / out.rate_hz;
  out.R[static_cast<std::size_t>(axis)] = bound.N * bound.N / T;
  out.states.push_back({axis, 0, 1, bound.K * bound.K * T, bound.start_sigma * bound.start_sigma});
  for (const BoundProcess& p : bound.markov) {
    const double variance = p.sigma * p.sigma;
    out.states.push_back({axis, p.time, std::exp(-T / p.time), -variance * std::expm1(-2 * T / p.time), variance});
  }
}

ExportInput bounded(ExportInput input) {
  input.options.bound = true;
  return input;
}

FilterNoise filter_noise(const ExportInput& input) {
  const NoiseValues values = noise_values_by_axis(bounded(input), "A filter");
  FilterNoise out{.rate_hz = values.rate_hz(), .states = {}, .R = {}, .facts = {}};
  out.R.fill(-1);
  for (int axis = 0; axis < 6; ++axis) {
    const auto& noise = (axis < 3 ? input.noise->gyro : input.noise->accel)[static_cast<std::size_t>(axis % 3)];
    if (noise) add_axis(out, axis, *noise->bound);
  }
  out.facts = {fmt::format("Holds: DISCRETE values at {:g} Hz, in rad/s and m/s^2. b' = F b + w, Q = var w; R = variance of a reading's white noise.",
                           out.rate_hz),
               "States: of each axis a walk, then its Gauss-Markov processes. A reading is the motion, the sum of its states, and white noise.",
               "At no frequency is this noise below what the log permits. Add the variance of the bias at switch-on to P0 of each walk.",
               "Correct the readings with `imulab compensate` before."};
  for (const auto& [unit, value] : {std::pair(&input.noise->gyro_unit, &values.gyro_N), {&input.noise->accel_unit, &values.accel_N}})
    if (unit->empty()) out.facts.push_back("R = -1 is no variance: " + value->comment);
  out.facts.push_back(values.facts.front());
  return out;
}

constexpr std::array axis_names{"gyro.x", "gyro.y", "gyro.z", "accel.x", "accel.y", "accel.z"};

std::string array_text(const char* type, const char* name, const FilterNoise& noise, const auto& value_of, const char* what) {
  std::string out = fmt::format("static const {} {}[{}] = {{ /* {} */\n", type, name, noise.states.size(), what);
  for (const FilterState& state : noise.states)
    out += fmt::format("  {}, /* {} */\n", value_of(state), axis_names[static_cast<std::size_t>(state.axis)]);
  return out + "};\n";
}

}  // namespace

Sentences left_out_of_filter(const ExportInput& input) { return left_out_of_noise_files(bounded(input)); }

std::string filter_text(const ExportInput& input) {
  const FilterNoise noise = filter_noise(input);
  std::istringstream head(comment_head(input, "a Kalman filter", noise.facts, left_out_of_filter(input)));
  FilterJson about = FilterJson::array();
  for (std::string line; std::getline(head, line);)
    if (line.size() > 2) about.push_back(line.substr(2));  // without its mark
  FilterJson out{{"about", about}, {"rate_hz", noise.rate_hz}};
  FilterJson states = FilterJson::array(), F = states, Q = states, P0 = states;
  for (const FilterState& state : noise.states) {
    FilterJson one{{"axis", axis_names[static_cast<std::size_t>(state.axis)]}, {"kind", state.time_s > 0 ? "process" : "walk"}};
    if (state.time_s > 0) one["time_s"] = state.time_s;
    states.push_back(one), F.push_back(state.F), Q.push_back(state.Q), P0.push_back(state.P0);
  }
  out["states"] = states, out["F"] = F, out["Q"] = Q, out["P0"] = P0, out["R"] = noise.R;
  return out.dump(2) + "\n";
}

std::string filter_c_text(const ExportInput& input) {
  const FilterNoise noise = filter_noise(input);
  std::string out = in_comments("//", comment_head(input, "a Kalman filter in C", noise.facts, left_out_of_filter(input)));
  out += fmt::format("#ifndef IMULAB_FILTER_NOISE_H\n#define IMULAB_FILTER_NOISE_H\n\n#define IMULAB_FILTER_STATES {}\n\n", noise.states.size());
  const auto number = [](double FilterState::*member) { return [member](const FilterState& state) { return exact_number(state.*member); }; };
  out += array_text(
      "int", "imulab_filter_axis", noise, [](const FilterState& state) { return state.axis; }, "reading to which a state belongs");
  out += array_text("double", "imulab_filter_F", noise, number(&FilterState::F), "transition over one interval, diagonal");
  out += array_text("double", "imulab_filter_Q", noise, number(&FilterState::Q), "variance driven in one interval, diagonal");
  out += array_text("double", "imulab_filter_P0", noise, number(&FilterState::P0), "variance at the start, diagonal");
  out += "static const double imulab_filter_R[6] = { /* variance of the white noise of a reading */\n";
  for (std::size_t axis = 0; axis < 6; ++axis) out += fmt::format("  {}, /* {} */\n", exact_number(noise.R[axis]), axis_names[axis]);
  return out + "};\n\n#endif\n";
}

}  // namespace imulab::export_io
