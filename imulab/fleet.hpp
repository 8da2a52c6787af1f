// Many units: the store of their calibrations with their covariances, in one SQLite file, the statistics of a fleet, and the prior that it gives for
// its next unit (docs/start/fleet.md, docs/reference/fleet-store.md).
//
// Example:
//   FleetStore store("fleet.db", fleet::Access::write);
//   store.add_calibration(calibration, {.station = "A"});
//   for (const FleetUnit& unit : store.units()) std::puts(unit.serial.c_str());
//   const FleetStatistics statistics = fleet_statistics(store);
//   const PriorUse use = take_prior(calibration, fleet_prior(store));
//
// Every call that writes is one transaction: it is in the store as a whole or not at all, whatever ends the program. Several programs may write one
// store; each waits for the others. A FleetStore is used by one thread at a time. Times are seconds since 1970 (UTC), numbers SI in the
// accelerometers' frame. Throws Error where the file is no store, is damaged or cannot be written, and in a build without SQLite. 100,000 units of 42
// coefficients take some 4 s and 0.3 GB. Restricted maximum likelihood: Harville 1977, doi:10.1080/01621459.1977.10480998; intervals: Hardy and
// Thompson 1996, Hartung and Knapp 2001; rules: Nelson 1984.
#pragma once

#include "imulab/calibration.hpp"
#include "imulab/eigen.hpp"

#include <array>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace imulab {

namespace fleet {
class Database;
enum class Access { read, write };  ///< write: the store is made where there is none
}  // namespace fleet

/// Where and when a unit was measured.
struct FleetOccasion {
  std::string station, operated_by;
  double time = 0;
  std::string time_from = {};  ///< "stamps", "file", "created", "added" or "declared": where the time comes from
};

/// A session by its content.
struct FleetSession {
  std::string file, sha256;
  std::vector<SourceFile> files = {};
  std::string hash = {};  ///< of the session and of all its recordings
};

/// The request for a calibration of a session: each request is carried out once per session hash.
struct FleetRequest {
  std::string method, options;  ///< options: "terms=auto"
};

/// A calibration in the store, without its numbers.
struct FleetRecord {
  std::int64_t id = 0, unit = 0;
  std::string serial, name, method, options, created, software, verdict, session_file;
  FleetOccasion occasion;
  double added = 0;
  std::optional<double> removed = {};
  std::string reason = {};  ///< of the removal
};

struct FleetUnit {
  std::int64_t id = 0;
  std::string serial, name;
  std::int64_t calibrations = 0, noises = 0;  ///< those that were not removed
  double first = 0, last = 0;                 ///< times of those calibrations; 0: none
  std::string verdict, method, station;       ///< of the last one
};

struct FleetFailure {
  std::string file, method, options, message;
  double added = 0;
};

class FleetStore {
 public:
  /// Throws Error where the file is no store, is of a newer version, or is damaged.
  explicit FleetStore(const std::filesystem::path& file, fleet::Access access = fleet::Access::read);
  ~FleetStore();
  FleetStore(const FleetStore&) = delete;
  FleetStore& operator=(const FleetStore&) = delete;

  // Writing.
  /// True if a session with this hash was calibrated with this request, or failed with it.
  enum class Known { no, calibrated, failed };
  Known known(const FleetSession& session, const FleetRequest& request);
  /// A session of a unit, calibrated or not; false: the store already had it.
  bool add_session(const FleetSession& session, const std::string& serial, const std::string& name, const FleetOccasion& occasion);
  /// A calibration of a session, or of a file where there is none; false: the store already had it. Throws Error where it has no uncertainties or a
  /// fleet's prior in it, and where its unit's serial number is another unit's.
  bool add_calibration(const Calibration& calibration, const FleetOccasion& occasion, const FleetSession* session = nullptr,
                       const FleetRequest* request = nullptr);
  /// noise.json, as text; false: the store already had it.
  bool add_noise(const std::string& text, const std::string& serial, const std::string& name, const FleetOccasion& occasion);
  /// In place of an earlier failure of the same session and request.
  void add_failure(const FleetSession& session, const FleetRequest& request, const std::string& message);
  /// Removed calibrations stay in the store as history, but lists and statistics leave them out. Returns their number.
  std::int64_t remove(const std::vector<std::int64_t>& calibrations, const std::string& reason);
  /// Adds everything that the other store has and this one lacks. Returns the number of calibrations added.
  std::int64_t merge(const std::filesystem::path& other);

  // Reading.
  std::vector<FleetUnit> units();
  /// By serial number, or by name where there is none. Throws Error where there is none or several.
  FleetUnit unit(const std::string& serial_or_name);
  /// In the order of their times; of one unit (0: of all).
  std::vector<FleetRecord> records(std::int64_t unit = 0, bool with_removed = false);
  std::vector<FleetFailure> failures();
  /// Wrong clocks: calibrations that were added before earlier ones, or measured after they were added.
  std::vector<std::string> clock_problems();
  /// The calibration's file as it was stored.
  std::string calibration_file(std::int64_t calibration);
  /// Faults of the store itself, and files of sessions that exist but have changed; `progress` is called with the fraction done.
  struct Checked {
    std::vector<std::string> damaged, changed;
    std::int64_t files = 0, missing = 0;  ///< files looked for, and those that are not there
  };
  Checked check(const std::function<void(double)>& progress = {});

