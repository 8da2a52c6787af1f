#include "imulab/core/decomposition.hpp"
#include "imulab/estimate/kernel/slow_noise.hpp"
#include "imulab/estimate/whole_unit/problem.hpp"
#include "imulab/recording/declared_noise.hpp"

#include <algorithm>
#include <cmath>

namespace imulab::whole_unit {

using Eigen::Index;

double ChannelDrift::at(const MachinePoint& point) const { return point.recording == recording ? shape[static_cast<Index>(point.number)] : 0; }

void Problem::add_drifts() {
  constexpr double stands_out = 0.1;
  const NoiseModels declared = declared_terms(session->imu);
  point_variance.assign(session->recordings.size(), Vector6d::Zero());
  for (std::size_t recording = 0; recording < point_variance.size(); ++recording) {
    std::vector<const MachinePoint*> of_recording;
    for (const MachinePoint& p : points.all)
      if (p.recording == recording) of_recording.push_back(&p);
    if (of_recording.empty()) continue;
    const auto n = std::ssize(of_recording);
    // Noise begins with the recording, whose clock begins with it unless it starts with more than the recording's own length.
    const double first = of_recording.front()->step.start, origin = first < of_recording.back()->step.end - first ? 0 : first;
    std::vector<kernel::TimeSpan> times;
    for (const MachinePoint* p : of_recording) times.push_back({p->step.start - origin, p->step.end - origin});
    Eigen::MatrixXd covariance;
    SymmetricEigen shapes;
    for (int channel = 0; channel < 6; ++channel) {
      const NoiseModel& of_triad = channel < 3 ? declared.accel : declared.gyro;
      if (channel % 3 == 0) covariance = kernel::slow_noise(times, of_triad, points.interval_s);
      if (covariance.size() == 0) continue;
      if (channel % 3 == 0) shapes = symmetric_eigen(covariance);
      const double independent = std::max(0.0, shapes.values[0]), white = noise[channel] / static_cast<double>(of_recording.front()->samples);
      double others = 0;
      for (Index k = 0; k < n; ++k) {
        const double variance = shapes.values[k] - independent;
        if (!(variance > stands_out * (white + independent))) {
          others += variance / static_cast<double>(n);
          continue;
        }
        ChannelDrift drift{recording, channel, Eigen::VectorXd::Zero(static_cast<Index>(of_recording.back()->number) + 1)};
        for (Index p = 0; p < n; ++p) drift.shape[static_cast<Index>(of_recording[static_cast<std::size_t>(p)]->number)] = shapes.vectors(p, k);
        common.push_back({"", {}, std::sqrt(variance), 0, std::move(drift)});
      }
      point_variance[recording][channel] = independent + others;
    }
  }
}

}  // namespace imulab::whole_unit
