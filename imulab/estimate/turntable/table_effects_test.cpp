#include "imulab/estimate/turntable/table_effects.hpp"

#include "imulab/earth.hpp"
#include "imulab/estimate/kernel/site.hpp"
#include "imulab/estimate/turntable/estimator.hpp"
#include "imulab/estimate/turntable/prediction.hpp"
#include "imulab/procedure.hpp"
#include "imulab/rig/motion.hpp"
#include "imulab/units.hpp"

#include <Eigen/LU>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/table_session.hpp"
#include <algorithm>
#include <cmath>
#include <vector>

namespace imulab::turntable {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

const kernel::EffectSizes mems_sizes{{}, {{"mems"}}};

/// Returns the change of a unit's raw readings due to each effect of c (a column each), sample by sample along the rig's motion: means of holds, and
/// gyro sums of turns.
MatrixXd simulated_changes(const TablePlan& plan, const TableMotion& parts, const SensorModel& unit, const kernel::Effects& effects,
                           const VectorXd& c, std::size_t changed_at) {
  constexpr double interval = 0.02;  // 1 deg of the fastest turn
  const RigMotion motion = rig_motion(plan.steps);
  const double gravity = table_site().gravity();
  const Surroundings place{earth_rate_enu(*table_site().latitude), gravity, Matrix3d::Zero()};
  const kernel::SiteChanges changes(table_site());
  const Matrix3d of_accel = unit.accel.matrix.inverse(), of_gyro = unit.gyro.matrix.inverse();
  PlayOperator play(gravity);
  const std::size_t groups = effects.groups().size();
  MatrixXd sum = MatrixXd::Zero(parts.rows(), static_cast<Index>(groups));
  VectorXd weight = VectorXd::Zero(static_cast<Index>(parts.parts()));
  const auto samples = static_cast<int>(std::ceil(motion.end() / interval));
  for (int i = 0; i < samples; ++i) {
    const double t = (i + 0.5) * interval;
    const BodyState body = body_state(motion, t);
    const Motion truth = sensed_motion(body, place);
    EffectState state{.force = truth.force, .rate = truth.rate, .gravity = gravity};
    changes.fill(state, body.C_nb.transpose());
    state.time = (t - plan.begin) / (plan.end - plan.begin) - 0.5;
    state.play = play(truth.force);
    state.changed = t > plan.steps[changed_at].start - 1 ? 1 : 0;  // the change precedes the step; a turn's sum includes 1 s of the rest before
    std::vector<OutputChange> change(groups);
    for (std::size_t g = 0; g < groups; ++g) {
      const kernel::EffectGroup& group = effects.groups()[g];
      for (Index k = group.first; k < group.first + group.size; ++k) {
        const OutputChange one = effects.columns()[static_cast<std::size_t>(k)].at(state);
        change[g].force += c[k] * one.force, change[g].rate += c[k] * one.rate;
      }
      change[g] = {.force = of_accel * change[g].force, .rate = of_gyro * change[g].rate};
    }
    for (std::size_t part = 0; part < parts.parts(); ++part) {
      const double inside = std::min(t + 0.5 * interval, parts.end(part)) - std::max(t - 0.5 * interval, parts.begin(part));
      if (inside <= 0) continue;
      weight[static_cast<Index>(part)] += inside;
      for (std::size_t g = 0; g < groups; ++g) {
        auto column = sum.col(static_cast<Index>(g));
        if (parts.is_hold(part)) column.segment<3>(parts.row(part)) += inside * change[g].force;
        column.segment<3>(parts.gyro_row(part)) += inside * change[g].rate;
      }
    }
  }
  for (std::size_t part = 0; part < parts.parts(); ++part)
    if (parts.is_hold(part)) sum.middleRows<6>(parts.row(part)) /= weight[static_cast<Index>(part)];
  return sum;
}

/// Compares the columns of all effects with changes of simulated readings, each with its prior sigma and relative to its largest reading.
TEST(TableEffects, ColumnsAreDerivativesOfSimulatedReadings) {
  const RigDeclaration rig = table_of(2 * unit::arcsec);
  const TablePlan plan = table_plan(odd_steps(), rig);
  const TableMotion motion(plan, rig, table_site());
  const SensorModel unit = drawn_unit(3);
  const std::size_t changed_at = 9;
  EstimatorOptions options;
  options.terms = linear_terms();
  options.effects = table_effects(mems_sizes, motion, plan, table_site(), UnitChange{changed_at});
  const kernel::Effects& effects = options.effects.table;
  const RawNoise noise{raw_density(table_accel_noise, unit.accel.matrix), raw_density(table_gyro_noise, unit.gyro.matrix)};
  const Estimator estimator(motion, unit, noise, options);
  VectorXd c = effects.sigma();
  for (const kernel::EffectGroup& g : effects.groups())  // all columns of an effect at once, with different sizes
    for (Index k = 0; k < g.size; ++k) c[g.first + k] *= 1 + 0.3 * static_cast<double>(k);
  const MatrixXd simulated = simulated_changes(plan, motion, unit, effects, c, changed_at);
  for (std::size_t i = 0; i < effects.groups().size(); ++i) {
    const kernel::EffectGroup& g = effects.groups()[i];
    if (g.effect->name == "accel.rectification") continue;  // there is no vibration
    const VectorXd simulated_change = simulated.col(static_cast<Index>(i));
    const VectorXd change = estimator.readings_by_effects().middleCols(g.first, g.size) * c.segment(g.first, g.size);
    for (const int kind : {0, 1, 2}) {  // means of accelerometers, of gyros, sums of turns
      VectorXd rows = VectorXd::Zero(motion.rows());
      for (std::size_t part = 0; part < motion.parts(); ++part)
        if (motion.is_hold(part) != (kind == 2)) rows.segment<3>(motion.row(part) + (kind == 1 ? 3 : 0)).setOnes();
      const VectorXd expected = rows.cwiseProduct(simulated_change), error = rows.cwiseProduct(change) - expected;
      // Sampling at 50 Hz gives steps of a degree at turning points of the play and at ends of turns.
      EXPECT_LE(error.cwiseAbs().maxCoeff(), 2e-3 * expected.cwiseAbs().maxCoeff() + 1e-12) << g.effect->name << " " << kind;
    }
  }
}

TEST(TableEffects, EstimatesAreWithinTheirUncertainty) {
  const RigDeclaration rig = table_of(2 * unit::arcsec, 0);
  const TableRun run = run_of(zhang_steps(), rig, 4, 0);
  EstimatorOptions options;
  options.terms = linear_terms();
  options.effects = table_effects({{}, {{"navigation"}}}, run.motion, run.seen.parts, table_site());
  const RawNoise noise{raw_density(table_accel_noise, run.truth.accel.matrix), raw_density(table_gyro_noise, run.truth.gyro.matrix)};
  const Estimator estimator(run.motion, run.truth, noise, options);
  const Index n = options.effects.table.size();
  const VectorXd sigma = options.effects.table.sigma(), c = sigma.cwiseProduct(drawn_normals(n, 5, "effects"));
  const VectorXd readings = run.seen.readings + estimator.readings_by_effects() * c + drawn_noise(run.motion, run.truth, 5);
  const VectorXd error = estimator.effects(readings) - c;
  const MatrixXd P = estimator.effects_covariance();
  const double chi2 = error.dot(P.ldlt().solve(error)) / static_cast<double>(n);
  EXPECT_NEAR(chi2, 1, 4 * std::sqrt(2.0 / static_cast<double>(n)));  // 4 sigmas of its mean
  EXPECT_TRUE((P.diagonal().array() <= sigma.array().square() * (1 + 1e-9)).all());
}

TEST(TableEffects, PredictionAgreesWithMonteCarlo) {
  Session session = zhang_24_procedure({});
  session.imu.grade = "navigation";
  Plan plan = plan_of(session);
  const Prediction without = predict(plan);
  plan.effects = kernel::EffectSizes{{}, {{"navigation"}}};
  const Prediction closed = predict(plan);
  const MonteCarloResult sampled = monte_carlo(plan, 4000, 1);
  ASSERT_EQ(sampled.coefficients, closed.coefficients);
  for (Index i = 0; i < closed.sigma.size(); ++i)
    EXPECT_NEAR(sampled.sigma[i] / closed.sigma[i], 1, 0.05) << coefficient(closed.coefficients[static_cast<std::size_t>(i)]).name;  // 4.5 of 1.1 %
  EXPECT_TRUE((closed.sigma.array() >= without.sigma.array() * (1 - 1e-6)).all());
  EXPECT_THAT(closed.sources, testing::Contains("mount.elastic"));
}

}  // namespace
}  // namespace imulab::turntable
