#include "imulab/fleet/store/sample.hpp"

#include "imulab/core/random.hpp"
#include "imulab/error.hpp"
#include "imulab/fleet.hpp"
#include "imulab/fleet/statistics/stated.hpp"
#include "imulab/fleet/store/database.hpp"
#include "imulab/parallel.hpp"
#include "imulab/tasks/fleet_page.hpp"
#include "imulab/units.hpp"

#include <gmock/gmock.h>
#include <nlohmann/json.hpp>

#include "tests/fleet_draw.hpp"
#include "tests/temporary_folder.hpp"
#include <cmath>
#include <map>

namespace imulab {
namespace {

using fleet::Access;
using ::testing::HasSubstr;
using ::testing::Not;
using ::testing::ThrowsMessage;

constexpr double year_s = 365.25 * 86400;

/// 150 units, each calibrated three times in two years at two stations. accel.offset.x is 3 mg larger at station B; gyro.offset.y of unit 9 drifts by
/// 1 deg/s per year; accel.matrix.yy of unit 33 is 1 % off.
struct DrawnStore : ::testing::Test {
  TemporaryFolder folder;
  FleetStore store{folder / "fleet.db", Access::write};
  DrawnStore() {
    store.database().run("PRAGMA synchronous = OFF");  // a test's file may be lost with the machine
    for (std::uint64_t turn = 0; turn < 3; ++turn)
      for (std::uint64_t unit = 0; unit < 150; ++unit) {
        Calibration c = drawn_calibration(1, unit, turn);
        const bool b = (unit + turn) % 2 == 1;
        if (b) c.model.accel.offset.x() += 3e-3 * unit::g;
        if (unit == 9) c.model.gyro.offset.y() += static_cast<double>(turn) * unit::deg;
        if (unit == 33) c.model.accel.matrix(1, 1) += 0.01;
        store.add_calibration(c, {b ? "B" : "A", "Ada", 1.7e9 + static_cast<double>(turn) * year_s + static_cast<double>(unit) * 3600, "declared"});
      }
  }
  const CoefficientStatistics& of(const FleetStatistics& f, const char* name) {
    for (const CoefficientStatistics& c : f.coefficients)
      if (coefficient(c.index).name == name) return c;
    throw Error(name);
  }
};

TEST_F(DrawnStore, ShowsWhatWasDrawn) {
  FleetOptions options;
  options.requirements = parse_requirements("gyro.offset <= 1.5 deg/s");
  const FleetStatistics f = fleet_statistics(store, options);
  EXPECT_EQ(f.sample.units.size(), 150u);
  EXPECT_EQ(f.sample.calibration.size(), 450u);
  ASSERT_EQ(f.search.outliers.size(), 1u);
  EXPECT_EQ(f.sample.unit_of_row(f.sample.last[static_cast<std::size_t>(f.search.outliers[0].unit)]), "unit 33 1033");
  // Six standard deviations of the estimates: 1 / sqrt(2 x 148) of the spread, 1 / sqrt(149) of it for the mean.
  const CoefficientStatistics& scale = of(f, "gyro.matrix.zz");
  EXPECT_NEAR(scale.fleet.spread, 1e-3, 6 * 1.1e-3 / std::sqrt(296.0));
  EXPECT_NEAR(scale.fleet.mean, 1, 6 * 1.1e-3 / std::sqrt(149.0));
  EXPECT_NEAR(scale.fleet.measurement, 0.3e-3, 1e-9);
  EXPECT_EQ(scale.unit, "ppm");
  const CoefficientStatistics& offset = of(f, "accel.offset.x");
  ASSERT_TRUE(offset.stations);
  EXPECT_LT(offset.stations->p_value, 1e-6);
  EXPECT_LE(offset.stations->levels[1].low, 1.5e-3 * unit::g);  // half of the difference, from the mean of both
  EXPECT_GE(offset.stations->levels[1].high, 1.5e-3 * unit::g);
  EXPECT_FALSE(offset.operators);
  ASSERT_FALSE(f.drifts.empty());
  EXPECT_EQ(coefficient(f.drifts[0].index).name, "gyro.offset.y");
  EXPECT_NEAR(f.drifts[0].drift.slope, unit::deg, 0.3 * unit::deg);
  const CoefficientStatistics& gyro = of(f, "gyro.offset.z");
  ASSERT_TRUE(gyro.capability);
  EXPECT_NEAR(gyro.capability->cp, 1.5 / (3 * gyro.fleet.spread / unit::deg), 1e-9);
  EXPECT_FALSE(scale.capability);
}

TEST_F(DrawnStore, AsJsonAndTextOnAnyNumberOfThreads) {
  std::string first;
  for (const std::size_t threads : {1u, 2u}) {
    const ThreadLimit limit(threads);
    const FleetStatistics f = fleet_statistics(store);
    const std::string json = fleet_statistics_json(f);
    EXPECT_TRUE(first.empty() || first == json);
    first = json;
    const std::string text = fleet_statistics_text(f);
    EXPECT_THAT(text, HasSubstr("1 outliers (probability of any false one 1 %)\n  unit 33 1033: distance"));
    EXPECT_THAT(text, HasSubstr("unit 9 1009: gyro.offset.y"));
    EXPECT_THAT(text, HasSubstr("accel.offset.x        stations: A -"));
  }
  const auto json = nlohmann::json::parse(first);
  EXPECT_EQ(json["units"], 150);
  EXPECT_EQ(json["coefficients"].size(), 21u);
  EXPECT_EQ(json["coefficients"][0]["name"], "accel.offset.x");
  EXPECT_EQ(json["outliers"][0]["unit"], "unit 33 1033");
  EXPECT_EQ(json["coefficients"][0]["stations"]["levels"].size(), 2u);
}

/// What no calibration knows of a unit is the same in the next one by the same method: it hides no drift and no scatter, and counts between units.
TEST(FleetStatistics, WhatAUnitBringsAgainHidesNoDrift) {
  constexpr double constant = 5e-3 * unit::g,
                   drift = 1.5e-3 * unit::g;  // m/s^2, per year; the calibrations repeat to 0.6 mg, the units differ by 2 mg
  const TemporaryFolder folder;
  FleetStore store(folder / "fleet.db", Access::write);
  store.database().run("PRAGMA synchronous = OFF");
  const RandomStream unknown(4, "unknown");
  const auto calibration = [&](std::uint64_t unit, std::uint64_t year) {
    Calibration c = drawn_calibration(4, unit, year);
    c.model.accel.offset.x() += constant * unknown.normal(unit) + (unit == 9 ? drift * static_cast<double>(year) : 0);
    c.constant_covariance.setZero(c.covariance.rows(), c.covariance.cols());
    c.constant_covariance(0, 0) = constant * constant;
    c.covariance += c.constant_covariance;
    return c;
  };
  const auto add = [&](const Calibration& c, double year) { store.add_calibration(c, {"A", "Ada", 1.7e9 + year * year_s, "declared"}); };
  for (std::uint64_t unit = 0; unit < 100; ++unit)
    for (std::uint64_t year = 0; year < 5; ++year) add(calibration(unit, year), static_cast<double>(year) + 1e-4 * static_cast<double>(unit));
  const auto offset = [&](const FleetStatistics& f) { return f.coefficients.at(0); };
  const FleetStatistics f = fleet_statistics(store);
  EXPECT_EQ(coefficient(offset(f).index).name, "accel.offset.x");
  ASSERT_FALSE(f.drifts.empty());
  EXPECT_EQ(f.sample.units[static_cast<std::size_t>(f.drifts[0].drift.unit)], "unit 9 1009");
  EXPECT_NEAR(f.drifts[0].drift.slope, drift, 3 * 0.6e-3 / std::sqrt(10.0) * unit::g);  // five years: a sum of squares of 10
  EXPECT_LT(offset(f).drift.repeatability, 0.2e-3 * unit::g);
  EXPECT_LT(offset(f).fleet.spread, 3.5e-3 * unit::g);  // their values scatter by 5.4 mg, of which 5 mg are not the units'
  Calibration other = calibration(0, 5);
  other.method = "other";
  add(other, 5);
  EXPECT_TRUE(fleet_statistics(store).drifts.empty());  // of two methods, which do not share it
  EXPECT_FALSE(fleet_statistics(store, {}, "drawn").drifts.empty());
  EXPECT_THAT(store.check().damaged, testing::IsEmpty());
}

TEST(FleetStatistics, CorrelationsBetweenUnitsAreFound) {
  const TemporaryFolder folder;
  FleetStore store(folder / "fleet.db", Access::write);
  store.database().run("PRAGMA synchronous = OFF");
  for (std::uint64_t unit = 0; unit < 200; ++unit) {
    Calibration c = drawn_calibration(3, unit);
    c.model.gyro.matrix(0, 0) += 2 * (c.model.accel.matrix(0, 0) - 1);  // as one clock makes them; with the error of measurement, a tenth of it
    store.add_calibration(c, {"A", "", 1.7e9 + static_cast<double>(unit), "declared"});
  }
  const FleetStatistics f = fleet_statistics(store);
  ASSERT_FALSE(f.correlations.empty());
  EXPECT_EQ(coefficient(f.correlations[0].a).name, "accel.matrix.xx");
  EXPECT_EQ(coefficient(f.correlations[0].b).name, "gyro.matrix.xx");
  EXPECT_GT(f.correlations[0].correlation, 0.8);
  EXPECT_LE(f.correlations.size(), 2u);  // the errors of measurement have a correlation of 0.5, which is none of the units
}

/// The calibration with one more coefficient, known by itself.
void add_coefficient(Calibration& c, const char* name, double value, double sigma) {
  const Eigen::Index n = c.covariance.rows();
  c.covariance.conservativeResize(n + 1, n + 1);
  c.covariance.row(n).setZero(), c.covariance.col(n).setZero();
  c.covariance(n, n) = sigma * sigma;
  c.estimated.push_back(coefficient_index(name));
  set_coefficient(c.model, c.estimated.back(), value);
}

/// As a calibration by hand states them: the data say nothing of the cubic terms, which keep their prior; of the quadratic term of x they do in half
/// of the units and more, of that of y in some.
struct FleetWithPriors : ::testing::Test {
  TemporaryFolder folder;
  FleetStore store{folder / "fleet.db", Access::write};
  static constexpr std::uint64_t units = 60, off = 33;
  FleetWithPriors() {
    store.database().run("PRAGMA synchronous = OFF");
    const RandomStream draws(5, "quadratic");
    for (std::uint64_t unit = 0; unit < units; ++unit)
      for (const std::uint64_t turn : {0u, 1u}) {
        Calibration c = drawn_calibration(5, unit, turn);
        if (unit == off) c.model.accel.offset.x() += 0.5 * unit::g;
        add_coefficient(c, "gyro.quadratic.x", unit % 10 == 0 ? 0 : 3e-6 * draws.normal(2 * unit), unit % 10 == 0 ? 3e-5 : 1e-6);
        add_coefficient(c, "gyro.quadratic.y", unit % 10 != 0 ? 1e-18 : 3e-6 * draws.normal(2 * unit + 1), unit % 10 != 0 ? 3e-5 : 1e-6);
        add_coefficient(c, "gyro.cubic.x", 0, 3.3e-6);
        add_coefficient(c, "gyro.cubic.z", 0, 3.3e-6);
        store.add_calibration(c, {"A", "", 1.7e9 + static_cast<double>(turn) * year_s + static_cast<double>(unit), "declared"});
      }
  }
};

TEST_F(FleetWithPriors, WhatOnlyThePriorSetsIsLeftOut) {
  const FleetStatistics f = fleet_statistics(store);
  ASSERT_TRUE(f.search.possible);
  ASSERT_EQ(f.search.outliers.size(), 1u);
  EXPECT_EQ(f.sample.unit_of_row(f.sample.last[static_cast<std::size_t>(f.search.outliers[0].unit)]), "unit 33 1033");
  EXPECT_EQ(f.search.outliers[0].coefficients, 22);
  EXPECT_EQ(f.sample.left_out, select_each({"gyro.cubic.x", "gyro.cubic.z"}));
  std::map<std::string, Eigen::Index> units_of;
  for (const CoefficientStatistics& c : f.coefficients) {
    units_of[std::string(coefficient(c.index).name)] = c.fleet.units;
    EXPECT_LT(c.fleet.mean_low, c.fleet.mean_high) << coefficient(c.index).name;
  }
  EXPECT_EQ(units_of["accel.offset.x"], 59);
  EXPECT_EQ(units_of["gyro.quadratic.x"], 53);
  EXPECT_EQ(units_of["gyro.quadratic.y"], 6);
  EXPECT_FALSE(units_of.contains("gyro.cubic.x"));
  // The outlier is none of the spread: 2 mg, to six standard deviations of the estimate.
  EXPECT_NEAR(f.coefficients[0].fleet.spread, 2e-3 * unit::g, 6 * 2.1e-3 * unit::g / std::sqrt(116.0));
}

TEST_F(FleetWithPriors, WhatIsLeftOutIsNamed) {
  const FleetStatistics f = fleet_statistics(store);
  const std::string text = fleet_statistics_text(f);
  EXPECT_THAT(text, HasSubstr("Left out, since the data show nothing of them"));
  EXPECT_THAT(text, HasSubstr("gyro.cubic.x, gyro.cubic.z"));
  EXPECT_THAT(text, HasSubstr("Of 59 units, but: gyro.quadratic.x (53), gyro.quadratic.y (6)"));
  EXPECT_THAT(text, Not(HasSubstr("nine in a row")));
  EXPECT_EQ(nlohmann::json::parse(fleet_statistics_json(f))["left_out"], (nlohmann::json{"gyro.cubic.x", "gyro.cubic.z"}));
  EXPECT_THAT(fleet_page(f, "fleet.db"), HasSubstr("gyro.cubic.x, gyro.cubic.z"));
}

TEST(FleetStatistics, OfOneUnitAndOfNone) {
  const TemporaryFolder folder;
  FleetStore store(folder / "fleet.db", Access::write);
  EXPECT_THAT([&] { fleet_statistics(store); }, ThrowsMessage<Error>(HasSubstr("fleet.db: has no calibration")));
  store.add_calibration(drawn_calibration(1, 1), {"A", "", 1.7e9, "declared"});
  const FleetStatistics f = fleet_statistics(store);
  EXPECT_FALSE(f.search.possible);
  EXPECT_EQ(f.coefficients.size(), 21u);
  EXPECT_EQ(f.coefficients[0].fleet.spread, 0);
  EXPECT_THAT(fleet_statistics_text(f), HasSubstr("not tested: too few units"));
  EXPECT_TRUE(nlohmann::json::parse(fleet_statistics_json(f))["coefficients"][0]["fleet"]["spread_interval"][1].is_null());
  EXPECT_THAT([&] { fleet_statistics(store, {}, "hybrid"); }, ThrowsMessage<Error>(HasSubstr("by the method hybrid")));
  // Calibrations whose clock went back count in the order of their times.
  store.add_calibration(drawn_calibration(1, 1, 1), {"A", "", 1.6e9, "declared"});
  EXPECT_EQ(load_sample(store).last, std::vector<Eigen::Index>{1});
  EXPECT_EQ(load_sample(store).calibration, (std::vector<std::int64_t>{2, 1}));
}

}  // namespace
}  // namespace imulab
