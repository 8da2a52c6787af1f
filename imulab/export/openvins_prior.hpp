// The uncertainty of a calibration in the parameters of OpenVINS, which are functions of imulab's coefficients.
#pragma once

#include "imulab/export/consumer_model.hpp"

#include <string>
#include <vector>

namespace imulab::export_io {

struct OpenVinsModel {
  Matrix3d Tw, R_IMUtoGYRO, Ta, R_IMUtoACC, Tg;
  Matrix3d C_I_b;  ///< from the calibration's body frame to the IMU frame
};
OpenVinsModel openvins_model(const ConsumerModel& m, const std::string& model);

/// Lines with the standard uncertainties of its states vec_dw, vec_da (the triangles of T^-1, column by column), vec_tg (column by column) and of
/// the rotation it estimates, in the IMU frame: for the prior that state/State.cpp sets as constants (no key of its files does). NaN where a state
/// depends on coefficients that were not estimated. One line that says so where none was.
std::vector<std::string> openvins_prior(const Calibration& calibration, const std::string& model);

}  // namespace imulab::export_io
