#include "imulab/io/export/c_header.hpp"

#include "imulab/core/error.hpp"
#include "imulab/model/outlier_filter.hpp"

#include <fmt/format.h>

#include <array>
#include <cctype>
#include <cmath>
#include <string_view>

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
    if (thermal)
      text += fmt::format("  const imulab_real {0}_t{1} = {0}_temperature[{2}] - {3};\n", name, axes[i], i,
                          literal(m.temperature ? m.temperature->reference : 0));
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
  return fmt::format("{:g} to {:g} {}, reference {:g}", m.temperature->range[0], m.temperature->range[1], quoted(m.temperature->unit),
                     m.temperature->reference);
}

/// The condition that one of a triad's temperatures is outside its range; empty where no range is known.
std::string outside_text(const TriadModel& m, const char* name) {
  if (!m.temperature || (m.temperature->range[0] == 0 && m.temperature->range[1] == 0)) return {};
  std::string inside;
  for (int i = 0; i < 3; ++i)
    inside += fmt::format("{0}{1}_temperature[{2}] >= {3} && {1}_temperature[{2}] <= {4}", i ? " &&\n           " : "", name, i,
                          literal(m.temperature->range[0]), literal(m.temperature->range[1]));
  return fmt::format("  if (!({}))\n    return 1;\n", inside);
}

std::string out_of_range_text(const SensorModel& m) {
  std::string text =
      "/* 1 where a temperature lies outside what the calibration saw, or is no number, else 0. Where a triad's calibration knows no range its\n"
      " * temperatures are not read and may be 0 (null). */\n"
      "static inline int imulab_out_of_range(const imulab_real accel_temperature[3], const imulab_real gyro_temperature[3]) {\n";
  const std::string accel = outside_text(m.accel, "accel"), gyro = outside_text(m.gyro, "gyro");
  text += accel.empty() ? "  (void)accel_temperature;\n" : accel;
  text += gyro.empty() ? "  (void)gyro_temperature;\n" : gyro;
  return text + "  return 0;\n}\n\n";
}

/// OutlierFilter, statement by statement.
constexpr std::string_view filter_source =
    R"(/* Outliers of raw readings, replaced two samples late: spikes of one or two samples. Six readings in any order; each channel on its own. */
typedef struct {
  imulab_real window[5][6];                    /* the oldest first */
  imulab_real resolution[6];                   /* smallest difference of two readings in a row, other than zero */
  imulab_real usual[6], largest[6], second[6]; /* distance of a sample from its neighbors; while it is learned the sum, and the largest two */
  int taught[6], taken;
} imulab_filter;

static inline imulab_real imulab_min(imulab_real a, imulab_real b) { return b < a ? b : a; }
static inline imulab_real imulab_max(imulab_real a, imulab_real b) { return a < b ? b : a; }
static inline imulab_real imulab_size(imulab_real a) { return a < 0 ? -a : a; }

static inline void imulab_filter_init(imulab_filter* f) {
  int i, c;
  for (c = 0; c < 6; ++c) {
    for (i = 0; i < 5; ++i) f->window[i][c] = 0;
    f->resolution[c] = f->usual[c] = f->largest[c] = f->second[c] = 0;
    f->taught[c] = 0;
  }
  f->taken = 0;
}

/* Takes a sample and gives the one two earlier: its readings in `out`, and as the result the replaced channels, bit i for reading i. The first two
 * times there is none: the result is -1 and `out` stays. Until a channel has shown its noise, in @LEARNING@ windows, its readings pass as they are. */
static inline int imulab_filter_push(imulab_filter* f, const imulab_real reading[6], imulab_real out[6]) {
  int i, c, replaced = 0;
  if (f->taken < 5) ++f->taken;
  for (c = 0; c < 6; ++c) {
    for (i = 0; i < 4; ++i) f->window[i][c] = f->window[i + 1][c];
    f->window[4][c] = reading[c];
    if (f->taken > 1) {
      const imulab_real difference = imulab_size(f->window[4][c] - f->window[3][c]);
      if (difference > 0 && (!(f->resolution[c] > 0) || difference < f->resolution[c])) f->resolution[c] = difference;
    }
  }
  if (f->taken < 3) return -1;
  for (c = 0; c < 6; ++c) {
    const imulab_real before2 = f->window[0][c], before = f->window[1][c], x = f->window[2][c], after = f->window[3][c], after2 = f->window[4][c];
    const imulab_real one = imulab_max(imulab_min(before2, before), imulab_min(after, after2));
    const imulab_real other = imulab_min(imulab_max(before2, before), imulab_max(after, after2));
    const imulab_real a = imulab_min(one, other), b = imulab_max(one, other); /* the middle two of the four neighbors */
    const imulab_real cubic = ((imulab_real)4 * (before + after) - (before2 + after2)) * (imulab_real)(1.0 / 6);
    const imulab_real distance = imulab_max(x - b, a - x);
    const imulab_real threshold = (imulab_real)@FACTOR@ * f->usual[c] + (imulab_real)@RESOLUTIONS@ * f->resolution[c];
    out[c] = x;
    if (f->taken < 5 || !(distance >= 0)) continue; /* between a and b: a slope */
    if (f->taught[c] < @MEMORY@) ++f->taught[c];
    if (f->taught[c] > @LEARNING@) {
      f->usual[c] += (imulab_min(distance, threshold) - f->usual[c]) / (imulab_real)f->taught[c];
      if (!(imulab_min(distance, imulab_size(x - cubic)) > threshold)) continue;
      out[c] = (imulab_real)0.5 * a + (imulab_real)0.5 * b;
      replaced |= 1 << c;
    } else { /* the largest two may be outliers */
      f->usual[c] += distance;
      f->second[c] = imulab_max(f->second[c], imulab_min(f->largest[c], distance));
      f->largest[c] = imulab_max(f->largest[c], distance);
      if (f->taught[c] == @LEARNING@) f->usual[c] = imulab_max(f->usual[c] - f->largest[c] - f->second[c], 0) / (imulab_real)(@LEARNING@ - 2);
    }
  }
  return replaced;
}

)";

std::string filter_text() {
  std::string out(filter_source);
  const auto set = [&out](const std::string& name, double value) {
    for (std::size_t at = out.find(name); at != std::string::npos; at = out.find(name)) out.replace(at, name.size(), fmt::format("{:g}", value));
  };
  set("@LEARNING@", static_cast<double>(OutlierFilter::learning));
  set("@MEMORY@", OutlierFilter::memory);
  set("@FACTOR@", OutlierFilter::usual_factor);
  set("@RESOLUTIONS@", OutlierFilter::resolutions);
  return out;
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
  text += "}\n\n" + out_of_range_text(c.model) + filter_text() + "#endif\n";
  return text;
}

std::vector<std::string> left_out_of_c_header(const Calibration& calibration) {
  if (calibration.model.lever_arm.isZero(0)) return {};
  return {"lever arms are not exported; the forces are those at the accelerometers"};
}

}  // namespace imulab
