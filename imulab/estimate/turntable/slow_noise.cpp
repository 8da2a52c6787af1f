#include "imulab/estimate/turntable/slow_noise.hpp"

#include "imulab/estimate/kernel/slow_noise.hpp"

#include <algorithm>

namespace imulab::turntable {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

MatrixXd slow_noise(const TableMotion& motion, const NoiseModel& noise, double interval_s) {
  const auto parts = static_cast<Index>(motion.parts());
  std::vector<kernel::TimeSpan> times;
  VectorXd duration(parts), gain(parts);
  for (std::size_t k = 0; k < motion.parts(); ++k) {
    const auto i = static_cast<Index>(k);
    times.push_back({motion.begin(k), motion.end(k)});
    duration[i] = motion.end(k) - motion.begin(k), gain[i] = motion.gain(k);
  }
  const double start = parts == 0 ? 0 : std::min_element(times.begin(), times.end(), [](auto& a, auto& b) { return a.begin < b.begin; })->begin;
  for (kernel::TimeSpan& t : times) t.begin -= start, t.end -= start;
  MatrixXd out = kernel::slow_noise(times, noise, interval_s);
  if (out.size() > 0) {
    const MatrixXd about_mean = MatrixXd::Identity(parts, parts) - VectorXd::Ones(parts) * duration.transpose() / duration.sum();
    out = about_mean * out * about_mean.transpose();
  } else if (noise.Q > 0) {
    out.setZero(parts, parts);
  }
  if (noise.Q > 0) out.diagonal().array() += 2 * noise.Q * noise.Q / duration.array().square();  // the integral's error at both ends
  return out.size() > 0 ? MatrixXd(gain.asDiagonal() * out * gain.asDiagonal()) : out;
}

}  // namespace imulab::turntable
