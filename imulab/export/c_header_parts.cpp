#include "imulab/export/c_header_parts.hpp"

#include "imulab/error.hpp"
#include "imulab/formats/text/file.hpp"
#include "imulab/formats/text/printable.hpp"
#include "imulab/recording/unit_names.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <cmath>

namespace imulab::firmware {

namespace {

void expect_fitting(const RecordedAs& as, Triad triad, const std::string& raw) {
  const char* const name = triad == Triad::accel ? "accelerometers" : "gyros";
  const std::vector<std::string_view> units = unit_names(triad == Triad::accel ? Quantity::accel : Quantity::gyro, as.interval_s > 0);
  if (std::find(units.begin(), units.end(), as.unit) == units.end())
    throw Error(fmt::format("readings of the {} in {}; expected one of {}", name, harmless(as.unit), text::listed(units)));
  if (!raw.empty() && (as.unit == "count") != (raw == "count"))
    throw Error(fmt::format("readings of the {} in {}; expected {}, which the calibration was made from", name, as.unit,
                            raw == "count" ? "count" : "a physical unit"));
  if (!(as.counts_per_unit > 0) || !std::isfinite(as.counts_per_unit) || (as.unit == "count" && as.counts_per_unit != 1))
    throw Error(fmt::format("{:g} counts per {} of the {}; expected {}", as.counts_per_unit, as.unit, name,
                            as.unit == "count" ? "a physical unit with them" : "a number above 0"));
}

std::string described(const RecordedAs& as) {
  std::string text = as.counts_per_unit != 1 ? fmt::format("counts, {} to one {}", as.counts_per_unit, as.unit)
                     : as.unit == "count"    ? "counts"
                                             : as.unit;
  if (as.interval_s > 0) text += fmt::format(", each the sum over its interval of {} s", as.interval_s);
  return text;
}

void set_axes(Input& in) {
  in.column.fill(-1);
  for (int column = 0; column < 3; ++column) {
    const std::string& axis = in.as.axes[static_cast<std::size_t>(column)];
    const std::size_t body = axis.size() == 2 && (axis[0] == '+' || axis[0] == '-') ? std::string_view("xyz").find(axis[1]) : std::string::npos;
    if (body == std::string::npos || in.column[body] >= 0)
      throw Error(fmt::format("axis {} of column {}; expected +x, -x, +y, -y, +z or -z, each axis once", harmless(axis), column + 1));
    in.column[body] = column;
    in.sign[body] = axis[0] == '-' ? -1 : 1;
  }
}

}  // namespace

Input input_of(const Calibration& calibration, const CHeaderOptions& options, Triad triad) {
  const bool accel = triad == Triad::accel;
  const TriadModel& model = accel ? calibration.model.accel : calibration.model.gyro;
  const std::optional<RecordedAs>&given = accel ? options.accel : options.gyro,
        &recorded = accel ? calibration.recorded_accel : calibration.recorded_gyro;
  Input in;
  in.triad = triad;
  if (given || recorded)
    in.as = given ? *given : *recorded;
  else
    in.as.unit = model.raw_unit.empty() ? (accel ? "m/s^2" : "rad/s") : model.raw_unit;
  expect_fitting(in.as, triad, model.raw_unit);
  in.factor = si_factor(in.as.unit) / in.as.counts_per_unit;
  if (in.as.interval_s > 0) in.factor /= in.as.interval_s;
  if (!(in.factor > 0 && std::isfinite(in.factor)))
    throw Error(fmt::format("readings of the {} in {}: cannot be converted; expected a scale of an IMU", accel ? "accelerometers" : "gyros",
                            described(in.as)));
  in.counts = in.as.unit == "count" || in.as.counts_per_unit != 1;
  set_axes(in);
  in.parameter = fmt::format("{}_{}", in.triad_name(), in.counts ? "count" : unit_in_name(in.as.unit));
  in.unit = described(in.as);
  return in;
}

std::string literal(double value) {
  if (!std::isfinite(value)) throw Error("the header's numbers would be too large; expected a calibration and readings of an IMU");
  std::string text = fmt::format("{}", value);
  if (text.find_first_of(".e") == std::string::npos) text += ".0";
  return fmt::format("(imulab_real){}", value < 0 ? "(" + text + ")" : text);
}

std::string literal(std::int64_t value) {
  constexpr std::int64_t half = std::int64_t{1} << 30, whole = 2 * half;
  if (value > -whole && value < whole) return value < 0 ? fmt::format("({})", value) : fmt::format("{}", value);
  return fmt::format("((int64_t){} * {} + ({}))", literal(value / half), half, value % half);
}

std::string harmless(std::string_view text) {
  constexpr std::size_t longest = 100;
  constexpr std::string_view allowed = " .,:;()[]{}<>=+-_/@#%&!~^|'";  // no quote, backslash, asterisk or question mark (of trigraphs)
  std::string out;
  for (const char c : text) {
    const auto byte = static_cast<unsigned char>(c);
    if ((byte & 0xC0u) == 0x80u) continue;  // a further byte of a UTF-8 character
    if (out.size() == longest) return out + "...";
    out += byte < 0x80 && (std::isalnum(byte) || allowed.find(c) != std::string_view::npos) ? c : '_';
  }
  return out;
}

std::string unit_in_name(std::string_view unit) {
  std::string out;
  for (const char c : unit) {
    if (c == '/')
      out += "_per_";
    else if (std::isalnum(static_cast<unsigned char>(c)))
      out += c;
    else if (c != '^')
      out += '_';
  }
  return out;
}

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
  RawSample raw;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const auto i = static_cast<Eigen::Index>(axis);
    const auto column = [](const Input& triad, std::size_t body) { return static_cast<std::size_t>(triad.column[body]); };
    raw.accel[i] = accel.sign[axis] * accel.factor * in[column(accel, axis)];
    raw.gyro[i] = gyro.sign[axis] * gyro.factor * in[3 + column(gyro, axis)];
    if (model.accel.temperature) raw.accel_tau[i] = model.accel.temperature->tau(in[6 + axis]);
    if (model.gyro.temperature) raw.gyro_tau[i] = model.gyro.temperature->tau(in[9 + axis]);
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
    t->matrix_thermal1 = t->matrix_thermal1.cwiseAbs(), t->matrix_thermal2 = t->matrix_thermal2.cwiseAbs();
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

constexpr const char* selftest_comment =
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
  return fmt::format(selftest_comment, sample_count) + "static inline int imulab_selftest(void) {\n" + table("in", 12, in) +
         table("expected", 6, expected) + table("terms", 6, terms) + fmt::format(code, sample_count);
}

