// Predictions of a calibration before any data: uncertainties, the sources that limit them, and the errors of rig and IMU that would meet
// requirements (docs/theory/strapdown.md).
//
// Example:
//   const Session procedure = zhang_24_procedure({});
//   const Prediction p = predict("turntable", procedure, {.requirements = parse_requirements("gyro.matrix.off_diagonal <= 5 arcsec")});
//   for (const Shortfall& s : p.missed) std::printf("%s: %g\n", coefficient(s.coefficient).name.data(), s.sigma);  // SI
//   if (p.tolerances && p.tolerances->answers.back().declared.factor) std::printf("%g\n", *p.tolerances->answers.back().declared.factor);
//
// Sigmas are SI, one for each of `coefficients`, to first and second order; they equal what `calibrate` would state with data of an ideal unit.
// Coefficients that the procedure leaves open are in `undetermined`. Throws Error as `predict` says. It uses all threads, and several may run at a
// time; a Monte Carlo grows with its runs.
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

/// A requirement that is not met, by one of its coefficients.
struct Shortfall {
  Requirement requirement;
  CoefficientIndex coefficient;
  double sigma;             ///< the larger of u and U/2, SI; infinite: the procedure does not determine it
  std::string source = {};  ///< of most of its variance, where that is known; or why it meets no requirement
};

struct Sharing;  // of work among processes: the command's

/// The first two are for every method, the others for those whose row in the table takes them.
struct PredictionOptions {
  std::vector<CoefficientIndex> terms = {};    ///< as CalibrationOptions has them
  std::vector<Requirement> requirements = {};  ///< to compare with
  bool effects = true;                         ///< as CalibrationOptions has it
  bool sizes = false;                          ///< also for an IMU whose effects are half and twice as large as expected
  std::uint64_t runs = 0;                      ///< of the Monte Carlo; 0: none
  std::uint64_t seed = 1;
  bool advice = true;                                        ///< where a requirement is missed, or a coefficient is not determined
  bool classical = false;                                    ///< by the weights and the model of the paper that the method follows
  std::function<void(double)> progress = {};                 ///< called with the fraction done, 0 to 1, from any thread
  std::shared_ptr<Sharing> sharing = {};                     ///< of the Monte Carlo among processes, as the command does it; programs leave it empty
  std::stop_token stop = {};                                 ///< as CalibrationOptions has it
  std::shared_ptr<const motion::NominalMotion> motion = {};  ///< true: for a method whose procedure is a mission
};

/// Whole procedures with drawn errors, each calibrated.
struct MonteCarloResult {
  std::vector<CoefficientIndex> coefficients = {};
  std::uint64_t runs = 0;
  Eigen::VectorXd mean;            ///< of the errors
  Eigen::VectorXd sigma;           ///< root mean square error
  Eigen::VectorXd sampling_sigma;  ///< standard deviation of `sigma`, relative
};

/// A term that the IMU may have, as a source of error: the part of it that the readings do not show.
struct TermSource {
  std::string name = {};   ///< among the sources: "accel.quadratic"
  CoefficientIndex first;  ///< its coefficient of the x axis
  double prior = 0;        ///< one sigma of each of its coefficients [SI]
};

/// The source for coefficients that the procedure does not determine: they keep their starting values, and may be off by their prior.
inline constexpr const char* undetermined_source = "undetermined coefficients";

/// The groups of errors that a tolerance scales.
enum class Knob { table, timing, imu, all };
std::string_view to_string(Knob knob);

/// The scaled sizes: sigmas of the table, noise of the IMU; SI. 0: none, or known exactly.
struct ErrorSizes {
  double angle = 0, orthogonality = 0, zero = 0, timing = 0;
  double gyro_noise = 0, accel_noise = 0, gyro_turn_on = 0, accel_turn_on = 0;
};

/// The coarsest that meets the requirements.
struct Tolerance {
  std::optional<double> factor = {};       ///< times the declared size (1 arcsec, 1 ms where nothing is); absent: not even a perfect one meets them
  bool unlimited = false;                  ///< the factor is the largest that was tried
  ErrorSizes sizes;                        ///< at this factor
  std::vector<Shortfall> shortfalls = {};  ///< where none meets them: with a perfect one
};

