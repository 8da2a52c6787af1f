// An aided solution as nav_msgs/Odometry in a bag of ROS 2 (docs/theory/aided.md).
#pragma once

#include "imulab/formats/recording/bag/write_mcap.hpp"
#include "imulab/navigation/aided/aided.hpp"

#include <Eigen/Core>

#include <filesystem>
#include <optional>

namespace imulab {

/// MCAP with the topic /imulab/odometry, a message a state. The frame "map" is east, north, up of the first position; "base_link", the IMU, is
/// forward, left, up (REP 103, REP 105). Covariances are whole; that of the rotation is about the axes of the map. The angular velocity is the mean
/// since the state before (of the first one, to the next), against the Earth, and without a covariance: zeros. Stamps are the recording's. The file
/// appears whole at commit(), or not at all. Throws Error where it cannot be written.
class OdometryFile {
 public:
  explicit OdometryFile(const std::filesystem::path& path);
  void add(const AidedNavigation& navigation, double time, const NavigationState& state);
  void commit();

 private:
  struct Reached {
    double time = 0;
    NavigationState state;
    Eigen::Matrix<double, 9, 9> covariance;
  };
  void write(const Reached& reached, const Eigen::Vector3d& rate);

  bag::McapWriter file_;
  Eigen::Matrix3d map_;                              // columns: its axes, Earth-fixed
  Eigen::Vector3d origin_;                           // of the map, Earth-fixed
  std::optional<Reached> first_ = {}, before_ = {};  // the first waits for its rate
};

}  // namespace imulab
