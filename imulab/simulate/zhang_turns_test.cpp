// Zhang 2010 eq 8 (its Delta_g) against a simulated turntable: the independent check of axes, zero and angle errors together.
#include "imulab/simulate.hpp"
#include "imulab/units.hpp"

#include <Eigen/LU>
#include <gtest/gtest.h>

#include <numbers>

namespace imulab {
namespace {

using unit::deg;

constexpr double turns = 5, rate_dps = 10;

/// Turns of an axis forward and back, from rest to rest.
Session there_and_back(RigAxis axis) {
  Session s;
  s.site.latitude = 28 * deg;
  s.rigs.emplace_back();
  s.rigs[0].kind = RigKind::turntable;
  double t = 0;
  for (const double sign : {1.0, -1.0}) {
    Step hold, turn;
    hold.start = t, hold.end = t + 1;
    turn.kind = StepKind::rotate, turn.start = hold.end, turn.end = turn.start + turns * 360 / rate_dps + 0.2;
    turn.axis = axis, turn.angle = sign * turns * 2 * std::numbers::pi, turn.rate = rate_dps * deg;
    t = turn.end;
    s.steps.push_back(hold), s.steps.push_back(turn);
  }
  s.steps[2].angles[static_cast<std::size_t>(axis)] = turns * 2 * std::numbers::pi;
  Step last;
  last.start = t, last.end = t + 1;
  s.steps.push_back(last);
  return s;
}

/// Errors of a table [rad]: six orthogonalities, three zero errors, and the errors of each axis at the end of forward and back turns.
struct TableErrors {
  double i1, i2, m1, m2, o1, o2, so, sm, si;
  double forward_end, back_end;
};

/// Sum forward less sum back over 4 pi n: from mid-rest to mid-rest, in ENU body axes.
Vector3d turn_column(RigAxis axis, const TableErrors& e) {
  Session s = there_and_back(axis);
  RigDeclaration& rig = s.rigs[0];
  rig.given_orthogonality = {std::array{e.o1, e.o2}, std::array{e.m1, e.m2}, std::array{e.i1, e.i2}};
  rig.given_zero = {e.so, e.sm, e.si};
  RigErrors errors = draw_rig_errors(s, {}, 1);
  for (std::size_t k = 0; k < errors.sources.size(); ++k) {
    const RigErrorSource& source = errors.sources[k];
    if (source.kind == RigErrorKind::angle && source.step == 1) errors.values[k] = e.forward_end;
    if (source.kind == RigErrorKind::angle && source.step == 3) errors.values[k] = e.back_end;
  }
  const Recording r = simulate_recording(s, {}, {}, 1, errors);
  const std::size_t middle = r.size() / 2;  // both halves last equally long
  Vector3d sum = Vector3d::Zero();
  for (std::size_t k = 0; k < r.size(); ++k)
    for (int a = 0; a < 3; ++a) sum(a) += (k < middle ? 1 : -1) * r.gyro[static_cast<std::size_t>(a)][k] * r.interval_s;
  return sum / (4 * std::numbers::pi * turns);
}

/// Columns in ENU: the gyros of an ideal IMU on turns about each axis.
Matrix3d simulated_matrix(const TableErrors& e) {
  Matrix3d m;
  m.col(0) = turn_column(RigAxis::inner, e), m.col(1) = turn_column(RigAxis::middle, e), m.col(2) = turn_column(RigAxis::outer, e);
  return m;
}

/// I + Dg in ENU axes (east = inner, north = middle, up = outer), from Zhang's in north-up-east.
Matrix3d closed_form(const TableErrors& e) {
  const double ai1 = e.i1, ai2 = e.i2, am1 = e.m2, am2 = e.m1, ao1 = e.o2, ao2 = e.o1;
  // A forward turn's angle error is its end error less its start error (zero here); a back turn's likewise, counted negative.
  const double turn = (e.forward_end - (e.back_end - e.forward_end)) / (4 * std::numbers::pi * turns);
  Matrix3d zhang;
  zhang << turn, ao1 + e.si, ai1,  //
      am1 - e.si, turn, ai2,       //
      am2, ao2 - e.sm, turn;
  const int nue[3] = {2, 0, 1};  // east, north, up are Zhang's z, x, y
  Matrix3d out;
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j) out(i, j) = zhang(nue[i], nue[j]);
  return Matrix3d::Identity() + out;
}

TEST(ZhangTurns, GyroMatrixErrorIsTheClosedFormToSecondOrder) {
  const auto difference = [](double scale) {
    const TableErrors e{3e-3 * scale,  -2e-3 * scale, 4e-3 * scale, 1e-3 * scale,  -5e-3 * scale, 2e-3 * scale,
                        -3e-3 * scale, 4e-3 * scale,  2e-3 * scale, 30e-3 * scale, -20e-3 * scale};
    return (simulated_matrix(e) - closed_form(e)).norm();
  };
  const double whole = difference(1), half = difference(0.5);
  EXPECT_LT(whole, 9 * 5e-3 * 5e-3);  // nine elements of products of two errors
  EXPECT_GT(whole, 1e-6);             // the second order is visible
  // Earth's rate, the same forward and back, leaves (pi n)^-1 of its turned component, below 1e-9 at these errors; third order is 5e-3 of second.
  EXPECT_NEAR(whole / half, 4, 0.1);
}

}  // namespace
}  // namespace imulab
