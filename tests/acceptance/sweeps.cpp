// Thermal terms from a warm-up by hand, with thermometers that are on time or late: the figures of docs/theory/handheld.md.
#include "imulab/compensate.hpp"
#include "imulab/core/random.hpp"
#include "imulab/core/statistics.hpp"
#include "imulab/procedure.hpp"
#include "imulab/recording/rests_of_view.hpp"
#include "imulab/rests.hpp"
#include "imulab/simulate.hpp"
#include "imulab/units.hpp"

#include <Eigen/LU>
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
constexpr std::array per_K{200 * unit::ug, 40 * unit::deg_per_h};    // accelerometers, gyros: one sigma of c1, 50 K c2 and (50 K)^2 c3
constexpr double scale_per_K = 100 * unit::ppm;                      // of M1 and 50 K M2; a tenth beside the diagonal
enum Kind { first, second, third, scale, misalignment, kind_count };
constexpr std::array<const char*, kind_count> kind_names{"c1", "c2", "c3", "scale over temperature", "misalignment over temperature"};

struct Sweep {
  bool good = false;
  std::array<double, 2> u{}, scale_u{};                     ///< median of c1 and of the scales over temperature, accelerometers and gyros
  std::array<std::array<double, kind_count>, 2> squares{};  ///< sum of (error / u)^2 of accelerometers, of gyros
  std::array<std::array<double, kind_count>, 2> stated{};   ///< number of coefficients
  double held = 0;                                          ///< number of the intervals of 95 % that hold
  double output_square = 0;                                 ///< mean of (error / u)^2 of compensated outputs at the ends of the range
  double square = 0, square_at_room = 0;                    ///< their mean squares, and those of a calibration without thermal terms
  void fields(auto&& visit) {
    visit(good, u[0], u[1], scale_u[0], scale_u[1], held, output_square, square, square_at_room);
    for (std::size_t t = 0; t < 2; ++t)
      for (std::size_t k = 0; k < kind_count; ++k) visit(squares[t][k], stated[t][k]);
  }
};

/// Thermal terms about half way, drawn, of an IMU that has these others.
SensorModel drifts_of(SensorModel unit, std::uint64_t seed) {
  const RandomStream stream(seed, "sweep");
  std::uint64_t place = 0;
  const auto drawn = [&] { return stream.normal(place++); };
  for (const bool gyro : {false, true}) {
    TriadModel& m = gyro ? unit.gyro : unit.accel;
    for (int i = 0; i < 3; ++i) {
      for (int order = 1; order <= 3; ++order) m.thermal(i, order) = per_K[gyro ? 1 : 0] / std::pow(50, order - 1) * drawn();
      for (int j = 0; j < (gyro ? 3 : i + 1); ++j) {
        const double size = i == j ? scale_per_K : scale_per_K / 10;
        m.matrix_thermal1(i, j) = size * drawn(), m.matrix_thermal2(i, j) = size / 50 * drawn();
      }
    }
  }
  return unit;
}

/// The reading at tau instead of the one without thermal terms. The output p without the change of the matrix is (I + M1 tau + M2 tau^2)^-1 times the
/// motion; nonlinear terms are neglected there.
Vector3d changed(const TriadModel& m, const Vector3d& reading, double tau) {
  const Vector3d output = m.offset + m.matrix * reading;
  const Matrix3d factor = Matrix3d::Identity() + tau * m.matrix_thermal1 + tau * tau * m.matrix_thermal2;
  const Vector3d drift = m.thermal.col(1) * tau + m.thermal.col(2) * (tau * tau) + m.thermal.col(3) * (tau * tau * tau);
  return reading + m.matrix.inverse() * (factor.inverse() * output - output) + drift;
}