  fleet::Database& database() { return database_; }

 private:
  std::vector<FleetUnit> units_where(const std::string& condition, const std::string& name);
  std::int64_t unit_of(const Calibration& calibration);
  std::int64_t unit_named(const std::string& serial, const std::string& name);
  std::int64_t session_id(const FleetSession& session, std::int64_t unit, const FleetOccasion& occasion);

  std::unique_ptr<fleet::Database> owned_;
  fleet::Database& database_;
};

/// The hash of a session and its files; reads them all. Throws Error where one cannot be read.
FleetSession hashed_session(const std::string& file, const std::string& sha256,
                            const std::vector<std::pair<std::string, std::filesystem::path>>& files);

/// Rows are calibrations in the order of their times; columns coefficients in table order. SI, in the accelerometers' frame.
struct FleetSample {
  std::vector<CoefficientIndex> coefficients = {};
  Eigen::MatrixXd values, variances;  ///< NaN where a calibration's data did not determine the coefficient
  /// Parts of the variances that a unit brings again in each of its calibrations, which are all by one method; empty: zero.
  Eigen::MatrixXd constant_variances = {};
  Eigen::ArrayXd time;                                   ///< s since 1970
  std::vector<std::int64_t> calibration = {};            ///< numbers in the store
  std::vector<Eigen::Index> unit, station, operated_by;  ///< of each row, from 0
  std::vector<std::string> units, stations, operators;   ///< their names; of units with the serial number
  std::vector<Eigen::Index> last = {};                   ///< each unit's last row, in the order of their times
  std::vector<Eigen::Index> common = {};                 ///< columns that most units' last calibrations have together
  Eigen::MatrixXd mean_covariance;                       ///< of these columns, over those last calibrations
  std::vector<CoefficientIndex> left_out = {};           ///< no column: in every calibration that states them only the prior sets them
  std::vector<std::string> serials = {};                 ///< of the units, or their names where they have none

  const std::string& unit_of_row(Eigen::Index row) const { return units[static_cast<std::size_t>(unit[static_cast<std::size_t>(row)])]; }
};

struct RandomEffects {
  Eigen::Index units = 0;
  double mean = 0, mean_low = 0, mean_high = 0;        ///< interval of Hartung and Knapp
  double spread = 0, spread_low = 0, spread_high = 0;  ///< standard deviation between units; interval: profile of the restricted likelihood
  double measurement = 0;                              ///< root of the mean variance with which a unit was measured
  double p_value = 1;                                  ///< probability of such differences between units that are all the same
};

/// The rules of Nelson (1984) that apply to single values.
struct RunRule {
  std::string_view name;
  double false_alarm;  ///< probability that it fires at one unit of a steady production
};
inline constexpr std::size_t run_rule_count = 4;
const std::array<RunRule, run_rule_count>& run_rules();

struct ControlChart {
  Eigen::ArrayXd scores;  ///< of each unit: its difference from the mean in the standard deviation that it should have
  std::array<std::vector<Eigen::Index>, run_rule_count> fired;  ///< the units at which each rule fires
};

/// Capability of the units themselves, without the measurement uncertainty, for values that have to be within `limit` of `target`.
struct Capability {
  double target = 0, limit = 0;
  double cp = 0, cp_low = 0, cp_high = 0;  ///< limit / (3 spread); the interval is the spread's
  double cpk = 0;                          ///< (limit - |mean - target|) / (3 spread)
  double outside = 0;                      ///< the share of units that are outside, if they are normally distributed
};
Capability capability(const RandomEffects& fleet, double target, double limit);

struct UnitDrift {
  Eigen::Index unit = 0;
  int calibrations = 0;
  double span = 0;                      ///< years, from the first to the last
  double slope = 0, low = 0, high = 0;  ///< per year, with its interval
  double uncertainty = 0;               ///< standard, of the slope
  double since_middle = 0;              ///< years from the calibrations' weighted middle to the last; there level and slope have independent errors
  double level = 0, level_uncertainty = 0;  ///< without what is the same in each calibration of the unit
  double p_value = 1;                       ///< of so large a slope without a drift
  double last = 0;                          ///< the line's value at the last calibration
};

struct FleetDrift {
  double repeatability = 0;  ///< standard deviation of a unit about its line, beyond the uncertainties: turn-on, handling
  double degrees_of_freedom = 0;
  double p_value = 1;                 ///< of such scatter about the lines by the uncertainties alone
  std::vector<UnitDrift> units = {};  ///< those with calibrations at two times or more
};

struct GaugeLevel {
  Eigen::Index calibrations = 0;
  double bias = 0, low = 0, high = 0;  ///< from the mean of all levels, with its interval
};

