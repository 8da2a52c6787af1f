// The findings of a calibration: notes, warnings with their consequence, and reasons for a doubtful verdict; the rules common to all methods.
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

/// Returns true if the finding is a fault of the session's declarations (latitude, north, steps), not of the estimate.
bool is_of_session(Code code);

/// Doubts the latitude if the g-sensitivity is equal on all axes: the force points up at every rest, so an error of the Earth's vertical rate looks
/// identical. If the IMU's own g-sensitivity would hide a wrong sign of the latitude, notes that the sign is assumed.
void doubt_latitude(Findings& findings, const Calibration& calibration, double latitude, double gravity);

/// Returns the uncertainty of g, which is common to all three accelerometer scales.
UncertaintySource gravity_source(const Site& site);

/// Warns if the measured noise differs from the declared noise: `ratio` is measured over declared. `triad`: "accelerometers" or "gyros".
void check_declared_noise(Findings& findings, std::string_view triad, double ratio);

/// Notes that `what` ("the rests' gyro means") spreads by more than the sample noise explains.
void note_spread(Findings& findings, std::string_view what, double spread, std::string_view unit_name);

/// Warns of terms that are larger than expected, each once.
void warn_of_larger_terms(Findings& findings, std::vector<std::string> terms);

/// Warns of rejected parts of the data; rejecting more than a fifth of `all` parts is a doubt.
void add_dropped(Findings& findings, const std::vector<std::string>& names, std::size_t all, std::string_view parts = "rests and rotations");

/// Doubts gyros with steps coarser than their noise: readings at rest are nearly constant, so averaging does not reduce the rounding error.
void check_gyro_steps(Findings& findings, const MeanNoise& noise);

/// Returns the ratio of residuals to their declared size if its p-value is below 0.001, else 1.
double excess(double chi2, double degrees_of_freedom);

/// Warns that uncertainties were enlarged by `factor`, the excess of `what`; beyond 1.5 the model is doubtful.
void add_scatter(Findings& findings, std::string_view what, double factor);

/// Adds the doubts common to all methods: no convergence, undetermined coefficients, few degrees of freedom, residuals of the wrong size, uncertain
/// scales, a g that is implausible for the site.
void add_common_doubts(Findings& findings, const Calibration& calibration, const Site& site, double in_effects = 0);

/// Doubts residuals far below a declared noise. The noise of shaken rests is measured in their samples and may average out.
void doubt_small_residuals(Quality& quality, const ImuDeclaration& imu);

/// Recomputes verdict and cause from the findings; required after each change of the findings.
void judge(Quality& quality);

/// Adds the findings to the calibration's quality and sets its verdict.
void conclude(Calibration& calibration, const Findings& findings);

}  // namespace imulab::kernel
