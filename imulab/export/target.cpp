#include "imulab/core/nearest_name.hpp"
#include "imulab/error.hpp"
#include "imulab/exchange.hpp"
#include "imulab/export/c_header.hpp"
#include "imulab/export/targets.hpp"
#include "imulab/formats/text/printable.hpp"

#include <fmt/core.h>

namespace imulab {

const std::vector<ExportTarget>& export_targets() {
  namespace to = export_io;
  constexpr auto noise = ExportTarget::noise, variance = ExportTarget::variance_matched, model = ExportTarget::imu_model, topic = ExportTarget::topic,
                 instance = ExportTarget::instance;
  static const std::vector<ExportTarget> targets{
      {"c-header", "compensation for firmware, one header without a library", "imu_calibration.h",
       [](const ExportInput& input) { return c_header(input.calibration, {.prefix = input.options.prefix}); },
       [](const ExportInput& input) { return left_out_of_c_header(input.calibration); }},
      {"kalibr-imu", "Kalibr's imu.yaml: noise", "kalibr_imu.yaml", to::kalibr_imu_text, to::left_out_of_noise_files, to::warnings_of_walk, true,
       noise | topic},
      {"kalibr", "Kalibr's result form: matrices, g-sensitivity, noise", "kalibr_result.yaml", to::kalibr_text, to::left_out_of_kalibr,
       to::warnings_of_walk, true, noise | topic},
      {"openvins", "OpenVINS' kalibr_imu_chain.yaml", "kalibr_imu_chain.yaml", to::openvins_text, to::left_out_of_openvins, to::warnings_of_walk,
       true, noise | topic | model},
      {"vins", "VINS-Fusion and VINS-Mono: noise of a sample", "vins.yaml", to::vins_text, to::left_out_of_noise_files, to::warnings_of_walk, true,
       noise | variance},
      {"euroc", "EuRoC's sensor.yaml: noise", "sensor.yaml", to::euroc_text, to::left_out_of_noise_files, to::warnings_of_walk, true, noise},
      {"ros", "covariances of ROS' sensor_msgs/Imu", "ros_covariance.yaml", to::ros_text, to::left_out_of_ros, to::warnings_of_white, true, noise},
      {"ros-filter", "parameters of ROS' imu_filter_madgwick and imu_complementary_filter", "imu_filter.yaml", to::ros_filter_text,
       to::left_out_of_ros, to::warnings_of_white, true, noise},
      {"gtsam", "GTSAM's PreintegrationCombinedParams: noise", "gtsam_imu.hpp", to::gtsam_text, to::left_out_of_noise_files, to::warnings_of_walk,
       true, noise},
      {"orb-slam3", "ORB-SLAM3's settings: noise", "orb_slam3.yaml", to::orb_slam3_text, to::left_out_of_noise_files, to::warnings_of_walk, true,
       noise},
      {"lio-sam", "LIO-SAM's params.yaml: noise", "lio_sam.yaml", to::lio_sam_text, to::left_out_of_noise_files, to::warnings_of_walk, true, noise},
      {"fast-lio", "FAST-LIO2's configuration: variances of a sample", "fast_lio.yaml", to::fast_lio_text, to::left_out_of_noise_files,
       to::warnings_of_walk, true, noise},
      {"glim", "GLIM's config_sensors.json: noise", "glim_sensors.json", to::glim_text, to::left_out_of_noise_files, to::warnings_of_glim, true,
       noise},
      {"kf-gins", "KF-GINS' kf-gins.yaml: noise", "kf_gins.yaml", to::kf_gins_text, to::left_out_of_noise_files, to::warnings_of_walk, true, noise},
      {"oak", "BasaltVIO of OAK cameras (DepthAI), in Python: noise", "oak_imu.py", to::oak_text, to::left_out_of_ros, to::warnings_of_white, true,
       noise},
      {"gazebo", "Gazebo's <imu> element of SDFormat: noise", "gazebo_imu.sdf", to::gazebo_text, to::left_out_of_noise_files, to::warnings_of_walk,
       true, noise},
      {"matlab", "MATLAB's imuSensor: noise", "imu_sensor.m", to::matlab_text, to::left_out_of_matlab, to::warnings_of_walk, true, noise},
      {"filter", "a Kalman filter's F, Q and start covariance of a bound, JSON", "filter_noise.json", to::filter_text, to::left_out_of_filter,
       nullptr, true, noise | ExportTarget::bound},
      {"filter-c", "the same as arrays in C", "filter_noise.h", to::filter_c_text, to::left_out_of_filter, nullptr, true,
       noise | ExportTarget::bound},
      {"matlab-ins", "MATLAB's insEKF: noise", "ins_ekf.m", to::matlab_ins_text, to::left_out_of_noise_files, to::warnings_of_walk, true, noise},
      {"dlio", "DLIO's dlio.yaml: accelerometers' matrix, biases", "dlio.yaml", to::dlio_text, to::left_out_of_dlio},
      {"fusion", "x-io's Fusion: matrices and offsets in C", "fusion_imu.h", to::fusion_text, to::left_out_of_fusion},
      {"realsense", "RealSense's calibration.json: matrices and biases", "realsense.json", to::realsense_text, to::left_out_of_realsense},
      {"px4", "parameters of PX4", "px4.params", to::px4_text, to::left_out_of_px4, to::px4_warnings, false, instance},
      {"ardupilot", "parameters of ArduPilot", "ardupilot.param", to::ardupilot_text, to::left_out_of_ardupilot, to::ardupilot_warnings, false,
       instance},
      {"vectornav", "commands for VectorNav's registers", "vectornav.txt", to::vectornav_text, to::left_out_of_vectornav},
      {"json-matrix", "matrices and biases as JSON", "matrix.json", to::json_matrix_text, to::left_out_of_matrices, nullptr, false, noise},
      {"csv", "coefficients as a table", "calibration.csv", to::csv_text, to::left_out_of_matrices, nullptr, false, noise},
  };
  return targets;
}

const ExportTarget& export_target(std::string_view name, const std::vector<ExportTarget>& targets) {
  std::vector<std::string_view> names;
  for (const ExportTarget& target : targets) {
    if (target.name == name) return target;
    names.push_back(target.name);
  }
  throw Error(fmt::format("{} is not an export target{}", name, expected_name(name, names)));
}

}  // namespace imulab
