// Reading binary recordings whose bytes are the numbers. Target: half the speed of copying the file.
#include "imulab/files.hpp"
#include "imulab/formats/recording/bag/bytes.hpp"
#include "imulab/formats/recording/table_reader.hpp"
#include "imulab/formats/text/file.hpp"

#include <benchmark/benchmark.h>

#include <cmath>
#include <filesystem>
#include <random>
#include <string>
#include <vector>

namespace {

using namespace imulab;
using bag::append;

constexpr std::size_t samples = 1'000'000;

double reading(std::size_t i, std::size_t k) { return std::sin(0.01 * static_cast<double>(i + k)); }

void append_padded(std::string& out, std::string text, std::size_t size) {
  text.resize(size);
  out += text;
}

/// ArduPilot's log of one IMU at 50 bytes a sample.
std::string dataflash_log() {
  std::string out;
  const auto define = [&](unsigned char id, unsigned char length, const char* name, const char* format, const char* columns) {
    out += "\xA3\x95\x80";
    append<std::uint8_t>(out, id);
    append<std::uint8_t>(out, length);
    append_padded(out, name, 4);
    append_padded(out, format, 16);
    append_padded(out, columns, 64);
  };
  define(128, 89, "FMT", "BBnNZ", "Type,Length,Name,Format,Columns");
  define(10, 50, "IMU", "QBffffffIhQ", "TimeUS,I,GyrX,GyrY,GyrZ,AccX,AccY,AccZ,EG,T,SampleUS");
  for (std::size_t i = 0; i < samples; ++i) {
    out += "\xA3\x95\x0A";
    append<std::uint64_t>(out, 2500 * i);
    append<std::uint8_t>(out, 0);
    for (std::size_t k = 0; k < 6; ++k) append<float>(out, static_cast<float>(reading(i, k)));
    append<std::uint32_t>(out, 0);
    append<std::int16_t>(out, 2500);
    append<std::uint64_t>(out, 2500 * i);
  }
  return out;
}

/// A file of MATLAB's version 5 with one variable, imu: stamps and six readings as doubles, column by column.
std::string matlab_file() {
  constexpr std::uint32_t matrix = 14, flags = 6, sizes = 5, name = 1, doubles = 9, double_class = 6, columns = 7;
  std::string content, out = "MATLAB 5.0 MAT-file";
  const auto element = [&](std::uint32_t type, std::size_t bytes) {
    append<std::uint32_t>(content, type);
    append<std::uint32_t>(content, bytes);
  };
  element(flags, 8);
  append<std::uint64_t>(content, double_class);
  element(sizes, 8);
  append<std::uint32_t>(content, samples);
  append<std::uint32_t>(content, columns);
  element(name, 3);
  append_padded(content, "imu", 8);
  element(doubles, samples * columns * sizeof(double));
  for (std::size_t c = 0; c < columns; ++c)
    for (std::size_t i = 0; i < samples; ++i) append<double>(content, c == 0 ? 0.0025 * static_cast<double>(i) : reading(i, c));
  out.resize(124, ' ');
  out += std::string("\0\1IM", 4);
  append<std::uint32_t>(out, matrix);
  append<std::uint32_t>(out, content.size());
  return out + content;
}

/// A file that is removed at the end.
class Example {
 public:
  explicit Example(const std::string& content) { write_whole(path_, content); }
  ~Example() { std::filesystem::remove(path_); }
  Example(const Example&) = delete;
  Example& operator=(const Example&) = delete;
  const std::filesystem::path& path() const { return path_; }

 private:
  std::filesystem::path path_ = std::filesystem::temp_directory_path() / ("imulab-bench-" + std::to_string(std::random_device{}()));
};

void copy_file(benchmark::State& state, std::string (*content)()) {  // the measure: into memory that is new, as a table's is
  const Example example(content());
  for (auto _ : state) {
    const MappedFile file(example.path());
    const std::vector<char> copy(file.text().begin(), file.text().end());
    benchmark::DoNotOptimize(copy.data());
  }
  state.SetBytesProcessed(state.iterations() * static_cast<std::int64_t>(std::filesystem::file_size(example.path())));
}
BENCHMARK_CAPTURE(copy_file, dataflash, dataflash_log)->Unit(benchmark::kMillisecond)->UseRealTime();
BENCHMARK_CAPTURE(copy_file, matlab, matlab_file)->Unit(benchmark::kMillisecond)->UseRealTime();

void read_file(benchmark::State& state, std::string (*content)(), const char* topic, const std::vector<Column>& columns) {  // >= half of copy_file
  const Example example(content());
  const TableRequest request{example.path(), topic, ""};
  for (auto _ : state) {
    const recording_io::TableRows table = recording_io::read_columns(request, columns);
    if (table.columns[0].size() != samples) state.SkipWithError("samples are missing");
  }
  state.SetBytesProcessed(state.iterations() * static_cast<std::int64_t>(std::filesystem::file_size(example.path())));
}
const std::vector<Column> dataflash_names{"TimeUS", "GyrX", "GyrY", "GyrZ", "AccX", "AccY", "AccZ"};
const std::vector<Column> matlab_names{"imu.1", "imu.2", "imu.3", "imu.4", "imu.5", "imu.6", "imu.7"};
BENCHMARK_CAPTURE(read_file, dataflash, dataflash_log, "IMU", dataflash_names)->Unit(benchmark::kMillisecond)->UseRealTime();
BENCHMARK_CAPTURE(read_file, matlab, matlab_file, "", matlab_names)->Unit(benchmark::kMillisecond)->UseRealTime();

}  // namespace
