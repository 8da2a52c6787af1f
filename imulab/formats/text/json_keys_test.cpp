// Objects with very many keys.
#include "imulab/error.hpp"
#include "imulab/files.hpp"

#include <fmt/core.h>
#include <gmock/gmock.h>

namespace imulab {
namespace {

std::string with_keys(int count) {
  std::string text = R"({"format": "imulab.calibration/1")";
  for (int i = 0; i < count; ++i) text += fmt::format(", \"k{}\": 1", i);
  return text + "}";
}

TEST(JsonKeys, ThatAreUnknownEndSoon) {
  EXPECT_THAT([] { parse_calibration(with_keys(20'000), "c.json"); },
              testing::ThrowsMessage<Error>(testing::HasSubstr("c.json: has more than 1000 unknown keys; expected format, imu")));
  EXPECT_THAT([] { parse_calibration(with_keys(100'100), "c.json"); },
              testing::ThrowsMessage<Error>(testing::HasSubstr("c.json: an object has more than 100000 keys; expected")));
}

}  // namespace
}  // namespace imulab
