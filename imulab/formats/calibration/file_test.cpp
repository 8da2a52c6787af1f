#include "imulab/coefficient.hpp"
#include "imulab/core/random.hpp"
#include "imulab/error.hpp"
#include "imulab/files.hpp"
#include "imulab/model/finding_table.hpp"

#include <gmock/gmock.h>
#include <nlohmann/json.hpp>

#include "tests/temporary_folder.hpp"
#include <bit>
#include <cmath>
#include <filesystem>
#include <limits>

namespace imulab {
namespace {

using Json = nlohmann::ordered_json;
using ::testing::HasSubstr;
using ::testing::StartsWith;
using ::testing::ThrowsMessage;

/// A calibration with every field filled, numbers of all sizes, and an awkward text.
Calibration any_calibration() {
  Calibration c;
  c.imu = "RLG-90 \"#012\" \u00b0";
  c.method = "hybrid";
  c.created = "2026-11-20T12:00:00Z";
  c.software = "imulab 0.1.0";
  c.session_file = "session.toml";
  c.session_sha256 = std::string(64, 'a');
  c.frame = BodyFrame::rig;
  const RandomStream random(1, "calibration file");
  for (const CoefficientIndex i : coefficient_indices()) {
    const auto k = static_cast<std::uint64_t>(i);
    set_coefficient(c.model, i, random.normal(2 * k) * std::pow(10.0, 20 * random.normal(2 * k + 1)));
  }
  c.model.accel.raw_unit = "count";
  c.model.accel.temperature = ThermalReading{"degC", 25.1, {0.3, 70.7}};
  c.model.gyro.temperature = ThermalReading{"raw", 5012.3, {4990.1, 5030.9}};
  c.estimated = {coefficient_index("gyro.matrix.xy"), coefficient_index("accel.offset.x"), coefficient_index("accel.thermal.z2")};
  Eigen::Matrix3d l;
  l << 1e-7, 0, 0, 3e-4, 1.0 / 3, 0, -2e-9, 1e-9, 7e-9;
  c.covariance = l * l.transpose();
  c.quality = {.chi2_per_dof = 1.02,
               .degrees_of_freedom = 123,
               .condition = 812.7,
               .unobservable = {"accel.matrix.xy"},
               .verdict = Verdict::doubtful,
               .considered = {"accel.quadratic.x"},
               .rotation_residual_deg = 0.071,
               .term_tests = {{"gyro.g_sensitivity", 103.5, 9, 1e-18, true, 1.02, 17.7}},
               .fit_residuals = {{"gyro.x", 1e-5, 3e-5, 6.98}},
               .rig_errors = {{"centrifuge: radius.+z+x", 1e-4, -2.5e-5, 3e-6}},
               .sources = {{"gravity", 3e-5, "scales accel.matrix"}},
               .rests = {{0.5, 31.25, 0.98, true}, {40, 71, 12.5, false}},
               .rotations = {{31.25, 40, 1.7, true}},
               .requirements = {{"accel.offset <= 20 ug", "accel.offset.y", 2e-4, 1.5e-4, true},
                                {"gyro.offset <= 1 deg/h", "gyro.offset.x", 5e-6, std::numeric_limits<double>::infinity(), false}}};
  c.quality.findings.add<Code::uncertain_scale>(Subject{"gyro.matrix.xx"}, 2.5);
  c.quality.findings.add<Code::scatter>(Subject{"residuals"}, 3.1).severity = Severity::doubt;
  c.quality.findings.add<Code::larger_term>(Subject{"accel.cubic"});
  c.quality.findings.append(Severity::note, {"24 rests"});
  c.constant_covariance = 0.5 * c.covariance;
  c.serial = "012";
  c.operated_by = "A. N. Other";
  c.firmware = "2.1", c.filter = "low-pass, 42 Hz", c.station = "table 2", c.measured = "2026-03-31", c.valid_until = "2027-03-31";
  c.warm_up = "45 min";
  c.references = {{"rotation", "table 7", "T 12", "2026-03-31", "U = 2 arcsec"}, {"time", "counter", "C 1", "", ""}};
  c.sources = {{"recording.csv", std::string(64, 'a'), 123456789012, -0.5, 511.7, std::array{20.5, 31.0}, std::nullopt}};
  c.options = {{"terms", "auto"}};
  c.turn_on = {.accel = 1e-4, .gyro = 2e-6}, c.next_switch_on = {{"accel.offset.x", 3e-4}, {"gyro.offset.z", 1.0 / 3}};
  return c;
}

void expect_equal(const Calibration& a, const Calibration& b) {
  EXPECT_EQ(std::tie(a.imu, a.method, a.created, a.software, a.session_file, a.session_sha256, a.frame),
            std::tie(b.imu, b.method, b.created, b.software, b.session_file, b.session_sha256, b.frame));
  for (const CoefficientIndex i : coefficient_indices())
    EXPECT_EQ(std::bit_cast<std::uint64_t>(coefficient_value(a.model, i)), std::bit_cast<std::uint64_t>(coefficient_value(b.model, i))) << i;
  EXPECT_EQ(a.model.accel.raw_unit, b.model.accel.raw_unit);
  EXPECT_EQ(a.model.gyro.raw_unit, b.model.gyro.raw_unit);
  EXPECT_EQ(a.model.accel.temperature, b.model.accel.temperature);
  EXPECT_EQ(a.model.gyro.temperature, b.model.gyro.temperature);
  EXPECT_EQ(a.estimated, b.estimated);
  EXPECT_EQ(a.covariance, b.covariance);
  EXPECT_TRUE(a.quality == b.quality);
  EXPECT_EQ(std::tie(a.serial, a.operated_by, a.options), std::tie(b.serial, b.operated_by, b.options));
  EXPECT_EQ(std::tie(a.filter, a.station, a.measured, a.valid_until), std::tie(b.filter, b.station, b.measured, b.valid_until));
  EXPECT_EQ(std::tie(a.firmware, a.warm_up, a.power_cycles, a.references), std::tie(b.firmware, b.warm_up, b.power_cycles, b.references));
  EXPECT_TRUE(a.sources == b.sources);
  EXPECT_EQ(a.turn_on, b.turn_on);
  EXPECT_EQ(a.next_switch_on, b.next_switch_on);
}

TEST(CalibrationFile, ReadsBackBitForBit) {
  const Calibration c = any_calibration();
  const std::string text = calibration_text(c);
  const Calibration back = parse_calibration(text, "calibration.json");
  expect_equal(back, c);
  EXPECT_EQ(calibration_text(back), text);
}

TEST(CalibrationFile, HasTheCodesOfItsFindings) {
  const Calibration c = any_calibration();
  Json json = Json::parse(calibration_text(c));
  Json& quality = json["quality"];
  EXPECT_EQ(quality["findings"][0]["code"], "uncertain-scale");
  EXPECT_EQ(quality["findings"][0]["severity"], "doubt");
  EXPECT_EQ(quality["findings"][0]["subject"], "gyro.matrix.xx");
  EXPECT_EQ(quality["findings"][0]["numbers"], Json::array({2.5}));
  EXPECT_EQ(quality["because"].size(), 2u);
  EXPECT_EQ(quality["notes"], Json::array({"24 rests"}));
  // A file of an earlier version has their sentences alone, and people add some.
  quality.erase("findings");
  quality["because"].push_back("a reason of its own");
  const Findings back = parse_calibration(json.dump(), "c.json").quality.findings;
  std::vector<std::string> reasons = c.quality.findings.reasons();
  reasons.emplace_back("a reason of its own");
  EXPECT_EQ(back.reasons(), reasons);
  EXPECT_EQ(back.warnings(), c.quality.findings.warnings());
  EXPECT_EQ(back.notes(), c.quality.findings.notes());
  EXPECT_FALSE(back.has(Code::uncertain_scale));
}

TEST(CalibrationFile, OfADefaultCalibrationReadsBack) { expect_equal(parse_calibration(calibration_text({}), "calibration.json"), {}); }

TEST(CalibrationFile, HasTheShapeOfTheFormat) {
  const Json json = Json::parse(calibration_text(any_calibration()));
  EXPECT_EQ(json["format"], "imulab.calibration/1");
  EXPECT_EQ(json["model"]["accel"]["matrix"][1].size(), 3u);
  EXPECT_EQ(json["model"]["gyro"]["g_sensitivity"][2].size(), 3u);
  EXPECT_EQ(json["model"]["accel"]["thermal"][0][0], 0.0);
  EXPECT_EQ(json["model"]["accel"]["temperature"]["range"][1], 70.7);
  EXPECT_EQ(json["covariance"]["coefficients"][0], "gyro.matrix.xy");
  EXPECT_EQ(json["standard_uncertainty"]["gyro"]["matrix"][0][1], std::sqrt(json["covariance"]["matrix"][0][0].get<double>()));
  EXPECT_TRUE(json["standard_uncertainty"]["gyro"]["matrix"][0][0].is_null());
  EXPECT_TRUE(json["standard_uncertainty"]["gyro"]["thermal"][0][0].is_null());
  EXPECT_EQ(json["model"]["accel"]["raw"], "count");
  EXPECT_EQ(json["model"]["accel"].size(), 10u);
  EXPECT_EQ(json["model"]["gyro"].size(), 9u) << "a raw unit that is not known is left out";
}

TEST(CalibrationFile, KeysBeyondTheFormatAreLeftAlone) {
  Json json = Json::parse(calibration_text({}));
  json["rig"] = {{"angle_error", {1, 2, 3}}};
  EXPECT_NO_THROW(parse_calibration(json.dump(), "truth.json"));
}

TEST(CalibrationFile, NumbersThatAreNotFiniteAreNotWritten) {
  Calibration c;
  c.model.accel.offset.x() = std::nan("");
  EXPECT_THROW(calibration_text(c), Error);
}

TEST(CalibrationFile, WhatCouldNotBeReadIsNotWritten) {
  const TemporaryFolder folder;
  Calibration c;
  c.estimated = select_coefficients("accel.offset");
  for (const double variance : {-1.0, std::nan(""), std::numeric_limits<double>::infinity()}) {
    c.covariance = Eigen::MatrixXd::Identity(3, 3);
    c.covariance(1, 1) = variance;
    EXPECT_THAT([&] { write_calibration(folder / "c.json", c); }, ThrowsMessage<Error>(HasSubstr("the variance of accel.offset.y is ")));
    EXPECT_FALSE(std::filesystem::exists(folder / "c.json"));
  }
}

TEST(CalibrationFile, QualityMayHoldAConditionWithoutBound) {
  Calibration c;
  c.quality.condition = std::numeric_limits<double>::infinity();
  EXPECT_TRUE(std::isnan(parse_calibration(calibration_text(c), "calibration.json").quality.condition));
}

TEST(CalibrationFile, TextThatIsNotJsonNamesTheLine) {
  try {
    parse_calibration("{\n  \"format\": \"imulab.calibration/1\",\n  oops\n}", "calibration.json");
    ADD_FAILURE() << "accepted";
  } catch (const Error& e) {
    EXPECT_THAT(e.what(), StartsWith("calibration.json:3: not JSON"));
  }
  EXPECT_THROW(parse_calibration("", "calibration.json"), Error);
  EXPECT_THROW(parse_calibration("[1, 2]", "calibration.json"), Error);
  EXPECT_THROW(parse_calibration("{\"format\": 1e999}", "calibration.json"), Error);
}

struct Damage {
  const char* pointer;  ///< JSON pointer of what is replaced; removed where `value` is empty
  const char* value;
  const char* message;
};

TEST(CalibrationFile, DamageIsRefusedByNameAndPlace) {
  const Damage cases[] = {
      {"/format", "\"imulab.calibration/2\"",
       "calibration.json: format: imulab.calibration/2 is a newer format; this program reads imulab.calibration/1"},
      {"/format", "\"imulab.session/1\"", "calibration.json: format: expected \"imulab.calibration/1\", found \"imulab.session/1\""},
      {"/format", "", "calibration.json: format: is missing"},
      {"/standard_uncertainty_next_switch_on/accel.offset.x", "-1",
       "calibration.json: standard_uncertainty_next_switch_on: expected uncertainties of offsets, from 0 on"},
      {"/standard_uncertainty_next_switch_on/accel.ofset.y", "1",
       "calibration.json: standard_uncertainty_next_switch_on: expected uncertainties of offsets, from 0 on"},
      {"/frame", "\"body\"", "calibration.json: frame: expected \"accelerometers\" or \"rig\", found \"body\""},
      {"/model", "", "calibration.json: model: is missing"},
      {"/model", "3", "calibration.json: model: expected an object, found 3"},
      {"/model/gyro", "", "calibration.json: model.gyro: is missing"},
      {"/model/gyro/matrix", "", "calibration.json: model.gyro.matrix: is missing"},
      {"/model/gyro/temperature", "", "calibration.json: model.gyro: temperature: is missing; expected a reading"},
      {"/model/gyro/temperature/reference", "", "calibration.json: model.gyro.temperature.reference: is missing"},
      {"/model/accel/matrix/1", "[1, 2]", "calibration.json: model.accel.matrix[1]: expected 3 numbers"},
      {"/model/accel/matrix", "[1, 2, 3]", "calibration.json: model.accel.matrix[0]: expected 3 numbers"},
      {"/model/accel/matrix", "[[1, 2, 3]]", "calibration.json: model.accel.matrix: expected 3 rows of 3 numbers"},
      {"/model/accel/offset", "0", "calibration.json: model.accel.offset: expected 3 numbers"},
      {"/model/accel/offset/2", "\"0\"", "calibration.json: model.accel.offset[2]: expected a number, found \"0\""},
      {"/model/gyro/cubic/0", "null", "calibration.json: model.gyro.cubic[0]: expected a number, found null"},
      {"/model/gyro/thermal/1/0", "0.5", "calibration.json: model.gyro.thermal[1][0]: expected 0: the constant"},
      {"/model/gyro/temperature", "null", "calibration.json: model.gyro.temperature: expected a reading"},
      {"/model/gyro/temperature/unit", "\"F\"", "calibration.json: model.gyro.temperature.unit: expected degC, K or raw, found \"F\""},
      {"/model/gyro/temperature/range", "[70, 0]", "calibration.json: model.gyro.temperature.range: expected [lowest, highest]"},
      {"/covariance", "", "calibration.json: standard_uncertainty.accel.offset[0]: expected null: the covariance does not hold accel.offset.x"},
      {"/covariance/matrix", "", "calibration.json: covariance.matrix: is missing"},
      {"/covariance/coefficients/1", "\"accel.ofset.x\"", "calibration.json: covariance.coefficients[1]: unknown coefficient \"accel.ofset.x\""},
      {"/covariance/coefficients/1", "\"gyro.matrix.xy\"", "calibration.json: covariance.coefficients[1]: gyro.matrix.xy is listed twice"},
      {"/covariance/matrix", "[[1, 0], [0, 1]]", "calibration.json: covariance.matrix: expected 3 rows"},
      {"/covariance/constant", "[[1, 0], [0, 1]]", "calibration.json: covariance.constant: expected 3 rows"},
      {"/covariance/constant", "null", "calibration.json: covariance.constant: expected a list, found null"},
      {"/covariance/constant/0/0", "1e9", "calibration.json: covariance.constant: gyro.matrix.xy: 1000000000"},
      {"/covariance/constant/0/0", "-1", "calibration.json: covariance.constant[0][0]: expected a variance, which is not negative"},
      {"/covariance/matrix/2", "[1, 0]", "calibration.json: covariance.matrix[2]: expected 3 numbers"},
      {"/covariance/matrix/0/0", "-1", "calibration.json: covariance.matrix[0][0]: expected a variance, which is not negative, found -1"},
      {"/covariance/matrix/1/0", "0", "calibration.json: covariance.matrix[1][0]: expected"},
      {"/covariance/matrix/1/0", "true", "calibration.json: covariance.matrix[1][0]: expected a number, found true"},
      {"/standard_uncertainty/gyro/matrix/0/1", "1", "calibration.json: standard_uncertainty.gyro.matrix[0][1]: expected"},
      {"/standard_uncertainty/gyro/matrix/0/1", "null", "calibration.json: standard_uncertainty.gyro.matrix[0][1]: expected a number, found null"},
      {"/standard_uncertainty/gyro/matrix/0/0", "1", "calibration.json: standard_uncertainty.gyro.matrix[0][0]: expected null"},
      {"/quality/verdict", "1", "calibration.json: quality.verdict: expected a text, found 1"},
      {"/quality/verdict", "\"fine\"", "calibration.json: quality.verdict: expected good or doubtful, found \"fine\""},
      {"/quality/unobservable", "{}", "calibration.json: quality.unobservable: expected a list, found {}"},
      {"/quality/term_tests/0/kept", "1", "calibration.json: quality.term_tests[0].kept: expected true or false, found 1"},
  };
  for (const Damage& damage : cases) {
    Json json = Json::parse(calibration_text(any_calibration()));
    const Json::json_pointer pointer(damage.pointer);
    if (*damage.value) {
      json[pointer] = Json::parse(damage.value);
    } else {
      json[pointer.parent_pointer()].erase(pointer.back());
    }
    try {
      parse_calibration(json.dump(), "calibration.json");
      ADD_FAILURE() << "accepted " << damage.pointer << " = " << damage.value;
    } catch (const Error& e) {
      EXPECT_THAT(e.what(), StartsWith(damage.message)) << damage.pointer << " = " << damage.value;
    }
  }
}

TEST(CalibrationFile, WrittenByHandNeedsTheMatricesAlone) {
  const Calibration c = parse_calibration(R"({"format": "imulab.calibration/1", "model": {
      "accel": {"matrix": [[1.01, 0, 0], [0.002, 0.99, 0], [0, 0, 1]]}, "gyro": {"matrix": [[2, 0, 0], [0, 2, 0], [0, 0, 2]]}}})",
                                          "hand.json");
  Calibration expected;
  expected.frame = BodyFrame::rig;
  expected.covariance.resize(0, 0);
  expected.model.accel.matrix << 1.01, 0, 0, 0.002, 0.99, 0, 0, 0, 1;
  expected.model.gyro.matrix = 2 * Matrix3d::Identity();
  expect_equal(c, expected);
  const Json json = Json::parse(calibration_text(c));
  for (const auto& triad : json["standard_uncertainty"])
    for (const auto& term : triad)
      for (const auto& row : term)
        for (const auto& element : row.is_array() ? row : Json::array({row})) EXPECT_TRUE(element.is_null());
  expect_equal(parse_calibration(json.dump(), "again.json"), expected);
}

