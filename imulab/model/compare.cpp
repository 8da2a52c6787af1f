#include "imulab/compare.hpp"

#include "imulab/coefficient.hpp"
#include "imulab/core/decomposition.hpp"
#include "imulab/core/statistics.hpp"
#include "imulab/error.hpp"
#include "imulab/frame.hpp"
#include "imulab/model/gauge.hpp"

#include <Eigen/LU>

#include <algorithm>
#include <cmath>

namespace imulab {

namespace {

Eigen::VectorXd values(const SensorModel& model) {
  Eigen::VectorXd v(coefficient_count);
  for (const CoefficientIndex i : coefficient_indices()) v(i) = coefficient_value(model, i);
  return v;
}

/// Returns the covariance over the whole table, zero for coefficients that were not estimated.
Eigen::MatrixXd table_covariance(const Calibration& c) {
  Eigen::MatrixXd p = Eigen::MatrixXd::Zero(coefficient_count, coefficient_count);
  p(c.estimated, c.estimated) = c.covariance;
  return p;
}

/// Returns the part of the covariance that recurs for the same unit, over the whole table.
Eigen::MatrixXd table_constant(const Calibration& c) {
  Eigen::MatrixXd p = Eigen::MatrixXd::Zero(coefficient_count, coefficient_count);
  if (c.constant_covariance.size() > 0) p(c.estimated, c.estimated) = c.constant_covariance;
  return p;
}

/// Returns a covariance minus a part of it, or zero if nothing remains to be tested.
Eigen::MatrixXd without(const Eigen::MatrixXd& covariance, const Eigen::MatrixXd& part) {
  constexpr double rounding = 1e-9;
  Eigen::MatrixXd p = covariance - part;
  for (const CoefficientIndex i : coefficient_indices())
    if (!(p(i, i) > rounding * covariance(i, i))) p.row(i).setZero(), p.col(i).setZero();
  return p;
}

/// Returns true for calibrations of one unit by one method, as far as they state it: their unobservable errors are equal.
bool shares_constant(const Calibration& a, const Calibration& b) { return a.method == b.method && a.imu == b.imu && a.serial == b.serial; }

int first_lever_arm() { return coefficient_index(Triad::accel, Term::lever_arm, 0, 0); }

bool has_lever_arms(const std::vector<CoefficientIndex>& estimated) {
  const auto of_arms = [](CoefficientIndex i) { return coefficient(i).term == Term::lever_arm; };
  return std::count_if(estimated.begin(), estimated.end(), of_arms) == 9;
}

/// Returns the map from lever arms to lever arms relative to the accelerometers' mean point.
Eigen::MatrixXd about_mean_point() {
  Eigen::MatrixXd t = Eigen::MatrixXd::Identity(coefficient_count, coefficient_count);
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j) t.block<3, 3>(first_lever_arm() + 3 * i, first_lever_arm() + 3 * j) -= Matrix3d::Identity() / 3;
  return t;
}

Vector3d mean_point(const SensorModel& model) { return model.lever_arm.colwise().mean(); }

/// Returns the map from differences of coefficients to those with D = (M_b - M_a) M_a^-1 for matrices.
Eigen::MatrixXd to_relative(const SensorModel& a) {
  Eigen::MatrixXd t = Eigen::MatrixXd::Identity(coefficient_count, coefficient_count);
  for (const Triad triad : {Triad::accel, Triad::gyro}) {
    const Matrix3d& matrix = triad == Triad::accel ? a.accel.matrix : a.gyro.matrix;
    if (!(std::abs(matrix.determinant()) > 0)) throw Error(std::string(to_string(triad)) + ".matrix is singular");
    for (int row = 0; row < 3; ++row) {
      const int at = coefficient_index(triad, Term::matrix, row, 0);
      t.block<3, 3>(at, at) = matrix.inverse().transpose();
    }
  }
  return t;
}

/// Adds the turn-on changes of the output offsets, w = W0 + W1 V + C a with a = A0 + A1 V: A0 changes by t_a, W0 by t_w - C t_a.
Calibration with_turn_on(Calibration c) {
  if (!c.turn_on) return c;
  Eigen::MatrixXd by_turn_on = Eigen::MatrixXd::Zero(std::ssize(c.estimated), 6);
  for (std::size_t k = 0; k < c.estimated.size(); ++k) {
    const Coefficient& row = coefficient(c.estimated[k]);
    if (row.term != Term::offset) continue;
    const auto at = static_cast<Eigen::Index>(k);
    if (row.triad == Triad::accel) {
      by_turn_on(at, row.row) = c.turn_on->accel;
    } else {
      by_turn_on(at, 3 + row.row) = c.turn_on->gyro;
      by_turn_on.row(at).head<3>() = -c.turn_on->accel * c.model.g_sensitivity.row(row.row);
    }
  }
  c.covariance += by_turn_on * by_turn_on.transpose();
  return c;
}

/// Leaves out the rows that lower chi2 most, until the rest is probable: row i by z_i^2, z_i = (Q e)_i / sqrt(Q_ii), where Q is the inverse
/// covariance of the remaining rows. `row_of`: coefficient of each row.
std::vector<DifferenceGivenOthers> differing_rows(const Consistency& all, Eigen::VectorXd e, Eigen::MatrixXd Q,
                                                  const std::vector<CoefficientIndex>& row_of) {
  std::vector<DifferenceGivenOthers> out;
  double chi2 = all.chi2;
  for (int freedom = all.degrees_of_freedom; freedom > 0 && chi_square_tail(chi2, freedom) < improbable_differences; --freedom) {
    const Eigen::VectorXd information = Q.diagonal().cwiseMax(0);
    const double none = 1e-9 * information.maxCoeff();  // rounding in rows that are left out
    const Eigen::VectorXd z = (information.array() > none).select((Q * e).array() / information.array().max(none).sqrt(), 0.0);
    Eigen::Index worst = 0;
    if (!(z.cwiseAbs().maxCoeff(&worst) > 0)) break;
    const CoefficientIndex index = row_of[static_cast<std::size_t>(worst)];
    if (std::ranges::find(out, index, &DifferenceGivenOthers::index) == out.end()) out.push_back({index, z(worst)});
    chi2 = std::max(0.0, chi2 - z(worst) * z(worst));
    const Eigen::VectorXd column = Q.col(worst);
    Q -= column * column.transpose() / column(worst);
    Q.row(worst).setZero(), Q.col(worst).setZero(), e(worst) = 0;
  }
  return out;
}

/// Tests consistency. Directions without variance (two identical coefficients) cannot be tested and do not count. `row_of` names differing rows;
/// empty: they are not requested.
Consistency consistency_of(const Eigen::VectorXd& e, const Eigen::MatrixXd& p, const std::vector<CoefficientIndex>& row_of) {
  if (e.size() == 0) return {};
  const Eigen::VectorXd sigma = p.diagonal().cwiseSqrt();
  const SymmetricEigen correlation = symmetric_eigen(sigma.cwiseInverse().asDiagonal() * p * sigma.cwiseInverse().asDiagonal());
  const Eigen::VectorXd whitened = correlation.vectors.transpose() * e.cwiseQuotient(sigma);
  Consistency out;
  Eigen::VectorXd weight = Eigen::VectorXd::Zero(e.size());
  for (Eigen::Index i = 0; i < e.size(); ++i) {
    if (correlation.values(i) < 1e-12 * static_cast<double>(e.size())) continue;  // rounding of the correlations
    weight(i) = 1 / correlation.values(i);
    out.chi2 += whitened(i) * whitened(i) * weight(i);
    ++out.degrees_of_freedom;
  }
  if (out.degrees_of_freedom > 0) out.p_value = chi_square_tail(out.chi2, out.degrees_of_freedom);
  if (!row_of.empty() && out.p_value < improbable_differences)
    out.differing = differing_rows(out, e.cwiseQuotient(sigma), correlation.vectors * weight.asDiagonal() * correlation.vectors.transpose(), row_of);
  return out;
}

bool holds(const std::vector<CoefficientIndex>& indices, CoefficientIndex index) {
  return std::find(indices.begin(), indices.end(), index) != indices.end();
}

/// Returns coefficients estimated in both, or in one if the other is a truth; a variance of zero is not a testable uncertainty.
std::vector<CoefficientIndex> jointly_estimated(const Calibration& a, const Calibration& b, const Eigen::MatrixXd& p) {
  std::vector<CoefficientIndex> joint;
  for (const CoefficientIndex i : coefficient_indices()) {
    const bool in_a = a.estimated.empty() || holds(a.estimated, i), in_b = b.estimated.empty() || holds(b.estimated, i);
    if (in_a && in_b && p(i, i) > 0) joint.push_back(i);
  }
  return joint;
}

/// The difference of every coefficient in the table from a, in SI, and with D for matrices.
struct Differences {
  Eigen::VectorXd b, e, u, user_e, user_u;
};

Differences differences(const Eigen::VectorXd& a, const Eigen::MatrixXd& relative, const Calibration& b, const Eigen::MatrixXd& p) {
  Differences out;
  out.b = values(b.model);
  out.e = out.b - a;
  out.u = p.diagonal().cwiseSqrt();
  out.user_e = relative * out.e;
  out.user_u = (relative * p * relative.transpose()).diagonal().cwiseMax(0).cwiseSqrt();
  return out;
}

/// Returns the largest value of each coefficient's term in any comparison, because its axes share a unit.
Eigen::VectorXd term_sizes(const std::vector<Differences>& all) {
  Eigen::VectorXd size = Eigen::VectorXd::Zero(coefficient_count);
  for (const CoefficientIndex i : coefficient_indices())
    for (const CoefficientIndex k : coefficient_indices())
      if (coefficient(k).triad == coefficient(i).triad && coefficient(k).term == coefficient(i).term)
        for (const auto& d : all) size(i) = std::max({size(i), std::abs(d.user_e(k)), d.user_u(k)});
  return size;
}

/// Values and covariance of a calibration over the whole table.
struct Estimate {
  std::vector<CoefficientIndex> estimated;
  Eigen::VectorXd value;
  Eigen::MatrixXd covariance;
};

/// One estimate of a coefficient minus the most certain estimate of it.
struct Contrast {
  CoefficientIndex coefficient;
  std::size_t estimate, base;
};

std::vector<Contrast> contrasts(const std::vector<Estimate>& estimates, CoefficientIndex coefficient) {
  std::vector<std::size_t> of;
  for (std::size_t k = 0; k < estimates.size(); ++k)
    if (holds(estimates[k].estimated, coefficient)) of.push_back(k);
  const auto variance = [&](std::size_t k) { return estimates[k].covariance(coefficient, coefficient); };
  std::vector<Contrast> out;
  if (of.empty()) return out;
  // A poor base would be common to all contrasts, and rounding would hide the differences of the others.
  const std::size_t base = *std::min_element(of.begin(), of.end(), [&](std::size_t k, std::size_t l) { return variance(k) < variance(l); });
  for (const std::size_t k : of)
    if (k != base && variance(k) > 0) out.push_back({coefficient, k, base});
  return out;
}

/// The contrasts contain all information of the estimates except a common truth, so this is also the chi-square of the estimates about their weighted
/// mean. Errors common to all estimates cancel.
Consistency consistency_of(const std::vector<Estimate>& estimates, const std::vector<Contrast>& all, bool name) {
  const auto n = static_cast<Eigen::Index>(all.size());
  Eigen::VectorXd e(n);
  Eigen::MatrixXd p(n, n);
  for (Eigen::Index i = 0; i < n; ++i) {
    const Contrast& c = all[static_cast<std::size_t>(i)];
    e(i) = estimates[c.estimate].value(c.coefficient) - estimates[c.base].value(c.coefficient);
    for (Eigen::Index j = 0; j < n; ++j) {
      const Contrast& d = all[static_cast<std::size_t>(j)];
      const auto shared = [&](std::size_t k, std::size_t l) { return k == l ? estimates[k].covariance(c.coefficient, d.coefficient) : 0.0; };
      p(i, j) = shared(c.estimate, d.estimate) - shared(c.estimate, d.base) - shared(c.base, d.estimate) + shared(c.base, d.base);
    }
  }
  std::vector<CoefficientIndex> row_of;
  for (const Contrast& c : all) row_of.push_back(c.coefficient);
  return consistency_of(e, p, name ? row_of : std::vector<CoefficientIndex>());
}

}  // namespace

