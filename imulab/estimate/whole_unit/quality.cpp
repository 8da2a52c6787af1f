#include "imulab/estimate/whole_unit/quality.hpp"

#include "imulab/core/units.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>

namespace imulab::whole_unit {

using Eigen::Index;

namespace {

/// Why a coefficient is not determined, where counting levels tells.
std::string count_of_levels(const Problem& problem, const Coefficient& c) {
  const int order = c.term == Term::quadratic ? 2 : c.term == Term::cubic ? 3 : 0;
  if (order == 0) return "";
  const bool accel = c.triad == Triad::accel;
  std::vector<double> levels;
  for (const MachinePoint& p : problem.points.all) {
    const Motion m = problem.motion(p);
    const double level = accel ? m.force[c.row] : m.rate[c.row], same = accel ? 0.05 * unit::g : 0.1 * unit::deg;
    if (std::none_of(levels.begin(), levels.end(), [&](double l) { return std::abs(l - level) < same; })) levels.push_back(level);
  }
  return fmt::format("{} is not determined ({} different {} along {}, at least {} over the range of use are needed)", c.name, levels.size(),
                     accel ? "accelerations" : "rates", "xyz"[c.row], order + 2);
}

std::vector<FitResidual> fit_residuals(const Problem& problem) {
  std::vector<FitResidual> out;
  const std::array<double, 2> full_scale = problem.full_scale();
  for (int channel = 0; channel < 6; ++channel) {
    FitResidual r{fmt::format("{}.{}", channel < 3 ? "accel" : "gyro", "xyz"[channel % 3]), 0, 0, full_scale[channel < 3 ? 0 : 1]};
    double n = 0;
    for (const MachinePoint& p : problem.points.all) {
      if (p.machine == RigKind::chamber) continue;
      const double e = problem.equations(p).residual[channel];
      r.rms += e * e, r.largest = std::max(r.largest, std::abs(e)), n += 1;
    }
    if (n == 0) continue;
    r.rms = std::sqrt(r.rms / n);
    out.push_back(r);
  }
  return out;
}

std::vector<RigErrorEstimate> rig_errors(const Problem& problem, const Eigen::MatrixXd& covariance) {
  std::vector<RigErrorEstimate> out;
  for (auto i = std::ssize(problem.coefficients); const CommonError& error : problem.common) {
    if (error.sigma > 0) out.push_back({error.name(), error.sigma, error.value, std::sqrt(covariance(i, i))});
    ++i;
  }
  return out;
}

void note_points(Quality& quality, const Problem& problem) {
  const auto many = [&](RigKind kind) {
    return std::count_if(problem.points.all.begin(), problem.points.all.end(), [&](const MachinePoint& p) { return p.machine == kind; });
  };
  quality.notes.push_back(fmt::format("{} points were used: {} in the chamber, {} on the rate table, {} on the centrifuge", problem.points.all.size(),
                                      many(RigKind::chamber), many(RigKind::rate_table), many(RigKind::centrifuge)));
}

void note_residuals(Quality& quality) {
  if (quality.fit_residuals.size() != 6) return;
  const auto note = [&](const FitResidual* r, double unit, const char* unit_name) {
    const auto percent = [&](double value) { return 100 * value / r->full_scale; };
    quality.notes.push_back(fmt::format("fit residual, x y z: {:.2g}, {:.2g}, {:.2g} % RMS of the full scale of {:.4g} {} (largest {:.2g} %)",
                                        percent(r[0].rms), percent(r[1].rms), percent(r[2].rms), r->full_scale / unit, unit_name,
                                        percent(std::max({r[0].largest, r[1].largest, r[2].largest}))));
  };
  note(&quality.fit_residuals[0], unit::g, "g"), note(&quality.fit_residuals[3], unit::deg, "deg/s");
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
    quality.notes.push_back(fmt::format("{} errors of mounting and leveling were estimated jointly, {:.3g} arcsec RMS", angles,
                                        std::sqrt(square / static_cast<double>(angles)) / unit::arcsec));
}

}  // namespace

Quality quality_of(const Problem& problem, const JointEstimate& estimate) {
  Quality quality;
  quality.term_tests = estimate.tests;
  quality.chi2_per_dof = estimate.solution.chi2 / std::max(1.0, estimate.solution.degrees_of_freedom);
  quality.degrees_of_freedom = static_cast<int>(std::lround(estimate.solution.degrees_of_freedom));
  quality.condition = estimate.condition;
  quality.warnings = problem.points.warnings;
  for (std::size_t k = 0; k < problem.role.size(); ++k) {
    if (problem.role[k] != kernel::Role::considered) continue;
    const Coefficient& c = coefficient(problem.coefficients[k]);
    quality.unobservable.emplace_back(c.name);
    if (std::string reason = count_of_levels(problem, c); !reason.empty()) quality.warnings.push_back(std::move(reason));
  }
  quality.fit_residuals = fit_residuals(problem);
  quality.sources.push_back(kernel::gravity_source(problem.session->site));
  quality.rig_errors = rig_errors(problem, estimate.solution.covariance);
  note_points(quality, problem);
  note_residuals(quality);
  note_rig_errors(quality);
  return quality;
}

}  // namespace imulab::whole_unit
