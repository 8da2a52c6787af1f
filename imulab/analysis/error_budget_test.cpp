#include "imulab/analysis/error_budget.hpp"

#include "imulab/core/error.hpp"
#include "imulab/core/units.hpp"
#include "imulab/model/coefficient.hpp"
#include "imulab/navigation/flight.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

namespace imulab {
namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;
constexpr double pi = std::numbers::pi;

/// A unit that uses every term of the model, so that every way of an error is open.
SensorModel crooked_unit() {
  SensorModel m;
  m.accel.offset = {0.1, 0.2, 0.3};
  m.accel.matrix << 1, 0, 0.01, 0.03, 0.9, 0, 0, 0.02, 1.1;
  m.accel.quadratic = {1e-4, 0, 2e-4};
  m.accel.thermal.col(1).setConstant(1e-3);
  m.gyro.offset = {1e-3, 0, -1e-3};
  m.gyro.matrix(0, 1) = 0.02;
  m.gyro.cubic = {0, 1e-2, 0};
  m.gyro.thermal.col(1).setConstant(1e-5);
  m.g_sensitivity.setConstant(1e-4);
  return m;
}

ErrorSources sources_of(const std::vector<int>& coefficients) {
  ErrorSources s;
  s.coefficients = coefficients;
  s.fixed = VectorXd::Zero(static_cast<Eigen::Index>(coefficients.size()));
  s.covariance = MatrixXd::Zero(s.fixed.size(), s.fixed.size());
  return s;
}

std::vector<int> followed_coefficients() {
  std::vector<int> out;
  for (int i = 0; i < coefficient_count; ++i)
    if (coefficient_table()[static_cast<std::size_t>(i)].term != Term::lever_arm) out.push_back(i);
  return out;
}

/// The full integration, with what may err.
struct Flown {
  const NominalMotion& motion;
  const ErrorSources& sources;
  StrapdownOptions options;
  ErrorState error(const SensorModel& believed, const ErrorState& start, double barometer) const {
    Strapdown strapdown(with_error(motion.states.front(), start), options);
    for (std::size_t i = 0; i < motion.increments.size(); ++i) {
      const double T = motion.time[i + 1] - motion.time[i];
      const Motion true_motion{motion.increments[i].velocity / T, motion.increments[i].angle / T};
      const Motion c = compensate(believed, decompensate(sources.model, true_motion, sources.accel_tau, sources.gyro_tau));
      strapdown.step(Increment{c.rate * T, c.force * T}, T, motion.states[i + 1].height + barometer);
    }
    return error_of(strapdown.state(), motion.states.back());
  }
};

/// By attitude, velocity and position: the difference of two columns against the second's length.
void expect_near(const ErrorState& linear, const ErrorState& full, double tolerance, const std::string& what) {
  for (const int block : {ErrorIndex::attitude, ErrorIndex::velocity, ErrorIndex::position}) {
    const double length = full.segment<3>(block).norm();
    EXPECT_LT((linear - full).segment<3>(block).norm(), tolerance * length + 1e-9) << what << " " << block;  // 1e-9: rounding of the differences
  }
}

TEST(ErrorBudget, SensitivitiesAreTheDerivativesOfTheFullIntegration) {
  const Trajectory trajectory = flight({0.54, 1.8, 500, 80, 0}, {straight(20), turn(-60 * unit::deg, 2 * unit::deg, 4), climb(0.1, 10, 5),
                                                                 accelerate(20, 20), s_turn(0.5, 0.05, 3), straight(20)});
  const NominalMotion motion = nominal_motion(trajectory, 0.04);
  ErrorSources sources = sources_of(followed_coefficients());
  sources.model = crooked_unit();
  sources.accel_tau = {10, 5, 3};
  sources.gyro_tau = {-10, 5, 3};
  const auto n = static_cast<Eigen::Index>(sources.coefficients.size());
  for (const auto vertical : {VerticalChannel::free, VerticalChannel::fixed, VerticalChannel::aided, VerticalChannel::held}) {
    BudgetOptions options;
    options.strapdown.vertical = vertical;
    const ErrorColumns linear = error_sensitivities(motion, sources, options);
    const Flown flown{motion, sources, options.strapdown};
    const std::string channel = " of channel " + std::to_string(static_cast<int>(vertical));
    // What limits: the sensors' errors act in the middle of a block of 0.5 s, and the rolling in lasts 4 s: (0.5/4)^2/12 = 0.13 % of the change,
    // and a few times that where an effect of the rolling in and one of the rolling out nearly cancel.
    const double tolerance = 5e-3;
    for (Eigen::Index k = 0; k < n; ++k) {
      const int index = sources.coefficients[static_cast<std::size_t>(k)];
      if (vertical != VerticalChannel::free && k % 5 != 0) continue;  // for speed
      // A change that moves the end by a metre, so that what is quadratic is 1e-6 of it, and cancels in the difference of both sides.
      const double step = 0.5 / linear.col(k).segment<3>(ErrorIndex::position).norm();
      SensorModel above = sources.model, below = sources.model;
      set_coefficient(above, index, coefficient_value(above, index) + step);
      set_coefficient(below, index, coefficient_value(below, index) - step);
      const ErrorState full = (flown.error(above, ErrorState::Zero(), 0) - flown.error(below, ErrorState::Zero(), 0)) / (2 * step);
      expect_near(linear.col(k) * step, full * step, tolerance, std::string(coefficient_table()[static_cast<std::size_t>(index)].name) + channel);
    }
    const std::array<int, 9> state{6, 7, 8, 3, 4, 5, 0, 1, 2};
    for (int k = 0; k < 9; ++k) {
      ErrorState start = ErrorState::Zero();
      start[state[static_cast<std::size_t>(k)]] = k < 3 ? 10 : k < 6 ? 0.05 : 1e-5;
      const ErrorState full = (flown.error(sources.model, start, 0) - flown.error(sources.model, -start, 0)) / 2;
      if (vertical == VerticalChannel::held && k == 2) continue;  // the barometer replaces it in the first step
      // 1e-4: the motion's place and force are taken in the middle of a block. Aided: the loop corrects at the end of each step of 0.04 s, 3/100 s^-1
      // of the height. Fixed: the computed motion does not climb, so that it lacks the Coriolis acceleration of 5 m/s.
      const double start_tolerance = vertical == VerticalChannel::aided ? 2e-3 : vertical == VerticalChannel::fixed ? 5e-3 : 1e-4;
      expect_near(linear.col(n + 12 + k) * start.sum(), full, start_tolerance, "start " + std::to_string(k) + channel);
    }
    const ErrorState full = (flown.error(sources.model, ErrorState::Zero(), 5) - flown.error(sources.model, ErrorState::Zero(), -5)) / 2;
    expect_near(linear.col(n + 21) * 5, full, 2e-3, "barometer" + channel);  // as above
  }
}

}  // namespace
}  // namespace imulab
