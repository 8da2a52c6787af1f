// Any bytes where a program keeps what it goes on from: a fleet's store, the folder of a shared work.
#include "imulab/core/part_file.hpp"
#include "imulab/core/sealed.hpp"
#include "imulab/core/shared_work.hpp"
#include "imulab/error.hpp"
#include "imulab/fleet.hpp"
#include "imulab/fleet/store/database.hpp"
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

namespace {

/// A work of four blocks, each of which gives two numbers. Whatever there was, its results are taken once, in order, or not at all.
void take_all(Sharing sharing) {
  constexpr std::size_t blocks = 4;
  std::size_t taken = 0;
  SharedWork work;
  work.count = blocks;
  work.work = [](std::size_t block) {
    const double numbers[2] = {static_cast<double>(block), 0.5};
    return bytes_of(numbers, 2);
  };
  work.take = [&](std::size_t block, const std::string& result) {
    double numbers[2] = {};
    read_numbers(result, numbers, 2);
    if (block != taken++) finding("blocks out of order");
  };
  sharing.identity = "fuzzed";
  try {
    for_each(work, &sharing);
    if (taken != blocks) finding("not every block was taken");
  } catch (const Error&) {
  }
}

/// Calls `each` with a number and the bytes behind it, whose size is a byte.
void for_records(std::string_view left, const std::function<void(unsigned number, std::string_view bytes)>& each) {
  while (left.size() >= 2) {
    const std::string_view bytes = left.substr(2, static_cast<unsigned char>(left[1]));
    each(static_cast<unsigned char>(left[0]), bytes);
    left.remove_prefix(2 + bytes.size());
  }
}

}  // namespace

/// The results that a process left: bytes as they are, or, after an odd first byte, blocks with good seals.
void checkpoint(std::string_view bytes) {
  if (bytes.empty()) return;
  static const TemporaryFolder folder;
  const fs::path place = folder / "work";
  fs::remove_all(place);
  fs::create_directories(place);
  SealedWriter header;
  header.text("imulab.checkpoint/3"), header.text("fuzzed"), header.seal();
  std::string file = header.bytes();
  if ((bytes[0] & 1) == 0) file += bytes.substr(1);
  if ((bytes[0] & 1) != 0)
    for_records(bytes.substr(1), [&](unsigned number, std::string_view result) {
      SealedWriter record;
      record.number(number % 6U), record.text(result), record.seal();
      file += record.bytes();
    });
  write_bytes(place / "results", file);
  take_all({.checkpoint = place});
}

/// The second of two parts: bytes as they are, or, after an odd first byte, fields with good seals: 0 a number, 1 a text, 2 a seal.
void part(std::string_view bytes) {
  if (bytes.empty()) return;
  const auto first = std::make_shared<PartWriter>(PartNumber{1, 2}, "work");
  const double numbers[2] = {0, 0.5};
  first->begin_work("fuzzed", 4);
  for (int block = 0; block < 2; ++block) first->add(bytes_of(numbers, 2));
  first->end_work();
  SealedWriter second;
  if ((bytes[0] & 1) != 0)
    for_records(bytes.substr(1), [&](unsigned kind, std::string_view field) {
      if (kind % 3 == 0) second.number(field.empty() ? 0 : static_cast<unsigned char>(field[0]));
      if (kind % 3 == 1) second.text(field);
      if (kind % 3 == 2) second.seal();
    });
  const std::string file = (bytes[0] & 1) != 0 ? second.bytes() : std::string(bytes.substr(1));
  try {
    take_all({.joined = std::make_shared<PartReader>(std::vector{PartReader::memory("1", first->bytes()), PartReader::memory("2", file)})});
  } catch (const Error&) {
  }
}

}  // namespace imulab::fuzz
