// Zip64: archives beyond 4 GB, and small ones whose numbers stand in its fields, whole and damaged.
#include "imulab/formats/recording/archive/zip.hpp"

#include "imulab/formats/recording/logs/binary.hpp"

#include <gmock/gmock.h>

#include "tests/recording_files.hpp"
#include <cstdint>
#include <filesystem>
#include <limits>
#include <string>
#include <vector>

namespace imulab::recording_io {
namespace {

using testing::HasSubstr;

std::string array_of(const std::vector<double>& numbers) {
  return npy_file("{'descr': '<f8', 'fortran_order': False, 'shape': (" + std::to_string(numbers.size()) + ",), }",
                  {reinterpret_cast<const char*>(numbers.data()), numbers.size() * sizeof(double)});
}

/// Two arrays; numbers from `large` on are in fields of Zip64.
std::string archive(std::uint64_t large, std::uint64_t before = 0) {
  std::string bytes;
  ZipWriter writer([&](std::string_view piece) { bytes += piece; }, before, large);
  writer.add("t.npy", array_of({0.1, 0.2, 0.3}));
  writer.add("x.npy", array_of({1, -2, 3}));
  writer.finish();
  return bytes;
}

constexpr std::uint64_t never = std::numeric_limits<std::uint64_t>::max(), always = 0;

double x_at(std::size_t i, std::size_t) { return i == 1 ? -2.0 : static_cast<double>(i + 1); }

TEST(Zip, NumbersOf64BitsAreReadAsThoseOf32) {
  const TemporaryFolder folder;
  for (const std::uint64_t large : {always, std::uint64_t{200}, never}) {
    const std::string bytes = archive(large);
    EXPECT_EQ(bytes.find(std::string("PK\6\6")) != std::string::npos, large != never) << large;
    expect_columns({.file = folder.write("x.npz", bytes)}, {"x"}, x_at, 3);
  }
}

TEST(Zip, BeyondFourGigabytes) {
  if (sizeof(std::size_t) == 4) GTEST_SKIP() << "32 bits";
  const TemporaryFolder folder;
  constexpr std::uint64_t before = 5'000'000'000;  // a hole in the file
  const auto file = folder.write("x.npz", "PK\3\4");
  std::filesystem::resize_file(file, before);
  const std::string bytes = archive(std::numeric_limits<std::uint32_t>::max(), before);
  std::ofstream(file, std::ios::binary | std::ios::app).write(bytes.data(), static_cast<std::streamsize>(bytes.size()));
  expect_columns({.file = file}, {"x"}, x_at, 3);
}

/// Any of the numbers in 64 bits wrong: an error, whatever they are.
TEST(Zip, WrongNumbersAreErrors) {
  const TemporaryFolder folder;
  const std::string whole = archive(always);
  const std::size_t directory = whole.find("PK\1\2"), end = whole.find("PK\6\6"), locator = whole.find("PK\6\7");
  const std::size_t numbers = directory + 46 + std::string("t.npy").size() + 4;
  const auto message = [&](const std::string& bytes) { return error_of({.file = folder.write("x.npz", bytes)}, {"x"}); };
  ASSERT_EQ(message(whole), "no error");
  const struct {
    const char* what;
    std::size_t place;
    const char* says;
  } cases[] = {
      {"size", numbers, "t.npy has impossible sizes"},
      {"stored size", numbers + 8, "t.npy"},
      {"place", numbers + 16, "t.npy is not where the directory says"},
      {"entries", end + 32, "its directory is damaged"},
      {"place of the directory", end + 48, "its directory is damaged"},
      {"place of its end", locator + 8, "its directory is damaged"},
  };
  const std::uint64_t size = whole.size();
  for (const auto& c : cases)
    for (const std::uint64_t wrong : {size - 1, size, std::uint64_t{1} << 32, std::uint64_t{1} << 63, never - 20, never}) {
      std::string bytes = whole;
      store<std::uint64_t>(bytes.data() + c.place, wrong);
      EXPECT_THAT(message(bytes), HasSubstr(c.says)) << c.what << " " << wrong;
    }
  // The field is missing, too short, or another.
  for (const std::uint16_t length : {0, 4, 8, 16, 0xFFFF}) {
    std::string bytes = whole;
    store<std::uint16_t>(bytes.data() + numbers - 2, length);
    EXPECT_THAT(message(bytes), HasSubstr("x.npz: ")) << length;
  }
  std::string other = whole;
  store<std::uint16_t>(other.data() + numbers - 4, 2);
  EXPECT_THAT(message(other), HasSubstr("t.npy"));
}

}  // namespace
}  // namespace imulab::recording_io
