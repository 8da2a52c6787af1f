// KF-GINS (i2Nav-WHU/KF-GINS, commit f39bc2e: src/kf_gins.cpp, loadConfig; src/kf-gins/gi_engine.cpp): white noise as random walks of angle and
// velocity; biases and scale factors as Gauss-Markov processes of one correlation time T, whose driving noise has the density 2 std^2 / T. A process
// with std = K sqrt(T / 2) is the walk K for times far below T.
#include "imulab/coefficient.hpp"
#include "imulab/export/noise_values.hpp"
#include "imulab/export/targets.hpp"
#include "imulab/export/write.hpp"
#include "imulab/grade.hpp"
#include "imulab/model/relative_uncertainty.hpp"
#include "imulab/units.hpp"

#include <fmt/format.h>

#include <cmath>

namespace imulab::export_io {

namespace {

constexpr double usual_correlation_h = 4;  // the drives that KF-GINS processes are shorter
constexpr double mGal = 1e-5;              // m/s^2

std::string axes_line(const char* key, const NoiseValue& value, double factor, const char* unit, const char* density_unit) {
  const std::array<double, 3> v = each_axis(value);
  const Vector3d scaled = factor * Vector3d(v[0], v[1], v[2]);
  return triad_text(value, fmt::format("  {}: {}  # {}; densities [{}]: {}\n", key, row_text(scaled), unit, density_unit, value.comment), "  #");
}

/// One sigma of what the calibration leaves of the scale factors.
std::string scale_line(const ExportInput& input, const char* key, const char* triad, double of_grade) {
  Vector3d sigma;
  for (Eigen::Index i = 0; i < 3; ++i)
    sigma[i] = relative_uncertainty(input.calibration, coefficient_index(fmt::format("{0}.matrix.{1}{1}", triad, "xyz"[i])));
  const bool known = sigma.allFinite();
  if (!known) sigma.setConstant(of_grade);
  return fmt::format("  {}: {}  # ppm; {}\n", key, row_text(sigma / unit::ppm),
                     known ? "standard uncertainties of the calibration's scale factors" : "NOT MEASURED: assumed, grade mems before a calibration");
}

}  // namespace

std::string kf_gins_text(const ExportInput& input) {
  const auto [n, correlation_s] = noise_values_of_process(input, "KF-GINS", usual_correlation_h * unit::hour);
  const double walk_s = std::sqrt(correlation_s / 2), correlation_h = correlation_s / unit::hour;
  const Grade& mems = grade("mems");
  const Sentences facts{
      "Holds: N as arw and vrw, K as gbstd and abstd of each axis, CONTINUOUS values: no rate is needed.",
      input.options.bound
          ? "gbstd, abstd, corrtime: processes that together with N are the bounds below; K = gbstd sqrt(2 / corrtime)."
          : fmt::format("gbstd, abstd = K sqrt(corrtime / 2): walks over times far below {:g} h. They are not the bias instability B.",
                        correlation_h),
      "Without initbgstd and initbastd, KF-GINS takes gbstd and abstd also as what the first biases are uncertain by.",
      "Biases that change from one turn-on to the next are not in the noise: give their size as initbgstd [deg/h] and initbastd [mGal].",
      "Correct the readings with `imulab compensate` before: then the initial errors below are zero. KF-GINS' axes are forward, right, down.",
      "Replace these keys of kf-gins.yaml."};
  std::string text = noise_head(input, "KF-GINS", facts, n);
  for (const char* key : {"initgyrbias", "initaccbias", "initgyrscale", "initaccscale"}) text += fmt::format("{}: [0.0, 0.0, 0.0]\n", key);
  return text + "imunoise:\n" + axes_line("arw", n.gyro_N, 1 / unit::deg_per_sqrt_h, "deg/sqrt(h)", "rad/s/sqrt(Hz)") +
         axes_line("vrw", n.accel_N, std::sqrt(unit::hour), "m/s/sqrt(h)", "m/s^2/sqrt(Hz)") +
         axes_line("gbstd", n.gyro_K, walk_s / unit::deg_per_h, "deg/h", "rad/s^2/sqrt(Hz)") +
         axes_line("abstd", n.accel_K, walk_s / mGal, "mGal", "m/s^3/sqrt(Hz)") + scale_line(input, "gsstd", "gyro", mems.gyro_scale) +
         scale_line(input, "asstd", "accel", mems.accel_scale) + fmt::format("  corrtime: {}  # h\n", exact_number(correlation_h));
}

}  // namespace imulab::export_io
