// The prediction of a whole-unit calibration: against what calibrate states of the same procedure, and against the scatter of its estimates.
#include "imulab/core/error.hpp"
#include "imulab/core/statistics.hpp"

#include <gmock/gmock.h>

#include "tests/whole_unit_session.hpp"
#include <algorithm>
#include <cmath>

namespace imulab::whole_unit {
namespace {

using ::testing::HasSubstr;
using ::testing::IsEmpty;

TEST(WholeUnitPrediction, IsWhatCalibrateStatesAndHowItsEstimatesScatter) {
  constexpr std::uint64_t sessions = 8;
  Prediction p;
  std::vector<double> stated, squares;
  for (std::uint64_t seed = 1; seed <= sessions; ++seed) {
    const WholeUnitSession s = whole_unit_session(seed);
    if (seed == 1) p = predict(s.session), squares.assign(p.coefficients.size(), 0);
    const Calibration c = calibrate(s.input(), full_whole_unit()).calibration;
    ASSERT_EQ(c.estimated, p.coefficients);
    for (std::size_t i = 0; i < p.coefficients.size(); ++i) {
      const double sigma = p.sigma[static_cast<Eigen::Index>(i)];
      stated.push_back(relative_uncertainty(c, p.coefficients[i]) / sigma);
      squares[i] += std::pow((coefficient_value(c.model, p.coefficients[i]) - coefficient_value(s.truth.model, p.coefficients[i])) / sigma, 2);
    }
  }
  // The drawn unit's scales are off by 1 %, and third orders go with their third power; the noise is measured in points of 50 samples.
  EXPECT_NEAR(median(stated), 1, 0.02);
  EXPECT_GT(*std::min_element(stated.begin(), stated.end()), 0.85);
  EXPECT_LT(*std::max_element(stated.begin(), stated.end()), 1.2);
  // Each sum is chi-square distributed with as many degrees of freedom as sessions: outside once in a thousand runs of all coefficients together.
  const double level = 0.5e-3 / static_cast<double>(squares.size());
  for (std::size_t i = 0; i < squares.size(); ++i) {
    EXPECT_LT(squares[i], chi_square_quantile(1 - level, sessions)) << coefficient(p.coefficients[i]).name;
    EXPECT_GT(squares[i], chi_square_quantile(level, sessions)) << coefficient(p.coefficients[i]).name;
  }
}

TEST(WholeUnitPrediction, WithoutTheCentrifugeTheCubicTermsStayOpen) {
  Session session = dai_unit_procedure({});
  EXPECT_THAT(predict(session).undetermined, IsEmpty());
  const std::string gone = session.recordings.back().file;
  session.recordings.pop_back();
  std::erase_if(session.steps, [&](const Step& step) { return step.recording == gone; });
  const Prediction p = predict(session);
  EXPECT_TRUE(contains(p.undetermined, coefficient_index("accel.cubic.x")));
  EXPECT_TRUE(contains(p.coefficients, coefficient_index("gyro.cubic.x")));
}

TEST(WholeUnitPrediction, SaysWhatAProcedureLacks) {
  const auto error_of = [](const Session& s) {
    try {
      predict(s);
    } catch (const Error& e) {
      return std::string(e.what());
    }
    return std::string("no error");
  };
  Session s = dai_unit_procedure({});
  s.site.latitude.reset();
  EXPECT_THAT(error_of(s), HasSubstr("no latitude"));
  s = dai_unit_procedure({});
  s.steps.clear();
  EXPECT_THAT(error_of(s), HasSubstr("no steps"));
  EXPECT_THAT(error_of(hand_held_procedure({}, 1)), HasSubstr("expected a rate table, centrifuge or chamber"));
}

}  // namespace
}  // namespace imulab::whole_unit
