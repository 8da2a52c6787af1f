#include "imulab/estimate/kernel/effects.hpp"

#include "imulab/grade.hpp"

namespace imulab::kernel {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

namespace {

/// Returns the owner of the factors that determine the size of an effect.
SizedGroup::Of owner_of(const Effect& effect, const EffectSizes& sizes) {
  if (sizes.declared.contains(effect.name)) return SizedGroup::Of::declared;
  constexpr unsigned of_rig =
      Effect::by_mount | Effect::by_centrifuge | Effect::by_latitude | Effect::by_thermal | Effect::by_north | Effect::by_change;
  if ((effect.needs & of_rig) != 0) return SizedGroup::Of::rig;
  const bool accel = effect.changes(Triad::accel), gyro = effect.changes(Triad::gyro);
  return accel && gyro ? SizedGroup::Of::unit : accel ? SizedGroup::Of::accel : SizedGroup::Of::gyro;
}

}  // namespace

PriorSizes Effects::terms_of(ImuDeclaration imu, const std::string& grade) {
  imu.grade = grade;
  return optional_priors(imu);
}

double EffectSizes::of(const Effect& effect) const { return effect_sigma(effect, declared, likeliest(grades).name); }

EffectSizes effect_sizes(const Session& session, const SeenOfUnit& seen) {
  EffectSizes sizes{session.imu.effect_sigmas, likely_grades(session.imu, seen), session.imu};
  const auto declare = [&](const char* name, double sigma) {
    if (sigma > 0) sizes.declared.try_emplace(name, sigma);
  };
  const NoiseModels noise = declared_terms(session.imu);
  if (!noise.accel.turn_on.fixed) declare("accel.turn_on", noise.accel.turn_on.value);
  if (!noise.gyro.turn_on.fixed) declare("gyro.turn_on", noise.gyro.turn_on.value);
  if (session.site.latitude_sigma) sizes.declared.try_emplace("site.latitude", *session.site.latitude_sigma);  // 0: exactly known
  return sizes;
}

Effects::Effects(const EffectSizes& sizes, const EffectSetting& setting) : imu_(sizes.imu), terms_(terms_of(imu_, likeliest(sizes.grades).name)) {
  for (const LikelyGrade& g : sizes.grades) hypotheses_.push_back({g.name, g.log_weight});
  for (const Effect& effect : imulab::effects()) {
    const int columns = effect.columns(setting);
    const double sigma = sizes.of(effect);
    if (columns == 0 || !(sigma > 0)) continue;
    groups_.push_back({{size(), columns, owner_of(effect, sizes)}, &effect, sigma});
    for (SizeHypothesis& h : hypotheses_) h.sizes.push_back(effect_sigma(effect, sizes.declared, h.grade));
    for (int k = 0; k < columns; ++k) columns_.push_back({&effect, k});
  }
  value_ = VectorXd::Zero(size());
}

void Effects::add_to(Parameters& parameters) const {
  const Index first = parameters.size() - size();
  parameters.offset.tail(size()) = -value_;
  for (const EffectGroup& g : groups_) parameters.sigma.segment(first + g.first, g.size).setConstant(g.sigma);
}

VectorXd Effects::sigma() const {
  VectorXd out(size());
  for (const EffectGroup& g : groups_) out.segment(g.first, g.size).setConstant(g.sigma);
  return out;
}

double Effects::degrees_of_freedom(const MatrixXd& covariance) const {
  return (1 - covariance.diagonal().tail(size()).array() / sigma().array().square()).sum();
}

OutputChange Effects::output(const EffectState& state) const {
  OutputChange sum;
  for (Index k = 0; k < size(); ++k) {
    if (value_[k] == 0) continue;
    const OutputChange change = columns_[static_cast<std::size_t>(k)].at(state);
    sum.force += value_[k] * change.force;
    sum.rate += value_[k] * change.rate;
  }
  return sum;
}

void Effects::add_derivatives(MatrixXd& jacobian, Index row, Triad triad, const MatrixXd& by_output, const EffectState& state) const {
  const Index first = jacobian.cols() - size();
  for (Index k = 0; k < size(); ++k) {
    const EffectColumn& c = columns_[static_cast<std::size_t>(k)];
    if (!c.effect->changes(triad)) continue;
    const OutputChange change = c.at(state);
    jacobian.col(first + k).segment(row, by_output.rows()) -= by_output * (triad == Triad::accel ? change.force : change.rate);
  }
}

}  // namespace imulab::kernel
