// The acceptance test every method has to pass: over many simulated sessions with known truth, are the errors as small as the data allow, and do
// they agree with the stated covariance?
#pragma once

#include "imulab/calibration.hpp"
#include "imulab/coefficient.hpp"
#include "imulab/estimate/method.hpp"
#include "imulab/estimate/turntable/estimator.hpp"
#include "imulab/simulate.hpp"

#include <Eigen/Core>

#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace imulab::acceptance {

/// One simulated session: the errors of the estimate, what it stated, and the Fisher information of the session.
struct Run {
  std::vector<CoefficientIndex> indices;  ///< table indices of the m coefficients
  Eigen::VectorXd error;
  Eigen::MatrixXd covariance;
  Eigen::MatrixXd information;
  void fields(auto&& visit) { visit(indices, error, covariance, information); }
};

struct Check {
  std::string name;
  double value, low, high;
  bool passed() const { return value >= low && value <= high; }
};

/// efficiency: mean of e^T F e / m at most 1.1025 (1.05 in RMS)
/// consistency: mean of e^T P^-1 e / m inside the 99.9 % chi-square band
/// coverage: by term, the fraction of whitened components within 1.96 inside the 99.9 % binomial band
/// worst coefficient: RMS over its bound below sqrt(chi2_N(1 - 0.001 / m) / N)
std::vector<Check> judge(const std::vector<Run>& runs);

/// A simulated and calibrated session, from a seed alone: poses, IMU, gravity and noise are all drawn.
Run handheld_run(std::uint64_t seed);
Run static_run(std::uint64_t seed);
/// Zhang's procedure on tables of 2 arcsec and of 1 arcmin, whose errors are drawn as well.
Run arcsecond_table_run(std::uint64_t seed);
Run arcminute_table_run(std::uint64_t seed);
/// Cheng's path for 25 min on tables of 2 arcsec, 1 arcmin and 1 deg; and a short one at 20 Hz.
Run hybrid_arcsecond_run(std::uint64_t seed);
Run hybrid_arcminute_run(std::uint64_t seed);
Run hybrid_degree_run(std::uint64_t seed);
Run short_hybrid_run(std::uint64_t seed);

/// Dai's procedure: points of 10 s, and short ones of 1 s.
Run whole_unit_run(std::uint64_t seed);
Run short_whole_unit_run(std::uint64_t seed);
/// Compensated samples anywhere in the range against the covariance propagated to them, and the stepwise estimate's RMS errors over the joint one's.
std::vector<Check> whole_unit_outputs(int runs);

/// Drawn fleets of 60 units with three calibrations each, through a store: coverage of spread, drift and station bias; rates of outliers.
std::vector<Check> fleets(int count);
/// Fleets of 86 units whose sessions by hand are simulated, written and calibrated as the documentation does: a unit 0.5 g off is named, and what
/// only the prior sets is left out.
std::vector<Check> fleets_by_hand(int count);

/// The runs of the acceptance test for a method. Every method of the table has at least one.
struct Case {
  std::string_view method, name;
  Run (*run)(std::uint64_t seed);
  int count;  ///< of sessions at full size
};
std::span<const Case> cases();

/// A method with its defaults on IMUs and data that are not ideal: coverage within 93 to 97 % and consistency within the chi-square band, apart for
/// the sessions with the verdict good and the others. Prints the sessions that a method refuses.
std::vector<Check> misspecified(const Method& method, int sessions);

/// A method's prediction of a short procedure, against what it states of simulated sessions of it (seeds 1 .. sessions), and against the scatter of
/// the estimates.
std::vector<Check> predictions(const Method& method, int sessions);

/// The rows of the table in docs/start/choose.md against what is predicted now; prints those that differ.
std::vector<Check> procedures();

/// Noise coefficients of simulated logs (seeds 1 .. logs) against their truth and the Cramer-Rao bound of the spectrum's likelihood.
std::vector<Check> noise_logs(int logs);
/// In which share of logs (seeds 1 .. logs) of some lengths the random walk is determined beside flicker, and how well.
std::vector<Check> noise_lengths(int logs);
/// Thermal terms of MEMS units that warm up in a hand (seeds 1 .. sessions), by thermometers that are 0, 10 and 20 s late.
std::vector<Check> sweeps(int sessions);
/// Filters with bounded noise: coverage, and stated over true standard deviations, beside N and K alone, the best fit and ten times.
std::vector<Check> noise_bounds(int units);

/// The options of a turntable session whose readings have this white noise.
Eigen::MatrixXd turntable_information(const TableMotion& motion, const SensorModel& truth, const turntable::RawNoise& noise,
                                      const std::vector<CoefficientIndex>& indices);

/// Runs of seeds 1 .. count, kept under the name where runs are kept.
std::vector<Run> run_all(Run (*run)(std::uint64_t), int count, const std::string& name = "runs");

/// Navigation errors: sigma of the position over the linear one, of this many Monte Carlo runs through a traffic pattern and an hour's drive.
std::vector<Check> error_growth(int runs);

/// Pure-inertial rates of one drive [nmi/h] with calibrations of the same IMU; exact: its own coefficients.
struct DriveRun {
  double classical_good, classical_poor, hybrid, exact;
  void fields(auto&& visit) { visit(classical_good, classical_poor, hybrid, exact); }
};
/// IMUs, tables, noise and drives of seeds 1 .. runs.
std::vector<DriveRun> drives(int runs);
/// The first seven, and the RMS of all.
std::string describe(const std::vector<DriveRun>& runs);

/// Aided navigation and the method drive on drawn drives (city with stops, motorway) and half as many flights (hover, fixed wing): MEMS and tactical
/// grade, receivers of 1 and 10 Hz whose stated sigma is a third, one and three times the true one, lever arm, delay, and a mounting up to 30 deg.
/// Of those that are good: coverage of what is stated, and NEES of a position.
/// `effects`: of every one that the table has, drawn and estimated.
std::vector<Check> aided_runs(int runs, bool effects = false);
/// Its constants on one flight: RMS errors at most 1.1 times the Cramer-Rao bound.
std::vector<Check> aided_bound(int runs);

/// Position errors at the end of a flight, east-north-up [m], one per row of the table that describe_flights makes.
using FlightRun = std::vector<Eigen::Vector3d>;
/// IMUs, calibrations and noise of seeds 1 .. runs on docs/evidence/papers/dai2011/flight.toml, and on the same without its roll.
struct DaiFlights {
  std::vector<FlightRun> with_roll, without_roll;
};
DaiFlights dai_flights(int runs);
/// In median: the error of traditional compensation is at least ten times that of whole-unit compensation, and the latter equals that of the exact
/// coefficients.
std::vector<Check> judge_flights(const std::vector<FlightRun>& runs);
std::string describe_flights(const std::vector<FlightRun>& runs);

/// The checks as lines of text.
std::string describe(const std::vector<Check>& checks);

}  // namespace imulab::acceptance
