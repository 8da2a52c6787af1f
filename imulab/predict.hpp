// Predicts a calibration before data exist: uncertainties, their dominant sources, and the errors of rig and IMU that would meet requirements
// (docs/theory/strapdown.md).
//
// Example:
//   const Session procedure = zhang_24_procedure({});
//   const Prediction p = predict("turntable", procedure, {.requirements = parse_requirements("gyro.matrix.off_diagonal <= 5 arcsec")});
//   for (const Shortfall& s : p.missed) std::printf("%s: %g\n", coefficient(s.coefficient).name.data(), s.sigma);  // SI
//   if (p.tolerances && p.tolerances->answers.back().declared.factor) std::printf("%g\n", *p.tolerances->answers.back().declared.factor);
//
// Sigmas are SI, one for each of `coefficients`, to first and second order. They equal the uncertainties that `calibrate` would state for data of an
// ideal unit. Coefficients that the procedure does not determine are in `undetermined`. A prediction uses all threads, and several may run at the
// same time; the time of a Monte Carlo simulation is proportional to its runs.
#pragma once

#include "imulab/calibration.hpp"
#include "imulab/eigen.hpp"
#include "imulab/session.hpp"

#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <stop_token>
#include <string>
#include <string_view>
#include <vector>

namespace imulab {

namespace motion {
struct NominalMotion;
}

/// A requirement that is not met, with one of its coefficients.
struct Shortfall {
  Requirement requirement;
  CoefficientIndex coefficient;
  double sigma;             ///< larger of u and U/2, SI; infinite: not determined by the procedure
  std::string source = {};  ///< source of most of the variance if known, or the reason why it meets no requirement
};

struct Sharing;  // distribution of work among processes, used by the command

/// Every method uses the first two options; the others apply to the methods whose table row declares them.
struct PredictionOptions {
  std::vector<CoefficientIndex> terms = {};    ///< as in CalibrationOptions
  std::vector<Requirement> requirements = {};  ///< requirements for the comparison
  bool effects = true;                         ///< as in CalibrationOptions
  bool sizes = false;                          ///< also predicts for effects half and twice as large as expected
  std::uint64_t runs = 0;                      ///< number of Monte Carlo runs; 0: no simulation
  std::uint64_t seed = 1;
  bool advice = true;                                        ///< gives advice if a requirement is missed or a coefficient is not determined
  bool classical = false;                                    ///< uses the weights and model of the paper behind the method
  std::function<void(double)> progress = {};                 ///< called with the fraction done, 0 to 1, from any thread
  std::shared_ptr<Sharing> sharing = {};                     ///< shares the Monte Carlo runs among processes for the command; programs leave it empty
  std::stop_token stop = {};                                 ///< as in CalibrationOptions
  std::shared_ptr<const motion::NominalMotion> motion = {};  ///< true motion, for a method whose procedure is a mission
};

/// Statistics of complete procedures with random errors, each calibrated.
struct MonteCarloResult {
  std::vector<CoefficientIndex> coefficients = {};
  std::uint64_t runs = 0;
  Eigen::VectorXd mean;            ///< mean of the errors
  Eigen::VectorXd sigma;           ///< root mean square error
  Eigen::VectorXd sampling_sigma;  ///< relative standard deviation of `sigma`
};

/// An optional term of the IMU as an error source: the part that the readings do not determine.
struct TermSource {
  std::string name = {};   ///< source name: "accel.quadratic"
  CoefficientIndex first;  ///< coefficient of the x axis
  double prior = 0;        ///< one sigma of each coefficient [SI]
};

/// Source name of coefficients that the procedure does not determine: they keep their starting values, with errors as large as their prior.
inline constexpr const char* undetermined_source = "undetermined coefficients";

/// Groups of errors that a tolerance scales.
enum class Knob { table, timing, imu, all };
std::string_view to_string(Knob knob);

/// Scaled sizes, SI: sigmas of the table, and noise of the IMU. 0 means absent or exactly known.
struct ErrorSizes {
  double angle = 0, orthogonality = 0, zero = 0, timing = 0;
  double gyro_noise = 0, accel_noise = 0, gyro_turn_on = 0, accel_turn_on = 0;
};

/// The largest errors that meet the requirements.
struct Tolerance {
  /// Multiple of the declared size (of 1 arcsec or 1 ms if none is declared); absent: even perfect parts do not meet the requirements.
  std::optional<double> factor = {};
  bool unlimited = false;                  ///< the factor is the largest that was tried
  ErrorSizes sizes;                        ///< sizes at this factor
  std::vector<Shortfall> shortfalls = {};  ///< requirements that even perfect parts miss
};

/// The errors of table, timing and IMU that would meet the requirements.
struct Tolerances {
  ErrorSizes declared;
  bool has_turns = true;  ///< without turns, their timing has no effect
  struct Answer {
    Knob knob;
    Tolerance declared;                   ///< the other groups have their declared sizes
    std::optional<Tolerance> alone = {};  ///< all other groups are perfect
  };
  std::vector<Answer> answers = {};  ///< the last answer scales all groups together
};

/// The worst-determined combination of coefficients, each in units of its requirement (or of half its prior), and the most useful further turns: one
/// or two turns of 90 or 180 deg about the table's axes at the end of the procedure.
struct Advice {
  std::vector<CoefficientIndex> coefficients = {};  ///< coefficients with a large part in the combination, the largest first
  double ratio = 0;                                 ///< sigma of the combination in these units
  std::vector<std::string> turns = {};              ///< "turn by 180 deg about the IMU's z axis while it is horizontal"; each is followed by a rest
  double ratio_after = 0;                           ///< largest ratio with these turns
};

/// Predicted standard uncertainties. SI.
struct Prediction {
  std::vector<CoefficientIndex> coefficients, undetermined;
  Eigen::VectorXd sigma;                    ///< one for each of `coefficients`, including the second order
  Eigen::VectorXd cramer_rao;               ///< Cramer-Rao bound
  Eigen::VectorXd degrees_of_freedom = {};  ///< effective, one for each of `coefficients`; empty: infinite
  /// Like `sigma`, for an IMU with effects and optional terms half and twice as large as expected; empty: not requested.
  Eigen::VectorXd sigma_of_half = {}, sigma_of_twice = {};
  Eigen::VectorXd remaining = {};  ///< one sigma for each of `undetermined`; empty: unknown
  /// Those of `coefficients` that the procedure does not make observable; their prior enters the uncertainty of the others.
  std::vector<CoefficientIndex> considered = {};
  std::vector<std::string> notes = {};            ///< reasons why something is not calibrated
  std::vector<std::string> warnings = {};         ///< warnings about the procedure
  std::vector<RigErrorEstimate> rig_errors = {};  ///< lever arms, delays and mounting angles of aids, at their declared values
  BodyFrame frame = BodyFrame::accelerometers;    ///< frame of the future calibration

