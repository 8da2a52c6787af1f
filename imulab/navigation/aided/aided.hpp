// Aided navigation (docs/theory/aided.md): an inertial solution with covariance, corrected by receivers, wheels, a barometer and constraints.
//
// An error-state filter runs forward and a Rauch-Tung-Striebel smoother backward, repeatedly about the smoothed trajectory. The sensors' errors, and
// the lever arms, delays, mounting angles and slow errors of the aids are states under their priors. The size of each noise source is estimated from
// the data.
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

/// An estimated constant [SI] with its standard deviations after and before the data. Wandering offsets refer to the middle of the recording.
struct AidedConstant {
  std::string name;  // "gnss.lever_arm.right", or a coefficient "gyro.offset.x": error of the calibrated output
  double value = 0, sigma = 0, prior = 0;
  /// Returns true if the data are less informative than the prior.
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

/// The size of a noise source: ratio of its variance to the stated or declared variance.
struct AidedFactor {
  std::string name;  // "gnss.position"
  double factor = 1;
  double resolved = 0;  // number of values that the data resolve
  double lasting = 1;   // factor on sigma for correlated errors: in the long run, the values are as informative as with a sigma larger by it
};

/// Errors in a withheld time: the largest horizontal error of the prediction, and the errors relative to their stated sigmas.
struct OutageErrors {
  double horizontal = 0, sigma = 0;  // m: the largest error, and the stated sigma at that time
  double vertical = 0;               // m
  double ratio = 0;                  // RMS of the horizontal errors relative to their sigmas
};
struct OutageResult {
  double begin = 0, end = 0;  // s
  std::size_t fixes = 0;
  OutageErrors predicted, smoothed;  // predicted from earlier data only; smoothed with the data on both sides
};

/// Covariance of phi [rad], velocity [m/s] and position [m], east-north-up, at one time [s].
struct AidedCovariance {
  double time = 0;
  Eigen::Matrix<double, 9, 9> value;
};

/// Measured minus predicted value before the update, divided by its sigma.
struct AidedInnovation {
  double time = 0;
  std::size_t source = 0;  // index among the factors
  double sigmas = 0;
  bool suspect = false;  // its weight is below a third
};

/// Rates or forces that the smoothed solution leaves unexplained: their RMS, 1 if the noise is as large as on average, and how many the data resolve.
struct AidedResiduals {
  double rms = 0, resolved = 0;
};
/// The residuals during one kind of motion: "at rest", "straight", "turning" (above 5 deg/s) or "accelerating" (above 0.5 m/s^2).
struct MotionResiduals {
  std::string kind;
  AidedResiduals gyro, accel;
};

struct AidedNavigation {
  Solution solution;                        // at every sample, or the first and last state
  std::size_t states = 0;                   // number of states at every sample
  std::vector<NavigationState> track;       // some thousand at equal intervals, for drawings
  double distance = 0;                      // m, along the path
  std::vector<AidedCovariance> covariance;  // at the epochs; for the filter twice if it uses an aid, before and after the update
  std::vector<std::string> aids;            // names, with which the names of their constants and factors begin: "gnss", "gnss2"
  std::vector<AidedConstant> constants;
  Eigen::MatrixXd constants_covariance;  // covariance of all constants
  std::vector<AidedFactor> factors;
  std::vector<OutageResult> outages;
  std::vector<AidedInnovation> innovations;  // innovations of the filter
  std::vector<MotionResiduals> residuals;    // of every kind of motion
  double innovation_rms = 0;                 // RMS of all: 1 if the noise is as stated
  double suspects = 0;                       // fraction of the rows with a weight below a third
  int passes = 0, headings = 1;              // passes of the smoother; candidates at the start
  bool converged = false, causal = false;
  Findings findings;
};

struct AidedOptions {
  bool causal = false;               // the solution is that of the last pass's filter, from only the data before each time but for the noise factors
  std::vector<Outage> outages = {};  // withheld from aids with a file, in addition to the aids' own outages
  int passes = 20;                   // largest number of smoother passes
  bool keep = true;                  // keeps every state in the solution; otherwise the first and the last
  /// Called at the end with every state in order, after all other results are known.
  std::function<void(const AidedNavigation& navigation, double time, const NavigationState& state)> each = {};
};

/// Navigates with the raw `recording`; the aids' records must be on its clock. Throws Error if no aid has an observation during the recording, or
/// nothing determines a start; like `compensate`; and if a temporary file (TMPDIR) cannot hold the epochs of a long recording.
AidedNavigation navigate_aided(const Calibration& calibration, const Session& session, Recording recording, const std::vector<Aid>& aids,
                               const AidedOptions& options = {});

/// Returns the covariance of phi, velocity, position, linear in time between epochs; at an epoch after its update.
Eigen::Matrix<double, 9, 9> covariance_at(const AidedNavigation& navigation, double time);
/// Returns the square roots of its diagonal.
Eigen::Matrix<double, 9, 1> sigmas_at(const AidedNavigation& navigation, double time);

}  // namespace imulab
