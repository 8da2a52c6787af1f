// MATLAB files that SciPy, h5py and Octave wrote (tests/recordings/matlab_files.py and .m).
#include <gmock/gmock.h>

#include "tests/recording_files.hpp"
#include <cstdint>
#include <cstring>
#include <string>

namespace imulab {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;

TEST(Matlab, VariablesAndFieldsOfStructures) {
  for (const char* name : {"v5.mat", "v5_compressed.mat", "v73.mat", "octave_v6.mat", "octave_v7.mat"}) {
    const TableRequest request{.file = recording_file(name)};
    if (built_without(request)) GTEST_SKIP();
    expect_columns(request, {"imu.gyro.1", "imu.gyro.2", "imu.gyro.3"}, fixture_gyro);
    expect_columns(request, {"imu.accel.1", "imu.accel.2", "imu.accel.3"}, fixture_accel);
    expect_columns(request, {"imu.accel.3", "t", "imu.gyro.2"}, [](std::size_t i, std::size_t c) {
      return c == 0 ? fixture_accel(i, 2) : c == 1 ? fixture_t(i) : fixture_gyro(i, 1);
    });
    const auto stamps = columns_of(request, {"stamp"}).columns[0].integers;
    ASSERT_EQ(stamps.size(), fixture_samples) << name;
    EXPECT_EQ(stamps[39], fixture_ns(39)) << name;
  }
}

TEST(Matlab, WhatThereIs) {
  const TableRequest request{.file = recording_file("v5_compressed.mat")};
  if (built_without(request)) GTEST_SKIP();
  const auto tables = format_of(request).describe(request);
  ASSERT_EQ(tables.size(), 1u);
  EXPECT_EQ(tables[0].rows, fixture_samples);
  EXPECT_THAT(column_texts(tables[0]),
              ElementsAre("t", "stamp", "imu.gyro.1", "imu.gyro.2", "imu.gyro.3", "imu.accel.1", "imu.accel.2", "imu.accel.3", "imu.counts.1",
                          "imu.counts.2", "imu.counts.3", "single.1", "single.2", "single.3"));
  expect_columns(request, {"imu.counts.1", "imu.counts.2", "imu.counts.3"}, fixture_counts);
  expect_columns(request, {"single.1", "single.2", "single.3"}, fixture_gyro);
  EXPECT_THAT(error_of(request, {"gyro.1"}), HasSubstr("v5_compressed.mat: column gyro.1 is not there; expected one of t, stamp, imu.gyro.1"));
}

TEST(Matlab, Version4) {
  for (const char* name : {"v4.mat", "octave_v4.mat"}) {
    const TableRequest request{.file = recording_file(name)};
    if (built_without(request)) GTEST_SKIP();
    expect_columns(request, {"gyro.1", "gyro.2", "gyro.3"}, fixture_gyro);
    expect_columns(request, {"accel.1", "accel.2", "accel.3"}, fixture_accel);
    expect_columns(request, {"t"}, [](std::size_t i, std::size_t) { return fixture_t(i); });
  }
}

TEST(Matlab, PsinsMatrix) {
  const TableRequest request{.file = recording_file("psins.mat")};
  if (built_without(request)) GTEST_SKIP();
  expect_columns(request, {1, 2, 3}, [](std::size_t i, std::size_t k) { return fixture_gyro(i, k) / 125; });
  expect_columns(request, {"imu.7", "imu.4"}, [](std::size_t i, std::size_t c) { return c == 0 ? fixture_t(i) : fixture_accel(i, 0) / 125; });
}

TEST(Matlab, DamageIsSurvived) {  // ctest: once
  const TableRequest request{.file = recording_file("v5.mat")};
  if (built_without(request)) GTEST_SKIP();
  expect_damage_is_survived(request, {"t", "imu.gyro.1"}, 29);
  expect_damage_is_survived({.file = recording_file("v5_compressed.mat")}, {"t", "imu.gyro.1"}, 19);
  expect_damage_is_survived({.file = recording_file("v4.mat")}, {"t", "gyro.1"}, 19);
}

TEST(Matlab, ADamagedCompressedVariableIsAnErrorAtOnce) {
  const TableRequest request{.file = recording_file("v5_compressed.mat")};
  if (built_without(request)) GTEST_SKIP();
  const std::string whole = file_bytes(request.file);
  const TemporaryFolder folder;
  std::size_t tried = 0;
  for (std::size_t begin = 128; begin + 8 < whole.size();) {  // variables: type and length, then what zlib packed
    std::uint32_t length = 0;
    std::memcpy(&length, whole.data() + begin + 4, sizeof length);
    for (std::size_t at = begin + 8; at < begin + 8 + length; at += 13, ++tried) {
      std::string damaged = whole;
      damaged[at] = static_cast<char>(damaged[at] ^ 0x10);
      EXPECT_THAT(error_of({.file = folder.write("damaged.mat", damaged)}, {"t"}), HasSubstr("a compressed variable is damaged")) << at;
    }
    begin += 8 + length;
  }
  EXPECT_GT(tried, 100u);
}

/// libhdf5 crashes on some of these files: with Debian 12's, bytes 1488 and 1489 of the whole file lead it to freed memory.
TEST(Matlab, DamageOfVersion73IsSurvived) {  // ctest: once
  const TableRequest request{.file = recording_file("v73.mat")};
  if (built_without(request)) GTEST_SKIP();
  expect_damage_is_survived(request, {"t", "imu.gyro.1"}, 97);
  const TemporaryFolder folder;
  for (const std::size_t at : {1488, 1489})
    for (const char damage : {'\xFF', '\x7F', '\1'}) {
      std::string damaged = file_bytes(request.file);
      damaged[at] = damage;
      expect_no_crash(folder / "damaged", damaged, request, {"t", "imu.gyro.1"});
    }
}

}  // namespace
}  // namespace imulab
