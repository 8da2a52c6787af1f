// The exported header takes readings as the driver gives them.
#include "imulab/error.hpp"
#include "imulab/export/c_header.hpp"
#include "imulab/files.hpp"
#include "imulab/formats/text/file.hpp"
#include "imulab/recording/origin.hpp"
#include "imulab/recording/unit_names.hpp"

#include <fmt/core.h>
#include <gmock/gmock.h>

#include "tests/recorded_session.hpp"
#include "tests/unit_of_every_term.hpp"
#include <cmath>

namespace imulab {
namespace {

using ::testing::HasSubstr;

constexpr const char* readings_program = R"(
#include "calibration.h"
#include <stdio.h>
int main(void) {
  double t, gyro[3], accel[3], force[3], rate[3];
  printf("t,gx,gy,gz,ax,ay,az\n");
  while (scanf("%lf,%lf,%lf,%lf,%lf,%lf,%lf", &t, gyro, gyro + 1, gyro + 2, accel, accel + 1, accel + 2) == 7) {
    imulab_compensate(accel, gyro, 0, 0, force, rate);
    printf("%.17g,%.17g,%.17g,%.17g,%.17g,%.17g,%.17g\n", t, rate[0], rate[1], rate[2], force[0], force[1], force[2]);
  }
  return 0;
}
)";

std::vector<std::vector<double>> csv_table(const std::string& csv) {
  std::vector<std::vector<double>> rows;
  std::istringstream lines(csv);
  std::string line;
  std::getline(lines, line);
  while (std::getline(lines, line)) {
    rows.emplace_back();
    for (const std::string& field : SessionText::fields(line)) rows.back().push_back(std::stod(field));
  }
  return rows;
}

/// The largest difference of the header's output of a recording's rows, as they are in the file, from that of `imulab compensate`, which writes
/// increments of the gyros over `interval_s` where the recording has them.
double difference_from_compensate(const TemporaryFolder& folder, const std::string& options = "", double interval_s = 1) {
  for (const std::string& command : {"export c.json --to c-header -o calibration.h " + options, std::string("compensate c.json session -o out.csv")})
    if (const CommandResult result = run_imulab(folder, command); result.exit_code != 0) throw std::runtime_error(result.errors);
  folder.write("program.c", readings_program);
  const CommandResult ran =
      run_shell(folder, std::string("cc -std=c99 program.c") + header_warnings + " && sed 1d session/recording.csv | ./program > header.csv");
  if (ran.exit_code != 0) throw std::runtime_error(ran.errors);
  const auto expected = csv_table(read_text(folder / "out.csv")), given = csv_table(read_text(folder / "header.csv"));
  EXPECT_EQ(given.size(), expected.size());
  EXPECT_GT(given.size(), 1000u);
  double worst = 0;
  for (std::size_t i = 0; i < given.size(); ++i)
    for (std::size_t k = 1; k < 7; ++k) worst = std::max(worst, std::abs(given[i][k] - expected[i][k] / (k < 4 ? interval_s : 1)));
  return worst;
}

/// Gyros in deg/s along other axes than the body's, accelerometers in counts.
SessionText as_a_driver_gives_them() {
  SessionText text = hand_held_session();
  text.declare("unit = \"rad/s\"", "unit = \"deg/s\", axes = [\"+y\", \"-x\", \"+z\"]");
  text.declare("unit = \"m/s^2\"", "unit = \"g\", counts_per_unit = 4096");
  text.for_rows([](std::vector<double>& row) {
    const double x = row[1], y = row[2];
    row[1] = y / si_factor("deg/s"), row[2] = -x / si_factor("deg/s"), row[3] /= si_factor("deg/s");
    for (std::size_t k = 4; k < 7; ++k) row[k] *= 4096 / si_factor("g");
  });
  return text;
}

TEST(ExportedReadings, AreThoseOfTheRecording) {
  const TemporaryFolder folder;
  as_a_driver_gives_them().write(folder);
  ASSERT_EQ(run_imulab(folder, "calibrate session -o c.json --method handheld").exit_code, 0);
  const Calibration c = read_calibration(folder / "c.json");
  EXPECT_EQ(c.recorded_gyro, (RecordedAs{"deg/s", 1, 0, {"+y", "-x", "+z"}}));
  EXPECT_EQ(c.recorded_accel, (RecordedAs{"g", 4096, 0}));
#if defined(__x86_64__) && !defined(__FMA__)
  EXPECT_EQ(difference_from_compensate(folder), 0);  // the same operations in the same order, none of them fused
#else
  EXPECT_LT(difference_from_compensate(folder), 1e-14 * 20);  // operations may be fused: some roundings of 20 m/s^2 or less
#endif
  const std::string header = read_text(folder / "calibration.h");
  EXPECT_THAT(header, HasSubstr(" * In:  accelerometers [counts, 4096 to one g], [0] along +x, [1] along +y, [2] along +z\n"
                                " *      gyros [deg/s], [0] along +y, [1] along -x, [2] along +z\n"));
  EXPECT_THAT(header, HasSubstr("imulab_compensate(const imulab_real accel_count[3], const imulab_real gyro_deg_per_s[3],"));
  EXPECT_THAT(header, HasSubstr("#define IMULAB_GYRO_UNIT \"deg/s\""));
  EXPECT_THAT(run_shell(folder, "sha256sum c.json").output, testing::StartsWith(sha256(read_text(folder / "c.json"))));
  EXPECT_THAT(header, HasSubstr("#define IMULAB_CALIBRATION_SHA256 \"" + sha256(read_text(folder / "c.json")) + "\""));
  EXPECT_THAT(header, HasSubstr("#define IMULAB_VERSION \"" + software() + "\""));
}

TEST(ExportedReadings, OfIncrementsAreIncrements) {
  const TemporaryFolder folder;
  SessionText text = hand_held_session();
  text.declare("output = \"rate\", unit = \"rad/s\"", "output = \"increment\", unit = \"arcsec\"");
  text.for_rows([](std::vector<double>& row) {
    for (std::size_t k = 1; k < 4; ++k) row[k] *= 0.01 / si_factor("arcsec");
  });
  text.write(folder);
  ASSERT_EQ(run_imulab(folder, "calibrate session -o c.json --method handheld").exit_code, 0);
  EXPECT_LT(difference_from_compensate(folder, "", 0.01), 1e-14 * 20);  // the interval is divided by elsewhere: some roundings
  EXPECT_THAT(read_text(folder / "calibration.h"), HasSubstr("gyros [arcsec, each the sum over its interval of 0.01 s]"));
}

TEST(ExportedReadings, MayBeGiven) {
  const TemporaryFolder folder;
  SessionText text = hand_held_session();
  text.write(folder, "si");
  ASSERT_EQ(run_imulab(folder, "calibrate si -o c.json --method handheld").exit_code, 0);
  SessionText other = hand_held_session();
  other.declare("unit = \"m/s^2\"", "unit = \"mg\", counts_per_unit = 2");
  other.for_rows([](std::vector<double>& row) {
    for (std::size_t k = 4; k < 7; ++k) row[k] *= 2 / si_factor("mg");
  });
  other.write(folder);  // the same readings from another driver
  EXPECT_LT(difference_from_compensate(folder, "--input-accel mg --accel-counts-per-unit 2 --body-axes"), 1e-14 * 20);
  EXPECT_THAT(read_text(folder / "calibration.h"), HasSubstr("accelerometers [counts, 2 to one mg]"));
}

TEST(ExportedReadings, ThatNobodyDescribedAreTakenInSiWithAWarning) {
  const TemporaryFolder folder;
  folder.write("count.json", calibration_text(every_term()));
  folder.write("si.json", calibration_text(every_term_in_si()));
  EXPECT_EQ(run_imulab(folder, "export count.json --to c-header -o c.h").errors, "");
  EXPECT_EQ(
      run_imulab(folder, "export si.json --to c-header --input-gyro deg/s -o c.h").errors,
      "imulab: warning: si.json: does not say how the accelerometers were recorded: the header takes m/s^2; --input-accel gives another unit\n");
  EXPECT_THAT(read_text(folder / "c.h"), HasSubstr(" * In:  accelerometers [m/s^2]"));
}

TEST(ExportedReadings, OfALiveStreamAreAsItsSessionDeclares) {
  Session session;
  session.recordings.resize(2);
  for (RecordingSource& source : session.recordings) {
    source.rate_hz = 200;
    source.accel.output = Output::increment, source.accel.unit = "g*s";
    source.gyro.unit = "deg/s";
  }
  Calibration c;
  add_declared_origin(c, session, {});
  EXPECT_EQ(c.recorded_accel, (RecordedAs{"g*s", 1, 0.005}));
  EXPECT_EQ(c.recorded_gyro, (RecordedAs{"deg/s"}));
  session.recordings[1].gyro.counts_per_unit = 131;  // recordings that differ: nothing is said
  session.recordings[0].rate_hz.reset();             // an interval that nobody knows
  add_declared_origin(c, session, {});
  EXPECT_EQ(c.recorded_accel, std::nullopt);
  EXPECT_EQ(c.recorded_gyro, std::nullopt);
}

TEST(ExportedReadings, ThatDoNotFitAreRefused) {
  const TemporaryFolder folder;
  folder.write("count.json", calibration_text(every_term()));
  folder.write("si.json", calibration_text(every_term_in_si()));
  const auto refused = [&](const std::string& arguments) {
    const CommandResult result = run_imulab(folder, "export " + arguments);
    EXPECT_EQ(result.exit_code, 2) << arguments;
    return result.errors;
  };
  EXPECT_THAT(refused("count.json --to c-header --input-accel g"),
              HasSubstr("count.json: readings of the accelerometers in g; expected count, which the calibration was made from"));
  EXPECT_THAT(refused("si.json --to c-header --input-gyro count"), HasSubstr("expected a physical unit, which the calibration was made from"));
  EXPECT_THAT(refused("si.json --to c-header --input-gyro knots"), HasSubstr("knots"));
  EXPECT_THAT(refused("si.json --to c-header --accel-counts-per-unit -3"), HasSubstr("--accel-counts-per-unit: -3; expected a number from 1e-09"));
  EXPECT_THAT(refused("count.json --to c-header --accel-counts-per-unit 3"), HasSubstr("expected a physical unit with them"));
  EXPECT_THAT(refused("si.json --to c-header --accel-range 3"),
              HasSubstr("--accel-range: is of --fixed-point and --q15; expected one of these flags as well"));
  EXPECT_THAT(refused("si.json --to c-header --fixed-point --accel-range 0"), HasSubstr("--accel-range: 0; expected a number from 1e-09"));
  EXPECT_THAT(refused("count.json --to c-header --fixed-point --gyro-range 1e12"), HasSubstr("expected one above 0 that 30 bits hold"));
  CHeaderOptions options;
  options.accel = RecordedAs{"m/s^2", 1, 0, {"+x", "-x", "+z"}};
  EXPECT_THAT([&] { c_header(every_term_in_si(), options); }, ThrowsMessage<Error>(HasSubstr("axis -x of column 2")));
}

TEST(ExportedReadings, AndNumbersOfNoImuMakeNoHeader) {
  CHeaderOptions options;
  options.fixed_point = true;
  const auto refused = [&](auto change, const std::string& message) {
    Calibration c = every_term_in_si();
    change(c);
    EXPECT_THAT(([&, c = c] { c_header(c, options); }), ThrowsMessage<Error>(HasSubstr(message)));
  };
  refused([](Calibration& c) { c.recorded_accel = RecordedAs{"g", 1e-320}; }, "readings of the accelerometers in counts");
  refused([](Calibration& c) { c.recorded_gyro = RecordedAs{"rad", 1, 1e-320}; }, "cannot be converted");
  refused([](Calibration& c) { c.model.accel.offset.x() = 1e308, c.model.accel.offset.y() = c.model.gyro.matrix(0, 0) = std::nan(""); },
          "not finite");
  refused([](Calibration& c) { c.model.accel.cubic.setConstant(1e307); }, "would be too large");
  refused([](Calibration& c) { c.model.accel.offset.x() = 1e300; }, "expected 1e-6 to 1e6");
  refused([](Calibration& c) { c.model.gyro.temperature->range = {-1e308, 1e308}; }, "");
  refused([](Calibration& c) { c.model.gyro.temperature->range = {-1e30, 1e30}; }, "expected less than 1e9");
  refused([](Calibration& c) { c.model.gyro.thermal(0, 1) = 1e6; }, "the thermal drift is larger than the range");
}

TEST(ExportedReadings, OfACalibrationFileAreChecked) {
  Calibration c = every_term();
  c.recorded_accel = RecordedAs{"count", 1, 0, {"-z", "+y", "+x"}};
  c.recorded_gyro = RecordedAs{"count", 1, 0.005};
  const std::string text = calibration_text(c);
  const Calibration back = parse_calibration(text, "c.json");
  EXPECT_EQ(back.recorded_accel, c.recorded_accel);
  EXPECT_EQ(back.recorded_gyro, c.recorded_gyro);
  EXPECT_EQ(calibration_text(back), text);
  const auto changed = [&](RecordedAs as) {
    c.recorded_accel = std::move(as);
    return calibration_text(c);
  };
  for (const auto& [as, message] : {std::pair{RecordedAs{"g"}, "recorded.accel.unit: expected what becomes count"},
                                    {RecordedAs{"stone"}, "recorded.accel.unit: expected count, m/s^2"},
                                    {RecordedAs{"count", 0}, "recorded.accel.counts_per_unit: expected a number above 0"},
                                    {RecordedAs{"count", 2}, "recorded.accel.counts_per_unit: expected 1"},
                                    {RecordedAs{"count", 1, -1}, "recorded.accel.interval_s: expected"},
                                    {RecordedAs{"count", 1, 0, {"+x", "x", "+z"}}, "recorded.accel.axes[1]: expected a body axis"},
                                    {RecordedAs{"count", 1, 0, {"+x", "-x", "+z"}}, "recorded.accel.axes[1]: expected an axis that no other"}})
    EXPECT_THAT(([&, text = changed(as)] { parse_calibration(text, "c.json"); }), ThrowsMessage<Error>(HasSubstr(message)));
}

}  // namespace
}  // namespace imulab
