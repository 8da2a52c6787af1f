#include "imulab/estimate/whole_unit_diagnosis.hpp"

#include "imulab/core/statistics.hpp"
#include "imulab/core/units.hpp"
#include "imulab/rig/machine.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <map>

namespace imulab {

using Eigen::Index;
using Eigen::VectorXd;

namespace {

constexpr double settled =
    0.05 / 60;  // K/s: 9 mK over a record of ten seconds, below what thermal readings agree to; of readings in raw, 70 K are their range
constexpr double level = 1e-3;  // a warning in a good session, shared among all tests of a kind

void find_unsettled(const WholeUnitProblem& problem, std::vector<std::string>& found) {
  std::size_t many = 0;
  std::string first;
  double largest = 0;
  const WholeUnitPoints& points = problem.points();
  const std::size_t thermometer = points.thermal[0] ? 0 : 1;
  const bool raw = points.thermal_unit[thermometer] == "raw";
  const double kelvin = raw ? (points.thermal_range_high[thermometer] - points.thermal_range_low[thermometer]) / 70 : 1;
  for (const WholeUnitPoint& p : problem.points().points) {
    if (problem.kind(p) != RigKind::chamber || !p.drift || std::abs(*p.drift) <= settled * kelvin) continue;
    if (many++ == 0) first = p.name(problem.session());
    largest = std::max(largest, std::abs(*p.drift));
  }
  if (many > 0)
    found.push_back(fmt::format(
        "{} of the chamber's points had not settled (up to {:.2g} {}/min; the first: {}): the sensors lag behind their thermal readings, and "
        "the thermal coefficients are off by what the uncertainties do not say",
        many, largest * 60, raw ? "raw" : "K", first));
}

/// Errors of a machine that move together, and what freeing them would save.
struct Suspicion {
  std::string what;
  std::vector<std::pair<Index, double>> direction;  ///< parameters and their share
  double unit;
  const char* unit_name;
  double largest;  ///< beyond this the linear fit means nothing
};

std::vector<Suspicion> suspicions(const WholeUnitProblem& problem) {
  std::map<std::string, Suspicion> by_name;
  const auto first = static_cast<Index>(problem.coefficients().size());
  for (std::size_t k = 0; k < problem.common().size(); ++k) {
    const CommonError& error = problem.common()[k];
    const auto add = [&](const std::string& what, double unit, const char* unit_name, double largest) {
      Suspicion& s = by_name.try_emplace(what, Suspicion{what, {}, unit, unit_name, largest}).first->second;
      s.direction.emplace_back(first + static_cast<Index>(k), 1.0);
    };
    const std::string rig = error.rig.empty() ? "the rig" : error.rig;
    if (k == 0) {
      add("gravity", 1e-3, "mm/s^2", 0.05);
    } else if (error.source.kind == RigErrorKind::radius) {
      add(rig + ": every radius_m", 1e-3, "mm", 1);
      add(rig + ": radius_m of mount " + mount_name(error.source.place), 1e-3, "mm", 1);
    } else if (error.source.kind == RigErrorKind::rate) {
      add(rig + ": rate_dps", 1e-2, "%", 0.1);
    } else if (error.source.kind == RigErrorKind::mount) {
      add(fmt::format("{}: mount {}, turned about {}", rig, mount_name(error.source.place), "xyz"[error.source.axis]), unit::deg, "deg",
          10 * unit::deg);
    } else if (error.source.kind == RigErrorKind::tilt) {
      add(fmt::format("{}: its axis, towards {}", rig, error.source.axis == 0 ? "south" : "east"), unit::deg, "deg", 10 * unit::deg);
    }
  }
  std::vector<Suspicion> all;
  for (auto& [name, s] : by_name) all.push_back(std::move(s));
  return all;
}

/// The chi-square that letting a suspicion's errors move together would save, and by how much they would.
void find_wrong_machines(const WholeUnitProblem& problem, const WholeUnitPrior& prior, const std::vector<Part>& parts,
                         std::vector<std::string>& found) {
  const SquareSum sum = problem.square_sum();
  const Knowledge known = knowledge(problem, prior, parts, Weak::held);
  // With one direction a more loose: its curvature less what the loose parameters explain of it.
  const Solution s = solve(sum, known);
  VectorXd pull = VectorXd::Zero(problem.size());  // of what is known
  for (Index i = 0; i < pull.size(); ++i)
    if (known.sigma[i] > 0 && !std::isinf(known.sigma[i])) pull[i] = (s.x[i] - known.offset[i]) / (known.sigma[i] * known.sigma[i]);
  const VectorXd slope = sum.g + sum.N * s.x;
  const std::vector<Suspicion> all = suspicions(problem);
  const Suspicion* worst = nullptr;
  double most = 0, by = 0;
  for (const Suspicion& suspicion : all) {
    VectorXd d = VectorXd::Zero(problem.size());
    for (const auto& [i, share] : suspicion.direction) d[i] = share;
    const VectorXd nd = sum.N * d;
    const double curvature = d.dot(nd) - nd.dot(s.covariance * nd);
    const double gradient = d.dot(slope) - (s.covariance * nd).dot(slope + pull);
    // Directions that the estimate follows anyway say nothing.
    if (!(curvature > 1e-9 * d.dot(nd)) || !(d.dot(nd) > 0)) continue;
    const double saved = gradient * gradient / curvature;
    if (std::abs(gradient / curvature) > suspicion.largest) continue;
    if (saved > most) most = saved, by = -gradient / curvature, worst = &suspicion;
  }
  if (!worst || log_chi_square_tail(most, 1) > std::log(level / static_cast<double>(all.size()))) return;
  // In points that scatter more than they should, the one thing to name is what explains a good part of that.
  const double excess = s.chi2 - s.degrees_of_freedom / (problem.noise_factor() * problem.noise_factor());
  if (most < 0.3 * excess) return;
  found.push_back(fmt::format(
      "{}: not as declared; the data fit best with {:+.3g} {} (chi2 falls by {:.3g}): what depends on it is off by what the uncertainties do not say",
      worst->what, by / worst->unit, worst->unit_name, most));
}

/// The chamber's points at one temperature, reached by warming and by cooling.
void find_hysteresis(const WholeUnitProblem& problem, std::vector<std::string>& found) {
  struct Sides {
    Vector6d sum[2] = {Vector6d::Zero(), Vector6d::Zero()};
    int n[2] = {0, 0};
  };
  std::map<long, Sides> by_temperature;
  const WholeUnitPoint* before = nullptr;
  const WholeUnitPoints& points = problem.points();
  const std::size_t thermometer = points.thermal[0] ? 0 : 1;
  const double range = points.thermal_range_high[thermometer] - points.thermal_range_low[thermometer];
  // Visits to one set point; without set points, readings within a fortieth of the range.
  const auto visit = [&](const WholeUnitPoint& p) {
    return p.step.temperature ? std::lround(100 * *p.step.temperature) : std::lround(40 * p.temperature[static_cast<Index>(3 * thermometer)] / range);
  };
  for (const WholeUnitPoint& p : problem.points().points) {
    if (problem.kind(p) != RigKind::chamber) continue;
    if (before && before->recording == p.recording) {
      const double now = p.temperature[static_cast<Index>(3 * thermometer)], then = before->temperature[static_cast<Index>(3 * thermometer)];
      Sides& sides = by_temperature[visit(p)];
      const std::size_t side = now > then ? 1 : 0;
      sides.sum[side] += problem.equations(p).residual, ++sides.n[side];
    }
    before = &p;
  }
  Vector6d difference = Vector6d::Zero(), square = Vector6d::Zero();
  double n = 0;
  for (const auto& [temperature, sides] : by_temperature) {
    if (sides.n[0] == 0 || sides.n[1] == 0) continue;
    const Vector6d d = sides.sum[1] / sides.n[1] - sides.sum[0] / sides.n[0];
    difference += d, square += d.cwiseAbs2(), n += 1;
  }
  if (n < 3) return;
  for (Index k = 0; k < 6; ++k) {
    const double mean = difference[k] / n, sigma = std::sqrt(std::max(square[k] / n - mean * mean, 1e-300) / (n - 1));
    if (std::abs(mean) < normal_quantile(1 - level / 12) * sigma * (1 + 4 / n)) continue;  // a little more for Student's few degrees
    found.push_back(fmt::format("{} {} differs by {:.2g} {} between warming and cooling: hysteresis, which the model has not",
                                k < 3 ? "accel" : "gyro", "xyz"[k % 3], k < 3 ? mean / unit::ug : mean / unit::deg_per_h, k < 3 ? "ug" : "deg/h"));
  }
}

}  // namespace

std::vector<std::string> wrong_machines(const WholeUnitProblem& problem, const WholeUnitPrior& prior, const std::vector<Part>& parts) {
  std::vector<std::string> found;
  find_wrong_machines(problem, prior, parts, found);
  return found;
}

std::vector<std::string> wrong_chamber(const WholeUnitProblem& problem) {
  std::vector<std::string> found;
  find_unsettled(problem, found);
  find_hysteresis(problem, found);
  return found;
}

}  // namespace imulab
