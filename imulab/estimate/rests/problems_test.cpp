// Compares the derivatives of both methods' conditions with differences of the conditions.
#include "imulab/estimate/rests/handheld_problem.hpp"
#include "imulab/estimate/rests/problem.hpp"
#include "imulab/model/frame_axes.hpp"
#include "imulab/units.hpp"

#include <gtest/gtest.h>

#include "tests/simulated_session.hpp"

namespace imulab::rests {
namespace {

std::vector<CoefficientIndex> all_coefficients() {
  std::vector<CoefficientIndex> indices = select_each({"accel.offset", "accel.matrix", "gyro.offset", "gyro.matrix", "gyro.g_sensitivity"});
  std::erase_if(indices, zero_by_frame);
  return indices;
}

coarse::RestStart start_at_truth(const SimulatedSession& s) {
  coarse::RestStart start;
  start.rests = summarize_rests(s.recording, s.rests);
  start.means = measure_mean_noise(s.recording, start.rests);
  start.model = s.truth.model;
  return start;
}

/// `step(u)` must be small enough for linearity and large enough compared with rounding.
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
    if (size < 1e-12) continue;  // fourth power of the Earth's rate: below the rounding error of the conditions
    EXPECT_LT((difference - at.jacobian.col(u)).cwiseAbs().maxCoeff(), tolerance * size) << "unknown " << u;
  }
}

TEST(HandheldProblem, DerivativesEqualDifferences) {
  HandHeldOptions options;
  options.poses = 8;
  options.first_rest = 4;
  const SimulatedSession s = simulate_session(options, 5);
  const coarse::RestStart start = start_at_truth(s);
  for (const bool latitude : {true, false}) {
    const auto make = [&] {
      Site site = s.site();
      site.given_gravity = s.truth.gravity;
      if (!latitude) site.latitude.reset();
      return HandheldProblem(s.recording, start, site, all_coefficients());
    };
    // The derivatives neglect, as documented, the dependence of C f (1e-3) and of the Earth's rate direction (1e-4) on the force, the midpoint rule
    // of the integrals, and the coning term ((rate dt)^2, 1e-4).
    expect_jacobian(
        make, [](Eigen::Index) { return 1e-6; }, 3e-3);
  }
}

TEST(HandheldProblem, DerivativesOfDeclaredTurnsEqualDifferences) {
  SimulatedSession s;
  s.session = ferraris_procedure(ferraris_options());
  s.truth = draw_truth(s.session, 5);
  s.recording = simulate_recording(s.session, s.session.recordings.front(), s.truth, 5);
  s.rests = rests_of(s.recording, s.session).ranges;
  const std::vector<DeclaredTurn> turns = declared_turns(s.session, s.session.recordings.front());
  for (const bool latitude : {true, false}) {
    const auto make = [&] {
      Site site = s.site();
      site.given_gravity = s.truth.gravity;
      if (!latitude) site.latitude.reset();
      return HandheldProblem(s.recording, start_at_truth(s), site, all_coefficients(), turns);
    };
    EXPECT_EQ(make().turns(), 3u);
    // As above. In addition, angles of the turns are wrong by 1 deg and axes by 2 deg: terms of 2e-2 are neglected.
    expect_jacobian(
        make, [](Eigen::Index) { return 1e-6; }, 2e-2);
  }
}

/// Returns rests in which navigation-grade gyros resolve the Earth's rate.
SimulatedSession long_rests() {
  HandHeldOptions options;
  options.poses = 8;
  options.first_rest = options.rest = 30;
  options.grade = "navigation";
  return simulate_session(options, 5);
}

std::vector<CoefficientIndex> without_g_sensitivity() {
  std::vector<CoefficientIndex> indices = all_coefficients();
  std::erase_if(indices, [](CoefficientIndex index) { return coefficient(index).term == Term::g_sensitivity; });
  return indices;
}

TEST(StaticProblem, DerivativesEqualDifferences) {
  const SimulatedSession s = long_rests();
  const coarse::RestStart start = start_at_truth(s);
  const std::vector<CoefficientIndex> indices = without_g_sensitivity();
  const auto make = [&] {
    Site site = s.site();
    site.given_gravity = s.truth.gravity;
    return StaticProblem(start, site, indices, true);
  };
  // The horizontal part is the length of a vector as short as 5e-5 rad/s: 1e-8 rad/s changes it by (1e-8 / 5e-5)^2.
  const auto step = [&](Eigen::Index u) {
    const Coefficient& c = coefficient(indices[static_cast<std::size_t>(u)]);
    return c.triad == Triad::gyro && c.term == Term::offset ? 1e-8 : 1e-5;
  };
  // The shift due to noise, var / (2 |w|), is kept constant: 1e-6 of the size.
  expect_jacobian(make, step, 1e-5);
}

/// Returns a start with the table of effects.
coarse::RestStart start_with_effects(const SimulatedSession& s) {
  coarse::RestStart start = start_at_truth(s);
  choose_coefficients(start, s.session, s.recording, true, {}, all_coefficients(), "handheld");
  return start;
}

TEST(HandheldProblem, DerivativesByEffectsEqualDifferences) {
  HandHeldOptions options;
  options.poses = 8;
  options.first_rest = 4;
  SimulatedSession s = simulate_session(options, 5);
  for (const bool all : {true, false}) {  // or without the table's first effect, so that one of the gyros is the first
    if (!all) s.session.imu.effect_sigmas["accel.asymmetry"] = 0;
    const coarse::RestStart start = start_with_effects(s);
    EXPECT_GT(start.effects.size(), 50);
    EXPECT_NE(start.effects.columns().front().effect->changes(Triad::gyro), all);
    const auto make = [&] { return HandheldProblem(s.recording, start, s.site(), all_coefficients()); };
    expect_jacobian(
        make, [](Eigen::Index) { return 1e-6; }, 5e-3);
  }
}

TEST(StaticProblem, DerivativesByEffectsEqualDifferences) {
  const SimulatedSession s = long_rests();
  const coarse::RestStart start = start_with_effects(s);
  const std::vector<CoefficientIndex> indices = without_g_sensitivity();
  const auto make = [&] { return StaticProblem(start, s.site(), indices, true); };
  const Eigen::Index coefficients = std::ssize(indices);
  const auto step = [&](Eigen::Index u) {
    const bool of_gyros = u < coefficients ? coefficient(indices[static_cast<std::size_t>(u)]).triad == Triad::gyro
                                           : start.effects.columns()[static_cast<std::size_t>(u - coefficients)].effect->changes(Triad::gyro);
    return of_gyros ? 1e-9 : 1e-6;
  };
  // The horizontal part is nonlinear, as above, also in the effects.
  expect_jacobian(make, step, 1e-2);
}

}  // namespace
}  // namespace imulab::rests
