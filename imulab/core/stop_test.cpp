#include "imulab/stop.hpp"

#include "imulab/core/parallel.hpp"
#include "imulab/error.hpp"

#include <gmock/gmock.h>

#include <algorithm>
#include <atomic>
#include <string>
#include <vector>

namespace imulab {
namespace {

TEST(Stop, OnlyWhereAScopeAsks) {
  EXPECT_NO_THROW(stop_point());
  std::stop_source inner, outer;
  const WorkScope around(outer.get_token());
  {
    const WorkScope scope(inner.get_token());
    EXPECT_NO_THROW(stop_point());
    inner.request_stop();
    EXPECT_THROW(stop_point(), Stopped);
  }
  EXPECT_NO_THROW(stop_point()) << "the scope has ended";
  outer.request_stop();
  const WorkScope another({});
  EXPECT_THROW(count_iteration(), Stopped) << "the tokens of all scopes count";
}

TEST(Stop, ReachesTheThreadsOfALoop) {
  std::stop_source source;
  const WorkScope scope(source.get_token());
  std::atomic<int> calls = 0;
  EXPECT_THROW(parallel_for(10'000,
                            [&](std::size_t) {
                              if (++calls == 3) source.request_stop();
                              parallel_for(1, [](std::size_t) {});  // a loop inside a call is in the scope, too
                            }),
               Stopped);
  EXPECT_LT(calls, 10'000);
}

TEST(Stop, IsNoErrorOfTheInput) {
  std::stop_source source;
  source.request_stop();
  const WorkScope scope(source.get_token());
  std::vector<std::string> problems;
  EXPECT_THROW(collect_problem(problems, [] { stop_point(); }), Stopped);
  EXPECT_THROW(errors_at("here", [] { stop_point(); }), Stopped);
  EXPECT_TRUE(problems.empty());
}

TEST(Stop, ProgressRisesAndNeverReachesOne) {
  std::vector<double> told;
  const WorkScope scope({}, [&](double part) { told.push_back(part); });
  const WorkScope without({});  // the innermost that has one is told
  parallel_for(100, [](std::size_t) { count_iteration(); });
  ASSERT_EQ(told.size(), 100u);
  EXPECT_TRUE(std::is_sorted(told.begin(), told.end()));
  EXPECT_GT(told.front(), 0);
  EXPECT_LT(told.back(), 1);
}

}  // namespace
}  // namespace imulab
