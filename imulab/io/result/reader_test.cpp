#include "imulab/core/error.hpp"
#include "imulab/core/units.hpp"
#include "imulab/io/result/budget.hpp"
#include "imulab/io/result/comparison.hpp"
#include "imulab/io/result/prediction.hpp"
#include "imulab/io/result/summary.hpp"

#include <gmock/gmock.h>

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
  const std::vector<Comparison> comparisons = compare(inputs[0].calibration, std::vector<Calibration>{inputs[1].calibration});
  const std::string text = comparison_json(inputs, comparisons, {});
  const auto back = std::get<ComparisonSummary>(parse_result(text, "c.json"));
  EXPECT_THAT(back.names, testing::ElementsAre("a.json", "b.json"));
  EXPECT_EQ(comparison_json(inputs, back.comparisons, back.agreement), text);
}

TEST(SavedResult, APredictionComesBack) {
  turntable::Prediction p;
  p.coefficients = select_coefficients("gyro.offset");
  p.undetermined = select_coefficients("accel.offset.x");
  p.sigma = p.cramer_rao = p.second_order = p.bias = Eigen::Vector3d(1, 2, 3);
  p.sources = {"angle", "gyro noise"};
  p.variance = Eigen::MatrixXd::Constant(3, 2, 4);
  const auto back = std::get<PredictionSummary>(parse_result(prediction_json(p, {}, {}, {}), "p.json"));
  EXPECT_EQ(back.coefficients, p.coefficients);
  EXPECT_EQ(back.undetermined, p.undetermined);
  EXPECT_EQ(back.sigma, p.sigma);
  EXPECT_EQ(back.sources, p.sources);
  EXPECT_TRUE(back.variance.isApprox(p.variance));
  EXPECT_FALSE(back.monte_carlo);
}

TEST(SavedResult, ABudgetsEndComesBack) {
  ErrorBudget b;
  b.time = {0, 60};
  b.vertical = VerticalChannel::fixed;
  b.mean = BudgetRows::Constant(budget_quantities, 2, 1);
  b.covariance.assign(2, 4 * BudgetMatrix::Identity());
  b.groups = {{"gyro bias", BudgetRows::Constant(budget_quantities, 2, 1), BudgetRows::Constant(budget_quantities, 2, 2)}};
  const std::string text = budget_json(b, {});
  const auto back = std::get<BudgetSummary>(parse_result(text, "b.json"));
  EXPECT_EQ(back.budget.time, std::vector<double>{60});
  EXPECT_EQ(back.budget.vertical, VerticalChannel::fixed);
  EXPECT_NEAR(back.budget.mean(8, 0), 1, 1e-12);
  EXPECT_NEAR(back.budget.shares(0, 0).front(), 1, 1e-12);
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
  EXPECT_THAT(error("[]"), HasSubstr("x.json: not a result; expected calibration.json, or what compare"));
  EXPECT_THAT(error("{\"format\": \"imulab.session/1\"}"), HasSubstr("x.json: format: expected \"imulab.calibration/1\""));
  EXPECT_THAT(error("{\"coefficients\": {\"gyro.offset.w\": {}}, \"undetermined\": []}"),
              HasSubstr("x.json: coefficients: unknown coefficient \"gyro.offset.w\""));
  EXPECT_THAT(error("{\"coefficients\": {\"gyro.offset.x\": {\"closed_form\": \"1\"}}, \"undetermined\": []}"),
              HasSubstr("x.json: coefficients.gyro.offset.x.closed_form: expected a number"));
  EXPECT_THAT(error("{\"coefficients\": 3, \"undetermined\": []}"), HasSubstr("x.json: coefficients: expected an object"));
  EXPECT_THAT(error("{\"comparisons\": []}"), HasSubstr("x.json: comparisons: is empty"));
  EXPECT_THAT(error("{\"sessions\": []}"), HasSubstr("x.json: sessions: is empty"));
  EXPECT_THAT(error("{\"position_error\": null, \"session\": \"s\", \"time_s\": [0], \"vertical\": \"free\"}"),
              HasSubstr("x.json: time_s: expected 2 numbers"));
  EXPECT_THAT(error("{\"total\": {}, \"sources\": {}, \"time_s\": 1, \"vertical\": \"free\"}"), HasSubstr("x.json: total.position_m: is missing"));
  EXPECT_THAT(error(std::string(200'000, '[')), HasSubstr("x.json: nested too deeply"));
}

}  // namespace
}  // namespace imulab