/// The errors of table, timing and IMU that would meet the requirements.
struct Tolerances {
  ErrorSizes declared;
  bool has_turns = true;  ///< without turns their timing does not matter
  struct Answer {
    Knob knob;
    Tolerance declared;                   ///< with the other groups as declared
    std::optional<Tolerance> alone = {};  ///< with all else perfect
  };
  std::vector<Answer> answers = {};  ///< the last is of all groups together
};

/// The worst-determined direction: a combination of coefficients, each in units of its requirement (or of half its prior), and the further turns, one
/// or two of 90 or 180 deg about the table's axes at the end of the procedure, that help most.
struct Advice {
  std::vector<CoefficientIndex> coefficients = {};  ///< with a large part in it, the largest first
  double ratio = 0;                                 ///< sigma along it, in those units
  std::vector<std::string> turns = {};              ///< "turn by 180 deg about the IMU's z axis while it is horizontal"; each with a rest after it
  double ratio_after = 0;                           ///< the largest ratio with them
};

/// Predicted standard uncertainties. SI.
struct Prediction {
  std::vector<CoefficientIndex> coefficients, undetermined;
  Eigen::VectorXd sigma;                    ///< of each of `coefficients`, with the second order
  Eigen::VectorXd cramer_rao;               ///< Cramer-Rao bound
  Eigen::VectorXd degrees_of_freedom = {};  ///< effective, of each of `coefficients`; empty: infinite
  /// As sigma, of an IMU whose effects and optional terms are half and twice as large as expected; empty: not asked for.
  Eigen::VectorXd sigma_of_half = {}, sigma_of_twice = {};
  Eigen::VectorXd remaining = {};                 ///< sigma of each of `undetermined`; empty: not known
  std::vector<CoefficientIndex> considered = {};  ///< of `coefficients`: the procedure does not show them; their prior enters the others
  std::vector<std::string> notes = {};            ///< why something is not calibrated
  std::vector<std::string> warnings = {};         ///< about the procedure
  std::vector<RigErrorEstimate> rig_errors = {};  ///< lever arms, delays and mounting angles of aids, at their declared values
  BodyFrame frame = BodyFrame::accelerometers;    ///< of the calibration to come

  // The share of every error source, for methods that tell the sources apart; a row a coefficient.
  std::vector<std::string> sources = {};  ///< "orthogonality", "angle", "zero", "timing", "gravity", ...: columns of `variance`
  std::vector<TermSource> terms = {};     ///< those among them
  Eigen::MatrixXd variance = {};          ///< to first order, by source
  Eigen::VectorXd second_order = {};      ///< sigma of the second-order part
  Eigen::VectorXd bias = {};              ///< mean of the second-order part, which `calibrate` subtracts
  Eigen::VectorXd first_order() const { return variance.rowwise().sum().cwiseSqrt(); }

  std::optional<MonteCarloResult> monte_carlo = {};
  std::vector<Shortfall> missed = {};         ///< requirements
  std::optional<Tolerances> tolerances = {};  ///< where there are requirements
  std::optional<Advice> advice = {};          ///< where something is missed or not determined
};

/// In the order of the requirements: the coefficients that exceed them as in `assess` of a calibration, each once; sigma is infinite where one is not
/// determined. Those that the accelerometers' frame fixes at zero are left out.
std::vector<Shortfall> shortfalls(const Prediction& prediction, const std::vector<Requirement>& requirements);
/// Each requirement with the worst of its coefficients.
std::vector<RequirementResult> assess(const Prediction& prediction, const std::vector<Requirement>& requirements);

/// By a method's name (method_names). Throws Error where the method has no prediction, where neither gravity nor the latitude is known, where the
/// procedure lacks what the method needs, and for a requirement on a coefficient that it does not estimate.
Prediction predict(std::string_view method, const Session& procedure, const PredictionOptions& options = {});

}  // namespace imulab
