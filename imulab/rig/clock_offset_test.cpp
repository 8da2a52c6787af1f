#include "imulab/rig/clock_offset.hpp"

#include "imulab/procedure.hpp"
#include "imulab/simulate.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <vector>

namespace imulab {
namespace {

struct Example {
  Session session;
  Recording recording;
};

Example table_session() {
  TableProcedureOptions options;
  options.rest = 15, options.rate_hz = 50;
  Example e{zhang_24_procedure(options), {}};
  e.session.imu.grade = "navigation";
  const RecordingSource& source = e.session.recordings.front();
  e.recording = simulate_recording(e.session, source, draw_truth(e.session, 1), 1, draw_rig_errors(e.session, source, 1));
  return e;
}

TEST(ClockOffset, OfClocksThatAgreeIsNone) {
  const Example e = table_session();
  EXPECT_FALSE(clock_offset(e.recording, e.session.steps));
}

TEST(ClockOffset, IsFoundToTwoHundredthsOfASecond) {
  const Example e = table_session();
  for (const double offset : {33.7, -12.34, 1.0, 250.0}) {
    std::vector<Step> steps = e.session.steps;
    for (Step& step : steps) step.start -= offset, step.end -= offset;
    const auto found = clock_offset(e.recording, steps);
    ASSERT_TRUE(found) << offset;
    // Turns begin and end with the table's timing errors of 10 ms; over the procedure's turns they average out.
    EXPECT_NEAR(found->offset_s, offset, 0.02);
    EXPECT_GT(found->correlation, 0.8);  // the moves between the steps are faster than their gaps
  }
}

TEST(ClockRate, IsFoundWithinItsUncertainty) {
  const Example e = table_session();
  for (const double rate : {0.0, 1e-3, -2e-4, 3e-5}) {
    Example other = e;
    for (std::int64_t& stamp : other.recording.time_ns) stamp += std::llround(rate * static_cast<double>(stamp));
    const auto found = clock_rate(other.recording, e.session.steps);
    ASSERT_TRUE(found) << rate;
    EXPECT_GE(found->turns, 6U);
    EXPECT_LT(found->sigma, 1e-5);  // 10 ms of timing in the ends of six turns in half an hour
    EXPECT_NEAR(found->rate, rate, 4 * found->sigma) << rate;
    EXPECT_NEAR(found->late(found->at_s + 100) - found->late(found->at_s), 100 * found->rate, 1e-9);
    EXPECT_LT(found->lost_s, 0.1) << rate;  // ten times the timing's sigma
  }
}

TEST(ClockRate, SamplesLostWithoutATraceAreNoClock) {
  Example e = table_session();
  constexpr std::ptrdiff_t lost = 20;  // 0.4 s
  std::vector<double> turns;
  for (const Step& step : e.session.steps)
    if (step.kind == StepKind::rotate) turns.push_back(step.start);
  const auto at = static_cast<std::ptrdiff_t>(e.recording.samples_in(0, turns[3] - 5).end);  // in a rest
  for (auto* triad : {&e.recording.gyro, &e.recording.accel})
    for (auto& column : *triad) column.erase(column.begin() + at, column.begin() + at + lost);
  e.recording.time_ns.resize(e.recording.time_ns.size() - static_cast<std::size_t>(lost));
  const auto found = clock_rate(e.recording, e.session.steps);
  ASSERT_TRUE(found);
  EXPECT_NEAR(found->lost_s, 0.4, 0.1);
}

TEST(ClockRate, ATurnThatIsMissingIsPassedOver) {
  Example e = table_session();
  for (auto& column : e.recording.gyro)
    for (double& reading : column) reading = 0;
  EXPECT_FALSE(clock_rate(e.recording, e.session.steps));
}

TEST(ClockRate, ATableThatTakesLongerToComeToRestIsNoClock) {
  // The steps' turns end up to a second later than the motion, ever later: their beginnings agree.
  Example e = table_session();
  double late = 0;
  for (Step& step : e.session.steps)
    if (step.kind == StepKind::rotate) step.end += late += 0.2;
  const auto found = clock_rate(e.recording, e.session.steps);
  EXPECT_TRUE(!found || std::abs(found->rate) < 5 * found->sigma) << found->rate;
}

TEST(ClockOffset, OfAnotherRecordingIsNotBelieved) {
  const Example e = table_session();
  std::vector<Step> other = e.session.steps;
  for (std::size_t k = 0; k < other.size(); ++k) other[k].kind = k % 7 == 0 ? StepKind::rotate : StepKind::hold, other[k].angle = 1;
  const auto found = clock_offset(e.recording, other);
  EXPECT_TRUE(!found || found->correlation < 0.7) << found->correlation;
}

}  // namespace
}  // namespace imulab
