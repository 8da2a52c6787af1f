#include "imulab/formats/noise/noise_reader.hpp"

#include "imulab/formats/text/file.hpp"
#include "imulab/formats/text/json_field.hpp"

#include <algorithm>
#include <cmath>

namespace imulab {
namespace {

using json_text::Field;

NoiseCoefficient noise_coefficient_at(const Field& f) {
  NoiseCoefficient c;
  c.determined = f["determined"].truth();
  c.value = f["value"].number_or_nan();
  const Field sigma = f["standard_uncertainty"];
  c.standard_uncertainty = c.determined ? sigma.number_or_infinity() : sigma.number_or_nan();  // of a scale that has no upper bound
  c.lower = f["lower"].number();
  c.upper = f["upper"].number_or_infinity();
  if (c.determined && !(std::isfinite(c.value) && c.standard_uncertainty > 0))
    f.fail("is determined without a value; expected value and a positive standard_uncertainty");
  if (!(c.lower <= c.upper)) f.fail("expected an upper bound not below the lower one");
  return c;
}

/// Sizes are not negative; a ramp has a sign.
NoiseCoefficient noise_size_at(const Field& f) {
  const NoiseCoefficient c = noise_coefficient_at(f);
  if (c.upper < 0 || (c.determined && c.value < 0)) f.fail("expected a size from 0 on");
  return c;
}

NoiseCoefficients noise_coefficients_at(const Field& axis) {
  const Field f = axis["coefficients"];
  NoiseCoefficients out;
  out.Q = noise_size_at(f["Q"]), out.N = noise_size_at(f["N"]), out.B = noise_size_at(f["B"]), out.K = noise_size_at(f["K"]);
  out.R = noise_coefficient_at(f["R"]);
  out.markov = axis.list("markov", [](const Field& term) { return MarkovTerm{noise_size_at(term["sigma"]), noise_size_at(term["time"])}; });
  return out;
}

}  // namespace

ImuNoise read_noise(const std::string& path) {
  const MappedFile file(path, Content::settings);
  return parse_noise(file.text(), input_name(path));
}

ImuNoise parse_noise(std::string_view text, const std::string& file) {
  const json_text::Json json = json_text::parse_json(text, file, "noise.json as imulab noise writes it");
  const Field root(json, file, "");
  if (!root.has("format") || root["format"].text() != "imulab.noise/1") root.fail("expected \"format\": \"imulab.noise/1\"");
  ImuNoise out;
  out.recording = root.text_or_empty("recording");
  out.interval_s = root["interval_s"].number();
  if (!(out.interval_s > 0)) root["interval_s"].expected("a positive time");
  root["axes"].list([&](const Field& axis) {
    const std::string name = axis["name"].text();
    const bool gyro = name.starts_with("gyro.");
    const std::size_t at = name.empty() ? 3 : std::string("xyz").find(name.back());
    if ((!gyro && !name.starts_with("accel.")) || at > 2 || name.size() != (gyro ? 6u : 7u)) axis["name"].expected("gyro.x to accel.z");
    (gyro ? out.gyro_unit : out.accel_unit) = axis["unit"].text();
    if (axis.has("coefficients")) (gyro ? out.gyro : out.accel)[at] = noise_coefficients_at(axis);
    return 0;
  });
  return out;
}

}  // namespace imulab
