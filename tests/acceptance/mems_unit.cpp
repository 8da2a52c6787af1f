#include "tests/acceptance/mems_unit.hpp"

#include "imulab/coefficient.hpp"
#include "imulab/estimate/turntable/turntable.hpp"
#include "imulab/estimate/whole_unit/whole_unit.hpp"
#include "imulab/model/effects.hpp"
#include "imulab/procedure.hpp"
#include "imulab/simulate.hpp"

#include "tests/calibration_input.hpp"

namespace imulab::acceptance {

namespace {

Recording simulated(const Session& session, const RecordingSource& source, const Truth& truth, std::uint64_t seed) {
  return simulate_recording(session, source, truth, seed, draw_rig_errors(session, source, seed));
}

SensorModel traditionally_calibrated(const SensorModel& unit, std::uint64_t seed) {
  Session session = zhang_24_procedure({});
  session.imu.grade = "mems-30g";
  CalibrationOptions options;
  options.effects = false;  // none are simulated
  for (const char* term : {"accel.offset", "accel.matrix", "gyro.offset", "gyro.matrix"})
    for (const CoefficientIndex index : select_coefficients(term)) options.terms.push_back(index);
  const Recording recording = simulated(session, session.recordings.front(), draw_truth(session, seed, unit), seed);
  return turntable::calibrate(input_of(session, recording), options).calibration.model;
}

}  // namespace

CalibratedUnit calibrated_unit(std::uint64_t seed) {
  const Session session = dai_unit_procedure({});
  const Truth truth = draw_truth(session, seed);
  std::vector<Recording> recordings;
  for (const RecordingSource& source : session.recordings) recordings.push_back(simulated(session, source, truth, seed));
  CalibrationOptions full;
  full.effects = false;  // none are simulated
  full.whole_unit.full = true;
  return {truth.model, traditionally_calibrated(truth.model, seed), whole_unit::calibrate({session, recordings}, full).calibration.model};
}

}  // namespace imulab::acceptance
