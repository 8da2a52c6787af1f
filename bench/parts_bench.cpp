// Parts of a work are joined at the speed of a disk.
#include "imulab/core/part_file.hpp"
#include "imulab/core/shared_work.hpp"

#include <benchmark/benchmark.h>

#include <memory>
#include <string>
#include <vector>

namespace imulab {
namespace {

constexpr std::size_t parts = 10, blocks = 10000, bytes_of_block = 10000;

std::vector<std::string> made_parts() {
  std::vector<std::string> files;
  for (std::size_t k = 1; k <= parts; ++k) {
    PartWriter part({k, parts}, "bench");
    const BlockRange range = part.begin_work("bench", blocks);
    for (std::size_t block = range.begin; block < range.end; ++block) part.add(std::string(bytes_of_block, 'x'));
    part.end_work();
    files.push_back(part.bytes());
  }
  return files;
}

void join_parts(benchmark::State& state) {  // ten files of 10 MB; >= 400 MB/s, a disk
  const std::vector<std::string> files = made_parts();
  for (auto _ : state) {
    std::vector<PartReader::Source> sources;
    for (const std::string& file : files) sources.push_back(PartReader::memory("part", file));
    std::size_t taken = 0;
    PartReader(std::move(sources)).read("bench", blocks, [&](std::size_t, const std::string& result) { taken += result.size(); });
    benchmark::DoNotOptimize(taken);
  }
  state.SetBytesProcessed(state.iterations() * static_cast<std::int64_t>(blocks * bytes_of_block));
}
BENCHMARK(join_parts)->Unit(benchmark::kMillisecond);

}  // namespace
}  // namespace imulab
