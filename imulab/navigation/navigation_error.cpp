#include "imulab/navigation/navigation_error.hpp"

#include "imulab/core/statistics.hpp"
#include "imulab/error.hpp"
#include "imulab/navigate.hpp"
#include "imulab/navigation/budget/error_dynamics.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <numbers>

namespace imulab {
namespace {

using Eigen::Vector3d;

constexpr double same_stamp = 1e-7;  // s: files write nanoseconds

/// Latitude, longitude (near `longitude`) and height, with their rates.
struct Place {
  Vector3d value, rate;
};

Place place_of(const NavigationState& s, double longitude) {
  const LocalEarth e = local_earth(s.latitude, s.height);
  return {{s.latitude, longitude + std::remainder(s.longitude - longitude, 2 * std::numbers::pi), s.height},
          {s.velocity.y() / e.meridian_radius, s.velocity.x() / (e.transverse_radius * e.cos_latitude), s.velocity.z()}};
}

/// Interpolates between two states `h` [s] apart, at the fraction x of h.
NavigationState between(const NavigationState& a, const NavigationState& b, double h, double x) {
  const Place p = place_of(a, a.longitude), q = place_of(b, a.longitude);
  const double x2 = x * x, x3 = x2 * x;
  const Vector3d value = (2 * x3 - 3 * x2 + 1) * p.value + (x3 - 2 * x2 + x) * h * p.rate + (3 * x2 - 2 * x3) * q.value + (x3 - x2) * h * q.rate;
  const Vector3d rate = 6 * (x2 - x) / h * (p.value - q.value) + (3 * x2 - 4 * x + 1) * p.rate + (3 * x2 - 2 * x) * q.rate;
  NavigationState s;
  s.latitude = value.x();
  s.longitude = value.y();
  s.height = value.z();
  const LocalEarth e = local_earth(s.latitude, s.height);
  s.velocity = {rate.y() * e.transverse_radius * e.cos_latitude, rate.x() * e.meridian_radius, rate.z()};
  s.q_nb = a.q_nb.slerp(x, b.q_nb);
  return s;
}

/// Returns the state at a time within the solution.
NavigationState at(const Solution& s, double t) {
  const auto after = std::lower_bound(s.time.begin(), s.time.end(), t - same_stamp);
  const auto i = static_cast<std::size_t>(after - s.time.begin());
  if (i == s.size()) return s.states.back();
  if (i == 0 || s.time[i] - t < same_stamp) return s.states[i];
  const double h = s.time[i] - s.time[i - 1];
  return between(s.states[i - 1], s.states[i], h, (t - s.time[i - 1]) / h);
}

NavigationError error_at(double time, const NavigationState& s, const NavigationState& truth) {
  using At = budget::ErrorIndex;
  const budget::ErrorState e = budget::error_of(s, truth);
  return {time, e.segment<3>(At::position), e.segment<3>(At::velocity), e.segment<3>(At::attitude)};
}

std::size_t rows_between(const Solution& s, double begin, double end) {
  return static_cast<std::size_t>(std::upper_bound(s.time.begin(), s.time.end(), end + same_stamp) -
                                  std::lower_bound(s.time.begin(), s.time.end(), begin - same_stamp));
}

}  // namespace

void validate(const Solution& solution) {
  if (solution.states.size() != solution.time.size())
    throw Error(fmt::format("a solution with {} times and {} states; expected as many of each", solution.time.size(), solution.states.size()));
}

void validate(const HeightRecord& record) {
  const auto finite = [](double value) { return std::isfinite(value); };
  const auto& [time, height] = record;
  if (time.size() != height.size() || !std::all_of(time.begin(), time.end(), finite) || !std::all_of(height.begin(), height.end(), finite) ||
      !std::is_sorted(time.begin(), time.end(), std::less_equal()))
    throw Error(fmt::format("barometer: {} times and {} heights; expected as many of each, finite, the times ascending", time.size(), height.size()));
}

void validate(const GivenHeading& heading) {
  if (!(std::abs(heading.value) <= 2 * std::numbers::pi && heading.sigma >= 0 && std::isfinite(heading.sigma)))
    throw Error(fmt::format("a given heading of {:g} rad with a sigma of {:g} rad; expected -2 pi to 2 pi, and a sigma of at least 0", heading.value,
                            heading.sigma));
}

NavigationErrors navigation_errors(const Solution& solution, const Solution& truth) {
  if (solution.size() == 0 || truth.size() == 0) throw Error("comparison with a reference solution: expected at least one row of each");
  validate(solution), validate(truth);
  const double begin = std::max(solution.time.front(), truth.time.front()), end = std::min(solution.time.back(), truth.time.back());
  const auto range = [](const Solution& s) { return fmt::format("{:.3f} s to {:.3f} s", s.time.front(), s.time.back()); };
  if (end < begin - same_stamp)
    throw Error(fmt::format("the truth runs from {}, the solution from {}: expected times that overlap", range(truth), range(solution)));
  NavigationErrors out;
  const double step = solution.size() > 1 ? solution.time.back() - solution.time[solution.size() - 2] : 0;
  const double truth_step = truth.size() > 1 ? (truth.time.back() - truth.time.front()) / static_cast<double>(truth.size() - 1) : 0;
  const double margin = 1.5 * std::max(step, truth_step);
  if (begin - solution.time.front() > margin || solution.time.back() - end > margin)
    out.warnings.push_back(
        fmt::format("the truth runs from {}, the solution from {}: errors are known from {:.3f} s to {:.3f} s only, and the end "
                    "errors are those at {:.3f} s",
                    range(truth), range(solution), begin, end, end));
  const Solution& coarser = rows_between(truth, begin, end) < rows_between(solution, begin, end) ? truth : solution;
  std::vector<double> times;
  for (const double t : coarser.time)
    if (t >= begin - same_stamp && t <= end + same_stamp) times.push_back(t);
  if (times.empty() || end - times.back() > same_stamp) times.push_back(end);
  for (const double t : times) out.history.push_back(error_at(t, at(solution, t), at(truth, t)));
  const double navigated = out.history.back().time - solution.time.front();
  out.rate = navigated > 0 ? out.history.back().horizontal() / navigated : 0;
  return out;
}

void ComparedStates::add(double time, const NavigationState& state) {
  solution_.time.push_back(time), solution_.states.push_back(state), needed_.push_back(needed_.empty());
  const auto size = static_cast<std::ptrdiff_t>(needed_.size());
  bool passes = false;
  for (; passed_ < truth_.size() && truth_.time[passed_] - same_stamp <= time; ++passed_) passes = true;
  if (passes) std::fill(needed_.end() - std::min<std::ptrdiff_t>(2, size), needed_.end(), true);
  if (size < 3 || needed_[needed_.size() - 3]) return;
  solution_.time.erase(solution_.time.end() - 3), solution_.states.erase(solution_.states.end() - 3), needed_.erase(needed_.end() - 3);
}

RateSummary rate_summary(const std::vector<double>& rates) {
  double square = 0;
  for (const double rate : rates) square += rate * rate;
  return {std::sqrt(square / static_cast<double>(rates.size())), median(rates)};
}

}  // namespace imulab
