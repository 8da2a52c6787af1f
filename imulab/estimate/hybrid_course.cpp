#include "imulab/estimate/hybrid_course.hpp"

#include "imulab/core/rotation.hpp"
#include "imulab/core/statistics.hpp"
#include "imulab/core/units.hpp"
#include "imulab/estimate/hybrid_correction.hpp"

#include <Eigen/Cholesky>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <utility>

namespace imulab {

namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;
using L = HybridLayout;

/// Before the data, about the coarse solution: it is good to some per cent, and to the Earth's rate with what acceleration adds.
VectorXd prior_of(const HybridLayout& layout, const HybridData& data) {
  const HybridSite& site = data.site;
  VectorXd s = VectorXd::Zero(layout.constants);
  s.segment<3>(L::accel_offset).setConstant(0.02 * site.gravity);
  s.segment<6>(L::accel_matrix) << 0.05, 1e-2, 0.05, 1e-2, 1e-2, 0.05;
  s.segment<3>(L::gyro_offset).setConstant(3e-3);
  for (Index r = 0; r < 3; ++r)
    for (Index c = 0; c < 3; ++c) s[L::gyro_matrix + 3 * r + c] = r == c ? 0.05 : 0.02;
  s[L::gravity] = site.gravity_sigma / site.gravity;
  if (layout.latitude >= 0) s[layout.latitude] = site.latitude_sigma;
  if (layout.lever_arm >= 0) s.segment<9>(layout.lever_arm).setConstant(1);
  if (layout.quadratic >= 0) s.segment<3>(layout.quadratic).setConstant(1e-3);
  if (layout.g_sensitivity >= 0) s.segment<9>(layout.g_sensitivity).setConstant(1e-3);
  if (layout.delay >= 0) s[layout.delay] = 0.1;
  if (data.wanted.empty()) return s;
  const std::vector<int> of_state = corrected_coefficients(layout);
  for (std::size_t i = 0; i < of_state.size(); ++i)  // what is not to be estimated stays where it is
    if (of_state[i] >= 0 && std::find(data.wanted.begin(), data.wanted.end(), of_state[i]) == data.wanted.end()) s[static_cast<Index>(i)] = 0;
  return s;
}

/// Groups of optional terms and where they stand in a layout.
struct Group {
  const char* name;
  bool HybridTerms::*wanted;
  Index HybridLayout::*at;
  Index count;
};
constexpr std::array<Group, 4> optional_groups{{{"accel.lever_arm", &HybridTerms::lever_arm, &HybridLayout::lever_arm, 9},
                                                {"accel.quadratic", &HybridTerms::quadratic, &HybridLayout::quadratic, 3},
                                                {"gyro.g_sensitivity", &HybridTerms::g_sensitivity, &HybridLayout::g_sensitivity, 9},
                                                {"delay of the accelerometers", &HybridTerms::delay, &HybridLayout::delay, 1}}};

}  // namespace

HybridCourse begin_course(const HybridData& data, const HybridTerms& terms) {
  HybridCourse course{data.coarse, data.site, terms, {}, {}, {}, {}};
  course.settings.layout = hybrid_layout(terms, data.site.latitude_sigma > 0);
  course.prior = prior_of(course.settings.layout, data);
  course.total = VectorXd::Zero(course.prior.size());
  return course;
}

HybridCourse with_terms(const HybridData& data, const HybridCourse& before, const HybridTerms& terms) {
  HybridCourse out = begin_course(data, terms);
  const HybridLayout &from = before.settings.layout, &to = out.settings.layout;
  out.repetitions = before.repetitions;
  out.settings.start = before.settings.start;
  out.heading_known = before.heading_known;
  out.model = before.model;
  out.total.head<21>() = before.total.head<21>();
  if (from.latitude >= 0 && to.latitude >= 0) {
    out.site = before.site;
    out.total[to.latitude] = before.total[from.latitude];
  }
  for (const Group& g : optional_groups)
    if (from.*g.at >= 0 && to.*g.at >= 0) out.total.segment(to.*g.at, g.count) = before.total.segment(from.*g.at, g.count);
  if (!terms.lever_arm) out.model.lever_arm = data.coarse.lever_arm;
  if (!terms.quadratic) out.model.accel.quadratic = data.coarse.accel.quadratic;
  if (!terms.g_sensitivity) out.model.g_sensitivity = data.coarse.g_sensitivity;
  return out;
}

