// The targets' functions, one source each: for the table in target.cpp.
#pragma once

#include "imulab/exchange.hpp"

#include <string>
#include <vector>

namespace imulab::export_io {

using Sentences = std::vector<std::string>;

std::string kalibr_imu_text(const ExportInput& input);
std::string kalibr_text(const ExportInput& input);
std::string openvins_text(const ExportInput& input);
std::string vins_text(const ExportInput& input);
std::string euroc_text(const ExportInput& input);
std::string ros_text(const ExportInput& input);
std::string ros_filter_text(const ExportInput& input);
std::string px4_text(const ExportInput& input);
std::string ardupilot_text(const ExportInput& input);
std::string vectornav_text(const ExportInput& input);
std::string gtsam_text(const ExportInput& input);
std::string orb_slam3_text(const ExportInput& input);
std::string lio_sam_text(const ExportInput& input);
std::string fast_lio_text(const ExportInput& input);
std::string gazebo_text(const ExportInput& input);
std::string glim_text(const ExportInput& input);
std::string kf_gins_text(const ExportInput& input);
std::string oak_text(const ExportInput& input);
std::string matlab_text(const ExportInput& input);
std::string matlab_ins_text(const ExportInput& input);
std::string realsense_text(const ExportInput& input);
std::string dlio_text(const ExportInput& input);
std::string fusion_text(const ExportInput& input);
std::string filter_text(const ExportInput& input);
std::string filter_c_text(const ExportInput& input);
std::string json_matrix_text(const ExportInput& input);
std::string csv_text(const ExportInput& input);

Sentences left_out_of_kalibr(const ExportInput& input);
Sentences left_out_of_openvins(const ExportInput& input);
Sentences left_out_of_noise_files(const ExportInput& input);  ///< of files with the terms N and K alone
Sentences left_out_of_filter(const ExportInput& input);
Sentences left_out_of_matlab(const ExportInput& input);       ///< which also has B
Sentences left_out_of_dlio(const ExportInput& input);
Sentences left_out_of_fusion(const ExportInput& input);
Sentences left_out_of_ros(const ExportInput& input);  ///< of files with N alone
Sentences left_out_of_realsense(const ExportInput& input);
Sentences left_out_of_px4(const ExportInput& input);
Sentences left_out_of_ardupilot(const ExportInput& input);
Sentences left_out_of_vectornav(const ExportInput& input);
Sentences left_out_of_matrices(const ExportInput& input);  ///< json-matrix, csv: correlations, and the noise where it is not known

Sentences warnings_of_walk(const ExportInput& input);   ///< of targets with white noise and random walk
Sentences warnings_of_white(const ExportInput& input);  ///< of those with white noise alone

Sentences warnings_of_glim(const ExportInput& input);

Sentences px4_warnings(const ExportInput& input);
Sentences ardupilot_warnings(const ExportInput& input);

}  // namespace imulab::export_io
