// The linear covariance of navigation errors against full integrations, at full size.
#include "imulab/navigation/budget/monte_carlo.hpp"
#include "imulab/navigation/budget/specification.hpp"
#include "imulab/navigation/motion/flight.hpp"
#include "imulab/units.hpp"

#include "tests/acceptance/acceptance.hpp"
#include "tests/acceptance/shared_runs.hpp"
#include <cmath>

namespace imulab::acceptance {

namespace {

using namespace motion;

ErrorSources sources_after_alignment() {
  ErrorSpecification s;
  s.grade = "navigation";
  s.start.velocity.fill({0.01});
  s.start.position.fill({5});
  s.start.aligned_over = 300;
  s.barometer = {{3}, 1, 10};
  return error_sources(s);
}

/// Sampled over linear sigma of the horizontal position, at a quarter, half, three quarters and the end of the motion.
void compare(const std::string& name, const Trajectory& motion, VerticalChannel vertical, int runs, std::vector<Check>& checks) {
  const NominalMotion nominal = nominal_motion(motion, 0.1);
  StrapdownOptions strapdown;
  strapdown.vertical = vertical;
  const double every = motion.duration / 4 + 0.01;  // the fourth is the end
  const ErrorSources sources = sources_after_alignment();
  const ErrorBudget linear = error_budget(nominal, sources, {.strapdown = strapdown, .output_interval = every});
  const Sharing sharing = sharing_of("error-growth " + name, static_cast<std::size_t>(runs));
  const ErrorDistribution full =
      error_monte_carlo(nominal, sources, {.strapdown = strapdown, .output_interval = every, .runs = static_cast<std::uint64_t>(runs)}, {}, &sharing);
  const double bound = std::max(0.05, 4 / std::sqrt(2.0 * runs));  // 5 %, or four sampling sigmas
  for (std::size_t at = 0; at < linear.time.size(); ++at)
    for (const int q : {0, 1})
      checks.push_back({name + (q == 0 ? " east" : " north") + " after " + std::to_string(std::lround(linear.time[at])) + " s",
                        full.sigma(q, static_cast<Eigen::Index>(at)) / std::sqrt(linear.covariance[at](q, q)), 1 - bound, 1 + bound});
}

}  // namespace

std::vector<Check> error_growth(int runs) {
  std::vector<Check> checks;
  const FlightStart airborne{.latitude = 31 * unit::deg, .longitude = 104 * unit::deg, .height = 500, .speed = 80};
  std::vector<Segment> pattern{straight(100)};
  for (int leg = 0; leg < 4; ++leg) pattern.insert(pattern.end(), {turn(-90 * unit::deg, 90. / 49 * unit::deg, 4), straight(100)});
  by_part([&] { compare("traffic pattern", flight(airborne, pattern), VerticalChannel::held, runs, checks); });

  const FlightStart parked{.latitude = 40 * unit::deg, .longitude = 116 * unit::deg, .height = 50};
  std::vector<Segment> drive{accelerate(60 / 3.6, 20)};
  for (int leg = 0; leg < 9; ++leg) drive.insert(drive.end(), {straight(350), turn((leg % 3 == 0 ? 90 : -90) * unit::deg, 6 * unit::deg, 3)});
  drive.push_back(straight(268));
  Carrier vehicle;
  vehicle.banks = false;
  by_part([&] { compare("drive", flight(parked, drive, vehicle), VerticalChannel::aided, runs, checks); });
  return checks;
}

}  // namespace imulab::acceptance
