#include "imulab/formats/text/date.hpp"

#include <gtest/gtest.h>

#include <string>

namespace imulab::text {
namespace {

std::string seconds_of(std::string_view text, DateOrder order = DateOrder::unknown) {
  const Moment moment = moment_of(text, order);
  std::string out;
  if (moment) append_seconds(out, moment.seconds, moment.fraction);
  return out;
}

TEST(Moment, IsExact) {
  EXPECT_EQ(seconds_of("2025-07-08T19:34:18.499Z"), "1752003258.499");
  EXPECT_EQ(seconds_of("2025-07-08T21:34:18.499000001+02:00"), "1752003258.499000001");
  EXPECT_EQ(seconds_of("2025/07/08 19:34:18.499"), "1752003258.499");
  EXPECT_EQ(seconds_of("20250708T193418"), "");  // times without colons are not read
  EXPECT_EQ(seconds_of("08.07.2025 19:34"), "1752003240");
  EXPECT_EQ(seconds_of("08-Jul-2025 19:34:18"), "1752003258");
  EXPECT_EQ(seconds_of("7/8/2025 7:34:18 PM", DateOrder::month_first), "1752003258");
  EXPECT_EQ(seconds_of("13/04/2025 12:00:00"), "1744545600");
  EXPECT_EQ(seconds_of("19:34:18:499"), "70458.499");
  EXPECT_EQ(moment_of("13/04/2025 12:00:00").shows, DateOrder::day_first);
  EXPECT_TRUE(moment_of("03/04/2025 12:00:00").ordered);
  for (const char* text :
       {"", "12:34", "1.5", "2025-13-01 10:00:00", "2025-02-30", "24:00:00", "10:60:00", "1969-01-01", "2025-07-08x", "1:2:3", "99:00:00"})
    EXPECT_FALSE(moment_of(text)) << text;
}

}  // namespace
}  // namespace imulab::text
