// The store of a fleet: units, sessions, calibrations with their covariances, and noise, in one SQLite file (docs/fleet.md, docs/formats.md).
//
// Every call that writes is one transaction: it is in the store as a whole or not at all, whatever ends the program. Several programs may write one
// store; each waits for the others. Times are seconds since 1970 (UTC).
#pragma once

#include "imulab/fleet/store/database.hpp"
#include "imulab/model/calibration.hpp"

#include <cstdint>
#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <vector>

namespace imulab {

namespace fleet {
inline constexpr int store_version = 1;
double now();  ///< s since 1970
}  // namespace fleet

/// Where and when a unit was measured.
struct FleetOccasion {
  std::string station, operated_by;
  double time = 0;
  std::string time_from;  ///< "stamps", "file", "created", "added" or "declared": where the time comes from
};

/// A session by its content.
struct FleetSession {
  std::string file, sha256;
  std::vector<SourceFile> files;
  std::string hash;  ///< of the session and of all its recordings
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
  std::optional<double> removed;
  std::string reason;  ///< of the removal
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

  fleet::Database database_;
};

/// The hash of a session and its files; reads them all. Throws Error where one cannot be read.
FleetSession hashed_session(const std::string& file, const std::string& sha256,
                            const std::vector<std::pair<std::string, std::filesystem::path>>& files);

}  // namespace imulab
