#include "imulab/export/c_header_fixed.hpp"

#include "imulab/error.hpp"
#include "imulab/units.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace imulab::firmware {

namespace {

constexpr double most_counts = 1 << 30;

double largest_v(const FixedTriad& f) { return std::ldexp(1.0, f.words->v_bits); }

/// The largest k with |value| 2^k <= limit.
int bits_below(double value, double limit) {
  int exponent = 0;
  std::frexp(limit / value, &exponent);  // limit / value = m 2^exponent, 0.5 <= m < 1
  return exponent - 1;
}

std::int64_t nearest(double value) { return std::llround(value); }

/// Counts of 16 bits, unless the calibration's scale makes that less than sensors measure: 1.5 g, 50 deg/s. Otherwise 16 g, 2000 deg/s.
double usual_range(const TriadModel& m, const Input& in) {
  const bool accel = in.triad == Triad::accel;
  const double scale = in.as.unit == "count" ? m.matrix.cwiseAbs().maxCoeff() * in.factor : in.factor, bits16 = 32768;
  const double physical = scale > 0 ? (accel ? 16 * unit::g : 2000 * unit::deg) / scale : bits16;
  if (!in.counts) return physical;
  return bits16 * scale >= (accel ? 1.5 * unit::g : 50 * unit::deg) ? bits16 : std::min(std::ceil(physical), most_counts);
}

void set_range(FixedTriad& f, const TriadModel& m, const Input& in, double range) {
  if (range == 0) range = usual_range(m, in);
  if (!(range > 0 && std::isfinite(range) && range <= (in.counts ? most_counts : 1e12)))
    throw Error(fmt::format("a range of {:g} of the {}' readings; expected one above 0 that 30 bits hold", range, in.sensors()));
  f.in_bits = bits_below(range, std::min(largest_v(f), f.words->largest_temperature));
  if (in.counts) f.in_bits = range <= largest_v(f) ? 0 : f.in_bits;
  f.in_limit = std::max<std::int64_t>(nearest(std::ldexp(range, f.in_bits)), 1);
  f.in_shift = bits_below(static_cast<double>(f.in_limit), largest_v(f));
  f.v_unit = std::ldexp(in.factor, -f.in_bits - f.in_shift);
}

/// Formats of the thermal readings: up to the ends of the calibrated range, or 100 from the reference where that is not stated. Temperatures have
/// half as much room again.
void set_temperature(FixedTriad& f, const TriadModel& m) {
  const ThermalReading& t = *m.temperature;
  const std::array<double, 2> range = t.range[1] > t.range[0] ? t.range : std::array{t.reference - 100, t.reference + 100};
  const double far = std::max(std::abs(range[0] - t.reference), std::abs(range[1] - t.reference));
  if (!(std::abs(t.reference) + 1.5 * far < 1e9))
    throw Error(fmt::format("temperatures about {:g}, up to {:g} from it; expected less than 1e9 for integers", t.reference, 1.5 * far));
  f.temperature_bits = std::min(16, bits_below(std::abs(t.reference) + 1.5 * far, f.words->largest_temperature));
  const auto as_integer = [&](double reading) { return nearest(std::ldexp(reading, f.temperature_bits)); };
  f.reference = as_integer(t.reference);
  f.lowest_temperature = as_integer(range[0]), f.highest_temperature = as_integer(range[1]);
  f.temperature_limit = std::max({f.highest_temperature - f.reference, f.reference - f.lowest_temperature, std::int64_t{1}});
  f.temperature_shift = bits_below(static_cast<double>(f.temperature_limit), largest_v(f));
  const auto rounded_by = [&](std::int64_t integer, double reading) {
    return std::ldexp(static_cast<double>(integer), -f.temperature_bits) - reading;
  };
  f.moved = rounded_by(f.reference, t.reference);
  f.end_error = std::max(std::abs(rounded_by(f.lowest_temperature, range[0])), std::abs(rounded_by(f.highest_temperature, range[1])));
}

/// The thermal reading [its unit] at t = 1, 2^v_bits.
double full_tau(const FixedTriad& f) { return std::ldexp(largest_v(f), -f.temperature_shift - f.temperature_bits); }
/// The largest |t|, at most 1.
double largest_t(const FixedTriad& f) { return std::ldexp(static_cast<double>(f.temperature_limit), f.temperature_shift) / largest_v(f); }

/// c1 tau + c2 tau^2 + c3 tau^3 in units of v, as k0 + (k1 + (k2 + k3 t) t) t with t = 1 at 2^v_bits.
FixedDrift drift_of(const FixedTriad& f, const TriadModel& m, int axis) {
  FixedDrift d;
  const double full = full_tau(f), t = largest_t(f), moved = f.moved;  // tau = tau of the integers + moved
  const double c1 = m.thermal(axis, 1), c2 = m.thermal(axis, 2), c3 = m.thermal(axis, 3), unit = full / f.v_unit;
  const double e0 = (c1 + (c2 + c3 * moved) * moved) * moved / f.v_unit, e1 = (c1 + (2 * c2 + 3 * c3 * moved) * moved) * unit;
  const double e2 = (c2 + 3 * c3 * moved) * full * unit, e3 = c3 * full * full * unit;
  const double size = std::abs(e1) + std::abs(e2) + std::abs(e3);
  const double at_end = (std::abs(e1) + 2 * std::abs(e2) * t + 3 * std::abs(e3) * t * t) / full * f.end_error;
  if (size == 0 && e0 == 0) return d;
  d.largest = std::abs(e0) + (std::abs(e1) + (std::abs(e2) + std::abs(e3) * t) * t) * t + 2;
  const int bits = f.words->v_bits;
  if (!(std::ldexp(static_cast<double>(f.in_limit), f.in_shift) + d.largest < f.words->largest_raw))
    throw Error(
        fmt::format("the thermal drift is larger than the range of the readings leaves ({} bits); expected a larger range", f.words->data_bits));
  d.shift = std::min(bits, bits_below(std::max(size, 1e-9), largest_v(f)));
  const auto scaled = [&](double e) { return nearest(std::ldexp(e, d.shift)); };
  d.k0 = nearest(std::ldexp(e0, d.shift + bits)), d.k1 = scaled(e1), d.k2 = scaled(e2), d.k3 = scaled(e3);
  const auto missed = [&](std::int64_t k, double e) { return std::abs(std::ldexp(static_cast<double>(k), -d.shift) - e); };
  const double products = (d.k2 != 0 || d.k3 != 0 ? t : 0) + (d.k3 != 0 ? t * t : 0);  // each is rounded
  d.error = 0.5 + at_end + (missed(d.k1, e1) + (missed(d.k2, e2) + missed(d.k3, e3) * t) * t) * t + std::ldexp(0.5 * products, -d.shift) +
            std::ldexp(0.5, -d.shift - bits);
  return d;
}

/// A row's coefficients in units of the output, of the integers that they multiply, and those integers' largest values.
struct ExactRow {
  double offset;
  std::array<double, 8> coefficient{}, largest{}, error{};  // matrix, g-sensitivity, quadratic, cubic; error: of the integers
};

constexpr std::size_t quadratic_at = 6, cubic_at = 7;

/// The largest s with which the coefficients fit 31 bits, and their sum its word.
int shift_of(const ExactRow& exact, const FixedWords& words) {
  double sum = std::abs(exact.offset) + 1, largest = 1e-30;
  for (std::size_t k = 0; k < 8; ++k) {
    sum += std::abs(exact.coefficient[k]) * exact.largest[k];
    largest = std::max(largest, std::abs(exact.coefficient[k]));
  }
  return std::clamp(std::min(bits_below(largest, 2147483000.0), bits_below(sum, words.largest_sum)), 1, words.most_shift);
}

FixedRow rounded(const ExactRow& exact, const FixedWords& words, double& error) {
  FixedRow row;
  row.shift = shift_of(exact, words);
  const auto scaled = [&](double x) { return nearest(std::ldexp(x, row.shift)); };
  std::array<std::int64_t, 8> k;
  error = 0.5 + std::ldexp(0.5, -row.shift);  // the result's rounding, the offset's
  for (std::size_t i = 0; i < 8; ++i) {
    k[i] = scaled(exact.coefficient[i]);
    error += std::abs(std::ldexp(static_cast<double>(k[i]), -row.shift) - exact.coefficient[i]) * exact.largest[i] +
             std::abs(exact.coefficient[i]) * exact.error[i];
  }
  row.offset = scaled(exact.offset);
  for (std::size_t j = 0; j < 3; ++j) row.matrix[j] = k[j], row.g_sensitivity[j] = k[3 + j];
  row.quadratic = k[quadratic_at], row.cubic = k[cubic_at];
  return row;
}

ExactRow exact_row(const FixedTriad& f, const TriadModel& m, int i) {
  ExactRow exact;
  const double out = std::ldexp(1.0, f.out_bits), u = f.v_unit;
  exact.offset = m.offset[i] * out;
  const auto largest = [&](std::size_t j) { return std::ldexp(static_cast<double>(f.in_limit), f.in_shift) + f.drift[j].largest; };
  for (std::size_t j = 0; j < 3; ++j) {
    exact.coefficient[j] = m.matrix(i, static_cast<Eigen::Index>(j)) * u * out;
    exact.largest[j] = largest(j), exact.error[j] = f.drift[j].error;
  }
  const auto axis = static_cast<std::size_t>(i);
  const double v = largest(axis), half = std::ldexp(1.0, f.words->power_bits), ev = f.drift[axis].error;
  exact.coefficient[quadratic_at] = m.quadratic[i] * u * u * half * out;
  exact.largest[quadratic_at] = v * v / half + 1, exact.error[quadratic_at] = 0.5 + 2 * v / half * ev;
  exact.coefficient[cubic_at] = m.cubic[i] * u * u * u * half * half * out;
  exact.largest[cubic_at] = v * v / half * v / half + 2, exact.error[cubic_at] = 0.5 + 0.5 * v / half + 3 * v / half * v / half * ev;
  return exact;
}

/// The largest sum of a row of |M1 tau + M2 tau^2|.
double largest_change(const FixedTriad& f, const TriadModel& m, int row) {
  const double tau = largest_t(f) * full_tau(f);
  return (m.matrix_thermal1.row(row).cwiseAbs().sum() + tau * m.matrix_thermal2.row(row).cwiseAbs().sum()) * tau;
}

/// A row of M1 and M2 at t = 1, and the error that it adds, in units of the output.
FixedChange change_of(const FixedTriad& f, const TriadModel& m, int row, double& error) {
  FixedChange out;
  const double full = full_tau(f), t = largest_t(f), largest_out = std::ldexp(f.full_scale, f.out_bits);
  const Vector3d first = full * m.matrix_thermal1.row(row), second = full * full * m.matrix_thermal2.row(row);
  const double most = std::max({first.cwiseAbs().maxCoeff(), second.cwiseAbs().maxCoeff(), 1e-12});
  const double sum = std::max({first.cwiseAbs().sum(), second.cwiseAbs().sum(), 1e-12}) * largest_out;
  out.shift = std::clamp(std::min(bits_below(most, largest_v(f)), bits_below(sum, f.words->largest_sum)), 1, f.words->most_shift);
  double missed = 0;
  const auto scaled = [&](double x, double at) {
    const std::int64_t k = nearest(std::ldexp(x, out.shift));
    missed += at * std::abs(std::ldexp(static_cast<double>(k), -out.shift) - x);
    return k;
  };
  for (std::size_t j = 0; j < 3; ++j) {
    const auto column = static_cast<Eigen::Index>(j);
    out.first[j] = scaled(first[column], t), out.second[j] = scaled(second[column], t * t);
  }
  const double steepest = (first.cwiseAbs().sum() + 2 * t * second.cwiseAbs().sum()) / full;
  const double roundings = 1 + t + (second.isZero(0) ? 0 : t * (1 + t)) + (f.row[static_cast<std::size_t>(row)].g_sensitivity[0] != 0 ? 1 : 0);
  error += 0.5 * roundings + largest_change(f, m, row) * error + (missed + steepest * (f.end_error + std::abs(f.moved))) * largest_out;
  return out;
}

/// The largest output of the axes, SI.
double full_scale(const FixedTriad& f, const SensorModel& model, const TriadModel& m, const FixedTriad* force) {
  double most = 0;
  for (int i = 0; i < 3; ++i) {
    const ExactRow exact = exact_row(f, m, i);
    double sum = std::abs(exact.offset);
    for (std::size_t k = 0; k < 8; ++k) sum += std::abs(exact.coefficient[k]) * exact.largest[k];
    sum = std::ldexp(sum, -f.out_bits) * (f.changes ? 1 + largest_change(f, m, i) : 1);
    if (force != nullptr) sum += model.g_sensitivity.row(i).cwiseAbs().sum() * force->full_scale;
    most = std::max(most, sum);
  }
  return most;
}

}  // namespace

