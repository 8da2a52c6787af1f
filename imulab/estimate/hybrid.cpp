#include "imulab/estimate/hybrid.hpp"

#include "imulab/core/error.hpp"
#include "imulab/core/statistics.hpp"
#include "imulab/core/units.hpp"
#include "imulab/earth/earth.hpp"
#include "imulab/estimate/hybrid_blocks.hpp"
#include "imulab/estimate/hybrid_correction.hpp"
#include "imulab/estimate/hybrid_course.hpp"
#include "imulab/estimate/hybrid_start.hpp"
#include "imulab/model/coefficient.hpp"
#include "imulab/model/grade.hpp"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <optional>

namespace imulab {

namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

constexpr double settling_s = 1;  // a table may still move that long after its step has ended, and before it begins

/// A declared rest may begin and end with the table still moving: that much is left to the motion where the rest is long enough.
std::vector<Range> within(const Recording& recording, std::vector<Range> rests, std::vector<std::string>& warnings) {
  const auto margin = static_cast<std::size_t>(std::lround(settling_s / recording.interval_s));
  std::size_t short_ones = 0;
  for (Range& rest : rests) {
    if (rest.size() > 5 * margin)
      rest = {rest.begin + margin, rest.end - margin};
    else
      ++short_ones;
  }
  if (2 * short_ones > rests.size())
    warnings.push_back(
        fmt::format("{} of {} rests are no longer than {:g} s: too short to leave out what settles at their ends, and the Earth's rate is "
                    "hardly seen in them; 30 s and more are good",
                    short_ones, rests.size(), 5 * settling_s));
  return rests;
}

std::vector<int> supplied_coefficients() {
  std::vector<int> indices = accel_coefficients();
  for (const char* selector : {"gyro.offset", "gyro.matrix", "gyro.g_sensitivity", "accel.quadratic", "accel.lever_arm"})
    for (const int index : select_coefficients(selector)) indices.push_back(index);
  return indices;
}

HybridTerms terms_of(const std::vector<int>& indices) {
  HybridTerms terms;
  for (const int index : indices) {
    const Term term = coefficient_table()[static_cast<std::size_t>(index)].term;
    terms.lever_arm |= term == Term::lever_arm;
    terms.quadratic |= term == Term::quadratic;
    terms.g_sensitivity |= term == Term::g_sensitivity;
  }
  return terms;
}

/// White noise of the calibrated output from the samples' or the declared noise; random walks of the offsets, and quantisation of the velocity, as
/// declared.
HybridNoise noise_of(const Start& start, const SensorModel& coarse, const Recording& recording, const ImuDeclaration& imu) {
  const double root = std::sqrt(recording.interval_s);
  HybridNoise noise{coarse.gyro.matrix.cwiseAbs2() * start.noise.gyro.cwiseAbs2(), coarse.accel.matrix.cwiseAbs2() * start.noise.accel.cwiseAbs2()};
  noise.gyro = root * noise.gyro.cwiseSqrt();
  noise.accel = root * noise.accel.cwiseSqrt();
  const bool of_grade = imu.noise == NoiseTerms::full && imu.grade;
  if (imu.gyro_noise || of_grade) noise.gyro_walk.setConstant(imu.gyro_noise ? imu.gyro_noise->K : grade(*imu.grade).gyro_noise.K);
  if (!imu.accel_noise && !of_grade) return noise;
  const NoiseModel accel = imu.accel_noise ? *imu.accel_noise : grade(*imu.grade).accel_noise;
  noise.accel_walk.setConstant(accel.K);
  noise.velocity = accel.Q;
  return noise;
}

/// What the data determine, in the table's coefficients; the rest is at the coarse solution and named.
Calibration calibration_of(const HybridData& data, const HybridCourse& course) {
  const HybridLayout& layout = course.settings.layout;
  const HybridErrors errors = determined_errors(course);
  Calibration c;
  c.method = "hybrid";
  c.model = course.model;
  const std::vector<int> of_state = corrected_coefficients(layout);
  for (Index s = 0; s < layout.constants; ++s) {
    const int index = of_state[static_cast<std::size_t>(s)];
    if (index < 0 || course.prior[s] == 0) continue;
    if (std::find(errors.undetermined.begin(), errors.undetermined.end(), s) == errors.undetermined.end()) {
      c.estimated.push_back(index);
    } else {
      c.quality.unobservable.emplace_back(coefficient_table()[static_cast<std::size_t>(index)].name);
      set_coefficient(c.model, index, coefficient_value(data.coarse, index));
    }
  }
  const MatrixXd jacobian = correction_jacobian(course.model, c.estimated, layout);
  c.covariance = jacobian * errors.covariance * jacobian.transpose();
  if (c.estimated.empty()) return c;
  const VectorXd unit = c.covariance.diagonal().cwiseSqrt().cwiseInverse();
  const VectorXd values = MatrixXd(unit.asDiagonal() * c.covariance * unit.asDiagonal()).selfadjointView<Eigen::Lower>().eigenvalues();
  c.quality.condition = std::sqrt(values.maxCoeff() / values.minCoeff());
  return c;
}

/// The latitude that a g-sensitivity alike on all axes would be: up is along the force at every rest, so the two look the same.
std::optional<SeenLatitude> latitude_instead(const Calibration& c, const HybridSite& site) {
  std::vector<Index> at;
  VectorXd value(9), alike = VectorXd::Zero(9);
  for (std::size_t i = 0; i < c.estimated.size(); ++i) {
    const Coefficient& row = coefficient_table()[static_cast<std::size_t>(c.estimated[i])];
    if (row.term != Term::g_sensitivity || at.size() == 9) continue;
    const auto k = static_cast<Index>(at.size());
    value[k] = coefficient_value(c.model, c.estimated[i]);
    alike[k] = row.row == row.column ? 1 : 0;
    at.push_back(static_cast<Index>(i));
  }
  if (at.size() != 9) return {};
  const Eigen::LDLT<MatrixXd> weight(MatrixXd(c.covariance(at, at)));
  const double variance = 1 / alike.dot(weight.solve(alike)), common = variance * alike.dot(weight.solve(value));
  const VectorXd rest = value - common * alike;
  const double sine = std::sin(site.latitude) - common * site.gravity / earth_rate;
  if (common * common < 25 * variance || chi_square_tail(rest.dot(weight.solve(rest)), 8) < 1e-3 || std::abs(sine) > 1) return {};
  const double latitude = std::asin(sine);
  return SeenLatitude{latitude, std::sqrt(variance) * site.gravity / earth_rate / std::cos(latitude)};
}

/// Chi-square of the velocities as the last pass met them.
void add_residuals(const HybridData& data, const HybridCourse& course, Quality& quality) {
  double chi2 = 0;
  int used = 0;
  for (std::size_t k = 0; k < data.blocks.size(); ++k) {
    if (!data.blocks[k].observed) continue;
    chi2 += course.pass.chi2[k];
    ++used;
  }
  const auto states = static_cast<int>((course.prior.array() > 0).count()) + 3;
  quality.degrees_of_freedom = 3 * used - states;
  quality.chi2_per_dof = chi2 / std::max(1, quality.degrees_of_freedom);
}

void add_notes(const HybridData& data, const HybridCourse& course, Quality& quality) {
  quality.notes.push_back(fmt::format("{} repetitions over {} blocks", course.repetitions, data.blocks.size()));
  const double relative_g = data.site.gravity_sigma / data.site.gravity;
  quality.sources.push_back(
      {"gravity", relative_g, fmt::format("g is known to {:.3g} ppm: this much is common to all three accelerometer scales", 1e6 * relative_g)});
  constexpr Index heading = HybridLayout::start + 2;
  if (const double sigma = std::sqrt(course.pass.covariance(heading, heading)); course.terms.g_sensitivity && sigma > 3 * unit::deg)
    quality.warnings.push_back(
        fmt::format("the gyros hardly see the Earth's rate (the heading at the start is known to {:.0f} deg): a g-sensitivity alike on "
                    "all axes is uncertain by some times what is stated; all else is not touched by it",
                    sigma / unit::deg));
  if (const Index at = course.settings.layout.delay; at >= 0)
    quality.notes.push_back(fmt::format("the accelerometers' output is {:.3g} +/- {:.2g} ms behind the gyros'", 1e3 * course.pass.x[at],
                                        1e3 * std::sqrt(course.pass.covariance(at, at))));
}

std::vector<ConvergenceCurve> curves_of(const HybridCourse& course) {
  std::vector<ConvergenceCurve> curves;
  const std::vector<int> of_state = corrected_coefficients(course.settings.layout);
  for (std::size_t s = 0; s < of_state.size(); ++s) {
    const auto at = static_cast<Index>(s);
    if (of_state[s] < 0 || course.prior[at] == 0) continue;
    ConvergenceCurve curve{std::string(coefficient_table()[static_cast<std::size_t>(of_state[s])].name), {}, {}};
    for (const HybridPoint& point : course.pass.curve) {
      curve.residual.push_back(course.total[at] + point.x[at]);
      curve.sigma.push_back(point.sigma[at]);
    }
    curves.push_back(std::move(curve));
  }
  return curves;
}

bool on_turntable(const Session& session) {
  return std::any_of(session.rigs.begin(), session.rigs.end(), [](const RigDeclaration& rig) { return rig.kind == RigKind::turntable; });
}

/// With the latitude that the gyros see in place of the site's, open to be estimated along.
HybridResult at_latitude(const SeenLatitude& seen, const Recording& recording, const std::vector<Range>& rests, Session session,
                         const HybridOptions& options) {
  const double declared = *session.site.latitude;
  session.site.latitude = seen.value;
  session.site.latitude_sigma = 30 * unit::deg;
  HybridResult out = calibrate_hybrid(recording, rests, session, options);
  Quality& quality = out.calibration.quality;
  quality.warnings.push_back(
      fmt::format("the gyros see the Earth's rate of latitude {:.3f} +/- {:.2g} deg, not {:.3f}: theirs is used, with its g where none "
                  "is given; is the site right?",
                  seen.value / unit::deg, seen.sigma / unit::deg, declared / unit::deg));
  const std::string doubt = "the latitude seems to be wrong";
  quality.verdict = quality.verdict == "good" ? "doubtful, because " + doubt : quality.verdict + "; " + doubt;
  return out;
}

struct Settled {
  HybridCourse course;
  std::vector<TermTest> tests;
  std::size_t left_out = 0;              ///< velocities
  std::optional<SeenLatitude> latitude;  ///< instead of the site's: then the rest is void
};

/// Repeats until neither the terms nor the velocities that are used change. Terms are `chosen`, or those significant of more `possible` ones.
/// Outlying blocks are no longer observed in `data`.
Settled settle(HybridData& data, const HybridTerms& chosen, const HybridTerms& possible, double significance) {
  Settled s{converged(data, begin_course(data, chosen)), {}, 0, {}};
  for (int round = 0; round < 6; ++round) {
    HybridReview seen = review(data, s.course, possible, significance);
    s.latitude = seen.latitude;
    if (s.latitude) break;
    if (!(chosen == possible)) {
      s.tests = std::move(seen.tests);
      if (!(seen.significant == s.course.terms)) {  // and again, about them
        s.course = converged(data, with_terms(data, s.course, seen.significant));
        continue;
      }
    }
    if (!s.course.converged) break;
    const std::vector<std::size_t> outlying = outlying_blocks(data, s.course);
    if (outlying.empty()) break;
    for (const std::size_t k : outlying) data.blocks[k].observed = false;
    s.left_out += outlying.size();
    s.course = converged(data, std::move(s.course));
  }
  return s;
}

}  // namespace

