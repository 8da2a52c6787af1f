// docs/architecture.md, "Extending": a method, a recording format and an export target for this test alone, each a row more in a copy of its table.
// The page shows this code.
#include "imulab/core/error.hpp"
#include "imulab/estimate/kernel/input.hpp"
#include "imulab/estimate/method.hpp"
#include "imulab/export/target.hpp"
#include "imulab/formats/recording/file.hpp"
#include "imulab/formats/text/file.hpp"

#include <fmt/core.h>
#include <gmock/gmock.h>

#include "tests/run_command.hpp"
#include <cmath>
#include <cstring>
#include <regex>

namespace imulab {

// imulab/estimate/zeros/zeros.cpp
namespace zeros {

/// The gyros' offsets from one rest: minus the mean of each axis.
CalibrationResult calibrate(const CalibrationInput& input, const CalibrationOptions&) {
  const Recording& recording = kernel::only_recording(input, "zeros");
  CalibrationResult result;
  Calibration& c = result.calibration;
  c.method = "zeros";
  c.estimated = select_coefficients("gyro.offset");
  c.covariance.setZero(3, 3);
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const auto column = Eigen::Map<const Eigen::ArrayXd>(recording.gyro[axis].data(), static_cast<Eigen::Index>(recording.size()));
    const auto i = static_cast<Eigen::Index>(axis);
    c.model.gyro.offset[i] = -column.mean();
    c.covariance(i, i) = (column - column.mean()).square().mean() / static_cast<double>(recording.size());
  }
  c.quality.verdict = "good";
  return result;
}

}  // namespace zeros

// imulab/formats/recording/imu7.cpp
namespace recording_io {

/// Rows of seven doubles after the four bytes "IMU7".
bool is_imu7(std::string_view head) { return head.starts_with("IMU7"); }

std::vector<TableDescription> describe_imu7(const TableRequest& request) {
  TableDescription table;
  for (const char* name : {"t", "gx", "gy", "gz", "ax", "ay", "az"}) table.columns.push_back({name});
  table.rows = (MappedFile(request.file).text().size() - 4) / (7 * sizeof(double));
  return {table};
}

RawTable imu7_columns(const TableRequest& request, const std::vector<Column>& columns) {
  const TableDescription table = describe_imu7(request).front();
  const MappedFile file(request.file);
  RawTable raw;
  for (const Column& column : columns) {
    std::vector<double>& numbers = raw.columns.emplace_back().numbers;
    numbers.resize(table.rows);
    const char* first = file.text().data() + 4 + sizeof(double) * find_column(table, column, request.file.string());
    for (std::size_t i = 0; i < table.rows; ++i) std::memcpy(&numbers[i], first + 7 * sizeof(double) * i, sizeof(double));
  }
  return raw;
}

}  // namespace recording_io

// imulab/export/offsets.cpp
namespace export_io {

std::string offsets_text(const ExportInput& input) {
  const Vector3d& offset = input.calibration.model.gyro.offset;
  return fmt::format("{} {} {}\n", offset[0], offset[1], offset[2]);
}
std::vector<std::string> left_out_of_offsets(const ExportInput&) { return {"everything but the gyros' offsets"}; }

}  // namespace export_io

namespace {

using ::testing::HasSubstr;
using ::testing::ThrowsMessage;

template <class Row>
std::vector<Row> with(const auto& table, Row row) {
  std::vector<Row> rows(table.begin(), table.end());
  rows.insert(rows.begin(), row);
  return rows;
}

const std::array<std::array<double, 7>, 3> rows{{{0, 0.1, 0.2, 0.3, 0, 0, 9.8}, {0.01, 0.1, 0.4, 0.3, 0, 0, 9.8}, {0.02, 0.1, 0.3, 0.6, 0, 0, 9.8}}};

// clang-format off
const RecordingFormat imu7
{.name = "rows of seven doubles", .recognizes = recording_io::is_imu7, .describe = recording_io::describe_imu7, .columns = recording_io::imu7_columns}
;
// clang-format on

/// A session with one recording in the new format, and what is read of it.
Recording read_imu7_session(const TemporaryFolder& folder, const std::vector<RecordingFormat>& formats) {
  std::string bytes = "IMU7";
  bytes.append(reinterpret_cast<const char*>(rows.data()), sizeof rows);
  folder.write("unit.imu7", bytes);
  Session session;
  session.file = folder / "session.toml";
  RecordingSource& source = session.recordings.emplace_back();
  source.file = "unit.imu7";
  source.gyro = {.columns = {2, 3, 4}, .unit = "rad/s"};
  source.accel = {.columns = {5, 6, 7}, .unit = "m/s^2"};
  return read_recording(session, session.recordings.front(), formats).recording;
}

TEST(Extension, ThePageShowsThisCode) {
  const std::string page = read_text(IMULAB_SOURCE "/docs/architecture.md"), code = read_text(IMULAB_SOURCE "/tests/extension_test.cpp");
  const std::regex excerpt("```cpp\n([^`]*)\n```");
  std::size_t shown = 0;
  for (std::sregex_iterator i(page.begin(), page.end(), excerpt), end; i != end; ++i, ++shown) EXPECT_THAT(code, HasSubstr((*i)[1].str()));
  EXPECT_EQ(shown, 6u);
}

TEST(Extension, ARecordingFormatIsAFileAndARow) {
  const TemporaryFolder folder;
  const auto formats = with<RecordingFormat>(recording_formats(), imu7);
  const Recording recording = read_imu7_session(folder, formats);
  EXPECT_EQ(recording.size(), 3u);
  EXPECT_DOUBLE_EQ(recording.interval_s, 0.01);
  EXPECT_EQ(recording.gyro[1], (std::vector{0.2, 0.4, 0.3}));
  EXPECT_THROW(read_imu7_session(folder, recording_formats()), Error) << "not without its row";
}

TEST(Extension, AnExportTargetIsAFileAndARow) {
  const auto targets = with<ExportTarget>(
      export_targets(), {"offsets", "the gyros' offsets [rad/s]", "offsets.txt", export_io::offsets_text, export_io::left_out_of_offsets});
  Calibration c;
  c.model.gyro.offset = {1, 2, 0.5};
  EXPECT_EQ(export_target("offsets", targets).text({c}), "1 2 0.5\n");
  EXPECT_THAT([&] { export_target("magic", targets); },
              ThrowsMessage<Error>(HasSubstr("magic is not an export target; expected one of offsets, c-header")));
}

TEST(Extension, AMethodIsAFolderAndARow) {
  const auto table = with<Method>(methods(), {.name = "zeros", .summary = "the gyros' offsets from one rest", .calibrate = zeros::calibrate});
  const TemporaryFolder folder;
  const Recording recording = read_imu7_session(folder, with<RecordingFormat>(recording_formats(), imu7));
  const Calibration c = method("zeros", table).calibrate({Session{}, {&recording, 1}}, {}).calibration;
  EXPECT_NEAR(c.model.gyro.offset[1], -0.3, 1e-15);
  EXPECT_NEAR(*standard_uncertainty(c, coefficient_index("gyro.offset.y")), std::sqrt(0.02 / 9), 1e-12);
  try {
    method("magic", table);
    FAIL();
  } catch (const Error& e) {
    EXPECT_THAT(e.what(), HasSubstr("zeros"));
  }
}

}  // namespace
}  // namespace imulab
