// Rows of binary numbers (tests/recordings/rows_files.py).
#include <gmock/gmock.h>

#include "tests/recording_files.hpp"

namespace imulab {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;

TEST(BinaryRows, PsinsIncrementsAndTime) {
  const TableRequest request{.file = recording_file("psins.bin"), .layout = "f8x7"};
  expect_columns(request, {1, 2, 3}, [](std::size_t i, std::size_t k) { return fixture_gyro(i, k) / 125; });
  expect_columns(request, {4, 5, 6}, [](std::size_t i, std::size_t k) { return fixture_accel(i, k) / 125; });
  expect_columns(request, {7}, [](std::size_t i, std::size_t) { return fixture_t(i); });
}

TEST(BinaryRows, TypesByteOrdersAndAHead) {
  const TableRequest request{.file = recording_file("mixed.bin"), .layout = "+16 >u4 >i2x3 f4x3 u1"};
  const auto tables = format_of(request).describe(request);
  EXPECT_EQ(tables.at(0).rows, fixture_samples);
  EXPECT_THAT(column_texts(tables[0]), ElementsAre("1", "2", "3", "4", "5", "6", "7", "8"));
  expect_columns(request, {1}, [](std::size_t i, std::size_t) { return 8000.0 * static_cast<double>(i + 1); });
  expect_columns(request, {2, 3, 4}, fixture_counts);
  expect_columns(request, {5, 6, 7}, fixture_accel);
  expect_columns(request, {8}, [](std::size_t i, std::size_t) { return static_cast<double>(i % 2); });
}

TEST(BinaryRows, WhatIsLeftOverIsSaid) {
  const TemporaryFolder folder;
  const TableRequest request{.file = folder.write("x.bin", file_bytes(recording_file("psins.bin")) + "12345"), .layout = "f8x7"};
  EXPECT_THAT(columns_of(request, {1}).warnings,
              ElementsAre(HasSubstr("x.bin: 5 bytes are left after 40 rows of 56 bytes: the file ends inside a row, or the layout is not \"f8x7\"")));
}

TEST(BinaryRows, WrongLayoutsAreErrors) {
  const struct {
    const char *layout, *message;
  } cases[] = {
      {"f8 f9", "layout \"f8 f9\": f9 is no type; expected words such as"},
      {"f8x", "f8x is no type"},
      {"f8x0", "f8x0 is no type"},
      {"f8x99999999999999999999", "is no type"},
      {"u8x4096 u8", "u8 is no type"},
      {"f2", "f2 is no type"},
      {"+12z f8", "+12z is no type"},
      {"+16", "has no numbers"},
      {" ", "has no numbers"},
      {"f8x300", "psins.bin: has 2240 bytes; expected 0 before the first row and 2400 in each"},
      {"+99999 f8", "psins.bin: has 2240 bytes; expected 99999 before the first row and 8 in each"},
      {"f8x6", "column 7 is not there; expected 1 to 6"},
  };
  for (const auto& c : cases) EXPECT_THAT(error_of({.file = recording_file("psins.bin"), .layout = c.layout}, {7}), HasSubstr(c.message)) << c.layout;
  EXPECT_THAT(error_of({.file = recording_file("psins.bin"), .topic = "imu", .layout = "f8x7"}, {7}), HasSubstr("topic imu is not there"));
}

TEST(BinaryRows, DamageIsSurvived) { expect_damage_is_survived({.file = recording_file("mixed.bin"), .layout = "+16 >u4 >i2x3 f4x3 u1"}, {1, 5}, 3); }

TEST(BinaryRows, LargeUnsignedIntegersBecomeNumbers) {
  const TemporaryFolder folder;
  std::string bytes(16, '\xFF');
  bytes.replace(0, 8, std::string(8, '\0'));
  const TableRequest request{.file = folder.write("x.bin", bytes), .layout = "u8"};
  EXPECT_THAT(columns_of(request, {1}).columns[0].numbers, ElementsAre(0, 18446744073709551615.0));
}

}  // namespace
}  // namespace imulab
