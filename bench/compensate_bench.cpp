// Compensation of columns in memory, all coefficients on. Target: 30 million samples/s on one core, or half of what copying the same bytes
// reaches in the same run.
#include "imulab/model/compensate.hpp"

#include <benchmark/benchmark.h>

#include <algorithm>
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
    triad->thermal << 0, 1e-2, 1e-4, 0, -2e-2, 1e-4, 0, 3e-2, -1e-4;
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
void compensate_linear(benchmark::State& state) { run(state, linear_model(), false); }

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

// A million samples, 144 MB: main memory, as a recording is.
BENCHMARK(compensate_all_coefficients)->Arg(1 << 20);
BENCHMARK(compensate_linear)->Arg(1 << 20);
BENCHMARK(copy_the_same_bytes)->Arg(1 << 20);

}  // namespace
