// Errors of aided navigation's constants over their Cramer-Rao bound. The bound shares no code with the filter: readings of an ideal IMU are
// integrated once for every parameter that is moved a little, and once for every shove by the sensors' noise; the receiver's errors, correlated in
// time, are one covariance of all fixes.
#include "imulab/coefficient.hpp"
#include "imulab/core/decomposition.hpp"
#include "imulab/core/rotation.hpp"
#include "imulab/core/statistics.hpp"
#include "imulab/estimate/drive/coefficients.hpp"
#include "imulab/navigation/aided/setup.hpp"
#include "imulab/navigation/budget/error_dynamics.hpp"
#include "imulab/navigation/motion/flight.hpp"
#include "imulab/simulate/simulate_aid.hpp"
#include "imulab/simulate/simulate_motion.hpp"
#include "imulab/units.hpp"

#include <Eigen/Cholesky>
#include <fmt/format.h>

#include "tests/acceptance/acceptance.hpp"
#include "tests/acceptance/shared_runs.hpp"
#include <cmath>
#include <functional>
#include <map>
#include <string>
#include <vector>

namespace imulab::acceptance {

namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::Vector3d;
using Eigen::VectorXd;

constexpr double step_s = 0.02, fix_s = 1, shove_s = 0.5;
constexpr double place_sigma = 1.5, speed_sigma = 0.05, memory_s = 60, white_part = 0.1;  // as simulate_aid has them
constexpr double gyro_N = 0.3 * unit::deg_per_sqrt_h, accel_N = 150 * unit::ug_per_sqrt_hz;

motion::Trajectory bound_flight() {
  using namespace motion;
  std::vector<Segment> parts{straight(3)};
  for (int k = 0; k < 4; ++k)
    parts.insert(parts.end(), {turn((k % 2 == 0 ? 200 : -200) * unit::deg, 0.3, 1.5), climb((k % 2 == 0 ? 10 : -10) * unit::deg, 3, 2),
                               accelerate(k % 2 == 0 ? 6 : -6, 4)});
  return flight({48 * unit::deg, 0.2, 500, 25, 1}, parts);
}

/// What the constants do to the readings of an ideal IMU.
struct Moved {
  Vector3d gyro = Vector3d::Zero(), accel = Vector3d::Zero();  // offsets
  Eigen::Matrix3d Mg = Eigen::Matrix3d::Zero(), Ma = Eigen::Matrix3d::Zero(), G = Eigen::Matrix3d::Zero();
  Vector3d lever{0.3, 0.5, 1};
};

/// Places and velocities of the antenna at the fixes, and those of the IMU one sample either way.
struct Reference {
  std::vector<Increment> ideal;
  std::vector<NavigationState> states;  // before each sample, and after the last
  std::size_t every = static_cast<std::size_t>(fix_s / step_s);