FixedTriad fixed_triad(const SensorModel& model, const Input& in, double range, const FixedTriad* force, const FixedWords& words) {
  const TriadModel& m = triad_model(model, in.triad);
  FixedTriad f;
  f.words = &words;
  set_range(f, m, in, range);
  f.thermal = m.varies(), f.changes = m.matrix_varies();
  if (f.thermal) {
    if (!m.temperature) throw Error("the calibration has thermal terms, but no reference temperature");
    set_temperature(f, m);
    for (int axis = 0; axis < 3; ++axis) f.drift[static_cast<std::size_t>(axis)] = drift_of(f, m, axis);
  }
  f.full_scale = full_scale(f, model, m, force);
  if (!(f.full_scale > 1e-6 && f.full_scale < 1e6))
    throw Error(fmt::format("readings of the {} up to the range give up to {:g} {}; expected 1e-6 to 1e6", in.sensors(), f.full_scale,
                            in.triad == Triad::accel ? "m/s^2" : "rad/s"));
  if (in.triad == Triad::accel && f.full_scale < 1.2 * unit::g)
    throw Error(
        fmt::format("readings of the accelerometers up to the range give up to {:.3g} m/s^2, no room for gravity; expected the largest reading of "
                    "the firmware, in counts where it has them",
                    f.full_scale));
  f.out_bits = bits_below(f.full_scale, words.largest_out);
  for (int i = 0; i < 3; ++i) {
    const auto axis = static_cast<std::size_t>(i);
    ExactRow exact = exact_row(f, m, i);
    for (std::size_t j = 0; force != nullptr && j < 3; ++j) {
      exact.coefficient[3 + j] = std::ldexp(model.g_sensitivity(i, static_cast<Eigen::Index>(j)), f.out_bits - force->out_bits);
      exact.largest[3 + j] = std::ldexp(force->full_scale, force->out_bits) + 1;
      exact.error[3 + j] = std::ldexp(force->error[j], force->out_bits);
    }
    f.row[axis] = rounded(exact, words, f.error[axis]);
    if (f.changes) f.change[axis] = change_of(f, m, i, f.error[axis]);
    f.error[axis] = std::ldexp(f.error[axis], -f.out_bits);
  }
  return f;
}

}  // namespace imulab::firmware