HybridResult calibrate_hybrid(const Recording& recording, const std::vector<Range>& rests, const Session& session, const HybridOptions& options) {
  const Site& site = session.site;
  if (!site.latitude) throw Error("[site]: latitude_deg was expected: the Earth's rate is part of what the gyros read");
  const bool turntable = on_turntable(session);
  const std::vector<int> wanted = options.terms.empty() ? std::vector<int>{} : choose_terms(options.terms, supplied_coefficients(), "hybrid");
  expect_alive(recording.gyro, recording.name, "gyro", "the method needs all gyros");
  std::vector<std::string> warnings;
  const std::vector<Range> still = within(recording, rests, warnings);
  const Start start = hybrid_start(recording, still, session.imu, *site.latitude, site.gravity());
  HybridBlocks cut = hybrid_blocks(recording, still, turntable);
  const SensorModel coarse = to_raw(start.scaled_model, start.scaling);
  HybridData data{recording,
                  std::move(cut.blocks),
                  {*site.latitude, site.gravity(), site.latitude_sigma.value_or(0), site.gravity_sigma()},
                  noise_of(start, coarse, recording, session.imu),
                  coarse,
                  wanted};

  const HybridTerms chosen = terms_of(wanted), possible{turntable, true, true, turntable};
  const Settled settled = settle(data, chosen, wanted.empty() ? possible : chosen, options.significance);
  if (settled.latitude) return at_latitude(*settled.latitude, recording, rests, session, options);
  HybridCourse course = settled.course;
  HybridResult out{calibration_of(data, course), coarse, {}, {}, 0};
  out.calibration.imu = session.imu.name;
  Quality& quality = out.calibration.quality;
  quality.notes = start.notes;
  quality.term_tests = settled.tests;
  for (const auto& part : {start.warnings, cut.warnings, warnings}) quality.warnings.insert(quality.warnings.end(), part.begin(), part.end());
  if (settled.left_out > 0)
    quality.warnings.push_back(
        fmt::format("{} of {} velocities were left out: the unit was bumped, shaken, or not in its place", settled.left_out, data.blocks.size()));
  add_residuals(data, course, quality);
  add_notes(data, course, quality);
  std::vector<std::string> doubts = common_doubts(out.calibration, site, 0, 1);
  if (const auto instead = latitude_instead(out.calibration, course.site)) {
    quality.warnings.push_back(fmt::format(
        "the g-sensitivity is the same on all axes, as a latitude of {:.1f} +/- {:.1f} deg instead of {:.1f} would make it: is the site right?",
        instead->value / unit::deg, instead->sigma / unit::deg, course.site.latitude / unit::deg));
    doubts.push_back("the latitude seems to be wrong");
  }
  if (!course.converged) doubts.insert(doubts.begin(), "the repetitions did not converge");
  conclude(out.calibration, doubts);
  if (options.curve_interval > 0) {
    course.settings.curve_interval = options.curve_interval;
    course = repeated(data, std::move(course));
    out.curves = curves_of(course);
    for (const HybridPoint& point : course.pass.curve) out.curve_time.push_back(point.time);
  }
  out.repetitions = course.repetitions;
  return out;
}

}  // namespace imulab
