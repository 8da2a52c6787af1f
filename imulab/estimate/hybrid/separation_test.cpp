#include "imulab/estimate/hybrid/separation.hpp"

#include "imulab/core/decomposition.hpp"
#include "imulab/core/random.hpp"
#include "imulab/core/rotation.hpp"
#include "imulab/estimate/hybrid/filter.hpp"
#include "imulab/units.hpp"

#include <Eigen/Cholesky>
#include <Eigen/LU>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/hybrid_session.hpp"

namespace imulab::hybrid {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;
using in_place::Matrix6;

using One = Eigen::Matrix<double, 1, 1>;
using Rows6 = Eigen::Matrix<double, 6, Eigen::Dynamic>;

/// Two constants and six states, driven by three additional constants c; the last three states are observed.
struct SmallCase {
  static constexpr Index states = 8, beside = 3;
  RandomStream draws{7, "separation test"};
  std::uint64_t next = 0;
  kernel::Parameters c{beside};
  double sigma = 0.3;

  SmallCase() {
    c.sigma << 0.5, 2, 0.1;
    c.offset << 0.2, 0, 0;
  }
  MatrixXd drawn(Index rows, Index columns) {
    return MatrixXd::NullaryExpr(rows, columns, [&] { return draws.normal(next++); });
  }
};

TEST(Separation, EqualsTheFilterWithTheConstantsAmongItsStates) {
  SmallCase s;
  constexpr Index n = SmallCase::states, m = SmallCase::beside;
  SquareRootEstimate separated(n), augmented(m + n);
  separated.factor.topLeftCorner<2, 2>().setIdentity();
  separated.x.head<2>() << 1, -1;
  augmented.factor.diagonal().head<m>() = s.c.sigma;
  augmented.factor.block<2, 2>(m, m).setIdentity();
  augmented.x << s.c.offset, separated.x;
  Separation separation(s.c, n);
  double chi2 = 0;
  const int blocks = 12;
  for (int k = 0; k < blocks; ++k) {
    const Rows6 by_states = 0.4 * s.drawn(6, n), by_c = s.drawn(6, m);
    const Matrix6 noise = std::sqrt(0.1) * Matrix6::Identity();
    Rows6 both(6, m + n);
    both << by_c, by_states;
    separated.predict(by_states, noise);
    separation.predict(by_states, by_c);
    augmented.predict(both, noise);

    const Vector3d seen = s.drawn(3, 1);
    const auto whitening = [&](const SquareRootEstimate& e) {
      const Eigen::Matrix<double, 3, Eigen::Dynamic> rows = e.factor.bottomRows<3>();
      return Matrix3d(Matrix3d(rows * rows.transpose() + s.sigma * s.sigma * Matrix3d::Identity()).llt().matrixL());
    };
    const auto whitened = [&](const SquareRootEstimate& e) -> Vector3d {
      return whitening(e).triangularView<Eigen::Lower>().solve(seen - e.x.tail<3>());
    };
    EXPECT_EQ(separation.observe<3>(separated, n - 3, whitening(separated), whitened(separated)), 4 * k);
    chi2 += whitened(augmented).squaredNorm();
    for (Index i = 2; i >= 0; --i) {
      separated.observe(n - 3 + i, seen[i], s.sigma);
      augmented.observe(m + n - 3 + i, seen[i], s.sigma);
    }
    // Observes one of the other states alone.
    const auto one = [&](const SquareRootEstimate& e, Index at) {
      const double deviation = std::hypot(e.factor.row(at).norm(), s.sigma);
      return std::pair(One(deviation), One((seen[0] - e.x[at]) / deviation));
    };
    const auto [deviation, innovation] = one(separated, 2);
    separation.observe<1>(separated, 2, deviation, innovation);
    chi2 += one(augmented, m + 2).second.squaredNorm();
    separated.observe(2, seen[0], s.sigma);
    augmented.observe(m + 2, seen[0], s.sigma);
    if (k == blocks / 2) separation.estimate();  // as for a curve: later innovations add to it
  }
  const Separation::Estimate c = separation.estimate();
  const MatrixXd covariance = augmented.factor * augmented.factor.transpose();
  EXPECT_LT((c.value - augmented.x.head<m>()).norm(), 1e-10);
  EXPECT_LT((c.covariance - covariance.topLeftCorner<m, m>()).norm(), 1e-10);
  EXPECT_LT((separated.x + separation.U * c.value - augmented.x.tail<n>()).norm(), 1e-10);
  const MatrixXd of_states = separated.factor * separated.factor.transpose() + separation.U * c.covariance * separation.U.transpose();
  EXPECT_LT((of_states - covariance.bottomRightCorner<n, n>()).norm(), 1e-10);
  // The residuals at c and its prior sum to the chi-square of the augmented filter.
  double residual = (c.value - s.c.offset).cwiseQuotient(s.c.sigma).squaredNorm();
  for (Index k = 0; k < blocks; ++k)
    residual += separation.innovation<3>(4 * k, c.value).squaredNorm() + separation.innovation<1>(4 * k + 3, c.value).squaredNorm();
  EXPECT_NEAR(residual, chi2, 1e-9 * chi2);
}

/// Adds c times a column of an effect to the calibrated output of each sample.
void add_effect(Recording& r, const SensorModel& model, const EffectColumn& column, double c, EffectState state) {
  CompensatedReadings readings(r, model);
  std::vector<OutputChange> changes;
  for (std::size_t i = 0; i < r.size(); ++i) {
    state.force = readings.force(i), state.rate = readings.rate(i);
    state.time = (r.time_s(i) - r.time_s(0)) / (r.time_s(r.size() - 1) - r.time_s(0)) - 0.5;
    changes.push_back(column.at(state));
  }
  const Matrix3d accel = model.accel.matrix.inverse(), gyro = model.gyro.matrix.inverse();
  for (std::size_t i = 0; i < r.size(); ++i)
    for (std::size_t j = 0; j < 3; ++j) {
      const auto axis = static_cast<Index>(j);
      r.accel[j][i] += c * accel.row(axis).dot(changes[i].force);
      r.gyro[j][i] += c * gyro.row(axis).dot(changes[i].rate);
    }
}

TEST(Separation, ColumnsAreTheDerivativesOfTheNavigation) {
  const HybridSession s = hybrid_session(1, [](Session& session) {
    session = hybrid_procedure(6, 100);
    session.imu.accel_noise_density = session.imu.gyro_noise_density = 1e-14;
  });
  const SensorModel& model = s.truth.model;
  const Place place{*s.session.site.latitude, s.truth.gravity, 0, 1e-4};
  const States states({}, place);
  Data data{s.recording,
            in_place::cut_into_blocks(s.recording, {s.rests[0], s.rests[1], s.rests[2], s.rests[3]}, true).blocks,
            place,
            {Vector3d::Constant(1e-9), Vector3d::Constant(1e-9)},
            model};
  for (Block& block : data.blocks) block.observed = false;  // only the transition is tested
  data.unmodeled = unmodeled_of(s.session, s.recording, data.blocks, model, {}, {}, true);
  const kernel::Effects& effects = data.unmodeled.effects;
  const auto errors_at_the_end = [&](const Recording& recording, const Matrix3d& start) {
    in_place::Navigator navigator(recording, model, 0, place.latitude, place.gravity, {});
    navigator.C_nb = start;
    Vector3d velocity = Vector3d::Zero();
    for (const Block& block : data.blocks) velocity += navigator.over(block, data.blocks.front().samples.begin).velocity;
    return std::pair(navigator.C_nb, velocity);
  };
  in_place::Navigator aligned(s.recording, model, 0, place.latitude, place.gravity, {});
  aligned.align(data.blocks.front().samples);
  const auto [C, v] = errors_at_the_end(s.recording, aligned.C_nb);
  kernel::Parameters known = states.parameters(VectorXd::Zero(states.constants()));
  known.sigma.setZero();
  known.sigma.segment<3>(states.first(Group::start)).setConstant(1e-9);
  EffectState state;
  state.gravity = state.full_force = place.gravity;
  state.full_rate = data.unmodeled.full_rate;
  for (Index k = 0; k < effects.size(); ++k) {
    const EffectColumn& column = effects.columns()[static_cast<std::size_t>(k)];
    if (column.number % 5 != 0) continue;                                                                     // other axes and functions are similar
    if (column.effect->name == "accel.hysteresis" || column.effect->name == "accel.rectification") continue;  // these depend on more than the sample
    const double c = 1e-5 / std::max({1.0, column.at({.force = {5, 5, 5}, .rate = {1, 1, 1}, .time = 0.5}).force.norm()});
    Recording changed = s.recording;
    add_effect(changed, model, column, c, state);
    const auto [C_changed, v_changed] = errors_at_the_end(changed, aligned.C_nb);
    VectorXd difference(6);
    difference << -rotation_log(C_changed * C.transpose()), v_changed - v;
    Linearization about{model, place, aligned.C_nb};
    about.effects = c * VectorXd::Unit(effects.size(), k);
    const VectorXd predicted = filter_pass(data, about, states, known, {.effects = false}).x.tail(6);
    // The steps are 0.05 rad, with the middles of ramps.
    for (const Index part : {0, 3})
      EXPECT_LT((difference - predicted).segment<3>(part).norm(), 0.02 * difference.segment<3>(part).norm() + (part == 0 ? 1e-11 : 1e-8))
          << column.effect->name << " " << column.number << ": " << difference.transpose() << " predicted " << predicted.transpose();
  }
}

TEST(Separation, EffectsThatAreAsGoodAsNoneChangeNothing) {
  HybridSession s = hybrid_session(3);
  for (const Effect& effect : effects()) s.session.imu.effect_sigmas[std::string(effect.name)] = 1e-9 * effect.prior[0] * effect.unit;
  s.session.imu.term_sigmas = {
      .accel_quadratic = 1e-6, .accel_cubic = 1e-7, .gyro_quadratic = 1e-6, .gyro_cubic = 1e-6, .g_sensitivity = 1e-9, .lever_arm = 0.05};
  const CalibrationResult none = calibrated(s, {.effects = false}), table = calibrated(s, {.effects = true});
  ASSERT_EQ(none.calibration.estimated, table.calibration.estimated);
  EXPECT_TRUE(none.calibration.quality.effects.empty());
  EXPECT_FALSE(table.calibration.quality.effects.empty());
  const VectorXd sigma = none.calibration.covariance.diagonal().cwiseSqrt();
  for (std::size_t i = 0; i < none.calibration.estimated.size(); ++i) {
    const CoefficientIndex index = none.calibration.estimated[i];
    const auto k = static_cast<Index>(i);
    EXPECT_NEAR(coefficient_value(none.calibration.model, index), coefficient_value(table.calibration.model, index), 0.02 * sigma[k]);
    EXPECT_NEAR(std::sqrt(table.calibration.covariance(k, k)), sigma[k], 1e-3 * sigma[k]);
  }
}

TEST(Separation, AGyroThatSticksInATurnCostsThatTurn) {
  HybridSession s = hybrid_session(4);
  const std::size_t begin = s.rests[4].end + 60;  // 3 s at 20 Hz: within a turn of 9 s
  for (std::vector<double>& gyro : s.recording.gyro) std::fill_n(gyro.begin() + static_cast<std::ptrdiff_t>(begin), 20, gyro[s.rests[4].begin]);
  const Calibration c = calibrated(s).calibration;
  EXPECT_THAT(c.quality.findings.warnings(), testing::Contains(testing::HasSubstr("dropped as an outlier: the rotation from")));
  EXPECT_EQ(c.quality.verdict, Verdict::good) << verdict_text(c.quality);
  VectorXd error(std::ssize(c.estimated));
  for (Index k = 0; k < error.size(); ++k) {
    const CoefficientIndex index = c.estimated[static_cast<std::size_t>(k)];
    error[k] = (coefficient_value(c.model, index) - coefficient_value(s.truth.model, index)) / std::sqrt(c.covariance(k, k));
  }
  EXPECT_LT(error.cwiseAbs().maxCoeff(), 4.5);
}

}  // namespace
}  // namespace imulab::hybrid
