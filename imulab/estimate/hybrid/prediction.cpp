#include "imulab/estimate/hybrid/prediction.hpp"

#include "imulab/core/error.hpp"
#include "imulab/earth/earth.hpp"
#include "imulab/estimate/hybrid/iteration.hpp"
#include "imulab/model/grade.hpp"
#include "imulab/recording/declared_noise.hpp"
#include "imulab/recording/rests.hpp"
#include "imulab/rig/ideal_recording.hpp"
#include "imulab/rig/motion.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>

namespace imulab::hybrid {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

namespace {

/// Readings that follow the motion: the rate does not matter as long as a sample turns by little.
Recording readings_of(const Plan& plan) {
  constexpr double slowest = 20, fastest = 320, turned = 0.05;  // Hz, Hz, rad
  const std::vector<RecordingSource>& declared = plan.procedure.recordings;
  RecordingSource source;
  if (!declared.empty()) source.file = declared.front().file, source.rig = declared.front().rig;
  for (double rate = slowest;; rate *= 2) {
    source.rate_hz = rate;
    Recording recording = rig::ideal_recording(plan.procedure, source, {earth_rate_enu(plan.place.latitude), plan.place.gravity});
    double largest = 0;
    for (const std::vector<double>& column : recording.gyro)
      for (const double x : column) largest = std::max(largest, std::abs(x));
    if (largest * recording.interval_s < turned || rate >= fastest) return recording;
  }
}

/// Attitude and directions of the table's axes at the end of the procedure.
void add_end(const std::vector<Step>& steps, Prediction& out) {
  const RigMotion motion = rig_motion(steps);
  for (std::size_t a = 0; a < 3; ++a) {
    AxisStates states = axis_states(motion.pieces.back(), motion.end());
    for (AxisState& state : states) state.rate = 0;
    states[a].rate = 1;
    const BodyState turning = turntable_state(motion.axes, states);
    out.C_nb = turning.C_nb;
    out.axes[a] = turning.C_nb * turning.rate_nb_b;
  }
}

}  // namespace

Plan plan_of(const Session& procedure) {
  const std::string& file = procedure.file;
  if (procedure.recordings.size() > 1)
    throw Error(fmt::format("{}: {} recordings; expected a procedure with one", file, procedure.recordings.size()));
  const DeclaredNoise noise = errors_at(file, [&] { return declared_noise(procedure.imu); });
  if (!(noise.accel.N > 0 && noise.gyro.N > 0))
    throw Error(file + ": a noise density of 0; expected densities above 0, since the uncertainties follow from them");
  Plan plan{procedure, errors_at(file, [&] { return place_of(procedure.site); }), {}, {}, on_turntable(procedure)};
  plan.noise.gyro.setConstant(noise.gyro.N);
  plan.noise.accel.setConstant(noise.accel.N);
  plan.noise.gyro_walk.setConstant(noise.gyro.K);
  plan.noise.accel_walk.setConstant(noise.accel.K);
  plan.noise.velocity = noise.accel.Q;
  if (procedure.imu.grade && grade(*procedure.imu.grade).g_sensitivity > 0) plan.terms = {Group::g_sensitivity};
  return plan;
}

Prediction predict(const Plan& plan) {
  const Recording recording = readings_of(plan);
  const std::vector<Range> rests = still_parts(recording, rests_of(recording, plan.procedure).ranges);
  if (rests.empty()) throw Error(plan.procedure.file + ": no hold among the steps; expected at least one, since the method needs rests");
  const Data data{recording, cut_into_blocks(recording, rests, plan.observe_motion).blocks, plan.place, plan.noise, SensorModel{}, {}};
  const Iterate pass = repeated(data, first_iterate(data, plan.terms));
  const Errors errors = determined_errors(pass);

  Prediction out{{}, {}, pass.states, pass.pass.covariance, {}, {}};
  add_end(plan.procedure.steps, out);
  for (const Index s : pass.states.corrections()) {
    const bool open = std::find(errors.undetermined.begin(), errors.undetermined.end(), s) != errors.undetermined.end();
    (open ? out.undetermined : out.coefficients).push_back(pass.states.corrects(s));
  }
  const MatrixXd jacobian = correction_jacobian(SensorModel{}, out.coefficients, out.states);
  const Index n = out.states.constants();
  out.sigma = (jacobian * errors.covariance * jacobian.transpose()).diagonal().cwiseSqrt();
  out.cramer_rao = (jacobian * out.covariance.topLeftCorner(n, n) * jacobian.transpose()).diagonal().cwiseSqrt();
  out.remaining = out.covariance.diagonal()(errors.undetermined).cwiseSqrt();
  return out;
}

imulab::Prediction predict(const Session& procedure) { return predict(plan_of(procedure)); }

}  // namespace imulab::hybrid