  /// The antenna at all fixes less the reference, from sample `first` on at this state. `late`: samples.
  VectorXd antenna(const Moved& m, std::size_t first, const NavigationState& start, int late = 0) const {
    const std::size_t fixes = ideal.size() / every;
    VectorXd out = VectorXd::Zero(static_cast<Index>(6 * fixes));
    Strapdown strapdown(start, {});
    for (std::size_t i = first; i < ideal.size(); ++i) {
      const Increment& s = ideal[i];
      const Increment moved{s.angle + step_s * m.gyro + m.Mg * s.angle + m.G * s.velocity, s.velocity + step_s * m.accel + m.Ma * s.velocity};
      strapdown.step(moved, step_s);
      const std::size_t at = i + 1 + static_cast<std::size_t>(late);
      if (at % every != 0 || at / every == 0 || at / every > fixes) continue;
      const NavigationState &now = strapdown.state(), &then = states[at];
      const budget::ErrorState error = budget::error_of(now, then);
      const Eigen::Matrix3d C = now.q_nb.toRotationMatrix();
      const auto row = static_cast<Index>(6 * (at / every - 1));
      out.segment<3>(row) = error.segment<3>(budget::ErrorIndex::position) + C * m.lever;
      out.segment<3>(row + 3) = error.segment<3>(budget::ErrorIndex::velocity) + C * (moved.angle / step_s).cross(m.lever);
    }
    return out;
  }
};

NavigationState shoved(NavigationState s, Index k, double by) {
  const Vector3d e = by * Vector3d::Unit(k % 3);
  if (k < 3) s.q_nb = s.q_nb * Eigen::Quaterniond(rotation_exp(e));
  if (k >= 3 && k < 6) s.velocity += s.q_nb * e;
  if (k < 6) return s;
  budget::ErrorState error = budget::ErrorState::Zero();
  error.segment<3>(budget::ErrorIndex::position) = e;
  return budget::with_error(s, error);
}

/// All noise of the fixes: of the receiver, and what the sensors' noise makes of the motion.
MatrixXd noise_of(const Reference& reference) {
  const std::size_t fixes = reference.ideal.size() / reference.every, bin = static_cast<std::size_t>(shove_s / step_s);
  MatrixXd out = MatrixXd::Zero(static_cast<Index>(6 * fixes), static_cast<Index>(6 * fixes));
  for (Index a = 0; a < static_cast<Index>(fixes); ++a)
    for (Index b = 0; b < static_cast<Index>(fixes); ++b)
      for (Index axis = 0; axis < 3; ++axis) {
        const double slow = (1 - white_part) * std::exp(-fix_s * std::abs(static_cast<double>(a - b)) / memory_s);
        out(6 * a + axis, 6 * b + axis) = place_sigma * place_sigma * (slow + (a == b ? white_part : 0));
        if (a == b) out(6 * a + 3 + axis, 6 * a + 3 + axis) = speed_sigma * speed_sigma;
      }
  std::vector<VectorXd> columns;
  for (std::size_t i = bin / 2; i < reference.ideal.size(); i += bin)
    for (Index k = 0; k < 6; ++k) {
      constexpr double by = 1e-4;
      const double size = (k < 3 ? gyro_N : accel_N) * std::sqrt(shove_s);
      columns.push_back(
          size / (2 * by) *
          (reference.antenna({}, i, shoved(reference.states[i], k, by)) - reference.antenna({}, i, shoved(reference.states[i], k, -by))));
    }
  for (const VectorXd& column : columns) out.selfadjointView<Eigen::Lower>().rankUpdate(column);
  return out.selfadjointView<Eigen::Lower>();
}

/// A constant's place in Moved; null for those of another kind.
double* place_of_constant(const std::string& name, Moved& m) {
  constexpr std::array<const char*, 3> axes{"x", "y", "z"}, body{"right", "forward", "up"};
  for (Index i = 0; i < 3; ++i) {
    const auto at = static_cast<std::size_t>(i);
    if (name == fmt::format("gyro.offset.{}", axes[at])) return &m.gyro[i];
    if (name == fmt::format("accel.offset.{}", axes[at])) return &m.accel[i];
    if (name == fmt::format("gnss.lever_arm.{}", body[at])) return &m.lever[i];
    for (Index j = 0; j < 3; ++j) {
      const std::string element = fmt::format("{}{}", axes[at], axes[static_cast<std::size_t>(j)]);
      if (name == "gyro.matrix." + element) return &m.Mg(i, j);
      if (name == "accel.matrix." + element) return &m.Ma(i, j);
      if (name == "gyro.g_sensitivity." + element) return &m.G(i, j);
    }
  }
  return nullptr;
}

/// Standard deviations at the bound of constants with these names and priors.
std::map<std::string, double> bound_of(const std::vector<AidedConstant>& constants) {
  const motion::Trajectory flown = bound_flight();
  Reference reference{.ideal = motion::ideal_increments(flown, step_s), .states = {motion::navigation_state(flown.at(0))}};
  Strapdown strapdown(reference.states.front(), {});
  for (const Increment& sample : reference.ideal) strapdown.step(sample, step_s), reference.states.push_back(strapdown.state());
  std::vector<VectorXd> columns;
  std::vector<double> priors;
  std::vector<std::string> names;
  const auto add = [&](const std::string& name, double prior, double by, const std::function<VectorXd(double)>& moved) {
    columns.push_back((moved(by) - moved(-by)) / (2 * by)), priors.push_back(prior), names.push_back(name);
  };
  const NavigationState& start = reference.states.front();
  for (Index k = 0; k < 9; ++k)
    add("start",
        k < 2   ? 5 * unit::deg
        : k < 3 ? 30 * unit::deg
        : k < 6 ? 2
                : 30,
        k < 6 ? 1e-4 : 0.1, [&](double by) { return reference.antenna({}, 0, shoved(start, k, by)); });
  for (const AidedConstant& c : constants) {
    Moved probe;
    if (place_of_constant(c.name, probe))
      add(c.name, c.prior, 1e-2 * c.prior, [&](double by) {
        Moved m;
        *place_of_constant(c.name, m) += by;
        return reference.antenna(m, 0, start);
      });
    if (c.name != "gnss.delay") continue;
    // Later by one sample: the reference of the fix, met one sample before or after.
    const VectorXd rate = (reference.antenna({}, 0, start, 1) - reference.antenna({}, 0, start, -1)) / (2 * step_s);
    VectorXd drift = rate;
    for (Index k = 0; k < drift.size(); ++k) drift[k] *= fix_s * static_cast<double>(k / 6 + 1) - flown.duration / 2;
    columns.push_back(rate), priors.push_back(c.prior), names.push_back(c.name);
    columns.push_back(drift), priors.push_back(300e-6), names.push_back("drift");
  }
  MatrixXd J(columns.front().size(), std::ssize(columns));
  for (Index k = 0; k < J.cols(); ++k) J.col(k) = priors[static_cast<std::size_t>(k)] * columns[static_cast<std::size_t>(k)];  // in priors
  const MatrixXd information = MatrixXd::Identity(J.cols(), J.cols()) + J.transpose() * noise_of(reference).llt().solve(J);
  const VectorXd variance = information.llt().solve(MatrixXd::Identity(J.cols(), J.cols())).diagonal();
  std::map<std::string, double> out;
  for (std::size_t k = 0; k < names.size(); ++k) out[names[k]] = priors[k] * std::sqrt(variance[static_cast<Index>(k)]);
  return out;
}

struct BoundRun {
  std::vector<double> error, stated, prior;
  std::vector<std::string> name;
  void fields(auto&& visit) { visit(error, stated, prior, name); }
};

BoundRun bound_run(std::uint64_t seed) {
  const motion::Trajectory flown = bound_flight();
  Session session;
  session.site.latitude = 48 * unit::deg, session.site.longitude = 0.2, session.site.height = 500;
  session.imu.grade = "mems";
  session.imu.gyro_noise = NoiseModel{.N = gyro_N, .K = 1e-9}, session.imu.accel_noise = NoiseModel{.N = accel_N, .K = 1e-9};
  const Truth unit = draw_truth(session, seed);
  const SimulatedAid receiver = simulate_aid({.lever_arm = Vector3d(0.3, 0.5, 1),
                                              .lever_arm_sigma = 0.5,
                                              .delay_sigma = 0.05,
                                              .position_sigma = place_sigma,
                                              .velocity_sigma = speed_sigma,
                                              .correlation = memory_s},
                                             0, flown, seed);
  session.aids = {receiver.aid};
  const Recording recording = simulate_motion(motion::ideal_increments(flown, step_s), step_s, unit, seed);
  const AidedNavigation n = aided::navigate_under(drive::unit_priors(session.imu, drive::drive_coefficients()), session, recording, session.aids, {});
  // The model's coefficients as errors of the readings: w = W0 + W1 V + C a with a = A0 + A1 V.
  SensorModel errors = unit.model;
  errors.gyro.offset += unit.model.g_sensitivity * unit.model.accel.offset;
  errors.g_sensitivity = unit.model.g_sensitivity * unit.model.accel.matrix;
  Moved truth{.gyro = errors.gyro.offset,
              .accel = errors.accel.offset,
              .Mg = errors.gyro.matrix - Eigen::Matrix3d::Identity(),
              .Ma = errors.accel.matrix - Eigen::Matrix3d::Identity(),
              .G = errors.g_sensitivity,
              .lever = receiver.lever_arm};
  BoundRun out;
  for (const AidedConstant& c : n.constants) {
    const double* exact = c.name == "gnss.delay" ? &receiver.delay : place_of_constant(c.name, truth);
    if (exact == nullptr) continue;
    out.error.push_back(c.value - *exact), out.stated.push_back(c.sigma), out.prior.push_back(c.prior), out.name.push_back(c.name);
  }
  return out;
}

}  // namespace

