// Rules that every method in the table of methods keeps whose procedures are simulated.
#include "imulab/calibrate.hpp"
#include "imulab/error.hpp"
#include "imulab/estimate/method.hpp"
#include "imulab/files.hpp"
#include "imulab/grade.hpp"
#include "imulab/recording/origin.hpp"
#include "imulab/recording/rests_of_view.hpp"
#include "imulab/rests.hpp"
#include "imulab/simulate.hpp"
#include "imulab/stop.hpp"

#include <fmt/core.h>
#include <gmock/gmock.h>

#include "tests/acceptance/acceptance.hpp"
#include "tests/run_command.hpp"
#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <optional>
#include <stop_token>
#include <string>
#include <utility>
#include <vector>

namespace imulab {
namespace {

using ::testing::HasSubstr;
using ::testing::StartsWith;

struct Example {
  Session session;
  std::vector<Recording> recordings;
};

Example simulated(Session session) {
  Example e{std::move(session), {}};
  const Truth truth = draw_truth(e.session, 1);
  for (const RecordingSource& source : e.session.recordings)
    e.recordings.push_back(simulate_recording(e.session, source, truth, 1, draw_rig_errors(e.session, source, 1)));
  return e;
}

/// Those with a procedure that can be simulated. The method drive has tests of its own (apps/imulab/calibrate_drive_test.cpp).
std::vector<Method> simulated_methods() {
  std::vector<Method> out(methods().begin(), methods().end());
  std::erase_if(out, [](const Method& method) { return method.example == nullptr; });
  return out;
}

const Example& example(const Method& method) {
  static std::map<std::string_view, Example> examples;
  const auto found = examples.find(method.name);
  return found == examples.end() ? examples.emplace(method.name, simulated(method.example({}))).first->second : found->second;
}

std::string error_of(const Method& method, const CalibrationInput& input, const CalibrationOptions& options = {}) {
  try {
    calibrate(method, input, options);
  } catch (const Error& e) {
    return e.what();
  }
  return "no error";
}

TEST(Methods, EveryOneGivesACalibrationWithItsCovarianceAndVerdict) {  // ctest: once
  const std::string papers = read_text(IMULAB_SOURCE "/docs/reference/grades.md");
  for (const Method& method : simulated_methods()) {
    SCOPED_TRACE(method.name);
    const Example& e = example(method);
    const Calibration c = calibrate(method.name, {e.session, e.recordings}).calibration;
    EXPECT_THAT(c.method, StartsWith(std::string(method.name)));
    EXPECT_GT(c.estimated.size(), 0u);
    EXPECT_EQ(c.covariance.rows(), static_cast<Eigen::Index>(c.estimated.size()));
    EXPECT_TRUE(c.covariance.allFinite());
    EXPECT_GT(c.covariance.diagonal().minCoeff(), 0);
    EXPECT_GE(c.quality.degrees_of_freedom, 0) << "effects may take up all that is left";
    EXPECT_GT(calibrate(method.name, {e.session, e.recordings}, {.effects = false}).calibration.quality.degrees_of_freedom, 0);
    EXPECT_NE(c.quality.verdict, Verdict::none);
    EXPECT_EQ(c.quality.sources.front().name, "gravity");
    EXPECT_FALSE(method.summary.empty() || method.needs.empty());
    EXPECT_THAT(papers, HasSubstr(fmt::format("**{}.**", method.reference)));
  }
}

TEST(Methods, EveryOnePredictsWhatItWillEstimate) {  // ctest: once
  for (const Method& method : simulated_methods()) {
    SCOPED_TRACE(method.name);
    const Session& procedure = example(method).session;
    const Prediction p = predict(method, procedure);
    EXPECT_EQ(p.sigma.size(), std::ssize(p.coefficients));
    EXPECT_EQ(p.cramer_rao.size(), std::ssize(p.coefficients));
    EXPECT_GT(p.sigma.minCoeff(), 0);
    const bool few = p.degrees_of_freedom.size() > 0 && p.degrees_of_freedom.minCoeff() < 3;  // then no requirement is met
    EXPECT_EQ(shortfalls(p, parse_requirements("accel.offset <= 1 g, accel.matrix <= 100000 ppm")).empty(), !few);
    EXPECT_FALSE(shortfalls(p, parse_requirements("accel.offset <= 0.00001 ug")).empty());
  }
}

/// Larger effects never help, and an IMU whose effects are as expected is between those of half and of twice as large.
TEST(Methods, EveryOnePredictsForSmallerAndLargerEffects) {  // ctest: once
  int told_by_noise = 0;
  for (const Method& method : simulated_methods()) {
    SCOPED_TRACE(method.name);
    Session session = example(method).session;
    if (session.imu.grade) {
      const Grade& declared = grade(*std::exchange(session.imu.grade, std::nullopt));
      session.imu.accel_noise_density = declared.accel_noise.N;
      session.imu.gyro_noise_density = declared.gyro_noise.N;
      ++told_by_noise;
    }
    const Prediction p = predict(method, session, {.sizes = true, .advice = false});
    ASSERT_EQ(p.sigma_of_half.size(), p.sigma.size());
    ASSERT_EQ(p.sigma_of_twice.size(), p.sigma.size());
    constexpr double rounding = 1e-6, second_order = 0.02;  // of a table, whose products grow with what is uncertain
    for (Eigen::Index i = 0; i < p.sigma.size(); ++i) {
      const std::string_view name = coefficient(p.coefficients[static_cast<std::size_t>(i)]).name;
      EXPECT_LE(p.sigma_of_half[i], (1 + (p.sources.empty() ? rounding : second_order)) * p.sigma[i]) << name;
      EXPECT_GE(p.sigma_of_twice[i], (1 - (p.sources.empty() ? rounding : second_order)) * p.sigma[i]) << name;
    }
    EXPECT_GT((p.sigma_of_twice.array() / p.sigma_of_half.array()).maxCoeff(), 1.5);  // 4 where effects alone count
    EXPECT_EQ(predict(method, session, {.advice = false}).sigma_of_half.size(), 0);
  }
  EXPECT_GE(told_by_noise, 3);
}

/// The part of the covariance that a unit brings again: less than all of it in every direction, and not nothing.
TEST(Methods, EveryOneTellsWhatAUnitBringsAgain) {  // ctest: once
  for (const Method& method : simulated_methods()) {
    SCOPED_TRACE(method.name);
    const Example& e = example(method);
    const Calibration c = calibrate(method.name, {e.session, e.recordings}).calibration;
    ASSERT_EQ(c.constant_covariance.rows(), c.covariance.rows());
    const Eigen::VectorXd u = c.covariance.diagonal().cwiseSqrt();
    const Eigen::MatrixXd rest = u.cwiseInverse().asDiagonal() * (c.covariance - c.constant_covariance) * u.cwiseInverse().asDiagonal();
    const Eigen::VectorXd values = rest.selfadjointView<Eigen::Lower>().eigenvalues();
    EXPECT_GT(values.minCoeff(), -1e-9);
    EXPECT_GT((c.constant_covariance.diagonal().array() / c.covariance.diagonal().array()).maxCoeff(), 0.1);
    EXPECT_LT((c.constant_covariance.diagonal().array() / c.covariance.diagonal().array()).minCoeff(), 0.9);
    const Calibration back = parse_calibration(calibration_text(c), "c.json");
    EXPECT_TRUE(back.constant_covariance.isApprox(c.constant_covariance, 1e-9));
  }
}

TEST(Methods, EveryOnesPredictionIsWhatItStatesAndHowItsEstimatesScatter) {  // ctest: long
  for (const Method& method : simulated_methods())
    for (const acceptance::Check& c : acceptance::predictions(method, method.equipment < 2 ? 25 : 8))
      EXPECT_TRUE(c.passed()) << method.name << ": " << c.name << " is " << c.value << ", expected " << c.low << " to " << c.high;
}

TEST(Methods, EveryOneHasAnAcceptanceCase) {  // ctest: once
  for (const Method& method : simulated_methods()) {
    const auto of_method = [&](const acceptance::Case& c) { return c.method == method.name; };
    EXPECT_TRUE(std::ranges::any_of(acceptance::cases(), of_method)) << method.name;
  }
}

/// The samples of a recording before or after one of them, as a recording of its own.
Recording part_of(const Recording& whole, Range range, const std::string& name) {
  Recording part = whole;
  part.name = name;
  const auto cut = [&](auto& column) {
    column = {column.begin() + static_cast<std::ptrdiff_t>(range.begin), column.begin() + static_cast<std::ptrdiff_t>(range.end)};
  };
  cut(part.time_ns);
  for (auto* columns : {&part.gyro, &part.accel})
    for (auto& column : *columns) cut(column);
  return part;
}

TEST(Methods, EveryOneTakesSeveralRecordingsOfOneUnit) {  // ctest: once
  for (const Method& method : simulated_methods()) {
    SCOPED_TRACE(method.name);
    const Example& e = example(method);
    if (method.takes_several) {
      EXPECT_GT(e.recordings.size(), 1u);
      continue;
    }
    const Recording& whole = e.recordings.front();
    // In the middle of a rest near the half.
    const std::vector<Range> rests = rests_of(whole, e.session).ranges;
    const Range& rest = rests[rests.size() / 2];
    const std::size_t cut = rest.begin + rest.size() / 2;
    Example two = e;
    two.recordings = {part_of(whole, {0, cut}, whole.name), part_of(whole, {cut, whole.size()}, "second.csv")};
    two.session.recordings.push_back(two.session.recordings.front());
    two.session.recordings.back().file = "second.csv";
    const double time = whole.time_s(cut);
    two.session.steps.clear();
    for (Step step : e.session.steps) {
      if (step.end <= time || step.start >= time) {
        step.recording = step.end <= time ? whole.name : "second.csv";
        two.session.steps.push_back(step);
      }
    }
    for (const bool effects : {false, true}) {
      const CalibrationOptions options{.effects = effects};
      const Calibration one = calibrate(method, {e.session, e.recordings}, options).calibration,
                        both = calibrate(method, {two.session, two.recordings}, options).calibration;
      // The rest that was cut in two is lost or halved, little of what all rests tell; with effects, each recording has a turn-on and drifts of its
      // own.
      const double most = effects ? 2.5 : 1.5;
      for (const CoefficientIndex index : one.estimated) {
        const auto sigma = standard_uncertainty(both, index);
        if (!sigma) continue;
        EXPECT_LT(std::abs(coefficient_value(both.model, index) - coefficient_value(one.model, index)), 3 * *sigma) << coefficient(index).name;
        EXPECT_LT(*sigma, most * *standard_uncertainty(one, index)) << coefficient(index).name;
      }
      if (!both.quality.rests.empty()) EXPECT_EQ(both.quality.rests.back().recording, "second.csv");
    }
  }
}

TEST(Methods, EveryOneRefusesWhatIsNoRecording) {  // ctest: once
  for (const Method& method : simulated_methods()) {
    SCOPED_TRACE(method.name);
    Example e = example(method);
    e.recordings.front().gyro[1][100] = std::numeric_limits<double>::quiet_NaN();
    EXPECT_THAT(error_of(method, {e.session, e.recordings}), HasSubstr("gyro"));
    EXPECT_NE(error_of(method, {e.session, {}}), "no error");
  }
}

TEST(Methods, EveryOneRefusesASessionInOtherUnits) {  // ctest: once
  for (const Method& method : simulated_methods()) {
    SCOPED_TRACE(method.name);
    const Example& e = example(method);
    Session degrees = e.session;
    degrees.site.latitude = 45;
    const auto wrong_latitude = testing::ThrowsMessage<Error>(HasSubstr("site.latitude_deg: 2578.3100780887044 is out of range"));
    EXPECT_THAT([&] { calibrate(method, {degrees, e.recordings}); }, wrong_latitude);
    EXPECT_THAT([&] { predict(method, degrees); }, wrong_latitude);
    EXPECT_THAT([&] { draw_truth(degrees, 1); }, wrong_latitude);
    EXPECT_THAT(
        [&] {
          calibrate(method, {e.session, e.recordings}, {.significance = -3});
        },
        testing::ThrowsMessage<Error>("significance: -3 is no probability; expected at least 0 and less than 1"));
    EXPECT_THAT(
        [&] {
          calibrate(method, {e.session, e.recordings, std::vector<Range>{{50, 20}}});
        },
        testing::ThrowsMessage<Error>(StartsWith("rests: samples 50 to 20 are no rest")));
  }
}

TEST(Methods, EveryOneNamesATermItDoesNotEstimate) {  // ctest: long
  for (const Method& method : simulated_methods()) {
    SCOPED_TRACE(method.name);
    const Example& e = example(method);
    bool any = false;
    for (const char* name : {"gyro.cubic.x", "accel.lever_arm.xx"}) try {
        calibrate(method, {e.session, e.recordings}, {.terms = {coefficient_index(name)}});
      } catch (const TermsError& error) {
        EXPECT_THAT(error.what(), HasSubstr(name));
        any = true;
      }
    EXPECT_TRUE(any);
  }
}

TEST(Methods, EveryOneStopsBetweenIterationsAndTellsItsProgress) {  // ctest: once
  for (const Method& method : simulated_methods()) {
    SCOPED_TRACE(method.name);
    const Example& e = example(method);
    std::stop_source source;
    std::vector<double> told;
    const CalibrationOptions options{.progress = [&](double part) { told.push_back(part), source.request_stop(); }, .stop = source.get_token()};
    EXPECT_THROW(calibrate(method, {e.session, e.recordings}, options), Stopped);
    EXPECT_EQ(told.size(), 1u) << "the first iteration is the last";
    EXPECT_THROW(predict(method, e.session, {.stop = source.get_token()}), Stopped);
    EXPECT_NO_THROW(stop_point()) << "the token belongs to the call";
    told.clear();
    calibrate(method, {e.session, e.recordings}, {.effects = false, .progress = [&](double part) { told.push_back(part); }});
    EXPECT_TRUE(std::is_sorted(told.begin(), told.end()));
    EXPECT_GT(told.size(), 1u);
    EXPECT_EQ(told.back(), 1);
  }
}

TEST(Methods, EveryOneFillsInTheOriginFromASessionOfItsOwn) {  // ctest: once
  for (const Method& method : simulated_methods()) {
    SCOPED_TRACE(method.name);
    const Example& e = example(method);
    const CalibrationInput job = [&] {  // as a queue keeps it: the session that it was made of is gone
      Session session = e.session;
      session.imu.serial = "7";
      session.operated_by = "E. Example";
      return CalibrationInput{session, e.recordings};
    }();
    const Calibration c = calibrate(method, job, {.effects = false}).calibration;
    EXPECT_EQ(c.serial, "7");
    EXPECT_EQ(c.operated_by, "E. Example");
    EXPECT_EQ(c.software, software());
    EXPECT_EQ(c.created.size(), std::string("2026-03-31T12:00:00Z").size());
    EXPECT_EQ(c.recorded_gyro, (RecordedAs{"rad/s"}));
  }
}

/// A calibration that leaves out what the unit has is worse than its prediction, which says so.
TEST(Methods, RestrictedTermsAreNamedInThePrediction) {
  for (const Method& method : simulated_methods()) {
    SCOPED_TRACE(method.name);
    const Session& procedure = example(method).session;
    const Prediction whole = predict(method, procedure, {.effects = false});
    PredictionOptions options{.effects = false};
    for (const CoefficientIndex index : whole.coefficients)
      if (!is_optional(coefficient(index).term)) options.terms.push_back(index);
    const Prediction restricted = predict(method, procedure, options);
    const bool leaves_out = restricted.coefficients.size() < whole.coefficients.size();
    const auto named = [](const std::string& note) { return note.starts_with("taken as absent, since the terms do not name them: "); };
    EXPECT_EQ(std::ranges::count_if(restricted.notes, named), leaves_out ? 1 : 0);
    EXPECT_EQ(std::ranges::count_if(whole.notes, named), 0);
  }
  const Method& hybrid = method("hybrid");
  const Prediction offsets = predict(hybrid, example(hybrid).session, {.terms = select_coefficients("gyro.offset"), .effects = false});
  EXPECT_THAT(offsets.notes,
              testing::Contains(testing::AllOf(HasSubstr("accel.offset, accel.matrix.diagonal"), HasSubstr("gyro.matrix.off_diagonal"))));
}

TEST(Methods, AnUnknownOneIsAnsweredWithTheKnown) {
  try {
    method("magic");
    FAIL();
  } catch (const Error& e) {
    EXPECT_THAT(e.what(), HasSubstr("drive, handheld, hybrid, reference, static, turntable, whole-unit"));
  }
}

}  // namespace
}  // namespace imulab
