#include "imulab/results/conclusion.hpp"

#include "imulab/error.hpp"
#include "imulab/results/aided.hpp"
#include "imulab/results/summary.hpp"

#include <gmock/gmock.h>
#include <nlohmann/json.hpp>

#include <cmath>
#include <tuple>

namespace imulab {
namespace {

using OrderedJson = nlohmann::ordered_json;

const Conclusion a_conclusion{Verdict::not_met, "CEP is 2 m \"or so\"", {{"CEP <= 1 m", "CEP", 1, 2, false, "by a test"}}};

std::vector<std::string> keys_of(const std::string& text) {
  std::vector<std::string> keys;
  const OrderedJson json = OrderedJson::parse(text);
  for (const auto& [key, value] : json.items()) keys.push_back(key);
  return keys;
}

TEST(ConclusionJson, StandsAtTheBegin) {
  for (const char* text : {"{\n  \"a\": 1,\n  \"b\": {}\n}\n", "{\"a\":1,\"b\":{}}\n"}) {
    const std::string whole = with_conclusion(text, a_conclusion, {"one", "two"});
    EXPECT_THAT(keys_of(whole), testing::ElementsAre("verdict", "headline", "warnings", "requirements", "a", "b"));
    EXPECT_EQ(OrderedJson::parse(whole)["headline"], a_conclusion.headline);
    EXPECT_EQ(OrderedJson::parse(whole)["warnings"][1], "two");
    EXPECT_EQ(std::count(whole.begin(), whole.end(), '\n') == 1, std::string_view(text)[1] != '\n') << "one line stays one line";
  }
}

TEST(ConclusionJson, OrAtTheEndOfAFile) {
  const std::string whole =
      with_conclusion("{\n  \"quality\": {\n    \"x\": {}\n  }\n}\n", {Verdict::none, "nothing was judged"}, {}, ConclusionPlace::end);
  EXPECT_THAT(keys_of(whole), testing::ElementsAre("quality", "verdict", "headline", "warnings"));
  EXPECT_TRUE(OrderedJson::parse(whole)["verdict"].is_null());
}

TEST(ConclusionJson, ListsStayListsAndNothingIsStillAnObject) {
  EXPECT_EQ(with_conclusion("[1, 2]\n", a_conclusion, {}), "[1, 2]\n");
  for (const ConclusionPlace place : {ConclusionPlace::begin, ConclusionPlace::end})
    EXPECT_THAT(keys_of(with_conclusion("{}\n", {Verdict::good, "x"}, {}, place)), testing::ElementsAre("verdict", "headline", "warnings"));
}

TEST(ConclusionJson, ComesBackWithItsResult) {
  const std::string text = R"({"format": "imulab.prediction/1", "coefficients": {}, "undetermined": []})";
  const Conclusion back = parse_answer(with_conclusion(text, a_conclusion, {}), "p.json").conclusion;
  EXPECT_EQ(back.verdict, Verdict::not_met);
  EXPECT_EQ(back.headline, a_conclusion.headline);
  EXPECT_EQ(back.requirements, a_conclusion.requirements);
  EXPECT_EQ(parse_answer(text, "p.json").conclusion.verdict, Verdict::none) << "of an earlier version";
  EXPECT_THROW(parse_answer(R"({"verdict": "perfect", "format": "imulab.prediction/1", "coefficients": {}, "undetermined": []})", "p.json"), Error);
}

TEST(OutageSummary, IsTheRmsTheMedianAndTheLargest) {
  std::vector<OutageResult> outages(3);
  for (const auto& [k, horizontal, ratio] : {std::tuple{0u, 5.0, 2.0}, {1u, 70.0, 1.0}, {2u, 6.0, 2.0}})
    outages[k].predicted.horizontal = horizontal, outages[k].predicted.ratio = ratio;
  const OutageSummary s = outage_summary(outages, &OutageResult::predicted);
  EXPECT_DOUBLE_EQ(s.ratio, std::sqrt(3.0));
  EXPECT_EQ(s.median, 6);
  EXPECT_EQ(s.worst, 70);
  EXPECT_EQ(outage_summary(outages, &OutageResult::smoothed).ratio, 0);
}

}  // namespace
}  // namespace imulab
