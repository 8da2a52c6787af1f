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
      {"c-header", "firmware, as one C header: the whole model, the recording's axes and units", "imu_calibration.h",
       [](const ExportInput& input) { return c_header(input.calibration, {.prefix = input.options.prefix}); },
       [](const ExportInput& input) { return left_out_of_c_header(input.calibration); }},
      {"kalibr-imu", "Kalibr's imu.yaml: noise N and K", "kalibr_imu.yaml", to::kalibr_imu_text, to::left_out_of_noise_files, to::warnings_of_walk,
       true, noise | topic},
      {"kalibr", "Kalibr's result form: matrices, g-sensitivity, noise N and K", "kalibr_result.yaml", to::kalibr_text, to::left_out_of_kalibr,
       to::warnings_of_walk, true, noise | topic},
      {"openvins", "OpenVINS' kalibr_imu_chain.yaml: matrices, g-sensitivity, noise N and K", "kalibr_imu_chain.yaml", to::openvins_text,
       to::left_out_of_openvins, to::warnings_of_walk, true, noise | topic | model},
      {"vins", "VINS-Fusion and VINS-Mono: noise of a sample", "vins.yaml", to::vins_text, to::left_out_of_noise_files, to::warnings_of_walk, true,
       noise | variance},
      {"euroc", "EuRoC's sensor.yaml: noise N and K", "sensor.yaml", to::euroc_text, to::left_out_of_noise_files, to::warnings_of_walk, true, noise},
      {"ros", "ROS' sensor_msgs/Imu: variances of a sample", "ros_covariance.yaml", to::ros_text, to::left_out_of_ros, to::warnings_of_white, true,
       noise},
      {"ros-filter", "ROS' imu_filter_madgwick and imu_complementary_filter: parameters from the gyros' noise", "imu_filter.yaml",
       to::ros_filter_text, to::left_out_of_ros, to::warnings_of_white, true, noise},
      {"gtsam", "GTSAM's PreintegrationCombinedParams, as a C++ function: noise N and K", "gtsam_imu.hpp", to::gtsam_text,
       to::left_out_of_noise_files, to::warnings_of_walk, true, noise},
      {"orb-slam3", "ORB-SLAM3's settings: noise N and K", "orb_slam3.yaml", to::orb_slam3_text, to::left_out_of_noise_files, to::warnings_of_walk,
       true, noise},
      {"lio-sam", "LIO-SAM's params.yaml: noise N and K", "lio_sam.yaml", to::lio_sam_text, to::left_out_of_noise_files, to::warnings_of_walk, true,
       noise},
      {"fast-lio", "FAST-LIO2's configuration: variances of a sample", "fast_lio.yaml", to::fast_lio_text, to::left_out_of_noise_files,
       to::warnings_of_walk, true, noise},
      {"glim", "GLIM's config_sensors.json: noise N, one K for all biases", "glim_sensors.json", to::glim_text, to::left_out_of_noise_files,
       to::warnings_of_glim, true, noise},
      {"kf-gins", "KF-GINS' kf-gins.yaml: noise N and K, uncertainties of the scale factors", "kf_gins.yaml", to::kf_gins_text,
       to::left_out_of_noise_files, to::warnings_of_walk, true, noise},
      {"oak", "BasaltVIO of OAK cameras (DepthAI), in Python: noise N", "oak_imu.py", to::oak_text, to::left_out_of_ros, to::warnings_of_white, true,
       noise},
      {"gazebo", "Gazebo's <imu> element of SDFormat: noise of a sample, and K", "gazebo_imu.sdf", to::gazebo_text, to::left_out_of_noise_files,
       to::warnings_of_walk, true, noise},
      {"matlab", "MATLAB's imuSensor: noise N, B and K", "imu_sensor.m", to::matlab_text, to::left_out_of_matlab, to::warnings_of_walk, true, noise},
      {"matlab-ins", "MATLAB's insEKF: noise N and K", "ins_ekf.m", to::matlab_ins_text, to::left_out_of_noise_files, to::warnings_of_walk, true,
       noise},
      {"filter", "a Kalman filter of your own, JSON: F, Q and start variance of each bias state, from a bound", "filter_noise.json", to::filter_text,
       to::left_out_of_filter, to::warnings_of_walk, true, noise | ExportTarget::bound},
      {"filter-c", "the same as arrays in C", "filter_noise.h", to::filter_c_text, to::left_out_of_filter, to::warnings_of_walk, true,
       noise | ExportTarget::bound},
      {"dlio", "DLIO's dlio.yaml: accelerometers' matrix, biases", "dlio.yaml", to::dlio_text, to::left_out_of_dlio},
      {"fusion", "x-io's Fusion, as a C header: biases and matrices", "fusion_imu.h", to::fusion_text, to::left_out_of_fusion},
      {"realsense", "RealSense's calibration.json: biases and matrices", "realsense.json", to::realsense_text, to::left_out_of_realsense},
      {"px4", "PX4's parameters: accelerometers' biases and scale factors, gyros' biases, thermal biases", "px4.params", to::px4_text,
       to::left_out_of_px4, to::px4_warnings, false, instance},
      {"ardupilot", "ArduPilot's parameters: as px4", "ardupilot.param", to::ardupilot_text, to::left_out_of_ardupilot, to::ardupilot_warnings, false,
       instance},
      {"vectornav", "VectorNav's registers 25 and 84: biases and matrices", "vectornav.txt", to::vectornav_text, to::left_out_of_vectornav},
      {"json-matrix", "JSON for other programs: the whole model, axes and units, all noise terms, standard uncertainties", "matrix.json",
       to::json_matrix_text, to::left_out_of_matrices, nullptr, false, noise},
      {"csv", "CSV for spreadsheets: as json-matrix; axes in comments", "calibration.csv", to::csv_text, to::left_out_of_matrices, nullptr, false,
       noise},
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