HybridErrors determined_errors(const HybridCourse& c) {
  constexpr double determined_part = 0.5;
  const auto n = c.prior.size();
  HybridErrors out{c.pass.x.head(n), c.pass.covariance.topLeftCorner(n, n), {}};
  const std::vector<int> of_state = corrected_coefficients(c.settings.layout);
  for (Index i = 0; i < n; ++i)
    if (of_state[static_cast<std::size_t>(i)] >= 0 && c.prior[i] > 0 && std::sqrt(out.covariance(i, i)) > determined_part * c.prior[i])
      out.undetermined.push_back(i);
  const auto& u = out.undetermined;
  if (u.empty()) return out;
  const MatrixXd columns = out.covariance(Eigen::all, u), gain = columns(u, Eigen::all).ldlt().solve(columns.transpose()).transpose();
  out.mean -= gain * VectorXd(out.mean(u) + c.total(u));
  out.covariance += gain * (MatrixXd(c.prior(u).cwiseAbs2().asDiagonal()) - columns(u, Eigen::all)) * gain.transpose();
  return out;
}

HybridCourse repeated(const HybridData& data, HybridCourse c) {
  c.pass = hybrid_pass(data.recording, data.blocks, c.model, c.site, data.noise, c.settings, -c.total, c.prior);
  ++c.repetitions;
  return c;
}

namespace {

double chi_square(const HybridData& data, const HybridPass& pass) {
  double sum = 0;
  for (std::size_t k = 0; k < data.blocks.size(); ++k)
    if (data.blocks[k].observed) sum += pass.chi2[k];
  return sum;
}

/// Gyros that hardly see the Earth's rate start from any heading, too far off for the repetitions to turn back: of eight, the one that fits best.
Matrix3d best_heading(const HybridData& data, const HybridCourse& course) {
  Matrix3d best = *course.settings.start;
  double least = std::numeric_limits<double>::infinity();
  for (int k = 0; k < 8; ++k) {
    HybridCourse turned = course;
    turned.settings.start = rotation_about(Vector3d::UnitZ(), k * 45 * unit::deg) * *course.settings.start;
    turned = repeated(data, std::move(turned));
    if (const double chi2 = chi_square(data, turned.pass); chi2 < least) {
      least = chi2;
      best = *turned.settings.start;
    }
  }
  return best;
}

/// Where a step follows its forerunner's direction, what their ratio says all further ones would add up to (Aitken): of barely determined directions
/// the repetitions creep along one, and about another they swing.
double whole_way(const VectorXd& step, const VectorXd& before) {
  if (before.size() == 0) return 1;
  const double product = step.dot(before), ratio = product / before.squaredNorm();
  if (std::abs(product) < 0.7 * step.norm() * before.norm() || ratio > 0.99) return 1;
  return std::clamp(1 / (1 - ratio), 0.25, 6.0);
}

}  // namespace

HybridCourse converged(const HybridData& data, HybridCourse c) {
  constexpr int most_repetitions = 30, before_heading = 3;
  const HybridLayout& layout = c.settings.layout;
  VectorXd before;  // the last step, in sigmas
  c.converged = false;
  for (int k = 0; k < most_repetitions; ++k) {
    c = repeated(data, std::move(c));
    const HybridErrors errors = determined_errors(c);
    const VectorXd sigma = errors.covariance.diagonal().cwiseSqrt();
    VectorXd step = errors.mean;
    const Vector3d start = step.segment<3>(L::start);
    step.segment<3>(L::start).setZero();
    for (const Index linear : {L::gravity, layout.delay})  // no point of linearisation: estimated anew in each pass
      if (linear >= 0) step[linear] = 0;
    c.converged = (step.cwiseAbs() - 0.01 * sigma).maxCoeff() <= 0;
    if (c.converged) break;
    const VectorXd in_sigmas = step.cwiseQuotient(sigma.cwiseMax(1e-300));
    const double longest = std::max(1.0, step.cwiseAbs().cwiseQuotient(3 * c.prior.cwiseMax(1e-30)).maxCoeff()), whole = whole_way(in_sigmas, before);
    const double factor = whole / longest;
    before = whole == 1 ? in_sigmas : VectorXd();
    c.model = corrected(c.model, factor * step, layout);
    if (layout.latitude >= 0) c.site.latitude -= factor * step[layout.latitude];
    c.total += factor * step;
    c.settings.start = rotation_exp(factor * start) * c.pass.start;
    if (k >= before_heading && !c.heading_known && sigma[L::start + 2] > 3 * unit::deg) c.settings.start = best_heading(data, c);
    c.heading_known = c.heading_known || k >= before_heading;
  }
  return c;
}