std::optional<double> CoefficientDifference::sigmas() const {
  if (!uncertainty || *uncertainty == 0) return std::nullopt;
  return difference / *uncertainty;
}

std::optional<double> CoefficientDifference::user_sigmas() const {
  if (!user_uncertainty || *user_uncertainty == 0) return std::nullopt;
  return user_difference / *user_uncertainty;
}

Comparison compare(const Calibration& a, const Calibration& b) { return compare(a, std::vector<Calibration>{b}).front(); }

std::vector<Comparison> compare(const Calibration& first, const std::vector<Calibration>& others) {
  const Calibration a = in_accelerometer_frame(with_turn_on(first));
  const Eigen::VectorXd value_a = values(a.model);
  const Eigen::MatrixXd p_a = table_covariance(a), relative = to_relative(a.model);
  std::vector<Comparison> out(others.size());
  std::vector<Calibration> b;
  std::vector<Differences> all;
  for (std::size_t k = 0; k < others.size(); ++k) {
    b.push_back(in_accelerometer_frame(in_gauge_of(first, with_turn_on(others[k]))));
    Eigen::MatrixXd p = p_a + table_covariance(b[k]);
    if (shares_constant(a, b[k])) p = without(p, 2 * common_part(table_constant(a), table_constant(b[k])));
    Eigen::VectorXd from = value_a;
    if (has_lever_arms(a.estimated) && has_lever_arms(b[k].estimated)) {
      const Vector3d moved = mean_point(b[k].model) - mean_point(a.model);
      for (int i = 0; i < 3; ++i) from.segment<3>(first_lever_arm() + 3 * i) += moved;
      p = about_mean_point() * p * about_mean_point().transpose();
      out[k].translation = moved;
    }
    all.push_back(differences(from, relative, b[k], p));
    const std::vector<CoefficientIndex> joint = jointly_estimated(a, b[k], p);
    out[k].consistency = consistency_of(all[k].e(joint), p(joint, joint), joint);
  }
  const Eigen::VectorXd size = term_sizes(all);
  for (const CoefficientIndex i : coefficient_indices()) {
    bool compared = holds(a.estimated, i);
    for (std::size_t k = 0; k < b.size(); ++k) compared = compared || holds(b[k].estimated, i) || all[k].e(i) != 0;
    if (!compared) continue;
    const UserUnit unit = user_unit(coefficient(i), size(i), triad_model(a.model, coefficient(i).triad));
    for (std::size_t k = 0; k < b.size(); ++k) {
      const Differences& d = all[k];
      CoefficientDifference x{i, value_a(i), d.b(i), d.e(i), std::nullopt, d.user_e(i) / unit.size, std::nullopt, unit.name};
      // A starting value on one side is uninformative; a calibration without uncertainties is the truth.
      const bool in_a = a.estimated.empty() || holds(a.estimated, i), in_b = b[k].estimated.empty() || holds(b[k].estimated, i);
      if (in_a && in_b && d.u(i) > 0) {
        x.uncertainty = d.u(i);
        x.user_uncertainty = d.user_u(i) / unit.size;
      }
      out[k].coefficients.push_back(x);
    }
  }
  return out;
}

