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
#include <functional>
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

/// Thermal terms about half way, drawn.
SensorModel drifts_of(std::uint64_t seed) {
  std::array<double, 12> drawn{};
  RandomStream(seed, "sweep").normals(0, drawn);
  SensorModel drifts;
  for (const bool gyro : {false, true})
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const double size = per_K[gyro ? 1 : 0], c1 = size * drawn[(gyro ? 6 : 0) + axis], c2 = size / 50 * drawn[(gyro ? 9 : 3) + axis];
      (gyro ? drifts.gyro : drifts.accel).thermal.row(static_cast<Eigen::Index>(axis)) << 0, c1, c2;
    }
  return drifts;
}

/// Adds the drift to readings without one, and a thermometer of first order that follows with this lag [s].
void add_drift(const SensorModel& drifts, const std::vector<double>& temperature, double lag_s, Recording& recording) {
  for (const Triad triad : {Triad::accel, Triad::gyro})
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const auto c = triad_model(drifts, triad).thermal.row(static_cast<Eigen::Index>(axis));
      std::vector<double>& readings = (triad == Triad::gyro ? recording.gyro : recording.accel)[axis];
      for (std::size_t i = 0; i < readings.size(); ++i) {
        const double tau = temperature[i] - half_way_K;
        readings[i] += (c(1) + c(2) * tau) * tau;
      }
    }
  std::vector<double> read;
  for (const double t : temperature) read.push_back(read.empty() || lag_s == 0 ? t : read.back() + (t - read.back()) * recording.interval_s / lag_s);
  recording.accel_temperature = recording.gyro_temperature = {read, read, read};
}

std::vector<double> warm_up(std::size_t n) {
  std::vector<double> out;
  for (std::size_t i = 0; i < n; ++i) out.push_back(range_K * (1 - std::exp(-times_constant * static_cast<double>(i) / static_cast<double>(n))));
  return out;
}

Sweep judged(const Calibration& c, const SensorModel& drifts) {
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

Session by_hand(const HandHeldOptions& options, std::uint64_t seed) {
  Session session = hand_held_procedure(options, seed);
  session.recordings[0].accel_temperature = session.recordings[0].gyro_temperature = ThermalSource{};
  return session;
}

/// Warmed up while it is turned by hand.
Sweep sweep_of(double lag_s, std::uint64_t seed) {
  HandHeldOptions options;
  options.rest = 12;
  Session session = by_hand(options, seed);
  Recording recording = simulate_recording(session, session.recordings.front(), draw_truth(session, seed), seed);
  session.steps.clear();
  const SensorModel drifts = drifts_of(seed);
  add_drift(drifts, warm_up(recording.size()), lag_s, recording);
  return judged(calibrate("handheld", input_of(session, recording)).calibration, drifts);
}

/// Turned by hand at one temperature, then warmed up in one attitude; or that alone.
Sweep attitude_of(bool alone, std::uint64_t seed) {
  HandHeldOptions still;
  still.poses = 1, still.first_rest = 1200;
  Session session = by_hand({}, seed), warming = by_hand(still, seed + 1000);
  const Truth truth = draw_truth(session, seed);
  warming.recordings[0].file = "warming.csv";
  std::vector<Recording> recordings{simulate_recording(session, session.recordings.front(), truth, seed),
                                    simulate_recording(warming, warming.recordings.front(), truth, seed + 1000)};
  session.recordings.push_back(warming.recordings.front());
  const SensorModel drifts = drifts_of(seed);
  add_drift(drifts, std::vector<double>(recordings[0].size(), half_way_K), 0, recordings[0]);
  add_drift(drifts, warm_up(recordings[1].size()), 10, recordings[1]);
  if (alone) recordings.erase(recordings.begin()), session.recordings.erase(session.recordings.begin());
  session.steps.clear();
  return judged(calibrate(alone ? "static" : "handheld", {session, recordings}).calibration, drifts);
}

/// A kind of warm-up with its limits.
struct SweepKind {
  std::string name;
  std::function<Sweep(std::uint64_t seed)> run;
  double most_rms, least_held, accel_u, gyro_u;
};

}  // namespace

std::vector<Check> sweeps(int sessions) {
  std::vector<Check> checks;
  // A thermometer of 20 s is late by more than a tenth of the warm-up's time constant, 190 s; terms of the second order then show. In one attitude,
  // a change of the vertical scale looks like one of the bias, and takes its share of a large one: the largest errors are those of the largest c1.
  const std::vector<SweepKind> kinds{{"0 s late", [](std::uint64_t seed) { return sweep_of(0, seed); }, 1.1, 0.93, 50, 10},
                                     {"10 s late", [](std::uint64_t seed) { return sweep_of(10, seed); }, 1.1, 0.93, 50, 10},
                                     {"20 s late", [](std::uint64_t seed) { return sweep_of(20, seed); }, 1.4, 0.88, 50, 10},
                                     {"one attitude, and by hand", [](std::uint64_t seed) { return attitude_of(false, seed); }, 1.3, 0.93, 100, 10},
                                     {"one attitude alone", [](std::uint64_t seed) { return attitude_of(true, seed); }, 1.1, 0.93, 100, 10}};
  for (const SweepKind& kind : kinds)
    by_part([&] {
      const auto runs = runs_of<Sweep>("sweeps " + kind.name, sessions, [&](std::size_t i) { return kind.run(1 + i); });
      double good = 0, held = 0;
      std::array<double, 4> squares{};
      std::array<std::vector<double>, 2> u;
      for (const Sweep& run : runs) {
        good += run.good, held += run.held;
        for (std::size_t k = 0; k < 4; ++k) squares[k] += run.squares[k] / sessions;
        for (std::size_t t = 0; t < 2; ++t) u[t].push_back(run.u[t]);
      }
      const std::string name = kind.name + ": ";
      checks.push_back({name + "good", good / sessions, 0.95, 1});
      checks.push_back({name + "95 % intervals hold", held / sessions, kind.least_held, 1});
      for (std::size_t k = 0; k < 4; ++k)
        checks.push_back({fmt::format("{}RMS of the errors of {} c{} over u", name, k < 2 ? "accelerometer" : "gyro", 1 + k % 2),
                          std::sqrt(squares[k]), 0.1, kind.most_rms});
      checks.push_back({name + "u of c1 [ug/K]", median(u[0]) / unit::ug, 0, kind.accel_u});
      checks.push_back({name + "u of c1 [deg/h/K]", median(u[1]) / unit::deg_per_h, 0, kind.gyro_u});
    });
  return checks;
}

}  // namespace imulab::acceptance
