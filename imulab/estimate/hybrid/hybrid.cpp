#include "imulab/estimate/hybrid/hybrid.hpp"

#include "imulab/core/decomposition.hpp"
#include "imulab/core/error.hpp"
#include "imulab/core/statistics.hpp"
#include "imulab/core/units.hpp"
#include "imulab/earth/earth.hpp"
#include "imulab/estimate/hybrid/iteration.hpp"
#include "imulab/estimate/kernel/coarse.hpp"
#include "imulab/estimate/kernel/input.hpp"
#include "imulab/estimate/kernel/optional_terms.hpp"
#include "imulab/estimate/kernel/rest_start.hpp"
#include "imulab/model/triad_axes.hpp"
#include "imulab/recording/quiet_noise.hpp"

#include <Eigen/LU>
#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <numeric>

namespace imulab::hybrid {

namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

constexpr const char* wrong_latitude = "the latitude seems to be wrong";

/// Coarse gyros: from the Earth's rate at rest where the rests allow it, else the declared unit or, for counts, the motion of gravity; offset from
/// the rests.
void start_gyro(kernel::RestStart& start, const Recording& recording, double latitude) {
  TriadModel& gyro = start.model.gyro;
  std::vector<Vector3d> readings, up;
  for (const RestMeans& rest : start.rests) readings.push_back(start.gyro(rest)), up.push_back(start.up(rest));
  const bool counts = recording.gyro_unit == "count";
  const auto at_rest = kernel::coarse_gyro_at_rest(readings, up, earth_rate * std::sin(latitude));
  if (at_rest && !counts && (at_rest->matrix - Matrix3d::Identity()).cwiseAbs().maxCoeff() < 0.05) {
    gyro.matrix = at_rest->matrix;
    gyro.offset = at_rest->offset;
    start.findings.note("gyros started from the Earth's rate at rest");
    return;
  }
  if (counts) {
    const auto in_motion = kernel::coarse_gyro_in_motion(recording, start.rests, start.model, start.scaling);
    if (!in_motion)
      throw Unsupported(recording.name + ": gyro: the motion does not turn the IMU about all its axes; readings in counts need that for their scale");
    gyro.matrix = *in_motion;
  }
  const Vector3d mean = gyro.matrix * start.scaling.gyro(mean_gyro(start.rests));
  if (mean.norm() > 2 * earth_rate) gyro.offset = -mean;  // a smaller mean is largely the Earth's rate
  start.findings.note(counts ? "gyros started from the motion of gravity between the rests" : "gyros started from the declared unit");
}

void check_axes(const Recording& recording, const kernel::RestStart& start) {
  const auto in_motion = kernel::coarse_gyro_in_motion(recording, start.rests, start.model, start.scaling);
  if (!in_motion || !(std::abs(in_motion->determinant()) > 0)) return;
  if (const std::string wrong = wrong_axes(*in_motion); !wrong.empty())
    throw Error(recording.name + ": " + wrong + ", as gravity turns in the IMU; expected right-handed axes, the same for both triads");
}

void use_quiet_noise(kernel::RestStart& start, const Recording& recording, const std::vector<Range>& rests, const ImuDeclaration& imu) {
  const std::size_t second = std::max<std::size_t>(5, static_cast<std::size_t>(std::lround(1 / recording.interval_s)));
  for (std::size_t j = 0; j < 3; ++j) {
    const auto axis = static_cast<Index>(j);
    if (!imu.accel_noise_density) start.noise.accel[axis] = std::min(start.noise.accel[axis], quiet_noise(recording.accel[j], rests, second));
    start.noise.gyro[axis] = std::min(start.noise.gyro[axis], quiet_noise(recording.gyro[j], rests, second));
  }
  kernel::limit_noise(start);
}

/// Rests, their noise, and a coarse solution of both triads (Cheng 2014 sec 1.2). Throws as kernel::start_from_rests does, and Error for axes that
/// are swapped, reversed or left-handed.
kernel::RestStart coarse_start(const Recording& recording, const std::vector<Range>& rests, const ImuDeclaration& imu, double latitude,
                               double gravity) {
  kernel::RestStart start = kernel::start_from_rests(recording, rests, imu, gravity);
  use_quiet_noise(start, recording, rests, imu);
  start_gyro(start, recording, latitude);
  kernel::use_declared_gyro_noise(start, recording, imu);
  check_axes(recording, start);
  return start;
}

/// White noise of the calibrated output from the samples' or the declared noise; the other terms as declared.
Noise noise_of(const SampleNoise& raw, const SensorModel& coarse, const Recording& recording, const ImuDeclaration& imu, std::size_t rests) {
  const auto density = [&](const TriadModel& triad, const Vector3d& sigma) {
    return Vector3d(std::sqrt(recording.interval_s) * (triad.matrix.cwiseAbs2() * sigma.cwiseAbs2()).cwiseSqrt());
  };
  return in_place::noise_of(density(coarse.gyro, raw.gyro), density(coarse.accel, raw.accel), declared_terms(imu),
                            recording.interval_s * static_cast<double>(recording.size()) / static_cast<double>(rests));
}

void warn_of_short_rests(const std::vector<Range>& rests, const std::vector<Range>& still, kernel::Findings& findings) {
  const auto n = std::inner_product(rests.begin(), rests.end(), still.begin(), std::size_t{0}, std::plus<>(), std::equal_to<>());
  if (2 * n > rests.size())
    findings.warn(
        fmt::format("{} of {} rests are no longer than {:g} s; settling transients at their ends cannot be cut off, and the Earth's rate hardly "
                    "shows in them; use rests of 30 s or more",
                    n, rests.size(), 5 * in_place::settling_time));
}

/// The determined coefficients of the table; the others stay at the coarse solution and are named.
Calibration calibration_of(const Data& data, const Iterate& iterate) {
  const Errors errors = determined_errors(iterate);
  Calibration c;
  c.method = "hybrid";
  c.model = iterate.about.model;
  c.estimated = errors.coefficients;
  for (const CoefficientIndex index : errors.considered) c.quality.considered.emplace_back(coefficient(index).name);
  for (const CoefficientIndex index : errors.open) {
    c.quality.unobservable.emplace_back(coefficient(index).name);
    set_coefficient(c.model, index, coefficient_value(data.coarse, index));
  }
  const MatrixXd jacobian = correction_jacobian(iterate.about.model, c.estimated, iterate.states);
  c.covariance = jacobian * errors.covariance * jacobian.transpose();
  if (!c.estimated.empty()) c.quality.condition = kernel::condition_number(c.covariance);
  return c;
}

/// Coefficients of which the data say nothing: cubic terms look like scales at the force and the rate that the data have, and quadratic terms of the
/// gyros, which turns in both directions tell from scales, like nothing that they can be told from. They count in the scales' covariance.
void consider_nonlinearity(const Data& data, Calibration& c) {
  std::vector<double> rates;
  for (const Block& block : data.blocks)
    if (!block.at_rest)
      for (std::size_t k = 0; k < 3; ++k) rates.push_back(std::abs(data.recording.gyro[k][block.samples.begin]));
  const double force = data.place.gravity, rate = rates.empty() ? 0 : quantile(rates, 0.9) * std::cbrt(std::abs(c.model.gyro.matrix.determinant()));
  for (const char* selector : {"accel.cubic", "gyro.quadratic", "gyro.cubic"})
    for (const CoefficientIndex index : select_coefficients(selector)) {
      const Coefficient& term = coefficient(index);
      const TriadModel& triad = term.triad == Triad::accel ? c.model.accel : c.model.gyro;
      const double scale = std::abs(triad.matrix(term.row, term.row)), reading = (term.triad == Triad::accel ? force : rate) / scale;
      const CoefficientIndex slope = coefficient_index(term.triad, Term::matrix, term.row, term.row);
      const auto at = std::find(c.estimated.begin(), c.estimated.end(), slope);
      if (at == c.estimated.end()) continue;
      const double sigma = kernel::prior_sigma(data.priors.sizes, term, scale), effect = term.term == Term::cubic ? reading * reading : reading;
      const Index row = at - c.estimated.begin(), n = c.covariance.rows();
      c.covariance.conservativeResize(n + 1, n + 1);
      c.covariance.row(n).setZero(), c.covariance.col(n).setZero();
      c.covariance(n, n) = sigma * sigma;
      c.covariance(row, row) += std::pow(sigma * effect, 2);
      if (term.term == Term::cubic) c.covariance(row, n) = c.covariance(n, row) = -sigma * sigma * effect;
      c.estimated.push_back(index);
      c.quality.considered.emplace_back(term.name);
    }
}

/// The latitude that a g-sensitivity equal on all axes corresponds to: up is along the force at every rest, so the two cannot be told apart.
std::optional<SeenLatitude> latitude_instead(const Calibration& c, const Place& place) {
  std::vector<Index> at;
  VectorXd value(9), alike = VectorXd::Zero(9);
  for (std::size_t i = 0; i < c.estimated.size(); ++i) {
    const Coefficient& row = coefficient(c.estimated[i]);
    if (row.term != Term::g_sensitivity) continue;
    const auto k = static_cast<Index>(at.size());
    value[k] = coefficient_value(c.model, c.estimated[i]);
    alike[k] = row.row == row.column ? 1 : 0;
    at.push_back(static_cast<Index>(i));
  }
  if (at.size() != 9) return {};
  const MatrixXd covariance = c.covariance(at, at);
  const VectorXd weight = solve_semidefinite(covariance, alike);
  const double variance = 1 / alike.dot(weight), common = variance * value.dot(weight);
  const VectorXd rest = value - common * alike;
  const double sine = std::sin(place.latitude) - common * place.gravity / earth_rate;
  if (common * common < 25 * variance || chi_square_tail(squared_norm_in(covariance, rest), 8) < 1e-3 || std::abs(sine) > 1) return {};
  const double latitude = std::asin(sine);
  return SeenLatitude{latitude, std::sqrt(variance) * place.gravity / earth_rate / std::cos(latitude)};
}

/// Chi-square of the velocities in the last pass.
void add_residuals(const Data& data, const Iterate& iterate, Quality& quality) {
  const std::vector<double>& chi2 = iterate.pass.chi2;
  const auto used = std::count_if(data.blocks.begin(), data.blocks.end(), [](const Block& b) { return b.observed; });
  quality.degrees_of_freedom = static_cast<int>(3 * used - (iterate.states.prior.array() > 0).count());
  quality.chi2_per_dof = std::accumulate(chi2.begin(), chi2.end(), 0.0) / std::max(1, quality.degrees_of_freedom);
}

/// Neighbouring blocks that were left out together.
struct Disturbance {
  std::size_t first, last;
};

std::vector<Disturbance> disturbances(std::vector<std::size_t> left_out) {
  std::sort(left_out.begin(), left_out.end());
  std::vector<Disturbance> out;
  for (const std::size_t k : left_out) {
    if (out.empty() || k > out.back().last + 1) out.push_back({k, k});
    out.back().last = k;
  }
  return out;
}

/// Bumps come at any time. Velocities left out that gather in turns, or in rests, are a term that the model lacks.
void judge_left_out(const Data& data, const std::vector<Disturbance>& found, kernel::Findings& findings) {
  constexpr double improbable = 1e-4;
  double turning = 0, observed = 0, in_turns = 0;
  for (const Block& block : data.blocks) observed += 1, turning += !block.at_rest;
  for (const Disturbance& d : found) in_turns += !data.blocks[d.first].at_rest;
  const double n = static_cast<double>(found.size());
  if (turning == 0 || binomial_quantile(1 - improbable, n, turning / observed) >= in_turns) return;
  findings.doubt(
      fmt::format("{:.0f} of {:.0f} disturbances that were left out are in turns: that is no bump but something that the model lacks; check the "
                  "delay between the triads, the lever arms and the stamps",
                  in_turns, n));
}

/// What was left out, with its times.
void add_left_out(const Data& data, const std::vector<std::size_t>& left_out, kernel::Findings& findings) {
  if (left_out.empty()) return;
  constexpr std::size_t most_listed = 10;
  const std::vector<Disturbance> found = disturbances(left_out);
  std::string times;
  for (std::size_t k = 0; k < std::min(found.size(), most_listed); ++k)
    times += fmt::format("{}{:.1f}..{:.1f} s", k == 0 ? "" : ", ", data.recording.time_s(data.blocks[found[k].first].samples.begin),
                         data.recording.time_s(data.blocks[found[k].last].samples.end - 1));
  if (found.size() > most_listed) times += fmt::format(" and {} more", found.size() - most_listed);
  findings.warn(fmt::format("{} of {} velocities do not fit: the IMU was bumped, shaken, or displaced; they are not used: {}", left_out.size(),
                            data.blocks.size(), times));
  judge_left_out(data, found, findings);
}

/// Enlarges the uncertainties where the velocities scatter more than the noise explains.
void enlarge(const Data& data, const Iterate& iterate, Calibration& calibration, kernel::Findings& findings) {
  const auto excess_of = [&](auto counts) {
    double chi2 = 0, degrees = 0;
    for (std::size_t k = 0; k < data.blocks.size(); ++k)
      if (data.blocks[k].observed && counts(data.blocks[k])) chi2 += iterate.pass.chi2[k], degrees += 3;
    return kernel::excess(chi2, degrees);
  };
  double factor = excess_of([](const Block& b) { return b.at_rest; });
  // The ramps of turns between two samples leave a few percent there; half as much again is more than that.
  if (const double in_turns = excess_of([](const Block& b) { return !b.at_rest; }); in_turns > 1.5) factor = std::max(factor, in_turns);
  calibration.covariance *= factor * factor;
  kernel::add_scatter(findings, "velocities", factor);
}

void report(const Data& data, const Converged& result, const Site& site, Calibration& calibration, kernel::Findings& findings) {
  const Iterate& last = result.last;
  const auto sigma = [&](Index state) { return std::sqrt(last.pass.covariance(state, state)); };
  add_residuals(data, last, calibration.quality);
  enlarge(data, last, calibration, findings);
  calibration.quality.term_tests = result.tests;
  calibration.quality.converged = last.converged;
  calibration.quality.sources.push_back(kernel::gravity_source(site));
  add_left_out(data, result.left_out, findings);
  findings.note(fmt::format("{} iterations over {} blocks", last.iterations, data.blocks.size()));
  if (const double heading = sigma(last.states.first(Group::start) + 2); last.terms.contains(Group::g_sensitivity) && heading > 3 * unit::deg)
    findings.warn(
        fmt::format("the gyros hardly measure the Earth's rate (the heading at the start is known to {:.0f} deg); a g-sensitivity equal on all "
                    "axes is several times less certain than stated; the other coefficients are not affected",
                    heading / unit::deg));
  if (const Index at = last.states.first(Group::delay); at >= 0)
    findings.note(fmt::format("the accelerometers' output is {:.3g} +/- {:.2g} ms behind the gyros'", 1e3 * last.pass.x[at], 1e3 * sigma(at)));
  kernel::add_common_doubts(findings, calibration, site);
  if (const auto instead = latitude_instead(calibration, last.about.place)) {
    findings.warn(
        fmt::format("the g-sensitivity is the same on all axes, as a latitude of {:.1f} +/- {:.1f} deg instead of {:.1f} would make it; check "
                    "the site's latitude",
                    instead->value / unit::deg, instead->sigma / unit::deg, last.about.place.latitude / unit::deg));
    findings.doubt(wrong_latitude);
  }
}

void add_curves(const Data& data, const Iterate& iterate, double interval, CalibrationResult& out) {
  const Iterate last = repeated(data, iterate, interval);
  for (const Index s : last.states.corrections()) {
    ConvergenceCurve curve{std::string(coefficient(last.states.corrects(s)).name), {}, {}};
    for (const CurvePoint& point : last.pass.curve) {
      curve.residual.push_back(last.total[s] + point.x[s]);
      curve.sigma.push_back(point.sigma[s]);
    }
    out.curves.push_back(std::move(curve));
  }
  for (const CurvePoint& point : last.pass.curve) out.curve_time.push_back(point.time);
  out.iterations = last.iterations;
}

/// `findings`: those so far; `last`: those to be listed last.
CalibrationResult calibrated(const Recording& recording, const std::vector<Range>& rests, const Session& session, const CalibrationOptions& options,
                             kernel::Findings findings, const kernel::Findings& last) {
  const Place place = place_of(session.site);
  const bool turntable = on_turntable(session);
  std::vector<CoefficientIndex> wanted;
  if (!options.terms.empty()) wanted = kernel::chosen_coefficients(options.terms, all_coefficients(), "hybrid");
  kernel::expect_alive(recording.gyro, recording.name, "gyro", "the method needs all gyros");
  const std::vector<Range> still = in_place::still_parts(recording, rests);
  const kernel::RestStart start = coarse_start(recording, still, session.imu, place.latitude, place.gravity);
  in_place::Blocks cut = in_place::cut_into_blocks(recording, still, turntable);
  const SensorModel coarse = to_raw(start.model, start.scaling);
  Data data{recording,
            std::move(cut.blocks),
            place,
            noise_of(start.noise, coarse, recording, session.imu, rests.size()),
            coarse,
            wanted,
            {kernel::optional_priors(session.imu, coarse.accel.offset, coarse.gyro.offset), kernel::delay_prior(session.imu, recording.interval_s)}};

  Groups terms = wanted.empty() ? Groups{Group::quadratic, Group::g_sensitivity} : optional_groups(wanted);
  if (wanted.empty() && turntable) terms.insert({Group::lever_arm, Group::delay});
  const Converged result = converge(data, terms, options.significance);
  if (result.latitude) {  // it replaces the site's and is estimated jointly
    Session there = session;
    there.site.latitude = result.latitude->value;
    there.site.latitude_sigma = 30 * unit::deg;
    kernel::Findings instead;
    instead.warn(
        fmt::format("the gyros measure the Earth's rate of latitude {:.3f} +/- {:.2g} deg, not {:.3f}; that one is used, with its g where none "
                    "is given; check the site's latitude",
                    result.latitude->value / unit::deg, result.latitude->sigma / unit::deg, place.latitude / unit::deg));
    if (last.doubts.empty()) instead.doubt(wrong_latitude);
    instead.add(last);
    return calibrated(recording, rests, there, options, std::move(findings), instead);
  }
  findings.add(start.findings);
  for (const std::string& warning : cut.warnings) findings.warn(warning);
  warn_of_short_rests(rests, still, findings);
  CalibrationResult out{calibration_of(data, result.last), coarse, {}, {}, result.last.iterations};
  out.calibration.imu = session.imu.name;
  report(data, result, session.site, out.calibration, findings);
  if (wanted.empty()) consider_nonlinearity(data, out.calibration);
  findings.add(last);
  kernel::conclude(out.calibration, findings);
  if (options.hybrid.curve_interval > 0) add_curves(data, result.last, options.hybrid.curve_interval, out);
  return out;
}

}  // namespace

CalibrationResult calibrate(const CalibrationInput& input, const CalibrationOptions& options) {
  const Recording& recording = kernel::only_recording(input, "hybrid");
  const Rests rests = kernel::rests_of(input, recording);
  return calibrated(recording, rests.ranges, input.session, options, {rests.notes, {}, {}}, {});
}

}  // namespace imulab::hybrid
