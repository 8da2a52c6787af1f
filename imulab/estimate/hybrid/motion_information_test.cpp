#include "imulab/estimate/hybrid/motion_information.hpp"

#include "imulab/coefficient.hpp"
#include "imulab/core/rotation.hpp"
#include "imulab/eigen.hpp"
#include "imulab/recording/turn.hpp"
#include "imulab/rig/motion.hpp"
#include "imulab/units.hpp"

#include <gtest/gtest.h>

#include "tests/hybrid_session.hpp"
#include <array>
#include <cmath>

namespace imulab::hybrid {
namespace {

/// Returns the uncertainties of all constants of the model for a path assembled from parts.
Eigen::VectorXd by_parts(const Plan& plan, const InformationModel& model) {
  Knowledge knowledge = prior_knowledge(model);
  std::array<double, 3> angles{};
  const std::vector<Step>& steps = plan.procedure.steps;
  for (const Step& step : steps) {
    AxisStates states;
    for (std::size_t a = 0; a < 3; ++a) states[a].angle = angles[a];
    const BodyState body = turntable_state(ideal_axes(), states);
    if (step.kind == StepKind::hold) {
      RestSeconds used = used_seconds(model, static_cast<int>(std::lround(step.end - step.start)), &step == &steps.front() || &step == &steps.back());
      if (!plan.observe_motion && &step == &steps.front())
        ++used.still;  // a turn by hand uses two seconds of the following rest, which is absent here
      knowledge = after(knowledge, rest_information(model, body.C_nb, used));
    } else {
      auto& state = states[static_cast<std::size_t>(step.axis)];
      state.rate = 1;
      const Vector3d axis = body.C_nb * turntable_state(ideal_axes(), states).rate_nb_b;
      knowledge = after(knowledge, turn_information(model, body.C_nb, {axis, step.angle, step.rate, *step.acceleration}));
      angles[static_cast<std::size_t>(step.axis)] += step.angle;
    }
  }
  return sigma_of(knowledge);
}

void expect_the_filters_sigmas(const Session& session, double tolerance) {
  const Plan plan = plan_of(session);
  const FilterPrediction p = predict(plan);
  const InformationModel model(plan);
  const Eigen::VectorXd sigma = by_parts(plan, model);
  for (Eigen::Index i = 0; i < model.size(); ++i) {
    const Eigen::Index state = model.constants[static_cast<std::size_t>(i)];
    const double expected = std::sqrt(p.covariance(state, state));
    const bool of_ramps = state >= model.states.first(Group::lever_arm) && model.states.first(Group::lever_arm) >= 0;
    // Ramps of turns determine lever arms, depending on their division into blocks of a fifth of a second, which differs from the filter's. The other
    // coefficients hardly change.
    EXPECT_NEAR(sigma[i], expected, (of_ramps ? 0.5 : tolerance) * expected) << "state " << state;
  }
}

TEST(MotionInformation, PartsAddUpToTheFilter) {
  // Both have the same blocks. The sums use midpoints of 0.5 deg, the filter Simpson's rule. The sums observe the heading of a rest in 13 s, the
  // filter in 12.8 s, because holds exclude a tenth of a second at their ends: the difference is 0.8 % of what the heading alone determines.
  expect_the_filters_sigmas(hybrid_procedure(15, 100), 5e-3);
}

TEST(MotionInformation, PartsAddUpToTheFilterByHand) {
  Session session = hybrid_procedure(15, 20);
  session.rigs.front() = {};
  // A turn is one block of 12 to 21 s here: first order in the Earth's rotation within it. Its last second is one of 13 with a constant heading.
  expect_the_filters_sigmas(session, 0.03);
}

TEST(MotionInformation, PartsAddUpWithAnUncertainLatitudeAndGSensitivity) {
  Session session = hybrid_procedure(15, 100);
  session.imu.grade = "mems";
  session.site.latitude_sigma = 0.1 * unit::deg;
  expect_the_filters_sigmas(session, 5e-3);
}

TEST(MotionInformation, ARestIsTheSumOfItsSeconds) {
  const Plan plan = plan_of(hybrid_procedure(15, 20));
  const InformationModel model(plan);
  const Matrix3d C = rotation_about(Vector3d(1, 2, 3).normalized(), 1.0);
  Knowledge one_by_one = prior_knowledge(model);
  for (int k = 0; k < 12; ++k)
    one_by_one = after(one_by_one, rest_information(model, rotation_about(Vector3d(k % 3, 1, k % 4).normalized(), k), {60}));
  Knowledge at_once = one_by_one;
  for (int k = 0; k < 13; ++k) one_by_one = after(one_by_one, rest_information(model, C, {1}));
  at_once = after(at_once, rest_information(model, C, {13}));
  // The heading's change is known to sixteen digits more than the heading itself.
  EXPECT_LT((sigma_of(one_by_one).cwiseQuotient(sigma_of(at_once)).array() - 1).abs().maxCoeff(), 1e-3);
}

}  // namespace
}  // namespace imulab::hybrid
