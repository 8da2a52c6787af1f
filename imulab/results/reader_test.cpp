#include "imulab/error.hpp"
#include "imulab/estimate/hybrid/path_design.hpp"
#include "imulab/navigate.hpp"
#include "imulab/results/budget.hpp"
#include "imulab/results/comparison.hpp"
#include "imulab/results/compensation.hpp"
#include "imulab/results/navigation.hpp"
#include "imulab/results/prediction.hpp"
#include "imulab/results/summary.hpp"
#include "imulab/units.hpp"

#include <gmock/gmock.h>

#include <algorithm>
#include <cmath>

namespace imulab {
namespace {

using ::testing::HasSubstr;

Calibration calibration_with(double offset) {
  Calibration c;
  c.method = "static";
  c.estimated = select_coefficients("accel.offset");
  c.covariance = 1e-8 * Eigen::Matrix3d::Identity();
  c.model.accel.offset = {offset, 0, 0};
  return c;
}

TEST(SavedResult, AComparisonComesBack) {
  const std::vector<NamedCalibration> inputs{{"a.json", calibration_with(0)}, {"b.json", calibration_with(1e-3)}};
  ComparisonSummary summary{.names = {"a.json", "b.json"},
                            .comparisons = compare(inputs[0].calibration, std::vector<Calibration>{inputs[1].calibration})};
  for (const NamedCalibration& input : inputs) summary.calibrations.push_back(compared_calibration(input));
  summary.requirements.push_back(assess(summary, parse_requirements("accel.offset <= 50 ug").front()));
  const std::string text = comparison_json(summary);
  const auto back = std::get<ComparisonSummary>(parse_result(text, "c.json"));
  EXPECT_THAT(back.names, testing::ElementsAre("a.json", "b.json"));
  EXPECT_EQ(comparison_json(back), text);
  EXPECT_EQ(conclusion_about(back).verdict, Verdict::not_met);
}

TEST(SavedResult, APredictionComesBack) {
  Prediction p;
  p.coefficients = select_coefficients("gyro.offset");
  p.undetermined = select_coefficients("accel.offset.x");
  p.sigma = p.cramer_rao = p.second_order = p.bias = Eigen::Vector3d(1, 2, 3);
  p.sources = {"angle", "gyro noise"};
  p.variance = Eigen::MatrixXd::Constant(3, 2, 4);
  const auto back = std::get<PredictionSummary>(parse_result(prediction_json(summary_of(p)), "p.json"));
  EXPECT_EQ(back.indices(), p.coefficients);
  EXPECT_EQ(back.undetermined, p.undetermined);
  EXPECT_EQ(back.sigma(), p.sigma);
  EXPECT_EQ(back.coefficients[2].budget, (std::vector<std::pair<std::string, double>>{{"angle", 2}, {"gyro noise", 2}}));
  EXPECT_FALSE(back.coefficients[0].monte_carlo);
}

TEST(SavedResult, APlanComesBack) {
  const std::vector<Requirement> requirements = parse_requirements("gyro.offset <= 0.01 deg/h, accel.matrix.diagonal <= 10 ppm");
  const TurnPath path{.first_rest = 60, .turns = {{RigAxis::middle, -90, 30}, {RigAxis::inner, 180, 12}}, .duration = 123};
  Prediction p;
  p.coefficients = select_coefficients("gyro.offset");
  p.sigma = p.cramer_rao = Eigen::Vector3d(1e-8, 2e-8, 3e-8);
  const std::string text = plan_json({requirements, path, summary_of(p)});
  const auto back = std::get<PlanSummary>(parse_result(text, "plan.json"));
  ASSERT_EQ(back.requirements.size(), 2u);
  EXPECT_EQ(to_string(back.requirements[0]), to_string(requirements[0]));
  EXPECT_EQ(back.path.first_rest, 60);
  EXPECT_EQ(back.path.duration, 123);
  ASSERT_EQ(back.path.turns.size(), 2u);
  EXPECT_EQ(back.path.turns[0].axis, RigAxis::middle);
  EXPECT_EQ(back.path.turns[0].angle_deg, -90);
  EXPECT_EQ(back.path.turns[1].rest, 12);
  EXPECT_EQ(back.prediction.sigma(), p.sigma);
}

/// A budget of `times` outputs whose errors grow.
ErrorBudget growing_budget(Eigen::Index times) {
  ErrorBudget b;
  b.vertical = VerticalChannel::fixed;
  const auto rows = [&](double size) {
    BudgetRows out(budget_quantities, times);
    for (Eigen::Index q = 0; q < budget_quantities; ++q)
      for (Eigen::Index i = 0; i < times; ++i) out(q, i) = size * static_cast<double>((q + 1) * (i + 1));
    return out;
  };
  b.mean = rows(3);
  b.groups = {{"gyro bias", rows(1), rows(2)}, {"start", rows(2), rows(1)}};
  for (Eigen::Index i = 0; i < times; ++i) {
    b.time.push_back(10.0 * static_cast<double>(i));
    b.covariance.emplace_back((rows(2).col(i).array().square() + rows(1).col(i).array().square()).matrix().asDiagonal());
  }
  return b;
}

/// The end is exact; over time six digits are kept, at most about 200 times.
TEST(SavedResult, ABudgetComesBack) {
  for (const Eigen::Index times : {1, 2, 200, 1001}) {
    const ErrorBudget b = growing_budget(times);
    std::vector<NavigationState> track(static_cast<std::size_t>(times));
    for (std::size_t i = 0; i < track.size(); ++i) track[i].latitude = 1e-5 * static_cast<double>(i), track[i].height = static_cast<double>(i);
    const auto back = std::get<BudgetSummary>(parse_result(budget_json(b, {}, track), "b.json"));
    ASSERT_LE(back.budget.time.size(), 202u);
    ASSERT_GE(back.budget.time.size(), static_cast<std::size_t>(std::min<Eigen::Index>(times, 150)));
    EXPECT_EQ(back.budget.time.back(), b.time.back());
    EXPECT_EQ(back.budget.vertical, VerticalChannel::fixed);
    EXPECT_TRUE(back.budget.mean.rightCols(1).isApprox(b.mean.rightCols(1), 1e-14));
    for (std::size_t i = 0; i < back.budget.time.size(); ++i) {
      const auto own = static_cast<std::size_t>(std::find(b.time.begin(), b.time.end(), back.budget.time[i]) - b.time.begin());
      ASSERT_LT(own, b.time.size());
      const auto shares = back.budget.horizontal_shares(i), expected = b.horizontal_shares(own);
      for (std::size_t k = 0; k < shares.size(); ++k) EXPECT_NEAR(shares[k], expected[k], 1e-5) << times << " " << i;  // six digits
      for (Eigen::Index q = 0; q < budget_quantities; ++q) {
        const double at = b.mean(q, static_cast<Eigen::Index>(own)), variance = b.covariance[own](q, q);
        EXPECT_NEAR(back.budget.mean(q, static_cast<Eigen::Index>(i)), at, 1e-5 * std::abs(at));
        EXPECT_NEAR(back.budget.covariance[i](q, q), variance, 1e-5 * variance);
      }
    }
    EXPECT_EQ(back.track.size(), times < 2 ? 0 : times == 1001 ? 501 : static_cast<std::size_t>(times));
  }
}

TEST(SavedResult, AHistoryOfUnevenLengthsIsAnError) {
  std::string text = budget_json(growing_budget(20), {});
  const std::size_t at = text.find("\"time_s\": [") + 11;
  text.erase(at, text.find(',', at) + 1 - at);
  EXPECT_THROW(parse_result(text, "b.json"), Error);
}

TEST(SavedResult, NavigationComesBack) {
  NavigatedSession s{.session = "drive", .navigated = {}, .errors = NavigationErrors{}};
  for (int i = 0; i <= 3000; ++i) {
    NavigationState state;
    state.latitude = 0.8 + 1e-6 * i, state.longitude = -3 + 2e-6 * i, state.height = 400;
    const double time = 1.7e9 + 0.5 * i;  // a clock from 1970
    s.navigated.solution.time.push_back(time);
    s.navigated.track.push_back(state);
    s.errors->history.push_back({time, {1e-3 * i, -2e-3 * i, 0.5}, {1e-4, 2e-4, 3e-4}, {1e-6, 2e-6, 3e-6 * i}});
  }
  s.errors->rate = 2;
  s.navigated.aligned.emplace();
  s.navigated.aligned->begin = 1, s.navigated.aligned->end = 100;
  s.navigated.aligned->alignment.attitude.C_nb = attitude_matrix({0.1, -0.2, 2.5});
  s.navigated.aligned->alignment.attitude.covariance = 1e-8 * Eigen::Matrix3d::Identity();
  s.explained = growing_budget(30);
  const NavigationSummary all = std::get<NavigationSummary>(parse_result(navigation_json({s}), "n.json"));
  ASSERT_EQ(all.size(), 1u);
  const NavigatedSession& back = all.front();
  ASSERT_TRUE(back.errors && back.explained && back.navigated.aligned);
  EXPECT_EQ(back.explained->time.size(), 30u);
  EXPECT_EQ(back.navigated.solution.time, (std::vector<double>{1.7e9, 1.7e9 + 1500}));
  EXPECT_GT(back.navigated.track.size(), 400u);
  EXPECT_LT(back.navigated.track.size(), 1000u);
  EXPECT_NEAR(back.navigated.track.back().longitude, s.navigated.track.back().longitude, 1e-9);  // ten digits of degrees
  EXPECT_GT(back.errors->history.size(), 300u);
  EXPECT_EQ(back.errors->history.back().time, 1.7e9 + 1500);
  EXPECT_EQ(back.errors->history.back().position, s.errors->history.back().position);
  EXPECT_NEAR(back.errors->history[11].position.x(), 1e-3 * (back.errors->history[11].time - 1.7e9) / 0.5, 1e-6);
  EXPECT_TRUE(back.navigated.aligned->alignment.attitude.C_nb.isApprox(s.navigated.aligned->alignment.attitude.C_nb, 1e-12));
}

TEST(SavedResult, CompensatedRecordingsComeBack) {
  CompensatedFile f{.file = "out.csv", .samples = 3000, .saturated = 2, .out_of_range = 1, .recording = "log.csv", .rate_hz = 100, .gaps = 4};
  f.overview.emplace();
  f.overview->samples_per_interval = 10;
  f.overview->first_s = 1.7e9 - 0.125;
  for (int i = 0; i < 40; ++i) {
    f.overview->time.push_back(1.7e9 + 0.25 * i);  // a clock from 1970
    for (std::size_t k = 0; k < 3; ++k) f.overview->rate[k].push_back(0.01 * i), f.overview->force[k].push_back(9.8125);
  }
  CompensationSummary summary{.calibration_file = "c.json", .imu = "unit", .quality = {}, .files = {f}};
  summary.quality.verdict = Verdict::doubtful;
  summary.quality.findings.append(Severity::doubt, {"why"});
  const auto back = std::get<CompensationSummary>(parse_result(compensation_json(summary), "c.json"));
  EXPECT_EQ(back.quality.findings.reasons(), summary.quality.findings.reasons());
  ASSERT_EQ(back.files.size(), 1u);
  EXPECT_EQ(back.files[0].gaps, 4u);
  ASSERT_TRUE(back.files[0].overview);
  EXPECT_EQ(back.files[0].overview->time, f.overview->time);
  EXPECT_EQ(back.files[0].overview->first_s, f.overview->first_s);
  EXPECT_EQ(back.files[0].overview->force[2], f.overview->force[2]);
  EXPECT_NEAR(back.files[0].overview->rate[1].back(), 0.39, 1e-6);
  EXPECT_EQ(compensation_json(back), compensation_json(summary));
}

TEST(SavedResult, WhatIsNoResultIsNamed) {
  const auto error = [](const std::string& text) -> std::string {
    try {
      parse_result(text, "x.json");
    } catch (const Error& e) {
      return e.what();
    }
    return "accepted";
  };
  EXPECT_THAT(error(""), HasSubstr("x.json: is empty; expected calibration.json"));
  EXPECT_THAT(error("{\n\"a\": }"), HasSubstr("x.json:2: not JSON"));
  EXPECT_THAT(error("[]"), HasSubstr("x.json: not a result; expected calibration.json, noise.json, extrinsics.json, or what compare"));
  EXPECT_THAT(error("{\"format\": \"imulab.session/1\"}"), HasSubstr("x.json: format: expected \"imulab.calibration/1\""));
  EXPECT_THAT(error("{\"format\": \"imulab.prediction/1\", \"coefficients\": {\"gyro.offset.w\": {}}, \"undetermined\": []}"),
              HasSubstr("x.json: coefficients: unknown coefficient \"gyro.offset.w\""));
  EXPECT_THAT(error("{\"format\": \"imulab.prediction/1\", \"coefficients\": {\"gyro.offset.x\": {\"closed_form\": \"1\"}}, \"undetermined\": []}"),
              HasSubstr("x.json: coefficients.gyro.offset.x.closed_form: expected a number"));
  EXPECT_THAT(error("{\"format\": \"imulab.prediction/1\", \"coefficients\": 3, \"undetermined\": []}"),
              HasSubstr("x.json: coefficients: expected an object"));
  EXPECT_THAT(error("{\"format\": \"imulab.comparison/1\", \"comparisons\": []}"), HasSubstr("x.json: comparisons: is empty"));
  EXPECT_THAT(error("{\"format\": \"imulab.navigation/1\", \"sessions\": []}"), HasSubstr("x.json: sessions: is empty"));
  EXPECT_THAT(error("{\"format\": \"imulab.navigation/1\", \"position_error\": null, \"session\": \"s\", \"time_s\": [0], \"vertical\": \"free\"}"),
              HasSubstr("x.json: time_s: expected 2 numbers"));
  EXPECT_THAT(error("{\"format\": \"imulab.budget/1\", \"total\": {}, \"sources\": {}, \"time_s\": 1, \"vertical\": \"free\"}"),
              HasSubstr("x.json: total.position_m: is missing"));
  const std::string sheet = R"({"format": "imulab.noise/1", "source": "data sheet", "interval_s": 0, )";
  EXPECT_THAT(error(sheet + R"("axes": [{"name": "gyro.x", "unit": "rad/s"}]})"),
              HasSubstr("x.json: axes: expected coefficients of every axis of a data sheet"));
  EXPECT_THAT(error(sheet + R"("axes": [], "data_sheet": [{"name": "", "sheet": 1, "value": 1, "lower": 0, "upper": 2}]})"),
              HasSubstr("x.json: data_sheet[0].name: expected an axis and a term, as in gyro.x.N"));
  EXPECT_THAT(error(std::string(200'000, '[')), HasSubstr("x.json: nested too deeply"));
}

}  // namespace
}  // namespace imulab
