// Statistics of many units: a store of calibrations with covariances in one SQLite file, fleet statistics, and a prior for the next unit
// (docs/start/fleet.md, docs/reference/fleet-store.md).
//
// Example:
//   FleetStore store("fleet.db", fleet::Access::write);
//   store.add_calibration(calibration, {.station = "A"});
//   for (const FleetUnit& unit : store.units()) std::puts(unit.serial.c_str());
//   const FleetStatistics statistics = fleet_statistics(store);
//   const PriorUse use = take_prior(calibration, fleet_prior(store));
//
// Every writing call is one transaction: its result is stored completely or not at all, even if the program is terminated. Several programs may write
// to one store; each waits for the others. Only one thread at a time may use a FleetStore. Times are seconds since 1970 (UTC); numbers are SI in the
// accelerometers' frame. Throws Error if the file is not a store, is damaged or cannot be written, and in a build without SQLite. 100,000 units with
// 42 coefficients take about 4 s and 0.3 GB. Restricted maximum likelihood: Harville 1977, doi:10.1080/01621459.1977.10480998; intervals: Hardy and
// Thompson 1996, Hartung and Knapp 2001; rules: Nelson 1984.
#pragma once

#include "imulab/calibration.hpp"
#include "imulab/eigen.hpp"

#include <array>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace imulab {

namespace fleet {
class Database;
enum class Access { read, write };  ///< write: creates the store if it does not exist
}  // namespace fleet

/// Place and time of a unit's measurement.
struct FleetOccasion {
  std::string station, operated_by;
  double time = 0;
  std::string time_from = {};  ///< source of the time: "stamps", "file", "created", "added" or "declared"
};

/// A session, identified by its content.
struct FleetSession {
  std::string file, sha256;
  std::vector<SourceFile> files = {};
  std::string hash = {};  ///< hash of the session and all its recordings
};

/// A requested calibration of a session. Each request is carried out once per session hash.
struct FleetRequest {
  std::string method, options;  ///< options: "terms=auto"
};

/// A calibration in the store, without its coefficients.
struct FleetRecord {
  std::int64_t id = 0, unit = 0;
  std::string serial, name, method, options, created, software, verdict, session_file;
  FleetOccasion occasion;
  double added = 0;
  std::optional<double> removed = {};
  std::string reason = {};  ///< reason of the removal
};

struct FleetUnit {
  std::int64_t id = 0;
  std::string serial, name;
  std::int64_t calibrations = 0, noises = 0;  ///< numbers without removed ones
  double first = 0, last = 0;                 ///< times of these calibrations; 0: none
  std::string verdict, method, station;       ///< those of the last calibration
};

struct FleetFailure {
  std::string file, method, options, message;
  double added = 0;
};

class FleetStore {
 public:
  /// Opens the store `file` for reading or writing. Throws Error if the file is not a store, has a newer version, or is damaged.
  explicit FleetStore(const std::filesystem::path& file, fleet::Access access = fleet::Access::read);
  ~FleetStore();
  FleetStore(const FleetStore&) = delete;
  FleetStore& operator=(const FleetStore&) = delete;

  // Functions that write.
  /// Returns whether a session with this hash was calibrated with this request, or failed.
  enum class Known { no, calibrated, failed };
  Known known(const FleetSession& session, const FleetRequest& request);
  /// Adds a session of the unit `serial` with IMU name `name`, calibrated or not. Returns false if the store already has it.
  bool add_session(const FleetSession& session, const std::string& serial, const std::string& name, const FleetOccasion& occasion);
  /// Adds a calibration of `session` (null: of a file) made by `request`. Returns false if the store already has it. Throws Error if the calibration
  /// has no uncertainties or includes a fleet's prior, or if its serial number belongs to another unit.
  bool add_calibration(const Calibration& calibration, const FleetOccasion& occasion, const FleetSession* session = nullptr,
                       const FleetRequest* request = nullptr);
  /// Adds the text of a noise.json for the unit `serial` with IMU name `name`. Returns false if the store already has it.
  bool add_noise(const std::string& text, const std::string& serial, const std::string& name, const FleetOccasion& occasion);
  /// Records the failure of a request with its error `message`. It replaces an earlier failure of the same session and request.
  void add_failure(const FleetSession& session, const FleetRequest& request, const std::string& message);
  /// Marks calibrations (by id) as removed for a `reason`: they stay in the store, but lists and statistics omit them. Returns their number.
  std::int64_t remove(const std::vector<std::int64_t>& calibrations, const std::string& reason);
  /// Adds everything from the store `other` that this store lacks. Returns the number of calibrations added.
  std::int64_t merge(const std::filesystem::path& other);

