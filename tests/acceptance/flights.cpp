// The proof by a flight (Dai 2011, sec 4.2): one MEMS IMU, its recording compensated in several ways, and a FOG IMU of table 4 on the same flight;
// all navigated without aiding from the exact start.
#include "imulab/core/random.hpp"
#include "imulab/core/statistics.hpp"
#include "imulab/formats/session/mission.hpp"
#include "imulab/navigate.hpp"
#include "imulab/simulate/simulate_motion.hpp"
#include "imulab/units.hpp"

#include <fmt/core.h>

#include "tests/acceptance/acceptance.hpp"
#include "tests/acceptance/mems_unit.hpp"
#include "tests/acceptance/shared_runs.hpp"
#include <array>
#include <cmath>
#include <limits>

namespace imulab::acceptance {

namespace {

using namespace motion;

constexpr std::array rows{"no compensation",
                          "traditional",
                          "whole-unit",
                          "exact coefficients",
                          "FOG",
                          "FOG, biases and noise alone",
                          "without thermal",
                          "without quadratic",
                          "without cubic",
                          "without g-sensitivity",
                          "without misalignment"};
enum Row { none, traditional, whole, exact, fog, fog_biases, first_without };

struct Flight {
  double interval = 0;
  std::vector<Increment> increments;
  UnitTemperature temperature;
  NoiseModel gyro_noise, accel_noise;  // of the MEMS IMU
  Session session;
  Solution truth;  // begin and end
};

Flight flight(bool roll) {
  MissionFile file = read_mission(IMULAB_SOURCE "/docs/evidence/papers/dai2011/flight.toml");
  Mission& mission = file.mission;
  if (!roll)
    for (Segment& s : mission.segments) std::erase_if(s.pulses, [](const Pulse& p) { return p.of == Pulse::Of::table; });
  const Trajectory motion = trajectory_of(mission);
  const double interval = 1 / mission.rate;
  Flight out{interval, ideal_increments(motion, interval), mission.temperature.value(), {}, {}, {}, truth(motion, interval, 1 << 30)};
  const ErrorSources sources = error_sources(file.errors.value());
  out.gyro_noise = sources.gyro_noise, out.accel_noise = sources.accel_noise;
  const NavigationState& from = out.truth.states.front();
  const EulerAngles angles = euler_angles(from.q_nb.toRotationMatrix());
  InitialState& start = out.session.initial.emplace();
  start.latitude = from.latitude, start.longitude = from.longitude, start.height = from.height;
  start.roll = angles.roll, start.pitch = angles.pitch, start.heading = angles.heading;
  return out;
}

/// End of the solution less end of the flight.
Vector3d end_error(const Flight& f, const Recording& recording, const SensorModel& model) {
  Calibration calibration;
  calibration.model = model;
  calibration.covariance.resize(0, 0);
  return navigation_errors(navigate(calibration, f.session, recording).solution, f.truth).history.back().position;
}

/// Table 4. Zero drift: one sigma of a bias. "Scale fit residual, 0.05 % of full scale": a scale error, uniform within that, so that the largest
/// possible one is 0.5 deg/s at 1000 deg/s and 15 mg at 30 g. The table gives no noise (here: tactical grade) and no misalignment (here: none).
Truth fog_unit(std::uint64_t seed, bool scale) {
  Truth unit;
  const RandomStream draws(seed, "fog scale");
  for (int axis = 0; scale && axis < 3; ++axis) {
    unit.model.gyro.matrix(axis, axis) += 5e-4 * (2 * draws.uniform(static_cast<std::uint64_t>(axis)) - 1);
    unit.model.accel.matrix(axis, axis) += 5e-4 * (2 * draws.uniform(static_cast<std::uint64_t>(axis) + 3) - 1);
  }
  unit.gyro_noise.N = 0.1 * unit::deg_per_sqrt_h;
  unit.gyro_noise.turn_on = {1 * unit::deg_per_h};
  unit.accel_noise.N = 100 * unit::ug_per_sqrt_hz;
  unit.accel_noise.turn_on = {100 * unit::ug};
  return unit;
}

/// The model with one group of its terms left out.
std::array<SensorModel, 5> without_groups(const SensorModel& model) {
  std::array<SensorModel, 5> out;
  out.fill(model);
  const auto both = [](SensorModel& m, auto change) { change(m.accel), change(m.gyro); };
  both(out[0], [](TriadModel& m) { m.thermal.setZero(); });
  both(out[1], [](TriadModel& m) { m.quadratic.setZero(); });
  both(out[2], [](TriadModel& m) { m.cubic.setZero(); });
  out[3].g_sensitivity.setZero();
  both(out[4], [](TriadModel& m) { m.matrix = Matrix3d(m.matrix.diagonal().asDiagonal()); });
  return out;
}

FlightRun flight_run(const Flight& f, const CalibratedUnit& unit, std::uint64_t seed) {
  Truth flown;
  flown.model = unit.truth, flown.gyro_noise = f.gyro_noise, flown.accel_noise = f.accel_noise;
  const Recording recording = simulate_motion(f.increments, f.interval, flown, seed, f.temperature);
  FlightRun out(rows.size());
  out[none] = end_error(f, recording, {});
  out[traditional] = end_error(f, recording, unit.traditional);
  out[whole] = end_error(f, recording, unit.whole);
  out[exact] = end_error(f, recording, unit.truth);
  for (const bool scale : {true, false})
    out[scale ? fog : fog_biases] = end_error(f, simulate_motion(f.increments, f.interval, fog_unit(seed, scale), seed + 1000000), {});
  std::size_t row = first_without;
  for (const SensorModel& model : without_groups(unit.whole)) out[row++] = end_error(f, recording, model);
  return out;
}

std::vector<double> column(const std::vector<FlightRun>& runs, std::size_t row, auto value) {
  std::vector<double> out;
  for (const FlightRun& run : runs) out.push_back(value(run[row]));
  return out;
}

double distance(const Vector3d& error) { return error.norm(); }

double rms(const std::vector<double>& values) {
  double square = 0;
  for (const double v : values) square += v * v;
  return std::sqrt(square / static_cast<double>(values.size()));
}

}  // namespace

DaiFlights dai_flights(int runs) {
  const Flight with_roll = flight(true), without_roll = flight(false);
  const auto both = runs_of<std::vector<FlightRun>>("dai-flight", runs, [&](std::size_t k) {
    const CalibratedUnit unit = calibrated_unit(k + 1);
    return std::vector{flight_run(with_roll, unit, k + 1), flight_run(without_roll, unit, k + 1)};
  });
  DaiFlights out;
  for (const auto& run : both) out.with_roll.push_back(run[0]), out.without_roll.push_back(run[1]);
  return out;
}

std::vector<Check> judge_flights(const std::vector<FlightRun>& runs) {
  const auto distance_of = [&](std::size_t row) { return median(column(runs, row, distance)); };
  return {{"traditional over whole-unit, distance", distance_of(traditional) / distance_of(whole), 10, std::numeric_limits<double>::infinity()},
          {"whole-unit over exact, distance", distance_of(whole) / distance_of(exact), 0.8, 1.25}};
}

std::string describe_flights(const std::vector<FlightRun>& runs) {
  const std::array axes{"east", "north", "up"};
  std::array<double, 3> fog_size{};
  for (std::size_t axis = 0; axis < 3; ++axis)
    fog_size[axis] = median(column(runs, fog, [&](const Vector3d& e) { return std::abs(e[static_cast<int>(axis)]); }));
  std::string text = fmt::format("  {:<28} {:>29}   {:>17}   {:>35}\n  {:<28}", "", "size, median, m", "over the FOG's", "distance, m", "");
  for (const char* axis : axes) text += fmt::format(" {:>9}", axis);
  text += "  ";
  for (const char* axis : {"E", "N", "U"}) text += fmt::format(" {:>5}", axis);
  text += fmt::format("   {:>8} {:>8} {:>17}\n", "median", "RMS", "5..95 %");
  for (std::size_t row = 0; row < rows.size(); ++row) {
    text += fmt::format("  {:<28}", rows[row]);
    std::string ratios;
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const double size = median(column(runs, row, [&](const Vector3d& e) { return std::abs(e[static_cast<int>(axis)]); }));
      text += fmt::format(" {:>9.0f}", size);
      ratios += fmt::format(" {:>5.3g}", size / fog_size[axis]);
    }
    const std::vector<double> distances = column(runs, row, distance);
    text += fmt::format("  {}   {:>8.0f} {:>8.0f} {:>17}\n", ratios, median(distances), rms(distances),
                        fmt::format("{:.0f}..{:.0f}", quantile(distances, 0.05), quantile(distances, 0.95)));
  }
  return text;
}

}  // namespace imulab::acceptance
