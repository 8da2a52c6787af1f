// The sections of a calibration's page, each as HTML; empty where there is nothing to show.
#pragma once

#include "imulab/report/calibration_page.hpp"
#include "imulab/report/page.hpp"

#include <string>
#include <vector>

namespace imulab::report {

// calibration_pictures.cpp: from the recordings and residuals
std::string before_and_after(const CalibrationReport& report);
std::string sweep_figures(const CalibrationReport& report);
std::string recordings_section(const CalibrationReport& report);
std::string residuals_section(const Calibration& calibration);
std::string coverage_section(const CalibrationReport& report);
std::vector<Vector3d> rest_directions(const CalibrationReport& report);

// calibration_coefficients.cpp: values and uncertainties
std::string coefficients_section(const Calibration& calibration);
std::string uncertainty_section(const Calibration& calibration);
/// "accel.offset.x and accel.matrix.xx (0.9), ..."; empty with fewer than two coefficients.
std::string strongest_correlations(const Calibration& calibration);
std::string correlation_section(const Calibration& calibration);
std::string tests_section(const Calibration& calibration);
std::string effects_section(const Calibration& calibration);

// calibration_curves.cpp: convergence, temperature, nonlinearity
std::string convergence_section(const CalibrationResult& result);
std::string thermal_section(const CalibrationReport& report);
std::string nonlinearity_section(const CalibrationReport& report);

// calibration_certificate.cpp: what a certificate states
std::string identification_section(const CalibrationReport& report);
std::string not_covered_section(const CalibrationReport& report, const std::string& temperature = "");  ///< as declared
std::string traceability_section(const CalibrationReport& report);
std::string origin_section(const CalibrationReport& report);

}  // namespace imulab::report