  // Functions that read.
  std::vector<FleetUnit> units();
  /// Returns the unit with this serial number, or with this name if it has no serial number. Throws Error unless there is exactly one.
  FleetUnit unit(const std::string& serial_or_name);
  /// Returns the calibrations of the unit with this id (0: of all units) in the order of their times; `with_removed`: also removed ones.
  std::vector<FleetRecord> records(std::int64_t unit = 0, bool with_removed = false);
  std::vector<FleetFailure> failures();  ///< returns the recorded failures
  /// Lists signs of wrong clocks: calibrations added before earlier ones, or measured after they were added.
  std::vector<std::string> clock_problems();
  /// Returns the file of the calibration with this id as it was stored.
  std::string calibration_file(std::int64_t calibration);
  /// Faults of the store itself, and existing session files that have changed. `progress` is called with the fraction done.
  struct Checked {
    std::vector<std::string> damaged, changed;
    std::int64_t files = 0, missing = 0;  ///< files that were looked for, and missing ones
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

/// Returns a session with its hash, from the name and hash of its TOML file and its recordings (name, path). Throws Error if a file cannot be read.
FleetSession hashed_session(const std::string& file, const std::string& sha256,
                            const std::vector<std::pair<std::string, std::filesystem::path>>& files);

/// Calibrations as rows in the order of their times, coefficients as columns in table order; SI, in the accelerometers' frame.
struct FleetSample {
  std::vector<CoefficientIndex> coefficients = {};
  Eigen::MatrixXd values, variances;  ///< NaN if a calibration's data did not determine the coefficient
  /// Parts of `variances` that recur in each calibration of a unit, if all are by one method; empty: zero.
  Eigen::MatrixXd constant_variances = {};
  Eigen::ArrayXd time;                                   ///< s since 1970
  std::vector<std::int64_t> calibration = {};            ///< ids in the store
  std::vector<Eigen::Index> unit, station, operated_by;  ///< indices for each row, from 0
  std::vector<std::string> units, stations, operators;   ///< their names; serial numbers for units
  std::vector<Eigen::Index> last = {};                   ///< last row of each unit, in the order of time
  std::vector<Eigen::Index> common = {};                 ///< columns common to the last calibrations of most units
  Eigen::MatrixXd mean_covariance;                       ///< mean over those last calibrations, for these columns
  std::vector<CoefficientIndex> left_out = {};           ///< coefficients without a column: every calibration has only their prior
  std::vector<std::string> serials = {};                 ///< serial numbers of the units, or names if they have none

