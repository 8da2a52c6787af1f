#include "imulab/estimate/hybrid/prediction.hpp"

#include "imulab/core/error.hpp"
#include "imulab/earth/earth.hpp"
#include "imulab/estimate/hybrid/iteration.hpp"
#include "imulab/estimate/hybrid/quality.hpp"
#include "imulab/estimate/kernel/input.hpp"
#include "imulab/model/frame.hpp"
#include "imulab/recording/declared_noise.hpp"
#include "imulab/recording/rests.hpp"
#include "imulab/rig/ideal_recording.hpp"

#include <fmt/core.h>

#include <algorithm>

namespace imulab::hybrid {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

namespace {

/// Throws Error for several recordings.
double rate_of(const Session& procedure) { return kernel::only_source(procedure).rate_hz.value_or(default_sample_rate); }

}  // namespace

constexpr const char* no_hold = ": no hold among the steps; expected at least one, since the method needs rests";

Plan plan_of(const Session& procedure, const std::vector<CoefficientIndex>& terms) {
  const std::string& file = procedure.file;
  if (procedure.steps.empty()) throw Error(file + no_hold);
  const double rate = rate_of(procedure);
  const NoiseModels noise = errors_at(file, [&] { return declared_noise(procedure.imu); });
  if (!(noise.accel.N > 0 && noise.gyro.N > 0))
    throw Error(file + ": a noise density of 0; expected densities above 0, since the uncertainties follow from them");
  return {procedure, errors_at(file, [&] { return place_of(procedure.site); }),
          in_place::noise_of(Vector3d::Constant(noise.gyro.N), Vector3d::Constant(noise.accel.N), noise, procedure.steps.back().end),
          terms_of(procedure, terms, Vector3d::Zero(), Vector3d::Zero(), 1 / rate), on_turntable(procedure)};
}

Prediction predict(const Plan& plan) {
  // Readings that follow the motion: the rate does not matter as long as a sample turns by little.
  // Lever arms show in the ramps of turns, as far as the session's rate resolves them: they take a fifth of a second.
  const double slowest = plan.terms.optional.contains(Group::lever_arm) ? std::clamp(rate_of(plan.procedure), 20.0, 100.0) : 20;
  const Recording recording = coarse_recording(plan.procedure, {earth_rate_enu(plan.place.latitude), plan.place.gravity}, slowest);
  const std::vector<Range> rests = in_place::still_parts(recording, rests_of(recording, plan.procedure).ranges);
  if (rests.empty()) throw Error(plan.procedure.file + no_hold);
  const Data data{recording, in_place::cut_into_blocks(recording, rests, plan.observe_motion).blocks, plan.place, plan.noise, SensorModel{},
                  plan.terms};
  const Iterate pass = repeated(data, first_iterate(data));
  const Errors errors = determined_errors(pass);

  Prediction out{prediction_of(calibration_of(data, pass)), pass.states, pass.pass.covariance, pose_at_end(plan.procedure.steps)};
  const MatrixXd jacobian = correction_jacobian(SensorModel{}, errors.coefficients, out.states);
  const Index n = out.states.constants();
  const MatrixXd by_undetermined = errors.covariance - out.covariance.topLeftCorner(n, n);
  VectorXd bound = out.sigma.cwiseAbs2();
  bound.head(jacobian.rows()) -= (jacobian * by_undetermined * jacobian.transpose()).diagonal();
  out.cramer_rao = bound.cwiseSqrt();
  std::vector<Index> open;
  for (const Index state : errors.undetermined)
    if (contains(errors.open, out.states.corrects(state))) open.push_back(state);
  out.remaining = out.covariance.diagonal()(open).cwiseSqrt();
  return out;
}

imulab::Prediction predict(const Session& procedure, const std::vector<CoefficientIndex>& terms) { return predict(plan_of(procedure, terms)); }

void expect_estimated(const std::vector<Requirement>& requirements, const Plan& plan) {
  for (const Requirement& r : requirements) {
    bool any = false;
    for (const CoefficientIndex index : r.coefficients) {
      any = any || !zero_by_frame(index);
      if (!plan.terms.wanted.empty() && !contains(plan.terms.wanted, index))
        throw Error(fmt::format("{}: {} is not among the terms to be estimated", r.selector, coefficient(index).name));
    }
    if (!any)
      throw Error(
          fmt::format("{}: it is zero in the accelerometers' frame, which the method calibrates in: their matrix is lower triangular", r.selector));
  }
}

}  // namespace imulab::hybrid