  // Contribution of each error source, for methods that separate the sources; one row per coefficient.
  std::vector<std::string> sources = {};  ///< columns of `variance`: "orthogonality", "angle", "zero", "timing", "gravity", ...
  std::vector<TermSource> terms = {};     ///< terms among the sources
  Eigen::MatrixXd variance = {};          ///< first-order variance by source
  Eigen::VectorXd second_order = {};      ///< sigma of the second-order part
  Eigen::VectorXd bias = {};              ///< mean of the second-order part, which `calibrate` subtracts
  Eigen::VectorXd first_order() const { return variance.rowwise().sum().cwiseSqrt(); }

  std::optional<MonteCarloResult> monte_carlo = {};
  std::vector<Shortfall> missed = {};         ///< missed requirements
  std::optional<Tolerances> tolerances = {};  ///< present if there are requirements
  std::optional<Advice> advice = {};          ///< present if a requirement is missed or a coefficient is not determined
};

/// Returns, in the order of the requirements, each coefficient that exceeds its limit as in `assess` of a calibration; sigma is infinite if it is not
/// determined. Coefficients that the accelerometers' frame fixes at zero are skipped.
std::vector<Shortfall> shortfalls(const Prediction& prediction, const std::vector<Requirement>& requirements);
/// Returns each requirement with its worst coefficient.
std::vector<RequirementResult> assess(const Prediction& prediction, const std::vector<Requirement>& requirements);

/// Predicts a calibration of `procedure` by `method` (one of method_names); `options`: terms, requirements and further results. Throws Error if the
/// method has no prediction, if neither gravity nor the latitude is known, if the procedure lacks something that the method needs, or if the method
/// does not estimate a required coefficient.
Prediction predict(std::string_view method, const Session& procedure, const PredictionOptions& options = {});

}  // namespace imulab
