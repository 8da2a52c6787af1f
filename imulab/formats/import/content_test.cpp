// The contents of a file beside its numbers are kept or named: layout, units, axes, what was not determined, checksums, dialects.
#include "imulab/error.hpp"
#include "imulab/exchange.hpp"
#include "imulab/files.hpp"

#include <fmt/format.h>
#include <gmock/gmock.h>

#include "tests/export_unit.hpp"
#include "tests/import_texts.hpp"

namespace imulab::export_test {
namespace {

using ::testing::Contains;
using ::testing::HasSubstr;

TEST(Import, TheLinesTellHowAMatrixIsLaidOut) {
  Matrix3d C;
  C << 1.01, 0.02, -0.03, 0.004, 0.99, 0.006, -0.007, 0.008, 1.02;
  const Vector3d b(0.1, -0.2, 0.3);
  const char* texts[] = {
      "1.01 0.02 -0.03\n0.004 0.99 0.006\n-0.007 0.008 1.02\n0.1 -0.2 0.3\n", "1.01 0.02 -0.03 0.1\n0.004 0.99 0.006 -0.2\n-0.007 0.008 1.02 0.3\n",
      "1.01 0.02 -0.03 0.004 0.99 0.006 -0.007 0.008 1.02 0.1 -0.2 0.3\n", "1.01 0.02 -0.03 0.004 0.99 0.006 -0.007 0.008 1.02\n0.1 -0.2 0.3\n"};
  for (const char* text : texts) {
    const TriadModel m = import(text).calibration.model.accel;
    EXPECT_EQ(m.matrix, C) << text;
    EXPECT_LT((m.offset + C * b).norm(), 1e-16) << text;
    for (const char* other : texts) EXPECT_EQ(import(std::string(text) + other).calibration.model.gyro.matrix, C) << text << other;
  }
  EXPECT_THAT(import(texts[1]).warnings, Contains(HasSubstr("taken as C and b of C (u - b)")));
}

TEST(Import, WhatTheDataDidNotDetermineStaysSo) {
  Calibration c = si_unit();
  c.quality.unobservable = {"accel.offset.x", "gyro.g_sensitivity.zz"};
  for (const char* target : {"json-matrix", "csv"}) {
    const Imported back = import(exported(target, {c}));
    EXPECT_EQ(back.calibration.quality.unobservable, c.quality.unobservable) << target;
    EXPECT_THAT(unusable(parse_calibration(calibration_text(back.calibration), "c")), testing::ElementsAre("accel.offset.x")) << target;
  }
}

TEST(Import, TheDevicesAxesComeBackFromMatrices) {
  Calibration c = si_unit();
  c.recorded_accel = RecordedAs{"g", 4096, 0, {"+y", "-x", "+z"}};
  c.recorded_gyro = RecordedAs{"deg", 1, 0.01, {"-z", "+x", "-y"}};
  const Calibration back = import(exported("json-matrix", {c})).calibration;
  EXPECT_EQ(back.recorded_accel, c.recorded_accel);
  EXPECT_EQ(back.recorded_gyro, c.recorded_gyro);
}

TEST(Import, RawIsRefusedWhereTheFileTellsTheUnit) {
  const Calibration si = si_unit();
  Calibration counts = si;
  counts.model.accel.raw_unit = counts.model.gyro.raw_unit = "count";
  ImportOptions as_counts, as_si;
  as_counts.raw = "count";
  as_si.raw = "si";
  for (const char* target : {"px4", "ardupilot", "vectornav", "csv", "json-matrix"}) {
    EXPECT_NO_THROW(import(exported(target, {si}), as_si)) << target;
    EXPECT_THAT(
        [&] { import(exported(target, {si}), as_counts); },
        testing::ThrowsMessage<Error>(HasSubstr("file: raw count: the accelerometers' readings are in m/s^2 in this format; expected no raw")))
        << target;
  }
  for (const char* target : {"csv", "json-matrix"}) {
    EXPECT_EQ(import(exported(target, {counts}), as_counts).calibration.model.gyro.raw_unit, "count") << target;
    EXPECT_THAT([&] { import(exported(target, {counts}), as_si); }, testing::ThrowsMessage<Error>(HasSubstr("raw si"))) << target;
  }
}

TEST(Import, VectorNavsSixteenBitChecksumIsRead) {
  std::string text = import_file("vectornav.txt");
  text.replace(text.find("*53"), 3, "*@A");
  text.replace(text.find("*5F"), 3, "*@B");
  // CRC-16 of CCITT from 0, most significant bit first, by its polynomial
  for (const char* place : {"@A", "@B"}) {
    const std::size_t star = text.find(std::string("*") + place), dollar = text.rfind('$', star);
    unsigned crc = 0;
    for (const char c : text.substr(dollar + 1, star - dollar - 1)) {
      crc ^= static_cast<unsigned>(static_cast<unsigned char>(c)) << 8U;
      for (int bit = 0; bit < 8; ++bit) crc = ((crc << 1U) ^ ((crc & 0x8000U) != 0 ? 0x1021U : 0U)) & 0xffffU;
    }
    text.replace(star + 1, 2, fmt::format("{:04X}", crc));
  }
  EXPECT_EQ(import(text).calibration.model.accel.matrix, import(import_file("vectornav.txt")).calibration.model.accel.matrix);
}

TEST(Import, FlowStyleAndByteOrderMarksAreRead) {
  const std::string flow =
      "{imu0: {model: kalibr, Tw: [[1, 0, 0], [0, 2, 0], [0, 0, 1]], R_IMUtoGYRO: [[1, 0, 0], [0, 1, 0], [0, 0, 1]], Ta: [[1, 0, 0], [0, 1, 0], [0, "
      "0, "
      "1]]}}\n";
  EXPECT_EQ(import(flow).calibration.model.gyro.matrix(1, 1), 0.5);
  for (const std::string& text : {import_file("opencv.yaml"), import_file("kalibr_imu_chain.yaml"), psins_text, imucal_text,
                                  import_file("matrix.txt"), import_file("table.csv"), import_file("px4.params")})
    EXPECT_EQ(import("\xEF\xBB\xBF" + text).calibration.model.accel.matrix, import(text).calibration.model.accel.matrix) << text.substr(0, 60);
}

TEST(Import, WhatKalibrDoesNotHaveIsSaid) {
  std::string text = chain;
  text.replace(text.find("data: [0., -1., 0., 0.,"), 23, "data: [0., -1., 0., 0.1,");
  text.replace(text.find("M: [[1, 0, 0]"), 13, "M: [[-1, 0, 0.2]");
  const auto warnings = import(text).warnings;
  EXPECT_THAT(warnings, Contains(HasSubstr("T_i_b: its translation is left out")));
  EXPECT_THAT(warnings, Contains(HasSubstr("gyroscopes.M: has an upper triangle")));
  EXPECT_THAT(warnings, Contains(HasSubstr("gyroscopes.M: has a negative scale")));
  EXPECT_THAT(import(import_file("kalibr_imu_chain.yaml")).warnings, Contains("R_IMUtoACC is missing: taken as the identity"));
}

}  // namespace
}  // namespace imulab::export_test
