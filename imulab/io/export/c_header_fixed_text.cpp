// imulab_compensate_fixed: the numbers of FixedTriad as C.
#include "imulab/io/export/c_header_fixed.hpp"
#include "imulab/io/export/c_header_parts.hpp"
#include "imulab/io/export/c_header_samples.hpp"
#include "imulab/io/export/c_header_text.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace imulab::firmware {

namespace {

constexpr const char* helpers =
    "static inline int32_t imulab_fixed_limit(int32_t x, int32_t least, int32_t most) { return x > most ? most : x < least ? least : x; }\n"
    "static inline int64_t imulab_fixed_shift(int64_t x, int bits) { return (x + ((int64_t)1 << (bits - 1))) >> bits; }\n"
    "static inline int64_t imulab_fixed_product(int32_t a, int32_t b) { return (int64_t)a * b; }\n\n";

std::string times_power(int bits) { return bits == 0 ? "" : fmt::format(" * {}", std::int64_t{1} << bits); }

std::string drift_text(const FixedTriad& f, const std::string& name, int axis) {
  const FixedDrift& d = f.drift[static_cast<std::size_t>(axis)];
  if (d.k0 == 0 && d.k1 == 0 && d.k2 == 0) return {};
  const std::string t = fmt::format("{}_t{}", name, axis_names[static_cast<std::size_t>(axis)]);
  std::string slope = literal(d.k1);
  if (d.k2 != 0) slope = fmt::format("({} + (int32_t)imulab_fixed_shift(imulab_fixed_product({}, {}), 30))", slope, literal(d.k2), t);
  return fmt::format(" -\n      (int32_t)imulab_fixed_shift({} + imulab_fixed_product({}, {}), {})", literal(d.k0), slope, t, 30 + d.shift);
}

std::string raw_text(const FixedTriad& f, const Input& in) {
  const std::string name = in.triad_name();
  std::string text = f.thermal ? "" : fmt::format("  (void){}_temperature;\n", name);
  for (int i = 0; i < 3; ++i) {
    const auto axis = static_cast<std::size_t>(i);
    const std::string drift = drift_text(f, name, i);
    if (!drift.empty())
      text += fmt::format("  const int32_t {0}_t{1} = (imulab_fixed_limit({0}_temperature[{2}], {3}, {4}) - {5}){6};\n", name, axis_names[axis], i,
                          literal(f.reference - f.temperature_limit), literal(f.reference + f.temperature_limit), literal(f.reference),
                          times_power(f.temperature_shift));
    text += fmt::format("  const int32_t {}_{} = {}imulab_fixed_limit({}[{}], -{}, {}){}{};\n", name, axis_names[axis], in.sign[axis] < 0 ? "-" : "",
                        in.parameter, in.column[axis], f.in_limit, f.in_limit, times_power(f.in_shift), drift);
  }
  if (f.thermal && f.drift[0].largest == 0 && f.drift[1].largest == 0 && f.drift[2].largest == 0) text = "  (void)" + name + "_temperature;\n" + text;
  return text;
}

std::string polynomial_text(const FixedTriad& f, const std::string& name, const std::string& out) {
  std::string text;
  for (std::size_t i = 0; i < 3; ++i) {
    const FixedRow& r = f.row[i];
    const std::string axis = axis_names[i], v = name + "_" + axis;
    if (r.quadratic != 0 || r.cubic != 0)
      text += fmt::format("  const int32_t {0}2 = (int32_t)imulab_fixed_shift(imulab_fixed_product({0}, {0}), 31);\n", v);
    if (r.cubic != 0) text += fmt::format("  const int32_t {0}3 = (int32_t)imulab_fixed_shift(imulab_fixed_product({0}2, {0}), 31);\n", v);
    std::string sum = literal(r.offset);
    const auto add = [&sum](std::int64_t k, const std::string& x) {
      if (k != 0) sum += fmt::format(" + imulab_fixed_product({}, {})", literal(k), x);
    };
    for (std::size_t j = 0; j < 3; ++j) add(r.matrix[j], name + "_" + axis_names[j]);
    add(r.quadratic, v + "2"), add(r.cubic, v + "3");
    for (std::size_t j = 0; j < 3; ++j) add(r.g_sensitivity[j], std::string("f_") + axis_names[j]);
    text += fmt::format("  const int32_t {}_{} = (int32_t)imulab_fixed_shift({}, {});\n", out, axis, sum, r.shift);
  }
  return text;
}

/// Two figures, rounded up.
std::string at_most(double value) {
  const double unit = std::pow(10.0, std::floor(std::log10(value)) - 1);
  return fmt::format("{:.2g}", std::ceil(value / unit - 1e-9) * unit);
}

std::string reading_text(const FixedTriad& f, const Input& in) {
  const double range = std::ldexp(static_cast<double>(f.in_limit), -f.in_bits);
  if (in.counts) return fmt::format("counts, up to {:g} either way", range);
  return fmt::format("{} times 2^{}, up to {:g} {} either way", in.as.unit, f.in_bits, range, in.as.unit);
}

std::string temperature_text(const FixedTriad& f, const TriadModel& m) {
  if (!f.thermal) return "not read";
  const double distance = std::ldexp(static_cast<double>(f.temperature_limit), -f.temperature_bits);
  return fmt::format("{} times 2^{}, taken as at most {:g} from {:g}", harmless(m.temperature->unit), f.temperature_bits, distance,
                     m.temperature->reference);
}

std::string comment_text(const SensorModel& m, const FixedTriad& a, const FixedTriad& g, const Input& accel, const Input& gyro) {
  return fmt::format(
      "/* The same in integers: 32 bits, sums of 64; no floating point.\n"
      " * In:  accelerometers: {}\n"
      " *      gyros: {}\n"
      " *      accelerometer temperatures: {}\n"
      " *      gyro temperatures: {}\n"
      " *      Beyond a range its end is taken.\n"
      " * Out: m/s^2 times 2^{}, rad/s times 2^{}.\n"
      " * Largest error within the ranges, against the exact model: {} m/s^2, {} rad/s. Right shifts of negative numbers must keep the sign, as\n"
      " * with every usual compiler; imulab_selftest_fixed checks it. */\n",
      reading_text(a, accel), reading_text(g, gyro), temperature_text(a, m.accel), temperature_text(g, m.gyro), a.out_bits, g.out_bits,
      at_most(a.largest_error()), at_most(g.largest_error()));
}

std::string macros_text(const FixedTriad& a, const FixedTriad& g) {
  return fmt::format(
      "#include <stdint.h>\n\n"
      "#define IMULAB_FIXED_ACCEL_BITS {} /* a reading is an integer times 2^-bits of IMULAB_ACCEL_UNIT */\n"
      "#define IMULAB_FIXED_GYRO_BITS {}\n"
      "#define IMULAB_FIXED_ACCEL_TEMPERATURE_BITS {}\n"
      "#define IMULAB_FIXED_GYRO_TEMPERATURE_BITS {}\n"
      "#define IMULAB_FIXED_FORCE_BITS {} /* an output is an integer times 2^-bits m/s^2 */\n"
      "#define IMULAB_FIXED_RATE_BITS {}  /* rad/s */\n\n",
      a.in_bits, g.in_bits, a.temperature_bits, g.temperature_bits, a.out_bits, g.out_bits);
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
    "static inline int imulab_selftest_fixed(void) {{\n"
    "  static const int32_t in[{0}][12] = {{\n{1}  }};\n"
    "  static const int32_t expected[{0}][6] = {{\n{2}  }};\n"
    "  int32_t out[6];\n"
    "  int i, k;\n"
    "  for (i = 0; i < {0}; ++i) {{\n"
    "    imulab_compensate_fixed(in[i], in[i] + 3, in[i] + 6, in[i] + 9, out, out + 3);\n"
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
  return fmt::format(selftest, sample_count, in, expected, most(a), most(g));
}

}  // namespace

std::string fixed_text(const SensorModel& model, const Input& accel, const Input& gyro, const CHeaderOptions& options) {
  const FixedTriad a = fixed_triad(model, accel, options.accel_range, nullptr), g = fixed_triad(model, gyro, options.gyro_range, &a);
  std::string text = macros_text(a, g) + helpers + comment_text(model, a, g, accel, gyro);
  text += fmt::format(
      "static inline void imulab_compensate_fixed(const int32_t {}[3], const int32_t {}[3], const int32_t accel_temperature[3],\n"
      "                                           const int32_t gyro_temperature[3], int32_t force[3], int32_t rate[3]) {{\n",
      accel.parameter, gyro.parameter);
  text += raw_text(a, accel) + polynomial_text(a, "accel", "f") + raw_text(g, gyro) + polynomial_text(g, "gyro", "w");
  for (int i = 0; i < 3; ++i) text += fmt::format("  force[{0}] = f_{1};\n  rate[{0}] = w_{1};\n", i, axis_names[static_cast<std::size_t>(i)]);
  return text + "}\n\n" + fixed_selftest_text(model, a, g, accel, gyro);
}

}  // namespace imulab::firmware
