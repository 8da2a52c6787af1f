// The derivatives of both methods' conditions against differences of the conditions themselves.
#include "imulab/core/units.hpp"
#include "imulab/estimate/common.hpp"
#include "imulab/estimate/handheld_problem.hpp"
#include "imulab/estimate/static_problem.hpp"
#include "tests/simulated_session.hpp"

#include <gtest/gtest.h>

namespace imulab {
namespace {

std::vector<int> all_coefficients() {
  std::vector<int> indices = accel_coefficients();
  for (const char* selector : {"gyro.offset", "gyro.matrix", "gyro.g_sensitivity"})
    for (const int index : select_coefficients(selector)) indices.push_back(index);
  return indices;
}

/// `step(u)`: small enough that the conditions are straight over it, large enough for their rounding.
template <class Make, class Step>
void expect_jacobian(Make make, Step step_of, double tolerance) {
  auto problem = make();
  const Conditions at = problem.conditions({});
  for (Eigen::Index u = 0; u < at.jacobian.cols(); ++u) {
    Eigen::VectorXd step = Eigen::VectorXd::Zero(at.jacobian.cols());
    step[u] = step_of(u);
    auto plus = make(), minus = make();
    plus.correct(step);
    minus.correct(-step);
    const Eigen::VectorXd difference = (plus.conditions({}).value - minus.conditions({}).value) / (2 * step[u]);
    const double size = at.jacobian.col(u).cwiseAbs().maxCoeff();
    EXPECT_GT(size, 0) << "unknown " << u;
    EXPECT_LT((difference - at.jacobian.col(u)).cwiseAbs().maxCoeff(), tolerance * size) << "unknown " << u;
  }
}

TEST(HandheldProblem, DerivativesEqualDifferences) {
  HandHeldOptions options;
  options.poses = 8;
  options.first_rest = 4;
  const SimulatedSession s = simulate_session(options, 5);
  const auto rests = summarize_rests(s.recording, s.rests);
  const SampleNoise noise = measure_noise(s.recording, rests);
  for (const bool latitude : {true, false}) {
    const auto make = [&] {
      return HandheldProblem(s.recording, rests, s.truth.gravity, latitude ? s.session.site.latitude : std::nullopt, noise, {}, s.truth.model, {}, all_coefficients());
    };
    // What the derivatives leave out is stated there: the force's part in C f (1e-3) and in the direction of Earth's rate (1e-4), the integrals' midpoint
    // rule and the coning term ((rate dt)^2, 1e-4).
    expect_jacobian(make, [](Eigen::Index) { return 1e-6; }, 3e-3);
  }
}

TEST(StaticProblem, DerivativesEqualDifferences) {
  HandHeldOptions options;
  options.poses = 8;
  options.first_rest = options.rest = 30;
  options.grade = "navigation";
  const SimulatedSession s = simulate_session(options, 5);
  const auto rests = summarize_rests(s.recording, s.rests);
  std::vector<int> indices = accel_coefficients();
  for (const char* selector : {"gyro.offset", "gyro.matrix"})
    for (const int index : select_coefficients(selector)) indices.push_back(index);
  const auto make = [&] {
    return StaticProblem(rests, s.truth.gravity, s.session.site.latitude, measure_noise(s.recording, rests), {}, s.truth.model, {}, indices);
  };
  // The horizontal part is the length of a vector as short as 5e-5 rad/s: 1e-8 rad/s bends it by (1e-8 / 5e-5)^2.
  const auto step = [&](Eigen::Index u) {
    const Coefficient& c = coefficient_table()[static_cast<std::size_t>(indices[static_cast<std::size_t>(u)])];
    return c.triad == Triad::gyro && c.term == Term::offset ? 1e-8 : 1e-5;
  };
  // The shift by the noise, var / (2 |w|), is held constant: 1e-6 of the size.
  expect_jacobian(make, step, 1e-5);
}

}  // namespace
}  // namespace imulab
