#include "imulab/estimate/kernel/prior.hpp"

#include "imulab/grade.hpp"
#include "imulab/model/effects.hpp"
#include "imulab/units.hpp"

#include <algorithm>
#include <cmath>
#include <string_view>

namespace imulab::kernel {

namespace {

/// Returns the log probability of each observed quantity under a grade. Sizes are within a factor of 5 of the grade's. One offset in ten was removed
/// by the manufacturer or firmware and may be arbitrarily small.
Eigen::Vector4d log_probabilities(const Grade& of, const SeenOfUnit& seen) {
  const auto within = [](double value, double usual) {
    const double spread = std::log(5);
    return value > 0 ? std::exp(-0.5 * std::pow(std::log(value / usual) / spread, 2)) : 0;
  };
  const auto noise = [&](double value, double usual) { return value > 0 ? std::log(within(value, usual)) : 0; };
  const auto offset = [&](double value, double usual) {
    constexpr double taken_out = 0.1;
    return std::log((1 - taken_out) * within(value, usual) + (value < usual ? taken_out : 0));
  };
  return {noise(seen.accel_noise, of.accel_noise.N), noise(seen.gyro_noise, of.gyro_noise.N), offset(seen.accel_offset, of.accel_bias),
          offset(seen.gyro_offset, of.gyro_bias)};
}

/// Returns true if another grade is more probable even without the quantity that favors it most: a single quantity may be a fault of the data.
bool contradicts(const SeenOfUnit& seen, std::string_view declared) {
  constexpr double clearly = 1;  // difference of the logarithm
  return std::ranges::any_of(graded_names(), [&](std::string_view other) {
    const Eigen::Vector4d for_other = log_probabilities(grade(other), seen) - log_probabilities(grade(declared), seen);
    return for_other.sum() - std::max(0.0, for_other.maxCoeff()) > clearly;
  });
}

/// Not inlined: valgrind reports a choice between two optional values as a read of uninitialized memory.
[[gnu::noinline]] double stated(const std::optional<double>& declared, double usual) { return declared.value_or(usual); }

}  // namespace

SeenOfUnit seen_of_axes(const Vector3d& accel_noise, const Vector3d& gyro_noise, const Vector3d& accel_offset, const Vector3d& gyro_offset) {
  const auto rms = [](const Vector3d& v) { return v.norm() / std::sqrt(3.0); };
  return {rms(accel_noise), rms(gyro_noise), rms(accel_offset), rms(gyro_offset)};
}

Vector3d output_sigma(const Matrix3d& matrix, const Vector3d& raw) { return (matrix.cwiseAbs2() * raw.cwiseAbs2()).cwiseSqrt(); }

const LikelyGrade& likeliest(const std::vector<LikelyGrade>& grades) { return *std::ranges::max_element(grades, {}, &LikelyGrade::log_weight); }

std::vector<LikelyGrade> likely_grades(const ImuDeclaration& imu, const SeenOfUnit& seen) {
  if (imu.grade && !contradicts(seen, *imu.grade)) return {{*imu.grade}};
  SeenOfUnit known = seen;
  if (known.accel_noise == 0) known.accel_noise = imu.accel_noise_density.value_or(0);
  if (known.gyro_noise == 0) known.gyro_noise = imu.gyro_noise_density.value_or(0);
  std::vector<LikelyGrade> out;
  for (const std::string_view name : graded_names()) out.push_back({std::string(name), log_probabilities(grade(name), known).sum()});
  return out;
}

ImuDeclaration of_likeliest_grade(ImuDeclaration imu, const SeenOfUnit& seen) {
  imu.grade = likeliest(likely_grades(imu, seen)).name;
  return imu;
}

double* size_of(PriorSizes& sizes, const Coefficient& c) {
  TriadPrior& triad = c.triad == Triad::accel ? sizes.accel : sizes.gyro;
  switch (c.term) {
    case Term::quadratic:
      return &triad.quadratic;
    case Term::cubic:
      return &triad.cubic;
    case Term::g_sensitivity:
      return &sizes.g_sensitivity;
    case Term::lever_arm:
      return &sizes.lever_arm;
    default:
      return nullptr;
  }
}

bool is_declared(const TermSigmas& declared, const Coefficient& c) {
  const bool accel = c.triad == Triad::accel;
  switch (c.term) {
    case Term::quadratic:
      return (accel ? declared.accel_quadratic : declared.gyro_quadratic).has_value();
    case Term::cubic:
      return (accel ? declared.accel_cubic : declared.gyro_cubic).has_value();
    case Term::g_sensitivity:
      return declared.g_sensitivity.has_value();
    case Term::lever_arm:
      return declared.lever_arm.has_value();
    default:
      return false;
  }
}

PriorSizes optional_priors(const ImuDeclaration& imu) {
  const TermSizes usual = grade(likeliest(likely_grades(imu, {})).name).terms;
  const TermSigmas& declared = imu.term_sigmas;
  constexpr double lever_arm = 0.05;  // [m], of a unit held in a hand
  PriorSizes sizes;
  sizes.accel.quadratic = stated(declared.accel_quadratic, usual.accel_quadratic);
  sizes.accel.cubic = stated(declared.accel_cubic, usual.accel_cubic);
  sizes.gyro.quadratic = stated(declared.gyro_quadratic, usual.gyro_quadratic);
  sizes.gyro.cubic = stated(declared.gyro_cubic, usual.gyro_cubic);
  sizes.g_sensitivity = stated(declared.g_sensitivity, usual.g_sensitivity);
  sizes.lever_arm = stated(declared.lever_arm, lever_arm);
  return sizes;
}

ImuDeclaration of_size(const ImuDeclaration& imu, double factor) {
  ImuDeclaration out = imu;
  const std::string grade = likeliest(likely_grades(imu, {})).name;
  for (const Effect& e : effects())
    if ((e.needs & ~(Effect::of_accel | Effect::of_gyro | Effect::by_thermometer)) == 0)
      out.effect_sigmas[std::string(e.name)] = factor * effect_sigma(e, imu.effect_sigmas, grade);
  const PriorSizes sizes = optional_priors(imu);
  TermSigmas& terms = out.term_sigmas;
  terms.accel_quadratic = factor * sizes.accel.quadratic, terms.accel_cubic = factor * sizes.accel.cubic;
  terms.gyro_quadratic = factor * sizes.gyro.quadratic, terms.gyro_cubic = factor * sizes.gyro.cubic;
  terms.g_sensitivity = factor * sizes.g_sensitivity;
  return out;
}

std::optional<TurnOn> declared_turn_on(const ImuDeclaration& imu, std::size_t recordings) {
  const NoiseModels noise = declared_terms(imu);
  const auto sigma = [&](const char* effect, const Spread& turn_on) {
    const auto at = imu.effect_sigmas.find(effect);
    const double one = at != imu.effect_sigmas.end() ? at->second : turn_on.fixed ? 0 : turn_on.value;
    return one / std::sqrt(static_cast<double>(recordings));
  };
  const TurnOn out{.accel = sigma("accel.turn_on", noise.accel.turn_on), .gyro = sigma("gyro.turn_on", noise.gyro.turn_on)};
  return out == TurnOn{} ? std::nullopt : std::optional(out);
}

}  // namespace imulab::kernel
