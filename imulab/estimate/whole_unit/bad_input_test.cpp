// Whole-unit sessions with declarations that contradict the data.
#include "imulab/core/statistics.hpp"
#include "imulab/error.hpp"
#include "imulab/estimate/whole_unit/whole_unit.hpp"
#include "imulab/model/effects.hpp"
#include "imulab/rig/machine.hpp"
#include "imulab/rig/rig_errors.hpp"
#include "imulab/units.hpp"

#include <gmock/gmock.h>

#include "tests/whole_unit_session.hpp"
#include <algorithm>

namespace imulab::whole_unit {
namespace {

using ::testing::AllOf;
using ::testing::Contains;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::Not;

const WholeUnitSession& good() {
  static const WholeUnitSession s = whole_unit_session(11);
  return s;
}

template <class Change>
Session changed(Change change) {
  Session session = good().session;
  change(session);
  return session;
}

Calibration calibration_from(const std::vector<Recording>& recordings, const Session& session, const CalibrationOptions& options = {}) {
  return calibrate({session, recordings}, options).calibration;
}

std::string error_of(const std::vector<Recording>& recordings, const Session& session) {
  try {
    calibration_from(recordings, session);
  } catch (const Error& e) {
    return e.what();
  }
  return "no error";
}

/// Changes the steps of one recording with a mount.
template <class Change>
void at_mount(Session& session, const std::string& file, const std::string& mount, Change change) {
  for (Step& step : session.steps)
    if (step.recording == file && mount_name(mount_of(step)) == mount) change(step);
}

TEST(WholeUnitBadInput, AGoodSessionHasNoWarnings) {
  const Calibration c = calibration_from(good().recordings, good().session);
  EXPECT_THAT(c.quality.findings.warnings(), IsEmpty());
  EXPECT_EQ(c.quality.verdict, Verdict::good);
}

TEST(WholeUnitBadInput, AWrongMountContradictsGravity) {
  const Session twice = changed([](Session& s) { at_mount(s, "rate_table.csv", "+x+y", [](Step& step) { step.mount->up.sign = -1; }); });
  EXPECT_THAT(error_of(good().recordings, twice), AllOf(HasSubstr("rate_table.csv"), HasSubstr("mount -x+y"), HasSubstr("those of +x")));
  const Session swapped = changed([](Session& s) {
    at_mount(s, "rate_table.csv", "+x+y", [](Step& step) { step.mount->up = {1, 1}, step.mount->outward = {0, 1}; });
  });
  EXPECT_THAT(error_of(good().recordings, swapped), AllOf(HasSubstr("rate_table.csv"), HasSubstr("mount +y+x"), HasSubstr("those of +x")));
  const Session centrifuge = changed([](Session& s) { at_mount(s, "centrifuge.csv", "+z+y", [](Step& step) { step.mount->outward = {0, 1}; }); });
  EXPECT_THAT(error_of(good().recordings, centrifuge), AllOf(HasSubstr("centrifuge.csv"), HasSubstr("mount +z+x"), HasSubstr("those of +z+y")));
}

TEST(WholeUnitBadInput, RatesThatRunTheOtherWayAreNamed) {
  const Session session = changed([](Session& s) {
    for (Step& step : s.steps)
      if (step.recording == "rate_table.csv") step.rate = -step.rate;
  });
  EXPECT_THAT(error_of(good().recordings, session), HasSubstr("the gyros read the opposite of the declared rate"));
}

TEST(WholeUnitBadInput, ARadiusThatContradictsTheRateIsFound) {
  const Session session = changed([](Session& s) {
    for (Step& step : s.steps)
      if (step.recording == "centrifuge.csv")
        for (double& r : step.radius) r += 0.02;
  });
  const Calibration c = calibration_from(good().recordings, session);
  EXPECT_THAT(c.quality.findings.warnings(),
              Contains(AllOf(HasSubstr("centrifuge: every radius"), AnyOf(HasSubstr("-19"), HasSubstr("-20")), HasSubstr("mm"))));
  EXPECT_THAT(verdict_text(c.quality), HasSubstr("doubtful, because"));
}

TEST(WholeUnitBadInput, WhatAMachineCannotDoIsNamed) {
  EXPECT_THAT(error_of(good().recordings, changed([](Session& s) {
                         s.steps.back().radius = {0, 0, 0};
                       })),
              AllOf(HasSubstr("centrifuge.csv"), HasSubstr("a radius above 0")));
  EXPECT_THAT(error_of(good().recordings, changed([](Session& s) { s.steps.front().kind = StepKind::spin; })), HasSubstr("a chamber does not turn"));
  EXPECT_THAT(error_of(good().recordings, changed([](Session& s) { s.site.latitude.reset(), s.site.given_gravity = 9.8; })),
              HasSubstr("the site has no latitude"));
}

TEST(WholeUnitBadInput, AnUnsettledChamberIsReportedWithItsDrift) {
  DaiUnitOptions options;
  options.record = 10;
  const WholeUnitSession s = whole_unit_session(12, options, [](Session& session) {
    double time = 0;  // half a minute of soak instead of half an hour
    for (Step& step : session.steps)
      if (step.recording == "chamber.csv") step.start = time + 60, step.end = time += 70;
  });
  const Calibration c = calibration_from(s.recordings, s.session);
  EXPECT_THAT(c.quality.findings.warnings(), Contains(AllOf(HasSubstr("of the chamber's points had not settled"), HasSubstr("K/min"))));
}

TEST(WholeUnitBadInput, HysteresisShowsWhereTheChamberGoesBothWays) {
  DaiUnitOptions options;
  options.record = 2;
  options.both_ways = true;
  const auto calibrated = [&](double hysteresis) {
    const WholeUnitSession s = whole_unit_session(13, options, [&](Session& session) { session.rigs[0].hysteresis = hysteresis; });
    CalibrationOptions without;
    without.effects = false;  // drifts would absorb it
    return calibration_from(s.recordings, s.session, without).quality.findings.warnings();
  };
  EXPECT_THAT(calibrated(0), Not(Contains(HasSubstr("hysteresis"))));
  EXPECT_THAT(calibrated(3), Contains(HasSubstr("between warming and cooling: hysteresis")));
}

TEST(WholeUnitBadInput, TooFewRatesForTheOrderAreCounted) {
  WholeUnitSession s = good();
  std::erase_if(s.session.steps, [](const Step& step) {
    return step.recording == "rate_table.csv" && step.kind == StepKind::spin && std::abs(std::abs(step.rate) - 100 * unit::deg) > 0.1 * unit::deg;
  });
  std::erase_if(s.session.steps, [](const Step& step) { return step.recording == "centrifuge.csv"; });
  s.session.recordings.pop_back(), s.recordings.pop_back();
  const Calibration c = calibration_from(s.recordings, s.session, full_whole_unit());
  EXPECT_THAT(c.quality.unobservable, Contains("gyro.cubic.x"));
  EXPECT_THAT(c.quality.findings.warnings(),
              Contains(AllOf(HasSubstr("gyro.cubic.x is not determined"), HasSubstr("different rates along x, at least 5"))));
}

TEST(WholeUnitBadInput, ASaturatedPointIsLeftOutWithAWarning) {
  WholeUnitSession s = good();
  s.recordings[1].saturated = {25};
  const Calibration c = calibration_from(s.recordings, s.session);
  EXPECT_THAT(c.quality.findings.warnings(), Contains(AllOf(HasSubstr("rate_table.csv, step 1 "), HasSubstr("saturated, left out"))));
  EXPECT_THAT(c.quality.findings.notes(), Contains(HasSubstr("302 points")));
}

TEST(WholeUnitBadInput, AnOutlierIsDroppedByName) {
  WholeUnitSession s = good();
  for (std::size_t k = 0; k < 50; ++k) s.recordings[2].accel[0][100 + k] += 0.05;  // the third point, by 5 mg
  const Calibration c = calibration_from(s.recordings, s.session);
  EXPECT_THAT(c.quality.findings.warnings(), Contains(AllOf(HasSubstr("dropped as an outlier: centrifuge.csv, step 3"))));
}

TEST(WholeUnitBadInput, RepeatedPointsAreMorePoints) {
  WholeUnitSession s = good();
  const Step first = s.session.steps.front();  // again, on the same samples: it adds no information, but must not fail
  s.session.steps.insert(s.session.steps.begin(), first);
  const Calibration c = calibration_from(s.recordings, s.session);
  EXPECT_THAT(c.quality.findings.warnings(), Contains(HasSubstr("twice")));
}

TEST(WholeUnitBadInput, OtherRigsAndMissingSamplesAreNamed) {
  EXPECT_THAT(error_of({}, good().session), HasSubstr("got 0 recordings; expected one for each of the 3 declared"));
  EXPECT_THAT(error_of(good().recordings, changed([](Session& s) { s.rigs[1].kind = RigKind::turntable; })), HasSubstr("rig of kind \"turntable\""));
  const Session late = changed([](Session& s) { s.steps.back().start += 1e5, s.steps.back().end += 1e5; });
  EXPECT_THAT(calibration_from(good().recordings, late).quality.findings.warnings(), Contains(HasSubstr("0 samples in it, left out")));
}

}  // namespace
}  // namespace imulab::whole_unit