namespace {

// ASCII characters, in any locale.
bool is_letter(char c) { return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z'); }
bool is_of_name(char c) { return is_letter(c) || (c >= '0' && c <= '9') || c == '_'; }

/// C99 tells names apart by their first 63 characters; the longest part that follows a prefix has 30: _FIXED_ACCEL_TEMPERATURE_BITS.
constexpr std::size_t longest_prefix = 32;

}  // namespace

void expect_prefix(std::string_view prefix) {
  const bool of_name = std::all_of(prefix.begin(), prefix.end(), is_of_name);
  // C++ keeps names with two underscores in a row, and C those that begin with one.
  const bool free = !prefix.empty() && is_letter(prefix.front()) && prefix.back() != '_' && prefix.find("__") == std::string_view::npos;
  if (!of_name || !free || prefix.size() > longest_prefix)
    throw Error(
        fmt::format("\"{}\" cannot begin a name in C; expected a letter, then letters, digits and single underscores between them, {} in all at "
                    "most: imu1",
                    harmless(prefix), longest_prefix));
}

std::string macro_prefix(std::string_view prefix) {
  std::string out(prefix);
  for (char& c : out)
    if (c >= 'a' && c <= 'z') c = static_cast<char>(c - 'a' + 'A');
  return out;
}

std::string with_prefix(std::string_view source, std::string_view prefix) {
  constexpr std::string_view name = "imulab_", macro = "IMULAB_";
  const std::string macros = macro_prefix(prefix);
  std::string out;
  for (std::size_t i = 0; i < source.size();) {
    const bool begins = is_of_name(source[i]) && (i == 0 || !is_of_name(source[i - 1]));
    const bool is_macro = source.substr(i).starts_with(macro);
    if (begins && (is_macro || source.substr(i).starts_with(name))) {
      out.append(is_macro ? std::string_view(macros) : prefix).append("_");
      i += name.size();
    } else {
      out += source[i++];
    }
  }
  return out;
}

std::string guarded(const std::string& comment, const std::string& source, std::string_view prefix) {
  const std::string macros = macro_prefix(prefix), own = fmt::format("{}_HEADER_{}", macros, sha256(comment + source).substr(0, 16));
  return fmt::format(
      "{0}#ifndef {1}\n"
      "#define {1}\n"
      "#ifdef {2}_HEADER\n"
      "#error \"Two different calibration headers with the prefix {3}: one would be used for both IMUs. Give each its own, as in imulab export "
      "calibration.json --to c-header --prefix imu1\"\n"
      "#else\n"
      "#define {2}_HEADER\n\n"
      "{4}#endif\n#endif\n",
      comment, own, macros, prefix, source);
}

}  // namespace imulab::firmware
