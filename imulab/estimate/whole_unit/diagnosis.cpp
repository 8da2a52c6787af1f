#include "imulab/core/statistics.hpp"
#include "imulab/core/units.hpp"
#include "imulab/estimate/whole_unit/quality.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <vector>

namespace imulab::whole_unit {

using Eigen::Index;
using Eigen::VectorXd;

namespace {

/// K/s: 9 mK over a record of ten seconds, below what thermal readings agree to. Readings in raw count as if their range were 70 K.
constexpr double settled = 0.05 / 60;
/// Probability of a warning in a good session, shared among all tests of a kind.
constexpr double level = 1e-3;

/// The triad whose thermal readings the chamber is judged by.
std::size_t thermometer(const Problem& problem) { return problem.points.thermal[0].known ? 0 : 1; }

bool warn_unsettled(kernel::Findings& findings, const Problem& problem) {
  std::size_t many = 0;
  std::string first;
  double largest = 0;
  const ThermalRange& thermal = problem.points.thermal[thermometer(problem)];
  const bool raw = thermal.unit == "raw";
  const double kelvin = raw ? thermal.size() / 70 : 1;
  for (const MachinePoint& p : problem.points.all) {
    if (p.machine != RigKind::chamber || !p.drift || std::abs(*p.drift) <= settled * kelvin) continue;
    if (many++ == 0) first = p.name(*problem.session);
    largest = std::max(largest, std::abs(*p.drift));
  }
  if (many > 0)
    findings.warn(fmt::format(
        "{} of the chamber's points had not settled (up to {:.2g} {}/min; the first: {}): the sensors lag behind their thermal readings, and "
        "the thermal coefficients are biased beyond the stated uncertainties; wait longer at each temperature",
        many, largest * 60, raw ? "raw" : "K", first));
  return many > 0;
}

/// The chamber's points at one temperature, reached by warming and by cooling.
struct Directions {
  Vector6d sum[2] = {Vector6d::Zero(), Vector6d::Zero()};
  int n[2] = {0, 0};
};

bool warn_hysteresis(kernel::Findings& findings, const Problem& problem) {
  std::map<long, Directions> by_temperature;
  const std::size_t triad = thermometer(problem);
  const auto reading = [&](const MachinePoint& p) { return p.temperature[static_cast<Index>(3 * triad)]; };
  // Visits to one set point; without set points, readings within a fortieth of the range.
  const auto visit = [&](const MachinePoint& p) {
    return p.step.temperature ? std::lround(100 * *p.step.temperature) : std::lround(40 * reading(p) / problem.points.thermal[triad].size());
  };
  const MachinePoint* before = nullptr;
  for (const MachinePoint& p : problem.points.all) {
    if (p.machine != RigKind::chamber) continue;
    if (before && before->recording == p.recording) {
      Directions& directions = by_temperature[visit(p)];
      const std::size_t warmer = reading(p) > reading(*before) ? 1 : 0;
      directions.sum[warmer] += problem.equations(p).residual, ++directions.n[warmer];
    }
    before = &p;
  }
  Vector6d difference = Vector6d::Zero(), square = Vector6d::Zero();
  double n = 0;
  for (const auto& [temperature, directions] : by_temperature) {
    if (directions.n[0] == 0 || directions.n[1] == 0) continue;
    const Vector6d d = directions.sum[1] / directions.n[1] - directions.sum[0] / directions.n[0];
    difference += d, square += d.cwiseAbs2(), n += 1;
  }
  if (n < 3) return false;
  bool found = false;
  for (Index k = 0; k < 6; ++k) {
    const double mean = difference[k] / n, sigma = std::sqrt(std::max(square[k] / n - mean * mean, 1e-300) / (n - 1));
    if (std::abs(mean) < normal_quantile(1 - level / 12) * sigma * (1 + 4 / n)) continue;  // a little more for Student's few degrees
    found = true;
    findings.warn(fmt::format("{} {} differs by {:.2g} {} between warming and cooling: hysteresis, which the model does not have",
                              k < 3 ? "accel" : "gyro", "xyz"[k % 3], k < 3 ? mean / unit::ug : mean / unit::deg_per_h, k < 3 ? "ug" : "deg/h"));
  }
  return found;
}

/// Errors of a machine that change together.
struct Hypothesis {
  std::string name;
  double unit;
  const char* unit_name;
  double largest;      ///< beyond this the linear fit means nothing
  VectorXd direction;  ///< among the parameters
};

std::vector<Hypothesis> hypotheses(const Problem& problem) {
  std::map<std::string, Hypothesis> by_name;
  for (std::size_t k = 0; k < problem.common.size(); ++k) {
    const CommonError& error = problem.common[k];
    const auto add = [&](const std::string& name, double unit, const char* unit_name, double largest) {
      Hypothesis& h = by_name.try_emplace(name, Hypothesis{name, unit, unit_name, largest, VectorXd::Zero(problem.size())}).first->second;
      h.direction[static_cast<Index>(problem.coefficients.size() + k)] = 1;
    };
    const std::string rig = error.rig.empty() ? "the rig" : error.rig;
    if (k == 0) {
      add("gravity", 1e-3, "mm/s^2", 0.05);
    } else if (error.source.kind == RigErrorKind::radius) {
      add(rig + ": every radius", 1e-3, "mm", 1);
      add(rig + ": radius of mount " + mount_name(error.source.place), 1e-3, "mm", 1);
    } else if (error.source.kind == RigErrorKind::rate) {
      add(rig + ": rate", 1e-2, "%", 0.1);
    } else if (error.source.kind == RigErrorKind::mount) {
      add(fmt::format("{}: mount {}, turned about {}", rig, mount_name(error.source.place), "xyz"[error.source.axis]), unit::deg, "deg",
          10 * unit::deg);
    } else if (error.source.kind == RigErrorKind::tilt) {
      add(fmt::format("{}: its axis, towards {}", rig, error.source.axis == 0 ? "south" : "east"), unit::deg, "deg", 10 * unit::deg);
    }
  }
  std::vector<Hypothesis> all;
  for (auto& [name, h] : by_name) all.push_back(std::move(h));
  return all;
}

}  // namespace

std::string wrong_machine(const Problem& problem) {
  const kernel::Information data = problem.information();
  const kernel::Solution s = kernel::solve(data, problem.parameters(), "the points");
  const VectorXd slope = data.g + data.N * s.x;  // half of that of the sum of squares, at the solution
  const std::vector<Hypothesis> all = hypotheses(problem);
  const Hypothesis* worst = nullptr;
  double most = 0, by = 0;
  for (const Hypothesis& h : all) {
    // One more direction to move in: its curvature less what the free parameters explain of it, whose own slope and that of their priors cancel.
    const VectorXd nd = data.N * h.direction;
    const double curvature = h.direction.dot(nd) - nd.dot(s.covariance * nd), gradient = h.direction.dot(slope);
    // Directions that the estimate follows anyway say nothing.
    if (!(curvature > 1e-9 * h.direction.dot(nd)) || !(h.direction.dot(nd) > 0)) continue;
    const double saved = gradient * gradient / curvature;
    if (std::abs(gradient / curvature) > h.largest) continue;
    if (saved > most) most = saved, by = -gradient / curvature, worst = &h;
  }
  if (!worst || log_chi_square_tail(most, 1) > std::log(level / static_cast<double>(all.size()))) return "";
  // In points that scatter more than they should, the one thing to name is what explains a good part of that.
  const double excess = s.chi2 - s.degrees_of_freedom / (problem.noise_factor * problem.noise_factor);
  if (most < 0.3 * excess) return "";
  return fmt::format(
      "{}: not as declared; the data fit best with {:+.3g} {} (chi2 falls by {:.3g}): what depends on it is biased beyond the stated uncertainties",
      worst->name, by / worst->unit, worst->unit_name, most);
}

void check_chamber(kernel::Findings& findings, const Problem& problem) {
  const bool unsettled = warn_unsettled(findings, problem), hysteresis = warn_hysteresis(findings, problem);
  if (unsettled || hysteresis) findings.doubt("the chamber's points do not settle or do not repeat");
}

}  // namespace imulab::whole_unit
