#include "imulab/navigate.hpp"

#include "imulab/compensate.hpp"
#include "imulab/core/statistics.hpp"
#include "imulab/eigen.hpp"
#include "imulab/error.hpp"
#include "imulab/files.hpp"
#include "imulab/formats/recording/reader.hpp"

#include <Eigen/Dense>
#include <gmock/gmock.h>

#include "tests/flight_session.hpp"
#include <algorithm>

namespace imulab {
namespace {

using ::testing::Contains;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::Not;

NavigationError end_error(const Navigated& n, const Solution& truth) { return navigation_errors(n.solution, truth).history.back(); }

/// Removes samples begin .. end - 1, in the form of read_recording.
Recording without(Recording r, std::size_t begin, std::size_t end) {
  const auto cut = [&](auto& column) {
    column.erase(column.begin() + static_cast<std::ptrdiff_t>(begin), column.begin() + static_cast<std::ptrdiff_t>(end));
  };
  cut(r.time_ns);
  for (std::size_t k = 0; k < 3; ++k) {
    cut(r.gyro[k]);
    cut(r.accel[k]);
  }
  r.gaps = {begin};
  return r;
}

TEST(Navigate, AnIdealUnitFromAGivenStartIsWhereTheTruthIs) {
  FlightSession f = flight_session(0);
  f.session.initial = flight_start();
  const Navigated n = navigate({}, f.session, f.recording);
  EXPECT_FALSE(n.aligned);
  EXPECT_THAT(n.warnings, IsEmpty());
  EXPECT_DOUBLE_EQ(n.solution.time.front(), flight_rest);
  const NavigationError end = end_error(n, f.truth);
  EXPECT_LT(end.position.norm(), 2e-3);  // 60 s at 50 Hz with a roll-in of 3 s: a millimeter is the integrator's own error
  EXPECT_LT(end.attitude.norm(), 1e-6);
}

TEST(Navigate, StartsInsideASampleToo) {
  FlightSession f = flight_session(0);
  f.session.initial = flight_start();
  f.session.initial->time = flight_rest - 0.013;
  const Navigated n = navigate({}, f.session, f.recording);
  EXPECT_DOUBLE_EQ(n.solution.time.front(), flight_rest - 0.013);
  EXPECT_LT(end_error(n, f.truth).position.norm(), 2e-3);
  f.session.initial->time = 0;  // start of the first sample's interval
  EXPECT_LT(end_error(navigate({}, f.session, f.recording), f.truth).position.norm(), 3e-3);
  for (const std::int64_t late : {100000, -100000}) {  // 0.1 ms of 20: the first sample is still whole
    FlightSession stamped = f;
    stamped.recording.time_ns[0] += late;
    const Navigated begun = navigate({}, stamped.session, stamped.recording);
    EXPECT_DOUBLE_EQ(begun.solution.time.front(), 0);
    EXPECT_LT(end_error(begun, f.truth).horizontal(), 3e-3);
  }
  for (const double outside : {-1., 100., 500.}) {
    f.session.initial->time = outside;
    EXPECT_THROW(navigate({}, f.session, f.recording), Error) << outside;
  }
}

TEST(Navigate, AlignsOnTheFirstRestWithinTheStatedUncertainty) {
  double square = 0;
  const int runs = 12;
  for (int k = 0; k < runs; ++k) {
    const FlightSession f = flight_session(1, 10 + static_cast<std::uint64_t>(k));
    const Navigated n = navigate({}, f.session, f.recording);
    ASSERT_TRUE(n.aligned);
    EXPECT_NEAR(n.aligned->end, flight_rest, 1.5);  // the rest is found in the data
    const Eigen::Vector3d e = navigation_errors(n.solution, f.truth).history.front().attitude;
    square += e.dot(n.aligned->alignment.attitude.covariance.llt().solve(e));
  }
  EXPECT_LT(square, chi_square_quantile(1 - 1e-6, 3 * runs));  // by chance p = 1e-6
  EXPECT_GT(square, chi_square_quantile(1e-6, 3 * runs));
}

TEST(Navigate, ARestTooShortToAlignOnIsPassedOver) {
  FlightSession f = flight_session(1);
  for (std::size_t i = 250; i < 300; ++i) f.recording.gyro[0][i] += i % 2 == 0 ? 0.01 : -0.01;  // shaken after 5 s, for 1 s
  const Navigated n = navigate({}, f.session, f.recording);
  EXPECT_NEAR(n.aligned->begin, 6.5, 0.5);
  EXPECT_NEAR(n.aligned->end, flight_rest, 1.5);
}

TEST(Navigate, BridgesGapsOrRefusesThem) {
  FlightSession f = flight_session(0);
  f.session.initial = flight_start();
  const Recording holed = without(f.recording, 2500, 2525);  // 0.5 s while it speeds up
  const Navigated n = navigate({}, f.session, holed);
  ASSERT_EQ(n.gaps.size(), 1u);
  EXPECT_NEAR(n.gaps[0].begin, 50, 1e-9);
  EXPECT_NEAR(n.gaps[0].length, 0.5, 1e-9);
  ASSERT_THAT(n.warnings, testing::SizeIs(1));
  EXPECT_THAT(n.warnings[0], HasSubstr("1 gap of 0.5 s altogether, the first after 50.000000 s"));
  // The force is extrapolated linearly: neglecting its curvature, below 1 m/s^4, over 0.5 s costs at most 0.01 m/s, 0.5 m after 50 s.
  EXPECT_LT(end_error(n, f.truth).position.norm(), 0.5);
  EXPECT_THROW(navigate({}, f.session, holed, {.gaps = GapTreatment::refuse}), Error);
  f.session.initial->time = 50.3;  // a start inside the gap
  const Navigated inside = navigate({}, f.session, holed);
  EXPECT_DOUBLE_EQ(inside.solution.time.front(), 50.3);
  EXPECT_NEAR(inside.solution.time[1], 50.32, 1e-9);
}

TEST(Navigate, AVerticalChannelThatIsFreeForAnHourIsNamed) {
  FlightSession f = flight_session(0);
  f.session.initial = flight_start();
  const auto go_on = [&](double seconds) {
    for (const double end = f.recording.time_s(f.recording.size() - 1) + seconds; f.recording.time_s(f.recording.size() - 1) < end;) {
      f.recording.time_ns.push_back(f.recording.time_ns.back() + 20000000);
      for (std::size_t k = 0; k < 3; ++k)
        f.recording.gyro[k].push_back(f.recording.gyro[k].back()), f.recording.accel[k].push_back(f.recording.accel[k].back());
    }
  };
  const auto named = Contains(HasSubstr("the vertical channel is free for 51 min"));
  go_on(2900);
  EXPECT_THAT(navigate({}, f.session, f.recording).warnings, Not(named));
  go_on(100);  // 3060 s; cosh(3020 / 570) = 100
  EXPECT_THAT(navigate({}, f.session, f.recording).warnings, named);
  EXPECT_THAT(navigate({}, f.session, f.recording, {.vertical = VerticalChannel::fixed}).warnings, Not(named));
}

TEST(Navigate, LateStampsOnEvenIncrementsMakeNoMotion) {
  // Stamps scatter by a fifth of the interval, and 4 rows are lost during acceleration: the increments still give the same path.
  const TemporaryFolder folder;
  FlightSession f = flight_session(0);
  f.session.initial = flight_start();
  RecordingSource& source = f.session.recordings[0];
  source.gyro = {.columns = {"gx", "gy", "gz"}, .output = Output::increment, .unit = "rad"};
  source.accel = {.columns = {"ax", "ay", "az"}, .output = Output::increment, .unit = "m/s"};
  f.recording.gyro_increment = f.recording.accel_increment = true;
  const RandomStream draws(3, "late stamps");
  for (std::size_t i = 0; i + 1 < f.recording.size(); ++i)  // clipped, so that they ascend
    f.recording.time_ns[i] += static_cast<std::int64_t>(4e6 * std::clamp(draws.normal(i), -2.4, 2.4));
  FlightSession whole = f;
  f.recording = without(without(f.recording, 2510, 2512), 2500, 2502);
  write(folder, "whole", whole);
  write(folder, "holed", f);
  for (const std::string name : {"whole", "holed"}) {
    const Session session = read_session(folder / name);
    const Navigated n = navigate({}, session, read_recording(session, session.recordings[0]).recording);
    EXPECT_EQ(n.gaps.size(), name == "whole" ? 0u : 2u);
    EXPECT_THAT(n.warnings, testing::Contains(HasSubstr("increments are taken as they are")));
    // Gravity up to a late stamp affects only the height. Rows lost during acceleration cost millimeters; half a false interval would be 0.4 m.
    EXPECT_LT(end_error(n, f.truth).horizontal(), 0.1) << name;
  }
}

TEST(Navigate, LeverArmsOfTheAccelerometersAreRemoved) {
  FlightSession f = flight_session(0);
  f.session.initial = flight_start();
  Calibration c;
  c.model.lever_arm << 0.5, 0, 0, 0, -0.4, 0.1, 0.2, 0, 0.3;
  // Forces at the arms come from the readings: rates of 6 deg/s and their change give some mm/s^2, meters after a minute.
  Recording moved = f.recording;
  Matrix3d arms = -c.model.lever_arm;
  remove_lever_arms(moved, arms);
  EXPECT_GT(end_error(navigate({}, f.session, moved), f.truth).position.norm(), 0.1);
  EXPECT_LT(end_error(navigate(c, f.session, moved), f.truth).position.norm(), 2e-3);
}

TEST(Navigate, LeverArmsSeeTheCentripetalAndTheTangentialForce) {
  Recording r;
  r.interval_s = 0.1;
  for (std::size_t i = 0; i < 3; ++i) {
    r.time_ns.push_back(100000000 * static_cast<std::int64_t>(i + 1));
    for (auto& column : r.accel) column.push_back(0);
    r.gyro[0].push_back(0);
    r.gyro[1].push_back(0);
    r.gyro[2].push_back(2 + 0.5 * static_cast<double>(i));  // 5 rad/s^2 about z
  }
  Matrix3d arm = Matrix3d::Zero();
  arm(0, 0) = 0.1;  // x accelerometer, 0.1 m along x: measures -w^2 r
  arm(1, 0) = 0.1;  // y accelerometer, also there: measures w' r
  remove_lever_arms(r, arm);
  EXPECT_NEAR(r.accel[0][1], 2.5 * 2.5 * 0.1, 1e-12);
  EXPECT_NEAR(r.accel[1][1], -5 * 0.1, 1e-12);
  EXPECT_NEAR(r.accel[2][1], 0, 1e-12);
}

TEST(Navigate, PlaceAndHeadingAreAskedForWhereTheyAreMissing) {
  FlightSession f = flight_session(1);
  f.session.site.longitude.reset();
  EXPECT_THAT(navigate({}, f.session, f.recording).warnings[0], HasSubstr("no longitude"));
  f.session.site = {};
  EXPECT_THROW(navigate({}, f.session, f.recording), Error);
  f.session.initial = flight_start();
  EXPECT_TRUE(navigate({}, f.session, f.recording, {.align = true}).aligned);
  f.session.imu.gyro_noise_density = 0.3 * unit::deg_per_sqrt_h;  // a gyro that does not resolve the Earth's rate
  try {
    navigate({}, f.session, f.recording, {.align = true});
    FAIL();
  } catch (const Unsupported& e) {
    EXPECT_THAT(e.what(), HasSubstr("do not resolve the Earth's rate"));
    EXPECT_THAT(e.what(), HasSubstr("give the heading (--heading) or an initial state"));
  }
  const Navigated n = navigate({}, f.session, f.recording, {.heading = GivenHeading{30 * unit::deg, 0}});
  EXPECT_NEAR(euler_angles(n.solution.states[0].q_nb.toRotationMatrix()).heading, 30 * unit::deg, 1e-7);
  EXPECT_LT(std::abs(navigation_errors(n.solution, f.truth).history.front().attitude.x()), 1e-4);
}

TEST(Navigate, AlignmentTakesTheCalibrationsErrorAtTheReadingOfTheRest) {
  // A unit in counts about 30000: the errors of offset at zero counts and of scale cancel at the counts of the rest.
  FlightSession f = flight_session(1);
  const double scale = 1e-5, zero = 30000, scale_sigma = 1e-4 * scale;
  for (auto& column : f.recording.gyro)
    for (double& value : column) value = value / scale + zero;
  Calibration c;
  c.model.gyro.matrix *= scale;
  c.model.gyro.offset.setConstant(-scale * zero);
  const double exact = std::sqrt(navigate(c, f.session, f.recording).aligned->alignment.attitude.covariance(2, 2));
  for (int i = 0; i < 3; ++i) {
    c.estimated.push_back(coefficient_index(Triad::gyro, Term::offset, i, i));
    c.estimated.push_back(coefficient_index(Triad::gyro, Term::matrix, i, i));
  }
  c.covariance = Eigen::MatrixXd::Zero(6, 6);
  for (int i = 0; i < 6; i += 2) {
    c.covariance(i, i) = std::pow(zero * scale_sigma, 2);
    c.covariance(i + 1, i + 1) = std::pow(scale_sigma, 2);
    c.covariance(i, i + 1) = c.covariance(i + 1, i) = -zero * scale_sigma * scale_sigma;
  }
  const double with = std::sqrt(navigate(c, f.session, f.recording).aligned->alignment.attitude.covariance(2, 2));
  EXPECT_NEAR(with / exact, 1, 0.01);  // a relative 1e-4 of the Earth's rate, compared with noise of some 10 %
  for (int i = 0; i < 6; i += 2) c.covariance(i, i + 1) = c.covariance(i + 1, i) = 0;
  EXPECT_THROW(navigate(c, f.session, f.recording), Unsupported);  // 3e-5 rad/s: half of the Earth's rate
}

TEST(Navigate, AnglesHaveTheSigmasOfTheirOwnErrors) {
  Alignment a;
  a.C_nb = attitude_matrix({0.3, 0.5, 1});
  a.covariance.diagonal() << 1e-6, 4e-6, 9e-6;
  const Eigen::Vector3d sigma = angle_sigmas(a);
  // Pitch is the tilt about the level axis right of the heading: (cos h, -sin h) of east and north.
  EXPECT_NEAR(sigma.y(), std::sqrt(1e-6 * std::pow(std::cos(1), 2) + 4e-6 * std::pow(std::sin(1), 2)), 1e-9);
  // Heading: phi_U and tan(pitch) times the tilt about the level axis along the heading; roll: that tilt over cos(pitch).
  const double along = 1e-6 * std::pow(std::sin(1), 2) + 4e-6 * std::pow(std::cos(1), 2);
  EXPECT_NEAR(sigma.x(), std::sqrt(along) / std::cos(0.5), 1e-8);
  EXPECT_NEAR(sigma.z(), std::sqrt(9e-6 + along * std::pow(std::tan(0.5), 2)), 1e-8);
}

}  // namespace
}  // namespace imulab
