#include "imulab/analysis/hybrid_prediction.hpp"

#include "imulab/core/error.hpp"
#include "imulab/estimate/hybrid_blocks.hpp"
#include "imulab/estimate/hybrid_correction.hpp"
#include "imulab/estimate/hybrid_course.hpp"
#include "imulab/model/coefficient.hpp"
#include "imulab/model/grade.hpp"
#include "imulab/recording/rests.hpp"
#include "imulab/rig/motion.hpp"
#include "imulab/simulate/simulate.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>

namespace imulab {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

namespace {

void expect_noise(double density, const std::string& file, const char* triad) {
  if (density > 0) return;
  throw Error(fmt::format("{}: [imu] {}_noise_density: a density above 0 was expected: the uncertainties follow from it", file, triad));
}

/// The readings of an ideal unit at `rate_hz`, without noise, on an exact rig.
Recording ideal_recording(const HybridPlan& plan, double rate_hz) {
  RecordingSource source;
  source.file = plan.procedure.recordings.empty() ? "" : plan.procedure.recordings.front().file;
  if (!plan.procedure.recordings.empty()) source.rig = plan.procedure.recordings.front().rig;
  source.rate_hz = rate_hz;
  source.gyro.unit = "rad/s";
  source.accel.unit = "m/s^2";
  return simulate_recording(plan.procedure, source, {SensorModel{}, plan.site.gravity, plan.site.latitude, {}, {}}, 1);
}

/// Readings that follow the motion: the rate does not matter as long as a sample turns by little.
Recording ideal_recording(const HybridPlan& plan) {
  constexpr double slowest = 20, fastest = 320, turned = 0.05;  // Hz, Hz, rad
  double rate_hz = slowest;
  for (;; rate_hz *= 2) {
    Recording recording = ideal_recording(plan, rate_hz);
    double largest = 0;
    for (const std::vector<double>& rate : recording.gyro)
      for (const double x : rate) largest = std::max(largest, std::abs(x));
    if (largest * recording.interval_s < turned || rate_hz >= fastest) return recording;
  }
}

std::vector<Range> still_parts(const Recording& recording, const Session& procedure) {
  const auto margin = static_cast<std::size_t>(std::lround(hybrid_settling / recording.interval_s));
  std::vector<Range> rests = rests_of(recording, procedure).ranges;
  for (Range& rest : rests)
    if (rest.size() > 5 * margin) rest = {rest.begin + margin, rest.end - margin};
  return rests;
}

}  // namespace

HybridPlan hybrid_plan(const Session& procedure) {
  if (procedure.recordings.size() > 1) throw Error(procedure.file + ": [[recording]]: a procedure with one recording was expected");
  const Site& site = procedure.site;
  if (!site.latitude) throw Error(procedure.file + ": [site]: latitude_deg was expected: the Earth's rate is part of what the gyros read");
  const Truth unit = [&] {  // an ideal one; its noise is as a simulation has it
    try {
      return draw_truth(procedure, 1, SensorModel{});
    } catch (const Error& e) {
      throw Error(fmt::format("{}: {}", procedure.file, e.what()));
    }
  }();
  expect_noise(unit.accel_noise.N, procedure.file, "accel");
  expect_noise(unit.gyro_noise.N, procedure.file, "gyro");
  HybridPlan plan{procedure, {*site.latitude, site.gravity(), site.latitude_sigma.value_or(0), site.gravity_sigma()}, {}, {}};
  plan.noise.gyro.setConstant(unit.gyro_noise.N);
  plan.noise.accel.setConstant(unit.accel_noise.N);
  plan.noise.gyro_walk.setConstant(unit.gyro_noise.K);
  plan.noise.accel_walk.setConstant(unit.accel_noise.K);
  plan.noise.velocity = unit.accel_noise.Q;
  plan.terms.g_sensitivity = procedure.imu.grade && grade(*procedure.imu.grade).g_sensitivity > 0;
  plan.observe_motion =
      std::any_of(procedure.rigs.begin(), procedure.rigs.end(), [](const RigDeclaration& r) { return r.kind == RigKind::turntable; });
  return plan;
}

HybridPrediction predict(const HybridPlan& plan) {
  const Recording recording = ideal_recording(plan);
  const std::vector<Range> rests = still_parts(recording, plan.procedure);
  if (rests.empty()) throw Error(plan.procedure.file + ": [[step]]: a hold was expected: the method needs rests");
  const HybridData data{recording, hybrid_blocks(recording, rests, plan.observe_motion).blocks, plan.site, plan.noise, SensorModel{}, {}};
  const HybridCourse course = repeated(data, begin_course(data, plan.terms));
  const HybridErrors errors = determined_errors(course);

  HybridPrediction out;
  out.layout = course.settings.layout;
  out.prior = course.prior;
  out.covariance = course.pass.covariance;
  const RigMotion motion = rig_motion(plan.procedure.steps);
  for (std::size_t a = 0; a < 3; ++a) {
    AxisStates states = axis_states(motion.pieces.back(), motion.end());
    for (AxisState& state : states) state.rate = 0;
    states[a].rate = 1;
    const BodyState turning = turntable_state(motion.axes, states);
    out.C_nb = turning.C_nb;
    out.axes[a] = turning.C_nb * turning.rate_nb_b;
  }
  const std::vector<int> of_state = corrected_coefficients(out.layout);
  std::vector<double> remaining;
  for (Index s = 0; s < out.layout.constants; ++s) {
    const int index = of_state[static_cast<std::size_t>(s)];
    if (index < 0) continue;
    const bool open = std::find(errors.undetermined.begin(), errors.undetermined.end(), s) != errors.undetermined.end();
    (open ? out.undetermined : out.coefficients).push_back(index);
    if (open) remaining.push_back(std::sqrt(out.covariance(s, s)));
  }
  const MatrixXd jacobian = correction_jacobian(SensorModel{}, out.coefficients, out.layout);
  out.sigma = (jacobian * errors.covariance * jacobian.transpose()).diagonal().cwiseSqrt();
  const Index n = out.layout.constants;
  out.cramer_rao = (jacobian * out.covariance.topLeftCorner(n, n) * jacobian.transpose()).diagonal().cwiseSqrt();
  out.remaining = Eigen::Map<const VectorXd>(remaining.data(), static_cast<Index>(remaining.size()));
  return out;
}

}  // namespace imulab
