// Sizes of effects, and the play of hysteresis.
#include "imulab/grade.hpp"
#include "imulab/model/effects.hpp"

#include <algorithm>
#include <cmath>

namespace imulab {

namespace {

constexpr std::array<std::string_view, 4> graded{"strategic", "navigation", "tactical", "mems"};

/// The place of a grade among those of the priors; mems-30g is mems.
std::size_t place_of(std::string_view name) {
  const auto at = std::find(graded.begin(), graded.end(), name);
  return std::min<std::size_t>(static_cast<std::size_t>(at - graded.begin()), graded.size() - 1);
}

}  // namespace

double effect_sigma(const Effect& effect, const EffectSigmas& declared, std::string_view grade_name, double accel_offset) {
  if (const auto at = declared.find(effect.name); at != declared.end()) return at->second;
  std::size_t place = 0;
  if (!grade_name.empty()) {
    place = place_of(grade_name);
  } else {
    const auto distance = [&](std::string_view name) { return std::abs(std::log(std::max(accel_offset, 1e-9) / grade(name).accel_bias)); };
    for (std::size_t k = 1; k < graded.size(); ++k)
      if (distance(graded[k]) < distance(graded[place])) place = k;
  }
  return effect.prior[place] * effect.unit;
}

Vector3d PlayOperator::operator()(const Vector3d& force) {
  if (!middle_) middle_ = force;
  middle_ = middle_->cwiseMax(force - Vector3d::Constant(half_)).cwiseMin(force + Vector3d::Constant(half_));
  return (force - *middle_) / half_;
}

}  // namespace imulab
