#include "imulab/estimate/whole_unit/stepwise.hpp"

#include "imulab/compensate.hpp"
#include "imulab/core/decomposition.hpp"
#include "imulab/error.hpp"
#include "imulab/model/compensation_derivatives.hpp"
#include "imulab/recording/scaling.hpp"
#include "imulab/rig/machine_points.hpp"

#include <Eigen/LU>
#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <map>

namespace imulab::whole_unit {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

namespace {

/// Returns the reference temperature, a whole number: the mean of the points outside the chamber, where most points are, or the middle of the range
/// if there is only a chamber.
double reference_temperature(const MachinePoints& points, std::size_t triad) {
  double sum = 0, n = 0;
  for (const MachinePoint& p : points.all)
    if (p.machine != RigKind::chamber) sum += p.temperature.segment<3>(static_cast<Index>(3 * triad)).mean(), n += 1;
  return std::round(n > 0 ? sum / n : 0.5 * (points.thermal[triad].low + points.thermal[triad].high));
}

/// Returns offset and matrix for readings minus `center`, by least squares with the motion of the machines, without some points; absent if the
/// machines did not excite each axis.
std::optional<TriadModel> linear_fit(const std::vector<MachinePoint>& points, const Range& without, const Session& session, const Vector6d& center,
                                     std::size_t triad) {
  const auto rows = static_cast<Index>(points.size() - without.size());
  MatrixXd x(rows, 4), y(rows, 3);
  Index row = 0;
  for (std::size_t k = 0; k < points.size(); ++k) {
    if (k >= without.begin && k < without.end) continue;
    const Motion m = steady_motion(points[k].step, session.site);
    x.row(row) << 1, (points[k].raw - center).segment<3>(static_cast<Index>(3 * triad)).transpose();
    y.row(row++) = triad == 0 ? m.force : m.rate;
  }
  if (rows < 4) return std::nullopt;
  const Eigen::RowVectorXd scale = x.colwise().norm().cwiseMax(1e-300);
  constexpr double threshold = 1e-3;  // the effect of temperature and noise on an unexcited direction is below this
  const LeastSquares scaled = least_squares(x * scale.cwiseInverse().asDiagonal(), y, threshold);
  if (scaled.rank < 4) return std::nullopt;
  const MatrixXd fit = scale.cwiseInverse().asDiagonal() * scaled.x;
  TriadModel out;
  out.offset = fit.row(0), out.matrix = fit.bottomRows(3).transpose();
  return out;
}

}  // namespace

Vector6d reading_center(const MachinePoints& points) {
  Vector6d low = points.all.front().raw, high = low;
  for (const MachinePoint& p : points.all) low = low.cwiseMin(p.raw), high = high.cwiseMax(p.raw);
  const Vector6d middle = 0.5 * (low + high), half = 0.5 * (high - low);
  return (middle.array().abs() > half.array().max(1000)).select(middle.array().round(), 0);  // counts
}

SensorModel starting_model(const MachinePoints& points, const Session& session, const Vector6d& center) {
  const RecordingSource& source = session.recordings.front();
  SensorModel start;
  for (std::size_t triad = 0; triad < 2; ++triad) {
    TriadModel& m = triad == 0 ? start.accel : start.gyro;
    const ThermalRange& thermal = points.thermal[triad];
    const bool counts = (triad == 0 ? source.accel : source.gyro).unit == "count";
    if (counts) {
      const auto fit = linear_fit(points.all, {}, session, center, triad);
      if (!fit)
        throw Unsupported(fmt::format("{}: the {} read counts, and the machines do not move each axis; their scales cannot be determined",
                                      session.file, triad == 0 ? "accelerometers" : "gyros"));
      m = *fit;
    }
    m.raw_unit = counts ? "count" : triad == 0 ? "m/s^2" : "rad/s";
    if (thermal.known) m.temperature = ThermalReading{thermal.unit, reference_temperature(points, triad), {thermal.low, thermal.high}};
  }
  return start;
}

void check_mounts(const MachinePoints& points, const Session& session, const SensorModel& start, const Vector6d& center) {
  const std::vector<MachinePoint>& all = points.all;
  const auto same_mounting = [](const MachinePoint& a, const MachinePoint& b) {
    return a.recording == b.recording && mount_of(a.step) == mount_of(b.step);
  };
  for (Range here; here.begin < all.size(); here.begin = here.end) {  // a mounting: consecutive points
    while (here.end < all.size() && same_mounting(all[here.begin], all[here.end])) ++here.end;
    TriadModel accel = start.accel, gyro = start.gyro;
    // Counts require a fit; a fit to the other points is independent of these.
    if (accel.raw_unit == "count") accel = linear_fit(all, here, session, center, 0).value_or(accel);
    if (gyro.raw_unit == "count") gyro = linear_fit(all, here, session, center, 1).value_or(gyro);
    std::vector<Motion> measured;
    for (std::size_t k = here.begin; k < here.end; ++k) {
      const Vector6d raw = all[k].raw - center;
      measured.push_back({.rate = linear_output(gyro, raw.tail<3>()), .force = linear_output(accel, raw.head<3>())});
    }
    expect_declared_mount(std::span(all).subspan(here.begin, here.size()), measured, session);
  }
}

namespace {

constexpr std::initializer_list<Term> polynomial{Term::offset, Term::matrix, Term::quadratic, Term::cubic};

/// Three misfits of force or rate, linear in the coefficients of their step. Columns: derivatives by the problem's coefficients (of this step, and of
/// earlier steps); the misfit with the coefficients so far; derivatives by the unit-variance noises of all points, then by the common errors over
/// their sigmas (absent without covariance).
using Equations = Eigen::Matrix<double, 3, Eigen::Dynamic>;

class Steps {
 public:
  Steps(const PointProblem& problem, bool with_covariance)
      : problem_(problem),
        points_(problem.points.all),
        model_(problem.model),
        with_covariance_(with_covariance),
        coefficients_(std::ssize(problem.coefficients)),
        noises_(12 * std::ssize(points_)),
        sensitivity_(MatrixXd::Zero(coefficients_, with_covariance ? noises_ + std::ssize(problem.common) : 0)) {
    for (const CoefficientIndex k : problem.coefficients) set_coefficient(model_, k, 0);
  }

