#include "imulab/estimate/drive/quality.hpp"

#include "imulab/coefficient.hpp"
#include "imulab/core/statistics.hpp"
#include "imulab/estimate/drive/unmodeled.hpp"
#include "imulab/estimate/kernel/information.hpp"
#include "imulab/model/relative_uncertainty.hpp"
#include "imulab/units.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <string>
#include <utility>
#include <vector>

namespace imulab::drive {

std::string in_front(const std::vector<Drive>& drives, const Drive& drive) { return drives.size() > 1 ? drive.name + ": " : ""; }

namespace {

/// Returns true for optional terms, which are not named if a drive does not determine them.
bool is_curvature(const std::string& constant) {
  return constant.find(".quadratic") != std::string::npos || constant.find(".cubic") != std::string::npos;
}

}  // namespace

void name_undetermined(const AidedNavigation& n, Quality& quality, kernel::Findings& findings) {
  std::vector<std::string> names;
  for (const AidedConstant& c : n.constants) {
    if (!c.undetermined() || is_effect(c.name)) continue;
    if (of_unit(c)) quality.considered.push_back(c.name);
    if (!is_curvature(c.name)) names.push_back(c.name);
  }
  for (const auto& [manoeuvre, group] : by_manoeuvre(names))
    findings.add<Code::shown_by_no_motion>(Subject{fmt::format("{}", fmt::join(group, ", "))},
                                           manoeuvre.empty() ? "" : fmt::format("; shown by {}", manoeuvre));
}

std::string constant_text(const AidedConstant& c) {
  const UserUnit& unit = quantity_of_constant(c.name).unit;
  return fmt::format("{} {:.4g} {} (u = {:.2g})", c.name, c.value / unit.size, unit.name, c.sigma / unit.size);
}

namespace {

void note_drive(const Drive& drive, const std::string& before, kernel::Findings& findings) {
  const AidedNavigation& n = drive.navigation;
  findings.add<Code::drive_passes>(before, n.passes, n.solution.time.back() - n.solution.time.front(), fmt::format("{}", fmt::join(n.aids, ", ")),
                                   n.innovations.size(), n.innovation_rms);
  for (const AidedFactor& f : n.factors) findings.add<Code::aid_noise>(before, Subject{f.name}, std::sqrt(f.factor), f.resolved);
}

void doubt_drive(const Drive& drive, const std::string& before, kernel::Findings& findings) {
  for (Finding f : drive.navigation.findings) {
    if (f.severity == Severity::doubt) f.text = before + f.text;
    findings.push_back(std::move(f));
  }
}

/// Adds a doubt for the drive that contradicts the others most.
void doubt_contradiction(const std::vector<Contradiction>& all, kernel::Findings& findings) {
  const auto chance = [](const Contradiction& c) { return c.freedom > 0 ? log_chi_square_tail(c.chi2, c.freedom) : 0; };
  const auto worst = std::ranges::min_element(all, {}, chance);
  constexpr double improbable = 1e-4;
  if (worst == all.end() || chance(*worst) > std::log(improbable / static_cast<double>(all.size()))) return;
  findings.add<Code::drive_contradicts>(Subject{worst->drive}, all.size() > 2 ? " drives" : " drive", worst->chi2, worst->freedom, worst->worst,
                                        worst->sigmas);
}

/// Doubts a unit that is not of its grade, or not mounted as declared: the prior then biases the estimates.
void doubt_priors(const AidedNavigation& n, const Session& session, kernel::Findings& findings) {
  constexpr double many = 4, far = 2;  // sigma of the prior; mounting angles are linear up to about 30 deg
  const AidedConstant* worst = nullptr;
  for (const AidedConstant& c : n.constants) {
    if (of_unit(c) && (!worst || std::abs(c.value / c.prior) > std::abs(worst->value / worst->prior))) worst = &c;
    if (c.name.find("mounting") != std::string::npos && std::abs(c.value) > far * c.prior)
      findings.add<Code::large_mounting>(Subject{c.name}, c.value / unit::deg);
  }
  if (worst && std::abs(worst->value) > many * worst->prior)
    findings.add<Code::beyond_grade>(Subject{shown_name(worst->name)}, std::abs(worst->value / worst->prior),
                                     session.imu.grade.value_or("mems, which is assumed,"));
}

/// Returns the part of a calibration that the drive determined.
Calibration determined_part(const Calibration& c) {
  Calibration out = c;
  out.estimated.clear();
  std::vector<Eigen::Index> places;
  for (std::size_t k = 0; k < c.estimated.size(); ++k)
    if (is_result(c, c.estimated[k])) out.estimated.push_back(c.estimated[k]), places.push_back(static_cast<Eigen::Index>(k));
  out.covariance = c.covariance(places, places).eval();
  out.quality.converged = true;  // the drive reports lack of convergence itself
  return out;
}

}  // namespace

void add_aids(const AidedNavigation& n, Quality& quality) {
  for (const AidedConstant& c : n.constants)
    if (of_aid(c)) quality.rig_errors.push_back({.name = c.name, .declared_sigma = c.prior, .value = c.value, .uncertainty = c.sigma});
}

kernel::Findings judged(const std::vector<Drive>& drives, const Together& all, const Session& session, Calibration& calibration) {
  kernel::Findings findings;
  Quality& quality = calibration.quality;
  quality.converged = true;
  double values = 0, squares = 0;
  for (const Drive& drive : drives) {
    const AidedNavigation& n = drive.navigation;
    quality.converged = quality.converged && n.converged;
    values += static_cast<double>(n.innovations.size()), squares += n.innovation_rms * n.innovation_rms * static_cast<double>(n.innovations.size());
    note_drive(drive, in_front(drives, drive), findings);
  }
  quality.chi2_per_dof = values > 0 ? squares / values : 0;
  quality.degrees_of_freedom = static_cast<int>(values) - static_cast<int>(std::ranges::count_if(
                                                              all.navigation.constants, [](const AidedConstant& c) { return !c.undetermined(); }));
  if (!calibration.estimated.empty()) quality.condition = kernel::condition_number(calibration.covariance);
  quality.sources.push_back(kernel::gravity_source(session.site));
  if (!session.imu.grade) findings.add<Code::no_grade>("session");
  name_undetermined(all.navigation, quality, findings);
  add_aids(all.navigation, quality);
  for (const AidedConstant& c : all.navigation.constants)
    if (of_aid(c)) findings.add<Code::aid_constant>(constant_text(c)).subject = c.name;
  for (const Drive& drive : drives) doubt_drive(drive, in_front(drives, drive), findings);
  doubt_contradiction(all.contradictions, findings);
  doubt_priors(all.navigation, session, findings);
  const Calibration determined = determined_part(calibration);
  if (determined.estimated.empty()) findings.add<Code::no_coefficient_shown>();
  kernel::add_common_doubts(findings, determined, session.site);
  return findings;
}

}  // namespace imulab::drive
