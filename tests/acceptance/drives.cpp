// The proof by a drive (Cheng 2014, sec 3.3): one IMU, calibrated by the classical method on a good table and on a poor one and by the hybrid method
// on the poor one; then an hour at 60 km/h after an alignment of 300 s, navigated with each, the same recording for all.
#include "imulab/estimate/turntable/turntable.hpp"
#include "imulab/navigate.hpp"
#include "imulab/navigation/motion/mission.hpp"
#include "imulab/simulate/simulate_motion.hpp"
#include "imulab/units.hpp"

#include <fmt/core.h>

#include "tests/acceptance/acceptance.hpp"
#include "tests/acceptance/shared_runs.hpp"
#include "tests/calibration_input.hpp"
#include "tests/hybrid_session.hpp"
#include <cmath>

namespace imulab::acceptance {

namespace {

constexpr double interval = 0.01, nmi_per_h = unit::nmi / unit::hour;
constexpr double good_table = 0.001 * unit::deg, poor_table = 60 * unit::arcsec;

/// Zhang's procedure with 17 s in each position: 31 min. The path takes 27.
Session classical_procedure() {
  TableProcedureOptions options;
  options.rest = 17;
  return zhang_24_procedure(options);
}

struct TableTime {
  Session session;
  Recording recording;
};

/// The IMU on a table whose errors are drawn.
TableTime on_table(Session session, double sigma, const SensorModel& unit, std::uint64_t seed) {
  session.imu.gyro_noise_density = 0.001 * unit::deg_per_sqrt_h;
  session.imu.accel_noise_density = 5 * unit::ug_per_sqrt_hz;
  RigDeclaration& rig = session.rigs.front();
  rig.angle.value = rig.orthogonality.value = rig.zero.value = sigma;
  const RecordingSource& source = session.recordings.front();
  const Truth truth = draw_truth(session, seed, unit);
  return {session, simulate_recording(session, source, truth, seed, draw_rig_errors(session, source, seed))};
}

/// With the noise that the drive's IMU has.
CityDrive drive() {
  CityDrive out = city_drive(interval);
  out.session.imu.gyro_noise_density = 0.001 * unit::deg_per_sqrt_h;
  out.session.imu.accel_noise_density = 5 * unit::ug_per_sqrt_hz;
  return out;
}

/// Pure-inertial rate [nmi/h].
double rate(const CityDrive& d, const Recording& recording, const Calibration& calibration) {
  NavigateOptions options;
  options.vertical = VerticalChannel::fixed;
  options.align = true;
  return navigation_errors(navigate(calibration, d.session, recording, options).solution, d.truth).rate / nmi_per_h;
}

}  // namespace

std::vector<DriveRun> drives(int runs) {
  const CityDrive d = drive();
  return runs_of<DriveRun>("drives", runs, [&](std::size_t k) {
    const std::uint64_t seed = k + 1;
    const SensorModel unit = hybrid_unit(seed);
    const TableTime good = on_table(classical_procedure(), good_table, unit, seed),
                    poor = on_table(classical_procedure(), poor_table, unit, seed + 1000000),
                    path = on_table(hybrid_procedure(65.5, 100), poor_table, unit, seed + 2000000);
    Truth on_the_road;
    on_the_road.model = unit;
    on_the_road.gyro_noise.N = 0.001 * unit::deg_per_sqrt_h;
    on_the_road.accel_noise.N = 5 * unit::ug_per_sqrt_hz;
    const Recording recording = simulate_motion(d.increments, interval, on_the_road, seed);
    Calibration exact;
    exact.model = unit;
    exact.covariance.resize(0, 0);
    CalibrationOptions as_zhang;
    as_zhang.effects = false;
    as_zhang.turntable.bias_while_turning = true;  // the gyros' offset is that of the positions
    return DriveRun{rate(d, recording, turntable::calibrate(input_of(good.session, good.recording), as_zhang).calibration),
                    rate(d, recording, turntable::calibrate(input_of(poor.session, poor.recording), as_zhang).calibration),
                    rate(d, recording, hybrid::calibrate(input_of(path.session, path.recording)).calibration), rate(d, recording, exact)};
  });
}

std::string describe(const std::vector<DriveRun>& runs) {
  std::string text =
      fmt::format("  {:<8} {:>22} {:>22} {:>18} {:>14}\n", "nmi/h", "classical, 0.001 deg", "classical, 1 arcmin", "hybrid, 1 arcmin", "exact");
  DriveRun square{};
  const auto row = [&](const std::string& name, const DriveRun& r) {
    text += fmt::format("  {:<8} {:>22.3f} {:>22.3f} {:>18.3f} {:>14.3f}\n", name, r.classical_good, r.classical_poor, r.hybrid, r.exact);
  };
  for (std::size_t k = 0; k < runs.size(); ++k) {
    const DriveRun& r = runs[k];
    if (k < 7) row(fmt::format("drive {}", k + 1), r);
    square.classical_good += r.classical_good * r.classical_good;
    square.classical_poor += r.classical_poor * r.classical_poor;
    square.hybrid += r.hybrid * r.hybrid;
    square.exact += r.exact * r.exact;
  }
  const auto rms = [&](double sum) { return std::sqrt(sum / static_cast<double>(runs.size())); };
  row("RMS", {rms(square.classical_good), rms(square.classical_poor), rms(square.hybrid), rms(square.exact)});
  return text;
}

}  // namespace imulab::acceptance
