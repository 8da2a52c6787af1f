// The three machines of a whole-unit calibration (Dai 2011 section 3).
#include "imulab/error.hpp"
#include "imulab/procedure.hpp"
#include "imulab/recording.hpp"
#include "imulab/session.hpp"

#include <algorithm>
#include <array>
#include <cmath>

namespace imulab {

namespace {

constexpr double soak = 1800;                                // s, before each temperature
constexpr double rate_change = 10, remount = 60;             // s, to another rate of the table; to another mount or rate of the arm
constexpr double arm = 6.1;                                  // m: 30 g below 400 deg/s
constexpr double resonance = 5000, resonance_per_K = -0.15;  // Hz, Hz/K: a silicon resonator's -30 ppm/K

/// Positions of the accelerometers in the IMU, m from its center, which is at the arm's end: row i, accelerometer i.
constexpr double accel_place[3][3] = {{4e-3, -2e-3, 1e-3}, {-3e-3, 5e-3, 1e-3}, {1e-3, -1e-3, 6e-3}};

ThermalSource sensors(bool three, const std::string& name) {
  ThermalSource source;
  source.columns = {name};
  if (three) source.columns = {name + "x", name + "y", name + "z"};
  source.noise = 0.01;
  return source;
}

RecordingSource recording(const std::string& rig, const DaiUnitOptions& options) {
  RecordingSource source;
  source.file = rig + ".csv";
  source.rig = rig;
  source.rate_hz = options.rate_hz;
  source.extent = Extent::steps;
  source.time.column = std::string("t");
  source.gyro.columns = {"gx", "gy", "gz"};
  source.gyro.unit = "rad/s";
  source.accel.columns = {"ax", "ay", "az"};
  source.accel.unit = "m/s^2";
  source.gyro_temperature = sensors(options.thermal != ThermalSensors::one, "tg");
  source.accel_temperature = sensors(options.thermal != ThermalSensors::one, "ta");
  if (options.thermal == ThermalSensors::resonance) {
    ThermalSource& gyro = *source.gyro_temperature;
    gyro.unit = "raw", gyro.at_25_degC = resonance, gyro.per_K = resonance_per_K;
    gyro.noise *= std::abs(resonance_per_K);
  }
  return source;
}

/// Writes one machine's points, one after the other.
class Points {
 public:
  Points(Session& session, RigKind kind, const DaiUnitOptions& options) : session_(session), record_(options.record) {
    RigDeclaration rig;
    rig.name = to_string(kind), rig.kind = kind;
    rig.mount.value = 10 * unit::arcsec, rig.zero.value = 5 * unit::arcsec;
    if (kind == RigKind::chamber) {
      rig.ramp = 2.0 / 60, rig.time_constant = 300;
    } else {
      rig.rate.value = 10 * unit::ppm, rig.radius.value = 0.1e-3;
    }
    session_.rigs.push_back(rig);
    session_.recordings.push_back(recording(rig.name, options));
  }

  Step& add(StepKind kind, const Mount& mount, double move) {
    Step step;
    step.kind = kind, step.mount = mount;
    step.recording = session_.recordings.back().file;
    step.start = time_ + move;
    step.end = time_ = step.start + record_;
    return session_.steps.emplace_back(step);
  }

 private:
  Session& session_;
  double record_, time_ = 0;
};

void add_chamber(Session& session, const DaiUnitOptions& options) {
  Points points(session, RigKind::chamber, options);
  std::vector<double> temperatures;
  for (int t = 0; t <= 70; t += 5) temperatures.push_back(t);
  for (int t = 65; t >= 0 && options.both_ways; t -= 5) temperatures.push_back(t);
  for (std::size_t k = 0; k < temperatures.size(); ++k) points.add(StepKind::hold, {}, k == 0 ? 0 : soak).temperature = temperatures[k];
}

/// Six mounts: each face where `face` says, up or outward, the next axis where the other is.
std::array<Mount, 6> six_mounts(BodyAxis Mount::*face, BodyAxis Mount::*other) {
  std::array<Mount, 6> mounts;
  for (std::size_t k = 0; k < mounts.size(); ++k) {
    const int axis = static_cast<int>(k % 3);
    mounts[k].*face = {axis, k < 3 ? 1 : -1};
    mounts[k].*other = {(axis + 1) % 3, 1};
  }
  return mounts;
}

void add_rate_table(Session& session, const DaiUnitOptions& options) {
  Points points(session, RigKind::rate_table, options);
  for (const Mount& mount : six_mounts(&Mount::up, &Mount::outward))
    for (int rate = -400; rate <= 400; rate += 20) {
      Step& step = points.add(rate == 0 ? StepKind::hold : StepKind::spin, mount, rate == -400 ? remount : rate_change);
      step.rate = rate * unit::deg;
    }
}

void add_centrifuge(Session& session, const DaiUnitOptions& options) {
  Points points(session, RigKind::centrifuge, options);
  for (const Mount& mount : six_mounts(&Mount::outward, &Mount::up))
    for (int g = 0; g <= 30; g += 5) {
      const bool first = g == 0 && (session.steps.empty() || session.steps.back().recording != session.recordings.back().file);
      Step& step = points.add(g == 0 ? StepKind::hold : StepKind::spin, mount, first ? 0 : remount);
      if (g == 0) continue;
      step.rate = std::round(std::sqrt(g * unit::g / arm) / unit::deg * 100) / 100 * unit::deg;  // hundredths are easy to read in a file
      for (std::size_t i = 0; i < 3; ++i) step.radius[i] = std::round((arm + mount.outward.sign * accel_place[i][mount.outward.index]) * 1e4) / 1e4;
    }
}

}  // namespace

std::string_view to_string(ThermalSensors sensors) {
  return sensors == ThermalSensors::three ? "three" : sensors == ThermalSensors::one ? "one" : "resonance";
}

Session dai_unit_procedure(const DaiUnitOptions& options) {
  for (const double x : {options.record, options.rate_hz})
    if (!(x > 0 && std::isfinite(x))) throw Error("dai-unit: expected a duration of the points and a sampling rate above 0");
  Session session;
  session.imu.name = "dai-unit";
  session.imu.grade = options.grade;
  session.site.latitude = options.latitude;
  session.site.height = options.height;
  const auto has = [&](RigKind kind) { return std::ranges::find(options.machines, kind) != options.machines.end(); };
  if (has(RigKind::chamber)) add_chamber(session, options);
  if (has(RigKind::rate_table)) add_rate_table(session, options);
  if (has(RigKind::centrifuge)) add_centrifuge(session, options);
  if (session.steps.empty()) throw Error("dai-unit: no machine; expected chamber, rate_table or centrifuge");
  validate(session);
  return session;
}

}  // namespace imulab
