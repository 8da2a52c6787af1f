#include "imulab/estimate/whole_unit_quality.hpp"

#include "imulab/core/units.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>

namespace imulab {

using Eigen::Index;

namespace {

/// Why a coefficient stayed open, where counting tells.
std::string open_reason(const WholeUnitProblem& problem, const Coefficient& c) {
  const int order = c.term == Term::quadratic ? 2 : c.term == Term::cubic ? 3 : 0;
  if (order == 0) return "";
  std::vector<double> levels;
  for (const WholeUnitPoint& p : problem.points().points) {
    const Motion m = problem.motion(p);
    const double level = c.triad == Triad::accel ? m.force[c.row] : m.rate[c.row], same = c.triad == Triad::accel ? 0.05 * unit::g : 0.1 * unit::deg;
    if (std::none_of(levels.begin(), levels.end(), [&](double l) { return std::abs(l - level) < same; })) levels.push_back(level);
  }
  return fmt::format(" ({} different {} along {}, at least {} over the range of use are needed)", levels.size(),
                     c.triad == Triad::accel ? "accelerations" : "rates", "xyz"[c.row], order + 2);
}

std::vector<FitResidual> fit_residuals(const WholeUnitProblem& problem) {
  std::vector<FitResidual> out;
  const std::array<double, 2> full_scale = problem.full_scale();
  for (int channel = 0; channel < 6; ++channel) {
    const std::size_t triad = channel < 3 ? 0 : 1;
    FitResidual r{fmt::format("{}.{}", triad == 0 ? "accel" : "gyro", "xyz"[channel % 3]), 0, 0, full_scale[triad]};
    double n = 0;
    for (const WholeUnitPoint& p : problem.points().points) {
      if (problem.kind(p) == RigKind::chamber) continue;
      const double e = problem.equations(p).residual[channel];
      r.rms += e * e, r.largest = std::max(r.largest, std::abs(e)), n += 1;
    }
    if (n == 0) continue;
    r.rms = std::sqrt(r.rms / n);
    out.push_back(r);
  }
  return out;
}

std::vector<RigErrorEstimate> estimated_errors(const WholeUnitProblem& problem, const Solution& s) {
  std::vector<RigErrorEstimate> out;
  const auto first = static_cast<Index>(problem.coefficients().size());
  for (std::size_t k = 0; k < problem.common().size(); ++k) {
    const CommonError& error = problem.common()[k];
    const Index i = first + static_cast<Index>(k);
    if (error.sigma > 0) out.push_back({error.name(), error.sigma, error.value, std::sqrt(s.covariance(i, i))});
  }
  return out;
}

/// Radii one by one, where the data know them twice as well as their declaration; the many small angles in one line.
void note_rig_errors(Quality& quality) {
  std::size_t angles = 0;
  double square = 0;
  for (const RigErrorEstimate& e : quality.rig_errors) {
    if (e.name == "gravity" || e.uncertainty > 0.5 * e.declared_sigma) continue;
    const bool radius = e.name.find("radius") != std::string::npos, rate = e.name.ends_with("rate");
    if (!radius && !rate) {
      ++angles, square += e.value * e.value;
      continue;
    }
    const double unit = radius ? 1e-3 : unit::ppm;
    quality.notes.push_back(fmt::format("{}: {:+.3g} +/- {:.2g} {} from its declaration (sigma {:.3g})", e.name, e.value / unit, e.uncertainty / unit,
                                        radius ? "mm" : "ppm", e.declared_sigma / unit));
  }
  if (angles > 0)
    quality.notes.push_back(fmt::format("{} errors of mounting and levelling were found along, {:.3g} arcsec RMS", angles,
                                        std::sqrt(square / static_cast<double>(angles)) / unit::arcsec));
}

void add_notes(Quality& quality, const WholeUnitProblem& problem) {
  std::size_t of[3] = {0, 0, 0};
  for (const WholeUnitPoint& p : problem.points().points)
    ++of[problem.kind(p) == RigKind::chamber ? 0 : problem.kind(p) == RigKind::rate_table ? 1 : 2];
  quality.notes.push_back(fmt::format("{} points were used: {} in the chamber, {} on the rate table, {} on the centrifuge",
                                      problem.points().points.size(), of[0], of[1], of[2]));
  const auto text = [&](std::size_t first, double unit, const char* name) {
    const auto& r = quality.fit_residuals;
    const auto percent = [&](std::size_t k) { return 100 * r[k].rms / r[k].full_scale; };
    const double largest =
        std::max({r[first].largest / r[first].full_scale, r[first + 1].largest / r[first].full_scale, r[first + 2].largest / r[first].full_scale});
    quality.notes.push_back(fmt::format("fit residual, x y z: {:.2g}, {:.2g}, {:.2g} % RMS of the full scale of {:.4g} {} (largest {:.2g} %)",
                                        percent(first), percent(first + 1), percent(first + 2), r[first].full_scale / unit, name, 100 * largest));
  };
  if (quality.fit_residuals.size() == 6) text(0, unit::g, "g"), text(3, unit::deg, "deg/s");
  note_rig_errors(quality);
}

void add_all(std::vector<std::string>& to, const std::vector<std::string>& more) { to.insert(to.end(), more.begin(), more.end()); }

}  // namespace

Quality whole_unit_quality(const WholeUnitProblem& problem, const WholeUnitOutcome& outcome) {
  Quality quality;
  const WholeUnitPoints& points = problem.points();
  const Solution& solution = outcome.solution;
  quality.term_tests = outcome.tests;
  quality.chi2_per_dof = solution.chi2 / std::max(1.0, solution.degrees_of_freedom);
  quality.degrees_of_freedom = static_cast<int>(std::lround(solution.degrees_of_freedom));
  quality.condition = solution.condition;
  add_all(quality.warnings, points.warnings);
  add_all(quality.warnings, outcome.warnings);
  for (std::size_t k = 0; k < outcome.parts.size(); ++k) {
    if (outcome.parts[k] != Part::weak) continue;
    const Coefficient& c = coefficient_table()[static_cast<std::size_t>(problem.coefficients()[k])];
    quality.unobservable.emplace_back(c.name);
    if (const std::string reason = open_reason(problem, c); !reason.empty())
      quality.warnings.push_back(std::string(c.name) + " is not determined" + reason);
  }
  for (const std::string& name : outcome.dropped) quality.warnings.push_back("dropped as an outlier: " + name);
  add_all(quality.warnings, outcome.wrong_machines);
  if (outcome.scatter > 1)
    quality.warnings.push_back(fmt::format(
        "the points scatter {:.2f} times as much as noise and declared errors explain; the uncertainties are enlarged by that", outcome.scatter));
  quality.fit_residuals = fit_residuals(problem);
  const double relative = problem.session().site.gravity_sigma() / problem.session().site.gravity();
  quality.sources.push_back({"gravity", relative, fmt::format("g is known to {:.3g} ppm", relative / unit::ppm)});
  quality.rig_errors = estimated_errors(problem, solution);
  add_notes(quality, problem);
  return quality;
}

}  // namespace imulab
