// The readings of an IMU of a body, on its own clock.
#pragma once

#include "imulab/eigen.hpp"
#include "imulab/extrinsics.hpp"
#include "imulab/navigation/common_motion.hpp"

#include <vector>

namespace imulab::extrinsics {

using common_motion::Sample, common_motion::Stream;

/// Compensates the readings, and takes means over 4 ms of those that come faster. Times count from `origin_ns` on the IMU's clock. Samples at a limit
/// and across gaps are left out.
Stream stream_of(const BodyImu& imu, std::int64_t origin_ns);

struct Span {
  double begin = 0, end = 0;  ///< s
  double length() const { return end - begin; }
};

/// The spans of at most `most` seconds in all that have most motion, in order.
std::vector<Span> spans_with_motion(const Stream& stream, const Span& whole, double most);

}  // namespace imulab::extrinsics
