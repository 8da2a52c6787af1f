// Thermal terms from a warm-up by hand, with thermometers that are on time or late: the figures of docs/theory/handheld.md.
#include "imulab/core/random.hpp"
#include "imulab/core/statistics.hpp"
#include "imulab/procedure.hpp"
#include "imulab/recording/rests_of_view.hpp"
#include "imulab/rests.hpp"
#include "imulab/simulate.hpp"
#include "imulab/units.hpp"

#include <fmt/core.h>

#include "tests/acceptance/acceptance.hpp"
#include "tests/acceptance/shared_runs.hpp"
#include "tests/calibration_input.hpp"
#include <array>
#include <cmath>
#include <string>
#include <vector>

namespace imulab::acceptance {

namespace {

constexpr double range_K = 40, half_way_K = 20, times_constant = 3;  // 95 % of the way to the end temperature in the session
constexpr std::array per_K{200 * unit::ug, 40 * unit::deg_per_h};    // accelerometers, gyros: one sigma of c1, and of 50 K c2

struct Sweep {
  bool good = false;
  std::array<double, 2> u{};        ///< median of c1, accelerometers and gyros
  std::array<double, 4> squares{};  ///< mean of (error / u)^2 of c1, c2 of accelerometers, of gyros
  double held = 0;                  ///< share of the twelve intervals of 95 % that hold
  void fields(auto&& visit) { visit(good, u[0], u[1], squares[0], squares[1], squares[2], squares[3], held); }
};

/// The drift is added to readings without one, as a function of the temperature that a thermometer of first order follows with this lag [s].
Sweep sweep_of(double lag_s, std::uint64_t seed) {
  HandHeldOptions options;
  options.rest = 12;
  Session session = hand_held_procedure(options, seed);
  const Truth truth = draw_truth(session, seed);
  Recording recording = simulate_recording(session, session.recordings.front(), truth, seed);
  session.steps.clear();
  session.recordings[0].accel_temperature = session.recordings[0].gyro_temperature = ThermalSource{};
  std::vector<double> temperature, read;
  const auto n = static_cast<double>(recording.size());
  for (std::size_t i = 0; i < recording.size(); ++i) {
    temperature.push_back(range_K * (1 - std::exp(-times_constant * static_cast<double>(i) / n)));
    read.push_back(i == 0 || lag_s == 0 ? temperature.back() : read.back() + (temperature.back() - read.back()) * recording.interval_s / lag_s);
  }
  recording.accel_temperature = recording.gyro_temperature = {read, read, read};
  std::array<double, 12> drawn{};
  RandomStream(seed, "sweep").normals(0, drawn);
  SensorModel drifts;  // about half way
  for (const bool gyro : {false, true})
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const double size = per_K[gyro ? 1 : 0], c1 = size * drawn[(gyro ? 6 : 0) + axis], c2 = size / 50 * drawn[(gyro ? 9 : 3) + axis];
      (gyro ? drifts.gyro : drifts.accel).thermal.row(static_cast<Eigen::Index>(axis)) << 0, c1, c2;
      std::vector<double>& readings = (gyro ? recording.gyro : recording.accel)[axis];
      for (std::size_t i = 0; i < readings.size(); ++i) {
        const double tau = temperature[i] - half_way_K;
        readings[i] += (c1 + c2 * tau) * tau;
      }
    }
  const Calibration c = calibrate("handheld", input_of(session, recording)).calibration;
  Sweep out{.good = c.quality.verdict == Verdict::good};
  std::array<std::vector<double>, 2> u;
  for (const CoefficientIndex index : c.estimated) {
    const Coefficient& row = coefficient(index);
    if (row.term != Term::thermal) continue;
    const std::size_t triad = row.triad == Triad::accel ? 0 : 1;
    const TriadModel& drift = triad_model(drifts, row.triad);
    const double c2 = drift.thermal(row.row, 2), to_mean = triad_model(c.model, row.triad).temperature->reference - half_way_K;
    const double expected = row.column == 1 ? drift.thermal(row.row, 1) + 2 * c2 * to_mean : c2, sigma = *standard_uncertainty(c, index);
    const double error = (coefficient_value(c.model, index) - expected) / sigma;
    out.squares[2 * triad + static_cast<std::size_t>(row.column - 1)] += error * error / 3;
    out.held += (std::abs(error) < normal_quantile(0.975) ? 1.0 : 0.0) / 12;
    if (row.column == 1) u[triad].push_back(sigma);
  }
  for (std::size_t triad = 0; triad < 2; ++triad)
    if (!u[triad].empty()) out.u[triad] = median(u[triad]);
  return out;
}

}  // namespace

std::vector<Check> sweeps(int sessions) {
  std::vector<Check> checks;
  // A thermometer of 20 s is late by more than a tenth of the warm-up's time constant, 190 s; terms of the second order then show.
  for (const auto& [lag_s, most_rms, least_held] : {std::array{0.0, 1.1, 0.93}, {10.0, 1.1, 0.93}, {20.0, 1.4, 0.88}})
    by_part([&, lag = lag_s, most = most_rms, least = least_held] {
      const auto runs = runs_of<Sweep>(fmt::format("sweeps {:g}", lag), sessions, [&](std::size_t i) { return sweep_of(lag, 1 + i); });
      double good = 0, held = 0;
      std::array<double, 4> squares{};
      std::array<std::vector<double>, 2> u;
      for (const Sweep& run : runs) {
        good += run.good, held += run.held;
        for (std::size_t k = 0; k < 4; ++k) squares[k] += run.squares[k] / sessions;
        for (std::size_t t = 0; t < 2; ++t) u[t].push_back(run.u[t]);
      }
      const std::string name = fmt::format("{:g} s late: ", lag);
      checks.push_back({name + "good", good / sessions, 0.95, 1});
      checks.push_back({name + "95 % intervals hold", held / sessions, least, 1});
      for (std::size_t k = 0; k < 4; ++k)
        checks.push_back({fmt::format("{}RMS of the errors of {} c{} over u", name, k < 2 ? "accelerometer" : "gyro", 1 + k % 2),
                          std::sqrt(squares[k]), 0.1, most});
      checks.push_back({name + "u of c1 [ug/K]", median(u[0]) / unit::ug, 0, 50});
      checks.push_back({name + "u of c1 [deg/h/K]", median(u[1]) / unit::deg_per_h, 0, 10});
    });
  return checks;
}

}  // namespace imulab::acceptance
