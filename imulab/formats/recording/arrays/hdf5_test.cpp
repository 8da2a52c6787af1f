// HDF5 files that h5py wrote (tests/recordings/hdf5_files.py).
#include "imulab/formats/recording/signals.hpp"

#include <gmock/gmock.h>

#include "tests/recording_files.hpp"

// For the sanitizers: damaged files ask for more memory than there is.
extern "C" const char* __asan_default_options() { return "allocator_may_return_null=1"; }

namespace imulab {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;

TEST(Hdf5, DatasetsInGroups) {
  TableRequest request{.file = recording_file("groups.h5"), .topic = "/imu/t"};
  if (built_without(request)) GTEST_SKIP();
  const auto tables = format_of(request).describe(request);
  ASSERT_EQ(tables.size(), 2u);
  EXPECT_EQ(tables[0].name, "/baro/height");
  EXPECT_THAT(column_texts(tables[1]),
              ElementsAre("/imu/accel.1 [m/s^2]", "/imu/accel.2 [m/s^2]", "/imu/accel.3 [m/s^2]", "/imu/counts.1", "/imu/counts.2", "/imu/counts.3",
                          "/imu/gyro.1", "/imu/gyro.2", "/imu/gyro.3", "/imu/stamp", "/imu/t"));
  expect_columns(request, {"/imu/gyro.1", "/imu/gyro.2", "/imu/gyro.3"}, fixture_gyro);
  expect_columns(request, {"/imu/accel.1", "/imu/accel.2", "/imu/accel.3"}, fixture_accel);
  expect_columns(request, {"/imu/accel.3", "/imu/accel.2"}, [](std::size_t i, std::size_t c) { return fixture_accel(i, 2 - c); });
  expect_columns(request, {"/imu/counts.1", "/imu/counts.2", "/imu/counts.3"}, fixture_counts);
  EXPECT_EQ(columns_of(request, {"/imu/stamp"}).columns[0].integers.at(39), fixture_ns(39));
  EXPECT_THAT(error_of(request, {"/imu/mag"}), HasSubstr("groups.h5: /imu/accel: column /imu/mag is not there; expected one of /imu/accel.1"));
  request.topic = "/imu";
  EXPECT_THAT(error_of(request, {1}), HasSubstr("topic /imu is not there; expected one of /baro/height, /imu/accel"));
}

TEST(Hdf5, ANumberAloneMayBeTheRate) {
  if (built_without({.file = recording_file("groups.h5")})) GTEST_SKIP();
  const SignalTable table = read_tables(recording_file("groups.h5"), {"/imu/accel"}).front();
  EXPECT_EQ(table.rate_hz, 125);
  EXPECT_EQ(table.rate_name, "/imu/sampling_rate");
  const SignalTable stated = read_tables(recording_file("compound.h5")).front();
  EXPECT_EQ(stated.rate_hz, 125);
  EXPECT_EQ(stated.rate_name, "/fs") << "an attribute";
}

TEST(Hdf5, CompoundElements) {
  const TableRequest request{.file = recording_file("compound.h5")};
  if (built_without(request)) GTEST_SKIP();
  EXPECT_THAT(column_texts(format_of(request).describe(request).at(0)),
              ElementsAre("/samples.stamp", "/samples.gyro.1", "/samples.gyro.2", "/samples.gyro.3", "/samples.imu.ax", "/samples.imu.ay",
                          "/samples.imu.az"));
  expect_columns(request, {"/samples.gyro.1", "/samples.gyro.2", "/samples.gyro.3"}, fixture_gyro);
  expect_columns(request, {"/samples.imu.ax", "/samples.imu.ay", "/samples.imu.az"}, fixture_accel);
  EXPECT_EQ(columns_of(request, {1}).columns[0].integers.at(39), fixture_ns(39));
}

/// Its numbers are the first bytes of /etc/passwd, it says.
TEST(Hdf5, NoOtherFileIsRead) {
  const TableRequest request{.file = recording_file("external.h5")};
  if (built_without(request)) GTEST_SKIP();
  EXPECT_EQ(format_of(request).describe(request).at(0).rows, fixture_samples);
  EXPECT_THAT(error_of(request, {1}), HasSubstr("external.h5: /t: has its numbers in other files"));
}

/// For these the library gives zeros, or an error without a reason.
TEST(Hdf5, WhatIsNotKnownToBeReadAsWrittenIsAnError) {
  const std::pair<const char*, const char*> cases[]{{"/virtual", "is a virtual dataset, whose numbers are in other files"},
                                                    {"/partial", "was written in part, and the rest would be read as zeros"},
                                                    {"/unwritten", "was never written"},
                                                    {"/packed", "is packed by the filter 32000 (lzf), which is not known here"}};
  for (const auto& [name, says] : cases) {
    const TableRequest request{.file = recording_file("elsewhere.h5"), .topic = name};
    if (built_without(request)) GTEST_SKIP();
    EXPECT_THAT(error_of(request, {1}),
                HasSubstr(std::string("elsewhere.h5: ") + name + ": " + says + "; expected the numbers themselves in this file"));
  }
}

TEST(Hdf5, DamageIsSurvived) {  // ctest: once
  const TableRequest request{.file = recording_file("groups.h5"), .topic = "/imu/t"};
  if (built_without(request)) GTEST_SKIP();
  expect_damage_is_survived(request, {"/imu/t", "/imu/accel.1"}, 101);
  expect_damage_is_survived({.file = recording_file("compound.h5")}, {"/samples.gyro.1"}, 23);
}

}  // namespace
}  // namespace imulab
