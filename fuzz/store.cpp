// Any bytes where a program keeps what it goes on from: a fleet's store, the folder of a shared work.
#include "imulab/fleet/store/store.hpp"

#include "imulab/core/checkpoint_folder.hpp"
#include "imulab/core/error.hpp"
#include "imulab/core/shared_work.hpp"
#include "imulab/fleet/store/sample.hpp"
#include "imulab/formats/text/file.hpp"

#include "fuzz/fuzzed_file.hpp"
#include "fuzz/targets.hpp"
#include "tests/fleet_draw.hpp"
#include "tests/temporary_folder.hpp"
#include <cstring>
#include <string>

namespace imulab::fuzz {

namespace {

namespace fs = std::filesystem;

/// A store of five calibrations, of small pages: the bytes that others change.
std::string whole_store() {
  const TemporaryFolder folder;
  const fs::path file = folder / "whole.db";
  {
    FleetStore store(file, fleet::Access::write);
    for (std::uint64_t unit = 0; unit < 4; ++unit)
      store.add_calibration(drawn_calibration(1, unit), {"1", "somebody", 1e9 + 1e6 * static_cast<double>(unit), "declared"});
    store.add_calibration(drawn_calibration(1, 0, 1), {"2", "", 1.1e9, "stamps"});
    store.add_failure({"session.toml", "00", {}, "11"}, {"static", "terms=auto"}, "not at rest");
    fleet::Database& db = store.database();
    db.run("UPDATE units SET added = 2e9; UPDATE calibrations SET added = 2e9; UPDATE failures SET added = 2e9");  // the same at any time
    db.run("PRAGMA journal_mode = DELETE; PRAGMA page_size = 512; VACUUM");
  }
  return std::string(MappedFile(file).text());
}

template <class Read>
void unless_damaged(const Read& read) {
  try {
    read();
  } catch (const Error&) {
  }
}

void read_store(FleetStore& store) {
  unless_damaged([&] { store.units(); });
  unless_damaged([&] { store.clock_problems(); });
  unless_damaged([&] { store.failures(); });
  unless_damaged([&] { store.check(); });
  unless_damaged([&] { fleet::fleet_csv(store); });
  unless_damaged([&] { fleet_statistics(store); });
  unless_damaged([&] { fleet_prior(store); });
  unless_damaged([&] {
    for (const FleetRecord& record : store.records(0, true)) unless_damaged([&] { store.calibration_file(record.id); });
  });
}

}  // namespace

/// A whole file, or changes of a whole one: three bytes of place, one of value.
void fleet_store(std::string_view bytes) {
  static const TemporaryFolder folder;
  static const std::string whole = whole_store();
  std::string file = whole;
  if (bytes.starts_with("SQLite format 3"))
    file = bytes;
  else
    for (std::size_t i = 0; i + 4 <= bytes.size() && i < 400; i += 4) {
      const auto byte = [&](std::size_t k) { return static_cast<unsigned char>(bytes[i + k]); };
      file[(byte(0) + 256U * byte(1) + 65536U * byte(2)) % file.size()] = bytes[i + 3];
    }
  const fs::path place = folder / "store.db";
  write_bytes(place, file);
  unless_damaged([&] {
    FleetStore store(place);
    read_store(store);
  });
  unless_damaged([&] {
    FleetStore store(place, fleet::Access::write);
    store.add_calibration(drawn_calibration(1, 9), {"1", "", 1.2e9, "declared"});
  });
  for (const char* more : {"store.db-wal", "store.db-shm", "store.db-journal"}) fs::remove(folder / more);
}

/// The results that another process left: bytes as they are, or, after an odd first byte, records with good checksums.
void checkpoint(std::string_view bytes) {
  if (bytes.empty()) return;
  static const TemporaryFolder folder;
  const fs::path place = folder / "work";
  fs::remove_all(place);
  fs::create_directories(place);
  write_bytes(place / "identity", "format=imulab.checkpoint/2\nfuzzed\n");
  std::string records(bytes.substr(1));
  if ((bytes[0] & 1) != 0) {
    std::string_view left = bytes.substr(1);
    records.clear();
    while (left.size() >= 2) {
      const std::string_view payload = left.substr(2, static_cast<unsigned char>(left[1]));
      records += checkpoint_record(static_cast<unsigned char>(left[0]) % 6U, payload);
      left.remove_prefix(2 + payload.size());
    }
  }
  write_bytes(place / "results-host-1-0", records);
  constexpr std::size_t parts = 4;
  std::size_t taken = 0;
  SharedWork work;
  work.count = parts;
  work.work = [](std::size_t part) {
    const double numbers[2] = {static_cast<double>(part), 0.5};
    return bytes_of(numbers, 2);
  };
  work.take = [&](std::size_t part, const std::string& result) {
    double numbers[2] = {};
    read_numbers(result, numbers, 2);
    if (part != taken++) finding("parts out of order");
  };
  const Checkpoint shared{.folder = place, .identity = "fuzzed"};
  try {
    for_each(work, &shared);
    if (taken != parts) finding("not every part was taken");
  } catch (const Error&) {
  }
}

}  // namespace imulab::fuzz
