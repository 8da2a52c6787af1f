// Published values: NIST SP 1065 (Riley 2008), table 31 (NBS14, 10 points) and tables 32 to 34 (1000 points); and bounds of Stable32 for the same
// 1000 points. A published value must agree to all printed digits, unless the tables are inconsistent: SP 1065 prints one Hadamard deviation as
// 70.80608 and as 70.80607 (it is 70.806073), and 3.9108606e-2 as 3.910860e-2.
#include "imulab/core/random.hpp"
#include "imulab/core/statistics.hpp"
#include "imulab/error.hpp"
#include "imulab/noise.hpp"
#include "imulab/noise/degrees_of_freedom.hpp"
#include "imulab/noise/phase.hpp"

#include <gmock/gmock.h>

#include <cmath>
#include <cstdint>
#include <map>

namespace imulab {
namespace {

using Kind = DeviationKind;

const std::map<Kind, const char*> names{
    {Kind::allan, "Allan"},       {Kind::overlapping_allan, "overlapping Allan"},       {Kind::modified_allan, "modified"},
    {Kind::hadamard, "Hadamard"}, {Kind::overlapping_hadamard, "overlapping Hadamard"}, {Kind::total, "total"}};

std::vector<double> nbs14_10() { return {892, 809, 823, 798, 671, 644, 883, 903, 677}; }

std::vector<double> nbs14_1000() {
  std::vector<double> rate;
  for (std::uint64_t n = 1234567890; rate.size() < 1000; n = 16807 * n % 2147483647) rate.push_back(static_cast<double>(n) / 2147483647);
  return rate;
}

/// Returns half a unit of the last of `digits` significant digits.
double half_unit(double value, int digits) { return 0.5 * std::pow(10, std::floor(std::log10(value)) + 1 - digits) * (1 + 1e-9); }

void expect_published(const std::vector<double>& rate, const std::vector<std::size_t>& factors,
                      const std::map<Kind, std::vector<double>>& published) {
  for (const auto& [kind, values] : published) {
    const std::vector<DeviationPoint> points = deviation(rate, 1, factors, kind);
    ASSERT_EQ(points.size(), values.size()) << names.at(kind);
    for (std::size_t k = 0; k < values.size(); ++k)
      EXPECT_NEAR(points[k].deviation, values[k], (kind == Kind::hadamard ? 2 : 1) * half_unit(values[k], 7))
          << names.at(kind) << " at " << factors[k];
  }
}

TEST(Deviation, IsThePublishedOneOfTenPoints) {
  expect_published(nbs14_10(), {1, 2},
                   {{Kind::allan, {91.22945, 115.8082}},
                    {Kind::overlapping_allan, {91.22945, 85.95287}},
                    {Kind::modified_allan, {91.22945, 74.78849}},
                    {Kind::total, {91.22945, 93.90379}},
                    {Kind::hadamard, {70.80608, 116.7980}},
                    {Kind::overlapping_hadamard, {70.80607, 85.61487}}});
}

TEST(Deviation, IsThePublishedOneOfAThousandPoints) {
  const std::vector<double> rate = nbs14_1000();
  EXPECT_EQ(std::llround(rate[3] * 2147483647), 633705974);
  expect_published(rate, {1, 10, 100},
                   {{Kind::allan, {2.922319e-1, 9.965736e-2, 3.897804e-2}},
                    {Kind::overlapping_allan, {2.922319e-1, 9.159953e-2, 3.241343e-2}},
                    {Kind::modified_allan, {2.922319e-1, 6.172376e-2, 2.170921e-2}},
                    {Kind::hadamard, {2.943883e-1, 1.052754e-1, 3.910860e-2}},
                    {Kind::overlapping_hadamard, {2.943883e-1, 9.581083e-2, 3.237638e-2}},
                    {Kind::total, {2.922319e-1, 9.134743e-2, 3.406530e-2}}});
}

TEST(Deviation, HasTheTermsAndTimesOfTheDefinition) {
  const auto points = deviation(nbs14_1000(), 0.5, {1, 10, 100, 256, 500, 501});
  ASSERT_EQ(points.size(), 5u);  // two averages of 501 do not fit into 1000
  EXPECT_EQ(points[0].terms, 999u);
  EXPECT_EQ(points[1].terms, 981u);
  EXPECT_EQ(points[2].terms, 801u);
  EXPECT_EQ(points[3].terms, 489u);
  EXPECT_EQ(points[4].terms, 1u);
  EXPECT_DOUBLE_EQ(points[3].tau, 128);
  EXPECT_NEAR(points[0].deviation, 2.922318781067595e-01, 1e-13);  // from an independent implementation; rounding of 1000 sums
  EXPECT_NEAR(points[3].deviation, 1.028221763903267e-02, 1e-14);
}

TEST(Deviation, OfManyOctavesIsThatOfTheDefinition) {
  std::vector<double> rate;
  for (int i = 0; i < 9000; ++i) rate.push_back(std::fmod(0.61803398875 * i * i, 1.0));  // several pieces, the last one partial
  const std::vector<std::size_t> factors = averaging_factors(rate.size());
  const std::vector<DeviationPoint> points = deviation(rate, 1, factors, DeviationKind::overlapping_allan);
  ASSERT_EQ(points.size(), factors.size());
  for (std::size_t k = 0; k < factors.size(); ++k) {
    const std::size_t m = factors[k];
    double square = 0;
    std::size_t terms = 0;
    for (std::size_t i = 0; i + 2 * m <= rate.size(); ++i, ++terms) {
      double first = 0, second = 0;
      for (std::size_t j = i; j < i + m; ++j) first += rate[j], second += rate[j + m];
      square += std::pow((second - first) / static_cast<double>(m), 2);
    }
    EXPECT_EQ(points[k].terms, terms);
    // Rounding of sums of 9000 readings is 1e-12, for means that differ by at least 1e-3.
    EXPECT_NEAR(points[k].deviation, std::sqrt(square / (2 * static_cast<double>(terms))), 1e-9 * points[k].deviation) << m;
  }
}

TEST(Deviation, IsTheSameInTheMemoryOfTheReadings) {
  std::vector<double> rate;
  for (int i = 0; i < 5000; ++i) rate.push_back(9.8 + std::fmod(0.61803398875 * i * i, 1.0));
  const std::vector<std::size_t> factors = averaging_factors(rate.size());
  for (const DeviationKind kind : {DeviationKind::overlapping_allan, DeviationKind::total}) {
    const std::vector<DeviationPoint> expected = deviation(rate, 0.01, factors, kind);
    std::vector<double> own = rate;
    const std::vector<DeviationPoint> points = deviation_in_place(std::move(own), 0.01, factors, kind);
    ASSERT_EQ(points.size(), expected.size());
    for (std::size_t k = 0; k < points.size(); ++k) {
      EXPECT_EQ(points[k].deviation, expected[k].deviation) << k;
      EXPECT_EQ(points[k].edf, expected[k].edf) << k;
    }
  }
}

TEST(Deviation, HasTheBoundsOfStable32) {
  struct Row {
    std::size_t m, terms;
    double low, value, high;
  };
  const std::vector<Row> rows{{1, 999, 2.8515e-01, 2.9223e-01, 2.9987e-01},  {2, 997, 1.9520e-01, 2.0102e-01, 2.0738e-01},
                              {4, 993, 1.3931e-01, 1.4479e-01, 1.5098e-01},  {8, 985, 1.0038e-01, 1.0570e-01, 1.1198e-01},
                              {16, 969, 5.7696e-02, 6.1915e-02, 6.7217e-02}, {32, 937, 4.3654e-02, 4.8082e-02, 5.4202e-02},
                              {64, 873, 3.1755e-02, 3.6237e-02, 4.3377e-02}, {128, 745, 2.3045e-02, 2.7674e-02, 3.7027e-02}};
  const auto points = deviation(nbs14_1000(), 1, {1, 2, 4, 8, 16, 32, 64, 128});
  for (std::size_t k = 0; k < rows.size(); ++k) {
    const DeviationPoint& p = points[k];
    EXPECT_EQ(p.terms, rows[k].terms);
    EXPECT_EQ(p.noise_type, 0) << p.factor;  // white
    EXPECT_NEAR(p.deviation, rows[k].value, half_unit(rows[k].value, 5));
    // Above 100 degrees of freedom, Stable32's bounds are those of 68.0 %, not 68.27 %, to one unit of the last digit. Below, its chi-square
    // quantiles differ from the exact ones by up to 1.5e-4 of the bound.
    const double sixty_eight = p.edf > 100 ? 0.680 : 0.6826895;
    const auto bound = [&](double probability) { return p.deviation * std::sqrt(p.edf / chi_square_quantile(probability, p.edf)); };
    const auto allowed = [&](double printed) { return p.edf > 100 ? 3 * half_unit(printed, 5) : 2e-4 * printed; };
    EXPECT_NEAR(bound(0.5 + sixty_eight / 2), rows[k].low, allowed(rows[k].low)) << p.factor;
    EXPECT_NEAR(bound(0.5 - sixty_eight / 2), rows[k].high, allowed(rows[k].high)) << p.factor;
    EXPECT_DOUBLE_EQ(p.lower_68, bound(0.841344746068543));
    EXPECT_DOUBLE_EQ(p.upper_68, bound(0.158655253931457));
    EXPECT_LT(p.lower_95, p.lower_68);
    EXPECT_GT(p.upper_95, p.upper_68);
  }
}

void expect_edf(noise::Variance v, int alpha, const std::vector<std::size_t>& factors, const std::vector<double>& published, int decimals) {
  for (std::size_t k = 0; k < factors.size(); ++k) {
    v.m = factors[k];
    EXPECT_NEAR(noise::degrees_of_freedom(v, alpha), published[k], 0.5 * std::pow(10, -decimals) * (1 + 1e-6)) << "alpha " << alpha << " m " << v.m;
  }
}

TEST(DegreesOfFreedom, AreThePublished) {
  const std::vector<std::size_t> octaves{1, 2, 4, 8, 16, 32, 64, 128}, some{1, 4, 16, 64, 128};
  const noise::Variance oadev{.order = 2, .points = 1001};
  expect_edf(oadev, 0, octaves, {782.0303, 540.6812, 306.0916, 165.9878, 86.3701, 43.3512, 21.2395, 9.551}, 3);
  expect_edf({.order = 2, .points = 1001, .modified = true}, 0, octaves, {782.0303, 478.9962, 239.9958, 118.8731, 58.2752, 27.9797, 12.8485, 5.3215},
             3);
  expect_edf({.order = 2, .points = 1001, .overlapping = false}, 0, octaves, {782.0303, 356.3222, 171.391, 84.1013, 41.1789, 20.2943, 9.561, 4.2353},
             3);
  expect_edf({.order = 3, .points = 1001}, 0, octaves, {608.5487, 451.6717, 256.7196, 139.7089, 72.5414, 37.2074, 17.123, 7.1513}, 3);
  expect_edf(oadev, 2, some, {514.04, 511.75, 502.61, 466.56, 420.28}, 2);
  expect_edf(oadev, 1, some, {635.47, 388.89, 190.62, 76.16, 43.64}, 2);
  expect_edf(oadev, -1, some, {895.25, 282.36, 71.31, 16.54, 7.39}, 2);
  expect_edf(oadev, -2, some, {762.29, 227.09, 56.41, 12.97, 5.73}, 2);
}

/// The asymptotic forms must continue the exact sums; SP 1065 states them to a few percent.
TEST(DegreesOfFreedom, HaveNoStepWhereTheFormChanges) {
  for (const int order : {2, 3})
    for (int alpha = 2; alpha >= 2 - 2 * order; --alpha)
      for (const bool modified : {false, true})
        for (const std::size_t averages : {5u, 50u, 5000u}) {
          double before = 0;
          for (const std::size_t m : {24u, 25u, 26u, 32u, 33u, 34u, 35u, 36u}) {
            double edf = noise::degrees_of_freedom({.order = order, .points = averages * m + 1, .m = m, .modified = modified}, alpha);
            if (alpha == 2 && !modified) edf /= static_cast<double>(m);  // every sample of white phase counts
            if (before > 0) {
              EXPECT_NEAR(edf / before, 1, alpha == 1 ? 0.12 : 0.05) << order << " " << alpha << " " << modified << " " << averages << " " << m;
            }
            before = edf;
          }
        }
}

std::vector<double> white(std::size_t n, std::uint64_t seed) {
  std::vector<double> rate(n);
  RandomStream(seed, "white").normals(0, rate);
  return rate;
}

/// The exponent from 333 averages scatters by 0.11.
TEST(NoiseType, IsFoundAtEveryAveragingTime) {
  const std::vector<double> w = white(100'001, 1);
  std::vector<double> quantization(w.size() - 1), walk(w.size() - 1);
  double sum = 0;
  for (std::size_t i = 0; i + 1 < w.size(); ++i) quantization[i] = w[i + 1] - w[i], walk[i] = sum += w[i];
  const auto types = [](const std::vector<double>& rate, Kind kind) {
    std::vector<int> found;
    for (const DeviationPoint& p : deviation(rate, 1, {1, 3, 10, 30, 100, 300}, kind)) found.push_back(p.noise_type);
    return found;
  };
  using ::testing::Each;
  for (const Kind kind : {Kind::overlapping_allan, Kind::overlapping_hadamard}) {
    EXPECT_THAT(types(quantization, kind), Each(2));
    EXPECT_THAT(types(w, kind), Each(0));
    EXPECT_THAT(types(walk, kind), Each(-2));
  }
}

/// 95 % of the bounds of independent records contain the true deviation; the band is the binomial one of 400 records at 99.9 %.
TEST(Deviation, BoundsHoldAsOftenAsTheySay) {
  constexpr int records = 400;
  const std::vector<std::size_t> factors{1, 8, 64, 333};
  std::vector<int> held_95(factors.size()), held_68(factors.size());
  for (int record = 0; record < records; ++record) {
    const auto points = deviation(white(1000, static_cast<std::uint64_t>(record)), 1, factors);
    for (std::size_t k = 0; k < factors.size(); ++k) {
      const double truth = 1 / std::sqrt(static_cast<double>(factors[k]));
      held_95[k] += points[k].lower_95 <= truth && truth <= points[k].upper_95;
      held_68[k] += points[k].lower_68 <= truth && truth <= points[k].upper_68;
    }
  }
  // With fewer than 30 averages, the type is uncertain and the wider bounds are used: they may contain the truth more often.
  for (std::size_t k = 0; k < factors.size(); ++k) {
    const double slack = factors[k] > 33 ? records : 0;
    EXPECT_GE(held_95[k], binomial_quantile(0.0005, records, 0.95)) << factors[k];
    EXPECT_LE(held_95[k] - slack, binomial_quantile(0.9995, records, 0.95)) << factors[k];
    EXPECT_GE(held_68[k], binomial_quantile(0.0005, records, 0.6827)) << factors[k];
    EXPECT_LE(held_68[k] - slack, binomial_quantile(0.9995, records, 0.6827)) << factors[k];
  }
}

TEST(Deviation, DoesNotDependOnTheMeanNorOnTheOrderOfFactors) {
  std::vector<double> rate = white(5000, 3);
  const auto before = deviation(rate, 0.01, {1, 7, 100, 1600});
  for (double& r : rate) r += 1e6;
  const auto after = deviation(rate, 0.01, {1600, 100, 7, 1});
  // Readings near 1e6 are rounded to 1e-10.
  for (std::size_t k = 0; k < 4; ++k) EXPECT_NEAR(after[3 - k].deviation, before[k].deviation, 1e-9 * before[k].deviation + 1e-10);
}

TEST(Deviation, TakesAnyLengthAndRefusesTheRest) {
  for (const Kind kind : {Kind::allan, Kind::overlapping_allan, Kind::modified_allan, Kind::hadamard, Kind::overlapping_hadamard, Kind::total})
    for (std::size_t n = 3; n < 70; ++n) {
      std::vector<std::size_t> all;
      for (std::size_t m = 1; m <= n + 1; ++m) all.push_back(m);
      for (const DeviationPoint& p : deviation(white(n, n), 1, all, kind)) {
        EXPECT_TRUE(std::isfinite(p.deviation) && p.deviation >= 0) << names.at(kind) << " " << n << " " << p.factor;
        EXPECT_TRUE(std::isfinite(p.upper_95) && p.edf > 0.3) << names.at(kind) << " " << n << " " << p.factor << " " << p.edf;
      }
    }
  const std::vector<double> constant(100, 9.81);
  for (const DeviationPoint& p : deviation(constant, 1, averaging_factors(100))) EXPECT_EQ(p.deviation, 0);
  EXPECT_THROW(deviation(white(2, 1), 1, {1}), Error);
  EXPECT_THROW(deviation(white(9, 1), 0, {1}), Error);
  EXPECT_THROW(deviation(white(9, 1), 1, {0}), Error);
  std::vector<double> wrong = white(9, 1);
  wrong[4] = NAN;
  EXPECT_THROW(deviation(wrong, 1, {1}), Error);
}

TEST(AveragingFactors, DoubleEveryFourthAndEndAtAThird) {
  EXPECT_THAT(averaging_factors(60), testing::ElementsAre(1, 2, 3, 4, 5, 6, 7, 8, 10, 12, 14, 16, 20));
  EXPECT_THAT(averaging_factors(3), testing::ElementsAre(1));
}

}  // namespace
}  // namespace imulab
