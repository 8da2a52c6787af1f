#include "imulab/export/c_header_parts.hpp"
#include "imulab/export/c_header_samples.hpp"
#include "imulab/export/c_header_text.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace imulab::firmware {

double fraction(int sample, int channel) {
  const double size = 0.15 + 0.1 * ((5 * sample + 3 * channel) % 9);
  return (sample + channel + channel / 3) % 2 != 0 ? -size : size;
}

double test_temperature(const TriadModel& model, double fraction) {
  if (!model.temperature) return 0;
  const auto [low, high] = model.temperature->range;
  return low < high ? 0.5 * (low + high) + fraction * 0.5 * (high - low) : model.temperature->reference + 10 * fraction;
}

RawSample raw_sample(const SensorModel& model, const Input& accel, const Input& gyro, const std::array<double, 12>& in) {
  RawSample raw{Vector3d::Zero(), Vector3d::Zero()};
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const auto i = static_cast<Eigen::Index>(axis);
    const auto column = [](const Input& triad, std::size_t body) { return static_cast<std::size_t>(triad.column[body]); };
    raw.accel[i] = accel.sign[axis] * accel.factor * in[column(accel, axis)];
    raw.gyro[i] = gyro.sign[axis] * gyro.factor * in[3 + column(gyro, axis)];
    if (model.accel.temperature) raw.accel_tau[i] = in[6 + axis] - model.accel.temperature->reference;
    if (model.gyro.temperature) raw.gyro_tau[i] = in[9 + axis] - model.gyro.temperature->reference;
  }
  return raw;
}

namespace {

/// The reading at which the largest scale alone gives `output`: a size of readings to test with.
double usual_reading(const TriadModel& model, const Input& in, double output) {
  const double scale = model.matrix.cwiseAbs().maxCoeff() * in.factor;
  const double reading = scale > 0 ? output / scale : 1;
  return std::isfinite(reading) && reading < 1e30 ? reading : 1;
}

/// The model with the absolute values of its coefficients: of absolute readings it gives the sums of absolute terms, to which rounding is relative.
SensorModel absolute(SensorModel m) {
  for (TriadModel* t : {&m.accel, &m.gyro}) {
    t->offset = t->offset.cwiseAbs(), t->matrix = t->matrix.cwiseAbs();
    t->quadratic = t->quadratic.cwiseAbs(), t->cubic = t->cubic.cwiseAbs();
    t->thermal = -t->thermal.cwiseAbs();  // the drift is subtracted
  }
  m.g_sensitivity = m.g_sensitivity.cwiseAbs();
  return m;
}

/// Thermal readings count with themselves and the reference, which are subtracted.
RawSample absolute(const SensorModel& model, RawSample raw, const std::array<double, 12>& in) {
  raw.accel = raw.accel.cwiseAbs(), raw.gyro = raw.gyro.cwiseAbs();
  for (Eigen::Index i = 0; i < 3; ++i) {
    if (model.accel.temperature) raw.accel_tau[i] = std::abs(in[6 + static_cast<std::size_t>(i)]) + std::abs(model.accel.temperature->reference);
    if (model.gyro.temperature) raw.gyro_tau[i] = std::abs(in[9 + static_cast<std::size_t>(i)]) + std::abs(model.gyro.temperature->reference);
  }
  return raw;
}

template <class Numbers>
std::string row_text(const Numbers& numbers) {
  std::string text;
  for (const double x : numbers) text += (text.empty() ? "" : ", ") + literal(x);
  return "      {" + text + "},\n";
}

std::array<double, 6> outputs(const Motion& m) { return {m.force[0], m.force[1], m.force[2], m.rate[0], m.rate[1], m.rate[2]}; }

constexpr const char* comment =
    "/* 0 where this compiler and processor compute what imulab computes: {} samples, each output within 16 machine epsilons of imulab_real "
    "(3.6e-15\n"
    " * in double, 1.9e-6 in float) of the sum of the absolute values of its terms. Otherwise the place, from 1 on, of the first output that does\n"
    " * not agree. */\n";

constexpr const char* code =
    "  const imulab_real epsilon = (imulab_real)(sizeof(imulab_real) > 4 ? 2.220446049250313e-16 : sizeof(imulab_real) > 2 ? 1.1920929e-07 : "
    "9.765625e-04);\n"
    "  imulab_real out[6];\n"
    "  int i, k;\n"
    "  for (i = 0; i < {0}; ++i) {{\n"
    "    imulab_compensate(in[i], in[i] + 3, in[i] + 6, in[i] + 9, out, out + 3);\n"
    "    for (k = 0; k < 6; ++k) {{\n"
    "      const imulab_real difference = out[k] - expected[i][k], tolerance = (imulab_real)16 * epsilon * terms[i][k];\n"
    "      if (!(difference <= tolerance && -difference <= tolerance)) return 1 + 6 * i + k;\n"
    "    }}\n"
    "  }}\n"
    "  return 0;\n"
    "}}\n\n";

}  // namespace

std::string selftest_text(const SensorModel& model, const Input& accel, const Input& gyro) {
  constexpr double force = 20, rate = 5;  // m/s^2, rad/s: in the range of every IMU's sensors
  const double accel_reading = usual_reading(model.accel, accel, force), gyro_reading = usual_reading(model.gyro, gyro, rate);
  std::string in, expected, terms;
  for (int i = 0; i < sample_count; ++i) {
    std::array<double, 12> x;
    for (int k = 0; k < 12; ++k) {
      const double part = fraction(i, k);
      const double reading = k < 3 ? part * accel_reading : k < 6 ? part * gyro_reading : test_temperature(k < 9 ? model.accel : model.gyro, part);
      x[static_cast<std::size_t>(k)] = static_cast<float>(reading);  // exact in both types
    }
    const RawSample raw = raw_sample(model, accel, gyro, x);
    in += row_text(x);
    expected += row_text(outputs(compensate(model, raw)));
    terms += row_text(outputs(compensate(absolute(model), absolute(model, raw, x))));
  }
  const auto table = [](const char* name, int columns, const std::string& rows) {
    return fmt::format("  static const imulab_real {}[{}][{}] = {{\n{}  }};\n", name, sample_count, columns, rows);
  };
  return fmt::format(comment, sample_count) + "static inline int imulab_selftest(void) {\n" + table("in", 12, in) + table("expected", 6, expected) +
         table("terms", 6, terms) + fmt::format(code, sample_count);
}

}  // namespace imulab::firmware
