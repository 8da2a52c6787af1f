// What is given in memory is checked as strictly as what is read from a file: an Error, with all problems at once, and never an assertion.
#include "imulab/calibrate.hpp"
#include "imulab/compare.hpp"
#include "imulab/compensate.hpp"
#include "imulab/error.hpp"
#include "imulab/estimate/method.hpp"
#include "imulab/files.hpp"
#include "imulab/fleet/statistics/statistics.hpp"
#include "imulab/formats/calibration/file.hpp"
#include "imulab/frame.hpp"
#include "imulab/navigate.hpp"
#include "imulab/navigation/budget/budget.hpp"
#include "imulab/noise.hpp"
#include "imulab/noise/noise_analysis.hpp"
#include "imulab/outlier_filter.hpp"
#include "imulab/parallel.hpp"
#include "imulab/recording/compensated_readings.hpp"
#include "imulab/recording/readings.hpp"
#include "imulab/recording/rests_of_view.hpp"
#include "imulab/rests.hpp"
#include "imulab/simulate.hpp"

#include <gmock/gmock.h>

#include "tests/run_command.hpp"
#include <limits>
#include <string>
#include <vector>

namespace imulab {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;
using ::testing::Not;
using ::testing::StartsWith;

constexpr double nan = std::numeric_limits<double>::quiet_NaN(), infinite = std::numeric_limits<double>::infinity();

template <class Work>
std::string error_of(const Work& work) {
  try {
    work();
  } catch (const Error& e) {
    return e.what();
  }
  return "no error";
}

struct Unit {
  Session session;
  std::vector<Recording> recordings;
};
const Unit& unit_by_hand() {
  static const Unit unit = [] {
    Unit out{hand_held_procedure({.poses = 12, .first_rest = 5, .rest = 2}, 1), {}};
    out.recordings = {simulate_recording(out.session, out.session.recordings[0], draw_truth(out.session, 1), 1)};
    return out;
  }();
  return unit;
}

std::string refusal(const Unit& unit, const CalibrationOptions& options = {}, std::optional<std::vector<Range>> rests = {}) {
  return error_of([&] { calibrate("handheld", {unit.session, unit.recordings, std::move(rests)}, options); });
}

TEST(Validity, AllProblemsOfACalibrationAtOnce) {
  Unit wrong = unit_by_hand();
  wrong.session.site.latitude = 45;
  wrong.session.site.given_gravity = -9.8;
  wrong.session.imu.gyro_noise_density = -1e-3;
  wrong.recordings[0].gyro[1].pop_back();
  CalibrationOptions options{.terms = {CoefficientIndex(400)}, .significance = -3, .outlier_level = 7};
  options.handheld.rest_s = nan;
  options.hybrid.curve_interval = -1;
  options.handheld.requirements = {Requirement{"nothing", {}, -1, {"ppm", 1e-6}}};
  EXPECT_THAT(refusal(wrong, options, std::vector<Range>{{50, 20}}),
              AllOf(HasSubstr("terms: coefficient 400 is not in the table; expected 0 to 107"), HasSubstr("significance: -3 is no probability"),
                    HasSubstr("outlier_level: 7 is no probability"), HasSubstr("a requirement of no coefficient"), HasSubstr("handheld.rest_s: nan"),
                    HasSubstr("hybrid.curve_interval: -1"), HasSubstr("site.latitude_deg: 2578.31"), HasSubstr("site.gravity_mps2: -9.8"),
                    HasSubstr("imu.gyro_noise_density"), HasSubstr("gyro y"), HasSubstr("rests: samples 50 to 20 are no rest")));
}

TEST(Validity, RestsAreRangesInOrder) {
  const std::size_t n = unit_by_hand().recordings[0].size();
  for (const std::vector<Range>& rests : {std::vector<Range>{{50, 20}},
                                          {{0, n + 1}},
                                          {{200, 400}, {0, 100}},
                                          {{0, 400}, {300, 600}},
                                          {{0, 600}, {560, 590}},
                                          {{7, 7}},
                                          {{std::numeric_limits<std::size_t>::max(), 5}}})
    EXPECT_THAT(refusal(unit_by_hand(), {}, rests), StartsWith("rests: samples "));
}

TEST(Validity, RecordingsAreThoseOfTheSession) {
  Unit wrong = unit_by_hand();
  wrong.recordings.push_back(wrong.recordings[0]);
  EXPECT_EQ(refusal(wrong), "2 recordings were given; the session declares 1");
  wrong = unit_by_hand();
  wrong.recordings[0].name = "other.csv", wrong.recordings[0].gyro_unit = "count";
  EXPECT_EQ(refusal(wrong),
            "recording 1 is named other.csv; expected recording.csv as in the session\n  other.csv: gyro is in count; the session declares rad/s");
  wrong.recordings.clear();
  EXPECT_EQ(refusal(wrong), "the method handheld takes one recording; got none");
  wrong = unit_by_hand();
  wrong.recordings[0].saturated = {1'000'000'000};
  EXPECT_THAT(refusal(wrong), HasSubstr("saturated: entry 0 is sample 1000000000"));
}

TEST(Validity, SessionsInMemoryHaveBodyAxes) {
  Session session = unit_by_hand().session;
  session.recordings[0].gyro.axes = {{BodyAxis{0, 1}, {0, 1}, {2, 1}}};
  session.steps[0].mount = Mount{{7, 1}, {0, 1}};
  EXPECT_THAT(error_of([&] { draw_truth(session, 1); }), AllOf(HasSubstr("gyro.axes: are no body axes"), HasSubstr("the mount has no body axes")));
}

TEST(Validity, PredictionsCheckProcedureAndOptions) {
  for (const Method& method : methods()) {
    if (!method.example) continue;
    Session wrong = method.example({});
    wrong.site.latitude = 45;
    const PredictionOptions options{.terms = {CoefficientIndex(-1)}, .requirements = {Requirement{"x", {CoefficientIndex(108)}, 1, {}}}};
    EXPECT_THAT(error_of([&] { predict(method, wrong, options); }),
                AllOf(HasSubstr("terms: coefficient -1 "), HasSubstr("requirements: coefficient 108 "), HasSubstr("site.latitude_deg")));
  }
}

Calibration calibrated_scale() {
  Calibration c;
  c.estimated = select_coefficients("accel.matrix.diagonal");
  c.covariance = 1e-8 * Eigen::MatrixXd::Identity(3, 3);
  return c;
}

TEST(Validity, CalibrationsHaveTheirCovariance) {
  EXPECT_EQ(error_of([] { validate(calibrated_scale()); }), "no error");
  Calibration c = calibrated_scale();
  c.covariance = Eigen::MatrixXd::Identity(2, 2);
  const std::string size = "the calibration: the covariance is 2 x 2; expected 3 x 3, a row and a column a coefficient that was estimated";
  const Calibration good = calibrated_scale();
  EXPECT_EQ(error_of([&] { standard_uncertainty(c, c.estimated[0]); }), size);
  EXPECT_EQ(error_of([&] { raw_zero(c, Triad::accel); }), size);
  EXPECT_EQ(error_of([&] { output_covariance(c, {}); }), size);
  EXPECT_EQ(error_of([&] { compare(good, c); }), size);
  EXPECT_EQ(error_of([&] { agreement({good, c}); }), size);
  EXPECT_EQ(error_of([&] { in_accelerometer_frame(c); }), size);
  EXPECT_EQ(error_of([&] { error_sources(c); }), size);
  EXPECT_EQ(error_of([&] { calibration_text(c); }), size);
  EXPECT_EQ(error_of([&] { navigate(c, unit_by_hand().session, unit_by_hand().recordings[0]); }), size);
  c = calibrated_scale();
  c.estimated[1] = CoefficientIndex(400);
  c.model.gyro.offset.x() = nan;
  EXPECT_THAT(error_of([&] { validate(c); }), AllOf(HasSubstr("coefficient 400 is not in the table"), HasSubstr("gyro.offset.x is not finite")));
  c = calibrated_scale();
  c.estimated[1] = c.estimated[0];
  EXPECT_THAT(error_of([&] { validate(c); }), HasSubstr("accel.matrix.xx is listed twice"));
  for (const auto& [wrong, message] :
       {std::pair{-1e-8, "the variance of accel.matrix.xx is -1e-08"}, {nan, "the variance of accel.matrix.xx is nan"}}) {
    c = calibrated_scale();
    c.covariance(0, 0) = wrong;
    EXPECT_THAT(error_of([&] { validate(c); }), HasSubstr(message));
  }
  c = calibrated_scale();
  c.covariance(1, 0) = 1e-9;
  EXPECT_THAT(error_of([&] { validate(c); }), HasSubstr("accel.matrix.yy and accel.matrix.xx is not symmetric"));
  c.covariance(1, 0) = c.covariance(0, 1) = 2e-8;
  EXPECT_THAT(error_of([&] { validate(c); }), HasSubstr("are correlated by more than 1"));
}

TEST(Validity, ProvenanceIsThatOfTheRecordings) {
  Calibration c;
  const Unit& unit = unit_by_hand();
  EXPECT_EQ(error_of([&] { add_provenance(c, unit.session, {}); }), "0 recordings were given; the session declares 1");
  EXPECT_EQ(error_of([&] { add_provenance(c, {}, unit.recordings); }), "1 recordings were given; the session declares 0");
  std::vector<Recording> empty(1);
  EXPECT_THAT(error_of([&] { add_provenance(c, unit.session, empty); }), HasSubstr("no samples"));
}

TEST(Validity, IndicesAndCountsAreThere) {
  const Recording& r = unit_by_hand().recordings[0];
  EXPECT_THAT(error_of([] { coefficient(CoefficientIndex(400)); }), StartsWith("coefficient 400"));
  EXPECT_THAT(error_of([] { coefficient_value({}, CoefficientIndex(-1)); }), StartsWith("coefficient -1"));
  EXPECT_THAT(error_of([&] { r.interval(r.size(), false); }), HasSubstr("sample "));
  CompensatedReadings readings(r, {});
  EXPECT_THAT(error_of([&] { readings.rate(r.size()); }), HasSubstr("sample "));
  Recording all;
  EXPECT_THAT(error_of([&] { append(all, r, {5, r.size() + 1}); }), HasSubstr("expected an ascending range within"));
  EXPECT_THAT(error_of([] { ErrorBudget().shares(0, 0); }), HasSubstr("at output 0"));
  EXPECT_THAT(error_of([] { ErrorBudget().horizontal_shares(3); }), HasSubstr("output 3"));
  EXPECT_THAT(error_of([] { ThreadLimit(0); }), HasSubstr("0 threads"));
  EXPECT_THAT(error_of([] { noise_batch({}); }), HasSubstr("no logs"));
  EXPECT_THAT(error_of([&] { analyze_noise(r, {.range = {0, r.size() + 5}, .interval_s = 0.01}); }), HasSubstr("part at rest"));
  for (const double factor : {0.0, -1.0, nan, infinite}) EXPECT_THAT(error_of([&] { OutlierFilter{factor}; }), HasSubstr("outlier filter"));
  for (const double window : {0.0, -1.0, nan, infinite})
    EXPECT_THAT(error_of([&] { detect_rests(r, {.window_s = window}); }), HasSubstr("expected more than 0"));
  for (const double level : {0.0, 1.0, nan}) EXPECT_THAT(error_of([&] { fleet_statistics({}, {}, {.confidence = level}); }), HasSubstr("confidence"));
}

TEST(Validity, ColumnsHaveOneLength) {
  Recording r = unit_by_hand().recordings[0];
  r.accel[2].pop_back();
  EXPECT_THAT(error_of([&] { compensate({}, r); }), HasSubstr("accel z"));
  EXPECT_THAT(error_of([&] { remove_lever_arms(r, Matrix3d::Zero()); }), HasSubstr("accel z"));
  EXPECT_THAT(error_of([&] { Compensator({}, Outliers::reject).next(r); }), HasSubstr("accel z"));
  EXPECT_THAT(error_of([&] { rests_of(r, {}); }), HasSubstr("accel z"));
  std::vector<double> one(1), two(2);
  const MotionColumns columns{{one, one, one}, {one, two, one}};
  EXPECT_THAT(error_of([&] { decompensate({}, {}, {}, columns); }), HasSubstr("columns of different lengths"));
}

TEST(Validity, SimulationsOfAnImpossibleTruthAreRefused) {
  const Session& session = unit_by_hand().session;
  Truth truth = draw_truth(session, 1);
  truth.gyro_noise.N = -1, truth.gravity = nan, truth.model.accel.offset.y() = infinite;
  EXPECT_THAT(error_of([&] { simulate_recording(session, session.recordings[0], truth, 1); }),
              AllOf(HasSubstr("accel.offset.y is not finite"), HasSubstr("gravity is nan"), HasSubstr("gyro_noise: a term is -1")));
  EXPECT_THAT(error_of([] { hand_held_procedure({.latitude = 45}, 1); }), HasSubstr("site.latitude_deg"));
  EXPECT_THAT(error_of([] { zhang_24_procedure({.latitude = 45}); }), HasSubstr("site.latitude_deg"));
  EXPECT_THAT(error_of([] { dai_unit_procedure({.latitude = 45}); }), HasSubstr("site.latitude_deg"));
}

/// What was moved from, or is in memory without a name, is called what it is.
TEST(Validity, MessagesNameWhatHasNoName) {
  Recording moved;
  moved.name.clear();
  EXPECT_THAT(error_of([&] { validate(moved); }), StartsWith("recording: no samples"));
  Unit unit = unit_by_hand();
  unit.session.file.clear();
  unit.session.rigs.clear();
  EXPECT_THAT(error_of([&] { calibrate("turntable", {unit.session, unit.recordings}); }), StartsWith("session: no rig"));
  EXPECT_THAT(error_of([&] { predict("turntable", unit.session); }), StartsWith("procedure: no rig"));
}

}  // namespace
}  // namespace imulab
