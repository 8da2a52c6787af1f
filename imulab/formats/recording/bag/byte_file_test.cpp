#include "imulab/formats/recording/bag/byte_file.hpp"

#include "imulab/error.hpp"
#include "imulab/formats/text/file.hpp"

#include <gtest/gtest.h>

#include "tests/temporary_folder.hpp"
#include <fstream>
#include <limits>

namespace imulab::bag {
namespace {

constexpr std::uint64_t far = std::uint64_t{9} << 29;  // 4.5 GiB: beyond 32 bits

/// A hole of that size, and a word after it.
std::filesystem::path large_file(const TemporaryFolder& folder) {
  const std::filesystem::path file = folder / "large";
  { const std::ofstream made(file); }
  std::filesystem::resize_file(file, far);
  std::ofstream(file, std::ios::binary | std::ios::app) << "word";
  return file;
}

TEST(ByteFile, ReadsBeyondFourGigabytes) {
  const TemporaryFolder folder;
  const ByteFile file(large_file(folder));
  EXPECT_EQ(file.size(), far + 4);
  Buffer buffer;
  EXPECT_EQ(file.read(far, 4, buffer), "word");
  EXPECT_EQ(file.read_some(far + 2, 100, buffer), "rd");
}

TEST(MappedFileOfGigabytes, IsMappedWholeOrRefused) {
  const TemporaryFolder folder;
  const std::filesystem::path path = large_file(folder);
  if constexpr (std::numeric_limits<std::size_t>::digits > 32) {
    const MappedFile file(path);
    EXPECT_EQ(file.text().substr(far), "word");
  } else {
    EXPECT_THROW(MappedFile{path}, Error);
  }
}

}  // namespace
}  // namespace imulab::bag