TEST(CalibrationFile, EveryPartIsOptionalButTheMatrices) {
  const Json whole = Json::parse(calibration_text(any_calibration()));
  Json without_uncertainties = whole;
  without_uncertainties["standard_uncertainty"] = without_uncertainties["covariance"] = nullptr;
  EXPECT_NO_THROW(parse_calibration(without_uncertainties.dump(), "calibration.json"));
  const auto expect_optional = [&](const std::string& pointer) {
    Json json = without_uncertainties;
    const Json::json_pointer at(pointer);
    if (at.empty() || !json.contains(at)) return ADD_FAILURE() << pointer;
    json[at.parent_pointer()].erase(at.back());
    EXPECT_NO_THROW(parse_calibration(json.dump(), "calibration.json")) << pointer;
  };
  for (const auto& item : whole.items())
    if (item.key() != "format" && item.key() != "model") expect_optional("/" + item.key());
  for (const char* term : {"accel/offset", "accel/quadratic", "accel/cubic", "accel/lever_arm", "accel/raw", "gyro/offset", "gyro/quadratic",
                           "gyro/cubic", "gyro/g_sensitivity", "gyro/temperature/range"})
    expect_optional("/model/" + std::string(term));
  for (const auto& item : whole["quality"].items()) expect_optional("/quality/" + item.key());
}

