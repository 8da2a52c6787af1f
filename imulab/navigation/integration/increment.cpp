#include "imulab/navigation/integration/increment.hpp"

#include "imulab/error.hpp"
#include "imulab/navigate.hpp"

#include <Eigen/Geometry>

#include <array>
#include <cmath>
#include <string>

namespace imulab::integration {
namespace {

using Eigen::Vector3d;

/// Returns the velocity for force and rate in a fixed ratio, in the axes of the start (methods of Savage 1998, closed form): dv + (1 - cos t)/t^2 (th
/// x dv) + (1 - sin t/t)/t^2 th x (th x dv).
Vector3d turned_velocity(const Vector3d& angle, const Vector3d& velocity) {
  const double t2 = angle.squaredNorm();
  double first, second;
  if (t2 < 0.01) {  // the series have errors of 1e-16
    first = 1. / 2 - t2 * (1. / 24 - t2 * (1. / 720 - t2 * (1. / 40320 - t2 * (1. / 3628800))));
    second = 1. / 6 - t2 * (1. / 120 - t2 * (1. / 5040 - t2 * (1. / 362880)));
  } else {
    const double t = std::sqrt(t2);
    first = (1 - std::cos(t)) / t2;
    second = (1 - std::sin(t) / t) / t2;
  }
  const Vector3d across = angle.cross(velocity);
  return velocity + first * across + second * angle.cross(across);
}

/// The weight of the product of two samples of a step, first < second.
struct Pair {
  std::size_t first, second;
  double weight;
};

/// Weights for N = 2 to 5 samples, exact for pure coning to order 2 N, like the published algorithms (Ignagni 1996). Those put the whole weight of
/// each distance second - first on the last sample. Only its sum matters for coning, so it is distributed symmetrically in time here and, with the
/// remaining freedom (four and five samples), so that a rate or force that is cubic (quartic up to one term) in time is integrated exactly.
constexpr std::array<Pair, 1> two{{{0, 1, 2. / 3}}};
constexpr std::array<Pair, 3> three{{{0, 1, 27. / 40}, {1, 2, 27. / 40}, {0, 2, 9. / 20}}};
constexpr std::array<Pair, 6> four{
    {{0, 1, 232. / 315}, {1, 2, 178. / 315}, {2, 3, 232. / 315}, {0, 2, 46. / 105}, {1, 3, 46. / 105}, {0, 3, 54. / 105}}};
constexpr std::array<Pair, 10> five{{{0, 1, 475. / 576},
                                     {1, 2, 2175. / 4032},
                                     {2, 3, 2175. / 4032},
                                     {3, 4, 475. / 576},
                                     {0, 2, 1325. / 4032},
                                     {1, 3, 2550. / 4032},
                                     {2, 4, 1325. / 4032},
                                     {0, 3, 525. / 1008},
                                     {1, 4, 525. / 1008},
                                     {0, 4, 250. / 504}}};
constexpr std::array<std::span<const Pair>, 6> pairs{{{}, {}, two, three, four, five}};

}  // namespace

BodyStep body_step(const Increment& sample, const Increment& previous) {
  return {
      sample.angle + (1. / 12) * previous.angle.cross(sample.angle),
      turned_velocity(sample.angle, sample.velocity) + (1. / 12) * (previous.angle.cross(sample.velocity) + previous.velocity.cross(sample.angle))};
}

BodyStep body_step(std::span<const Increment> samples) {
  const std::size_t n = samples.size();
  if (n < 1 || n > 5) throw Error("coning and sculling with " + std::to_string(n) + " samples: expected 1 to 5");
  Increment sum;
  for (const Increment& s : samples) {
    sum.angle += s.angle;
    sum.velocity += s.velocity;
  }
  BodyStep step{sum.angle, turned_velocity(sum.angle, sum.velocity)};
  for (const auto& [first, second, weight] : pairs[n]) {
    const Increment &a = samples[first], &b = samples[second];
    step.rotation += weight * a.angle.cross(b.angle);
    step.velocity += weight * (a.angle.cross(b.velocity) + a.velocity.cross(b.angle));
  }
  return step;
}

}  // namespace imulab::integration
