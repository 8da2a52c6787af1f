#include "imulab/model/conclusion.hpp"

#include "imulab/calibration.hpp"

#include <gtest/gtest.h>

#include <limits>

namespace imulab {
namespace {

const RequirementResult reached_cep{"CEP <= 1 nmi/h", "CEP", 0.5, 0.4, true}, missed_rms{"RMS <= 100 m at 60 s", "RMS", 100, 150, false};

TEST(Conclusion, IsAboutWhatWasRequired) {
  EXPECT_EQ(conclude(Verdict::good, "all is well", {}).verdict, Verdict::good);
  EXPECT_EQ(conclude(Verdict::good, "all is well", {}).headline, "all is well");
  const Conclusion met = conclude(Verdict::good, "all is well", {reached_cep});
  EXPECT_EQ(conclusion_text(met), "met: CEP 0.8 nmi/h; required: CEP <= 1 nmi/h");
  EXPECT_EQ(missed_requirements(met), "");
  const Conclusion missed = conclude(Verdict::none, "all is well", {reached_cep, missed_rms});
  EXPECT_EQ(conclusion_text(missed), "not met: RMS 150 m; required: RMS <= 100 m at 60 s");
  EXPECT_EQ(missed_requirements(missed), "not met: RMS <= 100 m at 60 s");
}

TEST(Conclusion, ADoubtfulResultMeetsNothing) {
  const Conclusion doubtful = conclude(Verdict::doubtful, "the residuals are too large", {reached_cep});
  EXPECT_EQ(conclusion_text(doubtful), "doubtful: the residuals are too large");
  EXPECT_EQ(missed_requirements(doubtful), "a doubtful result meets no requirement: CEP <= 1 nmi/h");
  EXPECT_FALSE(is_favorable(doubtful.verdict));
  EXPECT_FALSE(is_favorable(Verdict::not_met));
  EXPECT_TRUE(is_favorable(Verdict::met) && is_favorable(Verdict::good));
}

TEST(Conclusion, OfSeveralTheOneWithTheLeastToSpare) {
  RequirementResult easy = missed_rms;
  easy.reached = 1, easy.met = true;
  EXPECT_EQ(conclude(Verdict::none, "", {easy, reached_cep}).headline, "CEP 0.8 nmi/h; required: CEP <= 1 nmi/h; 1 more met");
}

TEST(Conclusion, SaysWhatWasReachedInTheUnitOfTheText) {
  RequirementResult open = reached_cep;
  open.reached = std::numeric_limits<double>::infinity();
  EXPECT_EQ(reached_text(open), "not determined");
  EXPECT_EQ(reached_text({"no limit at all", "CEP", 1, 2, false}), "2") << "a saved file may hold any text";
}

}  // namespace
}  // namespace imulab
