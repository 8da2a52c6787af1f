#include "imulab/estimate/hybrid.hpp"

#include "imulab/core/error.hpp"
#include "imulab/core/statistics.hpp"
#include "imulab/core/units.hpp"
#include "imulab/earth/earth.hpp"
#include "imulab/estimate/coarse.hpp"
#include "imulab/estimate/common.hpp"
#include "imulab/estimate/hybrid_blocks.hpp"
#include "imulab/estimate/hybrid_correction.hpp"
#include "imulab/model/coefficient.hpp"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <Eigen/LU>
#include <fmt/core.h>

#include <algorithm>
#include <array>
#include <cmath>

namespace imulab {

namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;
using L = HybridLayout;

constexpr int most_repetitions = 12;
constexpr double determined_part = 0.5;  // a state is determined if the data halve its prior

/// Before the data, about the coarse solution: it is good to some per cent, and to the Earth's rate with what acceleration adds.
VectorXd prior_sigma(const HybridLayout& layout, const HybridSite& site) {
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
  return s;
}

/// Coarse gyros: from the Earth's rate at rest where the rests allow it, else the declared unit or, for counts, the motion of gravity; offset from the rests.
void start_gyro(Start& start, const Recording& recording, double latitude) {
  TriadModel& gyro = start.scaled_model.gyro;
  std::vector<Vector3d> readings, up;
  Vector3d mean = Vector3d::Zero();
  for (const Rest& rest : start.rests) {
    readings.push_back((rest.gyro - start.scaling.gyro_center).cwiseQuotient(start.scaling.gyro_scale));
    mean += readings.back() / static_cast<double>(start.rests.size());
    const TriadModel& accel = start.scaled_model.accel;
    up.push_back((accel.offset + accel.matrix * (rest.accel - start.scaling.accel_center).cwiseQuotient(start.scaling.accel_scale)).normalized());
  }
  const bool counts = recording.gyro_unit == "count";
  const auto at_rest = coarse_gyro_at_rest(readings, up, earth_rate * std::sin(latitude));
  if (at_rest && !counts && (at_rest->matrix - Matrix3d::Identity()).cwiseAbs().maxCoeff() < 0.05) {
    gyro.matrix = at_rest->matrix;
    gyro.offset = at_rest->offset;
    start.notes.push_back("gyros started from the Earth's rate at rest");
    return;
  }
  if (counts) {
    const auto in_motion = coarse_gyro_in_motion(recording, start.rests, start.scaled_model, start.scaling);
    if (!in_motion) throw Unsupported(recording.name + ": gyro: the motion does not turn the unit about all its axes: counts need that for a scale");
    gyro.matrix = *in_motion;
  } else {
    gyro.matrix.setIdentity();
  }
  const bool large = (gyro.matrix * mean).norm() > 2 * earth_rate;  // of a smaller one the Earth's rate is a good part
  gyro.offset = large ? Vector3d(-gyro.matrix * mean) : Vector3d::Zero();
  start.notes.push_back(counts ? "gyros started from the motion of gravity between the rests" : "gyros started from the declared unit");
}

/// Axes that are swapped, reversed or left-handed, in words; empty where the gyros turn as gravity does.
std::string wrong_axes(const Matrix3d& gyro) {
  const Matrix3d m = gyro / std::cbrt(std::abs(gyro.determinant()));
  std::array<Index, 3> source;
  for (Index r = 0; r < 3; ++r) {
    m.row(r).cwiseAbs().maxCoeff(&source[static_cast<std::size_t>(r)]);
    if (std::abs(m(r, source[static_cast<std::size_t>(r)])) < 0.7) return {};  // mounted askew: no statement
  }
  if (source[0] == source[1] || source[0] == source[2] || source[1] == source[2]) return {};
  std::string swapped, reversed;
  int negative = 0;
  for (Index r = 0; r < 3; ++r) {
    const Index from = source[static_cast<std::size_t>(r)];
    if (from != r) swapped += fmt::format("{}{} reads about {}", swapped.empty() ? "" : ", ", "xyz"[from], "xyz"[r]);
    if (m(r, from) > 0) continue;
    ++negative;
    reversed += fmt::format("{}{}", reversed.empty() ? "" : " and ", "xyz"[from]);
  }
  if (swapped.empty() && negative == 0) return {};
  if (!swapped.empty()) return "the gyros' axes are not those of the accelerometers: gyro " + swapped + (negative ? "; reversed: " + reversed : "");
  if (negative == 3) return "the triads are left-handed: both have one axis reversed (or all three gyros are)";
  if (negative == 1) return "gyro " + reversed + " has the wrong sign";
  for (Index r = 0; r < 3; ++r)
    if (m(r, r) > 0) return fmt::format("accelerometer {} (or the gyros {}) has the wrong sign", "xyz"[r], reversed);
  return {};
}

void check_axes(const Recording& recording, const Start& start) {
  const auto in_motion = coarse_gyro_in_motion(recording, start.rests, start.scaled_model, start.scaling);
  if (!in_motion || !(std::abs(in_motion->determinant()) > 0)) return;
  if (const std::string wrong = wrong_axes(*in_motion); !wrong.empty())
    throw Error(recording.name + ": " + wrong + " (seen from how gravity turns in the unit), expected right-handed axes, the same for both triads");
}

/// A declared rest may begin and end with the table still moving: a second of each side is left to the motion where the rest is long enough.
std::vector<Range> within(const Recording& recording, std::vector<Range> rests) {
  const auto second = static_cast<std::size_t>(std::lround(1 / recording.interval_s));
  for (Range& rest : rests)
    if (rest.size() > 5 * second) rest = {rest.begin + second, rest.end - second};
  return rests;
}

struct Data {
  const Recording& recording;
  std::vector<HybridBlock> blocks;
  HybridSite site;
  HybridNoise noise;
};

/// The state of the repetitions: the model, and what was corrected since the coarse solution.
struct Course {
  SensorModel model;
  HybridSettings settings;
  VectorXd total, prior;
  HybridPass pass;
  bool converged = false;
  int repetitions = 0;
};

void repeat(const Data& data, Course& c) {
  c.pass = hybrid_pass(data.recording, data.blocks, c.model, data.site, data.noise, c.settings, -c.total, c.prior);
  ++c.repetitions;
}

/// Passes until the correction is below a hundredth of its sigma. The last pass is about the final model.
void converge(const Data& data, Course& c) {
  c.converged = false;
  for (int k = 0; k < most_repetitions && !c.converged; ++k) {
    repeat(data, c);
    const VectorXd sigma = c.pass.covariance.diagonal().head(c.prior.size()).cwiseSqrt();
    VectorXd step = c.pass.x.head(c.prior.size());
    step.segment<3>(L::start).setZero();
    const HybridLayout& layout = c.settings.layout;
    for (const Index known : {L::gravity, layout.latitude, layout.delay})  // no part of the model: the filter estimates them anew in each pass
      if (known >= 0) step[known] = 0;
    c.converged = (step.cwiseAbs() - 0.01 * sigma).maxCoeff() <= 0;
    if (c.converged) return;
    const double longest = std::max(1.0, step.cwiseAbs().cwiseQuotient(c.prior.cwiseMax(1e-30)).maxCoeff());
    c.model = corrected(c.model, step / longest, layout);
    c.total += step / longest;
    c.settings.start = c.pass.start;
  }
}

/// Velocities that the converged solution cannot explain are left out: the unit was bumped or shaken. A wide prior would let the states wander between
/// the first turns, so the look back is by a narrow one. True where something changed.
bool leave_out_outliers(Data& data, const Course& c, std::size_t& left_out) {
  constexpr double unlikely = 40;  // chi-square with three degrees of freedom: probability 1e-8
  const VectorXd sigma = c.pass.covariance.diagonal().head(c.prior.size()).cwiseSqrt();
  HybridSettings settings = c.settings;
  settings.outlier = unlikely;
  settings.start_sigma = 30 * sigma.segment<3>(L::start);
  VectorXd prior = c.prior.cwiseMin(30 * sigma);
  prior.segment<3>(L::start).setZero();
  const HybridPass look = hybrid_pass(data.recording, data.blocks, c.model, data.site, data.noise, settings, VectorXd::Zero(prior.size()), prior);
  std::vector<std::size_t> found;
  for (std::size_t k = 0; k < data.blocks.size(); ++k)
    if (data.blocks[k].observed && std::isnan(look.chi2[k])) found.push_back(k);
  if (20 * found.size() > data.blocks.size()) return false;  // not a disturbance, but a model that does not fit: the residuals will say so
  for (const std::size_t k : found) data.blocks[k].observed = false;
  left_out += found.size();
  return !found.empty();
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

/// The same course with other terms; what of the model belonged to one that is left out goes back to the coarse solution.
Course with_terms(const Course& c, const HybridTerms& terms, const Data& data, const SensorModel& coarse) {
  const HybridLayout layout = hybrid_layout(terms, data.site.latitude_sigma > 0), &before = c.settings.layout;
  Course out{c.model, c.settings, VectorXd::Zero(layout.constants), prior_sigma(layout, data.site), {}, false, c.repetitions};
  out.settings.layout = layout;
  out.total.head<21>() = c.total.head<21>();
  for (const Group& g : optional_groups)
    if (before.*g.at >= 0 && layout.*g.at >= 0) out.total.segment(layout.*g.at, g.count) = c.total.segment(before.*g.at, g.count);
  if (!terms.lever_arm) out.model.lever_arm = coarse.lever_arm;
  if (!terms.quadratic) out.model.accel.quadratic = coarse.accel.quadratic;
  if (!terms.g_sensitivity) out.model.g_sensitivity = coarse.g_sensitivity;
  return out;
}

/// One pass with every optional term tells which are significant (Wald).
HybridTerms significant_terms(const Data& data, const Course& course, const SensorModel& coarse, bool turntable, double significance,
                              std::vector<TermTest>& tests) {
  Course trial = with_terms(course, {turntable, true, true, turntable}, data, coarse);
  repeat(data, trial);
  HybridTerms kept;
  tests.clear();
  for (const Group& g : optional_groups) {
    const Index at = trial.settings.layout.*g.at;
    if (at < 0) continue;
    const VectorXd value = trial.total.segment(at, g.count) + trial.pass.x.segment(at, g.count);
    TermTest test{g.name, value.dot(MatrixXd(trial.pass.covariance.block(at, at, g.count, g.count)).ldlt().solve(value)), static_cast<int>(g.count), 1, false};
    test.p_value = chi_square_tail(test.statistic, static_cast<double>(g.count));
    kept.*g.wanted = test.kept = test.p_value <= significance;
    tests.push_back(test);
  }
  return kept;
}

HybridTerms wanted_terms(const std::vector<int>& terms) {
  HybridTerms wanted;
  for (const int index : terms) {
    const Term term = coefficient_table()[static_cast<std::size_t>(index)].term;
    wanted.lever_arm |= term == Term::lever_arm;
    wanted.quadratic |= term == Term::quadratic;
    wanted.g_sensitivity |= term == Term::g_sensitivity;
  }
  return wanted;
}

std::vector<int> supplied_coefficients() {
  std::vector<int> indices = accel_coefficients();
  for (const char* selector : {"gyro.offset", "gyro.matrix", "gyro.g_sensitivity", "accel.quadratic", "accel.lever_arm"})
    for (const int index : select_coefficients(selector)) indices.push_back(index);
  return indices;
}

/// States of coefficients that are not to be estimated stay where they are.
void hold_others(Course& c, const std::vector<int>& wanted) {
  if (wanted.empty()) return;
  const std::vector<int> of_state = corrected_coefficients(c.settings.layout);
  for (std::size_t s = 0; s < of_state.size(); ++s)
    if (of_state[s] >= 0 && std::find(wanted.begin(), wanted.end(), of_state[s]) == wanted.end()) c.prior[static_cast<Index>(s)] = 0;
}

/// A latitude that is wrong shows in the horizontal Earth rate: by how much, in words; empty where it does not.
std::string wrong_latitude(const Data& data, const Course& course, const SensorModel& coarse) {
  Data open{data.recording, data.blocks, data.site, data.noise};
  open.site.latitude_sigma = 30 * unit::deg;
  Course trial = with_terms(course, {}, open, coarse);
  repeat(open, trial);
  const Index at = trial.settings.layout.latitude;
  const double off = -trial.pass.x[at], sigma = std::sqrt(trial.pass.covariance(at, at));
  if (std::abs(off) < 5 * sigma || sigma > 3 * unit::deg || std::abs(off) < 3 * data.site.latitude_sigma) return {};
  return fmt::format("the gyros see the Earth's rate of latitude {:.2f} +/- {:.2f} deg, not {:.2f}: is the site right?",
                     (data.site.latitude + off) / unit::deg, sigma / unit::deg, data.site.latitude / unit::deg);
}

void conclude_quality(const Data& data, const Course& course, std::size_t states, std::size_t left_out, Quality& quality,
                      std::vector<std::string>& doubts) {
  double chi2 = 0;
  std::size_t used = 0;
  for (std::size_t k = 0; k < data.blocks.size(); ++k) {
    if (!data.blocks[k].observed) continue;
    chi2 += course.pass.chi2[k];
    ++used;
  }
  quality.degrees_of_freedom = static_cast<int>(3 * used) - static_cast<int>(states) - 3;
  quality.chi2_per_dof = chi2 / std::max(1, quality.degrees_of_freedom);
  quality.notes.push_back(fmt::format("{} repetitions over {} blocks", course.repetitions, data.blocks.size()));
  if (left_out > 0)
    quality.warnings.push_back(fmt::format("{} of {} velocities were left out: the unit was bumped, shaken, or not in its place", left_out, used + left_out));
  if (!course.converged) doubts.push_back("the repetitions did not converge");
}

HybridResult result_of(const Course& course, const Start& start, const SensorModel& coarse, const Session& session) {
  const HybridLayout& layout = course.settings.layout;
  HybridResult out;
  out.repetitions = course.repetitions;
  Calibration& c = out.calibration;
  c.imu = session.imu.name;
  c.method = "hybrid";
  c.model = course.model;
  std::vector<int> indices;
  std::vector<char> determined;
  const std::vector<int> of_state = corrected_coefficients(layout);
  for (std::size_t s = 0; s < of_state.size(); ++s) {
    const auto at = static_cast<Index>(s);
    if (of_state[s] < 0 || course.prior[at] == 0) continue;
    indices.push_back(of_state[s]);
    determined.push_back(std::sqrt(course.pass.covariance(at, at)) <= determined_part * course.prior[at]);
  }
  const MatrixXd jacobian = correction_jacobian(course.model, indices, layout);
  const MatrixXd covariance = jacobian * course.pass.covariance.topLeftCorner(layout.constants, layout.constants) * jacobian.transpose();
  std::vector<Index> kept;
  for (std::size_t i = 0; i < indices.size(); ++i) {
    const auto& row = coefficient_table()[static_cast<std::size_t>(indices[i])];
    const double before = coefficient_value(coarse, indices[i]);
    if (!determined[i]) {
      c.quality.unobservable.emplace_back(row.name);
      set_coefficient(c.model, indices[i], before);
      continue;
    }
    kept.push_back(static_cast<Index>(i));
    c.estimated.push_back(indices[i]);
    const double value = coefficient_value(c.model, indices[i]), sigma = std::sqrt(covariance(kept.back(), kept.back()));
    out.table.push_back({indices[i], before, value - before, value, sigma});
  }
  c.covariance = covariance(kept, kept);
  Quality& quality = c.quality;
  const VectorXd sigma = c.covariance.diagonal().cwiseSqrt();
  if (sigma.size() > 0) {
    const VectorXd relative = c.covariance.diagonal().cwiseSqrt();
    const MatrixXd correlation = relative.cwiseInverse().asDiagonal() * c.covariance * relative.cwiseInverse().asDiagonal();
    const VectorXd values = correlation.selfadjointView<Eigen::Lower>().eigenvalues();
    quality.condition = std::sqrt(values.maxCoeff() / values.minCoeff());
  }
  quality.notes.insert(quality.notes.begin(), start.notes.begin(), start.notes.end());
  quality.warnings.insert(quality.warnings.begin(), start.warnings.begin(), start.warnings.end());
  const double relative_g = session.site.gravity_sigma() / session.site.gravity();
  quality.sources.push_back(
      {"gravity", relative_g, fmt::format("g is known to {:.3g} ppm: this much is common to all three accelerometer scales", 1e6 * relative_g)});
  if (layout.delay >= 0)
    quality.notes.push_back(fmt::format("the accelerometers' output is {:.3g} +/- {:.2g} ms behind the gyros'", 1e3 * course.pass.x[layout.delay],
                                        1e3 * std::sqrt(course.pass.covariance(layout.delay, layout.delay))));
  return out;
}

void add_curves(const Course& course, HybridResult& out) {
  const std::vector<int> of_state = corrected_coefficients(course.settings.layout);
  for (const HybridPoint& point : course.pass.curve) out.curve_time.push_back(point.time);
  for (std::size_t s = 0; s < of_state.size(); ++s) {
    const auto at = static_cast<Index>(s);
    if (of_state[s] < 0 || course.prior[at] == 0) continue;
    ConvergenceCurve curve{std::string(coefficient_table()[static_cast<std::size_t>(of_state[s])].name), {}, {}};
    for (const HybridPoint& point : course.pass.curve) {
      curve.residual.push_back(course.total[at] + point.x[at]);
      curve.sigma.push_back(point.sigma[at]);
    }
    out.curves.push_back(std::move(curve));
  }
}

}  // namespace

HybridResult calibrate_hybrid(const Recording& recording, const std::vector<Range>& rests, const Session& session, const HybridOptions& options) {
  if (!session.site.latitude) throw Error("[site]: latitude_deg was expected: the Earth's rate is part of what the gyros read");
  const Site& site = session.site;
  const bool turntable = std::any_of(session.rigs.begin(), session.rigs.end(), [](const RigDeclaration& rig) { return rig.kind == RigKind::turntable; });
  const std::vector<int> wanted = options.terms.empty() ? std::vector<int>{} : choose_terms(options.terms, supplied_coefficients(), "hybrid");
  expect_alive(recording.gyro, recording.name, "gyro", "the method needs all gyros");
  Start start = start_from_rests(recording, within(recording, rests), session.imu, site.gravity());
  start_gyro(start, recording, *site.latitude);
  use_declared_gyro_noise(start, recording, session.imu);
  check_axes(recording, start);
  const SensorModel coarse = to_raw(start.scaled_model, start.scaling);

  HybridBlocks cut = hybrid_blocks(recording, within(recording, rests), turntable);
  const double root = std::sqrt(recording.interval_s);
  Data data{recording,
            std::move(cut.blocks),
            {*site.latitude, site.gravity(), site.latitude_sigma.value_or(0), site.gravity_sigma()},
            {coarse.gyro.matrix.diagonal().cwiseAbs().cwiseProduct(start.noise.gyro) * root,
             coarse.accel.matrix.diagonal().cwiseAbs().cwiseProduct(start.noise.accel) * root}};
  start.warnings.insert(start.warnings.end(), cut.warnings.begin(), cut.warnings.end());

  const HybridLayout layout = hybrid_layout(wanted_terms(wanted), data.site.latitude_sigma > 0);
  Course course{coarse, {}, VectorXd::Zero(layout.constants), prior_sigma(layout, data.site), {}, false, 0};
  course.settings.layout = layout;
  hold_others(course, wanted);
  std::size_t left_out = 0;
  std::vector<TermTest> tests;
  converge(data, course);
  const std::string latitude = wrong_latitude(data, course, coarse);
  if (!latitude.empty()) start.warnings.push_back(latitude);
  for (int round = 0; round < 4; ++round) {
    if (wanted.empty() && latitude.empty()) {  // else terms would take up what the latitude leaves
      course = with_terms(course, significant_terms(data, course, coarse, turntable, options.significance, tests), data, coarse);
      converge(data, course);
    }
    if (!course.converged || !leave_out_outliers(data, course, left_out)) break;
    converge(data, course);
  }
  if (options.curve_interval > 0) {
    course.settings.curve_interval = options.curve_interval;
    repeat(data, course);
  }
  HybridResult out = result_of(course, start, coarse, session);
  Quality& quality = out.calibration.quality;
  quality.term_tests = tests;
  std::vector<std::string> doubts;
  conclude_quality(data, course, out.table.size(), left_out, quality, doubts);
  if (!latitude.empty()) doubts.push_back("the latitude seems to be wrong");
  for (const std::string& doubt : common_doubts(out.calibration, site, 0, 1)) doubts.push_back(doubt);
  conclude(out.calibration, doubts);
  if (options.curve_interval > 0) add_curves(course, out);
  return out;
}

}  // namespace imulab
