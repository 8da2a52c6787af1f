#include "imulab/estimate/hybrid/prediction.hpp"

#include "imulab/core/error.hpp"
#include "imulab/earth/earth.hpp"
#include "imulab/estimate/hybrid/iteration.hpp"
#include "imulab/model/grade.hpp"
#include "imulab/recording/declared_noise.hpp"
#include "imulab/recording/rests.hpp"
#include "imulab/rig/ideal_recording.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>

namespace imulab::hybrid {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

constexpr const char* no_hold = ": no hold among the steps; expected at least one, since the method needs rests";

Plan plan_of(const Session& procedure) {
  const std::string& file = procedure.file;
  if (procedure.steps.empty()) throw Error(file + no_hold);
  if (procedure.recordings.size() > 1)
    throw Error(fmt::format("{}: {} recordings; expected a procedure with one", file, procedure.recordings.size()));
  const NoiseModels noise = errors_at(file, [&] { return declared_noise(procedure.imu); });
  if (!(noise.accel.N > 0 && noise.gyro.N > 0))
    throw Error(file + ": a noise density of 0; expected densities above 0, since the uncertainties follow from them");
  Plan plan{procedure,
            errors_at(file, [&] { return place_of(procedure.site); }),
            in_place::noise_of(Vector3d::Constant(noise.gyro.N), Vector3d::Constant(noise.accel.N), noise, procedure.steps.back().end),
            {},
            on_turntable(procedure)};
  if (procedure.imu.grade && grade(*procedure.imu.grade).g_sensitivity > 0) plan.terms = {Group::g_sensitivity};
  return plan;
}

Prediction predict(const Plan& plan) {
  // Readings that follow the motion: the rate does not matter as long as a sample turns by little.
  const Recording recording = rig::coarse_recording(plan.procedure, {earth_rate_enu(plan.place.latitude), plan.place.gravity});
  const std::vector<Range> rests = in_place::still_parts(recording, rests_of(recording, plan.procedure).ranges);
  if (rests.empty()) throw Error(plan.procedure.file + no_hold);
  const Data data{recording, in_place::cut_into_blocks(recording, rests, plan.observe_motion).blocks, plan.place, plan.noise, SensorModel{}, {}};
  const Iterate pass = repeated(data, first_iterate(data, plan.terms));
  const Errors errors = determined_errors(pass);

  Prediction out{{errors.coefficients, errors.open, {}, {}}, pass.states, pass.pass.covariance, pose_at_end(plan.procedure.steps)};
  const MatrixXd jacobian = correction_jacobian(SensorModel{}, out.coefficients, out.states);
  const Index n = out.states.constants();
  out.sigma = (jacobian * errors.covariance * jacobian.transpose()).diagonal().cwiseSqrt();
  out.cramer_rao = (jacobian * out.covariance.topLeftCorner(n, n) * jacobian.transpose()).diagonal().cwiseSqrt();
  out.remaining = out.covariance.diagonal()(errors.undetermined).cwiseSqrt();
  return out;
}

imulab::Prediction predict(const Session& procedure) { return predict(plan_of(procedure)); }

void expect_estimated(const std::vector<Requirement>& requirements, const Plan& plan) {
  for (const Requirement& r : requirements) {
    bool any = false;
    for (const CoefficientIndex index : r.coefficients) {
      const Coefficient& c = coefficient(index);
      any = any || c.triad == Triad::gyro || c.term != Term::matrix || c.column <= c.row;
      if (c.term == Term::g_sensitivity && !plan.terms.contains(Group::g_sensitivity))
        throw Error(
            fmt::format("{}: this IMU's calibration does not estimate it; g-sensitivity is that of a grade that has it, such as mems", r.selector));
    }
    if (!any)
      throw Error(
          fmt::format("{}: it is zero in the accelerometers' frame, which the method calibrates in: their matrix is lower triangular", r.selector));
  }
}

}  // namespace imulab::hybrid
