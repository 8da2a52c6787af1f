#include "imulab/estimate/hybrid/turns.hpp"

#include "imulab/core/rotation.hpp"
#include "imulab/eigen.hpp"
#include "imulab/recording/compensated_readings.hpp"

#include <Eigen/Geometry>
#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <iterator>

namespace imulab::hybrid {

using in_place::Block;

namespace {

double angle_between(const Vector3d& a, const Vector3d& b) { return std::atan2(a.cross(b).norm(), a.dot(b)); }

}  // namespace

std::vector<Range> motions_of(const std::vector<Block>& blocks) {
  std::vector<Range> out;
  for (std::size_t k = 1; k < blocks.size(); ++k) {
    if (blocks[k].at_rest) continue;
    if (blocks[k - 1].at_rest) out.push_back({k, k});
    if (!out.empty()) out.back().end = k + 1;
  }
  return out;
}

std::vector<double> misfits_of_gravity(const Recording& recording, const SensorModel& model, const std::vector<Block>& blocks,
                                       const std::vector<Range>& motions) {
  CompensatedReadings readings(recording, model);
  const auto force_in = [&](const Block& block) {
    Vector3d sum = Vector3d::Zero();
    for (std::size_t i = block.samples.begin; i < block.samples.end; ++i) sum += readings.force(i);
    return sum;
  };
  std::vector<double> out;
  for (const Range& motion : motions) {
    Vector3d up = force_in(blocks[motion.begin - 1]);
    const std::size_t end = motion.end < blocks.size() ? blocks[motion.end].samples.begin : blocks[motion.end - 1].samples.end;
    for (std::size_t i = blocks[motion.begin].samples.begin; i < end; ++i) up = rotation_exp(-recording.interval_s * readings.rate(i)) * up;
    out.push_back(motion.end < blocks.size() ? angle_between(up, force_in(blocks[motion.end])) : 0);
  }
  return out;
}

std::vector<Block> without(std::vector<Block> blocks, const Range& motion) {
  const auto begin = blocks.begin() + static_cast<std::ptrdiff_t>(motion.begin);
  const auto after = blocks.erase(begin, begin + static_cast<std::ptrdiff_t>(motion.size()));
  if (after != blocks.end()) after->lost = true;
  return blocks;
}

std::vector<std::size_t> without(std::vector<std::size_t> places, const Range& motion) {
  std::erase_if(places, [&](std::size_t k) { return k >= motion.begin && k < motion.end; });
  for (std::size_t& k : places)
    if (k >= motion.end) k -= motion.size();
  return places;
}

std::string in_words(const Recording& recording, const std::vector<Block>& blocks, const Range& motion) {
  const Range first = blocks[motion.begin].samples, last = blocks[motion.end - 1].samples;
  return fmt::format("the rotation from {:.1f} to {:.1f} s", recording.time_s(first.begin), recording.time_s(last.end - 1));
}

}  // namespace imulab::hybrid