/// A wide prior would let the states wander between the first turns, so the look back is by a narrow one.
std::vector<std::size_t> outlying_blocks(const HybridData& data, const HybridCourse& c) {
  constexpr double unlikely = 40;  // chi-square with three degrees of freedom: probability 1e-8
  const VectorXd sigma = c.pass.covariance.diagonal().head(c.prior.size()).cwiseSqrt();
  HybridSettings settings = c.settings;
  settings.outlier = unlikely;
  settings.start_sigma = 30 * sigma.segment<3>(L::start);
  VectorXd prior = c.prior.cwiseMin(30 * sigma);
  prior.segment<3>(L::start).setZero();
  VectorXd known = VectorXd::Zero(prior.size());
  if (settings.layout.delay >= 0) known[settings.layout.delay] = c.pass.x[settings.layout.delay];
  known[L::gravity] = c.pass.x[L::gravity];
  const HybridPass look = hybrid_pass(data.recording, data.blocks, c.model, c.site, data.noise, settings, known, prior);
  std::vector<std::size_t> found;
  for (std::size_t k = 0; k < data.blocks.size(); ++k)
    if (data.blocks[k].observed && std::isnan(look.chi2[k])) found.push_back(k);
  if (20 * found.size() > data.blocks.size()) found.clear();  // not a disturbance, but a model that does not fit: the residuals will say so
  return found;
}

namespace {

/// The errors of the coarse solution, the latitude's having been measured as zero with the site's uncertainty.
HybridErrors at_site_latitude(const HybridCourse& open, double latitude_sigma) {
  const Index at = open.settings.layout.latitude, n = open.settings.layout.constants;
  HybridErrors e{open.total + open.pass.x.head(n), open.pass.covariance.topLeftCorner(n, n), {}};
  const VectorXd column = e.covariance.col(at), gain = column / (column[at] + latitude_sigma * latitude_sigma);
  e.mean -= gain * e.mean[at];
  e.covariance -= gain * column.transpose();
  return e;
}

std::optional<SeenLatitude> contradicting_latitude(const HybridData& open, HybridCourse trial, double declared_sigma) {
  const Index at = trial.settings.layout.latitude;
  const auto contradicts = [&] {
    const double off = trial.total[at] + trial.pass.x[at], sigma = std::sqrt(trial.pass.covariance(at, at));
    return std::abs(off) > 5 * sigma && sigma < 3 * unit::deg && std::abs(off) > 3 * declared_sigma;
  };
  if (!contradicts()) return {};
  trial = converged(open, std::move(trial));
  if (!trial.converged || !contradicts()) return {};
  return SeenLatitude{trial.site.latitude - trial.pass.x[at], std::sqrt(trial.pass.covariance(at, at))};
}

}  // namespace

HybridReview review(const HybridData& data, const HybridCourse& course, const HybridTerms& terms, double significance) {
  HybridData open = data;
  open.site.latitude_sigma = 30 * unit::deg;
  const HybridCourse trial = repeated(open, with_terms(open, course, terms));
  HybridReview out{contradicting_latitude(open, trial, data.site.latitude_sigma), {}, {}};
  HybridErrors errors = at_site_latitude(trial, data.site.latitude_sigma);
  // Integration from samples is good to less than a thousandth of their interval: in a turn's ramp of four samples it looks like a fifth of that.
  if (const Index at = trial.settings.layout.delay; at >= 0) errors.covariance(at, at) += std::pow(5e-4 * data.recording.interval_s, 2);
  for (const Group& g : optional_groups) {
    const Index at = trial.settings.layout.*g.at;
    if (at < 0) continue;
    const VectorXd value = errors.mean.segment(at, g.count);
    TermTest test{g.name, value.dot(MatrixXd(errors.covariance.block(at, at, g.count, g.count)).ldlt().solve(value)), static_cast<int>(g.count), 1,
                  false};
    test.p_value = chi_square_tail(test.statistic, static_cast<double>(g.count));
    out.significant.*g.wanted = test.kept = test.p_value <= significance;
    out.tests.push_back(test);
  }
  return out;
}

}  // namespace imulab