  /// Step 1: U = u0 + c1 tau + c2 tau^2 in every channel.
  void chamber() {
    const auto points = points_of(RigKind::chamber);
    const auto rows = static_cast<Index>(points.size());
    for (Index channel = 0; channel < 6; ++channel) {
      const Triad triad = channel < 3 ? Triad::accel : Triad::gyro;
      const auto axis = static_cast<int>(channel % 3);
      if (!problem_.points.thermal[channel < 3 ? 0 : 1].known) continue;
      MatrixXd x(rows, 3);
      VectorXd u(rows);
      for (Index k = 0; const std::size_t p : points) {
        const RawSample raw = problem_.sample(points_[p]);
        const double tau = (channel < 3 ? raw.accel_tau : raw.gyro_tau)[axis];
        x.row(k) << 1, tau, tau * tau;
        u[k++] = (channel < 3 ? raw.accel : raw.gyro)[axis];
      }
      const MatrixXd pseudo_inverse = least_squares(x, MatrixXd::Identity(rows, rows)).x;
      const VectorXd fit = pseudo_inverse * u;
      for (int order = 1; order <= 2; ++order) {
        const CoefficientIndex index = coefficient_index(triad, Term::thermal, axis, order);
        set_coefficient(model_, index, fit[order]);
        if (!with_covariance_) continue;
        const auto at = std::find(problem_.coefficients.begin(), problem_.coefficients.end(), index) - problem_.coefficients.begin();
        for (Index k = 0; const std::size_t p : points) {
          const double share = pseudo_inverse(order, k), slope = fit[1] + 2 * fit[2] * x(k, 1);
          const auto column = static_cast<Index>(12 * p);
          sensitivity_.row(at).segment<6>(column) = share * raw_by_noise(p).row(channel);
          sensitivity_(at, column + 6 + channel) = -share * slope * thermal_sigma(p)[channel];
          ++k;
        }
      }
    }
  }