double significant_sigmas(std::size_t tests) {
  return normal_quantile(1 - 0.5 * table_significance / static_cast<double>(std::max<std::size_t>(tests, 1)));
}

Agreement agreement(const std::vector<Calibration>& calibrations) {
  Agreement out;
  if (calibrations.empty()) return out;
  const Eigen::MatrixXd relative = to_relative(in_accelerometer_frame(calibrations[0]).model);
  std::vector<Calibration> stated;
  for (const auto& c : calibrations)
    if (!c.estimated.empty()) stated.push_back(in_accelerometer_frame(in_gauge_of(calibrations[0], with_turn_on(c))));
  Eigen::MatrixXd common = Eigen::MatrixXd::Zero(coefficient_count, coefficient_count);  // common to all of them
  if (std::ranges::all_of(stated, [&](const Calibration& c) { return shares_constant(c, stated.front()); }))
    for (const Calibration& c : stated) common = &c == &stated.front() ? table_constant(c) : common_part(common, table_constant(c));
  std::vector<Estimate> si, user;
  for (const Calibration& c : stated) {
    const Eigen::MatrixXd t =
        has_lever_arms(c.estimated) ? about_mean_point() : Eigen::MatrixXd(Eigen::MatrixXd::Identity(coefficient_count, coefficient_count));
    si.push_back({c.estimated, t * values(c.model), t * without(table_covariance(c), common) * t.transpose()});
    user.push_back({c.estimated, relative * si.back().value, relative * si.back().covariance * relative.transpose()});
  }
  out.calibrations = static_cast<int>(si.size());
  std::vector<Contrast> all;
  for (const CoefficientIndex i : coefficient_indices()) {
    const std::vector<Contrast> of_i = contrasts(si, i);
    all.insert(all.end(), of_i.begin(), of_i.end());
    if (!of_i.empty()) out.coefficients.push_back({i, consistency_of(user, contrasts(user, i), false)});
  }
  out.consistency = consistency_of(si, all, true);
  for (auto& c : out.coefficients) c.differs = c.consistency.p_value < table_significance / static_cast<double>(out.coefficients.size());
  return out;
}

}  // namespace imulab
