// Compensation of columns in memory, all coefficients on. Target: 30 million samples/s on one core, or half of what copying the same bytes
// reaches in the same run. Outliers: 10 million samples/s. A stream: a third of the reader's own speed on the same file in the same run.
#include "imulab/compensate.hpp"
#include "imulab/core/random.hpp"
#include "imulab/files.hpp"
#include "imulab/formats/recording/reader.hpp"
#include "imulab/formats/recording/text/stream.hpp"
#include "imulab/formats/recording/written/csv_writer.hpp"
#include "imulab/model/compensation_derivatives.hpp"
#include "imulab/outlier_filter.hpp"

#include <benchmark/benchmark.h>

#include <algorithm>
#include <cstdlib>
#include <fcntl.h>
#include <filesystem>
#include <random>
#include <unistd.h>
#include <vector>

namespace {

using namespace imulab;

using Columns = std::array<std::vector<double>, 3>;

Columns columns(std::size_t n, double value) {
  Columns c;
  for (auto& column : c) column.assign(n, value);
  return c;
}

struct Memory {
  Columns gyro, accel, gyro_temperature, accel_temperature, rate, force;
  explicit Memory(std::size_t n)
      : gyro(columns(n, 0.1)),
        accel(columns(n, 9.8)),
        gyro_temperature(columns(n, 30)),
        accel_temperature(columns(n, 31)),
        rate(columns(n, 0)),
        force(columns(n, 0)) {}

