// Aided navigation (docs/theory/aided.md): an inertial solution corrected by receivers, wheels, a barometer and known constraints, with its
// covariance.
//
// An error-state filter forward and a Rauch-Tung-Striebel smoother backward, repeated about the smoothed trajectory; the sensors' errors, lever arms,
// delays, mounting angles and slow errors of the aids are states under their priors. The size of each source of noise is estimated from the data.
#pragma once

#include "imulab/aid.hpp"
#include "imulab/calibration.hpp"
#include "imulab/coefficient.hpp"
#include "imulab/finding.hpp"
#include "imulab/navigate.hpp"
#include "imulab/recording.hpp"
#include "imulab/session.hpp"

#include <Eigen/Core>

#include <cstddef>
#include <functional>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace imulab {

/// An estimated constant [SI] beside its standard deviation before the data. Offsets, which wander, are those in the middle of the recording.
struct AidedConstant {
  std::string name;  // "gnss.lever_arm.right", or a coefficient's "gyro.offset.x": the error of the calibrated output
  double value = 0, sigma = 0, prior = 0;
  /// The data say less than the prior.
  bool undetermined() const { return sigma > 0.7 * prior; }
};

/// What all constants of one quantity have in common.
struct ConstantQuantity {
  std::string_view names;      ///< "gnss.lever_arm.right" matches "*.lever_arm.*"
  UserUnit unit;               ///< in which people are told of it
  std::string_view manoeuvre;  ///< the motion that would determine it; empty if none does
};
/// Returns the quantity of the constant of this name.
const ConstantQuantity& quantity_of_constant(std::string_view name);
/// Groups the names of constants by the manoeuvre that would determine them; groups and names keep their order.
std::vector<std::pair<std::string_view, std::vector<std::string>>> by_manoeuvre(const std::vector<std::string>& names);

/// The size of a source of noise: its variance over the stated or declared one.
struct AidedFactor {
  std::string name;  // "gnss.position"
  double factor = 1;
  double resolved = 0;  // number of values that the data resolve
  double lasting = 1;   // errors that last: in the long run the values tell as much as with a sigma so many times larger
};

/// A withheld time: the largest horizontal error of the prediction, and the errors over their stated sigmas.
struct OutageErrors {
  double horizontal = 0, sigma = 0;  // m: the largest error, and the stated sigma then
  double vertical = 0;               // m
  double ratio = 0;                  // root mean square of the horizontal errors over their sigmas
};
struct OutageResult {
  double begin = 0, end = 0;  // s
  std::size_t fixes = 0;
  OutageErrors predicted, smoothed;  // forward from the data before; with the data on both sides
};

/// Covariance of phi [rad], velocity [m/s], position [m], east-north-up, at one time [s].
struct AidedCovariance {
  double time = 0;
  Eigen::Matrix<double, 9, 9> value;
};

/// Measured less predicted before the update, over its sigma.
struct AidedInnovation {
  double time = 0;
  std::size_t source = 0;  // among the factors
  double sigmas = 0;
  bool suspect = false;  // it is weighed by less than a third
};

struct AidedNavigation {
  Solution solution;                        // at every sample; or its first and last state
  std::size_t states = 0;                   // at every sample: their number
  std::vector<NavigationState> track;       // some thousand of them along the way, for drawings
  double distance = 0;                      // m, along the way
  std::vector<AidedCovariance> covariance;  // at the epochs; of the filter twice where it uses an aid, before and after
  std::vector<std::string> aids;            // names, with which those of their constants and factors begin: "gnss", "gnss2"
  std::vector<AidedConstant> constants;
  Eigen::MatrixXd constants_covariance;  // of all of them
  std::vector<AidedFactor> factors;
  std::vector<OutageResult> outages;
  std::vector<AidedInnovation> innovations;  // of the filter
  double innovation_rms = 0;                 // of all: 1 where the noise is as stated
  double suspects = 0;                       // part of the rows that the kernel weighs by less than a third
  int passes = 0, headings = 1;              // of the smoother; candidates at the start
  bool converged = false, causal = false;
  Findings findings;
};

struct AidedOptions {
  bool causal = false;               // the solution is that of the filter: from the data before each time alone
  std::vector<Outage> outages = {};  // withheld from the aids with a file, besides the aids' own
  int passes = 20;                   // of the smoother, at most
  bool keep = true;                  // every state in the solution; otherwise the first and the last
  /// Called at the end with every state in turn, when all else is known.
  std::function<void(const AidedNavigation& navigation, double time, const NavigationState& state)> each = {};
};

/// `recording` is raw, the aids have their records on its clock. Throws Error where no aid has an observation during the recording, or nothing gives
/// a start; as `compensate` does; and where the epochs of a long recording find no place in a temporary file (TMPDIR).
AidedNavigation navigate_aided(const Calibration& calibration, const Session& session, Recording recording, const std::vector<Aid>& aids,
                               const AidedOptions& options = {});

/// Between the epochs, linear in time, of phi, velocity, position; at an epoch after its update.
Eigen::Matrix<double, 9, 9> covariance_at(const AidedNavigation& navigation, double time);
/// Roots of its diagonal.
Eigen::Matrix<double, 9, 1> sigmas_at(const AidedNavigation& navigation, double time);

}  // namespace imulab