std::string problems_of(const std::string& text) {
  try {
    parse_calibration(text, "c.json");
  } catch (const Error& e) {
    return e.what();
  }
  return "";
}

TEST(CalibrationFile, AllProblemsAreReportedAtOnce) {
  EXPECT_EQ(problems_of(R"({"format": "imulab.calibration/1", "imu": 5, "frame": "body", "model": {
      "accel": {"matrix": [[1, 2], [3, 4]], "offset": [0, "0", null]}, "gyro": {}}, "covariance": {"coefficients": ["x"], "matrix": []},
      "quality": {"verdict": 1}})"),
            "c.json: imu: expected a text, found 5\n"
            "c.json: frame: expected \"accelerometers\" or \"rig\", found \"body\"\n"
            "c.json: model.accel.offset[1]: expected a number, found \"0\"\n"
            "c.json: model.accel.matrix: expected 3 rows of 3 numbers\n"
            "c.json: model.gyro.matrix: is missing\n"
            "c.json: covariance.coefficients[0]: unknown coefficient \"x\"; expected triad.term.element such as gyro.matrix.xy, a term such as "
            "accel.offset, or gyro.matrix.diagonal, gyro.matrix.off_diagonal\n"
            "c.json: quality.verdict: expected a text, found 1");
  EXPECT_EQ(problems_of(R"({"format": "imulab.calibration/1", "model": 3})"), "c.json: model: expected an object, found 3");
  std::string many = R"({"format": "imulab.calibration/1", "model": {"accel": {"matrix": [])";
  for (int i = 0; i < 100; ++i) many += ", \"k" + std::to_string(i) + "\": 0";
  EXPECT_THAT(problems_of(many + "}, \"gyro\": {}}}"), ::testing::EndsWith("\nand 82 more"));
}