  RawColumns raw(bool temperatures) const {
    RawColumns c;
    for (std::size_t i = 0; i < 3; ++i) {
      c.gyro[i] = gyro[i];
      c.accel[i] = accel[i];
      if (!temperatures) continue;
      c.gyro_temperature[i] = gyro_temperature[i];
      c.accel_temperature[i] = accel_temperature[i];
    }
    return c;
  }
  MotionColumns motion() {
    MotionColumns c;
    for (std::size_t i = 0; i < 3; ++i) {
      c.rate[i] = rate[i];
      c.force[i] = force[i];
    }
    return c;
  }
};

SensorModel linear_model() {
  SensorModel m;
  m.accel.offset = m.gyro.offset = {0.1, -0.2, 0.3};
  m.accel.matrix << 1.1, 0.01, -0.02, 0.03, 0.9, 0.01, 0.02, -0.01, 1.2;
  m.gyro.matrix = m.accel.matrix.transpose();
  return m;
}

SensorModel full_model() {
  SensorModel m = linear_model();
  for (auto* triad : {&m.accel, &m.gyro}) {
    triad->quadratic = {1e-3, 2e-3, -1e-3};
    triad->cubic = {1e-5, -2e-5, 3e-5};
    triad->thermal.leftCols<3>() << 0, 1e-2, 1e-4, 0, -2e-2, 1e-4, 0, 3e-2, -1e-4;
    triad->temperature = ThermalReading{"degC", 25, {0, 70}};
  }
  m.g_sensitivity << 1e-3, 2e-3, -1e-3, 3e-3, 1e-3, 2e-3, -2e-3, 1e-3, 4e-3;
  return m;
}

void count(benchmark::State& state, int columns_moved) {
  state.SetItemsProcessed(state.iterations() * state.range(0));
  state.SetBytesProcessed(state.iterations() * state.range(0) * columns_moved * static_cast<int>(sizeof(double)));
}

void run(benchmark::State& state, const SensorModel& model, bool temperatures) {
  Memory memory(static_cast<std::size_t>(state.range(0)));
  for (auto _ : state) {
    compensate(model, memory.raw(temperatures), memory.motion());
    benchmark::ClobberMemory();
  }
  count(state, temperatures ? 18 : 12);
}

void compensate_all_coefficients(benchmark::State& state) { run(state, full_model(), true); }
/// Target: at most 1.4 times the former.
void compensate_over_temperature(benchmark::State& state) {
  SensorModel model = full_model();
  for (TriadModel* m : {&model.accel, &model.gyro}) {
    m->matrix_thermal1 << 1e-4, 1e-5, 0, 2e-5, -1e-4, 1e-5, 0, 1e-5, 5e-5;
    m->matrix_thermal2 = 0.02 * m->matrix_thermal1;
    m->thermal.col(3) = 0.02 * m->thermal.col(2);
  }
  run(state, model, true);
}
void compensate_linear(benchmark::State& state) { run(state, linear_model(), false); }

/// One sample after the other, as a real-time loop does it. Target: 40 ns a sample.
void compensate_sample_by_sample(benchmark::State& state) {
  const SampleCompensator compensator(full_model());
  Vector3d gyro(0.1, 0.2, -0.1), accel(0.1, -0.2, 9.8);
  for (auto _ : state) {
    benchmark::DoNotOptimize(gyro);
    benchmark::DoNotOptimize(accel);
    benchmark::DoNotOptimize(compensator(gyro, accel, 31));
  }
  state.SetItemsProcessed(state.iterations());
}

/// The bytes of a compensation with temperatures, 12 columns read and 6 written, by copying: nine columns to nine others.
void copy_the_same_bytes(benchmark::State& state) {
  Memory memory(static_cast<std::size_t>(state.range(0)));
  for (auto _ : state) {
    for (std::size_t i = 0; i < 3; ++i) {
      std::copy(memory.gyro[i].begin(), memory.gyro[i].end(), memory.rate[i].begin());
      std::copy(memory.accel[i].begin(), memory.accel[i].end(), memory.force[i].begin());
      std::copy(memory.gyro_temperature[i].begin(), memory.gyro_temperature[i].end(), memory.accel_temperature[i].begin());
    }
    benchmark::ClobberMemory();
  }
  count(state, 18);
}

void reject_outliers_of_columns(benchmark::State& state) {
  Memory memory(static_cast<std::size_t>(state.range(0)));
  std::array<std::span<double>, 6> columns;
  for (std::size_t c = 0; c < 6; ++c) {
    auto& column = c < 3 ? memory.rate[c] : memory.force[c - 3];
    RandomStream(1, c).normals(0, column);
    columns[c] = column;
  }
  for (auto _ : state) benchmark::DoNotOptimize(reject_outliers(columns));
  state.SetItemsProcessed(state.iterations() * state.range(0));
}

/// A recording of 7 columns of full precision, about 25 MB.
struct RecordingOnDisk {
  std::filesystem::path folder = std::filesystem::temp_directory_path() / ("imulab-bench-" + std::to_string(std::random_device{}()));
  Session session;
  RecordingSource source;
  RecordingOnDisk() {
    std::filesystem::create_directories(folder);
    session.file = (folder / "session.toml").string();
    source.file = "r.csv";
    source.time.column = 1;
    source.gyro.columns = {2, 3, 4};
    source.accel.columns = {5, 6, 7};
    Recording r;
    r.interval_s = 0.001;
    for (std::int64_t i = 0; i < 200'000; ++i) r.time_ns.push_back(i * 1'000'000);
    for (std::size_t k = 0; k < 3; ++k)
      for (auto* column : {&r.gyro[k], &r.accel[k]}) {
        column->resize(r.size());
        RandomStream(2, k).normals(0, *column);
      }
    write_recording(file(), r);
  }
  ~RecordingOnDisk() { std::filesystem::remove_all(folder); }
  std::filesystem::path file() const { return folder / source.file; }
  std::int64_t bytes() const { return static_cast<std::int64_t>(std::filesystem::file_size(file())); }
};

void read_the_same_file(benchmark::State& state) {
  const RecordingOnDisk disk;
  for (auto _ : state) benchmark::DoNotOptimize(read_recording(disk.session, disk.source));
  state.SetBytesProcessed(state.iterations() * disk.bytes());
}

/// As the command does it: text in, all coefficients, text out. With state.range(0), outliers are rejected.
void compensate_a_stream(benchmark::State& state) {
  const RecordingOnDisk disk;
  SensorModel model = full_model();
  model.accel.thermal.setZero(), model.gyro.thermal.setZero();
  const int out = ::open("/dev/null", O_WRONLY);
  for (auto _ : state) {
    const int in = ::open(disk.file().c_str(), O_RDONLY);
    RecordingStream stream(in, "file", disk.source);
    Compensator compensator(model, state.range(0) != 0 ? Outliers::reject : Outliers::keep);
    const auto write = [out](const CompensatedRecording& c) {
      const std::string text = compensated_rows(c, true);
      if (::write(out, text.data(), text.size()) < 0) std::abort();
    };
    while (auto piece = stream.next()) write(compensator.next(*std::move(piece)));
    write(compensator.rest());
    ::close(in);
  }
  ::close(out);
  state.SetBytesProcessed(state.iterations() * disk.bytes());
}

// A million samples, 144 MB: in main memory, like a recording.
BENCHMARK(compensate_all_coefficients)->Arg(1 << 20);
BENCHMARK(compensate_over_temperature)->Arg(1 << 20);
BENCHMARK(compensate_linear)->Arg(1 << 20);
BENCHMARK(compensate_sample_by_sample);
BENCHMARK(copy_the_same_bytes)->Arg(1 << 20);
BENCHMARK(reject_outliers_of_columns)->Arg(1 << 20);
BENCHMARK(read_the_same_file)->Unit(benchmark::kMillisecond);
BENCHMARK(compensate_a_stream)->Arg(0)->Arg(1)->Unit(benchmark::kMillisecond);

}  // namespace
