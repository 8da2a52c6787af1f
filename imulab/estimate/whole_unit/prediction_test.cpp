// Predictions of the whole-unit method. tests/methods_test.cpp compares them with its calibrations.
#include "imulab/calibration.hpp"
#include "imulab/coefficient.hpp"
#include "imulab/error.hpp"
#include "imulab/estimate/whole_unit/whole_unit.hpp"
#include "imulab/predict.hpp"
#include "imulab/procedure.hpp"

#include <gmock/gmock.h>

namespace imulab::whole_unit {
namespace {

using ::testing::HasSubstr;
using ::testing::IsEmpty;

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

TEST(WholeUnitPrediction, OfATermThatIsLeftOutNothingIsMet) {
  const Prediction p = predict(dai_unit_procedure({}), {.terms = select_each({"accel.offset", "accel.matrix.diagonal"})});
  const std::vector<Shortfall> missed = shortfalls(p, parse_requirements("accel.offset.x <= 1 g, accel.matrix.xy <= 1 deg"));
  ASSERT_EQ(missed.size(), 1u) << "no frame makes it zero: the machines define the axes";
  EXPECT_EQ(missed.front().coefficient, coefficient_index("accel.matrix.xy"));
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
