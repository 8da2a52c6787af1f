// Several calibrated IMUs of one body, estimated jointly: the errors that each calibration may have, with its covariance P, are the prior of the
// body's fit. The motion gives efficient estimates: their covariance V with any other unbiased estimate from the same data is their own (Hausman,
// Specification tests in econometrics, Econometrica 46, 1978). So calibrations of the same records contain V, too; the motion counts with 4 V, by
// which uncertainties are at most 5 % too small, where noise is all that a calibration is uncertain by, and too large where V is below P / 3.
#include "imulab/core/decomposition.hpp"
#include "imulab/core/statistics.hpp"
#include "imulab/error.hpp"
#include "imulab/estimate/extrinsics/body_fit.hpp"
#include "imulab/estimate/kernel/findings.hpp"
#include "imulab/extrinsics.hpp"
#include "imulab/model/finding_table.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>

namespace imulab {

using namespace extrinsics;

namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

Index own_column(std::size_t imu) { return imu == 0 ? 0 : MotionFit::mount_column(imu) - own_columns; }

/// What an error of g, which all IMUs have in common and no motion shows, does to the coefficients.
VectorXd by_gravity(const Calibration& c) {
  VectorXd out = VectorXd::Zero(std::ssize(c.estimated));
  for (const UncertaintySource& source : c.quality.sources) {
    if (source.name != "gravity") continue;
    for (std::size_t k = 0; k < c.estimated.size(); ++k) {
      const Coefficient& of = coefficient(c.estimated[k]);
      const double sign = of.triad == Triad::accel ? 1 : of.term == Term::g_sensitivity ? -1 : 0;
      out[static_cast<Index>(k)] = sign * source.relative * coefficient_value(c.model, c.estimated[k]);
    }
  }
  return out;
}

/// The errors of all IMUs and mountings, before the motion and after it.
struct BodyErrors {
  MatrixXd before;  ///< covariance; of the IMUs' own errors alone
  VectorXd mean;
  MatrixXd covariance;
};
BodyErrors errors_of(const BodyFit& body, bool own_seconds) {
  const MatrixXd& enlarged = body.constants.covariance;
  const VectorXd smaller = body.constants.enlargement.cwiseInverse();
  MatrixXd before = MatrixXd::Zero(enlarged.rows(), enlarged.cols()), prior = before;
  VectorXd at = VectorXd::Zero(enlarged.rows());  // the end of the fit
  VectorXd clocks = at;                           // what an IMU's gyros seem to be off by, where it and its calibration count seconds of its own
  double scatter = 1;                             // of the seconds, beyond the noise
  for (std::size_t k = 0; k < body.fit->states().size(); ++k) {
    const Index own = own_column(k);
    before.block<own_columns, own_columns>(own, own) = body.covariance_before[k];
    prior.block<own_columns, own_columns>(own, own) = Cholesky(body.covariance_before[k]).inverse();
    at.segment<own_columns>(own) = body.fit->states()[k].errors;
    if (own_seconds)
      for (int i = 0; i < 3; ++i) clocks[own + gyro_matrix + 4 * i] = -body.fit->states()[k].drift;
    scatter = std::max(scatter, body.constants.enlargement.segment<own_columns>(own).maxCoeff());
  }
  const double counted = 1 / (4 * scatter * scatter);  // of the motion's information
  const MatrixXd motion = Cholesky(smaller.asDiagonal() * enlarged * smaller.asDiagonal()).inverse() - prior;
  const MatrixXd covariance = Cholesky(prior + counted * motion).inverse();
  // At the end of the fit the slopes of both cancel; that of the motion counts less here, and the prior is about the clocks' share.
  return {before, at + covariance * ((counted - 1) * (prior * at) + prior * clocks) - clocks, covariance};
}

/// How far the calibrations are from agreeing in the motion, in the directions that it shows.
struct Disagreement {
  double chi2 = 0, directions = 0;

