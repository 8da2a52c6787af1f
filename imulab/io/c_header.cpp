#include "imulab/io/c_header.hpp"

#include "imulab/core/error.hpp"

#include <fmt/format.h>

#include <array>
#include <cctype>
#include <cmath>

namespace imulab {

namespace {

constexpr std::array<const char*, 3> axes{"x", "y", "z"};

/// As a literal of the header's number type, exact in double.
std::string literal(double value) {
  std::string text = fmt::format("{}", value);
  if (text.find_first_of(".e") == std::string::npos) text += ".0";
  return fmt::format("(imulab_real){}", value < 0 ? "(" + text + ")" : text);
}

/// Inside a comment: one line, and nothing that could end it.
std::string quoted(const std::string& text) {
  std::string out;
  for (const char c : text) out += std::isprint(static_cast<unsigned char>(c)) && c != '*' && c != '\\' ? c : ' ';
  return out;
}

/// value + coefficient * variable, where the coefficient is not zero.
void add_term(std::string& sum, double coefficient, const std::string& variable) {
  if (coefficient == 0) return;
  sum += fmt::format("{}{} * {}", sum.empty() ? "" : " + ", literal(coefficient), variable);
}

/// The statements that turn three readings into the triad's output.
std::string triad_text(const TriadModel& m, const char* name, const char* out) {
  std::string text;
  const bool thermal = !m.thermal.isZero(0);
  for (int i = 0; i < 3; ++i) {
    if (thermal) text += fmt::format("  const imulab_real {0}_t{1} = {0}_temperature[{2}] - {3};\n", name, axes[i], i, literal(m.temperature ? m.temperature->reference : 0));
    std::string drift;
    if (thermal && (m.thermal(i, 1) != 0 || m.thermal(i, 2) != 0)) {
      const std::string t = fmt::format("{}_t{}", name, axes[i]);
      drift = fmt::format(" - ({} + {} * {}) * {}", literal(m.thermal(i, 1)), literal(m.thermal(i, 2)), t, t);
    }
    text += fmt::format("  const imulab_real {0}_{1} = {0}[{2}]{3};\n", name, axes[i], i, drift);
  }
  for (int i = 0; i < 3; ++i) {
    const std::string v = fmt::format("{}_{}", name, axes[i]);
    std::string sum;
    for (int j = 0; j < 3; ++j) add_term(sum, m.matrix(i, j), fmt::format("{}_{}", name, axes[j]));
    if (m.offset[i] != 0) sum += (sum.empty() ? "" : " + ") + literal(m.offset[i]);
    add_term(sum, m.quadratic[i], fmt::format("{0} * {0}", v));
    add_term(sum, m.cubic[i], fmt::format("{0} * {0} * {0}", v));
    text += fmt::format("  const imulab_real {}_{} = {};\n", out, axes[i], sum.empty() ? literal(0) : sum);
  }
  if (thermal) return text;
  return fmt::format("  (void){}_temperature;\n", name) + text;
}

std::string range_text(const TriadModel& m) {
  if (!m.temperature) return "none read";
  return fmt::format("{:g} to {:g} {}, reference {:g}", m.temperature->range[0], m.temperature->range[1], quoted(m.temperature->unit), m.temperature->reference);
}

void expect_finite(const SensorModel& m) {
  for (const TriadModel* t : {&m.accel, &m.gyro})
    if (!(t->offset.allFinite() && t->matrix.allFinite() && t->quadratic.allFinite() && t->cubic.allFinite() && t->thermal.allFinite()))
      throw Error("the calibration has numbers that are not finite");
  if (!m.g_sensitivity.allFinite()) throw Error("the calibration has numbers that are not finite");
}

}  // namespace

std::string c_header(const Calibration& c) {
  expect_finite(c.model);
  const TriadModel &accel = c.model.accel, &gyro = c.model.gyro;
  const auto raw = [](const TriadModel& m, const char* si) { return m.raw_unit.empty() ? std::string(si) : quoted(m.raw_unit); };
  std::string text = fmt::format(
      "/* Calibration of \"{}\", method {}, {}.\n"
      " * Written by {}. C99 and C++.\n"
      " *\n"
      " * Raw readings: accelerometers in {}, gyros in {}.\n"
      " * Accelerometer temperatures: {}.\n"
      " * Gyro temperatures: {}.\n"
      " */\n"
      "#ifndef IMULAB_CALIBRATION_H\n"
      "#define IMULAB_CALIBRATION_H\n\n"
      "#ifndef IMULAB_REAL\n"
      "#define IMULAB_REAL double\n"
      "#endif\n"
      "typedef IMULAB_REAL imulab_real;\n\n",
      quoted(c.imu), quoted(c.method), quoted(c.created), quoted(c.software.empty() ? "imulab" : c.software), raw(accel, "m/s^2"), raw(gyro, "rad/s"),
      range_text(accel), range_text(gyro));
  text +=
      "/* Specific force [m/s^2] and angular rate [rad/s] of one sample, x y z, from raw readings and each axis's thermal reading. Where a triad's\n"
      " * calibration has no thermal terms its temperatures are not read and may be 0 (null). The outputs may be the inputs' own memory. */\n"
      "static inline void imulab_compensate(const imulab_real accel[3], const imulab_real gyro[3], const imulab_real accel_temperature[3],\n"
      "                                     const imulab_real gyro_temperature[3], imulab_real force[3], imulab_real rate[3]) {\n";
  text += triad_text(accel, "accel", "f");
  text += triad_text(gyro, "gyro", "w");
  for (int i = 0; i < 3; ++i) {
    std::string sum = fmt::format("w_{}", axes[i]);
    for (int j = 0; j < 3; ++j) add_term(sum, c.model.g_sensitivity(i, j), fmt::format("f_{}", axes[j]));
    text += fmt::format("  rate[{}] = {};\n", i, sum);
  }
  for (int i = 0; i < 3; ++i) text += fmt::format("  force[{}] = f_{};\n", i, axes[i]);
  text += "}\n\n#endif\n";
  return text;
}

}  // namespace imulab
