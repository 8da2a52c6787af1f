#include "tests/acceptance/mems_unit.hpp"

#include "imulab/estimate/turntable.hpp"
#include "imulab/estimate/whole_unit.hpp"
#include "imulab/model/coefficient.hpp"
#include "imulab/rig/procedure.hpp"
#include "imulab/simulate/simulate.hpp"

namespace imulab::acceptance {

namespace {

Recording simulated(const Session& session, const RecordingSource& source, const Truth& truth, std::uint64_t seed) {
  return simulate_recording(session, source, truth, seed, draw_rig_errors(session, source, seed));
}

SensorModel traditional(const SensorModel& unit, std::uint64_t seed) {
  Session session = zhang_24_procedure({});
  session.imu.grade = "mems-30g";
  TurntableOptions options;
  for (const char* term : {"accel.offset", "accel.matrix", "gyro.offset", "gyro.matrix"})
    for (const int index : select_coefficients(term)) options.terms.push_back(index);
  return calibrate_turntable(simulated(session, session.recordings.front(), draw_truth(session, seed, unit), seed), session, options).model;
}

}  // namespace

CalibratedUnit calibrated_unit(std::uint64_t seed) {
  const Session session = dai_unit_procedure({});
  const Truth truth = draw_truth(session, seed);
  std::vector<Recording> recordings;
  for (const RecordingSource& source : session.recordings) recordings.push_back(simulated(session, source, truth, seed));
  return {truth.model, traditional(truth.model, seed), calibrate_whole_unit(recordings, session, {.full = true}).model};
}

}  // namespace imulab::acceptance
