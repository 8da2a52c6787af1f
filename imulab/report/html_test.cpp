#include "imulab/report/html.hpp"

#include "imulab/report/aided_page.hpp"
#include "imulab/report/navigation_page.hpp"
#include "imulab/report/page.hpp"
#include "imulab/report/plot.hpp"
#include "imulab/report/start.hpp"
#include "imulab/report/track.hpp"

#include <gmock/gmock.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <regex>
#include <string>
#include <vector>

namespace imulab::report {
namespace {

using ::testing::ElementsAre;

TEST(Html, MarkupIsText) { EXPECT_EQ(escaped("<b a=\"1\" c='2'>&</b>"), "&lt;b a=&quot;1&quot; c=&#39;2&#39;&gt;&amp;&lt;/b&gt;"); }

TEST(Html, WhatIsNotSeenIsNamed) {
  EXPECT_EQ(escaped(std::string("a\0b", 3)), "a[U+0000]b");
  EXPECT_EQ(escaped("\x07\x1b\x7f"), "[U+0007][U+001B][U+007F]");
  EXPECT_EQ(escaped("\u202e\u200f\u2066\ufeff\u200b"), "[U+202E][U+200F][U+2066][U+FEFF][U+200B]");
  EXPECT_EQ(escaped("one\ntwo\tµ°Ω"), "one\ntwo\tµ°Ω");
}

TEST(Html, BytesThatAreNotUtf8AreReplaced) {
  const std::string replacement = "\xEF\xBF\xBD";
  EXPECT_EQ(escaped("a\xffz"), "a" + replacement + "z");
  EXPECT_EQ(escaped("\xC3"), replacement);                                      // cut off
  EXPECT_EQ(escaped("\xC0\xBC"), replacement + replacement);                    // "<" in too many bytes
  EXPECT_EQ(escaped("\xED\xA0\x80"), replacement + replacement + replacement);  // a surrogate
  EXPECT_EQ(escaped("\xF0\x9F\x98\x80"), "\xF0\x9F\x98\x80");
}

TEST(Html, ALongTextIsShortenedByCharacters) {
  EXPECT_EQ(shortened("µµµ", 3), "µµµ");
  EXPECT_EQ(shortened("µµµµ", 3), "µµµ… (4 characters)");
}

TEST(Html, NumbersHaveTheDigitsOfTheirUncertainty) {
  EXPECT_EQ(rounded_to(34303.4, 32), "34303");
  EXPECT_EQ(rounded_to(-0.0157123, 0.0055), "−0.0157");
  EXPECT_EQ(rounded_to(12857, 160), "12860");
  EXPECT_EQ(rounded_to(-0.001, 1.0), "0.0") << "no minus zero";
  EXPECT_EQ(uncertainty_text(1.449), "1.4");
  EXPECT_EQ(uncertainty_text(std::numeric_limits<double>::infinity()), "not determined");
  EXPECT_EQ(number_text(2154.3), "2150");
  EXPECT_EQ(number_text(NAN), "not determined");
}

TEST(Html, TicksAreReadable) {
  EXPECT_EQ(tick_text(-0.25), "−0.25");
  EXPECT_EQ(tick_text(1e-6), "10⁻⁶");
  EXPECT_EQ(tick_text(-2.5e7), "−2.5·10⁷");
  EXPECT_FALSE(are_raised({0, 0.001, 10000}));
  EXPECT_TRUE(are_raised({0, 10000, 1e6}));
  EXPECT_EQ(tick_text(10000, true), "10⁴") << "all of an axis in one form";
  EXPECT_EQ(tick_text(0, true), "0");
}

TEST(Page, ConstantsHaveTheDigitsOfTheirUncertainty) {
  const double unit = quantity_of_constant("gyro.offset.x").unit.size;
  AidedNavigation n;
  n.constants = {{"gyro.offset.x", 1.23456 * unit, 0.1 * unit, 5 * unit}};
  EXPECT_THAT(aided_page("drive", n, {}, {}), testing::HasSubstr("<td>1.23</td><td>0.10</td><td>5.0</td>"));
}

TEST(Plot, TicksAreRound) {
  EXPECT_THAT(ticks({"", -0.4, 1.1}, 5), ElementsAre(0, 0.5, 1));
  EXPECT_THAT(ticks({"", -6, 6}, 5), ElementsAre(-5, -2.5, 0, 2.5, 5));
  EXPECT_THAT(ticks({"", 0.5, 200, true}, 5), ElementsAre(1, 10, 100));
}

TEST(Plot, TwoTicksAtLeastAreNotZero) {
  for (const Axis& axis : {Axis{"", 0.1, 1.9}, {"", -0.4, 0.9}, {"", 0, 1}, {"", 99, 101}, {"", 2, 9, true}})
    for (const int count : {1, 3, 5}) {
      const std::vector<double> all = ticks(axis, count);
      EXPECT_GE(std::count_if(all.begin(), all.end(), [](double v) { return v != 0; }), 2) << axis.low << " to " << axis.high << ", " << count;
    }
}

TEST(Plot, NamesAtTheEndsOfCurvesDoNotCollide) {
  Plot plot({"x", 0, 1}, {"y", 0, 1}, "test", {960, 250, 180});
  for (const char* name : {"one", "two", "three"}) plot.name_at_end(0, name, color::blue);
  const std::string svg = plot.svg();
  std::vector<double> heights;
  const std::regex on("<text x=\"[0-9.]+\" y=\"([0-9.]+)\" text-anchor=\"start\" class=\"on\"");
  for (std::sregex_iterator at(svg.begin(), svg.end(), on), end; at != end; ++at) heights.push_back(std::stod((*at)[1]));
  ASSERT_EQ(heights.size(), 3u);
  EXPECT_GE(heights[1] - heights[0], 16);
  EXPECT_GE(heights[2] - heights[1], 16);
  EXPECT_LT(heights[2], 215) << "above the axis";
}

TEST(Page, ALongPageHasContentsAndNoIdentifierTwice) {  // ctest: once
  Page page{.kind = "k", .title = "t", .subtitle = "", .verdict = {}, .figures = {}, .body = {}};
  for (const char* heading : {"A", "B", "C", "D"}) page.body += section("part", heading, "lead", "");
  EXPECT_EQ(page_text(page).find("<nav"), std::string::npos) << "four parts are seen without";
  page.body += section("part", "<b>", "lead", "");
  const std::string text = page_text(page);
  EXPECT_THAT(text, testing::HasSubstr("<a href=\"#part\">A</a> <a href=\"#part-2\">B</a>"));
  EXPECT_THAT(text, testing::HasSubstr("<a href=\"#part-5\">&lt;b&gt;</a>"));
  EXPECT_THAT(text, testing::HasSubstr("<section id=\"part-5\">"));
}

TEST(Page, ARoughBudgetIsHeadedByItsMonteCarlo) {  // ctest: once
  BudgetReport report{.mission = "m", .summary = {.budget = {}, .monte_carlo = ErrorDistribution{}, .runs = 50}};
  ErrorBudget& b = report.summary.budget;
  b.time = {0, 60};
  b.mean.setZero(budget_quantities, 2);
  BudgetMatrix square = BudgetMatrix::Zero();
  square(0, 0) = 1e12, square(6, 6) = 0.04;  // 1000 km, 0.2 rad
  b.covariance = {BudgetMatrix::Zero(), square};
  ErrorDistribution& d = *report.summary.monte_carlo;
  d.time = b.time;
  for (auto* rows : {&d.mean, &d.sigma, &d.low, &d.median, &d.high}) rows->setConstant(budget_quantities + 1, 2, 3e4);
  const std::string page = budget_page(report);
  EXPECT_THAT(page, testing::HasSubstr("<strong id=\"verdict\">42.4 km after 1 min</strong>"));
  EXPECT_THAT(page, testing::HasSubstr("the linear figures are rough"));
  EXPECT_THAT(page, testing::HasSubstr("horizontal error [km]"));
  EXPECT_EQ(page.find("1000 km"), std::string::npos);
}

TEST(Page, TimesAreShortAndStartsAreDates) {  // ctest: once
  EXPECT_EQ(seconds_text(12.5), "12.5 s");
  EXPECT_EQ(seconds_text(7080), "7080 s (118 min)");
  EXPECT_EQ(stamp_and_date(1794000000.123457), "2026-11-06T21:20:00.123Z");
  EXPECT_EQ(stamp_and_date(12.5), "12.5 s");
  EXPECT_EQ(length_text(9876), "9880 m");
  EXPECT_EQ(length_text(1.05e6), "1050 km");
}

TEST(Plot, AnAxisHoldsWhatIsFinite) {
  const Axis axis = axis_over("", {NAN, 1, 3, INFINITY});
  EXPECT_LT(axis.low, 1);
  EXPECT_GT(axis.high, 3);
  EXPECT_LT(axis.high, 4);
  const Axis none = axis_over("", {});
  EXPECT_LT(none.low, none.high);
  const Axis flat = axis_over("", {0, 0});
  EXPECT_LT(flat.low, flat.high);
}

TEST(Plot, HolesAndPointsOffTheAxisAreLeftOut) {
  Plot plot({"x", 0, 4}, {"y", 0.1, 10, true}, "test");
  plot.line({0, 1, 2, 3}, {1, NAN, 2, 3}, color::blue);
  plot.dots({1, 2}, {0, 1}, color::blue);  // zero is nowhere on a logarithmic axis
  const std::string svg = plot.svg();
  EXPECT_EQ(svg.find("nan"), std::string::npos);
  EXPECT_EQ(svg.find("inf"), std::string::npos);
}

}  // namespace
}  // namespace imulab::report
