// Fleets whose sessions are simulated, written, and calibrated by the documented commands: `fleet calibrate --method handheld`, then `fleet stats`.
#include "imulab/core/statistics.hpp"
#include "imulab/files.hpp"
#include "imulab/fleet.hpp"
#include "imulab/fleet/statistics/statistics.hpp"
#include "imulab/procedure.hpp"
#include "imulab/tasks/fleet.hpp"
#include "imulab/tasks/simulate.hpp"
#include "imulab/units.hpp"

#include "tests/acceptance/acceptance.hpp"
#include "tests/acceptance/shared_runs.hpp"
#include "tests/temporary_folder.hpp"
#include <set>
#include <string>

namespace imulab::acceptance {

namespace {

// A calibration by hand determines 39 coefficients; the test for outliers needs 43 units, and twice as many are common.
constexpr std::uint64_t units_by_hand = 86, off = 17;
constexpr double false_alarm_by_hand = 0.05;

struct FleetByHand {
  double calibrated = 0, named = 0, others = 0, wrongly_left = 0, means = 0, covered = 0;
  void fields(auto&& visit) { visit(calibrated, named, others, wrongly_left, means, covered); }
};

/// Sessions of all units below a folder. One has an accelerometer that is 0.5 g off.
void write_week(const std::filesystem::path& folder, std::uint64_t seed) {
  for (std::uint64_t unit = 0; unit < units_by_hand; ++unit) {
    Session procedure = hand_held_procedure({}, 1);
    procedure.imu.name = "unit", procedure.imu.serial = std::to_string(unit);
    SimulationTask task{.seed = seed * units_by_hand + unit};
    if (unit == off) {
      task.unit = simulate_session(procedure, task).truth;
      task.unit->model.accel.offset.x() += 0.5 * unit::g;
    }
    write_simulated(folder / std::to_string(unit), simulate_session(procedure, task));
  }
}

/// The coefficients that the calibrations say to have kept their prior, in every unit.
std::set<std::string> kept_priors(FleetStore& store) {
  std::set<std::string> kept;
  bool first = true;
  for (const FleetRecord& record : store.records()) {
    const std::vector<std::string> here = parse_calibration(store.calibration_file(record.id), record.name).quality.considered;
    const std::set<std::string> names(here.begin(), here.end());
    if (first)
      kept = names;
    else
      std::erase_if(kept, [&](const std::string& name) { return !names.contains(name); });
    first = false;
  }
  return kept;
}

FleetByHand fleet_of(std::uint64_t seed) {
  const TemporaryFolder folder;
  write_week(folder / "week", seed);
  FleetStore store(folder / "fleet.db", fleet::Access::write);
  FleetByHand out;
  out.calibrated = static_cast<double>(calibrate_fleet(sessions_below({folder / "week"}), {.method = "handheld"}, store).calibrated);
  FleetOptions options;
  options.false_alarm = false_alarm_by_hand;
  const FleetStatistics f = fleet_statistics(store, options);
  for (const FleetOutlier& o : f.search.outliers) {
    const bool is_off = f.sample.unit_of_row(f.sample.last[static_cast<std::size_t>(o.unit)]) == "unit " + std::to_string(off);
    (is_off ? out.named : out.others) += 1;
  }
  std::set<std::string> left_out;
  for (const CoefficientIndex index : f.sample.left_out) left_out.emplace(coefficient(index).name);
  out.wrongly_left = left_out == kept_priors(store) ? 0 : 1;
  for (const CoefficientStatistics& c : f.coefficients) {
    const Coefficient& k = coefficient(c.index);
    if (is_optional(k.term)) continue;
    const double nominal = is_scale(k) ? 1 : 0;
    out.means += 1;
    out.covered += c.fleet.mean_low <= nominal && nominal <= c.fleet.mean_high;
  }
  return out;
}

}  // namespace

std::vector<Check> fleets_by_hand(int count) {
  FleetByHand sum;
  double with_others = 0;
  for (const FleetByHand& f : runs_of<FleetByHand>("fleet by hand", count, [](std::size_t k) { return fleet_of(k + 1); })) {
    sum.calibrated += f.calibrated, sum.named += f.named, sum.wrongly_left += f.wrongly_left, sum.means += f.means, sum.covered += f.covered;
    with_others += f.others > 0;
  }
  const auto n = static_cast<double>(count);
  // Coefficients that are drawn independently: what the binomial distribution leaves in 999 of 1000 runs.
  return {{"sessions calibrated", sum.calibrated / (n * static_cast<double>(units_by_hand)), 1, 1},
          {"units 0.5 g off that are named", sum.named / n, 1, 1},
          {"fleets with another outlier", with_others / n, 0, binomial_quantile(0.999, n, false_alarm_by_hand) / n},
          {"fleets that leave out others than those that kept their prior", sum.wrongly_left, 0, 0},
          {"coverage of the mean", sum.covered / sum.means, binomial_quantile(0.0005, sum.means, 0.95) / sum.means,
           binomial_quantile(0.9995, sum.means, 0.95) / sum.means}};
}

}  // namespace imulab::acceptance
