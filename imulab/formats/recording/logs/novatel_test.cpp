#include "imulab/error.hpp"
#include "imulab/formats/recording/logs/binary.hpp"
#include "imulab/formats/recording/signals.hpp"
#include "imulab/formats/recording/table_reader.hpp"
#include "imulab/units.hpp"

#include <fmt/core.h>
#include <gmock/gmock.h>

#include "tests/temporary_folder.hpp"
#include <array>
#include <chrono>

namespace imulab {
namespace {

using recording_io::append;
using recording_io::TableRows;
using testing::HasSubstr;
using testing::ThrowsMessage;

const std::vector<Column> axes{"time", "gyro.x", "gyro.y", "gyro.z", "accel.x", "accel.y", "accel.z"};

std::uint32_t checksum(std::string_view bytes) { return ~recording_io::crc32(bytes, ~std::uint32_t{0}); }

std::string line(const std::string& body, char sync = '%') { return fmt::format("{}{}*{:08x}\r\n", sync, body, checksum(body)); }

/// RAWIMUSX in binary: a short head, the body, the checksum.
std::string binary(std::uint8_t type, double seconds, const std::array<std::int32_t, 6>& logged) {
  std::string out("\xAA\x44\x13\x28", 4);
  append<std::uint16_t>(out, 1462);
  append<std::uint16_t>(out, 1692);
  append<std::uint32_t>(out, static_cast<std::uint32_t>(1000 * seconds));
  out += std::string(1, '\0') + static_cast<char>(type);
  append<std::uint16_t>(out, 1692);
  append<double>(out, seconds);
  append<std::uint32_t>(out, 0x77);
  for (const std::int32_t count : logged) append<std::int32_t>(out, count);
  append<std::uint32_t>(out, checksum(out));
  return out;
}

struct Novatel : testing::Test {
  TemporaryFolder folder;
  TableRows read(const std::string& bytes, const std::string& topic = "") const {
    return recording_io::read_columns({folder.write("x.log", bytes), topic, ""}, axes);
  }
};

/// The example of NovAtel's manual, with its checksum: an HG1700-AG58 with z up.
const std::string manual =
    "%RAWIMUSXA,1692,484620.664;00,11,1692,484620.664389000,00801503,43110635,-817242,-202184,-215194,-41188,-9895*a5db8c7b\r\n";

TEST_F(Novatel, TheManualsExampleReadsGravity) {
  std::string text = "#BESTPOSA,COM1,0,74.0;SOL*00000000\r\n";
  for (int i = 0; i < 3; ++i) text += manual;
  const TableRows rows = read(text);
  ASSERT_EQ(rows.size(), 3U);
  EXPECT_THAT(rows.warnings, testing::IsEmpty());
  EXPECT_EQ(rows.columns[0].integers[0], 1692 * 604'800'000'000'000 + 484'620'664'389'000);
  EXPECT_NEAR(rows.columns[6].numbers[0], 9.79, 0.01);
  EXPECT_NEAR(rows.columns[5].numbers[0], 0.1856, 0.0001) << "its sign is reversed";
  EXPECT_NEAR(rows.columns[4].numbers[0], -0.0459, 0.0001);
  EXPECT_NEAR(rows.columns[3].numbers[0], -215194 * 100 / 8589934592., 1e-12);
  EXPECT_GT(rows.columns[2].numbers[0], 0);
}

TEST_F(Novatel, BinaryIsWhatTheTextIs) {
  const std::array<std::int32_t, 6> logged{43110635, -817242, -202184, -215194, -41188, -9895};
  const TableRows text = read(manual),
                  rows = read("noise \xAA\x44" + binary(11, 484620.664389, logged) + "\xAA\x44\x13(garbage" + binary(11, 484620.674389, logged));
  ASSERT_EQ(rows.size(), 2U);
  EXPECT_EQ(rows.columns[0].integers[0], text.columns[0].integers[0]);
  for (std::size_t k = 1; k < axes.size(); ++k) EXPECT_EQ(rows.columns[k].numbers[1], text.columns[k].numbers[0]);
  EXPECT_THAT(read_tables(folder / "x.log").front().signals.front().unit, "ns");
}

TEST_F(Novatel, CountsOfAnUnknownImuStayCounts) {
  const TableRows plain = read(line("RAWIMUSA,1105,425384.180;1105,425384.156166800,111607,43088060,430312,-3033352,-132863,186983,823"));
  EXPECT_EQ(plain.columns[6].numbers[0], 43088060);
  EXPECT_EQ(plain.columns[2].numbers[0], -186983);
  EXPECT_THAT(plain.warnings, testing::ElementsAre(HasSubstr("RAWIMUS does not say which IMU it is: its increments stay counts")));
  const TableRows type = read(line("RAWIMUSXA,1692,1.0;00,250,1692,1.5,0,1,2,3,4,5,6"));
  EXPECT_THAT(type.warnings, testing::ElementsAre(HasSubstr("the scale of an IMU of type 250 is not known here")));
  EXPECT_EQ(read_tables(folder / "x.log").front().signals[1].unit, "count");
}

TEST_F(Novatel, DamagedMessagesAreLeftOutAndSaid) {
  std::string wrong = manual;
  wrong[70] = '9';
  EXPECT_THAT(read(manual + wrong).warnings, testing::ElementsAre(HasSubstr("1 RAWIMUSX with a wrong checksum or field were left out")));
  EXPECT_THAT([&] { read("\xAA\x44\x12" + std::string(100, '\0')); },
              ThrowsMessage<Error>(HasSubstr("is a log of a NovAtel receiver without raw readings")));
  EXPECT_THAT([&] { read(wrong); }, ThrowsMessage<Error>(HasSubstr("all 1 raw readings of an IMU in it have a wrong checksum or field")));
  EXPECT_THROW(read(line("RAWIMUSXA,1692,1.0;00,11,99999999,1.5,0,1,2,3,4,5,6")), Error) << "no week";
  EXPECT_THROW(read(manual.substr(0, 40)), Error);
}

TEST_F(Novatel, WhatIsMadeToTakeLongDoesNot) {
  std::string syncs;
  while (syncs.size() < 300'000) syncs += "\xAA\x44\x13\x28\xB6\x05%RAWIMU#";
  const auto begin = std::chrono::steady_clock::now();
  EXPECT_THROW(read(syncs), Error);
  EXPECT_LT(std::chrono::steady_clock::now() - begin, std::chrono::seconds(5));
}

}  // namespace
}  // namespace imulab
