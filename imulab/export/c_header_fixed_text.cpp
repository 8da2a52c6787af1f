// imulab_compensate_fixed and imulab_compensate_q15: the numbers of FixedTriad as C. What is computed has 32 bits in both; the sums of the one
// have 64.
#include "imulab/export/c_header_fixed.hpp"
#include "imulab/export/c_header_parts.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace imulab::firmware {

namespace {

constexpr const char* helpers =
    "static inline int32_t imulab_{0}_limit(int32_t x, int32_t least, int32_t most) {{ return x > most ? most : x < least ? least : x; }}\n"
    "static inline {1} imulab_{0}_shift({1} x, int bits) {{ return (x + (({1})1 << (bits - 1))) >> bits; }}\n"
    "static inline {1} imulab_{0}_product(int32_t a, int32_t b) {{ return ({1})a * b; }}\n\n";

std::string times_power(int bits) { return bits == 0 ? "" : fmt::format(" * {}", std::int64_t{1} << bits); }

std::string drift_text(const FixedTriad& f, const std::string& name, int axis) {
  const FixedDrift& d = f.drift[static_cast<std::size_t>(axis)];
  if (d.k0 == 0 && d.k1 == 0 && d.k2 == 0 && d.k3 == 0) return {};
  const std::string t = fmt::format("{}_t{}", name, axis_names[static_cast<std::size_t>(axis)]);
  const FixedWords& w = *f.words;
  const auto plus_product = [&](std::int64_t k, const std::string& slope) {
    return fmt::format("({1} + (int32_t)imulab_{0}_shift(imulab_{0}_product({2}, {3}), {4}))", w.prefix, literal(k), slope, t, w.v_bits);
  };
  std::string slope = literal(d.k1);
  if (d.k2 != 0 || d.k3 != 0) slope = plus_product(d.k1, d.k3 != 0 ? plus_product(d.k2, literal(d.k3)) : literal(d.k2));
  return fmt::format(" -\n      (int32_t)imulab_{0}_shift({1} + imulab_{0}_product({2}, {3}), {4})", w.prefix, literal(d.k0), slope, t,
                     w.v_bits + d.shift);
}

std::string raw_text(const FixedTriad& f, const Input& in) {
  const std::string name = in.triad_name();
  std::string text = f.thermal ? "" : fmt::format("  (void){}_temperature;\n", name);
  for (int i = 0; i < 3; ++i) {
    const auto axis = static_cast<std::size_t>(i);
    const std::string drift = drift_text(f, name, i);
    if (!drift.empty() || f.changes)
      text += fmt::format("  const int32_t {0}_t{1} = (imulab_{7}_limit({0}_temperature[{2}], {3}, {4}) - {5}){6};\n", name, axis_names[axis], i,
                          literal(f.lowest_temperature), literal(f.highest_temperature), literal(f.reference), times_power(f.temperature_shift),
                          f.words->prefix);
    text += fmt::format("  const int32_t {}_{} = {}imulab_{}_limit({}[{}], -{}, {}){}{};\n", name, axis_names[axis], in.sign[axis] < 0 ? "-" : "",
                        f.words->prefix, in.parameter, in.column[axis], f.in_limit, f.in_limit, times_power(f.in_shift), drift);
  }
  if (f.thermal && !f.changes && f.drift[0].largest == 0 && f.drift[1].largest == 0 && f.drift[2].largest == 0)
    text = "  (void)" + name + "_temperature;\n" + text;
  return text;
}

/// A sum of products of integers and variables.
std::string fixed_products(const FixedWords& w, const std::array<std::int64_t, 3>& k, const std::string& variable) {
  std::string sum;
  for (std::size_t j = 0; j < 3; ++j)
    if (k[j] != 0) sum += fmt::format("{}imulab_{}_product({}, {}_{})", sum.empty() ? "" : " + ", w.prefix, literal(k[j]), variable, axis_names[j]);
  return sum.empty() ? literal(std::int64_t{0}) : sum;
}

/// The change of the matrix with the temperature, and what of the force does not change.
std::string change_text(const FixedTriad& f, const std::string& name, const std::string& before, const std::string& out) {
  const FixedWords& w = *f.words;
  const auto shifted = [&w](const std::string& sum, int bits) { return fmt::format("(int32_t)imulab_{0}_shift({1}, {2})", w.prefix, sum, bits); };
  std::string text;
  for (std::size_t i = 0; i < 3; ++i) {
    const FixedChange& c = f.change[i];
    const std::string axis = axis_names[i], t = name + "_t" + axis;
    const auto times_t = [&](const std::string& x) { return shifted(fmt::format("imulab_{}_product({}, {})", w.prefix, x, t), w.v_bits); };
    std::string slope = shifted(fixed_products(w, c.first, before), c.shift);
    if (c.second != std::array<std::int64_t, 3>{}) slope += " + " + times_t(shifted(fixed_products(w, c.second, before), c.shift));
    text += fmt::format("  const int32_t {}_{} = {}_{} +\n      {}", out, axis, before, axis, times_t(slope));
    if (f.row[i].g_sensitivity != std::array<std::int64_t, 3>{})
      text += " + " + shifted(fixed_products(w, f.row[i].g_sensitivity, "f"), f.row[i].shift);
    text += ";\n";
  }
  return text;
}

std::string polynomial_text(const FixedTriad& f, const std::string& name, const std::string& result) {
  const std::string out = f.changes ? result + "0" : result;
  const FixedWords& w = *f.words;
  const auto power = [&w](const std::string& a, const std::string& b) {
    return fmt::format("(int32_t)imulab_{0}_shift(imulab_{0}_product({1}, {2}), {3})", w.prefix, a, b, w.power_bits);
  };
  std::string text;
  for (std::size_t i = 0; i < 3; ++i) {
    const FixedRow& r = f.row[i];
    const std::string axis = axis_names[i], v = name + "_" + axis;
    if (r.quadratic != 0 || r.cubic != 0) text += fmt::format("  const int32_t {}2 = {};\n", v, power(v, v));
    if (r.cubic != 0) text += fmt::format("  const int32_t {}3 = {};\n", v, power(v + "2", v));
    std::string sum = literal(r.offset);
    const auto add = [&](std::int64_t k, const std::string& x) {
      if (k != 0) sum += fmt::format(" + imulab_{}_product({}, {})", w.prefix, literal(k), x);
    };
    for (std::size_t j = 0; j < 3; ++j) add(r.matrix[j], name + "_" + axis_names[j]);
    add(r.quadratic, v + "2"), add(r.cubic, v + "3");
    for (std::size_t j = 0; j < 3 && !f.changes; ++j) add(r.g_sensitivity[j], std::string("f_") + axis_names[j]);
    text += fmt::format("  const int32_t {}_{} = (int32_t)imulab_{}_shift({}, {});\n", out, axis, w.prefix, sum, r.shift);
  }
  return f.changes ? text + change_text(f, name, out, result) : text;
}

/// Two figures, rounded up.
std::string at_most(double value) {
  const double unit = std::pow(10.0, std::floor(std::log10(value)) - 1);
  return fmt::format("{:.2g}", std::ceil(value / unit - 1e-9) * unit);
}

std::string reading_text(const FixedTriad& f, const Input& in) {
  const double range = std::ldexp(static_cast<double>(f.in_limit), -f.in_bits);
  if (in.counts && f.in_bits < 0) return fmt::format("counts over 2^{}, up to {:g} counts either way", -f.in_bits, range);
  if (in.counts) return fmt::format("counts, up to {:g} either way", range);
  return fmt::format("{} times 2^{}, up to {:g} {} either way", in.as.unit, f.in_bits, range, in.as.unit);
}

std::string temperature_text(const FixedTriad& f, const TriadModel& m) {
  if (!f.thermal) return "not read";
  const auto value = [&](std::int64_t t) { return std::ldexp(static_cast<double>(t), -f.temperature_bits); };
  return fmt::format("{} times 2^{}, from {:g} to {:g}", harmless(m.temperature->unit), f.temperature_bits, value(f.lowest_temperature),
                     value(f.highest_temperature));
}

std::string comment_text(const SensorModel& m, const FixedTriad& a, const FixedTriad& g, const Input& accel, const Input& gyro) {
  const FixedWords& w = *a.words;
  return fmt::format(
      "/* The same in integers: {} bits{}, sums of {}; no floating point.\n"
      " * In:  accelerometers: {}\n"
      " *      gyros: {}\n"
      " *      accelerometer temperatures: {}\n"
      " *      gyro temperatures: {}\n"
      " *      Beyond a range its end is taken.\n"
      " * Out: m/s^2 times 2^{}, rad/s times 2^{}.\n"
      " * Largest error within the ranges, against the exact model: {} m/s^2, {} rad/s. Right shifts of negative numbers must keep the sign, as\n"
      " * with every usual compiler; imulab_selftest_{} checks it. */\n",
      w.data_bits, w.data_bits == 16 ? " (Q15)" : "", 2 * w.data_bits, reading_text(a, accel), reading_text(g, gyro), temperature_text(a, m.accel),
      temperature_text(g, m.gyro), a.out_bits, g.out_bits, at_most(a.largest_error()), at_most(g.largest_error()), w.prefix);
}

std::string macros_text(const FixedTriad& a, const FixedTriad& g) {
  return fmt::format(
      "#include <stdint.h>\n\n"
      "#define IMULAB_{6}_ACCEL_BITS {0} /* a reading is an integer times 2^-bits of IMULAB_ACCEL_UNIT */\n"
      "#define IMULAB_{6}_GYRO_BITS {1}\n"
      "#define IMULAB_{6}_ACCEL_TEMPERATURE_BITS {2}\n"
      "#define IMULAB_{6}_GYRO_TEMPERATURE_BITS {3}\n"
      "#define IMULAB_{6}_FORCE_BITS {4} /* an output is an integer times 2^-bits m/s^2 */\n"
      "#define IMULAB_{6}_RATE_BITS {5}  /* rad/s */\n\n",
      a.in_bits, g.in_bits, a.temperature_bits, g.temperature_bits, a.out_bits, g.out_bits, a.words->data_bits == 16 ? "Q15" : "FIXED");
}

template <class Numbers>
std::string row_of_integers(const Numbers& numbers) {
  std::string text;
  for (const std::int64_t x : numbers) text += (text.empty() ? "" : ", ") + fmt::format("{}", x);
  return "      {" + text + "},\n";
}

constexpr const char* selftest =
    "/* 0 where the integers come out as they should: {0} samples, each output within the error above and one unit. Otherwise the place, from 1 on,\n"
    " * of the first that does not. */\n"
    "static inline int imulab_selftest_{5}(void) {{\n"
    "  static const {6} in[{0}][12] = {{\n{1}  }};\n"
    "  static const {6} expected[{0}][6] = {{\n{2}  }};\n"
    "  {6} out[6];\n"
    "  int i, k;\n"
    "  for (i = 0; i < {0}; ++i) {{\n"
    "    imulab_compensate_{5}(in[i], in[i] + 3, in[i] + 6, in[i] + 9, out, out + 3);\n"
    "    for (k = 0; k < 6; ++k) {{\n"
    "      const int32_t most = k < 3 ? {3} : {4}, difference = out[k] - expected[i][k];\n"
    "      if (difference > most || difference < -most) return 1 + 6 * i + k;\n"
    "    }}\n"
    "  }}\n"
    "  return 0;\n"
    "}}\n\n";

std::string fixed_selftest_text(const SensorModel& model, const FixedTriad& a, const FixedTriad& g, const Input& accel, const Input& gyro) {
  std::string in, expected;
  for (int i = 0; i < sample_count; ++i) {
    std::array<std::int64_t, 12> n;
    std::array<double, 12> x;
    for (int k = 0; k < 12; ++k) {
      const FixedTriad& f = k < 3 || (k >= 6 && k < 9) ? a : g;
      const TriadModel& m = k < 9 ? model.accel : model.gyro;
      const bool reading = k < 6;
      const int bits = reading ? f.in_bits : f.temperature_bits;
      const double value = reading     ? fraction(i, k) * static_cast<double>(f.in_limit)
                           : f.thermal ? std::ldexp(test_temperature(m, fraction(i, k)), bits)
                                       : 0;
      const auto at = static_cast<std::size_t>(k);
      n[at] = std::llround(value);
      x[at] = std::ldexp(static_cast<double>(n[at]), -bits);
    }
    const Motion motion = compensate(model, raw_sample(model, accel, gyro, x));
    std::array<std::int64_t, 6> out;
    for (std::size_t k = 0; k < 3; ++k) {
      out[k] = std::llround(std::ldexp(motion.force[static_cast<Eigen::Index>(k)], a.out_bits));
      out[3 + k] = std::llround(std::ldexp(motion.rate[static_cast<Eigen::Index>(k)], g.out_bits));
    }
    in += row_of_integers(n), expected += row_of_integers(out);
  }
  const auto most = [](const FixedTriad& f) { return static_cast<std::int64_t>(std::ceil(std::ldexp(f.largest_error(), f.out_bits))) + 1; };
  return fmt::format(selftest, sample_count, in, expected, most(a), most(g), a.words->prefix, a.words->data);
}

}  // namespace

