// The findings of a calibration: notes, warnings with their consequence, and the reasons for a doubtful verdict. The rules that hold for every
// method are here, once.
#pragma once

#include "imulab/calibration.hpp"
#include "imulab/model/finding_table.hpp"
#include "imulab/recording/mean_noise.hpp"
#include "imulab/session.hpp"

#include <string>
#include <string_view>
#include <vector>

namespace imulab::kernel {

using imulab::Findings;

/// True of a fault of the session's declarations, not of the estimate: the latitude, north, the steps.
bool is_of_session(Code code);

/// Doubts the latitude where the g-sensitivity is the same on all axes: up is along the force at every rest, so an error of the Earth's vertical rate
/// looks just like it. Notes the sign of the latitude as assumed where the IMU's own g-sensitivity would hide a wrong one.
void doubt_latitude(Findings& findings, const Calibration& calibration, double latitude, double gravity);

/// The uncertainty of g, which is common to all three accelerometer scales.
UncertaintySource gravity_source(const Site& site);

/// Warns where the measured noise is not the declared one: `ratio` is measured over declared. `triad`: "accelerometers", "gyros".
void check_declared_noise(Findings& findings, std::string_view triad, double ratio);

/// Notes that `what` ("the rests' gyro means") spreads by more than the sample noise explains.
void note_spread(Findings& findings, std::string_view what, double spread, std::string_view unit_name);

/// Warns of terms that are larger than expected, each once.
void warn_of_larger_terms(Findings& findings, std::vector<std::string> terms);

/// Warns of the parts of the data that were dropped; more than a fifth of `all` is doubtful.
void add_dropped(Findings& findings, const std::vector<std::string>& names, std::size_t all, std::string_view parts = "rests and rotations");

/// Doubts gyros whose readings come in steps coarser than their noise: at rest they read much the same, so that what a step hides does not average
/// out.
void check_gyro_steps(Findings& findings, const MeanNoise& noise);

/// By how much residuals are larger than their declared size, where chance explains that less than once in a thousand; else 1.
double excess(double chi2, double degrees_of_freedom);

/// Warns that the uncertainties were enlarged by `factor`, the excess of `what`; more than one and a half is doubtful: no noise, but a wrong model.
void add_scatter(Findings& findings, std::string_view what, double factor);

/// The doubts common to all methods: no convergence, undetermined coefficients, few degrees of freedom, residuals of the wrong size, uncertain
/// scales, a g that is not the place's.
void add_common_doubts(Findings& findings, const Calibration& calibration, const Site& site, double in_effects = 0);

/// Residuals far below a declared noise. That of shaken rests is measured in their samples, and may average out.
void doubt_small_residuals(Quality& quality, const ImuDeclaration& imu);

/// The verdict, and the cause that the findings name, anew: after each change of them.
void judge(Quality& quality);

/// Adds the findings to the calibration's quality, with the verdict.
void conclude(Calibration& calibration, const Findings& findings);

}  // namespace imulab::kernel
