#include "imulab/core/statistics.hpp"
#include "imulab/recording/clock.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

namespace imulab {
namespace {

/// Every millisecond, with jitter of either sign, lost samples, and a pause.
std::vector<std::int64_t> stamps(std::size_t count) {
  std::vector<std::int64_t> time_ns;
  std::uint64_t state = 1;
  std::int64_t at = -5'000'000'000;
  for (std::size_t i = 0; i < count; ++i) {
    state = state * 6364136223846793005u + 1442695040888963407u;
    const auto jitter = static_cast<std::int64_t>(state >> 45);  // up to 0.52 ms
    at += 1'000'000 + (i % 1000 == 7 ? 1'000'000 : 0) + (i == count / 2 ? 70'000'000'000 : 0);
    time_ns.push_back(at + jitter);
  }
  return time_ns;
}

std::vector<std::int64_t> sorted_differences(const std::vector<std::int64_t>& time_ns, std::size_t apart) {
  std::vector<std::int64_t> differences;
  for (std::size_t i = apart; i < time_ns.size(); ++i) differences.push_back(time_ns[i] - time_ns[i - apart]);
  std::sort(differences.begin(), differences.end());
  return differences;
}

TEST(Stamps, RanksOfDifferencesAreThoseOfASortedCopy) {
  std::vector<std::int64_t> time_ns = stamps(3000);
  time_ns[100] = time_ns[99] - 3'000'000'000'000;  // negative, too, and large
  for (const std::size_t apart : {1, 16}) {
    const std::vector<std::int64_t> sorted = sorted_differences(time_ns, apart);
    for (std::size_t k = 0; k < sorted.size(); k += 97) EXPECT_EQ(difference_of_rank(time_ns, apart, k), sorted[k]) << apart << " " << k;
    EXPECT_EQ(difference_of_rank(time_ns, apart, sorted.size() - 1), sorted.back());
  }
}

// Above 2^23 stamps no copy is made.
TEST(Stamps, OfManyAreTakenAsOfFew) {  // ctest: once
  for (const std::size_t count : {(std::size_t{1} << 23) + 1, (std::size_t{1} << 23) + 2}) {
    const std::vector<std::int64_t> time_ns = stamps(count);
    const std::vector<std::int64_t> sorted = sorted_differences(time_ns, 1);
    const std::size_t middle = sorted.size() / 2;
    const double median_s = sorted.size() % 2 == 1 ? 1e-9 * static_cast<double>(sorted[middle])
                                                   : 0.5e-9 * (static_cast<double>(sorted[middle]) + static_cast<double>(sorted[middle - 1]));
    const StampIntervals intervals = stamp_intervals(time_ns);
    EXPECT_EQ(intervals.median, median_s);
    double sum = 0, used = 0;
    for (const std::int64_t difference : sorted)  // whole numbers: exact in any order
      if (static_cast<double>(difference) <= 1.5e9 * median_s) sum += static_cast<double>(difference), ++used;
    EXPECT_LT(used, static_cast<double>(sorted.size())) << "lost samples and the pause are left out";
    EXPECT_EQ(intervals.mean, 1e-9 * sum / used);
    const std::vector<std::int64_t> lengths = sorted_differences(time_ns, 16);
    EXPECT_EQ(clock_interval(time_ns, 1e-3), 1e-9 * median(std::vector<double>(lengths.begin(), lengths.end())) / 16);
  }
}

}  // namespace
}  // namespace imulab