  double chance() const { return directions > 0 ? chi_square_tail(chi2, directions) : 1; }
};
Disagreement disagreement_of(const BodyErrors& errors, std::size_t imus) {
  std::vector<Index> own;
  for (std::size_t k = 0; k < imus; ++k)
    for (Index i = 0; i < own_columns; ++i) own.push_back(own_column(k) + i);
  const Cholesky prior(errors.before(own, own));
  const MatrixXd half = prior.solve_lower(MatrixXd(errors.covariance(own, own)));
  const SymmetricEigen kept = symmetric_eigen(prior.solve_lower(MatrixXd(half.transpose())));
  const VectorXd along = kept.vectors.transpose() * prior.solve_lower(VectorXd(errors.mean(own)));
  constexpr double least_shown = 0.1;  // of the variance before the motion
  Disagreement out;
  for (Index i = 0; i < along.size(); ++i)
    if (const double shown = 1 - kept.values[i]; shown > least_shown) out.chi2 += along[i] * along[i] / shown, ++out.directions;
  return out;
}

/// Changes the coefficients by what is known of an IMU's errors after the motion; their part `common` of the covariance stays.
void take(const BodyErrors& errors, std::size_t imu, const VectorXd& common, Calibration& c) {
  const Index own = own_column(imu);
  const auto of_own = [&](const MatrixXd& all) { return MatrixXd(all.block<own_columns, own_columns>(own, own)); };
  const MatrixXd before = of_own(errors.before), information = Cholesky(of_own(errors.covariance)).inverse();
  const MatrixXd added = information - Cholesky(before).inverse();
  const MatrixXd alone = c.covariance - common * common.transpose(), with_errors = alone * errors_by_coefficients(c, false).transpose();
  const MatrixXd gain = with_errors * inverse_of(MatrixXd::Identity(own_columns, own_columns) + added * before);
  const VectorXd change = gain * (information * errors.mean.segment<own_columns>(own));
  for (std::size_t k = 0; k < c.estimated.size(); ++k)
    set_coefficient(c.model, c.estimated[k], coefficient_value(c.model, c.estimated[k]) - change[static_cast<Index>(k)]);
  const MatrixXd less = gain * added * with_errors.transpose();
  c.covariance -= 0.5 * (less + less.transpose());
  if (c.constant_covariance.size() > 0) c.constant_covariance = limited_part(c.constant_covariance, c.covariance);
}

/// Whether two IMUs may be one sensor in other axes. Of noise that both have, the motion takes half away: 0.7 of its size is left.
bool has_same_noise(const BodyFit& body, const std::vector<BodyImu>& imus) {
  constexpr double clear = 0.85;
  int same = 0;
  for (std::size_t k = 0; k < imus.size(); ++k) {
    const auto& noise = imus[k].calibration->rest_noise;
    const BodyResidual& left = body.residuals[k];
    if (!noise || left.samples == 0) continue;
    const double root_interval = std::sqrt(body.used / static_cast<double>(left.samples));
    const auto size_of = [&](const Vector3d& density) { return density.norm() / std::sqrt(3.) / root_interval; };
    if (left.gyro < clear * size_of(noise->gyro) && left.accel < clear * size_of(noise->accel)) ++same;
  }
  return same >= 2;
}

std::string others_than(std::size_t imu, const std::vector<BodyImu>& imus) {
  std::vector<std::string> names;
  for (std::size_t k = 0; k < imus.size(); ++k)
    if (k != imu) names.push_back(imus[k].name);
  return fmt::format("{}", fmt::join(names, ", "));
}

}  // namespace

std::vector<Calibration> calibrate_jointly(std::vector<BodyImu> imus, const std::function<void(double)>& progress) {
  const auto counts_own_seconds = [](const BodyImu& imu) {
    return !imu.calibration || !imu.calibration->clock || imu.calibration->clock->seconds == "own";
  };
  const bool own_seconds = std::ranges::any_of(imus, counts_own_seconds);
  if (own_seconds && !std::ranges::all_of(imus, counts_own_seconds))
    throw Unsupported("some calibrations count true seconds, and others those of their recordings");
  std::vector<VectorXd> gravity;
  std::vector<Calibration> out;
  for (BodyImu& imu : imus) {
    if (!imu.calibration || imu.calibration->quality.verdict != Verdict::good)
      throw Error(fmt::format("{}: has no good calibration; expected one, for a joint estimate", imu.name));
    out.push_back(*imu.calibration);
    gravity.push_back(by_gravity(*imu.calibration));
    imu.calibration->covariance -= gravity.back() * gravity.back().transpose();
  }
  Findings findings;
  const BodyFit body = fit_body(imus, {.progress = progress}, findings);
  for (std::size_t k = 1; k < imus.size(); ++k) body.judge_agreement(k, imus, body.fit->rates(k), findings);
  if (has_same_noise(body, imus)) throw Unsupported("the motion explains their noise: one sensor in different axes, or a body that vibrates");
  if (!body.converged) findings.add<Code::not_converged>();
  if (findings.doubtful()) throw Unsupported(fmt::format("{}", fmt::join(findings.reasons(), "; ")));

  const BodyErrors errors = errors_of(body, own_seconds);
  const Disagreement apart = disagreement_of(errors, imus.size());
  constexpr double least_chance = 1e-4;
  for (std::size_t k = 0; k < imus.size(); ++k) {
    Quality& quality = out[k].quality;
    if (apart.chance() < least_chance) {
      quality.findings.add<Code::imus_contradict>(fmt::format("{} and {}", imus.front().name, others_than(0, imus)),
                                                  std::sqrt(apart.chi2 / apart.directions), apart.chance());
      kernel::judge(quality);
      continue;
    }
    const Eigen::ArrayXd alone = out[k].covariance.diagonal();
    take(errors, k, gravity[k], out[k]);
    const Eigen::ArrayXd ratios = (out[k].covariance.diagonal().array() / alone).sqrt();
    quality.findings.add<Code::joint_estimate>(others_than(k, imus), ratios.minCoeff(), ratios.maxCoeff());
  }
  return out;
}

}  // namespace imulab