TEST(CalibrationFile, AMistypedKeyIsNotZero) {
  const auto with = [](const std::string& top, const std::string& model, const std::string& accel) {
    return problems_of(R"({"format": "imulab.calibration/1", )" + top + R"("model": {)" + model +
                       R"("gyro": {"matrix": [[1, 0, 0], [0, 1, 0], [0, 0, 1]]}, "accel": {)" + accel +
                       R"("matrix": [[1, 0, 0], [0, 1, 0], [0, 0, 1]]}}})");
  };
  EXPECT_EQ(with("", "", ""), "");
  EXPECT_EQ(with("", "", R"("ofset": [1, 2, 3], )"), "c.json: model.accel.ofset: is unknown; did you mean offset?");
  EXPECT_EQ(with("", "", R"("g_sensitivity": [[0, 0, 0], [0, 0, 0], [0, 0, 0]], )"),
            "c.json: model.accel.g_sensitivity: is unknown; expected one of offset, matrix, quadratic, cubic, thermal, matrix_thermal1, "
            "matrix_thermal2, lever_arm, raw, temperature");
  EXPECT_EQ(with("", R"("rate": {}, )", ""), "c.json: model.rate: is unknown; expected one of accel, gyro");
  EXPECT_EQ(with(R"("Frame": "accelerometers", )", "", ""), "c.json: Frame: is unknown; did you mean frame?");
  EXPECT_EQ(with(R"("covarience": {}, )", "", ""), "c.json: covarience: is unknown; did you mean covariance?");
  EXPECT_EQ(with(R"("comment": "by hand", "name": "an IMU", "rig": {}, "": 0, )", "", ""), "");
}

