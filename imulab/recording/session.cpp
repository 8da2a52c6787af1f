#include "imulab/session.hpp"

#include "imulab/core/stamp_text.hpp"
#include "imulab/earth.hpp"
#include "imulab/error.hpp"
#include "imulab/grade.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

namespace imulab {

double Site::gravity() const {
  if (given_gravity) return *given_gravity;
  if (latitude) return normal_gravity(*latitude, height.value_or(0.0));
  throw Error("neither gravity nor latitude of the site is given; gravity sets the accelerometers' scale; expected one of them");
}

double Site::gravity_sigma() const {
  if (given_gravity_sigma) return *given_gravity_sigma;
  if (given_gravity) return 1e-5;
  const double normal = height ? 3e-4 : 3e-3;
  if (!latitude || !latitude_sigma) return normal;
  // It grows from the equator to the poles: most different at an end of the range, or at the equator inside it.
  const double north = *latitude + *latitude_sigma, south = *latitude - *latitude_sigma, pole = std::numbers::pi / 2;
  double most = 0;
  for (const double at : {std::clamp(south, -pole, pole), std::clamp(north, -pole, pole), std::clamp(0.0, south, north)})
    most = std::max(most, std::abs(normal_gravity(at, 0) - normal_gravity(*latitude, 0)));
  return std::hypot(normal, most);
}

std::string_view to_string(NoiseTerms terms) { return terms == NoiseTerms::white ? "white" : "full"; }

std::string_view to_string(Extent extent) { return extent == Extent::all ? "all" : "steps"; }

std::string_view to_string(Stamps stamps) { return stamps == Stamps::automatic ? "automatic" : stamps == Stamps::recorded ? "recorded" : "uniform"; }
namespace {
constexpr std::array<std::string_view, 4> vertical_channels{"free", "fixed", "aided", "held"};
}

std::string_view to_string(VerticalChannel vertical) {
  const auto at = static_cast<std::size_t>(vertical);
  if (at < vertical_channels.size()) return vertical_channels[at];
  return "none";
}

VerticalChannel vertical_channel(std::string_view name) {
  const auto at = std::ranges::find(vertical_channels, name) - vertical_channels.begin();
  if (at == std::ssize(vertical_channels)) throw Error(fmt::format("vertical channel: \"{}\"; expected free, fixed, aided or held", name));
  return static_cast<VerticalChannel>(at);
}

std::string_view to_string(RigKind kind) {
  switch (kind) {
    case RigKind::turntable:
      return "turntable";
    case RigKind::rate_table:
      return "rate_table";
    case RigKind::centrifuge:
      return "centrifuge";
    case RigKind::chamber:
      return "chamber";
    case RigKind::none:
      break;
  }
  return "none";
}

std::string_view to_string(RigAxis axis) {
  switch (axis) {
    case RigAxis::outer:
      return "outer";
    case RigAxis::middle:
      return "middle";
    case RigAxis::inner:
      break;
  }
  return "inner";
}

std::string_view to_string(StepKind kind) {
  switch (kind) {
    case StepKind::hold:
      return "hold";
    case StepKind::rotate:
      return "rotate";
    case StepKind::spin:
      break;
  }
  return "spin";
}

std::string step_name(const Step& step, std::size_t index) {
  return fmt::format("step {} ({} at {} s)", index + 1, to_string(step.kind), stamp_text(step.start));
}

std::set<std::string> RecordingSource::files() const {
  std::set<std::string> names{gyro.file.value_or(file), accel.file.value_or(file)};
  for (const auto& thermal : {gyro_temperature, accel_temperature})
    if (thermal) names.insert(thermal->file.value_or(file));
  return names;
}

RecordingSource Session::source_of(std::string_view name) const {
  for (const RecordingSource& source : recordings)
    if (source.file == name) return source;
  RecordingSource undeclared;
  undeclared.file = name;
  return undeclared;
}

const RigDeclaration* Session::rig_of(const RecordingSource& source) const {
  for (const RigDeclaration& rig : rigs)
    if (source.rig.empty() || rig.name == source.rig) return &rig;
  return nullptr;
}

std::vector<Step> Session::steps_of(const RecordingSource& source) const {
  std::vector<Step> chosen;
  for (const Step& step : steps)
    if (recordings.size() < 2 || step.recording == source.file) chosen.push_back(step);
  return chosen;
}

namespace {

/// A session file has it beside the other terms; in memory it may be one of them.
std::optional<double> declared_density(const std::optional<double>& density, const std::optional<NoiseModel>& terms) {
  return density || !terms || terms->N == 0 ? density : std::optional(terms->N);
}

}  // namespace

NoiseModels declared_terms(const ImuDeclaration& imu) {
  const Grade none{}, &of = imu.noise == NoiseTerms::full && imu.grade ? grade(*imu.grade) : none;
  NoiseModels noise{.gyro = imu.gyro_noise.value_or(of.gyro_noise), .accel = imu.accel_noise.value_or(of.accel_noise)};
  noise.accel.N = declared_density(imu.accel_noise_density, imu.accel_noise).value_or(of.accel_noise.N);
  noise.gyro.N = declared_density(imu.gyro_noise_density, imu.gyro_noise).value_or(of.gyro_noise.N);
  return noise;
}

NoiseModels declared_noise(const ImuDeclaration& imu) {
  const bool accel = declared_density(imu.accel_noise_density, imu.accel_noise).has_value(),
             gyro = declared_density(imu.gyro_noise_density, imu.gyro_noise).has_value();
  if (!imu.grade && !(accel && gyro))
    throw Error("the IMU's noise is not declared; expected the noise densities of accelerometers and gyros, or a grade");
  NoiseModels noise = declared_terms(imu);
  if (!accel) noise.accel.N = grade(*imu.grade).accel_noise.N;
  if (!gyro) noise.gyro.N = grade(*imu.grade).gyro_noise.N;
  return noise;
}

}  // namespace imulab
