// A calibration for people, in at most 80 columns, and how well an IMU is known, in a line a triad.
#pragma once

#include "imulab/calibration.hpp"
#include "imulab/model/conclusion.hpp"

#include <cstddef>
#include <functional>
#include <string>
#include <string_view>

namespace imulab {

struct CalibrationResult;

/// By its verdict and its requirements, which it keeps itself.
Conclusion conclusion_of(const Calibration& calibration);
/// The text of its file, with verdict, headline and warnings after the file's own fields: what --json prints.
std::string calibration_document(const Calibration& calibration);

/// The verdict; one line per triad with the uncertainties reached; fit and requirements; then every coefficient that the data showed, in user units,
/// with the digits that its standard uncertainty supports.
std::string calibration_summary(const Calibration& calibration);

/// Standard uncertainties of the offsets at the next switch-on, "accel.offset 210 ug, gyro.offset 1.1 deg/h"; empty where they are not known.
std::string next_switch_on_text(const Calibration& calibration);

/// All the rest: every estimated coefficient in SI and in user units, what was used, and the tests of optional terms. With the model before the
/// estimate, `coarse`: also its value and the correction.
std::string calibration_details(const Calibration& calibration, const SensorModel* coarse = nullptr);

/// The column of an effect that is the most of its standard deviations from zero.
std::size_t clearest_axis(const EffectEstimate& effect);

/// Of a note: what the result depends on and the data do not confirm, which is stated with it.
bool is_assumption(const Finding& finding);

/// Convergence curves as CSV: t (s), then for every coefficient NAME,NAME.sigma: its residual and the standard uncertainty of the residual.
std::string curves_csv(const CalibrationResult& result);

/// The standard uncertainty by which people judge a calibration: of matrices relative to the row's scale; of readings in counts that of the output
/// where it is zero, since their offset is that of a reading far away. Not finite where it is no result of the data.
double judged_uncertainty(const Calibration& calibration, CoefficientIndex index);

/// The worst standard uncertainty of a selector's coefficients in user units, "83 ppm"; empty where none is known. `sigma` gives a coefficient's; not
/// finite where it is not known.
std::string worst_text(std::string_view selector, const std::function<double(CoefficientIndex)>& sigma);

/// Returns "nonorthogonality" if the axes are the triad's own, so that the elements above the diagonal are zero by definition; else "misalignment".
/// `triad`: "accel" or "gyro"; `sigma`: as of worst_text.
std::string_view name_of_off_diagonal(std::string_view triad, const std::function<double(CoefficientIndex)>& sigma);
/// The worst of a triad's scales, misalignments (nonorthogonality, if the axes are its own) and biases, "scale 93 ppm, misalignment 12 arcsec, bias 38 ug";
/// empty if none is known. `triad`: "accel" or "gyro".
std::string worst_terms(std::string_view triad, const std::function<double(CoefficientIndex)>& sigma);
/// The same, a line a triad.
std::string worst_rows(const std::function<double(CoefficientIndex)>& sigma);
/// The same, and what it is.
std::string reached_text(const std::function<double(CoefficientIndex)>& sigma);

}  // namespace imulab
