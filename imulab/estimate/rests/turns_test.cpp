// Turns with declared angles in the handheld method: a hand turns a box by 360 deg, each angle known to 1 deg.
#include "imulab/estimate/rests/turns.hpp"

#include "imulab/coefficient.hpp"
#include "imulab/core/random.hpp"
#include "imulab/core/rotation.hpp"
#include "imulab/error.hpp"
#include "imulab/estimate/rests/rests.hpp"
#include "imulab/model/effects.hpp"
#include "imulab/rig/rig_errors.hpp"
#include "imulab/units.hpp"

#include <gmock/gmock.h>

#include "tests/calibration_input.hpp"
#include "tests/simulated_session.hpp"
#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <span>
#include <stdexcept>

namespace imulab::rests {
namespace {

using testing::Contains;
using testing::HasSubstr;

SimulatedSession simulated(const Session& session, std::uint64_t seed, bool orthogonal = false) {
  SimulatedSession s;
  s.session = session;
  s.truth = draw_truth(session, seed);
  if (orthogonal)
    for (TriadModel* triad : {&s.truth.model.accel, &s.truth.model.gyro}) triad->matrix = triad->matrix.diagonal().asDiagonal().toDenseMatrix();
  s.recording = simulate_recording(session, session.recordings.front(), s.truth, seed);
  s.recording.name = session.recordings.front().file;
  return s;
}

/// Simulates a session by hand with a box, with random errors of the box and the turns.
SimulatedSession ferraris(std::uint64_t seed) { return simulated(ferraris_procedure(ferraris_options()), seed); }

/// The axes are exactly vertical, a box on a level table: gravity does not determine the angle. Only the turns have errors.
SimulatedSession upright(std::uint64_t seed, bool orthogonal) {
  const Session declared = ferraris_procedure(ferraris_options());
  Session done = declared;
  RigDeclaration& rig = done.rigs.front();
  rig.angle = rig.orthogonality = rig.zero = {};
  const RandomStream draws(seed, "angles of the turns");
  for (std::size_t k = 0; k < done.steps.size(); ++k)
    if (Step& step = done.steps[k]; step.kind == StepKind::rotate) {
      const double error = std::numbers::sqrt2 * unit::deg * draws.normal(k);
      step.angle += error, step.rate *= 1.1, done.steps[k + 1].angles[0] += error;
    }
  SimulatedSession s = simulated(done, seed, orthogonal);
  s.session = declared;
  return s;
}

Calibration calibrated(const SimulatedSession& s) { return calibrate("handheld", input_of(s.session, s.recording), {}).calibration; }

std::string error_of(const SimulatedSession& s) {
  try {
    calibrated(s);
  } catch (const Error& e) {
    return e.what();
  }
  return "no error";
}

Step& turn(SimulatedSession& s, std::size_t which) {
  for (Step& step : s.session.steps)
    if (step.kind == StepKind::rotate && which-- == 0) return step;
  throw std::logic_error("no such turn");
}

/// Removes samples between the faces, so that only the turns determine the gyro scales.
void lose_the_moves(SimulatedSession& s) {
  for (std::size_t k = 0; k + 1 < s.session.steps.size(); ++k) {
    const double end = s.session.steps[k].end, next = s.session.steps[k + 1].start;
    if (next > end) s.recording.gaps.push_back(s.recording.samples_in(end, 0.5 * (end + next)).end);
  }
}

TEST(DeclaredTurns, HaveTheirAxisInTheBody) {
  const Session session = ferraris_procedure(ferraris_options());
  const std::vector<DeclaredTurn> turns = declared_turns(session, session.recordings.front());
  ASSERT_EQ(turns.size(), 3u);
  for (std::size_t k = 0; k < 3; ++k) {
    EXPECT_LT((turns[k].axis_b - Vector3d::Unit(static_cast<Eigen::Index>(k))).norm(), 1e-12) << k << ": that face is up";
    EXPECT_DOUBLE_EQ(turns[k].angle, 2 * std::numbers::pi);
    EXPECT_NEAR(turns[k].angle_sigma(), std::numbers::sqrt2 * unit::deg, 1e-3 * unit::deg + 1e-4) << "both ends, and a little of second order";
  }
  Session hand = session;
  hand.rigs.front().kind = RigKind::none;
  EXPECT_EQ(declared_turns(hand, hand.recordings.front()).size(), 3u);
  hand.rigs.front().angle = {};
  EXPECT_TRUE(declared_turns(hand, hand.recordings.front()).empty()) << "a hand that does not say how well it turns";
}

TEST(DeclaredTurns, WholeTurnsCount) {
  const DeclaredTurn turn{0, 1, RigAxis::outer, Vector3d::UnitZ(), 4 * std::numbers::pi, 1 * unit::deg, false};
  for (const double by : {-100.0, -3.0, 0.0, 3.0, 200.0, 720.0}) {
    const Vector3d swept(0, 0, turn.angle + by * unit::deg);
    EXPECT_NEAR(angle_beyond(turn, rotation_exp(swept), 1.02 * swept), by * unit::deg, 1e-9) << "a scale error of 2 % does not miscount";
  }
}

TEST(DeclaredTurns, GiveTheScalesToTheirAngles) {
  // 1 deg at both ends of 360 deg is 0.39 %. The mean square of the scale errors over their uncertainties is 1: for 120 errors it is between 0.61 and
  // 1.46 with p = 0.999, and up to 1.15 times as large if axes that are not orthogonal seem to tilt a box that turns exactly about up (measured on
  // 400).
  CalibrationOptions options;
  options.terms = select_each({"accel.offset", "accel.matrix", "gyro.offset", "gyro.matrix", "gyro.g_sensitivity"});
  double squares = 0;
  for (std::uint64_t seed = 1; seed <= 40; ++seed) {
    SimulatedSession s = upright(seed, seed % 2 == 0);
    lose_the_moves(s);
    const Calibration c = calibrate("handheld", input_of(s.session, s.recording), options).calibration;
    for (const CoefficientIndex index : select_coefficients("gyro.matrix.diagonal")) {
      const auto sigma = standard_uncertainty(c, index);
      ASSERT_TRUE(sigma) << seed;
      EXPECT_LT(*sigma, 4.1e-3) << seed << ": of a scale up to 3 % from 1";
      EXPECT_GT(*sigma, 3.3e-3) << seed << ": gravity says a little where the gyros' axes are tilted";
      squares += std::pow((coefficient_value(c.model, index) - coefficient_value(s.truth.model, index)) / *sigma, 2);
    }
  }
  EXPECT_GT(squares / 120, 0.61);
  EXPECT_LT(squares / 120, 1.15 * 1.46);
}

TEST(DeclaredTurns, AgreeWithTheRotationsBetweenTheFaces) {
  double squares = 0, count = 0;
  for (std::uint64_t seed = 1; seed <= 30; ++seed) {
    const SimulatedSession s = ferraris(seed);
    const Calibration c = calibrated(s);
    EXPECT_THAT(c.quality.findings.notes(), Contains(HasSubstr("3 of 3 turns were used with their declared angle, each with u = 1.4 deg"))) << seed;
    EXPECT_LT(largest_sigmas(c, s.truth.model), 5) << seed << ": 1200 coefficients in all";
    for (const CoefficientIndex index : c.estimated) {
      if (is_optional(coefficient(index).term)) continue;
      squares += std::pow((coefficient_value(c.model, index) - coefficient_value(s.truth.model, index)) / *standard_uncertainty(c, index), 2);
      ++count;
    }
  }
  EXPECT_GT(count, 30 * 15) << "two thirds of the coefficients that every IMU has";
  EXPECT_LT(squares / count, 1.4) << "correlated by about three, as 200: above it once in a thousand";
}

TEST(DeclaredTurns, ThatWereNotDoneAreRefused) {
  SimulatedSession s = ferraris(1);
  EXPECT_EQ(error_of(s), "no error");
  turn(s, 1).angle = 90 * unit::deg;
  EXPECT_THAT(error_of(s), HasSubstr("is declared as 90 deg about +y (outer), but the gyros turned by 36"));
  turn(s, 1).angle = -360 * unit::deg;
  EXPECT_THAT(error_of(s), HasSubstr("is declared as -360 deg about +y (outer), but the gyros turned by 36"));
  turn(s, 1).angle = 720 * unit::deg;
  EXPECT_THAT(error_of(s), HasSubstr("is declared as 720 deg about +y (outer), but the gyros turned by 36"));
  s = ferraris(1);
  turn(s, 2).axis = RigAxis::inner;
  EXPECT_THAT(error_of(s), testing::AllOf(HasSubstr("is declared as 360 deg about +x (inner), but the gyros turned by 36"), HasSubstr("about +z")));
  s = ferraris(1);
  for (auto& column : s.recording.gyro)  // removes the turn from the data
    for (const Range r = s.recording.samples_in(turn(s, 0).start, turn(s, 0).end); double& v : std::span(column).subspan(r.begin, r.size()))
      v = column[0];
  EXPECT_THAT(error_of(s), HasSubstr("but the gyros show none"));
}

TEST(DeclaredTurns, OffByMoreThanDeclaredAreDoubtful) {
  SimulatedSession s = ferraris(2);
  EXPECT_EQ(calibrated(s).quality.verdict, Verdict::good) << verdict_text(calibrated(s).quality);
  turn(s, 0).angle = 345 * unit::deg;  // eleven sigmas; the rotations between the faces determine the scale to a tenth of that
  const Calibration c = calibrated(s);
  EXPECT_THAT(verdict_text(c.quality), HasSubstr("a turn does not fit its declared angle"));
  EXPECT_THAT(c.quality.findings.warnings(), Contains(HasSubstr("dropped as an outlier: the rotation between")));
}

TEST(DeclaredTurns, WithoutASigmaAreNotUsed) {
  SimulatedSession s = ferraris(3);
  s.session.rigs.front().kind = RigKind::none, s.session.rigs.front().angle = {};
  EXPECT_THAT(calibrated(s).quality.findings.warnings(), Contains(HasSubstr("turns are declared, but not how well their angles are known")));
}

TEST(DeclaredTurns, NeedARestBeforeAndAfter) {
  SimulatedSession s = ferraris(3);
  std::vector<Step>& steps = s.session.steps;
  const auto first = std::find_if(steps.begin(), steps.end(), [](const Step& step) { return step.kind == StepKind::rotate; });
  steps.erase(first + 1);  // the hand continues to the next face
  const Calibration c = calibrated(s);
  EXPECT_THAT(c.quality.findings.notes(), Contains(HasSubstr("2 of 3 turns were used"))) << "its angle is not that of the whole rotation";
  EXPECT_LT(largest_sigmas(c, s.truth.model), 5);
  s = ferraris(3);
  s.recording.gaps = {s.recording.samples_in(turn(s, 0).start + 1, turn(s, 0).end).begin};
  EXPECT_THAT(calibrated(s).quality.findings.warnings(),
              Contains(HasSubstr("1 of 3 turns have no rest of their own before and after them, or a gap")));
}

TEST(DeclaredTurns, RestsAreFoundWhereNoneIsDeclared) {
  // A hand turns the box by half a turn, takes a new grip, and turns on. Only the turns are declared.
  Session session = ferraris_procedure(ferraris_options());
  std::vector<Step> steps, turns;
  double late = 0;
  for (Step step : session.steps) {
    step.start += late, step.end += late;
    if (step.kind != StepKind::rotate) {
      steps.push_back(step);
      continue;
    }
    Step half = step;
    half.angle /= 2, half.end -= 180.0 / 90;
    Step grip = half;
    grip.kind = StepKind::hold, grip.start = half.end, grip.end = half.end + 2;
    grip.angles[0] += half.angle;
    Step rest = half;
    rest.start = grip.end, rest.end = rest.start + (half.end - half.start), rest.angles = grip.angles;
    late += rest.end - step.end;
    step.end = rest.end;
    turns.push_back(step);
    for (const Step& part : {half, grip, rest}) steps.push_back(part);
  }
  session.steps = steps;
  SimulatedSession s = simulated(session, 4);
  s.session.steps = turns;
  const RigAxis axes[] = {RigAxis::inner, RigAxis::middle, RigAxis::outer};
  for (std::size_t k = 0; k < 3; ++k) s.session.steps[k].axis = axes[k], s.session.steps[k].angles = {};
  const Calibration c = calibrated(s);
  EXPECT_THAT(c.quality.findings.notes(), Contains(HasSubstr("12 rests and 11 rotations between them were used")));
  EXPECT_THAT(c.quality.findings.notes(), Contains(HasSubstr("3 of 3 turns were used")));
  EXPECT_LT(largest_sigmas(c, s.truth.model), 5);
}

TEST(DeclaredTurns, APredictionHasThem) {
  Session procedure = ferraris_procedure(ferraris_options());
  const auto scale_sigma = [&] {
    const Prediction p = predict_handheld(procedure);
    const auto at = std::find(p.coefficients.begin(), p.coefficients.end(), coefficient_index("gyro.matrix.zz"));
    return at == p.coefficients.end() ? HUGE_VAL : p.sigma[at - p.coefficients.begin()];
  };
  const double with = scale_sigma();
  EXPECT_LT(with, 3.93e-3);
  procedure.rigs.front().kind = RigKind::none, procedure.rigs.front().angle = {};
  EXPECT_GT(scale_sigma(), with);
}

TEST(DeclaredTurns, ShareTheErrorOfTheRestBetweenThem) {
  const auto scale_sigma = [](double first, double second) {
    TableProcedureOptions options = ferraris_options();
    const std::array turns{TableTurn{RigAxis::outer, first, 5}, TableTurn{RigAxis::outer, second, 5}};
    const Prediction p = predict_handheld(turns_procedure("two turns", 5, turns, options), {.effects = false});
    const auto at = std::find(p.coefficients.begin(), p.coefficients.end(), coefficient_index("gyro.matrix.zz"));
    return at == p.coefficients.end() ? HUGE_VAL : p.sigma[at - p.coefficients.begin()];
  };
  // In consecutive turns in one direction, the middle error cancels: sqrt(2) deg of 720. Forward and back, it counts twice: sqrt(1 + 4 + 1) deg.
  // Least squares of both turns have these variances for any correlation; gravity adds a little.
  const double deg_of_720 = 1.0 / 720;
  EXPECT_NEAR(scale_sigma(360, 360), std::sqrt(2.0) * deg_of_720, 0.05 * deg_of_720);
  EXPECT_NEAR(scale_sigma(360, -360), std::sqrt(6.0) * deg_of_720, 0.05 * deg_of_720);
}

}  // namespace
}  // namespace imulab::rests