/// What is rounding of the constant part is a matter of the whole: a coefficient without any may have some.
TEST(CalibrationFile, RoundingOfTheConstantPartIsNoDamage) {
  Calibration c = any_calibration();
  c.constant_covariance.row(0).setZero(), c.constant_covariance.col(0).setZero();
  c.constant_covariance(0, 1) = 1e-13 * std::sqrt(c.covariance(0, 0) * c.covariance(1, 1));
  EXPECT_EQ(parse_calibration(calibration_text(c), "calibration.json").constant_covariance, c.constant_covariance);
  EXPECT_NO_THROW(validate(c));
}

TEST(CalibrationFile, ACovarianceItsVariancesDoNotAllowIsRefused) {
  Json json = Json::parse(calibration_text(any_calibration()));
  const double largest = std::sqrt(json["covariance"]["matrix"][0][0].get<double>() * json["covariance"]["matrix"][1][1].get<double>());
  json["covariance"]["matrix"][0][1] = json["covariance"]["matrix"][1][0] = 1.01 * largest;
  try {
    parse_calibration(json.dump(), "calibration.json");
    ADD_FAILURE() << "accepted";
  } catch (const Error& e) {
    EXPECT_THAT(e.what(), HasSubstr("a covariance that its two variances allow"));
  }
}

}  // namespace
}  // namespace imulab