std::vector<Check> aided_bound(int count) {
  const auto runs = runs_of<BoundRun>("aided-bound", count, [&](std::size_t i) { return bound_run(i + 1); });
  std::vector<AidedConstant> constants;
  for (std::size_t k = 0; k < runs.front().name.size(); ++k) constants.push_back({runs.front().name[k], 0, 0, runs.front().prior[k]});
  const std::map<std::string, double> bound = bound_of(constants);
  double squares = 0, stated = 0, determined = 0, worst = 0;
  std::string which;
  for (std::size_t k = 0; k < constants.size(); ++k) {
    const double at_best = bound.at(constants[k].name);
    if (at_best > 0.7 * constants[k].prior) continue;
    double mean = 0, mean_stated = 0;
    for (const BoundRun& r : runs) mean += std::pow(r.error[k] / at_best, 2) / count, mean_stated += std::pow(r.stated[k] / at_best, 2) / count;
    if (tells())
      fmt::print("  {:<24} bound {:.3g}, errors {:.3f} and stated {:.3f} times that\n", constants[k].name, at_best, std::sqrt(mean),
                 std::sqrt(mean_stated));
    squares += mean, stated += mean_stated, determined += 1;
    if (mean > worst) worst = mean, which = constants[k].name;
  }
  const double sessions = count;
  return {{"determined constants", determined, 1, INFINITY},
          {"errors over the bound, RMS", std::sqrt(squares / determined), 0, 1.1},
          {"stated over the bound, RMS", std::sqrt(stated / determined), 0.95, 1.1},
          {"worst constant " + which, std::sqrt(worst), 0, 1.1 * std::sqrt(chi_square_quantile(1 - 0.001 / determined, sessions) / sessions)}};
}

}  // namespace imulab::acceptance