  const std::string& unit_of_row(Eigen::Index row) const { return units[static_cast<std::size_t>(unit[static_cast<std::size_t>(row)])]; }
};

struct RandomEffects {
  Eigen::Index units = 0;
  double mean = 0, mean_low = 0, mean_high = 0;        ///< interval by Hartung and Knapp
  double spread = 0, spread_low = 0, spread_high = 0;  ///< standard deviation between units; interval from the profile of the restricted likelihood
  double measurement = 0;                              ///< root of the mean variance of a unit's measurement
  double p_value = 1;                                  ///< for the hypothesis that all units are equal
};

/// The rules of Nelson (1984) for single values.
struct RunRule {
  std::string_view name;
  double false_alarm;  ///< probability that the rule fires at a unit of a stable production
};
inline constexpr std::size_t run_rule_count = 4;
const std::array<RunRule, run_rule_count>& run_rules();

struct ControlChart {
  Eigen::ArrayXd scores;  ///< for each unit: difference from the mean divided by its expected standard deviation
  std::array<std::vector<Eigen::Index>, run_rule_count> fired;  ///< units at which each rule fires
};

/// Capability of the units, without measurement uncertainty, for values that must be within `limit` of `target`.
struct Capability {
  double target = 0, limit = 0;
  double cp = 0, cp_low = 0, cp_high = 0;  ///< limit / (3 spread), with the interval of the spread
  double cpk = 0;                          ///< (limit - |mean - target|) / (3 spread)
  double outside = 0;                      ///< fraction of units outside the limits, if they are normally distributed
};
Capability capability(const RandomEffects& fleet, double target, double limit);  ///< `target` and `limit` in the unit of `fleet`

struct UnitDrift {
  Eigen::Index unit = 0;
  int calibrations = 0;
  double span = 0;                      ///< years from the first to the last calibration
  double slope = 0, low = 0, high = 0;  ///< per year, with confidence interval
  double uncertainty = 0;               ///< standard uncertainty of the slope
  /// Years from the weighted mean time of the calibrations, at which level and slope have independent errors, to the last one.
  double since_middle = 0;
  double level = 0, level_uncertainty = 0;  ///< `level_uncertainty` excludes errors common to the unit's calibrations
  double p_value = 1;                       ///< for the hypothesis of no drift
  double last = 0;                          ///< value of the line at the last calibration
};

struct FleetDrift {
  double repeatability = 0;  ///< standard deviation of a unit about its line beyond the stated uncertainties: turn-on, handling
  double degrees_of_freedom = 0;
  double p_value = 1;                 ///< for the hypothesis that the stated uncertainties explain the scatter about the lines
  std::vector<UnitDrift> units = {};  ///< units with calibrations at two or more times
};

struct GaugeLevel {
  Eigen::Index calibrations = 0;
  double bias = 0, low = 0, high = 0;  ///< difference from the mean of all levels, with interval
};

struct Gauge {
  std::vector<GaugeLevel> levels = {};  ///< all levels; one without calibrations has no bias
  /// Standard deviation of one unit at one level, beyond the stated uncertainties; 0 if no unit was measured twice.
  double repeatability = 0;
  double reproducibility = 0;  ///< standard deviation between levels, without the uncertainty of their biases
  double spread = 0;           ///< standard deviation between units
  double p_value = 1;          ///< for the hypothesis of no biases
  /// Some units were measured at several levels; if not, only the number of units separates a bias from the spread of the units.
  bool units_shared = false;
};

struct FleetOutlier {
  Eigen::Index unit = 0;
  double distance = 0;     ///< Mahalanobis distance, not squared
  int coefficients = 0;    ///< number of coefficients of the unit
  double p_value = 1;      ///< for the hypothesis that this unit belongs to the fleet
  Eigen::Index worst = 0;  ///< column with the largest single deviation from the mean
  double worst_sigmas = 0;
};

struct OutlierSearch {
  bool possible = false;   ///< false: too few units for the number of coefficients
  double false_alarm = 0;  ///< probability of any outlier in a fleet that has none
  Eigen::VectorXd mean;
  Eigen::MatrixXd spread;                   ///< covariance between units, without measurement errors
  std::vector<FleetOutlier> outliers = {};  ///< the farthest first
};

struct FleetOptions {
  double confidence = 0.95;                    ///< confidence level of every single interval
  double false_alarm = 0.01;                   ///< total probability for outliers, and for significant drifts and correlations
  std::vector<Requirement> requirements = {};  ///< limits for the values
  std::vector<Requirement> errors = {};        ///< limits for the errors of a calibration; beyond them recalibration is due
};

/// The recalibration date of a unit, and the coefficient that determines it.
struct UnitDue {
  Eigen::Index unit = 0;
  CoefficientIndex coefficient{};
  /// Seconds since 1970; infinite: not within 20 years. A time at or before the last calibration: that one exceeds the limit.
  double time = 0;
};

struct CoefficientStatistics {
  CoefficientIndex index{};
  double size = 1;        ///< SI value of one user unit
  std::string unit = {};  ///< user unit; SI if there is none
  RandomEffects fleet;    ///< from the last calibration of each unit, without outliers
  ControlChart chart;     ///< chart of `rows`
  /// Rows of the sample: last calibrations that have this coefficient, in the order of time.
  std::vector<Eigen::Index> rows = {};
  double control = 0;  ///< three standard deviations of a unit with average measurement uncertainty
  std::optional<Capability> capability = {};
  FleetDrift drift;
  std::optional<RandomEffects> mean_drift = {};  ///< slopes of the units, per year
  std::optional<Gauge> stations, operators;
  /// All units with this coefficient; empty if no error limit is given or no drift is known.
  std::vector<UnitDue> due = {};
};

struct SignificantDrift {
  CoefficientIndex index;
  UnitDrift drift;
};

struct SignificantCorrelation {
  CoefficientIndex a, b;
  double correlation = 0;  ///< between units, without the correlation of the measurement errors
};

struct FleetStatistics {
  FleetSample sample;
  std::vector<CoefficientStatistics> coefficients = {};
  OutlierSearch search;         ///< its units refer to `sample.last`, its columns to `sample.common`
  Eigen::MatrixXd correlation;  ///< between the columns `sample.common`; zero if a coefficient has no spread
  std::vector<SignificantCorrelation> correlations = {};
  std::vector<SignificantDrift> drifts = {};  ///< significant changes beyond the uncertainties of the calibrations
  std::vector<UnitDue> due = {};              ///< one row per unit, earliest first
};

/// Returns the statistics of the calibrations in `store`; `options`: confidence, levels and limits; `method`: one method, empty: all. Throws Error if
/// there are none.
FleetStatistics fleet_statistics(FleetStore& store, const FleetOptions& options = {}, const std::string& method = "");

/// The predicted coefficients of the fleet's next unit, in the accelerometers' frame, SI.
struct FleetPrior {
  std::string fleet = {};  ///< source in notes: "fleet.db"
  double units = 0;        ///< number of units without outliers
  std::string accel_unit, gyro_unit;
  std::vector<CoefficientIndex> coefficients = {};
  Eigen::VectorXd mean;
  Eigen::MatrixXd covariance;  ///< covariance of a unit that was not yet measured
  /// Sizes of the terms over temperature, one sigma about zero, SI, by the names of their effects (ImuDeclaration::effect_sigmas).
  std::map<std::string, double, std::less<>> effect_sigmas = {};
};

/// The result of combining a calibration with a prior.
struct PriorUse {
  bool taken = false;   ///< false: the unit contradicts the fleet, and its calibration is unchanged
  double distance = 0;  ///< Mahalanobis distance of the calibration from the fleet's mean
  double p_value = 1;   ///< for the hypothesis that the unit belongs to this fleet
  /// Coefficients that the data did not determine; they have the values that the fleet predicts.
  std::vector<CoefficientIndex> filled = {};
};

/// Converts the calibration to the accelerometers' frame and adds `prior` as an observation. A coefficient that the data did not determine gets its
/// prediction given the others, which do not become more certain by it. The prior is not used if its p-value is below 0.001. Throws Error if the
/// units of the readings differ from the fleet's, or if calibration and fleet have no coefficient in common.
PriorUse take_prior(Calibration& calibration, const FleetPrior& prior);

/// Returns the prior for the next unit from the store's units. Throws Error if their readings differ in units, or if there are too few.
FleetPrior fleet_prior(FleetStore& store);

}  // namespace imulab
