#include "imulab/formats/recording/signals.hpp"

#include <gmock/gmock.h>

#include "tests/recording_files.hpp"
#include <string>

namespace imulab {
namespace {

using testing::Contains;
using testing::HasSubstr;

/// A recording with more numbers than may be read gives about the first third of what may be, in whole rows, and a note.
TEST(Signals, OfALongRecordingTheFirstRowsAreRead) {
  constexpr std::size_t rows = 300'000, most = 60'000;  // numbers
  const TemporaryFolder folder;
  std::string text = "t,ax\n", records;
  for (std::size_t i = 0; i < rows; ++i) {
    const auto stamp = static_cast<std::int64_t>(i);
    const double value = 0.5 * static_cast<double>(i);
    records.append(reinterpret_cast<const char*>(&stamp), 8).append(reinterpret_cast<const char*>(&value), 8);
    text += std::to_string(i) + "," + std::to_string(value) + "\n";
  }
  const std::string head = "{'descr': [('t', '<i8'), ('ax', '<f8')], 'fortran_order': False, 'shape': (" + std::to_string(rows) + ",), }";
  for (const auto& file : {folder.write("log.csv", text), folder.write("log.npy", npy_file(head, records))}) {
    const SignalTable all = read_tables(file).front(), table = read_tables(file, {}, recording_formats(), stream_s, most).front();
    EXPECT_EQ(all.rows(), rows) << file;
    EXPECT_LT(table.rows(), rows) << file;
    EXPECT_GE(table.rows(), most / 2 / 4) << file;  // a third; of text by the length of the first lines
    EXPECT_THAT(table.notes, Contains(HasSubstr("the first " + std::to_string(table.rows()) + " rows were looked at"))) << file;
    for (const Signal& signal : table.signals) ASSERT_EQ(signal.values.size(), table.rows()) << file;
    for (std::size_t i = 0; i < table.rows(); ++i) {
      ASSERT_EQ(table.signals[0].values[i], static_cast<double>(i)) << file;
      ASSERT_EQ(table.signals[1].values[i], 0.5 * static_cast<double>(i)) << file;
    }
  }
}

}  // namespace
}  // namespace imulab