struct Gauge {
  std::vector<GaugeLevel> levels = {};  ///< those without calibrations have none, and no bias
  double repeatability = 0;             ///< standard deviation of one unit at one level, beyond the uncertainties; 0 where no unit was measured twice
  double reproducibility = 0;           ///< standard deviation between levels, apart from the uncertainty of their biases
  double spread = 0;                    ///< between units
  double p_value = 1;                   ///< of such biases where there are none
  bool units_shared = false;  ///< whether units were measured at several levels; else only the number of units separates a bias from their spread
};

struct FleetOutlier {
  Eigen::Index unit = 0;
  double distance = 0;     ///< Mahalanobis, not squared
  int coefficients = 0;    ///< that it has
  double p_value = 1;      ///< of so large a distance of one unit that belongs to the fleet
  Eigen::Index worst = 0;  ///< the column that is farthest from the mean by itself
  double worst_sigmas = 0;
};

struct OutlierSearch {
  bool possible = false;   ///< false: there are too few units for so many coefficients
  double false_alarm = 0;  ///< probability of any outlier in a fleet without
  Eigen::VectorXd mean;
  Eigen::MatrixXd spread;                   ///< covariance between units, apart from the measurement
  std::vector<FleetOutlier> outliers = {};  ///< the farthest first
};

struct FleetOptions {
  double confidence = 0.95;                    ///< of every interval, each by itself
  double false_alarm = 0.01;                   ///< of outliers, and of significant drifts and correlations: of all together
  std::vector<Requirement> requirements = {};  ///< limits of the values
  std::vector<Requirement> errors = {};        ///< how large the errors of a calibration may become before the unit is due
};

/// When a unit is to be calibrated again, and the coefficient that requires it first.
struct UnitDue {
  Eigen::Index unit = 0;
  CoefficientIndex coefficient{};
  double time = 0;  ///< s since 1970; infinite: not within 20 years. At or before the last calibration: that one does not meet the limit
};

struct CoefficientStatistics {
  CoefficientIndex index{};
  double size = 1;                      ///< SI of one user unit
  std::string unit = {};                ///< the user unit; SI where there is none
  RandomEffects fleet;                  ///< of each unit's last calibration, without the outliers
  ControlChart chart;                   ///< by `rows`
  std::vector<Eigen::Index> rows = {};  ///< of the sample: the last calibrations that have this coefficient, in the order of their times
  double control = 0;                   ///< three standard deviations of a unit that is measured as well as the average
  std::optional<Capability> capability = {};
  FleetDrift drift;
  std::optional<RandomEffects> mean_drift = {};  ///< of the units' slopes, per year
  std::optional<Gauge> stations, operators;
  std::vector<UnitDue> due = {};  ///< each unit that has this coefficient; none where no error is limited, or no unit's drift is known
};

struct SignificantDrift {
  CoefficientIndex index;
  UnitDrift drift;
};

struct SignificantCorrelation {
  CoefficientIndex a, b;
  double correlation = 0;  ///< between units, without that of the measurement
};

struct FleetStatistics {
  FleetSample sample;
  std::vector<CoefficientStatistics> coefficients = {};
  OutlierSearch search;         ///< units: of the sample's `last`; columns: of its `common`
  Eigen::MatrixXd correlation;  ///< of `common` over the fleet; zero where a coefficient has no spread
  std::vector<SignificantCorrelation> correlations = {};
  std::vector<SignificantDrift> drifts = {};  ///< changes that the calibrations do not explain
  std::vector<UnitDue> due = {};              ///< the earliest first, each unit once
};

/// The statistics of these. Throws Error where there is none.
FleetStatistics fleet_statistics(FleetStore& store, const FleetOptions& options = {}, const std::string& method = "");

/// In the accelerometers' frame, SI.
struct FleetPrior {
  std::string fleet = {};  ///< where it is from, as a note names it: "fleet.db"
  double units = 0;        ///< that it rests on: without outliers
  std::string accel_unit, gyro_unit;
  std::vector<CoefficientIndex> coefficients = {};
  Eigen::VectorXd mean;
  Eigen::MatrixXd covariance;  ///< of a unit that was not measured yet
};

/// The use of a prior in a calibration.
struct PriorUse {
  bool taken = false;                         ///< false: the unit contradicts the fleet, and its calibration stays as it is
  double distance = 0;                        ///< of the calibration from the fleet's mean: Mahalanobis
  double p_value = 1;                         ///< of so large a distance of a unit of this fleet
  std::vector<CoefficientIndex> filled = {};  ///< coefficients that the data did not determine: they have the values that the fleet predicts
};

/// The calibration in the accelerometers' frame, with the prior as one observation more. A coefficient that it leaves open has afterwards what the
/// prior says of it, given the others; these do not become more certain by that. A calibration that chance puts so far from the fleet less than once
/// in a thousand does not take the prior. Throws Error where the readings' units are others than the fleet's,
/// and where the calibration and the fleet have nothing in common.
PriorUse take_prior(Calibration& calibration, const FleetPrior& prior);

/// The prior that the store's units give for the next one. Throws Error for units with readings of different kinds, and for too few.
FleetPrior fleet_prior(FleetStore& store);

}  // namespace imulab
