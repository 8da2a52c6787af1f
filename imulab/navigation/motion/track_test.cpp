#include "imulab/core/random.hpp"
#include "imulab/core/rotation.hpp"
#include "imulab/eigen.hpp"
#include "imulab/error.hpp"
#include "imulab/navigation/motion/flight.hpp"

#include <gmock/gmock.h>

#include "tests/closed_form_flight.hpp"
#include <limits>

namespace imulab::motion {
namespace {

using ::testing::HasSubstr;

struct Difference {
  double rate = 0, force = 0;  // rad/s, m/s^2
};

/// Returns the largest differences over 20 ms increments, as means.
Difference difference(const Trajectory& a, const Trajectory& b) {
  const double interval = 0.02;
  const auto x = ideal_increments(a, interval), y = ideal_increments(b, interval);
  EXPECT_EQ(x.size(), y.size());
  Difference d;
  for (std::size_t i = 0; i < x.size(); ++i) {
    d.rate = std::max(d.rate, (x[i].angle - y[i].angle).norm() / interval);
    d.force = std::max(d.force, (x[i].velocity - y[i].velocity).norm() / interval);
  }
  return d;
}

TEST(Track, ASampledFlightHasItsIncrements) {
  const Trajectory flight = closed_form_flight(120);
  const auto error = [&](double h) { return difference(track(truth(flight, h)), flight); };
  // 3/8 h^2 times the fourth derivative of the path, 12.7 km (2 pi / 600 s)^4 = 1.5e-4 m/s^4, twice that at the ends, plus rounding of the latitude,
  // 1e-16 times the Earth's radius, which the second difference multiplies: 4/h^2 = 400 times 7e-10 m.
  EXPECT_LT(error(0.1).force, 2 * 0.375 * 0.01 * 1.5e-4 + 3e-7);
  // The orders are 2 and 3 (rate: one derivative of the attitude) if rounding is far below. 0.3 allows for the next orders.
  const Difference coarse = error(0.5), fine = error(0.25);
  EXPECT_NEAR(std::log2(coarse.force / fine.force), 2, 0.3);
  EXPECT_NEAR(std::log2(coarse.rate / fine.rate), 3, 0.3);
}

TEST(Track, IntegratedItComesBack) {
  const Trajectory t = track(truth(closed_form_flight(60), 0.5));
  Strapdown strapdown(navigation_state(t.at(0)));
  for (const Increment& sample : ideal_increments(t, 0.01)) strapdown.step(sample, 0.01);
  const Kinematics end = t.at(60);
  EXPECT_NEAR(strapdown.state().height, end.height, 1e-3);  // the track is a motion of its own: below a millimeter, like closed forms
  EXPECT_NEAR(strapdown.state().latitude, end.latitude, 1e-3 / 6.4e6);
  EXPECT_NEAR(strapdown.state().longitude, end.longitude, 1e-3 / 4.8e6);
  EXPECT_LT(rotation_log(end.C_nb.transpose() * strapdown.state().q_nb.toRotationMatrix()).norm(), 1e-9);
}

TEST(Track, SmoothingBringsNoiseDown) {
  const Trajectory flight = closed_form_flight(300);
  Solution rows = truth(flight, 1);
  const RandomStream random(7, 1);
  const double sigma = 2, radius = 6.37e6;
  std::uint64_t draw = 0;
  for (NavigationState& s : rows.states) {
    s.latitude += sigma / radius * random.normal(draw++);
    s.longitude += sigma / radius / std::cos(s.latitude) * random.normal(draw++);
    s.height += sigma * random.normal(draw++);
  }
  const auto error = [&](const Trajectory& t) {  // RMS of an axis, position and velocity
    Eigen::Vector2d sum(0, 0);
    for (double at = 0.5; at < 300; ++at) {
      const Kinematics a = t.at(at), b = flight.at(at);
      const Eigen::Vector3d way((a.longitude - b.longitude) * radius * std::cos(b.latitude), (a.latitude - b.latitude) * radius, a.height - b.height);
      sum += Eigen::Vector2d(way.squaredNorm(), (a.velocity - b.velocity).squaredNorm()) / 900;
    }
    return Eigen::Vector2d(sum.cwiseSqrt());
  };
  const Eigen::Vector2d through = error(track(rows)), smooth = error(track(rows, {.position = sigma}));
  EXPECT_GT(through(0), 0.5 * sigma);
  EXPECT_LT(smooth(0), 0.5 * sigma);      // some 20 s of the 1 Hz rows contribute at each point: sigma / sqrt(20), at most twice
  EXPECT_LT(smooth(1), through(1) / 10);  // noise of a velocity decreases with the 3/2 power of the time
}

TEST(Track, CrossesTheDateLine) {
  Solution rows;
  for (int i = 0; i < 10; ++i) {
    NavigationState s;
    s.longitude = std::remainder(3.1 + 0.01 * i, 2 * std::numbers::pi);
    s.q_nb.coeffs() *= i % 2 == 0 ? 1 : -1;  // the same attitude
    rows.time.push_back(100 + 10. * i);
    rows.states.push_back(s);
  }
  const Trajectory t = track(rows);
  EXPECT_EQ(t.duration, 90);
  for (double at = 0; at <= 90; at += 3.3) {
    EXPECT_NEAR(t.at(at).velocity.x(), 1e-3 * 6378137, 1e-6);  // rounding of 1e-9 m over 10 s, and of pi
    EXPECT_NEAR(t.at(at).rate_nb_b.norm(), 0, 1e-15);
  }
}

TEST(Track, RefusesWhatIsNoTrack) {
  const Solution good = truth(closed_form_flight(10), 1);
  const auto refusal = [&](auto damage) {
    Solution rows = good;
    damage(rows);
    try {
      track(rows);
    } catch (const Error& e) {
      return std::string(e.what());
    }
    return std::string("nothing");
  };
  EXPECT_EQ(refusal([](Solution&) {}), "nothing");
  EXPECT_THAT(refusal([](Solution& s) { s.time.resize(2), s.states.resize(2); }), HasSubstr("2 rows, expected at least 4"));
  EXPECT_THAT(refusal([](Solution& s) { s.time.resize(1), s.states.resize(1); }), HasSubstr("1 row, expected at least 4"));
  EXPECT_THAT(refusal([](Solution& s) { s.time[3] = s.time[2]; }), HasSubstr("track at 2.000 s: time does not ascend"));
  EXPECT_THAT(refusal([](Solution& s) { s.states[4].height = std::numeric_limits<double>::quiet_NaN(); }), HasSubstr("at 4.000 s: expected finite"));
  EXPECT_THAT(refusal([](Solution& s) { s.states[4].latitude = 1.5707; }), HasSubstr("at 4.000 s: latitude 89.99"));
  EXPECT_THAT(refusal([](Solution& s) { s.states[5].q_nb = s.states[5].q_nb * Eigen::Quaterniond(0, 1, 0, 0); }), HasSubstr("180 deg from the row"));
}

}  // namespace
}  // namespace imulab::motion
