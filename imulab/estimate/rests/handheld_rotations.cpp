// The rotations between the rests of a handheld calibration: which ones are usable, and their integrals of the gyros.
#include "imulab/core/rotation.hpp"
#include "imulab/error.hpp"
#include "imulab/estimate/rests/handheld_problem.hpp"
#include "imulab/recording/gyro_saturation.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>

namespace imulab::rests {

using Eigen::Index;

void HandheldProblem::add_turns(const std::vector<DeclaredTurn>& turns) {
  if (turns.empty()) return;
  const double scale = recording_->gyro_unit == "count" ? 0.5 : 0.2;  // the scale of counts comes from the motion; otherwise the usual tolerance
  integrate();
  for (std::size_t k = 0; k < links_.size(); ++k) {
    const auto between = [&](const DeclaredTurn& turn) { return rests_[k].mid_s < turn.middle() && turn.middle() < rests_[k + 1].mid_s; };
    if (!linked(k) || std::count_if(turns.begin(), turns.end(), between) != 1) continue;
    const DeclaredTurn& turn = *std::find_if(turns.begin(), turns.end(), between);
    if (turn.moves_on) continue;
    links_[k].turn = turn;
    if (const std::string wrong = contradiction(turn, swept(links_[k]), scale); !wrong.empty())
      throw Error(fmt::format("{}: {}; expected the turn as it was done", recording_->name, wrong));
  }
}

void HandheldProblem::relink() {
  const GyroSaturation saturation(*recording_);
  for (std::size_t k = 0; k < links_.size(); ++k) {
    const std::size_t begin = rests_[k].range.end, end = rests_[k + 1].range.begin;
    // A gap before sample `end` also means missing motion. Adjacent rests have no rotation between them.
    links_[k].usable = !rests_alone_ && !links_[k].refused && recording_->gaps_in({begin, end + 1}) == 0 && saturation.in({begin, end}) == 0;
  }
  stretch_.assign(rests_.size(), 0);
  for (std::size_t k = 1; k < rests_.size(); ++k) stretch_[k] = stretch_[k - 1] + (linked(k - 1) ? 0 : 1);
  earth_horizontal_.assign(rests_.empty() ? 0 : stretch_.back() + 1, Eigen::Vector2d::Zero());
}

std::size_t HandheldProblem::rotations() const {
  return static_cast<std::size_t>(std::count_if(links_.begin(), links_.end(), [](const Link& link) { return link.usable; }));
}

std::size_t HandheldProblem::turns(bool refused) const {
  return static_cast<std::size_t>(
      std::count_if(links_.begin(), links_.end(), [&](const Link& link) { return link.turn && (refused ? link.refused : link.usable); }));
}

Vector3d HandheldProblem::swept(const Link& link) const { return model_.gyro.offset * link.now.duration_s + model_.gyro.matrix * link.now.reading; }

IntegratedRotation HandheldProblem::integrated(const Recording& recording, Range range, const Vector3d& sigma) const {
  RateEffects effects;
  for (const EffectColumn& c : effects_.columns())
    if (c.effect->changes(Triad::gyro)) effects.columns.push_back(c);
  if (sweep_) effects.values = large_rate_effects();
  effects.state = [&](std::size_t sample) { return &recording == recording_ ? recorded_->at(sample) : recorded_->at(rests_.back().range.begin); };
  return integrate_rotation(recording, range, model_, scaling_, sigma, effects);
}

/// Thermal terms change the rate by up to a degree per second, and a rotation by an angle whose square counts. Other effects are small.
Eigen::VectorXd HandheldProblem::large_rate_effects() const {
  std::vector<double> values;
  for (Index k = 0; k < effects_.size(); ++k)
    if (const Effect& effect = *effects_.columns()[static_cast<std::size_t>(k)].effect; effect.changes(Triad::gyro))
      values.push_back((effect.needs & Effect::by_sweep) != 0 ? effects_.value()[k] : 0);
  return Eigen::Map<const Eigen::VectorXd>(values.data(), std::ssize(values));
}

Matrix3d HandheldProblem::corrected(const IntegratedRotation& rotation, const Vector3d& angle) const {
  Vector3d all = angle;
  Index gyro = 0;
  for (Index k = 0; k < effects_.size(); ++k)
    if (effects_.columns()[static_cast<std::size_t>(k)].effect->changes(Triad::gyro)) {
      all -= (effects_.value()[k] - rotation.effects[gyro]) * rotation.by_effect.col(gyro);
      ++gyro;
    }
  return rotation_exp(all) * rotation.C;
}

void HandheldProblem::integrate() {
  for (std::size_t k = 0; k < links_.size(); ++k) {
    Link& link = links_[k];
    if (!link.usable) continue;
    if (link.at) {  // a small step uses the derivatives: its square is below 1 % of the noise, or 1e-8 rad
      const double small = std::max(1e-8, 0.01 * std::sqrt(link.rotation.covariance.trace() / 3));
      const Vector3d angle = link.rotation.change(link.at->gyro, link.at->g_sensitivity, model_.gyro, model_.g_sensitivity);
      const Vector3d by_temperature = sweep_ ? Vector3d(link.rotation.by_effect * (large_rate_effects() - link.rotation.effects)) : Vector3d::Zero();
      if (angle.squaredNorm() < small && by_temperature.squaredNorm() < small &&
          (model_.accel.matrix - link.at->accel.matrix).norm() + (model_.accel.offset - link.at->accel.offset).norm() < 1e-3 * gravity_) {
        link.now.C = corrected(link.rotation, angle);
        continue;
      }
    }
    link.rotation = link.now = integrated(*recording_, turn_between(*recording_, rests_[k].range, rests_[k + 1].range, stillness_), turning_sigma_);
    link.now.C = corrected(link.rotation, Vector3d::Zero());
    link.at = model_;
  }
}

}  // namespace imulab::rests
