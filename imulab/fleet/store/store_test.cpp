#include "imulab/error.hpp"
#include "imulab/files.hpp"
#include "imulab/fleet.hpp"
#include "imulab/fleet/store/database.hpp"
#include "imulab/fleet/store/numbers.hpp"
#include "imulab/formats/text/decimal.hpp"
#include "imulab/formats/text/file.hpp"
#include "imulab/rig/rig_errors.hpp"

#include <gmock/gmock.h>

#include "tests/fleet_draw.hpp"
#include "tests/temporary_folder.hpp"
#include <array>
#include <csignal>
#include <sys/wait.h>
#include <unistd.h>

namespace imulab {
namespace {

using fleet::Access;
using ::testing::AllOf;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::SizeIs;
using ::testing::ThrowsMessage;

FleetSession a_session(const std::string& content) {
  const SourceFile recording{.file = "recording.csv", .sha256 = "of the recording", .bytes = 5, .accel_temperature = {}, .gyro_temperature = {}};
  return {"/data/" + content + "/session.toml", "sum of " + content, {recording}, "hash of " + content};
}
const FleetRequest request{"handheld", "terms=auto"};
const FleetOccasion monday{"station 1", "Ada", 1.7e9, "stamps"};

TEST(FleetStore, KeepsWhatItIsGiven) {
  const TemporaryFolder folder;
  const Calibration c = drawn_calibration(1, 7);
  const FleetSession session = a_session("one");
  {
    FleetStore store(folder / "fleet.db", Access::write);
    EXPECT_EQ(store.known(session, request), FleetStore::Known::no);
    EXPECT_TRUE(store.add_calibration(c, monday, &session, &request));
    EXPECT_FALSE(store.add_calibration(c, monday, &session, &request));
  }
  FleetStore store(folder / "fleet.db");
  EXPECT_EQ(store.known(session, request), FleetStore::Known::calibrated);
  EXPECT_EQ(store.known(session, {"static", "terms=auto"}), FleetStore::Known::no);
  ASSERT_THAT(store.units(), SizeIs(1));
  EXPECT_EQ(store.unit("1007").name, "unit 7");
  const std::vector<FleetRecord> records = store.records();
  ASSERT_THAT(records, SizeIs(1));
  EXPECT_EQ(records[0].occasion.station, "station 1");
  EXPECT_EQ(records[0].occasion.operated_by, "Ada");
  EXPECT_EQ(records[0].occasion.time, 1.7e9);
  EXPECT_EQ(records[0].session_file, session.file);
  EXPECT_EQ(store.calibration_file(records[0].id), calibration_text(c));  // to the last bit
  EXPECT_THAT(store.check().damaged, IsEmpty());
}

TEST(FleetStore, RemembersFailuresUntilTheyAreMended) {
  const TemporaryFolder folder;
  FleetStore store(folder / "fleet.db", Access::write);
  FleetSession session = a_session("one");
  store.add_failure(session, request, "no rest found");
  EXPECT_EQ(store.known(session, request), FleetStore::Known::failed);
  ASSERT_THAT(store.failures(), SizeIs(1));
  EXPECT_EQ(store.failures()[0].message, "no rest found");
  session.hash = "another content";  // of the same file
  EXPECT_EQ(store.known(session, request), FleetStore::Known::no);
  store.add_calibration(drawn_calibration(1, 7), monday, &session, &request);
  EXPECT_THAT(store.failures(), IsEmpty());
}

TEST(FleetStore, RemovedCalibrationsStayAsHistory) {
  const TemporaryFolder folder;
  FleetStore store(folder / "fleet.db", Access::write);
  store.add_calibration(drawn_calibration(1, 7), monday);
  store.add_calibration(drawn_calibration(1, 7, 1), monday);
  EXPECT_EQ(store.remove({1}, "dropped"), 1);
  EXPECT_EQ(store.remove({1}, "dropped"), 0);
  EXPECT_THAT(store.records(), SizeIs(1));
  ASSERT_THAT(store.records(0, true), SizeIs(2));
  EXPECT_EQ(store.records(0, true)[0].reason, "dropped");
  EXPECT_EQ(store.units()[0].calibrations, 1);
  EXPECT_FALSE(store.add_calibration(drawn_calibration(1, 7), monday));
}

TEST(FleetStore, RefusesWhatIsNoStoreOfThisVersion) {
  const TemporaryFolder folder;
  const auto opening = [&](const char* name) { return [=, &folder] { FleetStore(folder / name, Access::write); }; };
  folder.write("text", std::string(5000, 'x'));
  EXPECT_THAT(opening("text"), ThrowsMessage<Error>(AllOf(HasSubstr("text"), HasSubstr("not a database"))));
  { fleet::Database(folder / "other", Access::write).run("CREATE TABLE t (a)"); }
  EXPECT_THAT(opening("other"), ThrowsMessage<Error>(HasSubstr("another SQLite file; expected a fleet store")));
  { FleetStore(folder / "newer", Access::write).database().run("PRAGMA user_version = 7"); }
  EXPECT_THAT(opening("newer"), ThrowsMessage<Error>(HasSubstr("version 7; expected version 1 at most: a newer imulab wrote it")));
  { FleetStore(folder / "lost", Access::write).database().run("DROP TABLE texts"); }
  EXPECT_THAT(opening("lost"), ThrowsMessage<Error>(HasSubstr("has lost tables")));
  EXPECT_THAT([&] { FleetStore(folder / "nowhere"); }, ThrowsMessage<Error>(HasSubstr("unable to open")));
}

/// A store of ten units, as one file.
std::string ten_units(const TemporaryFolder& folder) {
  FleetStore store(folder / "ten.db", Access::write);
  for (std::uint64_t unit = 0; unit < 10; ++unit) store.add_calibration(drawn_calibration(1, unit), monday);
  store.database().run("PRAGMA wal_checkpoint(TRUNCATE)");
  return std::string(MappedFile(folder / "ten.db").text());
}

/// Everything that reads it.
std::size_t damages(const std::filesystem::path& file) {
  FleetStore store(file);
  std::size_t bytes = store.units().size() + store.failures().size();
  for (const FleetRecord& r : store.records()) bytes += store.calibration_file(r.id).size();
  return bytes > 0 ? store.check().damaged.size() : 1;
}

TEST(FleetStore, ADamagedStoreIsAnErrorOrIsFoundByTheCheck) {
  const TemporaryFolder folder;
  const std::string whole = ten_units(folder);
  const auto with_damage = [&](std::size_t place) {
    std::string damaged = whole;
    for (std::size_t k = 0; k < 16 && place + k < damaged.size(); ++k) damaged[place + k] = static_cast<char>(~damaged[place + k]);
    return folder.write("damaged.db", damaged);
  };
  int noticed = 0;
  for (std::size_t place = 0; place < whole.size(); place += whole.size() / 97) try {  // most are unused bytes of pages
      noticed += damages(with_damage(place)) > 0;
    } catch (const Error& e) {
      EXPECT_THAT(e.what(), HasSubstr("damaged.db"));
      ++noticed;
    }
  EXPECT_GT(noticed, 10);
  const std::string numbers = fleet::packed(fleet::numbers_of(drawn_calibration(1, 3)));
  const std::size_t at = whole.find(numbers.substr(0, 200));
  ASSERT_NE(at, std::string::npos);
  EXPECT_EQ(damages(with_damage(at + 100)), 1u);
  for (const std::size_t size : {whole.size() - 1, whole.size() / 2, std::size_t{4096}, std::size_t{50}})
    EXPECT_THAT(
        [&] {
          if (damages(folder.write("short.db", whole.substr(0, size))) > 0) throw Error("short.db: found by the check");
        },
        ThrowsMessage<Error>(HasSubstr("short.db")))
        << size;
}

TEST(FleetStore, OneSerialNumberIsOneUnit) {
  const TemporaryFolder folder;
  FleetStore store(folder / "fleet.db", Access::write);
  store.add_calibration(drawn_calibration(1, 7), monday);
  Calibration other = drawn_calibration(2, 7);
  other.imu = "another";
  EXPECT_THAT([&] { store.add_calibration(other, monday); },
              ThrowsMessage<Error>(HasSubstr("1007 is unit 7 in the store, and another here: two units")));
  other = drawn_calibration(2, 7);
  other.model.gyro.matrix *= 2;  // of another range
  EXPECT_THAT([&] { store.add_calibration(other, monday); }, ThrowsMessage<Error>(HasSubstr("serial number 1007: its gyro")));
  other = drawn_calibration(2, 7);
  other.model.accel.raw_unit = "m/s^2";
  EXPECT_THAT([&] { store.add_calibration(other, monday); },
              ThrowsMessage<Error>(HasSubstr("other sensors; expected one serial number for one unit")));
  EXPECT_THAT(store.records(), SizeIs(1));
  Calibration bare = drawn_calibration(2, 8);
  bare.estimated.clear();
  EXPECT_THAT([&] { store.add_calibration(bare, monday); }, ThrowsMessage<Error>(HasSubstr("has no uncertainties")));
}

TEST(FleetStore, AFullDiskLeavesTheStoreAsItWas) {
  const TemporaryFolder folder;
  FleetStore store(folder / "fleet.db", Access::write);
  store.add_calibration(drawn_calibration(1, 0), monday);
  store.database().run("PRAGMA max_page_count = " + std::to_string(store.database().number("PRAGMA page_count") + 1));
  EXPECT_THAT(
      [&] {
        for (std::uint64_t k = 1; k < 50; ++k) store.add_calibration(drawn_calibration(1, k), monday);
      },
      ThrowsMessage<Error>(HasSubstr("full; expected room to write")));
  FleetStore again(folder / "fleet.db");
  EXPECT_THAT(again.check().damaged, IsEmpty());
  EXPECT_EQ(again.units().size(), again.records().size());  // no unit without its calibration
  EXPECT_LT(again.units().size(), 5u);
}

/// A process that runs this.
template <class Work>
pid_t child(const Work& work) {
  const pid_t id = fork();
  if (id == 0) {
    int code = 0;
    try {
      work();
    } catch (const std::exception&) {
      code = 1;
    }
    _exit(code);
  }
  return id;
}

TEST(FleetStore, TwoProcessesWriteOneStore) {
  const TemporaryFolder folder;
  std::vector<pid_t> children;
  for (std::uint64_t k = 0; k < 2; ++k)
    children.push_back(child([&] {
      FleetStore store(folder / "fleet.db", Access::write);  // both make it
      for (std::uint64_t unit = 0; unit < 60; ++unit) store.add_calibration(drawn_calibration(1, unit, k), monday);
    }));
  for (const pid_t id : children) {
    int status = 0;
    waitpid(id, &status, 0);
    EXPECT_EQ(status, 0);
  }
  FleetStore store(folder / "fleet.db");
  EXPECT_THAT(store.units(), SizeIs(60));
  EXPECT_THAT(store.records(), SizeIs(120));
  EXPECT_THAT(store.check().damaged, IsEmpty());
}

TEST(FleetStore, WhatIsKilledLeavesWholeCalibrations) {
  const TemporaryFolder folder;
  std::size_t before = 0;
  for (int k = 0; k < 10; ++k) {
    std::array<int, 2> written{};  // a byte a calibration
    ASSERT_EQ(pipe(written.data()), 0);
    const pid_t id = child([&] {
      FleetStore store(folder / "fleet.db", Access::write);
      for (std::uint64_t unit = 0;; ++unit) {
        store.add_calibration(drawn_calibration(1, unit, static_cast<std::uint64_t>(k)), monday);
        if (write(written[1], "+", 1) != 1) return;
      }
    });
    close(written[1]);
    char byte = 0;
    const bool has_begun = k % 2 == 1;  // the others are killed anywhere, also while they make the store
    if (has_begun) EXPECT_EQ(read(written[0], &byte, 1), 1);
    usleep(static_cast<useconds_t>(7'919 * k));
    kill(id, SIGKILL);
    waitpid(id, nullptr, 0);
    close(written[0]);
    FleetStore store(folder / "fleet.db", Access::write);
    EXPECT_THAT(store.check().damaged, IsEmpty());
    EXPECT_GE(store.records().size(), before + (has_begun ? 1 : 0));
    before = store.records().size();
  }
}

TEST(FleetStore, MergesWhatIsMissing) {
  const TemporaryFolder folder;
  FleetStore a(folder / "a.db", Access::write), b(folder / "b.db", Access::write);
  const FleetSession shared = a_session("shared"), own = a_session("own");
  for (FleetStore* store : {&a, &b}) store->add_calibration(drawn_calibration(1, 1), monday, &shared, &request);
  a.add_calibration(drawn_calibration(1, 2), monday);
  b.add_calibration(drawn_calibration(1, 3), monday);
  b.add_calibration(drawn_calibration(1, 1, 1), {"station 2", "", 1.71e9, "declared"}, &own, &request);
  b.add_failure(a_session("bad"), request, "why");
  EXPECT_EQ(a.merge(folder / "b.db"), 2);
  EXPECT_EQ(a.merge(folder / "b.db"), 0);
  EXPECT_THAT(a.units(), SizeIs(3));
  EXPECT_THAT(a.records(a.unit("1001").id), SizeIs(2));
  EXPECT_EQ(a.known(own, request), FleetStore::Known::calibrated);
  EXPECT_THAT(a.failures(), SizeIs(1));
  EXPECT_THAT(a.check().damaged, IsEmpty());
  EXPECT_EQ(a.calibration_file(a.records(a.unit("1003").id)[0].id), calibration_text(drawn_calibration(1, 3)));
  Calibration other = drawn_calibration(1, 4);
  other.serial = "1002";
  b.add_calibration(other, monday);
  EXPECT_THAT([&] { a.merge(folder / "b.db"); }, ThrowsMessage<Error>(HasSubstr("two units with one serial number")));
  EXPECT_THAT([&] { a.merge(folder / "a.db"); }, ThrowsMessage<Error>(HasSubstr("is the store itself")));
  EXPECT_THAT(a.records(), SizeIs(4));
}

TEST(FleetTime, ReadsWhatItWrites) {
  EXPECT_EQ(time_text(1.7e9), "2023-11-14T22:13:20Z");
  EXPECT_EQ(parse_time("2023-11-14T22:13:20Z"), 1.7e9);
  EXPECT_EQ(time_text(parse_time("2024-02-29")), "2024-02-29T00:00:00Z");
  for (const char* bad : {"", "2023-02-29", "yesterday", "2023-11-14T25:00:00Z", "2023-11-14 22:13:20", "2023-11-14Z"})
    EXPECT_THROW(parse_time(bad), Error) << bad;
}

}  // namespace
}  // namespace imulab
