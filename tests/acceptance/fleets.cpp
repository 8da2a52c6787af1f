// Fleets drawn with known spread, drift, station bias and outliers, through a store: do the intervals of all statistics cover, and are outliers found
// at the stated rate?
#include "imulab/core/random.hpp"
#include "imulab/core/statistics.hpp"
#include "imulab/error.hpp"
#include "imulab/fleet.hpp"
#include "imulab/fleet/statistics/prior.hpp"
#include "imulab/fleet/statistics/statistics.hpp"
#include "imulab/fleet/store/database.hpp"
#include "imulab/rig/rig_errors.hpp"
#include "imulab/units.hpp"

#include <fmt/core.h>

#include "tests/acceptance/acceptance.hpp"
#include "tests/acceptance/shared_runs.hpp"
#include "tests/fleet_draw.hpp"
#include "tests/temporary_folder.hpp"
#include <cmath>

namespace imulab::acceptance {

namespace {

constexpr std::uint64_t units = 60, turns = 3;
constexpr double year = 365.25 * 86400;
constexpr double false_alarm = 0.05;

enum class Kind { drift, stations, outliers };

/// The drawn truth, in spreads of each coefficient.
double spread_of(const Coefficient& c) { return c.term == Term::matrix ? 1e-3 : c.triad == Triad::accel ? 2e-3 * unit::g : 0.3 * unit::deg; }
double nominal(const Coefficient& c) { return c.term == Term::matrix && c.row == c.column ? 1 : 0; }
double slope_of(std::uint64_t seed, std::uint64_t unit, CoefficientIndex index) {
  return 0.3 * spread_of(coefficient(index)) *
         RandomStream(seed, "drift of a unit").normal(unit * coefficient_count + static_cast<std::uint64_t>(index));
}
constexpr double station_bias = 0.25;  // of A and, with the other sign, of B
/// 15 spreads off in one coefficient: of 60 units with 21 coefficients and a rate of 5 % the limit is a distance of 10.3.
bool is_outlier(std::uint64_t unit) { return unit == 11 || unit == 42; }

void draw_fleet(std::uint64_t seed, Kind kind, FleetStore& store) {
  store.database().run("PRAGMA synchronous = OFF");  // lost with the machine, as the run
  for (std::uint64_t turn = 0; turn < turns; ++turn)
    for (std::uint64_t unit = 0; unit < units; ++unit) {
      Calibration c = drawn_calibration(seed, unit, turn);
      const bool at_b = kind == Kind::stations && (unit + turn) % 2 == 1;
      for (const CoefficientIndex index : c.estimated) {
        double more = 0;
        if (kind == Kind::drift) more = slope_of(seed, unit, index) * static_cast<double>(turn);
        if (kind == Kind::stations) more = (at_b ? -1 : 1) * station_bias * spread_of(coefficient(index));
        set_coefficient(c.model, index, coefficient_value(c.model, index) + more);
      }
      if (kind == Kind::outliers && is_outlier(unit)) c.model.gyro.matrix(1, 0) += 15e-3;
      store.add_calibration(c, {at_b ? "B" : "A", "", 1.7e9 + year * static_cast<double>(turn), "declared"});
    }
}

/// A count out of a number of trials.
struct Share {
  double hits = 0, all = 0;
  void take(bool hit) { hits += hit, all += 1; }
  void add(const Share& other) { hits += other.hits, all += other.all; }
  void fields(auto&& visit) { visit(hits, all); }
};

struct FleetShares {
  Share mean, spread, slope, bias, station_found, false_alarms, found, others, with_prior;
  double alone = 0, together = 0;  ///< sums of the squares of a new unit's errors, in spreads: without the prior, and with it
  void fields(auto&& visit) { visit(mean, spread, slope, bias, station_found, false_alarms, found, others, with_prior, alone, together); }
};

void take_spread(const FleetStatistics& f, double factor, FleetShares& s) {
  for (const CoefficientStatistics& c : f.coefficients) {
    const Coefficient& k = coefficient(c.index);
    const double truth = factor * spread_of(k);
    s.mean.take(c.fleet.mean_low <= nominal(k) && nominal(k) <= c.fleet.mean_high);
    s.spread.take(c.fleet.spread_low <= truth && truth <= c.fleet.spread_high);
  }
}

void take_drift(const FleetStatistics& f, std::uint64_t seed, FleetShares& s) {
  for (const CoefficientStatistics& c : f.coefficients)
    for (const UnitDrift& u : c.drift.units) {
      const std::string& title = f.sample.units[static_cast<std::size_t>(u.unit)];
      const double truth = slope_of(seed, std::stoull(title.substr(title.rfind(' ') + 1)) - 1000, c.index);
      s.slope.take(u.low <= truth && truth <= u.high);
    }
}

void take_stations(const FleetStatistics& f, FleetShares& s) {
  for (const CoefficientStatistics& c : f.coefficients) {
    const double truth = station_bias * spread_of(coefficient(c.index));
    for (std::size_t k = 0; k < f.sample.stations.size(); ++k) {
      const double sign = f.sample.stations[k] == "A" ? 1 : -1;
      const GaugeLevel& l = c.stations->levels[k];
      s.bias.take(l.low <= sign * truth && sign * truth <= l.high);
    }
    s.station_found.take(c.stations->p_value < false_alarm);
  }
}

/// The next unit, measured to a spread, with the fleet as its prior. Truth: the same draw without the error of measurement.
void take_next_unit(FleetStore& store, std::uint64_t seed, FleetShares& s) {
  const FleetPrior prior = fleet_prior(store);
  const Calibration truth = drawn_calibration(seed, 5000, 0, 1e-9), alone = drawn_calibration(seed, 5000, 0, 1.0);
  Calibration together = alone;
  if (!take_prior(together, prior).taken) return;
  for (const CoefficientIndex index : alone.estimated) {
    const double spread = spread_of(coefficient(index)), true_value = coefficient_value(truth.model, index);
    const double before = coefficient_value(alone.model, index) - true_value, after = coefficient_value(together.model, index) - true_value;
    s.with_prior.take(std::abs(after) <= normal_quantile(0.975) * *standard_uncertainty(together, index));
    s.alone += before * before / (spread * spread), s.together += after * after / (spread * spread);
  }
}

FleetShares shares_of(std::uint64_t seed) {
  const Kind kind = static_cast<Kind>(seed % 3);
  const TemporaryFolder folder;
  FleetStore store(folder / "fleet.db", fleet::Access::write);
  draw_fleet(seed, kind, store);
  FleetOptions options;
  options.false_alarm = false_alarm;
  const FleetStatistics f = fleet_statistics(store, options);
  FleetShares s;
  if (kind == Kind::stations) {
    take_stations(f, s);
    return s;
  }
  take_spread(f, kind == Kind::drift ? std::hypot(1, 0.3 * static_cast<double>(turns - 1)) : 1, s);
  if (kind == Kind::drift) {
    take_drift(f, seed, s);
    s.false_alarms.take(!f.search.outliers.empty());
    return s;
  }
  double found = 0;
  for (const FleetOutlier& o : f.search.outliers) {
    const std::string& title = f.sample.unit_of_row(f.sample.last[static_cast<std::size_t>(o.unit)]);
    found += is_outlier(std::stoull(title.substr(title.rfind(' ') + 1)) - 1000);
  }
  take_next_unit(store, seed, s);
  s.found.hits += found, s.found.all += 2;
  s.others.take(static_cast<double>(f.search.outliers.size()) > found);
  return s;
}

/// Coefficients of one calibration share errors, so the share is known less well than of as many independent ones: by the fleets and their 21
/// coefficients.
Check covers(const char* name, const Share& share) { return {name, share.hits / share.all, 0.93, 0.97}; }

/// At most what the binomial distribution allows in 999 of 1000 runs.
Check rate(const char* name, const Share& share) {
  return {name, share.hits / share.all, 0, binomial_quantile(0.999, share.all, false_alarm) / share.all};
}

}  // namespace

std::vector<Check> fleets(int count) {
  FleetShares s;
  for (const FleetShares& one : runs_of<FleetShares>("fleet", count, [](std::size_t k) { return shares_of(k + 1); })) {
    s.mean.add(one.mean), s.spread.add(one.spread), s.slope.add(one.slope), s.bias.add(one.bias);
    s.with_prior.add(one.with_prior), s.alone += one.alone, s.together += one.together;
    s.station_found.add(one.station_found), s.false_alarms.add(one.false_alarms), s.found.add(one.found), s.others.add(one.others);
  }
  return {covers("coverage of the mean", s.mean),
          covers("coverage of the spread", s.spread),
          covers("coverage of a unit's drift", s.slope),
          covers("coverage of a station's bias", s.bias),
          covers("coverage with the prior", s.with_prior),
          // Both together where each is right: 1/sqrt(2). The prior is wider for so few units: 0.8.
          {"a new unit's errors with the prior, of those without", std::sqrt(s.together / s.alone), 0.6, 0.85},
          {"stations' bias found", s.station_found.hits / s.station_found.all, 0.95, 1},
          rate("fleets with a false outlier", s.false_alarms),
          {"outliers of 15 spreads found", s.found.hits / s.found.all, 0.99, 1},
          rate("fleets with another outlier", s.others)};
}

}  // namespace imulab::acceptance