  /// Step 2: means of opposed positions at equal rate; W0, W1, W2, W3 (eqs 5, 6).
  void rate_table() {
    // The keys are the body's rate along an axis; the values are positions with that axis up and down.
    std::map<std::pair<int, std::int64_t>, std::array<std::vector<std::size_t>, 2>> opposed;
    for (const std::size_t p : points_of(RigKind::rate_table)) {
      const Step& step = points_[p].step;
      const BodyAxis up = mount_of(step).up;
      const double rate = step.kind == StepKind::spin ? step.rate * up.sign : 0;
      opposed[{up.index, std::llround(rate * 1e6)}][up.sign > 0].push_back(p);
    }
    // The second pass has the first one's coefficients, which determine the effect of reading noise on the misfit.
    for (int pass = 0; pass < 2; ++pass) {
      std::vector<Equations> means;
      for (const auto& [key, positions] : opposed) {
        if (positions[0].empty() || positions[1].empty()) continue;
        Equations& mean = means.emplace_back(Equations::Zero(3, columns()));
        for (const auto& side : positions)
          for (const std::size_t p : side) mean += 0.5 / static_cast<double>(side.size()) * equations(p, Triad::gyro);
      }
      solve(means, Triad::gyro, polynomial, "the rate table's points");
    }
  }

  /// Step 3: A0, A1, A2, A3 (eq 7), then C from the gyros' residuals (eqs 9, 10).
  void centrifuge(Triad triad, std::initializer_list<Term> terms, int passes) {
    for (int pass = 0; pass < passes; ++pass) {
      std::vector<Equations> all;
      for (const std::size_t p : points_of(RigKind::centrifuge)) all.push_back(equations(p, triad));
      solve(all, triad, terms, "the centrifuge's points");
    }
  }

  StepwiseEstimate estimate() const { return {model_, sensitivity_ * sensitivity_.transpose()}; }

 private:
  Index columns() const { return coefficients_ + 1 + sensitivity_.cols(); }

  std::vector<std::size_t> points_of(RigKind kind) const {
    std::vector<std::size_t> points;
    for (std::size_t p = 0; p < points_.size(); ++p)
      if (points_[p].machine == kind) points.push_back(p);
    return points;
  }

  /// Returns the change of the raw means per sigma of the mean's noise, which is given in force and rate.
  Eigen::Matrix<double, 6, 6> raw_by_noise(std::size_t p) const {
    const Vector6d sigma = (problem_.noise / static_cast<double>(points_[p].samples)).cwiseSqrt();
    return accel_first_derivatives(problem_.model, problem_.sample(points_[p])).raw.inverse() * sigma.asDiagonal();
  }

  Vector6d thermal_sigma(std::size_t p) const { return (problem_.points.thermal_variance / static_cast<double>(points_[p].samples)).cwiseSqrt(); }

  /// Returns e = compensate - motion at a point with the coefficients so far.
  Equations equations(std::size_t p, Triad triad) const {
    const CompensationDerivatives d = accel_first_derivatives(model_, problem_.sample(points_[p]));
    Eigen::Matrix<double, 6, Eigen::Dynamic> motion_by_common;
    const Motion truth = problem_.motion(points_[p], &motion_by_common);
    const Index row = triad == Triad::accel ? 0 : 3;
    Equations e = Equations::Zero(3, columns());
    e.leftCols(coefficients_) = d.coefficients(Eigen::seqN(row, 3), problem_.coefficients);
    e.col(coefficients_) = triad == Triad::accel ? d.motion.force - truth.force : d.motion.rate - truth.rate;
    if (!with_covariance_) return e;
    auto misfit_by_noise = e.rightCols(sensitivity_.cols());
    misfit_by_noise.middleCols<6>(static_cast<Index>(12 * p)) = d.raw.middleRows<3>(row) * raw_by_noise(p);
    misfit_by_noise.middleCols<6>(static_cast<Index>(12 * p) + 6) = d.temperature.middleRows<3>(row) * thermal_sigma(p).asDiagonal();
    for (Index k = 0; const CommonError& error : problem_.common) {
      misfit_by_noise.col(noises_ + k) = -error.sigma * motion_by_common.col(k).segment<3>(row);
      ++k;
    }
    return e;
  }

