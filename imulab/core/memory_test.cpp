#include "imulab/core/memory.hpp"

#include "imulab/core/error.hpp"

#include <gmock/gmock.h>

namespace imulab {
namespace {

TEST(MemoryLimit, RefusesWhatIsLargerWhileItLives) {
  const std::uint64_t machine = memory_limit();
  EXPECT_GT(machine, 1u << 26);
  {
    const MemoryLimit limit(4'000'000'000);
    EXPECT_NO_THROW(expect_memory(4e9, "a day"));
    try {
      expect_memory(6.8e9, "a day");
      FAIL();
    } catch (const MemoryError& e) {
      EXPECT_STREQ(e.what(), "a day takes about 6.8 GB of memory; expected at most 4 GB");
    }
  }
  EXPECT_EQ(memory_limit(), machine);
  EXPECT_THROW(expect_memory(1.01 * static_cast<double>(machine), "more than there is"), MemoryError);
}

}  // namespace
}  // namespace imulab
