#include "imulab/fleet/statistics/outliers.hpp"

#include "imulab/core/random.hpp"
#include "imulab/fleet.hpp"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <gmock/gmock.h>

#include <algorithm>
#include <cmath>
#include <cstdio>

namespace imulab {
namespace {

/// Units with correlated spreads 1, each measured with a covariance of its own.
struct DrawnFleet {
  OutlierInput input;
  std::vector<Eigen::MatrixXd> covariances;
  DrawnFleet(std::uint64_t seed, Eigen::Index units, Eigen::Index p, double least_u, double most_u) {
    const RandomStream between(seed, "between"), error(seed, "error"), size(seed, "size");
    input.values.resize(units, p);
    input.mean_covariance.setZero(p, p);
    for (Eigen::Index i = 0; i < units; ++i) {
      const double u = least_u + (most_u - least_u) * size.uniform(static_cast<std::uint64_t>(i));
      const auto draw = [&](const RandomStream& stream, double common) {  // variance 1, correlation common^2
        Eigen::VectorXd x(p);
        for (Eigen::Index j = 0; j < p; ++j)
          x[j] = common * stream.normal(static_cast<std::uint64_t>(i * (p + 1) + p)) +
                 std::sqrt(1 - common * common) * stream.normal(static_cast<std::uint64_t>(i * (p + 1) + j));
        return x;
      };
      input.values.row(i) = (draw(between, 0.5) + u * draw(error, 0.8)).transpose();
      covariances.push_back(u * u * (Eigen::MatrixXd::Constant(p, p, 0.64) + 0.36 * Eigen::MatrixXd::Identity(p, p)));
      input.mean_covariance += covariances.back() / static_cast<double>(units);
    }
    input.covariance = [this](Eigen::Index i) { return covariances[static_cast<std::size_t>(i)]; };
  }
  DrawnFleet(const DrawnFleet&) = delete;
};

TEST(Outliers, AFleetWithoutThemHasThemAtTheStatedRate) {  // ctest: long
  // 1200 fleets at a rate of 5 %: 60 expected, with a standard deviation of 7.5; four of them are allowed.
  int equal = 0, different = 0;
  constexpr int fleets = 1200;
  for (std::uint64_t seed = 1; seed <= fleets; ++seed) {
    equal += !find_outliers(DrawnFleet(seed, 60, 6, 0.5, 0.5).input, 0.05).outliers.empty();
    different += !find_outliers(DrawnFleet(seed, 60, 6, 0.3, 1.0).input, 0.05).outliers.empty();
  }
  std::printf("fleets with a false alarm, stated 5 %%: %.2f %% measured equally well, %.2f %% not\n", 100.0 * equal / fleets,
              100.0 * different / fleets);
  EXPECT_NEAR(equal, 0.05 * fleets, 30);
  EXPECT_NEAR(different, 0.05 * fleets, 30);
}

TEST(Outliers, AreFound) {
  // Three of 60, each eight times the spread off in one direction, which is far beyond the limit of about 5.5: all are found, and nobody else.
  int found = 0, others = 0;
  constexpr int fleets = 200;
  for (std::uint64_t seed = 1; seed <= fleets; ++seed) {
    DrawnFleet d(seed, 60, 6, 0.3, 1.0);
    for (const Eigen::Index unit : {5, 17, 40}) d.input.values(unit, 2) += 8 * std::sqrt(1 + d.covariances[static_cast<std::size_t>(unit)](2, 2));
    for (const FleetOutlier& o : find_outliers(d.input, 0.01).outliers) {
      const bool meant = o.unit == 5 || o.unit == 17 || o.unit == 40;
      found += meant && o.worst == 2;
      others += !meant;
    }
  }
  EXPECT_GE(found, 0.99 * 3 * fleets);
  EXPECT_LE(others, 10);  // 2 expected at 1 % of 200
}

TEST(Outliers, TheFarthestCoefficientIsStatedInSigmas) {
  DrawnFleet d(1, 60, 1, 0.1, 0.5);  // of one coefficient they are the distance
  d.input.values(7, 0) -= 20;
  const std::vector<FleetOutlier> found = find_outliers(d.input).outliers;
  ASSERT_EQ(found.size(), 1u);
  EXPECT_NEAR(found[0].worst_sigmas, -found[0].distance, 1e-9 * found[0].distance);
}

TEST(Outliers, AUnitMeasuredBadlyIsNoOutlier) {
  DrawnFleet d(1, 60, 3, 0.1, 0.1);
  d.input.values(7, 0) += 6;
  EXPECT_EQ(find_outliers(d.input).outliers.size(), 1u);
  d.covariances[7] *= 1e4;  // it was measured to 10 times the spread
  EXPECT_TRUE(find_outliers(d.input).outliers.empty());
}

TEST(Outliers, ACoefficientThatIsTheSameInAllUnitsHidesNone) {
  DrawnFleet d(1, 60, 4, 0.1, 0.5);
  d.input.values.col(3).setZero();  // as a prior sets it: apart from all else
  const auto set_apart = [](Eigen::MatrixXd& covariance) {
    const double own = covariance(3, 3);
    covariance.row(3).setZero(), covariance.col(3).setZero();
    covariance(3, 3) = own;
  };
  set_apart(d.input.mean_covariance);
  for (Eigen::MatrixXd& covariance : d.covariances) set_apart(covariance);
  EXPECT_TRUE(find_outliers(d.input).outliers.empty());
  d.input.values(7, 0) += 20;
  const OutlierSearch search = find_outliers(d.input);
  EXPECT_TRUE(search.possible);
  ASSERT_EQ(search.outliers.size(), 1u);
  EXPECT_EQ(search.outliers[0].unit, 7);
  EXPECT_EQ(search.spread(3, 3), 0);
}

TEST(Outliers, MissingCoefficientsAndSmallFleets) {
  DrawnFleet d(1, 60, 3, 0.1, 0.5);
  d.input.values(7, 0) = std::nan("");
  d.input.values(8, 0) = std::nan("");
  d.input.values(8, 1) += 20;
  const OutlierSearch search = find_outliers(d.input);
  ASSERT_EQ(search.outliers.size(), 1u);
  EXPECT_EQ(search.outliers[0].unit, 8);
  EXPECT_EQ(search.outliers[0].coefficients, 2);
  EXPECT_FALSE(find_outliers(DrawnFleet(1, 8, 6, 0.5, 0.5).input).possible);
  EXPECT_FALSE(find_outliers({Eigen::MatrixXd(0, 0), Eigen::MatrixXd(0, 0), {}}).possible);
}

/// By the definition: each unit against the mean and the spread of all others, whose eigenvalues are found anew for each.
double square_without(const OutlierInput& input, Eigen::Index unit, const std::vector<Eigen::Index>& inside) {
  std::vector<Eigen::Index> others = inside;
  std::erase(others, unit);
  const Eigen::MatrixXd rows = input.values(others, Eigen::all);
  const Eigen::RowVectorXd mean = rows.colwise().mean();
  const Eigen::MatrixXd z = rows.rowwise() - mean, sample = z.transpose() * z / (static_cast<double>(others.size()) - 1);
  const Eigen::VectorXd size = sample.diagonal().cwiseMax(input.mean_covariance.diagonal()).cwiseSqrt();
  const Eigen::MatrixXd by = size.cwiseInverse().asDiagonal();
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> e(by * (sample - input.mean_covariance) * by);
  const Eigen::MatrixXd root = size.asDiagonal() * e.eigenvectors() * e.eigenvalues().cwiseMax(0).cwiseSqrt().asDiagonal();
  const Eigen::VectorXd offset = (input.values.row(unit) - mean).transpose();
  return offset.dot((input.covariance(unit) + root * root.transpose()).ldlt().solve(offset));
}

TEST(Outliers, OfALargeFleetAreThoseOfTheDefinition) {
  // Units of more than 1000 are not all judged by eigenvalues. Forty are put at distances around the limit, one coefficient has no spread at all (no
  // step is then without eigenvalues), and uncertainties differ by eight times: who is an outlier, and how far, is as by the definition.
  constexpr Eigen::Index p = 4, units = 1100;
  DrawnFleet d(3, units, p, 0.1, 0.8);
  for (Eigen::Index i = 0; i < units; ++i) {
    Eigen::MatrixXd& own = d.covariances[static_cast<std::size_t>(i)];
    const double sigma = std::sqrt(own(3, 3));
    own.row(3).setZero(), own.col(3).setZero(), own(3, 3) = sigma * sigma;
    d.input.values(i, 3) = sigma * RandomStream(4, "apart").normal(static_cast<std::uint64_t>(i));
    if (i < 40) d.input.values(i, i % 4) += (i % 4 == 3 ? sigma : 1.2) * (4 + 0.1 * static_cast<double>(i));
  }
  d.input.mean_covariance.setZero();
  for (const Eigen::MatrixXd& own : d.covariances) d.input.mean_covariance += own / static_cast<double>(units);
  const OutlierSearch search = find_outliers(d.input);
  EXPECT_GT(search.outliers.size(), 5u);
  EXPECT_LT(search.outliers.size(), 40u);
  std::vector<Eigen::Index> inside;
  double nearest = search.outliers.back().distance, farthest_inside = 0;
  for (Eigen::Index i = 0; i < units; ++i)
    if (std::none_of(search.outliers.begin(), search.outliers.end(), [&](const FleetOutlier& o) { return o.unit == i; })) inside.push_back(i);
  for (const FleetOutlier& o : search.outliers) EXPECT_NEAR(o.distance, std::sqrt(square_without(d.input, o.unit, inside)), 1e-9 * o.distance);
  for (const Eigen::Index i : inside)
    if (i < 40 || i % 50 == 0) farthest_inside = std::max(farthest_inside, std::sqrt(square_without(d.input, i, inside)));
  // Two limits: a unit measured otherwise than the average has other degrees of freedom, which moves its limit by less than 2 % here.
  EXPECT_LT(farthest_inside, 1.02 * nearest);
}

TEST(Outliers, OfALargeFleetThatOthersAndCorrelationsHideAreFound) {
  // Errors of 41 units are correlated by 0.998. Forty of them are far from the fleet along the direction that is measured best, which widens the
  // spread of the first estimate so far that the last, within its variances of each coefficient, is near; without the forty it is not.
  constexpr Eigen::Index units = 2000, far = 40, hidden = units - 1;
  const RandomStream random(1, "readings");
  const double half = std::sqrt(0.5);
  OutlierInput input{Eigen::MatrixXd(units, 2), Eigen::MatrixXd::Identity(2, 2), {}};
  const Eigen::MatrixXd correlated{{1, 0.998}, {0.998, 1}};
  input.covariance = [&](Eigen::Index i) { return i < far || i == hidden ? correlated : input.mean_covariance; };
  for (Eigen::Index i = 0; i < units; ++i) {
    const auto along = [&](std::uint64_t k) { return random.normal(4 * static_cast<std::uint64_t>(i) + k); };
    input.values.row(i) << along(0) + 0.05 * along(1), along(2) + 0.05 * along(3);
    const double off = i == hidden ? 1.5 : i % 2 == 1 ? 4 : -4, common = i == hidden ? 1 : along(0);
    if (i < far || i == hidden) input.values.row(i) << half * (common + off), half * (common - off);
  }
  const std::vector<FleetOutlier> found = find_outliers(input).outliers;
  EXPECT_EQ(std::count_if(found.begin(), found.end(), [](const FleetOutlier& o) { return o.unit < far; }), far);
  EXPECT_EQ(std::count_if(found.begin(), found.end(), [](const FleetOutlier& o) { return o.unit == hidden; }), 1);
}

}  // namespace
}  // namespace imulab
