// A linear problem with known truth tests whether inferred sizes follow the units and whether the coefficients' uncertainties are correct.
#include "imulab/estimate/kernel/size_inference.hpp"

#include "imulab/core/decomposition.hpp"
#include "imulab/core/random.hpp"

#include <gmock/gmock.h>

#include <cmath>

namespace imulab::kernel {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

constexpr Index rows = 120, coefficients = 9, effects_of_unit = 8, columns_each = 3, columns = effects_of_unit * columns_each;

/// A sequence of standard normal draws.
class NormalDraws {
 public:
  NormalDraws(std::uint64_t seed, std::uint64_t stream) : stream_(seed, stream) {}
  double operator()() { return stream_.normal(next_++); }
  VectorXd vector(Index n) {
    return VectorXd::NullaryExpr(n, [&] { return (*this)(); });
  }

 private:
  RandomStream stream_;
  std::uint64_t next_ = 0;
};

/// r = X x + E c + n, with unit noise and half of the effects nearly in the span of X.
struct Linear {
  MatrixXd X{rows, coefficients}, E{rows, columns};

  explicit Linear(std::uint64_t seed) {
    NormalDraws random(seed, 0);
    for (MatrixXd* m : {&X, &E})
      for (Index k = 0; k < m->cols(); ++k) m->col(k) = random.vector(rows);
    for (Index k = 0; k < columns / 2; ++k) {  // a hundredth of the column is outside the span
      const VectorXd mix = random.vector(coefficients);
      E.col(k) = 0.01 * E.col(k) + X * mix / std::sqrt(static_cast<double>(coefficients));
    }
  }
  ReducedEffects reduced(const VectorXd& r) const {
    const MatrixXd gain = Cholesky(X.transpose() * X).solve(MatrixXd(X.transpose() * E));
    const MatrixXd own = E - X * gain;
    return {own.transpose() * own, own.transpose() * r};
  }
};

std::vector<SizedGroup> groups_of_unit(SizedGroup::Of of = SizedGroup::Of::unit) {
  std::vector<SizedGroup> groups;
  for (Index k = 0; k < effects_of_unit; ++k) groups.push_back({k * columns_each, columns_each, of});
  return groups;
}

struct Outcome {
  double nees = 0;   ///< mean of e^T P^-1 e / m for the coefficients
  double wider = 0;  ///< mean ratio of sigma to that without effects
};

/// Simulates units with effects `over` times the table's, scattered by `scatter` in the logarithm.
Outcome drawn(double over, double scatter, SizedGroup::Of of, int draws = 40) {
  constexpr double table = 2;  // in units of the noise: an effect moves a coefficient by several of its sigmas
  Outcome out;
  for (int draw = 0; draw < draws; ++draw) {
    const Linear problem(100 + static_cast<std::uint64_t>(draw));
    NormalDraws random(7, static_cast<std::uint64_t>(draw));
    VectorXd c(columns);
    for (Index k = 0; k < effects_of_unit; ++k) {
      const double size = over * table * std::exp(scatter * random());
      for (Index j = 0; j < columns_each; ++j) c[k * columns_each + j] = size * random();
    }
    const VectorXd r = problem.E * c + random.vector(rows);
    const SizePosterior found = infer_sizes(problem.reduced(r), groups_of_unit(of), {{"", 0, std::vector<double>(effects_of_unit, table)}});
    const Cholesky normal(problem.X.transpose() * problem.X);
    const MatrixXd follows = normal.solve(MatrixXd(problem.X.transpose() * problem.E));
    const ReducedEffects data = problem.reduced(r);
    MatrixXd information = data.L;
    for (Index k = 0; k < effects_of_unit; ++k)
      information.diagonal().segment<columns_each>(k * columns_each).array() += std::pow(found.rms[static_cast<std::size_t>(k)], -2);
    const Cholesky posterior(information);
    const VectorXd error = normal.solve(VectorXd(problem.X.transpose() * r)) - follows * posterior.solve(data.eta);  // the true x is 0
    const MatrixXd P = normal.inverse() + follows * posterior.inverse() * follows.transpose();
    out.nees += squared_norm_in(P, error) / (coefficients * draws);
    out.wider += (P.diagonal().cwiseSqrt().array() / normal.inverse().diagonal().cwiseSqrt().array()).mean() / draws;
  }
  return out;
}

// Each mean has 360 weakly correlated squares and therefore scatters by 0.08.
TEST(SizeInference, UnitsBetterThanTheirClassAreNotChargedForIt) {
  for (const double over : {0.0, 0.1}) {
    const Outcome fixed = drawn(over, std::log(2), SizedGroup::Of::declared), inferred = drawn(over, std::log(2), SizedGroup::Of::unit);
    EXPECT_LT(inferred.wider, 0.25 * fixed.wider) << over;
    EXPECT_GT(inferred.nees, 0.3) << over << ": the fixed sizes have 0.05";
    EXPECT_LT(inferred.nees, 1.1) << over;
  }
}

TEST(SizeInference, UncertaintiesHoldForUnitsOfTheirClassAndForWorseOnes) {
  for (const double over : {1.0, 3.0}) {
    const Outcome inferred = drawn(over, std::log(2), SizedGroup::Of::unit);
    EXPECT_GT(inferred.nees, 0.75) << over;
    EXPECT_LT(inferred.nees, 1.3) << over;
  }
  EXPECT_GT(drawn(3, std::log(2), SizedGroup::Of::declared).nees, 5) << "what sizes that are fixed and too small cost";
}

TEST(SizeInference, AnEffectFarBeyondItsUnitStandsOut) {
  const Linear problem(5);
  NormalDraws random(9, 0);
  VectorXd c = random.vector(columns);
  c.segment<columns_each>(15) *= 30;  // an observable effect
  const SizePosterior found =
      infer_sizes(problem.reduced(problem.E * c + random.vector(rows)), groups_of_unit(), {{"", 0, std::vector<double>(effects_of_unit, 1.0)}});
  EXPECT_GT(found.exceeds(5, 4), 0.99);
  EXPECT_GT(found.stands_out(5, 2), 0.9);
  for (std::size_t k = 4; k < 8; ++k)
    if (k != 5) EXPECT_LT(found.stands_out(k, 2), 0.9) << k;
}

TEST(SizeInference, TheGradeWhoseSizesTheEffectsHaveCarriesTheWeight) {
  const Linear problem(6);
  NormalDraws random(11, 0);
  const VectorXd r = problem.E * (10 * random.vector(columns)) + random.vector(rows);
  std::vector<SizeHypothesis> grades;
  for (const double size : {0.01, 0.3, 10.0}) grades.push_back({"", 0, std::vector<double>(effects_of_unit, size)});
  const SizePosterior found = infer_sizes(problem.reduced(r), groups_of_unit(), grades);
  EXPECT_GT(found.weights[2], 0.5);
  EXPECT_LT(found.weights[0], 0.05);
}

}  // namespace
}  // namespace imulab::kernel
