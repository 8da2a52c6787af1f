// Terms other than offsets and matrices are also constants of the sensors' output.
#include "imulab/core/rotation.hpp"
#include "imulab/navigation/aided/foreseen.hpp"
#include "imulab/navigation/aided/observation.hpp"
#include "imulab/navigation/aided/transition.hpp"
#include "imulab/navigation/motion/flight.hpp"
#include "imulab/units.hpp"

#include <gtest/gtest.h>

namespace imulab::aided {
namespace {

/// A turn, and a problem with a term in each triad.
struct WithTerms {
  motion::NominalMotion motion = motion::nominal_motion(
      motion::flight({48 * unit::deg, 0.2, 500, 0, 0}, {motion::accelerate(10, 5), motion::turn(90 * unit::deg, 0.3, 1)}, {.banks = false}), 0.02);
  Session session;
  Recording recording = ideal_readings(motion);
  OutputTerms terms{.names = {"of rate", "of force"}, .sigma = Eigen::Vector2d(1e-3, 1e-2), .at = [](double, const TimedIncrement& s, auto changes) {
                      changes.setZero();
                      for (Eigen::Index k = 0; k < 3; ++k)
                        changes(k, 0) = std::abs(s.increment.angle[k] / s.interval),
                                   changes(3 + k, 1) = std::pow(s.increment.velocity[k] / s.interval, 2);
                    }};
  Problem problem = make_problem(recording, sensor_priors({}, {}), {Aid{.kind = AidKind::vehicle}}, session);

  WithTerms() {
    problem.terms = &terms;
    problem.terms_first = add_block(problem, {.name = "terms", .size = 2, .prior = terms.sigma, .walk = {}, .noise = {}});
    problem.sensors_end = problem.size;
  }
  /// Returns the result of `use` for the problem with a term added to the readings.
  auto moved(Eigen::Index term, double c, auto use) const {
    Recording readings = recording;
    Eigen::Matrix<double, 6, Eigen::Dynamic> changes(6, 2);
    for (std::size_t i = 0; i < readings.size(); ++i) {
      terms.at(0, problem.samples[i], changes);
      for (Eigen::Index k = 0; k < 3; ++k) {
        readings.gyro[static_cast<std::size_t>(k)][i] += c * changes(k, term);
        readings.accel[static_cast<std::size_t>(k)][i] += c * changes(3 + k, term);
      }
    }
    Problem out = problem;
    out.samples = IncrementView(readings);
    return use(out);
  }
};

TEST(AidedTerms, MoveTheMotionAsTheirReadingsDo) {
  const WithTerms w;
  const std::size_t begin = 150, end = 400;  // 5 s of the turn
  const FullState start{w.motion.states[begin], Eigen::VectorXd::Zero(w.problem.size)};
  const Transition t = integrate(w.problem, begin, end, start, true).transition;
  const double size[] = {1e-4, 1e-5};
  for (const Eigen::Index term : {0, 1}) {
    const double c = size[term];
    const auto reached = [&](double x) { return w.moved(term, x, [&](const Problem& p) { return integrate(p, begin, end, start, false).end; }); };
    const Eigen::Matrix<double, 9, 1> difference = minus(reached(c), reached(-c)) / (2 * c), column = t.motion.col(w.problem.terms_first + term);
    ASSERT_GT(difference.norm(), 1);
    // The transition treats samples to first order: 2e-3 of the motion in 20 ms.
    EXPECT_LT((column - difference).norm(), 2e-3 * difference.norm()) << "term " << term;
  }
}

TEST(AidedTerms, AreInTheRateOfARest) {
  const WithTerms w;
  Channel rest{.name = "zero_velocity", .aid = {.kind = AidKind::zero_velocity}};
  const Observation now{.stamp = 5, .channel = 0};
  const FullState state{w.motion.states[400], Eigen::VectorXd::Zero(w.problem.size)};
  const auto rows_of = [&](const Problem& p) { return aid_law(AidKind::zero_velocity).observe(p, rest, now, instant_at(p, 400, state)); };
  const auto residual = [&](double c) { return w.moved(0, c, [&](const Problem& p) { return rows_of(p).residual; }); };
  const ObservedRows rows = rows_of(w.problem);
  const Eigen::VectorXd difference = -(residual(1e-4) - residual(-1e-4)) / 2e-4;
  EXPECT_LT((rows.derivative.col(w.problem.terms_first) - difference).norm(), 0.01 * difference.norm());  // the row's rate is a mean over 0.1 s
}

}  // namespace
}  // namespace imulab::aided
