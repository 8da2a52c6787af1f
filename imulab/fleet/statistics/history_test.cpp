// Drift, gauge and control of drawn fleets.
#include "imulab/core/random.hpp"
#include "imulab/fleet.hpp"
#include "imulab/fleet/statistics/control.hpp"
#include "imulab/fleet/statistics/drift.hpp"
#include "imulab/fleet/statistics/gauge.hpp"

#include <gmock/gmock.h>

#include <cmath>
#include <cstdio>
#include <ctime>

namespace imulab {
namespace {

/// 30 units with five calibrations in four years, which drift by 0.5 per year with a spread of 0.2 and repeat to `repeat`.
DriftInput drifting(std::uint64_t seed, double repeat, std::vector<double>& slopes) {
  const RandomStream unit(seed, "unit"), error(seed, "error"), again(seed, "again"), size(seed, "size");
  constexpr Eigen::Index units = 30, times = 5;
  DriftInput in{{}, Eigen::ArrayXd(units * times), Eigen::ArrayXd(units * times), Eigen::ArrayXd(units * times)};
  for (Eigen::Index i = 0; i < units; ++i) {
    slopes.push_back(0.5 + 0.2 * unit.normal(static_cast<std::uint64_t>(2 * i)));
    for (Eigen::Index j = 0; j < times; ++j) {
      const Eigen::Index k = i * times + j;
      const auto draw = static_cast<std::uint64_t>(k);
      const double u = 0.5 + size.uniform(draw);
      in.unit.push_back(i);
      in.time[k] = 2020 + static_cast<double>(j) + 0.3 * size.uniform(draw + 1000);
      in.variances[k] = u * u;
      in.values[k] = 5 * unit.normal(static_cast<std::uint64_t>(2 * i + 1)) + slopes.back() * (in.time[k] - 2020) + u * error.normal(draw) +
                     repeat * again.normal(draw);
    }
  }
  return in;
}

TEST(Drift, IntervalsCoverTheTruth) {
  // 300 fleets of 30 units: 9000 intervals, the share that covers known to 0.25 %.
  for (const double repeat : {0.0, 1.0}) {
    int covered = 0, all = 0;
    double repeatability = 0;
    for (std::uint64_t seed = 1; seed <= 300; ++seed) {
      std::vector<double> slopes;
      const FleetDrift d = fleet_drift(drifting(seed, repeat, slopes));
      repeatability += d.repeatability / 300;
      for (const UnitDrift& u : d.units) {
        const double truth = slopes[static_cast<std::size_t>(u.unit)];
        covered += u.low <= truth && truth <= u.high, all += 1;
        EXPECT_NEAR(u.last, u.level + u.slope * u.since_middle, 1e-9) << "the line at the last calibration";
      }
    }
    std::printf("drift, repeatability %g (found %.2f): the interval covers in %.2f %%\n", repeat, repeatability, 100.0 * covered / all);
    EXPECT_EQ(all, 9000);
    EXPECT_GE(covered, 0.93 * all);
    EXPECT_LE(covered, 0.97 * all);
    EXPECT_NEAR(repeatability, repeat, 0.2);  // without any, half of the estimates are above zero
  }
}

TEST(Drift, OfFewCalibrations) {
  DriftInput in{{0, 0, 1, 2, 2}, Eigen::ArrayXd(5), Eigen::ArrayXd(5), Eigen::ArrayXd::Constant(5, 0.01)};
  in.time << 2020, 2022, 2020, 2021, 2021;
  in.values << 1, 3, 7, 1, 2;
  const FleetDrift d = fleet_drift(in);
  ASSERT_EQ(d.units.size(), 1u);  // one calibration, or two at one time, are no history
  EXPECT_EQ(d.units[0].unit, 0);
  EXPECT_NEAR(d.units[0].slope, 1, 1e-12);
  EXPECT_NEAR(d.units[0].high - 1, 1.95996 * std::sqrt(0.02) / 2, 1e-5);
  EXPECT_NEAR(d.units[0].last, 3, 1e-12);
  EXPECT_TRUE(fleet_drift({}).units.empty());
}

/// 60 units with a spread of 2, at three stations with biases -0.5, 0, 0.5; each unit at one of them, or at two.
GaugeInput at_stations(std::uint64_t seed, bool shared, double repeat) {
  const RandomStream unit(seed, "unit"), error(seed, "error"), again(seed, "again"), size(seed, "size");
  constexpr Eigen::Index units = 60;
  const Eigen::Index each = shared ? 2 : 1;
  GaugeInput in{{}, {}, 3, Eigen::ArrayXd(units * each), Eigen::ArrayXd(units * each)};
  for (Eigen::Index i = 0; i < units; ++i)
    for (Eigen::Index j = 0; j < each; ++j) {
      const Eigen::Index k = i * each + j, station = (i + j) % 3;
      const auto draw = static_cast<std::uint64_t>(k);
      const double u = 0.3 + 0.4 * size.uniform(draw);
      in.unit.push_back(i);
      in.level.push_back(station);
      in.variances[k] = u * u;
      in.values[k] = 10 + 2 * unit.normal(static_cast<std::uint64_t>(i)) + 0.5 * static_cast<double>(station - 1) + u * error.normal(draw) +
                     repeat * again.normal(draw);
    }
  return in;
}

TEST(GaugeLevels, IntervalsCoverTheTruth) {
  // 2000 fleets with three biases each: the share that covers is known to 0.4 %.
  for (const auto& [shared, repeat] : {std::pair{true, 0.5}, {true, 0.0}, {false, 0.0}}) {
    int covered = 0, found = 0;
    constexpr int fleets = 2000;
    for (std::uint64_t seed = 1; seed <= fleets; ++seed) {
      const Gauge g = compare_levels(at_stations(seed, shared, repeat));
      EXPECT_EQ(g.units_shared, shared);
      for (int a = 0; a < 3; ++a)
        covered += g.levels[static_cast<std::size_t>(a)].low <= 0.5 * (a - 1) && 0.5 * (a - 1) <= g.levels[static_cast<std::size_t>(a)].high;
      found += g.p_value < 0.05;
    }
    std::printf("stations, units %s, repeatability %g: the interval covers in %.2f %%, a bias is found in %.1f %%\n",
                shared ? "shared" : "not shared", repeat, 100.0 * covered / (3 * fleets), 100.0 * found / fleets);
    EXPECT_GE(covered, 0.93 * 3 * fleets);
    EXPECT_LE(covered, 0.97 * 3 * fleets);
    EXPECT_GE(found, (shared ? 0.9 : 0.05) * fleets);  // units that were at two stations show what others hide in their spread
  }
}

TEST(GaugeLevels, TimeIsLinearInTheCalibrationsOfAUnit) {
  constexpr Eigen::Index each = 30'000;  // quadratic: 7e8 pairs in each of several fits, more than 5 s; linear: 20 ms
  const RandomStream error(1, "error");
  GaugeInput in{{}, {}, 3, Eigen::ArrayXd(2 * each), Eigen::ArrayXd::Constant(2 * each, 0.01)};
  for (Eigen::Index k = 0; k < 2 * each; ++k) {
    in.unit.push_back(k % 5), in.level.push_back(k % 3);
    in.values[k] = 0.1 * error.normal(static_cast<std::uint64_t>(k)) + static_cast<double>(k % 5) + 0.05 * static_cast<double>(k % 3);
  }
  const std::clock_t begin = std::clock();
  const Gauge g = compare_levels(in);
  EXPECT_LT(static_cast<double>(std::clock() - begin) / CLOCKS_PER_SEC, 2);
  EXPECT_NEAR(g.levels[2].bias - g.levels[0].bias, 0.1, 0.005);  // 5 sigma: 0.1 sqrt(2/20000) = 0.001
}

TEST(GaugeLevels, OneStationHasNoBias) {
  GaugeInput in = at_stations(1, true, 0);
  in.level.assign(in.level.size(), 1);
  const Gauge g = compare_levels(in);
  EXPECT_EQ(g.levels[1].bias, 0);
  EXPECT_EQ(g.p_value, 1);
  EXPECT_EQ(g.levels[0].calibrations, 0);
}

TEST(ControlChart, RulesFireAtTheStatedRate) {
  constexpr Eigen::Index units = 400'000;
  const RandomStream draw(1, "steady");
  Eigen::ArrayXd y(units);
  for (Eigen::Index i = 0; i < units; ++i) y[i] = 3 + 2.5 * draw.normal(static_cast<std::uint64_t>(i));
  const RandomEffects fleet{.units = units, .mean = 3, .spread = 2};
  const ControlChart chart = control_chart(y, Eigen::ArrayXd::Constant(units, 2.25), fleet);  // 2^2 + 1.5^2 = 2.5^2
  for (std::size_t k = 0; k < run_rule_count; ++k) {
    const double expected = run_rules()[k].false_alarm * static_cast<double>(units), found = static_cast<double>(chart.fired[k].size());
    std::printf("%s: %.0f times, expected %.0f\n", std::string(run_rules()[k].name).c_str(), found, expected);
    EXPECT_NEAR(found, expected, 10 * std::sqrt(expected));  // runs come in clusters: 4 standard deviations of clusters of up to six
    EXPECT_FALSE(stands_out(chart, k));
    ControlChart twice = chart;
    twice.fired[k].insert(twice.fired[k].end(), chart.fired[k].begin(), chart.fired[k].end());
    EXPECT_TRUE(stands_out(twice, k));
  }
}

TEST(ControlChart, FindsAStepATrendAndOneValue) {
  const RandomEffects fleet{.units = 30, .mean = 0, .spread = 1};
  const auto fired = [&](const Eigen::ArrayXd& y) { return control_chart(y, Eigen::ArrayXd::Constant(y.size(), 1e-6), fleet).fired; };
  Eigen::ArrayXd y = Eigen::ArrayXd::LinSpaced(30, 0, 29).unaryExpr([](double i) { return std::fmod(i, 2) == 0 ? 0.5 : -0.5; });
  for (const auto& rule : fired(y)) EXPECT_TRUE(rule.empty());
  Eigen::ArrayXd one = y, step = y, trend = y, pair = y;
  one[12] = 4;
  EXPECT_THAT(fired(one)[0], ::testing::ElementsAre(12));
  step.tail(10) = step.tail(10).abs();
  EXPECT_FALSE(fired(step)[1].empty());
  trend.segment(10, 6) = Eigen::ArrayXd::LinSpaced(6, -1, 1);
  EXPECT_FALSE(fired(trend)[2].empty());
  pair[5] = pair[7] = 2.5;
  EXPECT_THAT(fired(pair)[3], ::testing::ElementsAre(7));
}

TEST(Capability, IsThatOfTheUnitsThemselves) {
  const RandomEffects fleet{.units = 50, .mean = 1, .spread = 2, .spread_low = 1.5, .spread_high = 3};
  const Capability c = capability(fleet, 0, 9);
  EXPECT_DOUBLE_EQ(c.cp, 1.5);
  EXPECT_DOUBLE_EQ(c.cp_low, 1.0);
  EXPECT_DOUBLE_EQ(c.cp_high, 2.0);
  EXPECT_DOUBLE_EQ(c.cpk, 8.0 / 6);
  EXPECT_NEAR(c.outside, 3.167e-5 + 2.87e-7, 1e-7);  // beyond 4 and 5 standard deviations
}

}  // namespace
}  // namespace imulab
