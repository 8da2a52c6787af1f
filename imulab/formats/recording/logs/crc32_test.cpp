#include "imulab/formats/recording/logs/binary.hpp"

#include <gtest/gtest.h>

#include <string>

namespace imulab::recording_io {
namespace {

/// Bit by bit, as the polynomial says.
std::uint32_t crc_of_bits(std::string_view bytes) {
  std::uint32_t c = 0xFFFFFFFFu;
  for (const char byte : bytes) {
    c ^= static_cast<unsigned char>(byte);
    for (int bit = 0; bit < 8; ++bit) c = (c & 1) != 0 ? (c >> 1) ^ 0xEDB88320u : c >> 1;
  }
  return ~c;
}

TEST(Crc32, IsThatOfItsPolynomial) {
  EXPECT_EQ(crc32("123456789"), 0xCBF43926u);  // the check value of CRC-32/ISO-HDLC
  std::string text;
  for (std::uint32_t i = 0; i < 400; ++i) {
    EXPECT_EQ(crc32(text), crc_of_bits(text)) << i;
    EXPECT_EQ(crc32(text.substr(i / 3), crc32(text.substr(0, i / 3))), crc32(text)) << i;
    text += static_cast<char>(i * i * 2654435761u >> 24);
  }
}

}  // namespace
}  // namespace imulab::recording_io