std::string fixed_text(const SensorModel& model, const Input& accel, const Input& gyro, const CHeaderOptions& options, const FixedWords& w) {
  const FixedTriad a = fixed_triad(model, accel, options.accel_range, nullptr, w), g = fixed_triad(model, gyro, options.gyro_range, &a, w);
  std::string text = macros_text(a, g) + fmt::format(helpers, w.prefix, w.sum) + comment_text(model, a, g, accel, gyro);
  text += fmt::format(
      "static inline void imulab_compensate_{2}(const {3} {0}[3], const {3} {1}[3], const {3} accel_temperature[3],\n"
      "                                           const {3} gyro_temperature[3], {3} force[3], {3} rate[3]) {{\n",
      accel.parameter, gyro.parameter, w.prefix, w.data);
  text += raw_text(a, accel) + polynomial_text(a, "accel", "f") + raw_text(g, gyro) + polynomial_text(g, "gyro", "w");
  // 16-bit outputs may be at the end of their range, less the error.
  const char* const out = w.data_bits == 16 ? "(int16_t)imulab_q15_limit({}_{}, -32767, 32767)" : "{}_{}";
  for (int i = 0; i < 3; ++i) {
    const char* const axis = axis_names[static_cast<std::size_t>(i)];
    text += fmt::format("  force[{0}] = {1};\n  rate[{0}] = {2};\n", i, fmt::format(fmt::runtime(out), "f", axis),
                        fmt::format(fmt::runtime(out), "w", axis));
  }
  return text + "}\n\n" + fixed_selftest_text(model, a, g, accel, gyro);
}

}  // namespace imulab::firmware
