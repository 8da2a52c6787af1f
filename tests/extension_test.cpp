// docs/reference/extending.md: a method, a recording format and an export target for this test alone, each a row more in a copy of
// its table. The page shows this code.
#include "apps/imulab/help.hpp"
#include "imulab/calibrate.hpp"
#include "imulab/earth.hpp"
#include "imulab/error.hpp"
#include "imulab/estimate/kernel/findings.hpp"
#include "imulab/estimate/kernel/information.hpp"
#include "imulab/estimate/kernel/input.hpp"
#include "imulab/estimate/method.hpp"
#include "imulab/exchange.hpp"
#include "imulab/files.hpp"
#include "imulab/formats/import/format.hpp"
#include "imulab/formats/recording/reader.hpp"
#include "imulab/formats/text/file.hpp"
#include "imulab/rig/ideal_recording.hpp"
#include "imulab/session.hpp"
#include "imulab/simulate.hpp"
#include "imulab/tasks/calibrate.hpp"
#include "imulab/tasks/predict.hpp"

#include <fmt/core.h>
#include <gmock/gmock.h>

#include "tests/run_command.hpp"
#include <algorithm>
#include <cmath>
#include <cstring>
#include <filesystem>
#include <regex>

namespace imulab {

// imulab/estimate/faces/faces.cpp
namespace faces {

/// A0 and the diagonal of A1 by least squares: a rest with axis j up or down reads V_j, and A0_j + A1_jj V_j = +g or -g.
Calibration solved(const Recording& recording, const std::vector<Range>& rests, const Session& session) {
  const double density = declared_noise(session.imu).accel.N, g = session.site.gravity();
  kernel::Information data(6);
  for (const RestMeans& rest : summarize_rests(recording, rests)) {
    Eigen::Index axis;
    rest.accel.cwiseAbs().maxCoeff(&axis);
    const double reading = rest.accel[axis];
    const double weight = std::sqrt(static_cast<double>(rest.range.size()) * recording.interval_s) / density;
    Eigen::MatrixXd row = Eigen::MatrixXd::Zero(1, 6);
    row(0, axis) = weight, row(0, 3 + axis) = weight * reading;
    data += kernel::Information(row, Eigen::VectorXd::Constant(1, weight * (reading - std::copysign(g, reading))));  // at A0 = 0, A1 = 1
  }
  const kernel::Solution s = kernel::solve(data, kernel::Parameters(6), "the faces");
  Calibration c;
  c.method = "faces", c.frame = BodyFrame::rig;
  c.estimated = select_each({"accel.offset", "accel.matrix.diagonal"});
  c.covariance = s.covariance;
  c.model.accel.offset = s.x.head<3>();
  c.model.accel.matrix.diagonal() += s.x.tail<3>();
  c.model.accel.raw_unit = recording.accel_unit, c.model.gyro.raw_unit = recording.gyro_unit;
  c.quality.converged = true;
  c.quality.degrees_of_freedom = data.rows - 6;
  c.quality.sources = {kernel::gravity_source(session.site)};
  return c;
}

CalibrationResult calibrate(const CalibrationInput& input, const CalibrationOptions&) {
  const Recording& recording = kernel::only_recording(input, "faces");
  CalibrationResult result{.calibration = solved(recording, kernel::rests_of(input, recording).ranges, input.session)};
  kernel::Findings findings;
  kernel::add_common_doubts(findings, result.calibration, input.session.site);
  kernel::conclude(result.calibration, findings);
  return result;
}

/// At the readings of an ideal IMU.
Prediction predict(const Session& procedure, const PredictionOptions& options) {
  const Vector3d earth = earth_rate_enu(procedure.site.latitude.value_or(0));
  const Recording ideal = ideal_recording(procedure, kernel::only_source(procedure), {earth, procedure.site.gravity()});
  Prediction out = prediction_of(solved(ideal, rests_of(ideal, procedure).ranges, procedure));
  out.missed = shortfalls(out, options.requirements);
  return out;
}

}  // namespace faces

// imulab/formats/recording/logs/imu7.cpp
namespace recording_io {

/// Rows of seven doubles after the four bytes "IMU7".
bool is_imu7(std::string_view head) { return head.starts_with("IMU7"); }

std::vector<TableDescription> describe_imu7(const TableRequest& request) {
  TableDescription table;
  for (const char* name : {"t", "gx", "gy", "gz", "ax", "ay", "az"}) table.columns.push_back({name});
  table.rows = (MappedFile(request.file).text().size() - 4) / (7 * sizeof(double));
  return {table};
}

void read_imu7(const TableRequest& request, const Wanted& wanted, const PieceSink& sink) {
  const TableDescription table = describe_imu7(request).front();
  const MappedFile file(request.file);
  TableRows rows;
  for (const Column& column : wanted.columns) {
    std::vector<double>& numbers = rows.columns.emplace_back().numbers;
    numbers.resize(table.rows);
    const char* first = file.text().data() + 4 + sizeof(double) * find_column(table, column, request.file.string());
    for (std::size_t i = 0; i < table.rows; ++i) std::memcpy(&numbers[i], first + 7 * sizeof(double) * i, sizeof(double));
  }
  sink(std::move(rows));
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
{.name = "rows of seven doubles", .recognizes = recording_io::is_imu7, .describe = recording_io::describe_imu7, .read = recording_io::read_imu7}
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
  const std::string page = read_text(IMULAB_SOURCE "/docs/reference/extending.md"), code = read_text(IMULAB_SOURCE "/tests/extension_test.cpp");
  const std::regex excerpt("```cpp\n([^`]*)\n```");
  std::size_t shown = 0;
  for (std::sregex_iterator i(page.begin(), page.end(), excerpt), end; i != end; ++i, ++shown) EXPECT_THAT(code, HasSubstr((*i)[1].str()));
  EXPECT_EQ(shown, 7u);
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

/// The table of a page that begins with this line.
std::string rows_below(const std::string& page, const std::string& head) {
  const std::string text = read_text(std::string(IMULAB_SOURCE "/docs/") + page);
  const std::size_t begin = text.find(head);
  EXPECT_NE(begin, std::string::npos) << page << ": " << head;
  return text.substr(begin, text.find("\n\n", begin) - begin);
}

TEST(Extension, EveryRecordingFormatIsDocumentedAndFuzzed) {
  const std::string rows = rows_below("reference/recordings.md", "| format | tables (`topic`) | columns |");
  const std::string fuzzed = read_text(IMULAB_SOURCE "/fuzz/recording.cpp");
  std::vector<std::string> parts;  // of the names of formats
  const std::regex call("read_all\\(\"([^\"]+)\"");
  for (std::sregex_iterator i(fuzzed.begin(), fuzzed.end(), call), end; i != end; ++i) parts.push_back((*i)[1]);
  for (const RecordingFormat& format : recording_formats()) {
    EXPECT_THAT(rows, HasSubstr(std::string(format.name.substr(0, format.name.find(' '))))) << format.name << ": docs/reference/recordings.md";
    if (format.recognizes_path != nullptr) continue;  // of several files, each of which is in another format
    EXPECT_TRUE(std::ranges::any_of(parts, [&](const std::string& part) { return format.name.find(part) != std::string_view::npos; }))
        << format.name << ": expected a target of fuzz/recording.cpp";
  }
}

TEST(Extension, EveryTargetAndImportIsDocumentedAndFuzzed) {
  const std::string targets = rows_below("reference/export.md", "| target | contents |"), imports = rows_below("reference/export.md", "| format |");
  for (const ExportTarget& target : export_targets()) EXPECT_THAT(targets, HasSubstr("\n| `" + std::string(target.name) + "` |"));
  std::vector<std::string> seeds;
  for (const auto& entry : std::filesystem::directory_iterator(IMULAB_SOURCE "/tests/imports")) seeds.push_back(read_text(entry.path()));
  for (const import_io::ImportFormat& format : import_io::import_formats()) {
    EXPECT_THAT(imports, HasSubstr(std::string(format.name)));
    EXPECT_TRUE(std::ranges::any_of(seeds, [&](const std::string& seed) { return format.recognizes(seed); }))
        << format.name << ": expected a file of tests/imports, from which the fuzzer begins";
  }
}

/// The row of an option, here at the end of the table of `calibrate`.
void add_color(Verb& verb, std::string& color) {
  verb.option("--color COLOR", color, "the color of the unit").one_of({"green", "grey"}).show_default();
}

TEST(Extension, AnOptionIsARowOfItsVerbsTable) {
  Verb imulab("imulab", "");
  CalibrateOptions o;
  std::string color = "green";
  Verb& calibrate = declare(imulab, o);
  add_color(calibrate, color);
  EXPECT_EQ(calibrate.at("--color").keyword, "color");  // Python's keywords are read from these rows: python/tests/test_options.py
  EXPECT_THAT(command::help_text(calibrate), HasSubstr("  --color COLOR          the color of the unit [green, grey] (default: green)\n"));
  EXPECT_THAT(command::manual_page(calibrate, "1"), HasSubstr(".B \\-\\-color COLOR\nthe color of the unit [green, grey]"));
  for (const std::string& shell : command::completion_shells) EXPECT_THAT(command::completion(imulab, shell), HasSubstr("green grey")) << shell;
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

// clang-format off
const Method faces_row
{.name = "faces",
 .summary = "accelerometer offsets and scales from rests on six faces",
 .reference = "Ferraris 1995",
 .needs = "a hold with each axis up and down as [[step]]",
 .equipment = 1,
 .test = "multi-position (tumble) on six faces",
 .calibrate = faces::calibrate,
 .predict = faces::predict,
 .example = [](const ExampleSize& size) { return six_position_procedure(size.on_table); }}
;
// clang-format on

/// The row alone makes the method calibrate, predict and print what it predicts.
TEST(Extension, AMethodIsAFolderAndARow) {
  const auto table = with<Method>(methods(), faces_row);
  const Method& faces = method("faces", table);
  const Session session = faces.example({});
  const Truth truth = draw_truth(session, 1);
  const RecordingSource source = session.recordings.front();
  const Recording recording = simulate_recording(session, source, truth, 1, draw_rig_errors(session, source, 1));
  const Calibration c = calibrate(faces, {session, {&recording, 1}}).calibration;
  const Prediction p = predict(faces, session, {.requirements = parse_requirements("accel.matrix.diagonal <= 0.0001 ppm")});
  ASSERT_EQ(p.coefficients, c.estimated);
  for (std::size_t i = 0; i < c.estimated.size(); ++i) {
    const double sigma = p.sigma[static_cast<Eigen::Index>(i)];
    EXPECT_NEAR(*standard_uncertainty(c, c.estimated[i]), sigma, 0.05 * sigma) << "by the drawn unit's scales";
    // Its other terms are not in this model: second and third order, and misalignments beside gravity.
    EXPECT_NEAR(coefficient_value(c.model, c.estimated[i]), coefficient_value(truth.model, c.estimated[i]), 2e-3);
  }
  EXPECT_EQ(p.missed.size(), 3u);
  EXPECT_THAT(prediction_text(p, {}), HasSubstr("accel.matrix.yy"));
  EXPECT_THAT(prediction_json(summary_of(p)), HasSubstr("not_met"));
  EXPECT_THAT([&] { method("magic", table); }, ThrowsMessage<Error>(HasSubstr("expected one of faces, drive, handheld")));
  EXPECT_EQ(find_method("faces"), nullptr) << "not without its row";
}

}  // namespace
}  // namespace imulab
