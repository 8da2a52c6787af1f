// For tests of the hybrid method: an IMU on the path of Cheng's turns.
#pragma once

#include "imulab/coefficient.hpp"
#include "imulab/core/random.hpp"
#include "imulab/estimate/hybrid/hybrid.hpp"
#include "imulab/model/effects.hpp"
#include "imulab/procedure.hpp"
#include "imulab/recording/rests_of_view.hpp"
#include "imulab/rests.hpp"
#include "imulab/simulate.hpp"
#include "imulab/units.hpp"

#include "tests/calibration_input.hpp"

namespace imulab {

struct HybridSession {
  Session session;
  Truth truth;
  Recording recording;
  std::vector<Range> rests;
};

/// Scales of 300 ppm, misalignments of 5e-4, offsets of 300 ug and 0.1 deg/h, drawn; lever arms of `lever_arm` m.
inline SensorModel hybrid_unit(std::uint64_t seed, double lever_arm = 0) {
  const RandomStream draws(seed, "hybrid unit");
  std::uint64_t next = 0;
  const auto normal = [&] { return draws.normal(next++); };
  SensorModel model;
  for (int r = 0; r < 3; ++r) {
    model.accel.offset[r] = 300 * unit::ug * normal();
    model.gyro.offset[r] = 0.1 * unit::deg_per_h * normal();
    for (int c = 0; c < 3; ++c) {
      const double size = r == c ? 300 * unit::ppm : 5e-4, accel = size * normal();
      if (c <= r) model.accel.matrix(r, c) += accel;
      model.gyro.matrix(r, c) += size * normal();
      model.lever_arm(r, c) = lever_arm * normal();
    }
  }
  return model;
}

/// The path with `rest` s between its turns, on a table of 1 arcmin, by an IMU of 0.001 deg/sqrt(h) and 5 ug/sqrt(Hz).
inline Session hybrid_procedure(double rest, double rate_hz) {
  TableProcedureOptions options;
  options.rest = rest;
  options.rate_hz = rate_hz;
  Session session = cheng_path_procedure(options);
  RigDeclaration& rig = session.rigs.front();
  rig.angle.value = rig.orthogonality.value = rig.zero.value = 60 * unit::arcsec;
  session.imu.gyro_noise_density = 0.001 * unit::deg_per_sqrt_h;
  session.imu.accel_noise_density = 5 * unit::ug_per_sqrt_hz;
  return session;
}

/// At 20 Hz with rests of 15 s; `change` may edit the session before it is simulated.
template <class Change>
HybridSession hybrid_session(std::uint64_t seed, Change change, const SensorModel& unit) {
  HybridSession s;
  s.session = hybrid_procedure(15, 20);
  change(s.session);
  s.truth = draw_truth(s.session, seed, unit);
  const RecordingSource& source = s.session.recordings.front();
  s.recording = simulate_recording(s.session, source, s.truth, seed, draw_rig_errors(s.session, source, seed));
  s.rests = rests_of(s.recording, s.session).ranges;
  return s;
}
template <class Change>
HybridSession hybrid_session(std::uint64_t seed, Change change) {
  return hybrid_session(seed, change, hybrid_unit(seed));
}
inline HybridSession hybrid_session(std::uint64_t seed) {
  return hybrid_session(seed, [](Session&) {});
}

inline CalibrationResult calibrated(const HybridSession& s, const CalibrationOptions& options = {}) {
  return hybrid::calibrate(input_of(s.session, s.recording, s.rests), options);
}

/// Cheng's 21 coefficients, with the g-sensitivity if requested; without effects, which his model has not.
inline CalibrationOptions base_terms(bool g_sensitivity = false) {
  CalibrationOptions options;
  options.effects = false;
  for (const char* selector : {"accel.offset", "accel.matrix", "gyro.offset", "gyro.matrix"})
    for (const CoefficientIndex index : select_coefficients(selector)) options.terms.push_back(index);
  if (g_sensitivity)
    for (const CoefficientIndex index : select_coefficients("gyro.g_sensitivity")) options.terms.push_back(index);
  return options;
}

}  // namespace imulab
