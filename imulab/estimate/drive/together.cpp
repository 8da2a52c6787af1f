#include "imulab/estimate/drive/together.hpp"

#include "imulab/estimate/drive/unmodeled.hpp"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>

#include <algorithm>
#include <cmath>
#include <cstddef>

namespace imulab::drive {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

bool of_unit(const AidedConstant& c) { return c.name.starts_with("accel.") || c.name.starts_with("gyro.") || is_effect_of_unit(c.name); }
bool of_aid(const AidedConstant& c) { return !of_unit(c) && !is_effect(c.name); }

namespace {

/// The information of data about the unit's constants in units of their priors: exponent -(x.N x)/2 + g.x.
struct Said {
  MatrixXd N;
  VectorXd g;
};

std::vector<Index> sensor_places(const AidedNavigation& n) {
  std::vector<Index> out;
  for (std::size_t k = 0; k < n.constants.size(); ++k)
    if (of_unit(n.constants[k])) out.push_back(static_cast<Index>(k));
  return out;
}

MatrixXd inverse_of(const MatrixXd& positive) { return positive.llt().solve(MatrixXd::Identity(positive.rows(), positive.cols())); }

Said said_by(const Drive& drive) {
  const std::vector<Index> places = sensor_places(drive.navigation);
  const Index n = std::ssize(places);
  VectorXd prior(n), x(n), change = VectorXd::Zero(n);
  for (Index k = 0; k < n; ++k) {
    const AidedConstant& c = drive.navigation.constants[static_cast<std::size_t>(places[static_cast<std::size_t>(k)])];
    prior[k] = c.prior, x[k] = c.value / c.prior;
    if (c.name.starts_with("gyro.offset")) change[k] = std::sqrt(drive.gyro_change) / c.prior;
    if (c.name.starts_with("accel.offset")) change[k] = std::sqrt(drive.accel_change) / c.prior;
  }
  const VectorXd scale = prior.cwiseInverse();
  const MatrixXd information = inverse_of(scale.asDiagonal() * drive.navigation.constants_covariance(places, places) * scale.asDiagonal());
  Said out{information - MatrixXd::Identity(n, n), information * x};
  const MatrixXd S = change.asDiagonal(), NS = out.N * S;
  const MatrixXd gain = NS * inverse_of(MatrixXd::Identity(n, n) + S * NS);
  out.g -= gain * (S * out.g);
  out.N -= gain * NS.transpose();
  return out;
}

/// Returns the inverse variance of the unit's prior relative to a drive's.
VectorXd unit_information(const Drive& drive) {
  const std::vector<Index> places = sensor_places(drive.navigation);
  VectorXd out = VectorXd::Ones(std::ssize(places));
  for (Index k = 0; k < out.size(); ++k) {
    const AidedConstant& c = drive.navigation.constants[static_cast<std::size_t>(places[static_cast<std::size_t>(k)])];
    const double turn_on = c.name.starts_with("gyro.offset") ? drive.gyro_turn_on : c.name.starts_with("accel.offset") ? drive.accel_turn_on : 0;
    constexpr double least = 0.01;  // smallest fraction of the prior: the remainder is turn-on
    out[k] = 1 / std::max(least, 1 - turn_on / (c.prior * c.prior));
  }
  return out;
}

/// Compares the state with and without `part` of `all` (which includes the prior).
Contradiction contradiction_of(const Drive& drive, const Said& all, const Said& part) {
  const MatrixXd with = inverse_of(all.N), without = inverse_of(all.N - part.N);
  const VectorXd step = with * all.g - without * (all.g - part.g);
  const Eigen::LLT<MatrixXd> root(without);
  const VectorXd white = root.matrixL().solve(step);
  const MatrixXd half = root.matrixL().solve(with), learned = MatrixXd::Identity(with.rows(), with.cols()) - root.matrixL().solve(half.transpose());
  const Eigen::SelfAdjointEigenSolver<MatrixXd> axes((learned + learned.transpose()) / 2);
  Contradiction out{.drive = drive.name, .worst = {}};
  constexpr double some = 0.05;  // fraction of the variance: less is hardly informative and subject to rounding
  for (Index k = 0; k < white.size(); ++k)
    if (const double part_learned = axes.eigenvalues()[k]; part_learned > some)
      out.chi2 += std::pow(axes.eigenvectors().col(k).dot(white), 2) / part_learned, ++out.freedom;
  const std::vector<Index> places = sensor_places(drive.navigation);
  for (Index k = 0; k < step.size(); ++k) {
    const double variance = without(k, k) - with(k, k);
    if (!(variance > some * without(k, k)) || std::abs(step[k]) < out.sigmas * std::sqrt(variance)) continue;
    out.sigmas = std::abs(step[k]) / std::sqrt(variance);
    out.worst = drive.navigation.constants[static_cast<std::size_t>(places[static_cast<std::size_t>(k)])].name;
  }
  return out;
}

/// Appends a drive's constants of aids to those of the unit.
void append_aids(const Drive& drive, AidedNavigation& out) {
  for (std::size_t k = 0; k < drive.navigation.constants.size(); ++k) {
    if (!of_aid(drive.navigation.constants[k])) continue;
    AidedConstant& c = out.constants.emplace_back(drive.navigation.constants[k]);
    c.name = drive.name + ": " + c.name;
    const Index at = out.constants_covariance.rows();
    out.constants_covariance.conservativeResizeLike(MatrixXd::Zero(at + 1, at + 1));
    out.constants_covariance(at, at) = c.sigma * c.sigma;
  }
}

}  // namespace

Together together(const std::vector<Drive>& drives) {
  const AidedNavigation& first = drives.front().navigation;
  if (drives.size() == 1) return {first, {}};
  std::vector<Said> parts;
  Said all;
  all.N = unit_information(drives.front()).asDiagonal(), all.g = VectorXd::Zero(all.N.rows());
  for (const Drive& drive : drives) {
    parts.push_back(said_by(drive));
    all.N += parts.back().N, all.g += parts.back().g;
  }
  Together out;
  const MatrixXd covariance = inverse_of(all.N);
  const VectorXd x = covariance * all.g;
  VectorXd prior(x.size());
  for (const Index place : sensor_places(first)) {
    AidedConstant& c = out.navigation.constants.emplace_back(first.constants[static_cast<std::size_t>(place)]);
    const Index k = std::ssize(out.navigation.constants) - 1;
    prior[k] = c.prior;
    c.value = prior[k] * x[k], c.sigma = prior[k] * std::sqrt(covariance(k, k));
  }
  out.navigation.constants_covariance = prior.asDiagonal() * covariance * prior.asDiagonal();
  for (std::size_t k = 0; k < drives.size(); ++k) {
    append_aids(drives[k], out.navigation);
    out.contradictions.push_back(contradiction_of(drives[k], all, parts[k]));
  }
  return out;
}

}  // namespace imulab::drive
