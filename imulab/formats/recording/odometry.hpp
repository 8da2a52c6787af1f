// An aided solution as nav_msgs/Odometry in a bag of ROS 2 (docs/theory/aided.md).
#pragma once

#include "imulab/navigation/aided/aided.hpp"

#include <filesystem>

namespace imulab {

/// MCAP with the topic /imulab/odometry, a message a state. The frame "map" is east, north, up of the first position; "base_link", the IMU, is forward,
/// left, up (REP 103, REP 105). Covariances are whole; that of the rotation is about the axes of the map. The angular velocity is the mean since the
/// state before, against the Earth, and without a covariance: zeros. Stamps are the recording's. The file appears whole or not at all. Throws Error
/// where it cannot be written.
void write_odometry(const std::filesystem::path& path, const AidedNavigation& navigation);

}  // namespace imulab
