// Reading recordings. Target: 250 MB/s of text on one core, so that an hour at 1 kHz (0.4 GB) opens in two seconds.
#include "imulab/files.hpp"
#include "imulab/formats/recording/reader.hpp"
#include "imulab/formats/text/file.hpp"

#include <benchmark/benchmark.h>
#include <fmt/format.h>

#include <cmath>
#include <filesystem>
#include <random>
#include <string>

namespace {

using namespace imulab;

/// A file of about 100 MB, and the session and source that read it.
struct Example {
  std::filesystem::path folder = std::filesystem::temp_directory_path() / ("imulab-bench-" + std::to_string(std::random_device{}()));
  Session session;
  RecordingSource source;

  Example() {
    std::filesystem::create_directories(folder);
    session.file = (folder / "session.toml").string();
    source.file = "r.txt";
    source.time.column = 1;
    source.gyro.columns = {2, 3, 4};
    source.accel.columns = {5, 6, 7};
  }
  ~Example() { std::filesystem::remove_all(folder); }
  std::filesystem::path file() const { return folder / source.file; }
};

constexpr std::size_t file_bytes = 100'000'000;

Recording wobble(std::size_t rows) {
  Recording r;
  r.interval_s = 0.001;
  for (std::size_t i = 0; i < rows; ++i) {
    r.time_ns.push_back(static_cast<std::int64_t>(i) * 1'000'000);
    for (std::size_t k = 0; k < 3; ++k) {
      r.gyro[k].push_back(std::sin(0.01 * static_cast<double>(i + k)));  // 17 digits each
      r.accel[k].push_back(9.8 * std::cos(0.01 * static_cast<double>(i + k)));
    }
  }
  return r;
}

void read(benchmark::State& state, const Example& example) {
  const auto bytes = static_cast<std::int64_t>(std::filesystem::file_size(example.file()));
  for (auto _ : state) benchmark::DoNotOptimize(read_recording(example.session, example.source));
  state.SetBytesProcessed(state.iterations() * bytes);
}

void read_csv(benchmark::State& state) {  // 7 columns of full precision, as write_recording writes them; >= 250 MB/s
  const Example example;
  write_recording(example.file(), wobble(file_bytes / 130));
  read(state, example);
}
BENCHMARK(read_csv)->Unit(benchmark::kMillisecond);

void read_blanks(benchmark::State& state) {  // columns of fixed width separated by blanks, as MATLAB saves them; >= 250 MB/s
  const Example example;
  const Recording r = wobble(file_bytes / 113);
  fmt::memory_buffer text;
  for (std::size_t i = 0; i < r.size(); ++i)
    fmt::format_to(std::back_inserter(text), "   {:.7e}   {:.7e}   {:.7e}   {:.7e}   {:.7e}   {:.7e}   {:.7e}\n", r.time_s(i),
                   32768 + 4000 * r.gyro[0][i], 32768 + 4000 * r.gyro[1][i], 32768 + 4000 * r.gyro[2][i], 32768 + 400 * r.accel[0][i],
                   32768 + 400 * r.accel[1][i], 32768 + 400 * r.accel[2][i]);
  std::FILE* file = std::fopen(example.file().c_str(), "w");
  std::fwrite(text.data(), 1, text.size(), file);
  std::fclose(file);
  read(state, example);
}
BENCHMARK(read_blanks)->Unit(benchmark::kMillisecond);

void read_decimal_commas(benchmark::State& state) {  // between semicolons, as spreadsheets write them in half of Europe; >= 125 MB/s
  const Example example;
  write_recording(example.file(), wobble(file_bytes / 130));
  std::string text(MappedFile(example.file()).text());
  for (char& c : text) c = c == ',' ? ';' : c == '.' ? ',' : c;
  write_whole(example.file(), text);
  read(state, example);
}
BENCHMARK(read_decimal_commas)->Unit(benchmark::kMillisecond);

void read_json_lines(benchmark::State& state) {  // >= 125 MB/s
  const Example example;
  const Recording r = wobble(file_bytes / 180);
  fmt::memory_buffer text;
  for (std::size_t i = 0; i < r.size(); ++i)
    fmt::format_to(std::back_inserter(text), "{{\"t\": {}, \"gyro\": [{}, {}, {}], \"accel\": [{}, {}, {}]}}\n", r.time_s(i), r.gyro[0][i],
                   r.gyro[1][i], r.gyro[2][i], r.accel[0][i], r.accel[1][i], r.accel[2][i]);
  write_whole(example.file(), {text.data(), text.size()});
  read(state, example);
}
BENCHMARK(read_json_lines)->Unit(benchmark::kMillisecond);

void write_csv(benchmark::State& state) {  // 17 digits per value; >= 100 MB/s
  const Example example;
  const Recording r = wobble(file_bytes / 130);
  for (auto _ : state) write_recording(example.file(), r);
  state.SetBytesProcessed(state.iterations() * static_cast<std::int64_t>(std::filesystem::file_size(example.file())));
}
BENCHMARK(write_csv)->Unit(benchmark::kMillisecond);

}  // namespace
