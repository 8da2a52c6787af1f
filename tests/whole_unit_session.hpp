// For tests of whole-unit calibration: an IMU in the chamber, on the rate table and on the centrifuge of Dai's procedure.
#pragma once

#include "imulab/coefficient.hpp"
#include "imulab/estimate/whole_unit/whole_unit.hpp"
#include "imulab/model/effects.hpp"
#include "imulab/procedure.hpp"
#include "imulab/simulate.hpp"

#include <Eigen/Core>

#include <vector>

namespace imulab {

struct WholeUnitSession {
  Session session;
  Truth truth;
  std::vector<Recording> recordings;

  CalibrationInput input() const { return {session, recordings}; }
};

/// All that the data determine, significant or not; without effects, which Dai's model has not.
inline CalibrationOptions full_whole_unit(bool stepwise = false) {
  CalibrationOptions options;
  options.effects = false;
  options.whole_unit = {.full = true, .stepwise = stepwise};
  return options;
}

/// Points of `options.record` s; `change` may edit the session before it is simulated.
template <class Change>
WholeUnitSession whole_unit_session(std::uint64_t seed, const DaiUnitOptions& options, Change change) {
  WholeUnitSession s;
  s.session = dai_unit_procedure(options);
  change(s.session);
  s.truth = draw_truth(s.session, seed);
  for (const RecordingSource& source : s.session.recordings)
    s.recordings.push_back(simulate_recording(s.session, source, s.truth, seed, draw_rig_errors(s.session, source, seed)));
  return s;
}
/// Points of one second.
inline WholeUnitSession whole_unit_session(std::uint64_t seed) {
  DaiUnitOptions options;
  options.record = 1;
  return whole_unit_session(seed, options, [](Session&) {});
}

/// Estimate less truth of the estimated coefficients.
inline Eigen::VectorXd errors_of(const Calibration& c, const SensorModel& truth) {
  Eigen::VectorXd e(static_cast<Eigen::Index>(c.estimated.size()));
  for (std::size_t k = 0; k < c.estimated.size(); ++k)
    e[static_cast<Eigen::Index>(k)] = coefficient_value(c.model, c.estimated[k]) - coefficient_value(truth, c.estimated[k]);
  return e;
}

}  // namespace imulab
