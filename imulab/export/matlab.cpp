// MATLAB's imuSensor (accelparams, gyroparams): with the noise type single-sided, a sample has the standard deviation NoiseDensity sqrt(SampleRate),
// and a step of the walk RandomWalk / sqrt(SampleRate). The bias instability is white noise of that size through the filter fractalcoef(n), flicker
// of the two-sided density B^2 / (2 pi f) above SampleRate / n.
#include "imulab/export/noise_values.hpp"
#include "imulab/export/targets.hpp"
#include "imulab/export/write.hpp"

#include <fmt/format.h>

namespace imulab::export_io {

namespace {

constexpr int flicker_poles = 2000;

std::string property(const char* name, const NoiseValue& value, const char* unit) {
  const std::array<double, 3> v = each_axis(value);
  return fmt::format("    '{}', [{}, {}, {}], ... % {}: {}\n", name, exact_number(v[0]), exact_number(v[1]), exact_number(v[2]), unit, value.comment);
}

std::string parameters(const char* triad, const char* function, const NoiseValue& N, const NoiseValue& B, const NoiseValue& K, const char* unit) {
  return triad_text(N,
                    fmt::format("imu.{} = {}( ...\n", triad, function) + property("NoiseDensity", N, fmt::format("({})/sqrt(Hz)", unit).c_str()) +
                        property("BiasInstability", B, unit) + property("RandomWalk", K, fmt::format("({})*sqrt(Hz)", unit).c_str()) +
                        fmt::format("    'BiasInstabilityCoefficients', fractalcoef({}), ...\n    'NoiseType', 'single-sided');\n", flicker_poles),
                    fmt::format("% imu.{}", triad));
}

}  // namespace

std::string matlab_text(const ExportInput& input) {
  const NoiseValues n = noise_values_by_axis(input, "MATLAB");
  const auto flicker = [&](bool gyro) { return input.options.bound ? NoiseValue{.comment = "part of the bound"} : bias_instability(input, gyro); };
  const Sentences facts{
      "Holds: N, B and K of each axis, CONTINUOUS values. MATLAB makes those of a sample from them by SampleRate.",
      "'single-sided' is the noise type for which N and K are those of the Allan deviation; with 'double-sided' N is too small by sqrt(2).",
      fmt::format("Without fractalcoef the default filter is not flicker noise. {} poles hold it up to {} / SampleRate seconds.", flicker_poles,
                  flicker_poles)};
  return noise_head(input, "MATLAB (imuSensor)", facts, n, "%", "NBK") +
         fmt::format("imu = imuSensor('accel-gyro', 'SampleRate', {});\n", exact_number(n.rate_hz())) +
         parameters("Accelerometer", "accelparams", n.accel_N, flicker(false), n.accel_K, "m/s^2") +
         parameters("Gyroscope", "gyroparams", n.gyro_N, flicker(true), n.gyro_K, "rad/s");
}

}  // namespace imulab::export_io
