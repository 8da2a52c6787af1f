#include "imulab/export/c_header.hpp"

#include "imulab/error.hpp"
#include "imulab/export/c_header_fixed.hpp"
#include "imulab/export/c_header_parts.hpp"
#include "imulab/export/loss.hpp"
#include "imulab/export/write.hpp"
#include "imulab/files.hpp"
#include "imulab/formats/text/file.hpp"
#include "imulab/recording/origin.hpp"

#include <fmt/format.h>

#include <array>

namespace imulab {

namespace {

using firmware::axis_names, firmware::harmless, firmware::Input, firmware::literal;

/// A sum of coefficient * variable, where the coefficient is not zero.
std::string products(const std::array<double, 3>& coefficients, const std::string& variable) {
  std::string sum;
  for (std::size_t j = 0; j < 3; ++j)
    if (coefficients[j] != 0) sum += fmt::format("{}{} * {}_{}", sum.empty() ? "" : " + ", literal(coefficients[j]), variable, axis_names[j]);
  return sum;
}

std::array<double, 3> row(const Matrix3d& m, int i) { return {m(i, 0), m(i, 1), m(i, 2)}; }

bool has_range(const TriadModel& m) { return m.temperature && m.temperature->has_range(); }

/// A temperature within the calibrated range, if it is known; no number stays none.
std::string limited_text(const TriadModel& m, const std::string& t) {
  if (!has_range(m)) return t;
  const std::string low = literal(m.temperature->range[0]), high = literal(m.temperature->range[1]);
  return fmt::format("({0} < {1} ? {1} : {0} > {2} ? {2} : {0})", t, low, high);
}

/// The statements that turn three readings into the model's raw readings, less their thermal drift.
std::string raw_text(const TriadModel& m, const Input& in) {
  const std::string name = in.triad_name();
  const bool thermal = m.varies();
  std::string text = thermal ? "" : fmt::format("  (void){}_temperature;\n", name);
  for (int i = 0; i < 3; ++i) {
    const auto axis = static_cast<std::size_t>(i);
    if (thermal)
      text += fmt::format("  const imulab_real {0}_t{1} = {2} - {3};\n", name, axis_names[axis],
                          limited_text(m, fmt::format("{}_temperature[{}]", name, i)), literal(m.temperature ? m.temperature->reference : 0));
    std::string drift;
    if (thermal && !m.thermal.row(i).isZero(0)) {
      const std::string t = fmt::format("{}_t{}", name, axis_names[axis]), c2 = literal(m.thermal(i, 2));
      const std::string upper = m.thermal(i, 3) == 0 ? c2 : fmt::format("({} + {} * {})", c2, literal(m.thermal(i, 3)), t);
      drift = fmt::format(" - ({} + {} * {}) * {}", literal(m.thermal(i, 1)), upper, t, t);
    }
    std::string reading = fmt::format("{}[{}]", in.parameter, in.column[axis]);
    if (in.factor != 1)
      reading += " * " + literal(in.sign[axis] * in.factor);
    else if (in.sign[axis] < 0)
      reading = "-" + reading;
    text += fmt::format("  const imulab_real {}_{} = {}{};\n", name, axis_names[axis], reading, drift);
  }
  return text;
}

/// The statements of the change of the matrix with the temperature.
std::string change_text(const TriadModel& m, const std::string& name, const std::string& before, const char* out) {
  std::string text;
  for (int i = 0; i < 3; ++i) {
    const char* const axis = axis_names[static_cast<std::size_t>(i)];
    const std::string first = products(row(m.matrix_thermal1, i), before), second = products(row(m.matrix_thermal2, i), before);
    const std::string t = fmt::format("{}_t{}", name, axis);
    std::string sum = fmt::format("{}_{}", before, axis);
    if (!second.empty())
      sum += fmt::format(" + {0} * (({1}) + {0} * ({2}))", t, first.empty() ? literal(0.0) : first, second);
    else if (!first.empty())
      sum += fmt::format(" + {} * ({})", t, first);
    text += fmt::format("  const imulab_real {}_{} = {};\n", out, axis, sum);
  }
  return text;
}

/// The statements of the polynomial, in the order of the library's on columns.
std::string polynomial_text(const TriadModel& m, const std::string& name, const char* out) {
  if (m.matrix_varies()) {
    TriadModel at_reference = m;
    at_reference.matrix_thermal1.setZero(), at_reference.matrix_thermal2.setZero();
    const std::string before = std::string(out) + "0";
    return polynomial_text(at_reference, name, before.c_str()) + change_text(m, name, before, out);
  }
  std::string text;
  for (int i = 0; i < 3; ++i) {
    const char* const axis = axis_names[static_cast<std::size_t>(i)];
    std::string sum = products(row(m.matrix, i), name);
    if (m.offset[i] != 0) sum = sum.empty() ? literal(m.offset[i]) : fmt::format("{} + ({})", literal(m.offset[i]), sum);
    if (m.quadratic[i] != 0 || m.cubic[i] != 0) {
      const std::string v = fmt::format("{}_{}", name, axis), bend = fmt::format("{} * {}", literal(m.cubic[i]), v);
      const std::string factor = m.cubic[i] == 0       ? literal(m.quadratic[i])
                                 : m.quadratic[i] == 0 ? "(" + bend + ")"
                                                       : fmt::format("({} + {})", literal(m.quadratic[i]), bend);
      sum += fmt::format("{}{} * ({} * {})", sum.empty() ? "" : " + ", factor, v, v);
    }
    text += fmt::format("  const imulab_real {}_{} = {};\n", out, axis, sum.empty() ? literal(0.0) : sum);
  }
  return text;
}

std::string compensate_text(const SensorModel& m, const Input& accel, const Input& gyro) {
  std::string text = fmt::format(
      "/* Specific force [m/s^2] and angular rate [rad/s] of one sample along the body axes x y z, from readings in the units above and each axis's\n"
      " * thermal reading. Where a triad's calibration has no thermal terms its temperatures are not read and may be 0 (null). The outputs may be\n"
      " * the inputs' own memory. A reading that is no number makes the outputs that depend on it no numbers. */\n"
      "static inline void imulab_compensate(const imulab_real {}[3], const imulab_real {}[3], const imulab_real accel_temperature[3],\n"
      "                                     const imulab_real gyro_temperature[3], imulab_real force_m_per_s2[3], imulab_real rate_rad_per_s[3]) "
      "{{\n",
      accel.parameter, gyro.parameter);
  text += raw_text(m.accel, accel) + polynomial_text(m.accel, "accel", "f");
  text += raw_text(m.gyro, gyro) + polynomial_text(m.gyro, "gyro", "w");
  for (int i = 0; i < 3; ++i) {
    const std::string sum = products(row(m.g_sensitivity, i), "f");
    text += fmt::format("  rate_rad_per_s[{}] = w_{}{};\n", i, axis_names[static_cast<std::size_t>(i)], sum.empty() ? "" : " + (" + sum + ")");
  }
  for (int i = 0; i < 3; ++i) text += fmt::format("  force_m_per_s2[{}] = f_{};\n", i, axis_names[static_cast<std::size_t>(i)]);
  return text + "}\n\n";
}

std::string range_text(const TriadModel& m) {
  if (!m.temperature) return "none read";
  const auto [low, high] = m.temperature->range;
  const std::string range = m.temperature->has_range() ? fmt::format("{:g} to {:g}", low, high) : "range not stated";
  return fmt::format("in {}, {}, reference {:g}", harmless(m.temperature->unit), range, m.temperature->reference);
}

/// The condition that one of a triad's temperatures is outside its range; empty where no range is known.
std::string outside_text(const TriadModel& m, const char* name) {
  if (!has_range(m)) return {};
  std::string inside;
  for (int i = 0; i < 3; ++i)
    inside += fmt::format("{0}{1}_temperature[{2}] >= {3} && {1}_temperature[{2}] <= {4}", i ? " &&\n        " : "", name, i,
                          literal(m.temperature->range[0]), literal(m.temperature->range[1]));
  return fmt::format("  if (!({}))\n    return 1;\n", inside);
}

std::string out_of_range_text(const SensorModel& m) {
  std::string text =
      "/* 1 where a temperature lies outside what the calibration saw, or is no number, else 0: imulab_compensate uses the nearest that it saw.\n"
      " * Where a triad's calibration knows no range its temperatures are not read and may be 0 (null). */\n"
      "static inline int imulab_out_of_range(const imulab_real accel_temperature[3], const imulab_real gyro_temperature[3]) {\n";
  const std::string accel = outside_text(m.accel, "accel"), gyro = outside_text(m.gyro, "gyro");
  text += accel.empty() ? "  (void)accel_temperature;\n" : accel;
  text += gyro.empty() ? "  (void)gyro_temperature;\n" : gyro;
  return text + "  return 0;\n}\n\n";
}

void expect_finite(const SensorModel& m) {
  for (const TriadModel* t : {&m.accel, &m.gyro})
    if (!t->all_finite()) throw Error("the calibration has numbers that are not finite");
  if (!m.g_sensitivity.allFinite()) throw Error("the calibration has numbers that are not finite");
}

std::string axes_text(const Input& in) {
  const auto& axes = in.as.axes;
  return fmt::format("[0] along {}, [1] along {}, [2] along {}", axes[0], axes[1], axes[2]);
}

/// The equation, what the header holds, what the data did not determine, and what is lost.
std::string equation_text(const Calibration& c) {
  std::string text =
      " *\n"
      " * V = u - (c1 (T - reference) + c2 (T - reference)^2): u the reading in SI (or counts, where the calibration has them), T its axis's "
      "temperature\n"
      " * force = offset + matrix V + quadratic V^2 + cubic V^3\n"
      " * rate  = offset + matrix V + quadratic V^2 + cubic V^3 + g_sensitivity force\n"
      " * so offsets are added to the output. Holds: the whole model of every sensor.\n";
  for (const std::string& name : export_io::not_determined(c))
    text += fmt::format(" * NOT DETERMINED by the data, a starting value that compensates nothing: {}\n", harmless(name));
  text += " * Not held: uncertainties and limits.\n";
  for (const std::string& lost : left_out_of_c_header(c)) text += " * Not held: " + lost + "\n";
  return text;
}

/// The SHA-256 of the calibration's file, or of the text that imulab writes.
std::string calibration_hash(const Calibration& c, const CHeaderOptions& options) {
  return options.calibration_sha256.empty() ? sha256(calibration_text(c)) : harmless(options.calibration_sha256);
}

/// The comment at the top.
std::string head_text(const Calibration& c, const Input& accel, const Input& gyro, const CHeaderOptions& options) {
  const std::string text = fmt::format(
      "/* {}made with {}.\n"
      " * Header by {}, from the calibration {} SHA-256 {}.\n"
      " * C99 and C++. Names begin with {}_ and {}_.\n"
      " *\n"
      " * In:  accelerometers [{}], {}\n"
      " *      gyros [{}], {}\n"
      " *      temperatures of the accelerometers: {}\n"
      " *      temperatures of the gyros: {}\n"
      " * Out: specific force [m/s^2], angular rate [rad/s], along x, y, z of the body\n",
      export_io::calibration_of_text(c, harmless), harmless(c.software.empty() ? "imulab" : c.software), software(),
      options.calibration_sha256.empty() ? "that imulab writes with" : "file with", calibration_hash(c, options), options.prefix,
      firmware::macro_prefix(options.prefix), accel.unit, axes_text(accel), gyro.unit, axes_text(gyro), range_text(c.model.accel),
      range_text(c.model.gyro));
  return text + equation_text(c) + " */\n";
}

/// The names of what the header was made from, and its number type.
std::string macros_text(const Calibration& c, const Input& accel, const Input& gyro, const CHeaderOptions& options) {
  return fmt::format(
      "#define IMULAB_VERSION \"{}\"\n"
      "#define IMULAB_CALIBRATION_SHA256 \"{}\"\n"
      "#define IMULAB_ACCEL_UNIT \"{}\"\n"
      "#define IMULAB_GYRO_UNIT \"{}\"\n\n"
      "#ifndef IMULAB_REAL\n"
      "#define IMULAB_REAL double\n"
      "#endif\n"
      "typedef IMULAB_REAL imulab_real;\n\n",
      software(), calibration_hash(c, options), accel.unit, gyro.unit);
}

}  // namespace

std::string c_header(const Calibration& c, const CHeaderOptions& options) {
  expect_finite(c.model);
  firmware::expect_prefix(options.prefix);
  const Input accel = firmware::input_of(c, options, Triad::accel), gyro = firmware::input_of(c, options, Triad::gyro);
  std::string text = macros_text(c, accel, gyro, options) + compensate_text(c.model, accel, gyro) + out_of_range_text(c.model) +
                     firmware::filter_text() + firmware::selftest_text(c.model, accel, gyro);
  if (options.fixed_point) text += firmware::fixed_text(c.model, accel, gyro, options, firmware::words_of_32);
  if (options.q15) text += firmware::fixed_text(c.model, accel, gyro, options, firmware::words_of_16);
  if (options.fixed_point || options.q15) text += firmware::fixed_filter_text();
  return firmware::guarded(head_text(c, accel, gyro, options), firmware::with_prefix(text, options.prefix), options.prefix);
}

std::string c_header(const Calibration& calibration) { return c_header(calibration, {}); }

std::vector<std::string> left_out_of_c_header(const Calibration& calibration) {
  constexpr export_io::Held all_but_lever_arms{.nonlinear = true,
                                               .accel_thermal = true,
                                               .gyro_thermal = true,
                                               .matrix_thermal = true,
                                               .g_sensitivity = true,
                                               .accel_matrix = true,
                                               .gyro_matrix = true,
                                               .accel_scale = true,
                                               .gyro_scale = true,
                                               .bias = true};
  return export_io::losses(calibration.model, all_but_lever_arms);
}

}  // namespace imulab