  /// Solves least squares for the coefficients of the step, and propagates the effects of noise and of earlier steps.
  void solve(const std::vector<Equations>& equations, Triad triad, std::initializer_list<Term> terms, std::string_view points) {
    std::vector<Index> own;
    for (Index k = 0; const CoefficientIndex index : problem_.coefficients) {
      const Coefficient& c = coefficient(index);
      if (c.triad == triad && std::find(terms.begin(), terms.end(), c.term) != terms.end()) own.push_back(k);
      ++k;
    }
    MatrixXd all(3 * std::ssize(equations), columns());
    for (Index row = 0; const Equations& e : equations) all.middleRows<3>(row) = e, row += 3;
    const MatrixXd design = all(Eigen::all, own);
    const kernel::Solution s = kernel::solve({design, all.col(coefficients_)}, kernel::Parameters(design.cols()), points);
    for (Index k = 0; const Index i : own) {
      const CoefficientIndex index = problem_.coefficients[static_cast<std::size_t>(i)];
      set_coefficient(model_, index, coefficient_value(model_, index) + s.x[k++]);
    }
    if (!with_covariance_) return;
    all(Eigen::all, own).setZero();  // the remaining columns belong to earlier steps
    sensitivity_(own, Eigen::all) =
        -s.covariance * design.transpose() * (all.rightCols(sensitivity_.cols()) + all.leftCols(coefficients_) * sensitivity_);
  }

  const PointProblem& problem_;
  const std::vector<MachinePoint>& points_;
  SensorModel model_;
  bool with_covariance_;
  Index coefficients_, noises_;
  MatrixXd sensitivity_;  ///< sensitivity of the coefficients, with columns as in the equations
};

/// Returns true if the session has the data for all three steps.
bool has_three_steps(const PointProblem& problem) {
  std::map<RigKind, std::array<bool, 6>> seen;
  for (const MachinePoint& p : problem.points.all) {
    const Mount mount = mount_of(p.step);
    const BodyAxis axis = p.machine == RigKind::centrifuge ? mount.outward : mount.up;
    seen[p.machine][2 * static_cast<std::size_t>(axis.index) + (axis.sign > 0 ? 1 : 0)] = true;
  }
  const auto all = [&](RigKind kind) { return seen.contains(kind) && std::all_of(seen[kind].begin(), seen[kind].end(), [](bool b) { return b; }); };
  return seen.contains(RigKind::chamber) && all(RigKind::rate_table) && all(RigKind::centrifuge);
}

}  // namespace

StepwiseEstimate stepwise_estimate(const PointProblem& problem, bool with_covariance) {
  if (!has_three_steps(problem))
    throw Unsupported(
        "the machines do not do all of Dai's three steps; expected a chamber, a rate table with each axis up and down, and a centrifuge "
        "with each axis outward both ways");
  PointProblem declared = problem;
  for (CommonError& error : declared.common) error.value = 0;
  Steps steps(declared, with_covariance);
  steps.chamber();
  steps.rate_table();
  steps.centrifuge(Triad::accel, polynomial, 2);
  steps.centrifuge(Triad::gyro, {Term::g_sensitivity}, 1);
  return steps.estimate();
}

}  // namespace imulab::whole_unit