/// Adds the change to readings without one, and a thermometer of first order that follows with this lag [s].
void add_drift(const SensorModel& drifts, const std::vector<double>& temperature, double lag_s, Recording& recording) {
  for (const bool gyro : {false, true}) {
    const TriadModel& m = gyro ? drifts.gyro : drifts.accel;
    Columns3& columns = gyro ? recording.gyro : recording.accel;
    for (std::size_t i = 0; i < columns[0].size(); ++i) {
      const Vector3d reading = changed(m, {columns[0][i], columns[1][i], columns[2][i]}, temperature[i] - half_way_K);
      for (int axis = 0; axis < 3; ++axis) columns[static_cast<std::size_t>(axis)][i] = reading[axis];
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

/// The coefficient of the truth at this reference [degC].
double true_value(const SensorModel& truth, const Coefficient& c, double reference) {
  const TriadModel& m = triad_model(truth, c.triad);
  const double e = reference - half_way_K;
  const int i = c.row;
  if (c.term == Term::thermal) {
    const double c2 = m.thermal(i, 2), c3 = m.thermal(i, 3);
    return c.column == 1 ? m.thermal(i, 1) + 2 * c2 * e + 3 * c3 * e * e : c.column == 2 ? c2 + 3 * c3 * e : c3;
  }
  const Matrix3d there = (Matrix3d::Identity() + e * m.matrix_thermal1 + e * e * m.matrix_thermal2).inverse();
  return c.term == Term::matrix_thermal1 ? ((m.matrix_thermal1 + 2 * e * m.matrix_thermal2) * there)(i, c.column)
                                         : (m.matrix_thermal2 * there)(i, c.column);
}

/// Compensated outputs at rest, each axis up and down, at both ends of the range.
void judge_outputs(const Calibration& c, const SensorModel& truth, Sweep& out) {
  SensorModel at_reference = truth, at_room = c.model;
  at_reference.accel.remove_temperature(), at_reference.gyro.remove_temperature();
  at_room.accel.remove_temperature(), at_room.gyro.remove_temperature();
  constexpr double outputs = 6 * 6 * 2;
  for (int attitude = 0; attitude < 6; ++attitude)
    for (const double tau : {-half_way_K, range_K * (1 - std::exp(-times_constant)) - half_way_K}) {
      Motion motion;
      motion.force[attitude / 2] = attitude % 2 == 0 ? unit::g : -unit::g;
      RawSample raw = decompensate(at_reference, motion);
      raw.accel = changed(truth.accel, raw.accel, tau), raw.gyro = changed(truth.gyro, raw.gyro, tau);
      const auto to_own = [&](const TriadModel& m) { return Vector3d(Vector3d::Constant(m.temperature->tau(tau + half_way_K))); };
      raw.accel_tau = to_own(c.model.accel), raw.gyro_tau = to_own(c.model.gyro);
      Eigen::Matrix<double, 6, 1> error, error_at_room;
      const Motion now = compensate(c.model, raw), before = compensate(at_room, raw);
      error << now.rate - motion.rate, now.force - motion.force;
      error_at_room << before.rate - motion.rate, before.force - motion.force;
      const Eigen::Matrix<double, 6, 1> variance = output_covariance(c, raw).diagonal();
      out.output_square += error.cwiseAbs2().cwiseQuotient(variance).sum() / outputs;
      // In units of what 1 K changes.
      const auto sum = [](const Eigen::Matrix<double, 6, 1>& e) {
        return std::pow(e.head<3>().norm() / per_K[1], 2) + std::pow(e.tail<3>().norm() / per_K[0], 2);
      };
      out.square += sum(error) / outputs, out.square_at_room += sum(error_at_room) / outputs;
    }
}

Sweep judged(const Calibration& c, const SensorModel& truth, bool whole) {
  Sweep out{.good = c.quality.verdict == Verdict::good};
  std::array<std::vector<double>, 2> u, scale_u;
  for (const CoefficientIndex index : c.estimated) {
    const Coefficient& row = coefficient(index);
    if (!is_thermal(row.term)) continue;
    const std::size_t triad = row.triad == Triad::accel ? 0 : 1;
    const double sigma = *standard_uncertainty(c, index);
    const double error = (coefficient_value(c.model, index) - true_value(truth, row, triad_model(c.model, row.triad).temperature->reference)) / sigma;
    const auto kind = static_cast<std::size_t>(row.term == Term::thermal ? row.column - 1 : row.row == row.column ? scale : misalignment);
    out.squares[triad][kind] += error * error, ++out.stated[triad][kind];
    out.held += std::abs(error) < normal_quantile(0.975) ? 1 : 0;
    if (kind == first) u[triad].push_back(sigma);
    if (row.term == Term::matrix_thermal1 && kind == scale) scale_u[triad].push_back(sigma);
  }
  for (std::size_t triad = 0; triad < 2; ++triad) {
    if (!u[triad].empty()) out.u[triad] = median(u[triad]);
    if (!scale_u[triad].empty()) out.scale_u[triad] = median(scale_u[triad]);
  }
  if (whole) judge_outputs(c, truth, out);
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
  const Truth truth = draw_truth(session, seed);
  Recording recording = simulate_recording(session, session.recordings.front(), truth, seed);
  session.steps.clear();
  const SensorModel drifts = drifts_of(truth.model, seed);
  add_drift(drifts, warm_up(recording.size()), lag_s, recording);
  return judged(calibrate("handheld", input_of(session, recording)).calibration, drifts, true);
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
  const SensorModel drifts = drifts_of(truth.model, seed);
  add_drift(drifts, std::vector<double>(recordings[0].size(), half_way_K), 0, recordings[0]);
  add_drift(drifts, warm_up(recordings[1].size()), 10, recordings[1]);
  if (alone) recordings.erase(recordings.begin()), session.recordings.erase(session.recordings.begin());
  session.steps.clear();
  return judged(calibrate(alone ? "static" : "handheld", {session, recordings}).calibration, drifts, !alone);
}

/// A kind of warm-up with its limits.
struct SweepKind {
  std::string name;
  std::function<Sweep(std::uint64_t seed)> run;
  double most_rms, most_rms_of_third;  ///< of c3
  double least_held, least_gain;
  double accel_u, gyro_u, accel_scale_u, gyro_scale_u;  ///< ug/K, deg/h/K, ppm/K
};

}  // namespace

std::vector<Check> sweeps(int sessions) {
  std::vector<Check> checks;
  // A thermometer of 20 s is late by more than a tenth of the warm-up's time constant, 190 s; terms of the second order then show, most in c3. In one
  // attitude, a change of the vertical scale looks like one of the bias, and takes its share of a large one: the largest errors are those of the
  // largest c1.
  const std::vector<SweepKind> kinds{
      {"0 s late", [](std::uint64_t seed) { return sweep_of(0, seed); }, 1.1, 1.1, 0.93, 8, 50, 10, 60, 70},
      {"10 s late", [](std::uint64_t seed) { return sweep_of(10, seed); }, 1.1, 1.3, 0.93, 7, 50, 10, 60, 70},
      {"20 s late", [](std::uint64_t seed) { return sweep_of(20, seed); }, 1.4, 1.5, 0.88, 6, 50, 10, 60, 70},
      {"one attitude, and by hand", [](std::uint64_t seed) { return attitude_of(false, seed); }, 1.3, 1.3, 0.93, 2, 100, 10, 200, 0},
      {"one attitude alone", [](std::uint64_t seed) { return attitude_of(true, seed); }, 1.1, 1.1, 0.93, 0, 100, 10, 200, 0}};
  for (const SweepKind& kind : kinds)
    by_part([&] {
      const auto runs = runs_of<Sweep>("sweeps " + kind.name, sessions, [&](std::size_t i) { return kind.run(1 + i); });
      double good = 0, held = 0, all = 0, output_square = 0, square = 0, square_at_room = 0;
      std::array<std::array<double, kind_count>, 2> squares{}, stated{};
      std::array<std::vector<double>, 2> u, scale_u;
      for (const Sweep& run : runs) {
        good += run.good, held += run.held, output_square += run.output_square / sessions;
        square += run.square, square_at_room += run.square_at_room;
        for (std::size_t t = 0; t < 2; ++t) {
          for (std::size_t k = 0; k < kind_count; ++k) squares[t][k] += run.squares[t][k], stated[t][k] += run.stated[t][k], all += run.stated[t][k];
          u[t].push_back(run.u[t]), scale_u[t].push_back(run.scale_u[t]);
        }
      }
      const std::string name = kind.name + ": ";
      checks.push_back({name + "good", good / sessions, 0.95, 1});
      checks.push_back({name + "95 % intervals hold", held / all, kind.least_held, 1});
      for (std::size_t t = 0; t < 2; ++t)
        for (std::size_t k = 0; k < kind_count; ++k)
          if (stated[t][k] > 0)
            checks.push_back({fmt::format("{}RMS of the errors of {} {} over u", name, t == 0 ? "accelerometer" : "gyro", kind_names[k]),
                              std::sqrt(squares[t][k] / stated[t][k]), 0.1, k == third ? kind.most_rms_of_third : kind.most_rms});
      if (square > 0) {
        checks.push_back({name + "RMS of compensated outputs at the ends of the range over u", std::sqrt(output_square), 0.1, kind.most_rms});
        checks.push_back({name + "times better than without thermal terms", std::sqrt(square_at_room / square), kind.least_gain, 1e6});
      }
      // One attitude says nothing of the gyros' scales, which are not stated.
      checks.push_back({name + "u of accelerometer scales [ppm/K]", median(scale_u[0]) / unit::ppm, 1, kind.accel_scale_u});
      checks.push_back({name + "u of gyro scales [ppm/K]", median(scale_u[1]) / unit::ppm, kind.gyro_scale_u > 0 ? 1.0 : 0.0, kind.gyro_scale_u});
      checks.push_back({name + "u of c1 [ug/K]", median(u[0]) / unit::ug, 0, kind.accel_u});
      checks.push_back({name + "u of c1 [deg/h/K]", median(u[1]) / unit::deg_per_h, 0, kind.gyro_u});
    });
  return checks;
}

}  // namespace imulab::acceptance
