#include "imulab/estimate/whole_unit/quality.hpp"

#include "imulab/core/statistics.hpp"
#include "imulab/rig/rig_errors.hpp"
#include "imulab/simulate.hpp"
#include "imulab/units.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <map>

namespace imulab::whole_unit {

using Eigen::Index;
using Eigen::VectorXd;

namespace {

/// Explains an undetermined coefficient by the number of levels, if that is the reason.
std::string count_of_levels(const PointProblem& problem, const Coefficient& c) {
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

std::vector<FitResidual> fit_residuals(const PointProblem& problem) {
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

std::vector<RigErrorEstimate> rig_errors(const PointProblem& problem, const Eigen::MatrixXd& covariance) {
  std::vector<RigErrorEstimate> out;
  for (auto i = std::ssize(problem.coefficients); const CommonError& error : problem.common) {
    if (error.sigma > 0 && !error.drift) out.push_back({error.name(), error.sigma, error.value, std::sqrt(covariance(i, i))});
    ++i;
  }
  return out;
}

void note_points(Quality& quality, const PointProblem& problem) {
  const auto many = [&](RigKind kind) {
    return std::count_if(problem.points.all.begin(), problem.points.all.end(), [&](const MachinePoint& p) { return p.machine == kind; });
  };
  quality.findings.add<Code::points_used>(problem.points.all.size(), many(RigKind::chamber), many(RigKind::rate_table), many(RigKind::centrifuge));
}

void note_residuals(Quality& quality) {
  if (quality.fit_residuals.size() != 6) return;
  const auto note = [&](const FitResidual* r, double unit, const char* unit_name) {
    const auto percent = [&](double value) { return 100 * value / r->full_scale; };
    quality.findings.add<Code::fit_residual>(percent(r[0].rms), percent(r[1].rms), percent(r[2].rms), r->full_scale / unit, unit_name,
                                             percent(std::max({r[0].largest, r[1].largest, r[2].largest})));
  };
  note(&quality.fit_residuals[0], unit::g, "g"), note(&quality.fit_residuals[3], unit::deg, "deg/s");
}

/// Lists radii one by one if the data determine them twice as well as declared; the many small angles in one line.
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
    quality.findings.add<Code::rig_error>(Subject{e.name}, e.value / unit, radius ? "mm" : "ppm", e.uncertainty / unit, e.declared_sigma / unit);
  }
  if (angles > 0) quality.findings.add<Code::rig_angles>(angles, std::sqrt(square / static_cast<double>(angles)) / unit::arcsec);
}

/// Probability of a warning in a good session, for all tests of a kind together.
constexpr double level = 1e-3;

/// The chamber's points at one temperature, reached by heating and by cooling.
struct Directions {
  Vector6d sum[2] = {Vector6d::Zero(), Vector6d::Zero()};
  int n[2] = {0, 0};
};

bool warn_hysteresis(kernel::Findings& findings, const PointProblem& problem) {
  std::map<std::int64_t, Directions> by_temperature;
  const std::size_t triad = problem.points.thermometer();
  const auto reading = [&](const MachinePoint& p) { return p.temperature[static_cast<Index>(3 * triad)]; };
  // A visit belongs to one set point; without set points, to readings within 1/40 of the range.
  const auto visit = [&](const MachinePoint& p) {
    return p.step.temperature ? std::llround(100 * *p.step.temperature) : std::llround(40 * reading(p) / problem.points.thermal[triad].size());
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
    if (std::abs(mean) < normal_quantile(1 - level / 12) * sigma * (1 + 4 / n)) continue;  // with a margin for the few degrees of Student's t
    found = true;
    findings.add<Code::hysteresis>(Subject{k < 3 ? "accel" : "gyro"}, "xyz"[k % 3], k < 3 ? mean / unit::ug : mean / unit::deg_per_h,
                                   k < 3 ? "ug" : "deg/h");
  }
  return found;
}

/// Errors of a machine that change together.
struct Hypothesis {
  ErrorInWords error;
  VectorXd direction;  ///< in the space of the parameters
};

std::vector<Hypothesis> hypotheses(const PointProblem& problem) {
  std::map<std::string, Hypothesis> by_name;
  for (std::size_t k = 0; k < problem.common.size(); ++k) {
    const auto add = [&](ErrorInWords error, const std::string& name) {
      error.name = name;
      Hypothesis& h = by_name.try_emplace(name, Hypothesis{error, VectorXd::Zero(problem.size())}).first->second;
      h.direction[static_cast<Index>(problem.coefficients.size() + k)] = 1;
    };
    const CommonError& common = problem.common[k];
    if (common.drift) continue;
    const std::string machine = common.rig.empty() ? "the rig: " : common.rig + ": ";
    const ErrorInWords error = k == 0 ? ErrorInWords{"gravity", 1e-3, "mm/s^2", 0.05} : in_words(common.source);
    add(error, k == 0 ? error.name : machine + error.name);
    if (common.source.kind == RigErrorKind::radius) add(error, machine + "every radius");
  }
  std::vector<Hypothesis> all;
  for (auto& [name, h] : by_name) all.push_back(std::move(h));
  return all;
}

}  // namespace

Quality quality_of(const PointProblem& problem, const JointEstimate& estimate) {
  Quality quality;
  quality.term_tests = estimate.tests;
  quality.chi2_per_dof = estimate.solution.chi2 / std::max(1.0, estimate.solution.degrees_of_freedom);
  quality.degrees_of_freedom = static_cast<int>(std::lround(estimate.solution.degrees_of_freedom));
  quality.condition = estimate.condition;
  quality.converged = estimate.converged;
  for (const std::size_t k : estimate.left_out) quality.considered.emplace_back(coefficient(problem.coefficients[k]).name);
  for (const std::string& warning : problem.points.warnings) quality.findings.add<Code::point_warning>(warning);
  for (std::size_t k = 0; k < problem.role.size(); ++k) {
    if (problem.role[k] != kernel::Role::considered) continue;
    const Coefficient& c = coefficient(problem.coefficients[k]);
    quality.unobservable.emplace_back(c.name);
    if (const std::string reason = count_of_levels(problem, c); !reason.empty()) quality.findings.add<Code::too_few_levels>(reason).subject = c.name;
  }
  quality.fit_residuals = fit_residuals(problem);
  quality.sources.push_back(kernel::gravity_source(problem.session->site));
  quality.rig_errors = rig_errors(problem, estimate.solution.covariance);
  note_points(quality, problem);
  note_residuals(quality);
  note_rig_errors(quality);
  return quality;
}

Findings wrong_machine(const PointProblem& problem) {
  const kernel::Information data = problem.information();
  const kernel::Solution s = kernel::solve(data, problem.parameters(), "the points");
  const VectorXd slope = data.g + data.N * s.x;  // half the gradient of the sum of squares, at the solution
  const std::vector<Hypothesis> all = hypotheses(problem);
  const Hypothesis* worst = nullptr;
  double most = 0, by = 0;
  for (const Hypothesis& h : all) {
    // The curvature along one more direction excludes what the free parameters explain; their slope and that of their priors cancel.
    const VectorXd nd = data.N * h.direction;
    const double curvature = h.direction.dot(nd) - nd.dot(s.covariance * nd), gradient = h.direction.dot(slope);
    // Directions that the estimate follows for any data carry no information.
    if (!(curvature > 1e-9 * h.direction.dot(nd)) || !(h.direction.dot(nd) > 0)) continue;
    const double saved = gradient * gradient / curvature;
    if (std::abs(gradient / curvature) > h.error.largest) continue;
    if (saved > most) most = saved, by = -gradient / curvature, worst = &h;
  }
  if (!worst || log_chi_square_tail(most, 1) > std::log(level / static_cast<double>(all.size()))) return {};
  // A cause of excess scatter is only named if it explains a substantial part of it.
  const double excess = s.chi2 - s.degrees_of_freedom / (problem.noise_factor * problem.noise_factor);
  if (most < 0.3 * excess) return {};
  Findings out;
  out.add<Code::machine_fit>(Subject{worst->error.name}, by / worst->error.unit, worst->error.unit_name, most);
  out.add<Code::machine_not_as_declared>();
  return out;
}

void check_chamber(kernel::Findings& findings, const PointProblem& problem) {
  const std::string unsettled = unsettled_points(problem.points, *problem.session);
  if (!unsettled.empty()) findings.add<Code::not_settled>(unsettled);
  if (warn_hysteresis(findings, problem) || !unsettled.empty()) findings.add<Code::chamber_not_repeated>();
}

}  // namespace imulab::whole_unit
