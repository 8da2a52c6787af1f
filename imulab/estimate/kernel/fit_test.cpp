#include "imulab/estimate/kernel/fit.hpp"

#include <gmock/gmock.h>

namespace imulab::kernel {
namespace {

using ::testing::ElementsAre;
using ::testing::IsEmpty;

/// Values about zero with unit noise; the log probability is -x^2 / 2.
struct Values {
  std::vector<double> values;
  std::size_t most = 2;
  std::vector<Suspect> suspects() const {
    std::vector<Suspect> all;
    for (const double v : values) all.push_back({std::to_string(static_cast<int>(v)), -v * v / 2});
    return all;
  }
  bool may_drop(std::size_t) const { return most > 0; }
  Values without(std::size_t i) const {
    Values other = *this;
    other.values.erase(other.values.begin() + static_cast<std::ptrdiff_t>(i));
    --other.most;
    return other;
  }
};

TEST(DropSuspects, TheLeastProbableGoFirstUntilChanceExplainsTheRest) {
  const auto cleaned = drop_suspects(Values{{1, 9, -1, 12, 2}}, 1e-3);
  EXPECT_THAT(cleaned.dropped, ElementsAre("12", "9"));
  EXPECT_THAT(cleaned.fit.values, ElementsAre(1, -1, 2));
  EXPECT_EQ(cleaned.worst, "12");
  EXPECT_TRUE(cleaned.clean);
}

TEST(DropSuspects, SaysWhereMoreAreBadThanMayGo) {
  const auto cleaned = drop_suspects(Values{{10, 9, 11, 12, 2}}, 1e-3);
  EXPECT_THAT(cleaned.dropped, ElementsAre("12", "11"));
  EXPECT_FALSE(cleaned.clean);
}

TEST(DropSuspects, TheLevelIsSharedAmongAll) {
  // exp(-x^2 / 2) is 1e-3 at x = 3.717; for one of a hundred suspects, 1e-5 at 4.799.
  EXPECT_THAT(drop_suspects(Values{{4}}, 1e-3).dropped, ElementsAre("4"));
  std::vector<double> many(100, 0.0);
  many[7] = 4;
  EXPECT_THAT(drop_suspects(Values{many}, 1e-3).dropped, IsEmpty());
  EXPECT_THAT(drop_suspects(Values{{}}, 1e-3).dropped, IsEmpty());
}

TEST(Improbable, TheLeastProbableComesFirst) {
  EXPECT_THAT(improbable({{"first", -100}, {"probable", -1}, {"least", -200}}, 1e-3), ElementsAre(2, 0));
}

TEST(Improbable, WhatIsNoNumberIsNotExplainedByChance) { EXPECT_THAT(improbable({{"good", -1}, {"nan", std::nan("")}}, 1e-3), ElementsAre(1)); }

}  // namespace
}  // namespace imulab::kernel
